"""Combined meshes of disks made by code: all guarantees, degenerate cases, attributes, holes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.errors import (
    DegenerateFaces,
    HenkeiError,
    InvalidInput,
    NotADisk,
    NotFinite,
    NotManifold,
    NotOriented,
)
from henkei.shapes import grid, hemisphere, random_disk
from invariants import assert_combined, assert_upright


def spread_pairs(a: hk.Mesh, b: hk.Mesh, count: int, shift: float = 0.0) -> np.ndarray:
    """Pairs at equal steps along both loops, b's turned by a part of its length."""
    loops = [mesh.topology.boundary_loops[0] for mesh in (a, b)]
    steps = np.arange(count) / count
    places = [
        (np.floor((steps + turn) * len(loop)).astype(int)) % len(loop)
        for loop, turn in zip(loops, (0, shift), strict=True)
    ]
    return np.stack([loop[place] for loop, place in zip(loops, places, strict=True)], axis=1)


@settings(max_examples=100, deadline=None)
@given(
    seeds=st.tuples(st.integers(0, 10**6), st.integers(0, 10**6)),
    sizes=st.tuples(st.integers(12, 120), st.integers(12, 120)),
    count=st.integers(3, 6),
    shift=st.sampled_from([0.0, 0.25, 0.5]),
)
def test_random_disks(seeds, sizes, count, shift):
    a, b = (random_disk(seed, size) for seed, size in zip(seeds, sizes, strict=True))
    pairs = spread_pairs(a, b, count, shift)
    assert_combined(a, b, hk.combine(a, b, pairs))


@pytest.mark.parametrize("seed", range(12))
def test_plain_disks_need_neither_finer_grids_nor_other_weights(seed):
    """A kernel that contradicts itself would be hidden by the next attempt; here it shows."""
    quality = hk.combine(random_disk(seed, 90), hemisphere(3)).quality
    assert quality.bits == 30
    assert quality.weights_b == "cotangent"
    assert quality.weights_a in ("cotangent", "mean value")


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(12, 150), count=st.integers(3, 6))
def test_a_mesh_with_itself_is_itself(seed, size, count):
    a = random_disk(seed, size)
    c = hk.combine(a, a, spread_pairs(a, a, count))
    assert_combined(a, a, c)
    assert c.quality.crossings == 0
    assert np.array_equal(c.vertices_a, c.vertices_b)
    if c.quality.chords_a == 0:
        assert {tuple(sorted(f)) for f in c.faces.tolist()} == {
            tuple(sorted(f)) for f in a.faces.tolist()
        }


@pytest.mark.parametrize("turn", [1, 2, 3])
def test_a_grid_with_itself_turned_by_pairs(turn):
    """Every vertex of one falls on a vertex of the other, or nearly: rounding must not matter."""
    a = grid(8, 8)
    corners = [0, 8, 80, 72]
    c = hk.combine(a, a, np.stack([corners, np.roll(corners, -turn)], axis=1))
    assert_combined(a, a, c)


@pytest.mark.parametrize(("n", "m"), [(2, 4), (4, 6), (5, 7), (6, 6)])
def test_grids_on_grids(n, m):
    a, b = grid(n, n), grid(m, m)
    pairs = [(0, 0), (n, m), ((n + 1) ** 2 - 1, (m + 1) ** 2 - 1), (n * (n + 1), m * (m + 1))]
    assert_combined(a, b, hk.combine(a, b, pairs))


def test_one_triangle_with_another():
    a = hk.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    b = hk.Mesh([[0, 0, 1], [2, 0, 1], [0, 2, 3]], [[0, 1, 2]])
    c = hk.combine(a, b, [(0, 1), (1, 2), (2, 0)])
    assert_combined(a, b, c)
    assert len(c.faces) == 1


def test_one_triangle_with_a_fine_disk():
    a, b = hk.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), hemisphere(3)
    c = hk.combine(a, b, spread_pairs(a, b, 3))
    assert_combined(a, b, c)


