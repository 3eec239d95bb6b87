"""Quadrangulation as a whole: its promise on all topologies, and what it says to bad input."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import henkei as hk
from bodies import bumpy, moved, together, with_unused_vertices
from data import real
from henkei import shapes
from henkei.errors import (
    Cancelled,
    DegenerateFaces,
    Infeasible,
    InvalidInput,
    InvalidMesh,
    NotFinite,
    NotManifold,
    NotOriented,
)
from henkei.mesh import Mesh
from henkei.quad import quality
from henkei.quad.wishes import MOST, Wish
from oracles.quads import assert_quadrangulates, from_segments
from topologies import TOPOLOGIES, cube, grid, refined, torus

WAYS = ["field", "vsa"]
TINY = ["triangle", "folded pair", "tetrahedron", "cube", "long strip", "tiny hole", "L", "wedge"]
BY_SHAPE = [*TINY, "sphere", "tube", "torus", "genus 1", "sphere with a hole of one face", "slit"]
seeds = st.integers(0, 10**6)


@pytest.fixture(autouse=True, scope="module")
def _few_samples():
    """Distances are measured elsewhere."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quality, "SAMPLES", 200)
        yield


def at_least(mesh: Mesh, quads: int, **how) -> hk.QuadResult:
    """So many quads, or as many as it says that the surface takes."""
    for _ in range(4):
        try:
            return hk.quadrangulate(mesh, quads=quads, **how)
        except Infeasible as error:
            said = int(str(error).split("at least ")[1].split(";")[0].replace(",", ""))
        assert said > quads
        quads = said
    return hk.quadrangulate(mesh, quads=quads, **how)


def same(a: hk.QuadResult, b: hk.QuadResult) -> bool:
    return (
        a.mesh.vertices.tobytes() == b.mesh.vertices.tobytes()
        and a.mesh.faces.tobytes() == b.mesh.faces.tobytes()
        and a.uv.tobytes() == b.uv.tobytes()
        and a.on_input.barycentric.tobytes() == b.on_input.barycentric.tobytes()
    )


@pytest.mark.parametrize(
    ("name", "layout"),
    [*((name, "field") for name in TOPOLOGIES), *((name, "vsa") for name in BY_SHAPE)],
)
def test_every_topology_is_kept(name, layout):
    mesh = TOPOLOGIES[name]()
    assert_quadrangulates(at_least(mesh, 45, layout=layout), mesh)


@pytest.mark.parametrize("name", TINY)
def test_very_few_quads_are_an_answer_or_the_least_number_is_said(name):
    mesh = TOPOLOGIES[name]()
    assert_quadrangulates(at_least(mesh, 6), mesh)


@settings(max_examples=4, deadline=None)
@given(
    name=st.sampled_from(sorted(TOPOLOGIES)),
    quads=st.integers(1, 90),
    layout=st.sampled_from(["auto", *WAYS]),
    seed=seeds,
)
def test_any_number_of_quads_on_surfaces_moved_and_numbered_anyhow(name, quads, layout, seed):
    mesh, rng = TOPOLOGIES[name](), np.random.default_rng(seed)
    order = rng.permutation(len(mesh.vertices))
    faces = np.argsort(order)[rng.permutation(mesh.faces)]
    turn = Rotation.random(random_state=seed).as_matrix()
    points = mesh.vertices[order] @ turn.T * 10.0 ** rng.integers(-6, 7)
    there = Mesh(points + rng.normal(size=3) * 1e3 * mesh.diagonal * rng.integers(0, 2), faces)
    assert_quadrangulates(at_least(there, quads, layout=layout, seed=seed % 1000), there)


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 10**4), quads=st.integers(60, 120))
def test_smooth_bodies_get_about_as_many_quads_as_asked_for_none_inverted(seed, quads):
    mesh = bumpy(2, seed)
    result = hk.quadrangulate(mesh, quads=quads)
    assert_quadrangulates(result, mesh)
    q = result.quality
    assert abs(q.quads - quads) <= 0.25 * quads + 4
    assert q.inverted == 0
    assert q.flipped == 0
    assert q.worst_scaled_jacobian > 0


