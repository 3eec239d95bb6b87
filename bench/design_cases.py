"""What the benchmark of design refines, smooths and solves; for peers, as files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array, eye_array, save_npz

from henkei.design import Constraint, Designer
from henkei.design.literal import neighbour_means
from henkei.design.refinement import Connectivity, connectivity, refined, refined_positions
from henkei.design.smoothing import PASS_BAND, STEP
from henkei.mesh import Floats, Mesh, PolygonMesh, Surface
from henkei.shapes import head_cage, torus_cage

CAGES: dict[str, Callable[[], PolygonMesh]] = {
    "head": head_cage,  # 106 vertices
    "torus": lambda: torus_cage(16, 10),
    "even torus": lambda: torus_cage(16, 16),
    "half torus": lambda: torus_cage(16, 8),
}
OUTWARD = 1.05  # where constraints want their points, by where the cage has them


def cage(name: str, triangles: bool) -> Surface:
    """A cage of quads, or each of them in two triangles."""
    quads = CAGES[name]()
    if not triangles:
        return quads
    corners = quads.indices.reshape(-1, 4)
    halves = np.stack([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], axis=1)
    return Mesh(quads.vertices, halves.reshape(-1, 3))


def finest(surface: Surface, levels: int) -> tuple[Connectivity, Floats]:
    """The last level of a cage, its vertices where refinement has them."""
    faces, positions = connectivity(surface), surface.vertices
    quads = not isinstance(surface, Mesh)
    for _ in range(levels):
        positions, faces = refined_positions(faces, quads, positions), refined(faces, quads)
    return faces, positions


def constrain(designer: Designer, count: int) -> list[Constraint]:
    """Pin so many points, spread over faces and levels at random, above level 0."""
    random = np.random.default_rng(0)
    return [pin(designer, 1 + i % designer.levels, random) for i in range(count)]


def pin(designer: Designer, level: int, random: np.random.Generator) -> Constraint:
    """Pin a point in a face of a level."""
    flat = designer.flat(level)
    face = int(random.integers(flat.face_count))
    corners = flat.indices[flat.offsets[face] : flat.offsets[face + 1]]
    weights = random.dirichlet(np.ones(len(corners)))
    return designer.pin(level, (face, weights), OUTWARD * weights @ flat.vertices[corners])


def save_cage(path: Path, name: str, triangles: bool) -> None:
    """Vertices and faces of a cage."""
    surface = cage(name, triangles)
    faces = surface.indices.reshape(-1, 3 if triangles else 4)
    np.savez(path, vertices=surface.vertices, faces=faces)


def save_smoothing(
    path: Path, name: str, levels: int, triangles: bool, steps: int
) -> dict[str, int]:
    """A level, a little noisy, the matrix of its neighbours' means, and where steps of smoothing by
    it bring the vertices."""
    faces, positions = finest(cage(name, triangles), levels)
    random = np.random.default_rng(0)
    noisy = positions + 0.01 * random.standard_normal(positions.shape)
    means, wanted = neighbour_means(faces), noisy
    for factor in steps * (STEP, 1 / (PASS_BAND - 1 / STEP)):
        wanted = wanted + factor * (means @ wanted - wanted)
    np.savez(
        path,
        vertices=noisy,
        faces=faces.indices.reshape(-1, 3 if triangles else 4),
        start=means.indptr,
        indices=means.indices,
        values=means.data,
        wanted=wanted,
    )
    return {"vertices": faces.vertex_count, "faces": faces.face_count}


def save_fairing(path: Path, name: str, levels: int, triangles: bool, pins: int) -> dict[str, int]:
    """The matrix of ``|L x|^2`` over a level, L the umbrella Laplacian, with the vertices of the
    cage and so many others fixed."""
    faces, _ = finest(cage(name, triangles), levels)
    laplacian = csr_array(eye_array(faces.vertex_count) - neighbour_means(faces))
    fixed = np.arange(len(CAGES[name]().vertices))
    others = np.arange(len(fixed), faces.vertex_count)
    more = np.random.default_rng(0).choice(others, pins, replace=False)
    free = np.setdiff1d(others, more)
    columns = laplacian[:, free]
    matrix = (columns.T @ columns).tocsc()
    matrix.sort_indices()
    save_npz(path, matrix)
    return {"vertices": faces.vertex_count, "unknowns": len(free), "entries": int(matrix.nnz)}
