"""Components taken apart and their quads joined: every number right in the whole."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from bodies import bumpy, together, with_unused_vertices
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import points_on
from henkei.mesh import Attributes, Mesh
from henkei.quad.components import Quads, components, joined
from topologies import cube, grid, torus


def shuffled(mesh: Mesh, seed: int) -> Mesh:
    rng = np.random.default_rng(seed)
    name = rng.permutation(len(mesh.vertices))
    return Mesh(mesh.vertices[name], np.argsort(name)[rng.permutation(mesh.faces)])


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 4))
def test_components_are_the_pieces_in_the_order_of_their_first_faces(seed, count):
    pieces = [bumpy(1, 0), grid(3, 2), cube(), torus(5, 4)][:count]
    mesh = with_unused_vertices(shuffled(together(*pieces), seed), [0, 5])
    found = components(mesh)
    assert len(found) == count
    assert sorted(np.concatenate([c.faces for c in found]).tolist()) == list(range(len(mesh.faces)))
    firsts = [int(c.faces.min()) for c in found]
    assert firsts == sorted(firsts)
    for one in found:
        np.testing.assert_array_equal(one.mesh.vertices, mesh.vertices[one.vertices])
        np.testing.assert_array_equal(one.vertices[one.mesh.faces], mesh.faces[one.faces])
        assert one.mesh.topology.component_count == 1
        assert not len(one.mesh.topology.unused_vertices)


def quads_on(mesh: Mesh, seed: int, way: str) -> Quads:
    """Numbers that look like quads of a mesh: places at random, each with what tells it apart."""
    rng = np.random.default_rng(seed)
    count, faces = 8 + seed % 5, 5 + seed % 3
    face = rng.integers(0, len(mesh.faces), count).astype(np.int32)
    places = SurfacePoints(face, rng.dirichlet([1, 1, 1], count))
    patch = np.arange(len(mesh.faces)) % 2
    layout = Mesh(
        mesh.vertices,
        mesh.faces,
        attributes=Attributes(
            corner={"uv": rng.random((3 * len(mesh.faces), 2))}, face={"patch": patch}
        ),
    )
    return Quads(
        points_on(mesh, places),
        rng.permuted(np.tile(np.arange(count), (faces, 1)), axis=1)[:, :4].astype(np.int32),
        (np.arange(faces) % 2).astype(np.int32),
        rng.random((faces, 4, 2)),
        places,
        rng.integers(0, count, (3, 2)).astype(np.int32),
        layout,
        way,
        bool(seed % 2),
    )


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 4))
def test_joined_quads_say_the_same_of_the_whole_as_of_their_parts(seed, count):
    mesh = shuffled(together(*[bumpy(1, 0), grid(3, 2), cube(), torus(5, 4)][:count]), seed)
    parts = components(mesh)
    made = [quads_on(p.mesh, seed + k, "field") for k, p in enumerate(parts)]
    whole = joined(parts, made)
    np.testing.assert_allclose(points_on(mesh, whole.on_surface), whole.vertices, atol=1e-12)
    corners = np.concatenate([q.vertices[q.faces] for q in made])
    np.testing.assert_array_equal(whole.vertices[whole.faces], corners)
    ends = np.concatenate([q.vertices[q.features] for q in made])
    np.testing.assert_array_equal(whole.vertices[whole.features], ends)
    np.testing.assert_array_equal(whole.uv, np.concatenate([q.uv for q in made]))
    layout = whole.layout
    corners = np.concatenate([q.layout.vertices[q.layout.faces] for q in made])
    np.testing.assert_array_equal(layout.vertices[layout.faces], corners)
    uv = np.concatenate([q.layout.attributes.corner["uv"] for q in made])
    np.testing.assert_array_equal(layout.attributes.corner["uv"], uv)
    # Patches: two of each part, numbered through, alike for quads and layout.
    assert np.unique(whole.patch).tolist() == list(range(2 * count))
    owner = np.repeat(np.arange(count), [len(q.faces) for q in made])
    np.testing.assert_array_equal(whole.patch // 2, owner)
    owner = np.repeat(np.arange(count), [len(q.layout.faces) for q in made])
    np.testing.assert_array_equal(layout.attributes.face["patch"] // 2, owner)


def test_the_way_is_that_of_most_quads():
    parts = components(together(cube(), cube(), cube()))
    made = [quads_on(p.mesh, 3, way) for p, way in zip(parts, ["field", "vsa", "vsa"], strict=True)]
    assert joined(parts, made).way == "vsa"
