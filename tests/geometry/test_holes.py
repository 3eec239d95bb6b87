"""Closing boundary loops."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.geometry.holes import fill_holes
from henkei.shapes import grid, hemisphere


def sieve() -> hk.Mesh:
    """A square with three holes of different sizes."""
    mesh = grid(16, 16)
    cells = mesh.vertices[mesh.faces].reshape(-1, 6, 3).mean(axis=1)[:, :2]
    middle = np.repeat(cells, 2, axis=0)
    inside = np.zeros(len(middle), dtype=bool)
    for centre, radius in (((0.25, 0.25), 0.1), ((0.75, 0.3), 0.16), ((0.5, 0.8), 0.05)):
        inside |= (np.abs(middle - centre) < radius).all(axis=1)
    return hk.without_unused_vertices(hk.Mesh(mesh.vertices, mesh.faces[~inside]))


def test_all_loops_but_the_longest_are_closed():
    mesh = sieve()
    filled = fill_holes(mesh)
    assert len(mesh.topology.boundary_loops) == 4
    assert len(filled.topology.boundary_loops) == 1
    assert filled.topology.is_manifold
    assert len(filled.topology.misoriented_edges) == 0
    assert np.array_equal(filled.faces[: len(mesh.faces)], mesh.faces)
    assert np.array_equal(filled.vertices[: len(mesh.vertices)], mesh.vertices)
    assert len(filled.vertices) == len(mesh.vertices) + 3
    assert filled.face_areas.sum() == pytest.approx(1)
    assert (filled.face_normals[:, 2] > 0).all()


def test_the_named_loop_stays_open():
    mesh = sieve()
    loop = mesh.topology.boundary_loops[-1]
    filled = fill_holes(mesh, int(loop[1]))
    assert set(filled.topology.boundary_loops[0].tolist()) == set(loop.tolist())
    inside = np.setdiff1d(
        np.arange(len(mesh.vertices)), np.concatenate(mesh.topology.boundary_loops)
    )
    with pytest.raises(InvalidInput, match=f"vertex {inside[0]}"):
        fill_holes(mesh, int(inside[0]))


def test_one_loop_needs_no_filling():
    mesh = hemisphere(2)
    assert np.array_equal(fill_holes(mesh).faces, mesh.faces)
