"""Every real mesh reads with the counts known for it, and as other libraries read it."""

from __future__ import annotations

import csv
import warnings

import numpy as np
import pytest

from data import folder, real
from henkei import Mesh, PolygonMesh
from henkei.io import read
from written import again, same_shape


def manifest() -> list[dict[str, str]]:
    path = folder() / "manifest.tsv"
    if not path.is_file():
        return []
    with path.open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream, delimiter="\t"))


ROWS = manifest()


def read_quietly(name: str) -> Mesh | PolygonMesh:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*NaN in the colours")
        return read(real(name))


@pytest.mark.skipif(not ROWS, reason="no manifest.tsv: set HENKEI_DATA to the real meshes")
@pytest.mark.parametrize("row", ROWS, ids=[row["file"] for row in ROWS])
def test_counts_and_exact_copies(row):
    surface = read_quietly(row["file"])
    triangles = surface.triangulated() if isinstance(surface, PolygonMesh) else surface
    assert (len(surface.vertices), len(triangles.faces)) == (int(row["V"]), int(row["F"]))
    plain = type(surface)(surface.vertices, surface.faces)
    for kind in ("obj", "ply"):
        assert same_shape(again(kind, plain), surface)


@pytest.mark.parametrize(
    "name",
    [
        "faces-disk/mediapipe_canonical.obj",
        "genus0/penguin.obj",
        "nasty/bunny_trimesh.ply",
        "cad-panel/plate_holes.stl",
        "quadruped/shrec07_385.off",
        "large/pycortexS1_flat_291k.ply",
    ],
)
def test_trimesh_reads_the_same_corners(name):
    trimesh = pytest.importorskip("trimesh")
    peer = trimesh.load(real(name), process=False)
    mesh = read_quietly(name)
    corners = peer.vertices[peer.faces]
    tolerance = 1e-6 * mesh.diagonal if name.endswith("ply") else 0.0  # trimesh keeps float32
    assert np.abs(corners - mesh.vertices[mesh.faces]).max() <= tolerance


@pytest.mark.parametrize("name", ["genus0/goathead.obj", "cad-panel/fandisk.obj"])
def test_meshio_reads_the_same(name):
    meshio = pytest.importorskip("meshio")
    peer = meshio.read(real(name))
    mesh = read_quietly(name)
    np.testing.assert_array_equal(peer.points, mesh.vertices)
    np.testing.assert_array_equal(peer.cells_dict["triangle"], mesh.faces)


def test_seams_do_not_split_vertices():
    mesh = read_quietly("faces-disk/mediapipe_canonical.obj")
    assert mesh.attributes.corner["uv"].shape == (3 * 898, 2)
    cow = read_quietly("cage/spot_control.obj")
    assert len(cow.vertices) == 188
    assert len(np.unique(cow.attributes.corner["uv"], axis=0)) > 188


def test_nan_colors_are_tolerated_with_a_warning():
    with pytest.warns(UserWarning, match=r"nancolor.obj: NaN in the colours of 6"):
        mesh = read(real("nasty/nancolor.obj"))
    assert np.isnan(mesh.attributes.vertex["color"][6]).all()
