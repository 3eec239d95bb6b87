"""All nodes of a model when the surface moves: interior, mid-side and hanging nodes follow.

Interior nodes of solids solve a Laplace problem whose elements are the stiffer the smaller they
are, so that thin layers are carried along rather than squashed: K. Stein, T. Tezduyar, R. Benney,
"Mesh moving techniques for fluid-structure interactions with large displacements", J. Appl. Mech.
70 (2003). The rotation and the affine map nearest to the motion of each piece are taken out first,
so that these are reproduced exactly.
"""

from __future__ import annotations

import warnings

import numpy as np
import scipy.sparse as sparse
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from henkei.errors import InvalidInput, NotFinite, some
from henkei.geometry.element_quality import scaled_jacobians
from henkei.io.cells import KINDS
from henkei.io.model import Block, Model
from henkei.mesh import Floats
from henkei.solve.factor import factor_spd

Rows = NDArray[np.int64]
Matrix = sparse.csr_array
STEPS = (1, 8)  # in which the surface moves, until no element is turned inside out
FLAT = 1e-6  # a tetrahedron's volume is taken for at least this part of its longest edge cubed
SHORT = 1e-9  # a link's length is taken for at least this part of the model's size
PRIOR = 1e-6  # weight of the piece's rotation where the edges at a node leave theirs open
TURNED = 1e-9  # a rotation matrix this far from the unit matrix has turned

# Each solid as two sets of tetrahedra that split every quad along both of its diagonals: their
# mean is the same from both sides of a face, whichever elements lie there.
TETRAHEDRA: dict[int, tuple[tuple[tuple[int, int, int, int], ...], ...]] = {
    4: (((0, 1, 2, 3),),) * 2,
    5: (((0, 1, 2, 4), (0, 2, 3, 4)), ((0, 1, 3, 4), (1, 2, 3, 4))),
    6: (
        ((0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)),
        ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)),
    ),
    8: (
        ((0, 1, 3, 4), (1, 2, 3, 6), (1, 4, 5, 6), (3, 4, 6, 7), (1, 3, 4, 6)),
        ((0, 1, 2, 5), (0, 2, 3, 7), (0, 4, 5, 7), (2, 5, 6, 7), (0, 2, 5, 7)),
    ),
}


def moved(model: Model, positions: ArrayLike, *, rotations: ArrayLike | None = None) -> Floats:
    """Positions of all nodes when the vertices of the surface move.

    - Interior nodes of solids follow by interpolation, in several steps where one would turn an
      element inside out; a warning names what is turned all the same.
    - Mid-side nodes stay in the middle of their edge, with the offset that they had from there,
      turned with the edge; where no end of the edge moves or turns they do not move.
    - Nodes that only beams, springs or rigid elements join to the rest follow the rotation and
      translation nearest to that of the nodes that hold them (with the rotation of the surface
      there, where these leave it open, such as about the line on which they stand), and what is
      left over linearly along the links. A piece whose holding nodes neither move nor turn stays
      where it is.
    - Nodes in no element, such as reference points, and those that constraints alone hold
      (couplings, ties) stay.

    Parameters
    ----------
    positions : (n, 3) of ``model.surface.vertices``.
    rotations : (n, 3, 3) rotation of each vertex, such as :attr:`henkei.Deformer.rotations`, for
        the offset of mid-side nodes and for what hangs on the surface; fitted to the edges around
        each corner if not given. Fitted ones do not see a turn that moves no vertex.

    Returns
    -------
    (N, 3) float64, in the order of ``model.nodes``.

    Raises
    ------
    InvalidInput : wrong shapes.
    NotFinite : a position is NaN or infinite.
    """
    target = np.asarray(positions, dtype=np.float64)
    if target.shape != model.surface.vertices.shape:
        raise InvalidInput(
            f"positions have shape {target.shape}, the surface has "
            f"{len(model.surface.vertices)} vertices"
        )
    bad = np.flatnonzero(~np.isfinite(target).all(axis=1))
    if len(bad):
        raise NotFinite(f"NaN or infinite positions of vertices {some(bad)}")
    nodes = model.nodes.copy()
    nodes[model.surface_nodes] = target
    known = np.zeros(len(nodes), dtype=bool)
    known[model.surface_nodes] = True
    solids = [block for block in model.blocks if block.dimension == 3]
    _move_interior(model, solids, nodes, known)
    for block in solids:
        known[block.corners] = True
    for block in model.blocks:
        if block.dimension == 2:  # shells inside solids, and collapsed ones
            known[block.corners[known[block.corners].any(axis=1)]] = True
    given = None if rotations is None else _checked_rotations(model, rotations)
    stirred = (nodes != model.nodes).any(axis=1)
    if given is not None:
        turned = np.abs(given - np.eye(3)).max(axis=(1, 2), initial=0.0) > TURNED
        stirred[model.surface_nodes] |= turned
    _move_middles(model, nodes, known, stirred, given)
    stirred |= (nodes != model.nodes).any(axis=1)
    _move_hanging(model, nodes, known, stirred, given)
    return nodes