@pytest.mark.parametrize("layout", ["auto", "field"])
def test_a_flat_square_becomes_a_grid(layout):
    result = hk.quadrangulate(grid(3, 3, seed=2), quads=64, layout=layout)
    assert_quadrangulates(result, grid(3, 3, seed=2))
    own = np.sort(np.rint(8 * result.mesh.vertices[:, :2]) @ [9, 1])
    np.testing.assert_array_equal(own, np.arange(81))
    np.testing.assert_allclose(
        8 * result.mesh.vertices, np.rint(8 * result.mesh.vertices), atol=1e-3
    )
    assert result.quality.irregular == 0


def test_a_cube_becomes_a_cube_of_squares():
    result = hk.quadrangulate(cube(), quads=54)
    assert_quadrangulates(result, cube())
    assert result.quality.quads == 54
    assert result.quality.irregular == 8
    assert result.quality.mean_scaled_jacobian == pytest.approx(1, abs=1e-3)


def test_edge_length_is_followed():
    result = hk.quadrangulate(grid(4, 4), edge_length=0.1)
    assert abs(result.quality.quads - 100) <= 5


def corners_of(mesh: Mesh, feature: np.ndarray) -> np.ndarray:
    """Where other than two of these edges (k, 2) meet, or two at a right angle or sharper."""
    found = []
    for vertex in np.unique(feature):
        ends = feature[(feature == vertex).any(axis=1)].sum(axis=1) - vertex
        ways = mesh.vertices[ends] - mesh.vertices[vertex]
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        if len(ways) != 2 or ways[0] @ ways[1] > -0.1:
            found.append(vertex)
    return mesh.vertices[found]


CORNERED = ["cube", "L", "square with holes", "wedge"]


def has(points: np.ndarray, wanted: np.ndarray) -> bool:
    """Whether all wanted points are among these, exactly."""
    return set(map(tuple, wanted.tolist())) <= set(map(tuple, points.tolist()))


@pytest.mark.parametrize("layout", WAYS)
@pytest.mark.parametrize("name", CORNERED)
def test_corners_of_creases_and_boundaries_are_kept_exactly(name, layout):
    mesh = TOPOLOGIES[name]()
    twin, face = mesh.topology.twin, mesh.topology.face
    cosine = (mesh.face_normals[face] * mesh.face_normals[face[twin]]).sum(axis=1)
    sharp = (twin < 0) | (cosine < 0.7)
    feature = np.unique(
        np.sort(np.stack([mesh.indices, mesh.topology.target], axis=1)[sharp], axis=1), axis=0
    )
    result = at_least(mesh, 90, layout=layout, sharp=40)
    assert_quadrangulates(result, mesh)
    assert has(result.mesh.vertices, corners_of(mesh, feature))
    # The feature edges of the quads lie on the input's, and cover them.
    ends = result.mesh.vertices[result.features]
    start, end = mesh.vertices[feature].transpose(1, 0, 2)
    for at in (0.0, 0.5):
        points = (1 - at) * ends[:, 0] + at * ends[:, 1]
        slack = 1e-9 if name != "wedge" or at == 0 else 0.05  # its rim is round
        assert from_segments(points, start, end).min(axis=1).max() <= slack * mesh.diagonal
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    whole = np.linalg.norm(end - start, axis=1).sum()
    assert length == pytest.approx(whole, rel=1e-2 if name == "wedge" else 1e-6)


@pytest.mark.parametrize("layout", WAYS)
def test_edges_that_are_given_become_edges_of_quads(layout):
    mesh = grid(8, 8, seed=4)
    x, y = mesh.vertices[mesh.topology.edges][:, :, :2].transpose(2, 0, 1)
    lines = mesh.topology.edges[(np.abs(y - 0.5) < 1e-9).all(axis=1) & (x < 0.76).all(axis=1)]
    result = hk.quadrangulate(mesh, quads=100, sharp=lines, layout=layout)
    assert_quadrangulates(result, mesh)
    ends = result.mesh.vertices[result.features]
    on_line = (np.abs(ends[..., 1] - 0.5) < 1e-9).all(axis=1)
    assert np.linalg.norm(ends[on_line, 0] - ends[on_line, 1], axis=1).sum() == pytest.approx(0.75)


