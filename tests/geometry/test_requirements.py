"""Each way in which a mesh falls short raises its own error, which says where and what to do."""

from __future__ import annotations

import numpy as np
import pytest

from henkei import errors
from henkei.geometry.requirements import (
    require_disk,
    require_finite,
    require_manifold,
    require_oriented,
)
from henkei.mesh import Mesh, PolygonMesh

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
QUADS = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)


def cube(*faces: int) -> Mesh:
    """The cube's sides of the given numbers, in triangles; all eight vertices."""
    return PolygonMesh(CUBE, QUADS[list(faces)]).triangulated()


def torus_with_hole() -> Mesh:
    i, j = (grid.ravel() for grid in np.indices((4, 4)))
    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    quads = np.stack([a % 4 * 4 + b % 4 for a, b in corners], axis=1)
    u, v = np.pi / 2 * i, np.pi / 2 * j
    ring = 2 + np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), np.sin(v)], axis=1)
    return PolygonMesh(vertices, quads[1:]).triangulated()


STRIP = Mesh(CUBE[:4], [[0, 1, 3], [0, 3, 2]])
OPEN_BOX = cube(0, 1, 2, 3, 4)
THREE_PAGES = Mesh(CUBE[:5], [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
HOURGLASS = Mesh(CUBE[:5], [[0, 1, 2], [0, 3, 4]])
TWO_HOURGLASSES = Mesh(  # two tetrahedra that share one vertex
    np.vstack([CUBE[:4], CUBE[5:]]),
    [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 4, 5], [0, 5, 6], [0, 6, 4], [4, 6, 5]],
)
MOEBIUS = Mesh(CUBE[:5], [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]])


@pytest.mark.parametrize("disk", [STRIP, OPEN_BOX, Mesh(CUBE[:3], [[0, 1, 2]])])
def test_disks_pass(disk):
    require_disk(disk)


@pytest.mark.parametrize(
    ("mesh", "error", "says"),
    [
        (Mesh(CUBE, []), errors.NotADisk, "no faces"),
        (
            Mesh([[0, 0, np.inf], *CUBE[1:3]], [[0, 1, 2]]),
            errors.NotFinite,
            "1 vertex has NaN or infinite coordinates: 0;",
        ),
        (
            Mesh(CUBE, [[0, 1, 2], [1, 3, 3]]),
            errors.DegenerateFaces,
            r"1 face repeats a vertex: 1; .*without_degenerate_faces",
        ),
        (THREE_PAGES, errors.NotManifold, r"share 1 edge \(between vertices 0-1\)"),
        (HOURGLASS, errors.NotManifold, "only in a point at 1 vertex: 0;"),
        (TWO_HOURGLASSES, errors.NotManifold, "only in a point at 1 vertex: 0;"),
        (
            Mesh(CUBE[:4], [[0, 1, 3], [0, 2, 3]]),
            errors.NotOriented,
            r"at 1 edge \(between vertices 0-3\); henkei.oriented",
        ),
        (MOEBIUS, errors.NotOriented, "one-sided"),
        (
            Mesh(CUBE, [[0, 1, 2], [4, 5, 6], [6, 5, 7]]),
            errors.NotADisk,
            "2 separate pieces, of 2, 1 faces; henkei.largest_component",
        ),
        (
            Mesh(np.vstack([CUBE[:4], CUBE[:4]]), [[0, 1, 3], [4, 7, 6]]),
            errors.NotADisk,
            "weld the 4 duplicate vertices first: henkei.weld",
        ),
        (Mesh(CUBE * 1e200, [[0, 1, 3]]), errors.InvalidMesh, "cannot be measured"),
        (Mesh(CUBE * 1e-200, [[0, 1, 3]]), errors.InvalidMesh, "cannot be measured"),
        (Mesh(CUBE + 1e15, [[0, 1, 3]]), errors.InvalidMesh, "1e.15 from the origin"),
        (cube(0, 1, 2, 3, 4, 5), errors.NotADisk, "closed, it has no boundary"),
        (
            cube(0, 1, 2, 3),
            errors.NotADisk,
            r"2 boundary loops, of length 4 \(4 vertices\), 4 \(4 .* 1 loop with --fill-holes",
        ),
        (torus_with_hole(), errors.NotADisk, r"1 handle \(genus 1\)"),
    ],
)
def test_what_is_no_disk_is_told_why(mesh, error, says):
    with pytest.raises(error, match=says) as caught:
        require_disk(mesh)
    assert type(caught.value) is error


def test_weaker_requirements_ask_for_less():
    require_oriented(PolygonMesh(CUBE, QUADS))
    require_manifold(MOEBIUS)
    require_manifold(Mesh([[0, 0, np.nan], *CUBE[1:3]], [[0, 1, 2]]))
    require_finite(THREE_PAGES)
    with pytest.raises(errors.NotOriented):
        require_oriented(MOEBIUS)
    with pytest.raises(errors.NotManifold):
        require_manifold(THREE_PAGES)


def test_huge_coordinates_are_finite():
    require_finite(Mesh(np.full((3, 3), 1e308), []))
