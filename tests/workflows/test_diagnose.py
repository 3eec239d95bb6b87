"""The diagnosis of meshes made by hand, and of real ones against what their collection says."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from data import folder, real
from henkei.mesh import Mesh, PolygonMesh
from henkei.workflows.diagnose import diagnose
from models import abaqus, box, parsed

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)


def usable(diagnosis) -> set[str]:
    return {name for name, use in diagnosis.methods.items() if use.usable}


def test_a_good_disk():
    d = diagnose(Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]]))
    assert (d.vertices, d.faces, d.face_sizes) == (4, 2, {3: 2})
    assert d.diagonal == pytest.approx(np.sqrt(2))
    assert [(c.vertices, c.faces, c.boundary_loops, c.genus) for c in d.components] == [
        (4, 2, 1, 0)
    ]
    assert [(loop.vertices, loop.length) for loop in d.boundary_loops] == [(4, 4.0)]
    assert d.manifold
    assert d.oriented
    assert d.orientable
    assert d.self_intersections.shape == (0, 2)
    assert d.worst_quality.tolist() == pytest.approx([np.sqrt(3) / 2] * 2)
    assert usable(d) == {"combine", "register", "quad", "deform", "design"}
    assert [name for name, use in d.methods.items() if use.available] == [
        "combine",
        "register",
        "quad",
        "deform",
        "design",
    ]
    assert all(use.reason == use.remedy == "" for use in d.methods.values())


def test_labels_are_those_of_a_model():
    model = parsed(
        abaqus(*box("hexahedron", 3, 3, 3)).replace(
            "*STEP", "*NSET, NSET=BOLTS\n1, 2, 3\n*ELSET, ELSET=TOP\n1, 2\n*STEP", 1
        )
    )
    labels = {(label.name, label.on): label.values for label in diagnose(model.surface).labels}
    assert labels == {
        ("set every", "vertices"): {1: 56},
        ("set BOLTS", "vertices"): {1: 3},
        ("property", "faces"): {1: 54},
        ("set set_hexahedron", "faces"): {1: 54},
        ("set TOP", "faces"): {1: 5},
    }
    assert diagnose(Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]])).labels == ()


def test_components_have_a_genus_each_and_stand_by_size():
    i, j = (grid.ravel() for grid in np.indices((3, 3)))
    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    torus = np.stack([a % 3 * 3 + b % 3 for a, b in corners], axis=1)
    u, v = 2 * np.pi / 3 * i, 2 * np.pi / 3 * j
    ring = 2 + np.cos(v)
    around = np.stack([ring * np.cos(u), ring * np.sin(u), np.sin(v)], axis=1)
    d = diagnose(PolygonMesh(np.vstack([SQUARE + 9, around]), np.vstack([[0, 1, 2, 3], torus + 4])))
    found = [(c.vertices, c.faces, c.boundary_loops, c.genus) for c in d.components]
    assert found == [(9, 9, 0, 1), (4, 1, 1, 0)]
    assert usable(d) == {"quad", "deform", "design"}


def test_holes_are_an_option_of_combine():
    ring = np.vstack([3 * SQUARE, SQUARE + np.array([1, 1, 0])])
    quads = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    d = diagnose(PolygonMesh(ring, quads).triangulated())
    assert [(loop.vertices, loop.length) for loop in d.boundary_loops] == [(4, 12.0), (4, 4.0)]
    combine = d.methods["combine"]
    assert (combine.usable, combine.option) == (False, "--fill-holes")
    assert combine.reason.startswith("the surface has 2 boundary loops, of length 12 (4 vertices)")
    assert combine.remedy.startswith("close 1 loop with --fill-holes")
    assert diagnose(PolygonMesh(ring, quads)).methods["combine"] == combine


def test_faults_are_named():
    vertices = np.vstack([SQUARE, SQUARE[:2], [[9, 9, 9]]])
    d = diagnose(Mesh(vertices, [[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 2, 3], [0, 4, 0]]))
    assert d.nonmanifold_edges.tolist() == [[0, 1], [0, 4]]
    assert not d.manifold
    assert d.degenerate_faces.tolist() == [3, 4]
    assert d.faces_without_area.tolist() == [2, 3, 4]
    assert d.unused_vertices.tolist() == [5, 6]
    assert d.duplicate_vertices == 2
    assert d.self_intersections.tolist() == [[0, 1]]
    assert [(c.faces, c.genus) for c in d.components] == [(4, None), (1, None)]
    assert usable(d) == set()
    assert d.methods["deform"].reason == "2 faces repeat a vertex: 3, 4"


def test_polygons_are_tested_by_their_triangles():
    stack = PolygonMesh(np.vstack([SQUARE, 2 * SQUARE]), [[0, 1, 2, 3], [4, 5, 6, 7]])
    assert diagnose(stack).self_intersections.tolist() == [[0, 1]]


def test_no_number_no_answer():
    d = diagnose(Mesh([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    assert d.not_finite_vertices.tolist() == [0]
    assert d.self_intersections is None
    assert not d.self_intersections_complete
    assert not len(d.worst_faces)
    assert d.as_dict()["diagonal"] is None
    assert usable(d) == set()


def test_quads_take_any_winding_that_can_be_made_to_agree():
    turned = diagnose(Mesh(SQUARE, [[0, 1, 2], [0, 3, 2]]))
    assert usable(turned) == {"quad", "deform"}
    thin = diagnose(Mesh([*SQUARE, [0.5, 0, 0]], [[0, 4, 1], [4, 2, 1], [0, 2, 4]]))
    assert "no area" in thin.methods["quad"].reason
    i = np.arange(5)
    strip = np.column_stack([2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2]) % 10
    strip[-1] = [8, 9, 0, 1]
    angle = 2 * np.pi * i / 5
    lower = np.column_stack([np.cos(angle), np.sin(angle), -np.cos(angle / 2)])
    upper = np.column_stack([1.2 * np.cos(angle), np.sin(angle), np.cos(angle / 2)])
    one_sided = diagnose(PolygonMesh(np.stack([lower, upper], axis=1).reshape(-1, 3), strip))
    assert "one-sided" in one_sided.methods["quad"].reason


@pytest.mark.parametrize("mesh", [Mesh(np.empty((0, 3)), []), Mesh(SQUARE, [])])
def test_nothing_is_not_usable(mesh):
    d = diagnose(mesh)
    assert (d.faces, d.components, d.boundary_loops) == (0, (), ())
    assert usable(d) == set()
    assert d.methods["combine"].reason == "the mesh has no faces"


def test_as_dict_is_json():
    d = diagnose(PolygonMesh(SQUARE, [[0, 1, 2, 3]]))
    told = json.loads(json.dumps(d.as_dict(), allow_nan=False))
    assert told["face_sizes"] == {"4": 1}
    assert told["boundary_loops"] == [{"start": 0, "vertices": 4, "length": 4.0}]
    assert told["methods"]["deform"]["usable"] is True


# The collection counts pieces over shared vertices, and fans in meshes with bad edges otherwise.
OTHER_COUNTS = {"cad-panel/octagonal_pocket.stl", "nasty/hourglass_ico.obj"}


def collection() -> list[dict[str, str]]:
    path = folder() / "manifest.tsv"
    if not path.is_file():
        return []
    with path.open() as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    return [row for row in rows if not row["file"].startswith("large/")]


@pytest.mark.skipif(not collection(), reason="no manifest.tsv: set HENKEI_DATA to the real meshes")
@pytest.mark.filterwarnings("ignore:.*NaN in the colours")
@pytest.mark.parametrize("row", collection(), ids=lambda row: row["file"])
def test_real_meshes_are_what_their_collection_says(row):
    d = diagnose(real(row["file"]))
    assert d.vertices == int(row["V"])
    assert sum((size - 2) * count for size, count in d.face_sizes.items()) == int(row["F"])
    assert d.manifold is (row["manifold"] == "True")
    assert len(d.nonmanifold_edges) == int(row["nmE"])
    assert d.duplicate_vertices == int(row["dupV"])
    if row["file"] not in OTHER_COUNTS:
        assert len(d.components) == int(row["comps"])
    if d.manifold:
        assert len(d.boundary_loops) == int(row["bloops"])
        assert sum(piece.genus for piece in d.components) == float(row["genus"])
    if set(d.face_sizes) == {3}:
        assert d.worst_quality[0] == pytest.approx(float(row["qmin"]), rel=1e-2, abs=1e-9)