def test_all_boundary_vertices_in_pairs():
    a, b = hemisphere(2), hemisphere(2)
    loop = a.topology.boundary_loops[0]
    assert_combined(a, b, hk.combine(a, b, np.stack([loop, np.roll(loop, 3)], axis=1)))


def test_a_long_tube_closed_at_its_far_end():
    """Harmonic maps crowd its far end at one point, by e^-length: finer grids, other weights."""
    tube = closed_tube(around=12, along=300, radius=1.0, length=150.0)
    c = hk.combine(tube, hemisphere(3), "auto")
    assert_combined(tube, hemisphere(3), c)
    assert c.quality.weights_a == "outward"


@pytest.mark.parametrize("turn", [0, 1, 5])
def test_long_tubes_over_each_other_turned(turn):
    """Vertices that should coincide are kept apart by rounding, in a crowd."""
    tube = closed_tube(around=12, along=60, radius=1.0, length=30.0)
    c = hk.combine(tube, tube, [(v, (v + turn) % 12) for v in range(12)])
    assert_combined(tube, tube, c)


def closed_tube(around: int, along: int, radius: float, length: float) -> hk.Mesh:
    turn = 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1) * radius
    rings = [np.c_[ring, np.full(around, length * i / along)] for i in range(along + 1)]
    vertices = np.vstack([*rings, [[0, 0, length + radius]]])
    i, j = (table.ravel() for table in np.mgrid[:along, :around])
    k = (j + 1) % around
    p, q, r, s = i * around + j, i * around + k, (i + 1) * around + k, (i + 1) * around + j
    last = along * around
    cap = [[last + n, last + (n + 1) % around, last + around] for n in range(around)]
    return hk.Mesh(vertices, np.vstack([np.c_[p, q, r], np.c_[p, r, s], cap]))


def test_sliver_triangles_and_tiny_boundary_edges():
    a = random_disk(3, 80)
    loop = a.topology.boundary_loops[0]
    vertices = a.vertices.copy()
    vertices[loop[1]] = vertices[loop[0]] + 1e-9 * (vertices[loop[1]] - vertices[loop[0]])
    inner = np.setdiff1d(np.arange(len(vertices)), loop)
    vertices[inner[0]] = vertices[a.faces[(a.faces == inner[0]).any(axis=1)][0]].mean(axis=0)
    sliver = hk.Mesh(vertices, a.faces)
    assert_combined(sliver, hemisphere(2), hk.combine(sliver, hemisphere(2), "auto"))


def test_faces_without_area():
    a = grid(4, 4)
    vertices = a.vertices.copy()
    vertices[12] = vertices[11]
    collapsed = hk.Mesh(vertices, a.faces)
    assert_combined(collapsed, hemisphere(2), hk.combine(collapsed, hemisphere(2)))


def test_scale_and_place_do_not_matter():
    a, b = random_disk(1, 60), random_disk(2, 60)
    pairs = spread_pairs(a, b, 4)
    near = hk.combine(a, b, pairs)
    far = hk.combine(hk.Mesh(a.vertices * 1e-6 + 5, a.faces), b, pairs)
    own = slice(len(a.vertices))
    drift = near.plane_vertices[own] - far.plane_vertices[own]
    assert np.abs(drift).max() <= 2**42
    assert_upright(far.plane_vertices, far.faces)


def test_the_same_input_gives_the_same_bytes():
    a, b = random_disk(4, 100), random_disk(5, 90)
    one, other = (hk.combine(a, b).to_arrays() for _ in range(2))
    assert one.keys() == other.keys()
    assert all(one[name].tobytes() == other[name].tobytes() for name in one)


