"""Landmarks of one surface from the files of other programs.

``.vts`` (a vertex number and its position per line), ``.pp`` (MeshLab's picked points),
``.mrk.json`` and ``.fcsv`` (3D Slicer's markups). Positions are taken as they stand in the file, so
the mesh must be in the same coordinate system (3D Slicer writes both as LPS unless told otherwise).
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from henkei.errors import InvalidFile, InvalidInput, some
from henkei.mesh import Floats

Named = list[tuple[str, list[float]]]
Position = Any


def read_landmark_points(path_a: str | os.PathLike[str], path_b: str | os.PathLike[str]) -> Floats:
    """Corresponding points ``(k, 2, 3)`` of two files, one for each surface.

    They are paired by name if both files have the same names, else in order.

    Raises
    ------
    InvalidFile : a file is missing, damaged or of another format; the message says the line.
    InvalidInput : the files have neither the same names nor equally many points.
    """
    a, b = _read(Path(path_a)), _read(Path(path_b))
    names_a, names_b = ([name for name, _ in side] for side in (a, b))
    unique = len(set(names_a)) == len(names_a) == len(names_b)
    if unique and set(names_a) == set(names_b):
        by_name = dict(b)
        return np.array([[point, by_name[name]] for name, point in a])
    if len(a) != len(b):
        odd = sorted(set(names_a) ^ set(names_b))
        raise InvalidInput(
            f"{path_a} has {len(a)} landmarks and {path_b} has {len(b)}, and their names do not "
            f"tell which belong together: {some(odd)}"
        )
    return np.array([[p, q] for (_, p), (_, q) in zip(a, b, strict=True)])


def _read(path: Path) -> Named:
    endings: dict[str, Callable[[Path, str], Named]] = {
        ".vts": _from_vts,
        ".pp": _from_meshlab,
        ".mrk.json": _from_slicer,
        ".fcsv": _from_fcsv,
    }
    decode = next((d for e, d in endings.items() if path.name.lower().endswith(e)), None)
    if decode is None:
        raise InvalidFile(
            f"{path}: not a landmark file by its name; known are {', '.join(endings)}"
        )
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InvalidFile(f"{path}: there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidFile(f"{path}: cannot be read as text ({error})") from None
    landmarks = decode(path, text)
    if not landmarks:
        raise InvalidFile(f"{path}: holds no landmarks")
    return landmarks


def _from_vts(path: Path, text: str) -> Named:
    found: Named = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip():
            where = f"line {number}"
            found.append((str(len(found)), _position(path, where, line.split()[1:])))
    return found


def _from_meshlab(path: Path, text: str) -> Named:
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        line, column = error.position
        raise InvalidFile(f"{path}: not XML, line {line}, column {column + 1}") from None
    points = [p for p in root.iter("point") if p.get("active", "1") != "0"]
    return [
        (p.get("name", str(i)), _position(path, f"point {i}", [p.get(axis) for axis in "xyz"]))
        for i, p in enumerate(points)
    ]


def _from_slicer(path: Path, text: str) -> Named:
    try:
        lists = json.loads(text)["markups"]
        points = [point for markups in lists for point in markups["controlPoints"]]
        rows = [(str(p.get("label", i)), p["position"], p) for i, p in enumerate(points)]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InvalidFile(f"{path}: not a file of 3D Slicer's markups") from None
    return [
        (name, _position(path, f"control point {i}", position))
        for i, (name, position, point) in enumerate(rows)
        if point.get("positionStatus", "defined") == "defined"
    ]


def _from_fcsv(path: Path, text: str) -> Named:
    found: Named = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip() and not line.startswith("#"):
            cells = line.split(",")
            name = cells[11] if len(cells) > 11 else str(len(found))
            found.append((name, _position(path, f"line {number}", cells[1:4])))
    return found


def _position(path: Path, where: str, values: Position) -> list[float]:
    try:
        position = [float(value) for value in values]
    except (TypeError, ValueError):
        position = []
    if len(position) != 3 or not np.isfinite(position).all():
        raise InvalidFile(f"{path}: {where} has no position of three finite numbers")
    return position
