"""Files of corresponding vertices, for a person to write and edit.

A file is JSON: ``[[12, 40], [77, 3], [80, 9]]``, or ``{"pairs": [...], "landmarks": [...]}`` with
pairs on the boundaries and inside. Each pair is a vertex of a and one of b (counted from 0), or a
point ``[x, y, z]`` near a vertex of a and one near a vertex of b.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.whole import whole
from henkei.topology import Ints

LARGEST = 2**31
SHAPE = "a pair is [i, j] (vertices of a and b) or [[x, y, z], [x, y, z]] (points)"


def read_pairs(
    path: str | os.PathLike[str], kind: Literal["pairs", "landmarks"] = "pairs"
) -> NDArray[Any]:
    """The pairs in a file: vertex indices ``(k, 2)`` int64, or points ``(k, 2, 3)`` float64.

    Parameters
    ----------
    path : the file.
    kind : which list to take of a file that names them.

    Raises
    ------
    InvalidFile : the file is missing, not JSON, or a pair is not one; the message says the line.
    """
    file = Path(path)
    try:
        text = file.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except UnicodeDecodeError:
        raise InvalidFile(f"{file}: not a text file; {SHAPE}, in JSON") from None
    except (OSError, ValueError) as error:
        raise InvalidFile(f"{file}: cannot be read ({error})") from None
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise InvalidFile(
            f"{file}: not JSON, line {error.lineno}, column {error.colno}: {error.msg}"
        ) from None
    except RecursionError:
        raise InvalidFile(f"{file}: nested too deeply to be pairs; {SHAPE}") from None
    pairs = content.get(kind) if isinstance(content, dict) else content
    if not isinstance(pairs, list):
        raise InvalidFile(f'{file}: holds no {kind}; write [[i, j], ...] or {{"{kind}": [...]}}')
    if not pairs:
        raise InvalidFile(f"{file}: the list of {kind} is empty")
    kinds = [_kind(pair) for pair in pairs]
    for number, of in enumerate(kinds):
        if not of or of != kinds[0]:
            reason = SHAPE if not of else f"the pairs before are {kinds[0]}, this is {of}"
            raise InvalidFile(
                f"{file}: line {_line(text, number, kind)}: pair {number} (counted from 0) is "
                f"{_short(pairs[number])}; {reason}"
            )
    return np.array(pairs, dtype=np.int64 if kinds[0] == "vertices" else np.float64)


def holds(path: str | os.PathLike[str], kind: Literal["pairs", "landmarks"]) -> bool:
    """Whether a file names a list of this kind, whatever else is wrong with it."""
    try:
        content = json.loads(Path(path).read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and kind in content


def write_pairs(path: str | os.PathLike[str], pairs: Ints, landmarks: Ints | None = None) -> None:
    """Write vertex pairs ``(k, 2)``, one a line, as :func:`read_pairs` reads them.

    Raises
    ------
    InvalidInput : the file cannot be written.
    """
    lists = [("pairs", pairs)]
    if landmarks is not None and len(landmarks):
        lists.append(("landmarks", landmarks))
    parts = [f'"{name}": [\n{_rows(values)}\n]' for name, values in lists]
    with whole(path, "w") as stream:
        stream.write("{" + ", ".join(parts) + "}\n")


def _rows(pairs: Ints) -> str:
    return ",\n".join(f"  [{i}, {j}]" for i, j in pairs.tolist())


def _kind(pair: Any) -> str:
    """What a pair is of, or nothing where it is none."""
    if not isinstance(pair, list) or len(pair) != 2:
        return ""
    if all(type(item) is int and abs(item) < LARGEST for item in pair):
        return "vertices"
    points = all(
        isinstance(point, list)
        and len(point) == 3
        and all(type(x) is float or (type(x) is int and abs(x) < LARGEST) for x in point)
        for point in pair
    )
    return "points" if points else ""


def _line(text: str, number: int, kind: str) -> int:
    """The line, from 1, on which an entry of a list starts."""
    named = re.search(rf'"{kind}"\s*:\s*\[', text)
    place = named.end() if text.lstrip().startswith("{") and named else text.index("[") + 1
    decoder, between = json.JSONDecoder(), re.compile(r"[\s,]*")
    for _ in range(number + 1):
        gap = between.match(text, place)
        start = gap.end() if gap else place
        place = decoder.raw_decode(text, start)[1]
    return text.count("\n", 0, start) + 1


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."