def _checked_rotations(model: Model, rotations: ArrayLike) -> Floats:
    given = np.asarray(rotations, dtype=np.float64)
    if given.shape != (len(model.surface_nodes), 3, 3):
        raise InvalidInput(
            f"rotations have shape {given.shape}, one (3, 3) matrix a vertex is needed"
        )
    return given


def _move_interior(model: Model, solids: list[Block], nodes: Floats, known: Rows) -> None:
    """Place the inner corners of solids, piece by piece, where the surface moved."""
    if not solids:
        return
    tetrahedra = [_tetrahedra(block.corners) for block in solids]
    cells = np.concatenate([cell for cell, _ in tetrahedra])
    inside = np.zeros(len(nodes), dtype=bool)
    inside[cells] = True
    piece = _pieces(len(nodes), cells)
    shift = nodes - model.nodes
    stirred = np.unique(piece[inside & known & (shift != 0).any(axis=1)])
    moving = inside & np.isin(piece, stirred)
    free = moving & ~known
    if not free.any():
        _warn_of_turned(solids, model.nodes, nodes)
        return
    cells = cells[moving[cells[:, 0]]]
    carried = nodes.copy()
    for number in stirred.tolist():
        held = np.flatnonzero((piece == number) & inside & known)
        own = np.flatnonzero((piece == number) & inside)
        carried[own] = _carried(model.nodes[held], nodes[held], model.nodes[own])
    for steps in STEPS:
        found = _in_steps(model.nodes, carried, nodes, cells, free, steps)
        if steps == STEPS[-1] or not len(_turned(solids, model.nodes, found)):
            break
    nodes[free] = found[free]
    _warn_of_turned(solids, model.nodes, nodes)


def _in_steps(
    rest: Floats, carried: Floats, target: Floats, cells: Rows, free: Rows, steps: int
) -> Floats:
    """Interior nodes, with what the carried ones lack of the target brought in step by step."""
    now = carried.copy()
    fixed = ~free
    lack = (target - carried)[fixed]
    weighed = rest  # the first step weighs elements as they were
    for _ in range(steps):
        matrix = _stiffness(weighed, cells)
        inner = matrix[free][:, free]
        step = np.zeros_like(now)
        step[fixed] = lack / steps
        step[free] = factor_spd(inner).solve(-(matrix[free][:, fixed] @ step[fixed]))
        now += step
        weighed = now
    return now


def _tetrahedra(corners: Rows) -> tuple[Rows, int]:
    """Both splittings of solids, one after the other."""
    splits = TETRAHEDRA[corners.shape[1]]
    rows = [corners[:, tetra] for split in splits for tetra in split]
    return np.concatenate(rows), len(rows)


def _stiffness(nodes: Floats, cells: Rows) -> Matrix:
    """Laplace matrix of linear tetrahedra, each divided by its volume."""
    points = nodes[cells]
    edges = points[:, 1:] - points[:, :1]
    longest = np.sqrt((edges**2).sum(axis=2).max(axis=1))
    distinct = (longest > 0) & (np.sort(cells, axis=1)[:, 1:] != np.sort(cells)[:, :-1]).all(axis=1)
    cells, points, longest = cells[distinct], points[distinct], longest[distinct]
    a, b, c, d = np.moveaxis(points / longest[:, None, None], 1, 0)
    areas = np.stack(
        [
            np.cross(d - b, c - b),
            np.cross(c - a, d - a),
            np.cross(d - a, b - a),
            np.cross(b - a, c - a),
        ],
        axis=1,
    )
    six_volumes = np.abs(np.einsum("ij,ij->i", areas[:, 3], d - a))
    size = np.maximum(six_volumes, 6 * FLAT)
    local = np.einsum("fik,fjk->fij", areas, areas) / (size**2 * longest**2)[:, None, None]
    scale = np.median(np.trace(local, axis1=1, axis2=2)) if len(local) else 1.0
    rows = np.repeat(cells, 4, axis=1).ravel()
    columns = np.tile(cells, (1, 4)).ravel()
    matrix = sparse.coo_array((local.ravel() / scale, (rows, columns)), shape=(len(nodes),) * 2)
    return matrix.tocsr()


