"""Folders of shapes: what is read, in which order, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry.correspondence import SurfacePoints
from henkei.register import Registration, register
from henkei.shapes import grid, hemisphere
from henkei.workflows.shape_folder import bridged_line, read_shapes

SHEET = grid(4, 4)


@cache
def registered(height: float) -> Registration:
    """The sheet registered onto a wave."""
    wave = grid(5, 5)
    bent = wave.vertices + np.column_stack([0 * wave.vertices[:, :2], height * wave.vertices[:, 0]])
    return register(SHEET, (bent, wave.faces))


def with_gap(result: Registration, vertices: list[int]) -> Registration:
    """As if the target had a hole at these vertices alone."""
    face = np.zeros(len(result.on_target), np.int32)
    barycentric = np.tile([1.0, 0, 0], (len(face), 1))
    face[vertices], barycentric[vertices] = -1, 0
    both = replace(result.correspondence, on_b=SurfacePoints(face, barycentric))
    return replace(result, correspondence=both)


def test_registrations_and_not_the_meshes_beside_them(tmp_path):
    gaps = [[], [3, 4, 9], [7]]
    for name, height, gap in zip("bca", (0.1, 0.2, 0.3), gaps, strict=True):
        result = with_gap(registered(height), gap)
        hk.save(tmp_path / f"{name}.npz", result)
        hk.write(tmp_path / f"{name}.ply", result.mesh)
    (tmp_path / "report.json").write_text("{}")
    found = read_shapes(tmp_path)
    assert found.registrations
    assert found.shapes.names == ("a", "b", "c")
    assert found.bridged == (1, 0, 3)
    assert bridged_line(found) == "4 vertices over gaps of the scans: a (1), c (3)"
    for k, height in enumerate((0.3, 0.1, 0.2)):
        np.testing.assert_array_equal(found.shapes.vertices[k], registered(height).mesh.vertices)
    np.testing.assert_array_equal(found.shapes.faces, SHEET.faces)


def test_meshes_in_the_order_of_their_names(tmp_path):
    for name in ("b.obj", "a.ply", "c.off"):
        hk.write(tmp_path / name, SHEET)
    (tmp_path / "notes.txt").write_text("x")
    (tmp_path / ".c.ply").write_text("x")
    (tmp_path / "below").mkdir()
    seen: list[float] = []
    found = read_shapes(tmp_path, progress=lambda message, fraction: seen.append(fraction))
    assert not found.registrations
    assert found.shapes.names == ("a", "b", "c")
    assert [path.name for path in found.files] == ["a.ply", "b.obj", "c.off"]
    assert bridged_line(found) == ""
    assert seen == sorted(seen)
    assert seen[-1] < 1


def test_which_file_differs_and_where(tmp_path):
    hk.write(tmp_path / "a.ply", SHEET)
    hk.write(tmp_path / "b.ply", SHEET)
    hk.write(tmp_path / "c.ply", grid(4, 3))
    with pytest.raises(InvalidInput, match=r"^c\.ply: has 20 vertices, a\.ply has 25"):
        read_shapes(tmp_path)
    turned = SHEET.faces.copy()
    turned[9] = np.roll(turned[9], 1)
    hk.write(tmp_path / "c.ply", hk.Mesh(SHEET.vertices, turned))
    with pytest.raises(InvalidInput, match=r"^c\.ply: face 9 is \(.*in a\.ply it is \("):
        read_shapes(tmp_path)


def test_what_is_no_shape_is_refused(tmp_path):
    with pytest.raises(InvalidFile, match=r"no shapes in this folder.*henkei register.*\.obj"):
        read_shapes(tmp_path)
    with pytest.raises(InvalidFile, match="no such folder"):
        read_shapes(tmp_path / "none")
    (tmp_path / "a.ply").write_text("nothing")
    with pytest.raises(InvalidFile, match=r"a\.ply"):
        read_shapes(tmp_path)
    with pytest.raises(InvalidFile, match="not a folder"):
        read_shapes(tmp_path / "a.ply")
    (tmp_path / "b.npz").write_text("nothing")
    with pytest.raises(InvalidFile, match=r"b\.npz: damaged"):
        read_shapes(tmp_path)


def test_results_of_other_kinds_are_refused(tmp_path):
    hk.save(tmp_path / "c.npz", hk.combine(hemisphere(1), hemisphere(1)))
    with pytest.raises(InvalidInput, match=r"c\.npz: holds CombinedMesh, not a registration"):
        read_shapes(tmp_path)
    hk.save(tmp_path / "c.npz", hk.shape_model([SHEET, SHEET]))
    with pytest.raises(InvalidInput, match=r"c\.npz: holds ShapeModel, not a registration"):
        read_shapes(tmp_path)


def test_one_shape_in_two_formats_is_refused(tmp_path):
    hk.write(tmp_path / "a.ply", SHEET)
    hk.write(tmp_path / "a.obj", SHEET)
    with pytest.raises(InvalidInput, match=r"a\.obj and a\.ply in .* have the same name"):
        read_shapes(tmp_path)


def test_a_folder_needs_no_string(tmp_path):
    hk.write(tmp_path / "a.ply", SHEET)
    assert len(read_shapes(str(tmp_path)).shapes) == 1
    assert isinstance(read_shapes(Path(tmp_path)).files[0], Path)
