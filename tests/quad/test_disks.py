from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data import real
from henkei import read, shapes
from henkei.errors import InvalidInput
from henkei.geometry.creases import Folds
from henkei.mesh import Mesh
from henkei.quad.disks import disk_layout, vsa_layout
from henkei.quad.layout import Layout
from henkei.quad.opened import label_cuts
from henkei.quad.patches import face_regions, open_neighbours, shape_patches
from henkei.quad.straightening import straightened, without_short_arcs
from sheets import plate, tube
from triangulated_spheres import random_hull, stacked


def assert_patches_are_disks(layout: Layout) -> int:
    """Each patch, cut open, has Euler number 1 and one rim, which visits no vertex twice.

    Faces, and corners at a vertex, are joined one by one over edges that are not cut. Returns the
    number of patches.
    """
    topology, cut = layout.mesh.topology, layout.cut.tolist()
    twin, after = topology.twin.tolist(), topology.next.tolist()
    origin = layout.mesh.indices.tolist()
    face, corner = list(range(len(layout.mesh.faces))), list(range(len(twin)))

    def root(parent, k):
        while parent[k] != k:
            parent[k] = k = parent[parent[k]]
        return k

    for h in range(len(twin)):
        assert twin[h] >= 0 or cut[h]
        if not cut[h]:
            assert not cut[twin[h]]
            face[root(face, h // 3)] = root(face, twin[h] // 3)
            corner[root(corner, h)] = root(corner, after[twin[h]])
    patch = [root(face, f) for f in range(len(face))]
    euler = Counter(patch)
    euler.update(patch[h // 3] for h in {root(corner, h) for h in range(len(twin))})
    edges = Counter(patch[h // 3] for h in range(len(twin)) if cut[h] or h < twin[h])
    euler.subtract(edges)
    assert set(euler.values()) == {1}
    rims = Counter(patch[h // 3] for h in range(len(twin)) if cut[h])
    starts = {patch[h // 3]: h for h in range(len(twin)) if cut[h]}
    assert set(rims) == set(patch)
    for own, start in starts.items():
        visited, h = [], start
        while not visited or h != start:
            visited.append(origin[h])
            h = after[h]
            while not cut[h]:
                h = after[twin[h]]
        assert len(visited) == rims[own] == len(set(visited))
    return len(rims)


def assert_layout(layout: Layout, mesh: Mesh, feature: np.ndarray | None) -> int:
    """A valid layout on the mesh that cuts every feature. Returns the number of patches."""
    twin = layout.mesh.topology.twin
    assert layout.mesh is mesh
    assert layout.turn is None
    assert (layout.feature == ((twin < 0) | layout.feature[twin])).all()
    if feature is not None:
        assert layout.feature[feature].all()
    assert layout.cut[layout.feature].all()
    assert (layout.length > 0).all()
    assert (layout.length[twin >= 0] == layout.length[twin[twin >= 0]]).all()
    return assert_patches_are_disks(layout)


def torus(around: int = 12, across: int = 6) -> Mesh:
    a, b = np.divmod(np.arange(around * across), across)
    u, v = 2 * np.pi * a / around, 2 * np.pi * b / across
    radius = 3 + np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), np.sin(v)], axis=1)
    p, q = a * across + b, a * across + (b + 1) % across
    r, s = (p + across) % len(p), (q + across) % len(p)
    return Mesh(points, np.concatenate([np.stack([p, r, s], 1), np.stack([p, s, q], 1)]))


def blocks(filled: np.ndarray) -> Mesh:
    """The surface of unit cubes, each square as two triangles."""
    padded = np.pad(filled, 1)
    corners, squares = {}, []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        step = np.eye(3, dtype=int)[axis]
        for cell in np.argwhere(padded):
            for away, base, ring in (
                (cell + step, cell + step, (0 * u, u, u + v, v)),
                (cell - step, cell, (0 * u, v, u + v, u)),
            ):
                if not padded[tuple(away)]:
                    squares.append(
                        [corners.setdefault(tuple(base + r), len(corners)) for r in ring]
                    )
    a, b, c, d = np.array(squares).T
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(np.array(list(corners), dtype=float), faces)


def holed(columns: int) -> Mesh:
    """A block with a row of square holes: as many handles."""
    filled = np.ones((2 * columns + 1, 3, 1), dtype=bool)
    filled[1::2, 1] = False
    return blocks(filled)


def punched() -> Mesh:
    """A sheet with six square holes."""
    mesh = shapes.grid(9, 7)
    cell = np.arange(len(mesh.faces)) // 2
    column, row = cell % 9, cell // 9
    return Mesh(mesh.vertices, mesh.faces[~((column % 3 == 1) & (row % 4 == 1))])


MESHES = {
    "tetrahedron": stacked(4, lambda faces: 0),
    "hull": random_hull(40, 2),
    "ball": shapes.icosphere(2),
    "box": shapes.bar(2.0, 1.0, 3, 6),
    "torus": torus(),
    "smallest torus": torus(3, 3),
    "two handles": holed(2),
    "five handles": holed(5),
    "triangle": Mesh(np.eye(3), [[0, 1, 2]]),
    "sheet": shapes.grid(6, 5),
    "sheet with a hole": plate(8, hole=0.4),
    "sheet with holes": punched(),
    "tube": tube(np.linspace(0, 4, 7), 5),
    "shortest tube": tube(np.linspace(0, 1, 2), 3),
}


def lengths(mesh: Mesh, edge: float) -> np.ndarray:
    ends = mesh.vertices[np.stack([mesh.indices, mesh.topology.target])]
    return np.linalg.norm(ends[0] - ends[1], axis=1) / edge


def labels(mesh: Mesh, kind: str, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    count = len(mesh.faces)
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    if kind == "one":
        return np.zeros(count, dtype=int)
    if kind == "each":
        return rng.permutation(count)
    if kind == "chance":
        return rng.integers(-2, 3, count)
    if kind == "stripes":
        return np.floor(centre @ rng.normal(size=3) * 2 / mesh.diagonal * rng.integers(1, 8))
    if kind == "rings":
        away = np.linalg.norm(centre - centre[rng.integers(count)], axis=1)
        return np.floor(away / mesh.diagonal * rng.integers(2, 12)).astype(int)
    return shape_patches(mesh, int(rng.integers(1, 20)), seed=seed)


@given(
    st.sampled_from(sorted(MESHES)),
    st.sampled_from(["one", "each", "chance", "stripes", "rings", "patches"]),
    st.sampled_from([0.0, 0.02, 0.15]),
    st.sampled_from([1e-3, 0.1, 1.0]),
    st.integers(0, 10**6),
)
@settings(max_examples=40, deadline=None)
def test_any_labelling_becomes_disks(name, kind, features, edge, seed):
    mesh = MESHES[name]
    feature = np.random.default_rng(seed).random(3 * len(mesh.faces)) < features
    layout = disk_layout(
        mesh,
        labels(mesh, kind, seed).astype(int),
        feature=feature,
        length=lengths(mesh, edge * mesh.diagonal),
    )
    assert_layout(layout, mesh, feature)


@pytest.mark.parametrize("name", sorted(MESHES))
def test_one_label_and_no_feature(name):
    mesh = MESHES[name]
    label = np.zeros(len(mesh.faces), dtype=np.int32)
    layout = disk_layout(mesh, label, feature=None, length=lengths(mesh, 0.1))
    assert_layout(layout, mesh, None)


def test_disks_stay_as_they_are():
    mesh = shapes.grid(12, 12)
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    quarter = 2 * (centre[:, 0] > 0.5) + (centre[:, 1] > 0.5)
    layout = disk_layout(mesh, quarter, feature=None, length=lengths(mesh, 0.1))
    assert np.array_equal(layout.cut, label_cuts(mesh, quarter))


def test_crumbs_are_joined_to_what_surrounds_them():
    mesh = shapes.grid(16, 16)
    label = np.zeros(len(mesh.faces), dtype=int)
    label[[50, 151, 300]] = [1, 2, 3]
    layout = disk_layout(mesh, label, feature=None, length=lengths(mesh, 0.1))
    assert assert_layout(layout, mesh, None) == 1


def test_an_annulus_becomes_two_halves():
    mesh = plate(16, hole=0.3)
    label = np.zeros(len(mesh.faces), dtype=int)
    layout = disk_layout(mesh, label, feature=None, length=lengths(mesh, 0.1))
    assert assert_layout(layout, mesh, None) == 2
    patch = face_regions(open_neighbours(mesh, layout.cut))
    area = np.bincount(patch, mesh.face_areas)
    assert area.min() > 0.25 * area.sum()


def crease(mesh: Mesh, chosen: np.ndarray) -> np.ndarray:
    """Half-edges both of whose ends are among the chosen vertices (n,)."""
    return chosen[mesh.indices] & chosen[mesh.topology.target]


def test_a_crease_that_ends_within_a_patch_goes_straight_on():
    mesh = shapes.grid(10, 10)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    feature = crease(mesh, np.isclose(y, 0.5) & (x < 0.65))
    layout = disk_layout(
        mesh, np.zeros(len(mesh.faces), int), feature=feature, length=lengths(mesh, 0.1)
    )
    assert assert_layout(layout, mesh, feature) == 2
    inner = layout.cut & (mesh.topology.twin >= 0)
    assert np.isclose(y[mesh.indices[inner]], 0.5).all()


def test_a_crease_within_a_patch_is_continued_both_ways():
    mesh = shapes.grid(10, 10)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    feature = crease(mesh, np.isclose(y, 0.5) & (x > 0.25) & (x < 0.75))
    layout = disk_layout(
        mesh, np.zeros(len(mesh.faces), int), feature=feature, length=lengths(mesh, 0.1)
    )
    assert assert_layout(layout, mesh, feature) == 2


def jagged_halves() -> tuple[Mesh, np.ndarray]:
    mesh = shapes.grid(12, 12)
    x, y = mesh.vertices[mesh.faces].mean(axis=1)[:, :2].T
    return mesh, (x + 0.2 * np.sin(20 * y) * (y > 0.1) * (y < 0.9) > 0.5).astype(np.int32)


def border_length(mesh: Mesh, label: np.ndarray) -> float:
    inner = label_cuts(mesh, label) & (mesh.topology.twin >= 0)
    return float(lengths(mesh, 1.0)[inner].sum()) / 2


def test_an_arc_becomes_the_shortest_between_its_ends():
    mesh, label = jagged_halves()
    feature = mesh.topology.twin < 0
    straight = straightened(mesh, label, feature, lengths(mesh, 1.0))
    assert border_length(mesh, label) > 1.5
    assert border_length(mesh, straight) < 1.2


def test_an_arc_along_a_feature_stays():
    mesh, label = jagged_halves()
    feature = label_cuts(mesh, label)
    assert np.array_equal(straightened(mesh, label, feature, lengths(mesh, 1.0)), label)


def test_the_nodes_of_a_short_arc_become_one():
    mesh = shapes.grid(20, 20)
    x, y = mesh.vertices[mesh.faces].mean(axis=1)[:, :2].T
    label = np.where(x < 0.5, y > 0.5, 2 + (y > 0.55)).astype(np.int32)
    feature, length = mesh.topology.twin < 0, lengths(mesh, 0.1)

    def inner_degrees(label):
        cut = label_cuts(mesh, label)
        degree = np.bincount(mesh.indices[cut], minlength=len(mesh.vertices))
        on_boundary = np.bincount(mesh.indices[feature], minlength=len(mesh.vertices)) > 0
        return sorted(degree[~on_boundary & (degree > 2)].tolist())

    assert inner_degrees(label) == [3, 3]
    assert inner_degrees(without_short_arcs(mesh, label, feature, length)) == [4]


def test_lengths_leave_out_the_zigzag():
    mesh = shapes.grid(20, 20)
    x, y = mesh.vertices[mesh.faces].mean(axis=1)[:, :2].T
    for label in (x > y, x > 1 - y):  # one of them runs against the diagonals
        length = lengths(mesh, 0.1)
        layout = disk_layout(mesh, label.astype(int), feature=None, length=length)
        inner = layout.cut & (mesh.topology.twin >= 0)
        assert layout.length[inner].sum() / 2 == pytest.approx(np.sqrt(2) / 0.1, rel=0.1)
        assert np.array_equal(layout.length[layout.feature], length[layout.feature])


def test_the_same_again():
    mesh = random_hull(300, 1)
    one, two = (vsa_layout(mesh, None, lengths(mesh, 0.1), patches=20, seed=3) for _ in range(2))
    assert np.array_equal(one.cut, two.cut)
    assert np.array_equal(one.length, two.length)


def test_what_does_not_fit_is_refused():
    mesh = shapes.grid(3, 3)
    label, length = np.zeros(len(mesh.faces), dtype=int), lengths(mesh, 1.0)
    with pytest.raises(InvalidInput, match="labels must have shape"):
        disk_layout(mesh, label[1:], feature=None, length=length)
    with pytest.raises(InvalidInput, match="feature must have shape"):
        disk_layout(mesh, label, feature=np.zeros(3, dtype=bool), length=length)
    with pytest.raises(InvalidInput, match="length must have shape"):
        disk_layout(mesh, label, feature=None, length=length[1:])
    with pytest.raises(InvalidInput, match="positive"):
        disk_layout(mesh, label, feature=None, length=0 * length)


@pytest.mark.parametrize(
    ("name", "patches", "sharp"),
    [
        ("cad-panel/fandisk.obj", 60, 40.0),
        ("cad-panel/hexme_s1.obj", 40, 40.0),
        ("cad-panel/featuretype.stl", 1, 40.0),
        ("cad-panel/f50_hood.obj", 1, np.inf),
        ("genus+/skull_lo.obj", 12, np.inf),
        ("cage/tetrahedron.off", 3, np.inf),
    ],
)
def test_a_real_mesh(name, patches, sharp):
    mesh = read(real(name))
    feature = Folds(mesh).angles >= sharp
    layout = vsa_layout(mesh, feature, lengths(mesh, 0.02 * mesh.diagonal), patches=patches)
    assert assert_layout(layout, mesh, feature) >= min(patches, len(mesh.faces)) / 2