def test_holes_are_filled_and_dropped_again():
    whole = grid(12, 12)
    centre = whole.vertices[whole.faces].mean(axis=1)
    hole = (np.abs(centre[:, :2] - 0.5) < 0.17).all(axis=1)
    ring = hk.without_unused_vertices(hk.Mesh(whole.vertices, whole.faces[~hole]))
    assert len(ring.topology.boundary_loops) == 2
    with pytest.raises(NotADisk, match=r"surface a: .*2 boundary loops.*--fill-holes"):
        hk.combine(ring, hemisphere(2))
    c = hk.combine(ring, hemisphere(2), fill_holes=True)
    assert c.quality.filled_a == 1
    assert c.quality.euler == 1
    assert (c.on_a.face == -1).any()
    assert (c.on_b.face >= 0).all()
    assert (c.on_a.face[c.vertex_of_a] >= 0).all()
    on_a = c.on_a.face >= 0
    points = np.einsum(
        "nk,nki->ni", c.on_a.barycentric[on_a], ring.vertices[ring.faces[c.on_a.face[on_a]]]
    )
    assert np.abs(points - c.vertices_a[on_a]).max() < 1e-12
    open_again = c.without_fill()
    surface = hk.Mesh(open_again.vertices_a, open_again.faces)
    assert len(surface.topology.boundary_loops) == 2
    assert surface.topology.genus == 0
    assert surface.face_areas.sum() == pytest.approx(ring.face_areas.sum(), rel=1e-12)
    assert (open_again.face_on_a >= 0).all()
    assert open_again.quality.euler == 0
    assert np.array_equal(
        np.unique(np.sort(open_again.edges, axis=1), axis=0), surface.topology.edges
    )
    assert np.abs(open_again.vertices_a[open_again.vertex_of_a] - ring.vertices).max() < 1e-12


def test_another_loop_may_stay_open():
    whole = grid(12, 12)
    centre = whole.vertices[whole.faces].mean(axis=1)
    hole = (np.abs(centre[:, :2] - 0.5) < 0.17).all(axis=1)
    ring = hk.without_unused_vertices(hk.Mesh(whole.vertices, whole.faces[~hole]))
    inner = int(min(ring.topology.boundary_loops, key=len)[0])
    c = hk.combine(ring, hemisphere(2), fill_holes=True, outer=(inner, None))
    opened = hk.Mesh(c.vertices_a, c.faces)
    assert len(opened.topology.boundary_loops[0]) < 100
    border = c.vertices_a[opened.topology.boundary_loops[0]]
    assert (np.abs(border[:, :2] - 0.5) < 0.2).all()
    with pytest.raises(InvalidInput, match="not on the boundary"):
        hk.combine(ring, hemisphere(2), fill_holes=True, outer=(10**6, None))


def test_attributes_ride_along():
    a, b = grid(6, 6), hemisphere(2)
    corner = np.repeat(np.arange(len(a.faces), dtype=float), 3)[:, None] * [1.0, -1.0]
    a = hk.Mesh(
        a.vertices,
        a.faces,
        attributes=hk.Attributes(
            vertex={"color": a.vertices.copy(), "label": np.arange(len(a.vertices))},
            corner={"uv": a.vertices[a.faces.ravel(), :2], "seam": corner},
            face={"part": np.arange(len(a.faces))},
        ),
    )
    c = hk.combine(a, b)
    carried = c.mesh_a.attributes
    assert np.abs(carried.vertex["color"] - c.vertices_a).max() < 1e-12
    assert np.abs(carried.corner["uv"] - c.vertices_a[c.faces.ravel(), :2]).max() < 1e-12
    assert np.array_equal(carried.face["part"], c.face_on_a)
    expected = np.repeat(c.face_on_a, 3)[:, None] * [1.0, -1.0]
    assert np.abs(carried.corner["seam"] - expected).max() < 1e-9
    assert np.array_equal(carried.vertex["label"][c.vertex_of_a], np.arange(len(a.vertices)))
    assert not hk.combine(a, b, attributes=False).mesh_a.attributes
    assert np.abs(c.at(0.3).vertices - (0.7 * c.vertices_a + 0.3 * c.vertices_b)).max() < 1e-12


def test_vertices_without_faces_are_left_out_and_counted():
    disk = hemisphere(2)
    loose = hk.Mesh(np.vstack([[[9, 9, 9]], disk.vertices]), disk.faces + 1)
    pairs = spread_pairs(disk, disk, 4)
    c = hk.combine(loose, disk, pairs + np.array([1, 0]))
    assert c.quality.unused_a == 1
    assert c.vertex_of_a[0] == -1
    assert np.array_equal(c.vertices_a[c.vertex_of_a[1:]], disk.vertices)
    assert np.array_equal(c.pairs - [1, 0], hk.combine(disk, disk, pairs).pairs)


