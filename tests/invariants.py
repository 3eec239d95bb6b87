"""What every combined mesh and every registration must fulfil, said once."""

from __future__ import annotations

import numpy as np

import henkei as hk

TOLERANCE = 1e-9


def assert_combined(a: hk.Mesh, b: hk.Mesh, c: hk.CombinedMesh) -> None:
    """All guarantees of a combined mesh without filled holes."""
    topology = hk.Mesh(c.vertices_a, c.faces).topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert topology.component_count == 1
    assert len(topology.boundary_loops) == 1
    assert len(c.vertices_a) - len(c.edges) + len(c.faces) == 1 == topology.euler_characteristic
    assert len(topology.unused_vertices) == 0
    assert np.array_equal(np.unique(np.sort(c.edges, axis=1), axis=0), topology.edges)
    assert_upright(c.plane_vertices, c.faces)
    for mesh, vertices, own, on, face_on, edge_on in (
        (a, c.vertices_a, c.vertex_of_a, c.on_a, c.face_on_a, c.edge_on_a),
        (b, c.vertices_b, c.vertex_of_b, c.on_b, c.face_on_b, c.edge_on_b),
    ):
        assert_on_surface(mesh, vertices, on)
        assert np.abs(vertices[own] - mesh.vertices).max() <= TOLERANCE * mesh.diagonal
        assert len(np.unique(own)) == len(own)
        assert_area_kept(mesh, vertices, c.faces, face_on)
        assert_edges_are_chains(mesh, vertices, c.edges, edge_on, own)
    q = c.quality
    assert (q.vertices, q.edges, q.faces, q.euler) == (
        *map(len, (c.vertices_a, c.edges, c.faces)),
        1,
    )
    assert q.inverted == 0
    assert max(q.area_error_a, q.area_error_b, q.vertex_error_a, q.vertex_error_b) <= TOLERANCE


def assert_upright(points, faces) -> None:
    """All triangles strictly counter-clockwise, in exact integers of any size."""
    p, q, r = (points.astype(object)[faces[:, i]] for i in range(3))
    area = (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (r[:, 0] - p[:, 0]) * (q[:, 1] - p[:, 1])
    assert (area > 0).all()


def assert_on_surface(mesh, vertices, on) -> None:
    assert (on.face >= 0).all()
    assert (on.barycentric >= 0).all()
    assert np.allclose(on.barycentric.sum(axis=1), 1, atol=1e-12)
    points = np.einsum("nk,nki->ni", on.barycentric, mesh.vertices[mesh.faces[on.face]])
    assert np.abs(points - vertices).max() <= TOLERANCE * mesh.diagonal


def assert_area_kept(mesh, vertices, faces, face_on) -> None:
    """Each input face is covered exactly by the faces that say they lie in it."""
    parts = hk.Mesh(vertices, faces).face_areas
    covered = np.bincount(face_on, parts, len(mesh.faces))
    assert np.abs(covered - mesh.face_areas).max() <= TOLERANCE * mesh.face_areas.sum()


def assert_edges_are_chains(mesh, vertices, edges, edge_on, own) -> None:
    """The parts of each input edge form one path between its ends, as long as the edge."""
    parts = edge_on >= 0
    ends = mesh.topology.edges
    lengths = np.linalg.norm(np.diff(mesh.vertices[ends], axis=1)[:, 0], axis=1)
    steps = np.linalg.norm(np.diff(vertices[edges], axis=1)[:, 0], axis=1)
    reached = np.bincount(edge_on[parts], steps[parts], len(ends))
    assert np.abs(reached - lengths).max() <= TOLERANCE * mesh.diagonal
    visits = np.repeat(edge_on[parts].astype(np.int64), 2) * len(vertices) + edges[parts].ravel()
    keys, counts = np.unique(visits, return_counts=True)
    assert set(counts.tolist()) <= {1, 2}
    edge, node = np.divmod(keys[counts == 1], len(vertices))
    assert np.array_equal(edge, np.repeat(np.arange(len(ends)), 2))
    assert np.array_equal(np.sort(node.reshape(-1, 2), axis=1), np.sort(own[ends], axis=1))


def assert_disk(mesh: hk.Mesh) -> None:
    topology = mesh.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert len(topology.unused_vertices) == 0
    assert topology.component_count == 1
    assert len(topology.boundary_loops) == 1
    assert topology.euler_characteristic == 1
    assert mesh.face_areas.min() > 0


def assert_registered(
    r: hk.Registration, source: hk.Mesh, target: hk.Mesh, *, landmarks=(), whole: bool = True
) -> None:
    """All guarantees of a registration.

    landmarks : pairs (k, 2) of vertices, or (k, 2, 3) of a source vertex' point and a point on the
        target. whole : no vertex is bridged, as where the target is closed.
    """
    np.testing.assert_array_equal(r.faces, source.faces)
    np.testing.assert_array_equal(r.mesh.faces, source.faces)
    np.testing.assert_array_equal(r.correspondence.vertices_a, source.vertices)
    np.testing.assert_array_equal(r.target_faces, target.faces)
    assert r.target_vertices == len(target.vertices)
    assert r.mesh.vertices.shape == source.vertices.shape
    assert np.isfinite(r.mesh.vertices).all()
    used = np.zeros(len(source.vertices), dtype=bool)
    used[source.faces] = True
    assert_places(source, source.vertices, r.correspondence.on_a, used)
    placed = r.on_target.face >= 0
    assert_places(target, r.mesh.vertices, r.on_target, placed)
    assert not placed[~used].any()
    assert placed[used].all() or not whole
    assert_landmarks_met(r, source, target, landmarks)
    q = r.quality
    assert (q.vertices, q.faces) == (len(source.vertices), len(source.faces))
    assert q.inverted == 0
    assert q.bridged == np.count_nonzero(used & ~placed)
    assert q.landmark_error <= TOLERANCE
    assert 0 <= q.to_target_mean <= q.to_target_max <= TOLERANCE
    assert 0 <= q.to_source_mean <= q.to_source_max < 1
    assert q.flipped_fraction == q.flipped / len(source.faces)
    assert q.self_intersecting_fraction == q.self_intersecting / len(source.faces)


def assert_places(mesh: hk.Mesh, points, places, placed) -> None:
    """Where a point has a place on the mesh it is there; where it has none nothing is said."""
    np.testing.assert_array_equal(places.face >= 0, placed)
    assert (places.face < len(mesh.faces)).all()
    assert (places.barycentric[~placed] == 0).all()
    assert_on_surface(mesh, points[placed], places.taken(placed))


def assert_landmarks_met(r: hk.Registration, source: hk.Mesh, target: hk.Mesh, landmarks) -> None:
    """The vertices of the source that were landmarks are where their counterparts are."""
    pairs = np.asarray(landmarks)
    assert len(r.landmarks) == len(pairs)
    if not len(pairs):
        return
    if pairs.ndim == 2:
        np.testing.assert_array_equal(r.landmarks, pairs[:, 0])
        goals = target.vertices[pairs[:, 1]]
    else:
        from_points = np.abs(source.vertices[r.landmarks] - pairs[:, 0]).max()
        assert from_points <= TOLERANCE * source.diagonal
        goals = pairs[:, 1]
    assert np.abs(r.mesh.vertices[r.landmarks] - goals).max() <= TOLERANCE * target.diagonal
