"""What is taken for a surface, what is refused and how that is said; mended where that is safe."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy, moved, together, with_unused_vertices
from data import real
from henkei.errors import (
    DegenerateFaces,
    InvalidFile,
    InvalidInput,
    InvalidMesh,
    NotASphere,
    NotFinite,
    NotManifold,
    NotOriented,
)
from henkei.mesh import Mesh, PolygonMesh
from henkei.register.surfaces import Closed
from henkei.shapes import hemisphere, icosphere
from invariants import assert_registered
from triangulated_spheres import torus

BODY, BALL = bumpy(2, 0), icosphere(2)
NO_FACES = np.zeros((0, 3), dtype=np.int32)


def at(value: float) -> Mesh:
    vertices = BODY.vertices.copy()
    vertices[7, 1] = value
    return Mesh(vertices, BODY.faces)


def one_turned() -> Mesh:
    faces = BODY.faces.copy()
    faces[11] = faces[11, ::-1]
    return Mesh(BODY.vertices, faces)


def moebius(steps: int) -> Mesh:
    angle = 2 * np.pi * np.arange(steps) / steps
    rail = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    lift = 0.3 * np.stack([np.cos(angle / 2)] * 2 + [np.sin(angle / 2)], axis=1)
    faces = []
    for k in range(steps):
        a, b = k, k + steps
        c, d = (k + 1, k + 1 + steps) if k + 1 < steps else (steps, 0)
        faces += [[a, c, b], [c, d, b]]
    return Mesh(np.concatenate([rail - lift, rail + lift]), faces)


BAD = [
    pytest.param(torus(), NotASphere, "1 handle", id="handle"),
    pytest.param(together(BODY, moved(BODY, shift=(9, 0, 0))), NotASphere,
                 "2 separate pieces, of 320, 320 faces.*largest_component", id="two pieces"),
    pytest.param(at(np.nan), NotFinite, "1 vertex has NaN or infinite coordinates: 7", id="NaN"),
    pytest.param(at(np.inf), NotFinite, "coordinates: 7", id="infinite"),
    pytest.param(Mesh(BODY.vertices, NO_FACES), NotASphere, "no faces.*not a point cloud",
                 id="point cloud"),
    pytest.param(Mesh(np.zeros((0, 3)), NO_FACES), NotASphere, "no faces", id="empty"),
    pytest.param(moebius(12), NotOriented, "one-sided.*cut it open", id="Moebius strip"),
    pytest.param(one_turned(), NotOriented, "at 3 edges.*henkei.oriented", id="one face turned"),
    pytest.param(Mesh(BODY.vertices, np.concatenate([BODY.faces, BODY.faces[:1]])), NotManifold,
                 "more than two faces share 3 edges", id="face twice"),
    pytest.param(Mesh(np.vstack([BALL.vertices, [[4, 0, 0], [4, 1, 0]]]),
                      np.vstack([BALL.faces, [[0, 162, 163]]])), NotManifold,
                 "only in a point at 1 vertex: 0", id="touches in a point"),
    pytest.param(Mesh(BODY.vertices, np.vstack([BODY.faces, [[4, 4, 9]]])), DegenerateFaces, "",
                 id="face repeats a vertex"),
    pytest.param(moved(BODY, 0), InvalidMesh, "is 0 long.*scale it", id="all in one place"),
    pytest.param(moved(BODY, 1e-150), InvalidMesh, "scale it", id="too small"),
    pytest.param(moved(BODY, 1e150), InvalidMesh, "scale it", id="too large"),
]  # fmt: skip


@pytest.mark.parametrize(("mesh", "kind", "message"), BAD)
def test_unusable_surfaces(mesh, kind, message):
    with pytest.raises(kind, match=f"source: .*{message}"):
        hk.register(mesh, BODY)
    with pytest.raises(kind, match=f"target: .*{message}"):
        hk.register(BODY, mesh)
    with pytest.raises(kind, match=f"mediator: .*{message}"):
        hk.register(BODY, BODY, mediator=mesh)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("genus+/torus_oded.obj", NotASphere),
        ("genus+/kitten_19k.obj", NotASphere),
        ("genus+/boot.obj", NotASphere),
        ("nasty/bunny_trimesh.ply", NotManifold),
        ("nasty/chair_soup.obj", NotManifold),
        ("nasty/fan3.obj", NotManifold),
        ("nasty/hourglass_ico.obj", NotManifold),
        ("nasty/triple_vierbein.obj", NotManifold),
        ("nasty/featuretype_soup.ply", NotASphere),
        ("nasty/openscad_crash.obj", NotASphere),
        ("nasty/soup.stl", NotASphere),
        ("nasty/moebius.obj", NotOriented),
    ],
)
def test_unusable_real_surfaces(name, kind):
    mesh = hk.read(real(name))
    with pytest.raises(kind, match=r"^source: .*; "):
        hk.register(mesh, BODY)
    with pytest.raises(kind, match=r"^target: .*; "):
        hk.register(BODY, mesh)


@pytest.mark.parametrize("source", [None, 3, BODY.vertices, object()])
def test_what_is_no_mesh(source):
    with pytest.raises(InvalidInput, match="cannot make a mesh from"):
        hk.register(source, BODY)
    with pytest.raises(InvalidInput, match="cannot make a mesh from"):
        hk.register(BODY, source)


def test_a_file_that_is_not_there():
    with pytest.raises(InvalidFile, match=r"nowhere\.obj: there is no such file"):
        hk.register("nowhere.obj", BODY)


def test_a_closed_surface_is_taken_as_it_is():
    side = Closed.of("source", BODY)
    assert side.given is BODY
    assert not side.is_open
    np.testing.assert_array_equal(side.mesh.vertices, BODY.vertices)
    np.testing.assert_array_equal(side.mesh.faces, BODY.faces)
    np.testing.assert_array_equal(side.used, np.arange(len(BODY.vertices)))
    assert side.is_own(np.arange(len(BODY.faces))).all()


def test_an_open_surface_is_closed():
    half = hemisphere(2)
    side = Closed.of("source", half)
    assert side.is_open
    assert not side.mesh.topology.boundary_loops
    assert side.mesh.topology.euler_characteristic == 2
    count = len(half.faces)
    np.testing.assert_array_equal(side.mesh.faces[:count], half.faces)
    np.testing.assert_array_equal(side.mesh.vertices[: len(half.vertices)], half.vertices)
    own = side.is_own(np.arange(len(side.mesh.faces)))
    np.testing.assert_array_equal(np.flatnonzero(own), np.arange(count))


def test_unused_vertices_are_left_out():
    side = Closed.of("source", with_unused_vertices(BODY, [0, 51, 163]))
    np.testing.assert_array_equal(side.used, np.delete(np.arange(165), [0, 51, 163]))
    np.testing.assert_array_equal(side.mesh.vertices, BODY.vertices)
    np.testing.assert_array_equal(side.mesh.faces, BODY.faces)


def test_polygons_are_split():
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    side = Closed.of("source", PolygonMesh.from_faces(corners, quads))
    assert side.given.faces.shape == (12, 3)
    assert side.mesh.topology.euler_characteristic == 2


def test_one_inside_out_is_refused():
    """It would be mirrored; which of the two is wrong is said, and how to turn it."""
    inward = Mesh(BODY.vertices, BODY.faces[:, ::-1])
    with pytest.raises(NotOriented, match=r"the source look inward.*flipped\(\) turns them"):
        hk.register(inward, BALL)
    with pytest.raises(NotOriented, match=r"the target look inward.*flipped\(\) turns them"):
        hk.register(BALL, inward)
    assert_registered(hk.register(inward.flipped(), BALL), BODY, BALL)


def test_both_inside_out_is_alright():
    inward = [Mesh(mesh.vertices, mesh.faces[:, ::-1]) for mesh in (BODY, BALL)]
    result = hk.register(*inward)
    assert_registered(result, *inward)
    assert result.quality.to_source_mean < 0.01
