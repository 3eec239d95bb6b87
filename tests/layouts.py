"""Small layouts made by code: patches on boxes, disks, tubes, rings, spheres, and T-meshes."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei import shapes
from henkei.mesh import Mesh
from henkei.quad.layout import Layout


def labelled(
    mesh: Mesh,
    label: np.ndarray,
    *,
    edge: float = 1.0,
    also: np.ndarray | None = None,
    sharp: float = 360.0,
) -> Layout:
    """Patches are the faces of one label; no corners chosen.

    edge : length of a wished quad edge. also : (3 m,) more half-edges to cut, either side.
    sharp : faces that meet at this angle or more between their normals (degrees) make a feature.
    """
    topology = mesh.topology
    twin, face = topology.twin, topology.face
    border = twin < 0
    across = np.where(border, face, face[twin])
    tilt = np.einsum("hi,hi->h", mesh.face_normals[face], mesh.face_normals[across])
    feature = border | (tilt <= np.cos(np.radians(sharp)) if sharp <= 180 else False)
    cut = feature | (label[face] != label[across])
    if also is not None:
        cut |= also | np.where(border, False, also[twin])
    start, end = mesh.vertices[topology.indices], mesh.vertices[topology.target]
    return Layout(mesh, cut, feature, np.linalg.norm(end - start, axis=1) / edge)


def with_turns(layout: Layout, corners: np.ndarray | None = None) -> Layout:
    """The layout with the quarter turns that are nearest to the angles of its patches.

    corners : (m, 3, d) places of the corners of each face in which angles are measured; in space
        where not given.
    """
    mesh = layout.mesh
    places = mesh.vertices[mesh.faces] if corners is None else corners
    to_next, to_previous = np.roll(places, -1, axis=1) - places, np.roll(places, 1, axis=1) - places
    cosine = (to_next * to_previous).sum(axis=2)
    cosine /= np.linalg.norm(to_next, axis=2) * np.linalg.norm(to_previous, axis=2)
    angle = np.arccos(np.clip(cosine, -1, 1)).ravel()
    turn = np.zeros(len(layout.cut), dtype=np.int8)
    for h in np.flatnonzero(layout.cut).tolist():
        turn[h] = np.rint(2 - sum(angle[sector(layout, h)]) / (np.pi / 2))
    return dataclasses.replace(layout, turn=turn)


def sector(layout: Layout, h: int) -> list[int]:
    """Corners of faces, as half-edges, between the cut half-edge ``h`` and the next cut to its
    left, round the vertex where it starts."""
    corners, topology = [h], layout.mesh.topology
    while not layout.cut[back := corners[-1] - corners[-1] % 3 + (corners[-1] + 2) % 3]:
        corners.append(int(topology.twin[back]))
    return corners


def cube(cells: int = 4, edge: float = 0.25) -> Layout:
    """The surface of a unit cube; its sides are the patches, its edges are features."""
    mesh = shapes.bar(1.0, 1.0, cells, cells)
    side = np.unique(np.rint(mesh.face_normals), axis=0, return_inverse=True)[1].ravel()
    return with_turns(labelled(mesh, side, edge=edge, sharp=45))


def disk(corners: int = 4, rings: int = 5, edge: float = 0.2) -> Layout:
    """A regular polygon of outer radius 1 as one patch; turns at its corners."""
    points, faces = [np.zeros((1, 2))], []
    for ring in range(1, rings + 1):
        side, step = np.divmod(np.arange(corners * ring), ring)
        at, towards = 2 * np.pi * side / corners, 2 * np.pi * (side + 1) / corners
        share = (step / ring)[:, None]
        point = np.column_stack([np.cos(at), np.sin(at)]) * (1 - share)
        points.append(
            ring / rings * (point + np.column_stack([np.cos(towards), np.sin(towards)]) * share)
        )
        inner, outer = 1 + corners * ring * (ring - 1) // 2, 1 + corners * ring * (ring + 1) // 2
        here = outer - corners * ring + np.arange(corners * ring)
        following = np.roll(here, -1)
        before = inner - corners * (ring - 1) if ring > 1 else 0
        count = max(corners * (ring - 1), 1)
        low = before + (side * (ring - 1) + step) % count
        faces.append(np.column_stack([low, here, following]))
        inside = step < ring - 1
        second = before + (side * (ring - 1) + step + 1) % count
        faces.append(np.column_stack([low, following, second])[inside])
    xy = np.concatenate(points)
    mesh = Mesh(np.column_stack([xy, np.zeros(len(xy))]), np.concatenate(faces))
    return with_turns(labelled(mesh, np.zeros(len(mesh.faces), dtype=int), edge=edge))


def sheet(label: np.ndarray, wrap: tuple[bool, bool] = (False, False), edge: float = 1.0) -> Layout:
    """A grid of unit squares whose patches are the squares ``(i, j)`` of one ``label`` (r, s).

    wrap : whether the sheet closes to a tube in its first, in its second direction (a ring if in
        both); the line where it closes is cut. Turns as in the flat sheet.
    """
    rows, columns = label.shape
    i, j = (axis.ravel() for axis in np.indices(label.shape))
    square = np.stack([(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]).transpose(2, 0, 1)
    flat = square[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 2)
    high = rows if wrap[0] else rows + 1
    wide = columns if wrap[1] else columns + 1
    faces = flat[..., 0] % high * wide + flat[..., 1] % wide
    at = np.stack(np.divmod(np.arange(high * wide), wide), axis=1).astype(float)
    mesh = Mesh(_rolled(at, label.shape, wrap), faces)
    end = np.roll(flat, -1, axis=1)
    seam = np.zeros(flat.shape[:2], dtype=bool)
    for axis in range(2):
        if wrap[axis]:
            seam |= (flat[..., axis] == 0) & (end[..., axis] == 0)
    layout = labelled(mesh, np.repeat(label.ravel(), 2), also=seam.ravel())
    length = np.linalg.norm(end - flat, axis=2).ravel() / edge
    return with_turns(dataclasses.replace(layout, length=length), flat.astype(float))


def _rolled(at: np.ndarray, size: tuple[int, ...], wrap: tuple[bool, bool]) -> np.ndarray:
    row, column = at.T
    if not any(wrap):
        return np.column_stack([row, column, 0 * row])
    if not wrap[0]:
        row, column, size = column, row, size[::-1]
    angle, radius = 2 * np.pi * row / size[0], size[0] / (2 * np.pi)
    if not all(wrap):
        points = [radius * np.cos(angle), radius * np.sin(angle), column]
        return np.column_stack(points if wrap[0] else [points[1], points[0], points[2]])
    around = 2 * np.pi * column / size[1]
    away = 2 * radius + radius * np.cos(angle)
    return np.column_stack([away * np.cos(around), away * np.sin(around), -radius * np.sin(angle)])


def tube(around: int = 8, along: int = 6, edge: float = 1.0) -> Layout:
    """An open tube as one rectangle, cut once along its axis."""
    return sheet(np.zeros((around, along), dtype=int), wrap=(True, False), edge=edge)


def torus(around: int = 8, along: int = 12, edge: float = 1.0) -> Layout:
    """A torus as one rectangle that touches itself on all its sides."""
    return sheet(np.zeros((around, along), dtype=int), wrap=(True, True), edge=edge)


def rectangles(size: int, seed: int, fewest: int = 2) -> np.ndarray:
    """Labels (size, size) of random rectangles: cut through, or by pinwheels, again and again."""
    label = np.zeros((size, size), dtype=int)
    rng = np.random.default_rng(seed)

    def divide(low: np.ndarray, high: np.ndarray) -> None:
        label[low[0] : high[0], low[1] : high[1]] = label.max() + 1
        extent = high - low
        if extent.max() <= fewest or (extent.max() < size and rng.random() < 0.15):
            return
        if extent.min() >= 3 and rng.random() < 0.4:
            _pinwheel(low, high, rng, divide)
            return
        axis = int(extent.argmax()) if extent.min() < 2 else int(rng.integers(2))
        middle = int(rng.integers(low[axis] + 1, high[axis]))
        divide(low, np.where(np.arange(2) == axis, middle, high))
        divide(np.where(np.arange(2) == axis, middle, low), high)

    divide(np.zeros(2, dtype=int), np.full(2, size))
    return label


def _pinwheel(low: np.ndarray, high: np.ndarray, rng: np.random.Generator, divide) -> None:
    (a, b), (d, e) = low, high
    left, right = np.sort(rng.choice(np.arange(a + 1, d), 2, replace=False))
    bottom, top = np.sort(rng.choice(np.arange(b + 1, e), 2, replace=False))
    boxes = [
        ((a, b), (right, bottom)),
        ((right, b), (d, top)),
        ((left, top), (d, e)),
        ((a, bottom), (left, e)),
        ((left, bottom), (right, top)),
    ]
    for start, end in boxes:
        divide(np.array(start), np.array(end))


def t_mesh(size: int = 12, seed: int = 0, wrap: tuple[bool, bool] = (False, False)) -> Layout:
    """Random rectangles on a square sheet, a tube or a ring, with T-junctions."""
    return sheet(rectangles(size, seed), wrap)


def sphere(
    patches: int = 12, seed: int = 0, level: int = 3, edge: float = 0.15, rough: float = 0.05
) -> Layout:
    """A unit sphere in about so many random patches, all of them disks; no corners chosen."""
    mesh = shapes.icosphere(level)
    rng = np.random.default_rng(seed)
    seeds = mesh.vertices[rng.choice(len(mesh.vertices), patches, replace=False)]
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    label = np.argmax(centre @ seeds.T + rough * rng.random((len(centre), patches)), axis=1)
    return labelled(mesh, with_disks(mesh, label), edge=edge)


def with_disks(mesh: Mesh, label: np.ndarray) -> np.ndarray:
    """Labels of which each is a disk, on a closed surface of genus 0: each patch is one connected
    piece and takes all but the largest of the pieces that it separates."""
    twin, face = mesh.topology.twin, mesh.topology.face
    label = _pieces(face, face[twin], label[face] == label[face[twin]], len(mesh.faces))
    for patch in range(label.max() + 1):
        rest = label != patch
        outer = _pieces(face, face[twin], rest[face] & rest[face[twin]], len(mesh.faces))
        largest = np.bincount(outer[rest]).argmax() if rest.any() else 0
        if np.any(label == patch):
            label = np.where(rest & (outer == largest), label, patch)
    return np.unique(label, return_inverse=True)[1].ravel()


def _pieces(start: np.ndarray, end: np.ndarray, joined: np.ndarray, count: int) -> np.ndarray:
    links = (np.ones(joined.sum()), (start[joined], end[joined]))
    return connected_components(coo_array(links, shape=(count, count)), directed=False)[1]