def test_polygons_are_split_and_counted():
    x, y = (table.ravel() for table in np.meshgrid(np.arange(4.0), np.arange(4.0)))
    i, j = (table.ravel() for table in np.mgrid[:3, :3])
    corner = 4 * i + j
    quads = hk.PolygonMesh(
        np.c_[x, y, x * y], np.stack([corner, corner + 1, corner + 5, corner + 4], axis=1)
    )
    c = hk.combine(quads, hemisphere(1))
    assert c.quality.polygons_a == 9
    assert_combined(quads.triangulated(), hemisphere(1), c)


def test_alignment_moves_b_only():
    a, b = random_disk(1, 50), random_disk(1, 50)
    angle = np.radians(70)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    moved = hk.Mesh(3 * b.vertices @ turn.T + [4, 5, 6], b.faces)
    c = hk.combine(a, moved, spread_pairs(a, b, 4)).aligned()
    assert np.abs(c.vertices_a - c.vertices_b).max() < 1e-9
    assert np.array_equal(c.vertices_a[c.vertex_of_a], a.vertices)


def mobius() -> hk.Mesh:
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    edge = [
        np.stack(
            [
                (1 + side * np.cos(turn / 2)) * np.cos(turn),
                (1 + side * np.cos(turn / 2)) * np.sin(turn),
                side * np.sin(turn / 2),
            ],
            axis=1,
        )
        for side in (-0.3, 0.3)
    ]
    faces = []
    for i in range(24):
        p, q = i, 24 + i
        r, s = (i + 1, 25 + i) if i < 23 else (24, 0)
        faces += [[p, r, s], [p, s, q]]
    return hk.Mesh(np.vstack(edge), faces)


def bad_meshes():
    disk = hemisphere(2)
    sphere = hk.Mesh(
        [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]],
        [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]],
    )
    two = hk.Mesh(
        np.vstack([disk.vertices, disk.vertices + 3]),
        np.vstack([disk.faces, disk.faces + len(disk.vertices)]),
    )
    fin = hk.Mesh(
        np.vstack([disk.vertices, [[0, 0, 5]]]),
        np.vstack([disk.faces, [[*disk.faces[inner_face(disk), :2], len(disk.vertices)]]]),
    )
    turned = disk.faces.copy()
    turned[5] = turned[5, ::-1]
    hole = hk.Mesh(disk.vertices, np.delete(disk.faces, inner_face(disk), axis=0))
    broken = disk.vertices.copy()
    broken[7, 1] = np.nan
    repeated = disk.faces.copy()
    repeated[3, 1] = repeated[3, 0]
    return {
        "two loops": (hole, NotADisk, "2 boundary loops"),
        "closed": (sphere, NotADisk, "closed"),
        "moebius": (mobius(), NotOriented, "one-sided"),
        "non-manifold edge": (fin, NotManifold, "more than two faces share"),
        "two components": (two, NotADisk, "2 separate pieces"),
        "winding": (hk.Mesh(disk.vertices, turned), NotOriented, "wind against each other"),
        "nan": (hk.Mesh(broken, disk.faces), NotFinite, "NaN.*7"),
        "repeated vertex": (hk.Mesh(disk.vertices, repeated), DegenerateFaces, "repeats.*3"),
        "no faces": (hk.Mesh(disk.vertices, np.empty((0, 3), int)), NotADisk, "no faces"),
    }


def inner_face(mesh: hk.Mesh) -> int:
    inside = ~np.isin(mesh.faces, mesh.topology.boundary_loops[0]).any(axis=1)
    return int(np.flatnonzero(inside)[0])


@pytest.mark.parametrize("name", bad_meshes())
@pytest.mark.parametrize("side", ["a", "b"])
def test_each_bad_surface_has_its_own_error(name, side):
    mesh, error, says = bad_meshes()[name]
    good = hemisphere(2)
    inputs = (mesh, good) if side == "a" else (good, mesh)
    with pytest.raises(error, match=rf"surface {side}: .*{says}"):
        hk.combine(*inputs)