@pytest.mark.parametrize("layout", WAYS)
def test_the_same_call_gives_the_same_bytes(layout):
    mesh = bumpy(2, 5)
    a, b = (hk.quadrangulate(mesh, quads=80, layout=layout, seed=3) for _ in range(2))
    assert same(a, b)


def test_another_process_with_another_hash_seed_gives_the_same_bytes():
    program = (
        "import hashlib, henkei as hk\n"
        "m = hk.shapes.bar(3.0, 1.0, 3, 5)\n"
        "for way in ('field', 'vsa'):\n"
        "    r = hk.quadrangulate(m, quads=60, layout=way)\n"
        "    made = r.mesh.vertices.tobytes() + r.mesh.faces.tobytes()\n"
        "    print(hashlib.sha256(made).hexdigest())\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", program],
        env={"PYTHONHASHSEED": "1", "PYTHONPATH": ":".join(sys.path)},
        capture_output=True,
        check=True,
        text=True,
    ).stdout.split()
    mesh = shapes.bar(3.0, 1.0, 3, 5)
    for way, there in zip(WAYS, said, strict=True):
        here = hk.quadrangulate(mesh, quads=60, layout=way).mesh
        made = here.vertices.tobytes() + here.faces.tobytes()
        assert hashlib.sha256(made).hexdigest() == there


@pytest.mark.parametrize(("layout", "power"), [("field", -20), ("field", 20), ("vsa", 20)])
def test_in_another_unit_the_quads_are_the_same_if_rounding_is(layout, power):
    mesh = bumpy(2, 5)
    here = hk.quadrangulate(mesh, quads=80, layout=layout)
    there = hk.quadrangulate(Mesh(mesh.vertices * 2.0**power, mesh.faces), quads=80, layout=layout)
    np.testing.assert_array_equal(here.mesh.faces, there.mesh.faces)
    np.testing.assert_allclose(here.mesh.vertices, there.mesh.vertices / 2.0**power, rtol=1e-6)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("name", ["sphere", "square with holes"])
def test_units_far_from_one_do_no_harm(name, scale):
    mesh = TOPOLOGIES[name]()
    small = Mesh(scale * mesh.vertices, mesh.faces)
    a, b = (at_least(m, 64, layout="field") for m in (mesh, small))
    assert_quadrangulates(b, small)
    assert abs(a.quality.quads - b.quality.quads) <= 15
    assert b.quality.inverted == 0


@pytest.mark.parametrize("shift", [1e3, 1e6])
def test_far_from_the_origin_the_promise_holds(shift):
    mesh = moved(bumpy(2, 1), shift=(shift, -shift, shift))
    assert_quadrangulates(hk.quadrangulate(mesh, quads=80), mesh)


def test_several_components_are_done_each_and_joined():
    pieces = [bumpy(1, 0), grid(4, 4), torus(), cube()]
    apart = [moved(piece, shift=(5 * k, 0, 0)) for k, piece in enumerate(pieces)]
    mesh = with_unused_vertices(together(*apart), [0, 30])
    result = hk.quadrangulate(mesh, quads=240)
    assert_quadrangulates(result, mesh)
    assert abs(result.quality.quads - 240) <= 40
    area = np.array([piece.face_areas.sum() for piece in pieces])
    label = np.rint(result.mesh.vertices[result.mesh.faces].mean(axis=1)[:, 0] / 5).astype(int)
    share = np.bincount(label) / result.quality.quads
    np.testing.assert_allclose(share, area / area.sum(), atol=0.07)