def _pieces(count: int, cells: Rows) -> Rows:
    """Number of the connected piece of each node."""
    rows = np.repeat(cells[:, 0], cells.shape[1] - 1)
    graph = sparse.coo_array((np.ones(len(rows)), (rows, cells[:, 1:].ravel())), (count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _carried(before: Floats, after: Floats, points: Floats) -> Floats:
    """The points under the rotation nearest to a motion, and then the nearest affine map."""
    rotation, start, end = _nearest_rotation(before, after)
    turned = (before - start) @ rotation.T
    rest = after - end - turned
    affine = np.linalg.pinv(turned, rcond=1e-6) @ rest
    if np.linalg.det(np.eye(3) + affine) <= 0:
        affine = np.zeros((3, 3))
    local = (points - start) @ rotation.T
    carried: Floats = end + local + local @ affine
    return carried


def _nearest_rotation(
    before: Floats, after: Floats, prior: Floats | None = None
) -> tuple[Floats, Floats, Floats]:
    """Rotation and both centres of the rigid motion nearest to ``before -> after``; near to the
    prior one (none, if not given) where the points leave it open."""
    start, end = before.mean(axis=0), after.mean(axis=0)
    covariance = (after - end).T @ (before - start)
    size = np.trace(np.abs(covariance)) or 1.0
    open_to = np.eye(3) if prior is None else prior
    return _rotation(covariance[None] + PRIOR * size * open_to)[0], start, end


def _rotation(covariance: Floats) -> Floats:
    """The rotations nearest to matrices ``(n, 3, 3)``."""
    u, _, vt = np.linalg.svd(covariance)
    u[..., -1] *= np.sign(np.linalg.det(u @ vt))[:, None]
    rotation: Floats = u @ vt
    return rotation


def _move_middles(
    model: Model, nodes: Floats, known: Rows, stirred: Rows, rotations: Floats | None
) -> None:
    """Place mid-side nodes whose corners are known."""
    found = _middles(model.blocks, known)
    if not found:
        return
    turn = _turns(model, nodes, rotations)
    for middle, corners in found:
        fresh = ~known[middle]
        middle, corners = middle[fresh], corners[fresh]
        offset = model.nodes[middle] - model.nodes[corners].mean(axis=1)
        moving = stirred[corners].any(axis=1)
        middle, corners, offset = middle[moving], corners[moving], offset[moving]
        rotation = _rotation(turn[corners].mean(axis=1))
        nodes[middle] = nodes[corners].mean(axis=1) + np.einsum("nij,nj->ni", rotation, offset)
    for middle, _ in found:
        known[middle] = True


def _middles(blocks: tuple[Block, ...], known: Rows) -> list[tuple[Rows, Rows]]:
    """Mid-side nodes with the corners around them, edges before faces."""
    found = []
    for block in blocks:
        if block.kind not in KINDS or block.dimension == 1:
            continue
        kind = KINDS[block.kind]
        for number, around in enumerate(kind.between, start=kind.corners):
            middle, corners = block.nodes[:, number], block.nodes[:, around]
            there = (middle >= 0) & known[corners].all(axis=1) & ~known[middle]
            if there.any():
                found.append((middle[there], corners[there]))
    return sorted(found, key=lambda pair: pair[1].shape[1])


def _turns(model: Model, nodes: Floats, rotations: Floats | None) -> Floats:
    """Rotation at every node: as given, or nearest to that of the edges around it."""
    edges = _edges(model.blocks)
    held = np.unique(edges)
    whole = np.eye(3)
    if len(held):
        whole = _nearest_rotation(model.nodes[held], nodes[held])[0]
    before = model.nodes[edges[:, 1]] - model.nodes[edges[:, 0]]
    after = nodes[edges[:, 1]] - nodes[edges[:, 0]]
    products = np.einsum("ei,ej->eij", after, before).reshape(-1, 9)
    covariance = np.zeros((len(nodes), 9))
    size = np.zeros(len(nodes))
    for side in (0, 1):
        for k in range(9):
            covariance[:, k] += np.bincount(edges[:, side], products[:, k], len(nodes))
        size += np.bincount(edges[:, side], (before**2).sum(axis=1), len(nodes))
    turn = np.broadcast_to(whole, (len(nodes), 3, 3)).copy()
    matrices = covariance[held].reshape(-1, 3, 3) + PRIOR * size[held, None, None] * whole
    turn[held] = _rotation(matrices)
    if rotations is not None:
        turn[model.surface_nodes] = rotations
    return turn


def _edges(blocks: tuple[Block, ...]) -> Rows:
    """Pairs of corners next to each other in shells and solids, each once."""
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for block in blocks:
        if block.dimension == 1:
            continue
        rings = (
            KINDS[block.kind].faces if block.dimension == 3 else (range(block.corners.shape[1]),)
        )
        for ring in rings:
            corners = block.corners[:, list(ring)]
            following = np.roll(corners, -1, axis=1)
            pairs.append(np.stack([corners.ravel(), following.ravel()], axis=1))
    edges = np.sort(np.concatenate(pairs), axis=1)
    return np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)


def _move_hanging(
    model: Model, nodes: Floats, known: Rows, stirred: Rows, rotations: Floats | None
) -> None:
    """Place nodes that only beams, springs and rigid elements hold."""
    links = model.links[~known[model.links].all(axis=1)]
    if not len(links):
        return
    turn = _turns(model, nodes, rotations)
    loose = np.zeros(len(nodes), dtype=bool)
    loose[links] = True
    loose &= ~known
    piece = np.full(len(nodes), -1)
    among = links[loose[links].all(axis=1)]
    number = _pieces(len(nodes), among)
    piece[loose] = number[loose]
    holding = links[known[links].any(axis=1)]
    holder = np.where(known[holding[:, 0]], holding[:, 0], holding[:, 1])
    held = piece[np.where(known[holding[:, 0]], holding[:, 1], holding[:, 0])]
    size = float(np.ptp(model.nodes, axis=0).max())
    order = np.argsort(held, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(held[order])) + 1):
        if len(rows) and stirred[holder[rows]].any():
            own = np.flatnonzero(piece == held[rows[0]])
            holders = np.unique(holder[rows])
            prior = _rotation(turn[holders].mean(axis=0)[None])[0]
            rigid = _nearest_rotation(model.nodes[holders], nodes[holders], prior)
            _follow(model.nodes, nodes, own, holders, links, rigid, SHORT * size)


