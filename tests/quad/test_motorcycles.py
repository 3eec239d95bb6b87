"""Motorcycle graphs: every patch a rectangle, the surface the same, and tracing in the plane."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bodies import bumpy, moved
from henkei import shapes
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Mesh
from henkei.quad.crossfield import cross_field
from henkei.quad.layout import Layout
from henkei.quad.motorcycles import _Traced, motorcycle_layout
from henkei.quad.seamless import SeamlessGradients, seamless_gradients
from oracles.homeomorphy import topology_of
from parts import subdivided_box
from topologies import (
    annulus,
    grid,
    handlebody,
    jittered,
    l_shaped,
    refined,
    scattered,
    sector,
    slit,
    torus,
    tube,
    without,
)  # fmt: skip

SURFACES = {
    "sphere": lambda: shapes.icosphere(3),
    "potato": lambda: bumpy(2, 0),
    "torus": lambda: torus(24, 14),
    "genus 2": lambda: refined(handlebody(2)),
    "genus 3": lambda: refined(handlebody(3), 1),
    "tube": lambda: tube(16, 6),
    "annulus": lambda: annulus(24, 5),
    "square": lambda: scattered(200, 0),
    "square with holes": lambda: refined(grid(7, 7, holes=((2, 2), (4, 4), (2, 5)))),
    "L": lambda: l_shaped(8),
    "slit": lambda: slit(8),
    "box": subdivided_box,
    "wedge": lambda: refined(sector(20), 2),
    "three quarters": lambda: refined(sector(300), 2),
    "sphere with two holes": lambda: without(shapes.icosphere(3), 0, 700),
}
WITH_CREASE = {
    "ends inside": [(x, 4) for x in range(3, 7)],
    "from the rim": [(x, 4) for x in range(5)],
    "across": [(x, 4) for x in range(9)],
    "bent": [(2, y) for y in range(2, 6)] + [(x, 5) for x in range(3, 7)],
    "closed": [(2, 2), (3, 2), (4, 2), (5, 2), (5, 3), (5, 4), (5, 5), (4, 5), (3, 5), (2, 5),
               (2, 4), (2, 3), (2, 2)],
}  # fmt: skip


def creases(mesh: Mesh, degrees: float = 40) -> np.ndarray:
    """Half-edges of the boundary and of folds."""
    twin, face = mesh.topology.twin, mesh.topology.face
    cosine = (mesh.face_normals[face] * mesh.face_normals[face[twin]]).sum(axis=1)
    return (twin < 0) | (cosine < np.cos(np.radians(degrees)))


def gradients_on(mesh: Mesh, feature: np.ndarray, size: float) -> SeamlessGradients:
    return seamless_gradients(cross_field(mesh, feature, size), size)


def with_crease(name: str) -> tuple[Mesh, np.ndarray]:
    """A sheet of 8 x 8 squares and a crease along some of its lines."""
    mesh = grid(8, 8, (8.0, 8.0), seed=1)
    number = {tuple(p): k for k, p in enumerate(np.rint(mesh.vertices[:, :2]).astype(int).tolist())}
    chain = [number[place] for place in WITH_CREASE[name]]
    wanted = {frozenset(edge) for edge in pairwise(chain)}
    ends = zip(mesh.indices.tolist(), mesh.topology.target.tolist(), strict=True)
    return mesh, np.array([frozenset(edge) in wanted for edge in ends]) | creases(mesh)


def rims(layout: Layout) -> dict[int, list[list[int]]]:
    """Closed walks of half-edges round each patch, the patch on the left."""
    mesh = layout.mesh
    patch = patches(layout)
    left = set(np.flatnonzero(layout.cut).tolist())
    found: dict[int, list[list[int]]] = defaultdict(list)
    while left:
        walk = [left.pop()]
        while (following := _after(layout, walk[-1])) != walk[0]:
            left.remove(following)
            walk.append(following)
        found[patch[walk[0] // 3]].append(walk)
    assert mesh.topology.component_count == 1
    return found


def _after(layout: Layout, h: int) -> int:
    """The cut half-edge that follows on the same rim."""
    following = h - h % 3 + (h + 1) % 3
    while not layout.cut[following]:
        twin = int(layout.mesh.topology.twin[following])
        following = twin - twin % 3 + (twin + 1) % 3
    return following


def patches(layout: Layout) -> list[int]:
    """Patch of each face."""
    twin, label = layout.mesh.topology.twin, [-1] * len(layout.mesh.faces)
    for first in range(len(label)):
        if label[first] >= 0:
            continue
        label[first], pending = first, [first]
        while pending:
            face = pending.pop()
            for h in range(3 * face, 3 * face + 3):
                if not layout.cut[h] and label[beside := int(twin[h]) // 3] < 0:
                    label[beside] = first
                    pending.append(beside)
    return label


def assert_disks(layout: Layout) -> None:
    """Cut open along all cuts, each patch has one rim and Euler number 1."""
    label, twin = patches(layout), layout.mesh.topology.twin
    walks = rims(layout)
    assert set(walks) == set(label)
    for patch, own in walks.items():
        assert len(own) == 1
        faces = [f for f, p in enumerate(label) if p == patch]
        uncut = sum(not layout.cut[h] for f in faces for h in range(3 * f, 3 * f + 3)) // 2
        corners: set[frozenset[int]] = set()
        for h in (h for f in faces for h in range(3 * f, 3 * f + 3)):
            around, g = [h], h
            while (
                not layout.cut[g]
                and (g := int(twin[g]) - int(twin[g]) % 3 + (int(twin[g]) + 1) % 3) != h
            ):
                around.append(g)
            g = h
            while not layout.cut[b := g - g % 3 + (g + 2) % 3] and (g := int(twin[b])) != h:
                around.append(g)
            corners.add(frozenset(around))
        assert len(corners) - (uncut + len(own[0])) + len(faces) == 1


def sides(layout: Layout, walk: list[int]) -> list[float]:
    """Lengths of the sides of a rim, from corner to corner."""
    turn = layout.turn[walk]
    first = int(np.argmax(turn == 1))
    order = np.roll(walk, -first)
    side = np.cumsum(np.roll(turn, -first)) - 1
    return np.bincount(side, layout.length[order], 4).tolist()


def assert_rectangles(layout: Layout, tolerance: float, merged: int = 0) -> None:
    """Four right angles each; opposite sides as long as each other. Where a track ran into one of
    its own direction, a patch has a cusp instead, and so has fewer sides."""
    assert (layout.turn[layout.cut] == 2).sum() == merged
    for own in rims(layout).values():
        turn = layout.turn[own[0]]
        assert turn.sum() == 4
        assert set(turn.tolist()) <= {0, 1, 2}
        if (turn == 2).any():
            continue
        a, b, c, d = sides(layout, own[0])
        assert abs(a - c) <= tolerance
        assert abs(b - d) <= tolerance
        assert min(a, b, c, d) > 0


def assert_same_surface(layout: Layout, mesh: Mesh, feature: np.ndarray) -> None:
    made = layout.mesh
    assert topology_of(made.faces) == topology_of(mesh.faces)
    np.testing.assert_array_equal(made.vertices[: len(mesh.vertices)], mesh.vertices)
    assert made.face_areas.min() > 0
    places, distance = ClosestPoints(mesh).query(made.vertices[made.faces].mean(axis=1))
    assert distance.max() < 1e-9 * mesh.diagonal
    covered = np.bincount(places.face, made.face_areas, len(mesh.faces))
    np.testing.assert_allclose(covered, mesh.face_areas, rtol=1e-6)
    same_way = (made.face_normals * mesh.face_normals[places.face]).sum(axis=1)
    np.testing.assert_allclose(same_way, 1, atol=1e-6)
    twin = made.topology.twin
    for table in (layout.cut, layout.feature):
        np.testing.assert_array_equal(table[twin >= 0], table[twin[twin >= 0]])
    assert not (layout.feature & ~layout.cut).any()
    assert (layout.feature | (twin >= 0)).all()
    assert lengths(made)[layout.feature].sum() == pytest.approx(lengths(mesh)[feature].sum())
    inner = twin >= 0
    np.testing.assert_allclose(layout.length[inner], layout.length[twin[inner]])
    assert (layout.length[layout.cut] > 0).all()


def lengths(mesh: Mesh) -> np.ndarray:
    edge = mesh.vertices[mesh.topology.target] - mesh.vertices[mesh.indices]
    return np.linalg.norm(edge, axis=1)


def traced_on(made: SeamlessGradients) -> _Traced:
    """The tracing of which ``motorcycle_layout`` makes the layout."""
    traced = _Traced.of(made, 0.0)
    traced.trace(traced.singular_starts(made))
    while len(starts := traced.starts_where_not_disks()):
        traced.trace(starts)
    return traced


def largest_step(made: SeamlessGradients) -> float:
    """Of one edge, in quads."""
    return float(np.linalg.norm(made.along, axis=1).max())


@pytest.mark.parametrize("name", SURFACES)
def test_patches_are_rectangles_on_the_same_surface(name):
    mesh = SURFACES[name]()
    feature = creases(mesh)
    made = gradients_on(mesh, feature, 0.2)
    traced = traced_on(made)
    layout = traced.layout()
    assert_disks(layout)
    assert_rectangles(layout, 2 * largest_step(made), traced.tables["merged"])
    assert_same_surface(layout, mesh, feature)


@pytest.mark.parametrize("name", WITH_CREASE)
def test_patches_keep_to_creases_that_are_given(name):
    mesh, feature = with_crease(name)
    made = gradients_on(mesh, feature, 1.0)
    layout = motorcycle_layout(made, meeting=0.0)
    assert_disks(layout)
    assert_rectangles(layout, 1e-6)
    assert_same_surface(layout, mesh, feature)


@pytest.mark.parametrize("name", SURFACES)
def test_where_tracks_meet_patches_are_still_disks_with_four_quarters(name):
    mesh = SURFACES[name]()
    feature = creases(mesh)
    layout = motorcycle_layout(gradients_on(mesh, feature, 0.4), meeting=0.5)
    assert_disks(layout)
    assert_same_surface(layout, mesh, feature)
    for own in rims(layout).values():
        assert layout.turn[own[0]].sum() == 4


@pytest.mark.parametrize("name", SURFACES)
def test_the_tables_of_the_tracing_stay_true(name):
    made = gradients_on(SURFACES[name](), creases(SURFACES[name]()), 0.3)
    tables = traced_on(made).tables
    mesh = Mesh(tables["vertices"], tables["faces"])
    twin = mesh.topology.twin
    np.testing.assert_array_equal(tables["twin"], twin)
    inner = np.flatnonzero(twin >= 0)
    matching = tables["matching"].astype(int)
    assert ((matching[inner] + matching[twin[inner]]) % 4 == 0).all()
    change = tables["change"] @ [1, 1j]
    np.testing.assert_allclose(change.reshape(-1, 3).sum(axis=1), 0, atol=1e-9)
    there = -change[twin[inner]] * 1j ** (-matching[inner])
    np.testing.assert_allclose(change[inner], there, atol=1e-9)
    track = tables["track"].astype(int)
    np.testing.assert_array_equal(track[inner] >= 0, track[twin[inner]] >= 0)
    both = inner[track[inner] >= 0]
    assert ((track[both] + matching[both] + 2 - track[twin[both]]) % 4 == 0).all()
    lined = tables["feature"] > 0
    along = change[lined] * 1j ** -track[lined]
    assert (along.real > 0).all()
    assert np.abs(along.imag).max(initial=0) < 1e-9


@pytest.mark.parametrize("shift", [0, 1, 2])
def test_the_same_coordinates_give_the_same_layout_whatever_else_was_done(shift):
    made = [gradients_on(bumpy(2, 1), creases(bumpy(2, 1)), 0.3) for _ in range(2)]
    a, b = (motorcycle_layout(m, meeting=shift / 4) for m in made)
    assert a.mesh.faces.tobytes() == b.mesh.faces.tobytes()
    assert a.mesh.vertices.tobytes() == b.mesh.vertices.tobytes()
    assert a.turn.tobytes() == b.turn.tobytes()


def test_a_bent_square_is_one_patch():
    flat = jittered(grid(10, 10), 0.02, 0)
    mesh = Mesh(flat.vertices + 0.1 * np.sin(3 * flat.vertices[:, [2, 2, 0]]), flat.faces)
    layout = motorcycle_layout(gradients_on(mesh, creases(mesh), 0.2), meeting=0.0)
    assert len(rims(layout)) == 1


def test_a_torus_without_singular_vertex_is_one_patch_or_a_few():
    mesh = torus(32, 20)
    layout = motorcycle_layout(gradients_on(mesh, creases(mesh), 0.3))
    assert 1 <= len(rims(layout)) <= 2
    assert layout.cut.any()


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_an_l_is_three_squares(turn):
    mesh = moved(jittered(l_shaped(8), 0.03, 1), turn=(0, 0, turn))
    layout = motorcycle_layout(gradients_on(mesh, creases(mesh), 0.125), meeting=0.0)
    found = [sides(layout, own[0]) for own in rims(layout).values()]
    np.testing.assert_allclose(found, [[4] * 4] * 3, atol=1e-6)


def tracks_in_the_plane(size: int, holes: list[tuple[int, int, int, int]]) -> list[int]:
    """Lengths of the tracks in a square [0, size]^2 with holes (left, right, bottom, top): two
    motorcycles leave each corner of a hole, all at unit speed, until a wall or an older track.

    By events in whole numbers: of all crossings of two tracks, the one that is reached last by the
    later rider ends it, earliest first. None if two come at the same time.
    """
    starts = []
    for a, b, c, d in holes:
        for x, dx in ((a, -1), (b, 1)):
            for y, dy in ((c, -1), (d, 1)):
                starts += [(x, y, dx, 0), (x, y, 0, dy)]
    reach = [_wall(size, holes, *start) for start in starts]
    events = []
    for i, (x, y, dx, _) in enumerate(starts):
        for j, (p, q, _, ey) in enumerate(starts):
            if dx == 0 or ey == 0:
                continue
            first, second = (p - x) * dx, (y - q) * ey  # times at which i and j cross
            if first > 0 and second > 0:
                events.append((max(first, second), min(first, second), i, j, first, second))
    for late, early, i, j, first, second in sorted(events):
        if first > reach[i] or second > reach[j]:
            continue
        assume(late != early)
        reach[i if first == late else j] = late
    return sorted(reach)


def _wall(size: int, holes: list[tuple[int, int, int, int]], x, y, dx, dy) -> int:
    """How far it is from a point to the next wall."""
    ends = [size - x if dx > 0 else x if dx else size - y if dy > 0 else y]
    for a, b, c, d in holes:
        if dx and c <= y <= d and ((a if dx > 0 else b) - x) * dx > 0:
            ends.append(((a if dx > 0 else b) - x) * dx)
        if dy and a <= x <= b and ((c if dy > 0 else d) - y) * dy > 0:
            ends.append(((c if dy > 0 else d) - y) * dy)
    return min(ends)


@settings(max_examples=12, deadline=None)
@given(data=st.data(), count=st.integers(1, 3), jitter=st.sampled_from([0.0, 0.2]))
def test_tracks_between_holes_of_a_square_are_those_of_the_plane(data, count, jitter):
    size = 4 * count + 3
    lines = [data.draw(st.permutations(range(1, size)))[: 2 * count] for _ in range(2)]
    # Holes on lines of their own, so that no two tracks are on one line.
    x, y = (np.sort(np.reshape(line, (-1, 2)), axis=1).tolist() for line in lines)
    holes = [(*a, *b) for a, b in zip(x, y, strict=True)]
    apart = [
        a[1] < b[0] or b[1] < a[0] or a[3] < b[2] or b[3] < a[2]
        for k, a in enumerate(holes)
        for b in holes[:k]
    ]
    assume(all(apart))
    expected = tracks_in_the_plane(size, holes)
    cells = tuple((i, j) for a, b, c, d in holes for i in range(a, b) for j in range(c, d))
    sheet = grid(size, size, (float(size), float(size)), holes=cells)
    mesh = jittered(sheet, jitter, 0)
    layout = motorcycle_layout(gradients_on(mesh, creases(mesh), 1.0), meeting=0.0)
    inner = layout.cut & ~layout.feature
    off = 1.0 * bool(jitter) * len(expected)  # a track may end beside its line
    assert layout.length[inner].sum() / 2 == pytest.approx(sum(expected), abs=off + 1e-6)
    # Each track that ends adds a patch, each hole takes one away.
    assert len(rims(layout)) == len(expected) + 1 - count