def test_a_handle_is_refused():
    turn = 2 * np.pi * np.arange(8) / 8
    u, v = (table.ravel() for table in np.meshgrid(turn, turn, indexing="ij"))
    vertices = np.stack(
        [(2 + np.cos(v)) * np.cos(u), (2 + np.cos(v)) * np.sin(u), np.sin(v)], axis=1
    )
    i, j = (table.ravel() for table in np.mgrid[:8, :8])
    p, q = i * 8 + j, (i + 1) % 8 * 8 + j
    r, s = (i + 1) % 8 * 8 + (j + 1) % 8, i * 8 + (j + 1) % 8
    torus = hk.Mesh(vertices, np.vstack([np.c_[p, q, r], np.c_[p, r, s]])[1:])
    with pytest.raises(NotADisk, match="handle"):
        hk.combine(torus, hemisphere(2))


def test_every_error_is_ours():
    with pytest.raises(HenkeiError):
        hk.combine(hemisphere(1), 7)


def test_progress_is_reported_and_can_cancel():
    reports = []
    hk.combine(
        hemisphere(2), hemisphere(1), progress=lambda text, part: reports.append((part, text))
    )
    assert reports == sorted(reports)
    assert reports[-1][0] == 1

    def cancel(text, part):
        if part > 0.3:
            raise hk.errors.Cancelled(text)

    with pytest.raises(hk.errors.Cancelled):
        hk.combine(hemisphere(2), hemisphere(1), progress=cancel)


def test_a_vertex_a_rounding_away_from_a_slanted_side():
    """On the coarsest grid the rounded side would pass on its wrong side."""
    turn = 2 * np.pi * np.arange(3) / 3
    corner = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    inward, along = -(corner[0] + corner[1]), (corner[1] - corner[0]) / np.sqrt(3)

    def on_side(part):
        return corner[0] * (1 - part) + corner[1] * part

    for part, height, shift in ((0.121, 0.52e-9, 5.17e-9), (0.718, 0.31e-9, 4.22e-9)):
        near = on_side(part + 0.005) + height * inward + shift * along
        middle = [on_side(part + 0.005), near, on_side(part), on_side(part + 0.01)]
        a = hk.Mesh(
            np.vstack([corner, middle]),
            [[5, 4, 2], [6, 1, 2], [3, 6, 4], [4, 6, 2], [5, 3, 4], [0, 5, 2]],
        )
        b = hk.Mesh(np.vstack([corner, middle[2:]]), [[0, 3, 2], [3, 4, 2], [4, 1, 2]])
        assert_combined(a, b, hk.combine(a, b, [(0, 0), (1, 1), (2, 2)]))


def test_weights_give_way_where_vertices_coincide():
    a = grid(4, 4)
    vertices = a.vertices.copy()
    vertices[7] = (vertices[6] + vertices[8]) / 2
    vertices[12] = vertices[13] = vertices[6]
    pinched = hk.Mesh(vertices, a.faces)
    c = hk.combine(pinched, a, [(0, 0), (4, 4), (24, 24), (20, 20)])
    assert_combined(pinched, a, c)
    assert c.quality.weights_a != "cotangent"


def test_a_nan_attribute_stays_at_its_vertex():
    a = grid(4, 4)
    values = np.arange(25.0)
    values[6] = np.nan
    c = hk.combine(hk.Mesh(a.vertices, a.faces, attributes=hk.Attributes({"v": values})), a)
    carried = c.mesh_a.attributes.vertex["v"][c.vertex_of_a]
    assert np.flatnonzero(np.isnan(carried)).tolist() == [6]


def test_landmarks_at_one_place_are_refused():
    tube = closed_tube(around=4, along=19, radius=1.0, length=19.0)
    top = len(tube.vertices) - 1
    other = hk.Mesh(tube.vertices * [1, 1, 1.1], tube.faces)
    with pytest.raises(HenkeiError):
        hk.combine(
            tube, other, [(i, i) for i in range(4)], landmarks=[(top, top), (top - 1, top - 1)]
        )
