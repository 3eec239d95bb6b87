"""Quads and layouts in files of each format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.io.cae import read_model
from henkei.shapes import icosphere
from henkei.workflows.quad_files import LAYOUTS, QUADS, require_ending, write_layout, write_quads

BY_MESHIO = {".vtu", ".msh", ".mesh"}


@pytest.fixture(scope="module")
def ball() -> hk.QuadResult:
    return hk.quadrangulate(icosphere(2), quads=60)


@pytest.mark.parametrize("suffix", QUADS)
def test_quads_are_read_again(ball, tmp_path, suffix):
    if suffix in BY_MESHIO:
        pytest.importorskip("meshio")
    path = tmp_path / f"quads{suffix}"
    require_ending(path)
    write_quads(path, ball)
    read = hk.read(path)
    np.testing.assert_array_equal(read.faces, ball.mesh.faces)
    np.testing.assert_allclose(read.vertices, ball.mesh.vertices, rtol=0, atol=1e-13)
    held = QUADS[suffix]
    if "texture" in held:
        np.testing.assert_array_equal(read.attributes.corner["uv"].reshape(-1, 4, 2), ball.uv)
    if held.endswith("patches"):
        np.testing.assert_array_equal(read.attributes.face["patch"], ball.patches)


def test_groups_of_obj_are_patches(ball, tmp_path):
    write_quads(tmp_path / "quads.obj", ball)
    read = hk.read(tmp_path / "quads.obj")
    lines = (tmp_path / "quads.obj").read_text().splitlines()
    groups, of_face = "", []
    for line in lines:
        groups = line if line.startswith("g ") else groups
        of_face += [groups] * line.startswith("f ")
    assert of_face == [f"g {patch}" for patch in ball.patches.tolist()]
    assert read.face_count == len(of_face)


@pytest.mark.parametrize(("suffix", "name"), [(".inp", "S4"), (".bdf", "CQUAD4")])
def test_shells_of_simulation_codes(ball, tmp_path, suffix, name):
    meshio = pytest.importorskip("meshio")
    path = tmp_path / f"quads{suffix}"
    write_quads(path, ball)
    assert name in path.read_text()
    other = meshio.read(path)
    assert [(block.type, len(block.data)) for block in other.cells] == [
        ("quad", ball.quality.quads)
    ]
    np.testing.assert_array_equal(other.cells[0].data, ball.mesh.faces)
    np.testing.assert_allclose(other.points, ball.mesh.vertices, rtol=0, atol=1e-13)
    model = read_model(path)
    (block,) = model.blocks
    assert (block.kind, len(block.ids)) == ("quad", ball.quality.quads)
    sets = model.groups.elements
    if suffix == ".inp":
        assert len(sets) == len(np.unique(ball.patches))
        for name, rows in sets.items():
            number = int(name.removeprefix("PATCH_"))
            np.testing.assert_array_equal(rows, np.flatnonzero(ball.patches == number))


@pytest.mark.filterwarnings("ignore:glTF holds float32")
@pytest.mark.parametrize("suffix", LAYOUTS)
def test_layouts_are_coloured(ball, tmp_path, suffix):
    path = tmp_path / f"layout{suffix}"
    require_ending(path, layout=True)
    write_layout(path, ball)
    read = hk.read(path)
    assert read.face_count == ball.layout.face_count
    np.testing.assert_allclose(
        read.vertices[read.indices], ball.layout.vertices[ball.layout.indices], atol=1e-6
    )
    colors = read.attributes.vertex["color"][read.indices[::3], :3]
    patch = ball.layout.attributes.face["patch"]
    for number in np.unique(patch):
        assert np.ptp(colors[patch == number], axis=0).max() == 0
    assert len(np.unique(colors, axis=0)) == min(len(np.unique(patch)), 12)


@pytest.mark.parametrize("name", ["quads.stl", "quads.glb", "quads.su2", "quads", "quads.xyz"])
def test_what_holds_no_quads_is_refused(name):
    with pytest.raises(InvalidInput, match="not written under the ending"):
        require_ending(Path(name))


@pytest.mark.parametrize("name", ["layout.stl", "layout.inp"])
def test_what_holds_no_colours_is_refused(name):
    with pytest.raises(InvalidInput, match="a coloured layout is not written"):
        require_ending(Path(name), layout=True)