def test_a_speck_beside_a_large_body_is_kept():
    speck = moved(cube(), 0.01, shift=(3, 0, 0))
    mesh = together(shapes.icosphere(1), speck)
    result = hk.quadrangulate(mesh, quads=60)
    assert_quadrangulates(result, mesh)


def test_polygons_and_pairs_of_arrays_are_taken_too():
    quads = shapes.bar(2.0, 1.0, 2, 4, quads=True)
    result = hk.quadrangulate(quads, quads=80)
    assert_quadrangulates(result, quads.triangulated())
    mesh = grid(4, 4)
    assert same(
        hk.quadrangulate((mesh.vertices, mesh.faces), quads=20), hk.quadrangulate(mesh, quads=20)
    )


def test_quads_are_finer_where_the_density_is_higher():
    mesh = refined(grid(8, 8), 1)
    result = hk.quadrangulate(
        mesh, quads=200, density=np.where(mesh.vertices[:, 0] < 0.5, 9.0, 1.0), layout="vsa"
    )
    assert_quadrangulates(result, mesh)
    left = (result.mesh.vertices[result.mesh.faces].mean(axis=1)[:, 0] < 0.5).mean()
    assert left > 0.6


def test_the_layout_map_covers_each_patch_once():
    result = hk.quadrangulate(bumpy(2, 2), quads=80)
    corners = result.layout.attributes.corner["uv"].reshape(-1, 3, 2)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2
    assert (area > 0).all()
    patch = result.layout.attributes.face["patch"]
    assert set(np.unique(result.patches)) <= set(np.unique(patch))
    total = np.bincount(patch, area)
    assert (total > 0).all()


# Bad input


def twisted(around: int = 12) -> Mesh:
    """A Moebius strip."""
    angle = np.repeat(2 * np.pi * np.arange(around) / around, 2)
    side = np.tile([-0.3, 0.3], around)
    out = 1 + side * np.cos(angle / 2)
    points = [out * np.cos(angle), out * np.sin(angle), side * np.sin(angle / 2)]
    faces = []
    for k in range(around):
        a, b = 2 * k, 2 * k + 1
        c, d = (a + 2, b + 2) if k < around - 1 else (1, 0)
        faces += [[a, c, d], [a, d, b]]
    return Mesh(np.stack(points, axis=1), faces)


def with_faces(mesh: Mesh, *faces, points=()) -> Mesh:
    vertices = np.vstack([mesh.vertices, *[[p] for p in points]])
    return Mesh(vertices, np.vstack([mesh.faces, np.array(faces, dtype=np.int32)]))


FLAT = grid(4, 4)
EDGE = FLAT.faces[5][:2].tolist()
BAD_MESHES = {
    "edge of three faces": (
        with_faces(FLAT, [*EDGE, 25], points=[(0.5, 0.5, 1)]),
        NotManifold,
        f"between vertices {min(EDGE)}-{max(EDGE)}",
    ),
    "faces that meet in a point": (
        Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 0, 0], [-1, -1, 0]], [[0, 1, 2], [0, 3, 4]]),
        NotManifold,
        "at 1 vertex: 0",
    ),
    "one-sided": (twisted(), NotOriented, "one-sided"),
    "face without area": (
        Mesh(np.where(np.arange(25)[:, None] == 6, FLAT.vertices[7], FLAT.vertices), FLAT.faces),
        DegenerateFaces,
        "no area",
    ),
    "face twice": (with_faces(FLAT, FLAT.faces[0]), InvalidMesh, "edge"),
    "face twice, turned": (with_faces(FLAT, FLAT.faces[0][::-1]), InvalidMesh, "edge"),
    "face that repeats a vertex": (with_faces(FLAT, [3, 3, 4]), DegenerateFaces, "32"),
    "not a number": (
        Mesh(np.where(np.arange(25)[:, None] == 6, np.nan, FLAT.vertices), FLAT.faces),
        NotFinite,
        ": 6",
    ),
    "no faces": (Mesh(FLAT.vertices, np.zeros((0, 3), dtype=int)), InvalidMesh, "no faces"),
    "too far away": (moved(FLAT, shift=(1e15, 0, 0)), InvalidMesh, "origin"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_MESHES)
