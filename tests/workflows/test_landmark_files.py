"""Landmark files of other programs: each format, pairing, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

import henkei as hk
from data import real
from henkei.errors import InvalidFile, InvalidInput
from henkei.workflows.landmark_files import read_landmark_points

POINTS = {"nose": [0.5, 1, 2], "chin": [-1, 0.25, 3], "ear": [4, 5, -6]}


def vts(names):
    return "\n".join(f" {i} {' '.join(map(str, POINTS[n]))}" for i, n in enumerate(names)) + "\n"


def meshlab(names):
    rows = "".join(
        f'<point x="{x}" y="{y}" z="{z}" active="1" name="{n}"/>'
        for n in names
        for x, y, z in [POINTS[n]]
    )
    return f"<!DOCTYPE PickedPoints>\n<PickedPoints>{rows}</PickedPoints>\n"


def slicer(names):
    points = [{"label": n, "position": POINTS[n], "positionStatus": "defined"} for n in names]
    points.append({"label": "later", "position": [0, 0, 0], "positionStatus": "undefined"})
    return json.dumps({"markups": [{"coordinateSystem": "LPS", "controlPoints": points}]})


def fcsv(names):
    head = "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
    rows = [f"{i},{','.join(map(str, POINTS[n]))},0,0,0,1,1,1,0,{n},," for i, n in enumerate(names)]
    return head + "\n".join(rows) + "\n"


WRITERS = {"a.vts": vts, "a.pp": meshlab, "a.mrk.json": slicer, "a.fcsv": fcsv}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("other", WRITERS)
def test_formats_pair_by_name_or_order(tmp_path, name, other):
    one, two = tmp_path / name, tmp_path / f"b{other[1:]}"
    one.write_text(WRITERS[name](["nose", "chin", "ear"]))
    two.write_text(WRITERS[other](["ear", "nose", "chin"]))
    pairs = read_landmark_points(one, two)
    assert pairs[:, 0].tolist() == [POINTS[n] for n in ("nose", "chin", "ear")]
    by_name = "vts" not in name + other
    order = ("nose", "chin", "ear") if by_name else ("ear", "nose", "chin")
    assert pairs[:, 1].tolist() == [POINTS[n] for n in order]


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.vts", "1 2 3 4\n5 6 7\n", "line 2 has no position"),
        ("a.vts", "1 2 3 nan\n", "line 1 has no position"),
        ("a.vts", "\n", "holds no landmarks"),
        ("a.pp", "<a><b></a>", "not XML, line 1"),
        ("a.pp", '<p><point x="1" y="2"/></p>', "point 0 has no position"),
        ("a.mrk.json", "[]", "not a file of 3D Slicer"),
        (
            "a.mrk.json",
            '{"markups": [{"controlPoints": [{"position": [1, 2]}]}]}',
            "control point 0",
        ),
        ("a.fcsv", "# only\nvtk,1,2\n", "line 2 has no position"),
        ("a.txt", "1 2 3", "not a landmark file by its name"),
    ],
)
def test_each_damage_is_named(tmp_path, name, text, says):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InvalidFile, match=says):
        read_landmark_points(path, path)


def test_missing_binary_and_unequal_files(tmp_path):
    with pytest.raises(InvalidFile, match="no such file"):
        read_landmark_points(tmp_path / "no.pp", tmp_path / "no.pp")
    binary = tmp_path / "b.vts"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidFile, match="as text"):
        read_landmark_points(binary, binary)
    one, two = tmp_path / "one.pp", tmp_path / "two.pp"
    one.write_text(meshlab(["nose", "chin"]))
    two.write_text(meshlab(["nose"]))
    with pytest.raises(InvalidInput, match=r"2 landmarks .* 1.*chin"):
        read_landmark_points(one, two)


def test_real_landmarks_lie_on_their_meshes():
    pairs = read_landmark_points(
        real("landmarks/shrec07_385.vts"), real("landmarks/shrec07_394.vts")
    )
    assert pairs.shape == (21, 2, 3)
    for side, number in enumerate((385, 394)):
        mesh = hk.read(real(f"quadruped/shrec07_{number}.off"))
        away = np.linalg.norm(mesh.vertices[None] - pairs[:, side, None], axis=2).min(axis=1)
        assert away.max() < 1e-3 * mesh.diagonal