def _follow(
    rest: Floats,
    nodes: Floats,
    own: Rows,
    holders: Rows,
    links: Rows,
    rigid_motion: tuple[Floats, Floats, Floats],
    shortest: float,
) -> None:
    """Place a piece that hangs on nodes which have moved."""
    rotation, start, end = rigid_motion
    around = np.concatenate([own, holders])
    place = np.full(len(rest), -1)
    place[around] = np.arange(len(around))
    rows = place[links[(place[links] >= 0).all(axis=1)]]
    rows = rows[(rows < len(own)).any(axis=1)]
    points = rest[around]
    lengths = np.linalg.norm(points[rows[:, 0]] - points[rows[:, 1]], axis=1)
    weights = 1 / np.maximum(lengths, shortest)
    weights /= weights.max()
    graph = sparse.coo_array((weights, (rows[:, 0], rows[:, 1])), (len(around),) * 2).tocsr()
    graph = graph + graph.T
    matrix = (sparse.diags_array(graph.sum(axis=1)) - graph).tocsr()
    rigid = end + (points - start) @ rotation.T
    lack = nodes[holders] - rigid[len(own) :]
    free, fixed = slice(0, len(own)), slice(len(own), None)
    solved = factor_spd(matrix[free, free]).solve(-(matrix[free, fixed] @ lack))
    nodes[own] = rigid[free] + solved


def _turned(solids: list[Block], before: Floats, after: Floats) -> Rows:
    """Numbers that the file gives the solids which the motion turned inside out."""
    found = []
    for block in solids:
        sound = scaled_jacobians(before, block.corners)
        found.append(block.ids[(sound > 0) & (scaled_jacobians(after, block.corners) <= 0)])
    return np.concatenate([np.empty(0, dtype=np.int64), *found])


def _warn_of_turned(solids: list[Block], before: Floats, after: Floats) -> None:
    turned = _turned(solids, before, after)
    if len(turned):
        warnings.warn(
            f"the motion turns {len(turned)} solid elements inside out: {some(turned)}; "
            "move less, or mesh again",
            stacklevel=3,
        )