def test_meshes_that_are_no_surface_are_named(name):
    mesh, kind, said = BAD_MESHES[name]
    with pytest.raises(kind, match=said):
        hk.quadrangulate(mesh, quads=20)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"quads": 10, "edge_length": 0.1}, "not both"),
        *[({"quads": q}, "quads") for q in (0, -1, 0.5, np.nan, np.inf, 1e12, "10", [10], True)],
        *[({"edge_length": e}, "edge_length") for e in (0, -1, np.nan, np.inf, "1", [1], 1e-9)],
        *[({"layout": w}, "layout") for w in ("x", None, 1, ["field"], "Field")],
        *[({"patches": p}, "patches") for p in (0, -3, 2.5, "4", np.nan, np.inf, True)],
        ({"patches": 4, "layout": "field"}, "vsa"),
        *[({"seed": s}, "seed") for s in (-1, 1.5, "a", None, 2**70, np.nan, True)],
        *[({"sharp": s}, "sharp") for s in (0, -1, 181, np.nan, "x", {}, True, [[0, 1], [2]])],
        ({"sharp": [[0, 24]]}, r"\(0, 24\)"),
        *[({"density": d}, "density") for d in ("x", 1.0, np.zeros(25), ["a"] * 25, [1j] * 25)],
        *[({"symmetry": s}, "symmetry") for s in ("w", 3, [1, 2], [[0, 0, 0], [0, 0, 0]])],
    ],
)  # fmt: skip
def test_arguments_that_make_no_sense_are_named(how, said):
    with pytest.raises(InvalidInput, match=said):
        hk.quadrangulate(FLAT, **{"quads": None if "edge_length" in how else 20, **how})


def test_the_least_length_is_told_and_is_taken():
    with pytest.raises(InvalidInput, match="20,000,000 are the most") as refused:
        Wish.of(FLAT, None, 1e-300, None)
    least = float(re.search(r"from (\S+) on", str(refused.value))[1])
    assert Wish.of(FLAT, None, 1.01 * least, None).quads == pytest.approx(MOST, rel=0.05)


def test_far_fewer_quads_than_the_surface_takes_are_refused_with_the_least_number():
    mesh = shapes.icosphere(1)  # as creases, its edges leave 80 triangles, each a quad or more
    with pytest.raises(Infeasible, match=r"10 quads were asked for.* at least \d+") as refused:
        hk.quadrangulate(mesh, quads=10, sharp=5, layout="field")
    assert int(re.findall(r"at least (\d+)", str(refused.value))[0]) >= 80


@pytest.mark.parametrize("layout", WAYS)
def test_progress_never_goes_back_and_can_end_the_work_at_any_step(layout):
    mesh = cube()
    seen: list[tuple[str, float]] = []
    hk.quadrangulate(
        mesh, quads=24, layout=layout, progress=lambda text, part: seen.append((text, part))
    )
    parts = [part for _, part in seen]
    assert parts == sorted(parts)
    assert 0 <= parts[0] <= parts[-1] == 1
    assert all(text for text, _ in seen)
    first = {text: number for number, (text, _) in reversed(list(enumerate(seen)))}
    assert len(first) >= 5
    for stop in first.values():
        left = [stop]

        def end(text: str, part: float, left: list[int] = left) -> None:
            left[0] -= 1
            if left[0] < 0:
                raise Cancelled(text)

        with pytest.raises(Cancelled, match=seen[stop][0].replace("(", ".").replace(")", ".")):
            hk.quadrangulate(mesh, quads=24, layout=layout, progress=end)


@pytest.mark.parametrize(
    "name",
    ["quadruped/spot_5856.obj", "cad-panel/fandisk.obj"],
)
def test_real_meshes(name):
    mesh = hk.read(real(name))
    result = hk.quadrangulate(mesh, quads=500)
    assert_quadrangulates(result, mesh)
    assert result.quality.inverted == 0
    assert abs(result.quality.quads - 500) <= 75
