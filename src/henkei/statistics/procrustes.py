"""Generalised Procrustes analysis: what differs between shapes once place, size and pose do not.

J. C. Gower, "Generalized Procrustes analysis", Psychometrika 40, 1975; F. J. Rohlf and D. Slice,
"Extensions of the Procrustes method for the optimal superimposition of landmarks", Systematic
Zoology 39, 1990. Shapes are brought to one centroid and one centroid size, then turned onto their
mean again and again (partial Procrustes superimposition). Mirroring is never used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidInput, NotConverged, NotFinite, some
from henkei.geometry.alignment import Similarity
from henkei.geometry.rotations import best_rotations
from henkei.mesh import Floats

TOLERANCE = 1e-12  # largest change of a rotation matrix's entry at which the shapes are at rest
ROUNDS = 1000
NO_SIZE = 1e-12  # centroid size, relative to the coordinates, that is only rounding


@dataclass(frozen=True, eq=False)
class Procrustes:
    """Shapes moved onto each other.

    aligned : (k, n, 3) the shapes, moved; unit of the first shape.
    mean : (n, 3) their mean, with the first shape's centroid and pose.
    centroid_sizes : (k,) of the shapes as given: the root of the sum over the vertices of the
        weighted squared distance from the centroid.
    similarities : k motions that took the shapes there.
    weights : (n,) of the vertices, with sum n.
    rounds : how often the shapes were turned onto their mean.
    """

    aligned: Floats
    mean: Floats
    centroid_sizes: Floats
    similarities: tuple[Similarity, ...]
    weights: Floats
    rounds: int

    @property
    def distances(self) -> Floats:
        """(k,) weighted root mean square distance of each shape's vertices from the mean's."""
        squares = ((self.aligned - self.mean) ** 2).sum(axis=2) @ self.weights
        distances: Floats = np.sqrt(squares / self.weights.sum())
        return distances

    @property
    def residual(self) -> float:
        """Root mean square of :attr:`distances`."""
        return float(np.sqrt(np.mean(self.distances**2)))


def procrustes(
    shapes: ArrayLike, scale: bool = True, weights: ArrayLike | None = None
) -> Procrustes:
    """Move shapes onto each other so that they are nearest to their mean.

    The first shape keeps its centroid and its pose. With ``scale`` all get one centroid size, the
    mean of theirs; without, shapes keep their sizes and only move rigidly. The result is a
    stationary point of the sum of squared distances from the mean, found from the poses nearest to
    the first shape.

    Parameters
    ----------
    shapes : (k, n, 3) corresponding points, k and n at least 1.
    scale : whether size is taken out as well.
    weights : (n,) of the vertices, not negative, not all zero; equal by default. Areas keep dense
        regions of a mesh from counting more, see :func:`area_weights`.

    Raises
    ------
    InvalidInput : other shapes of the arrays, unusable weights, or all points of a shape in one
        place where sizes are needed.
    NotFinite : a coordinate is NaN or infinite.
    NotConverged : the shapes do not come to rest, which takes shapes that have nothing in common.
    """
    points = checked_shapes(shapes)
    w = checked_weights(weights, points.shape[1])
    centroids = np.einsum("n,knj->kj", w, points) / w.sum()
    centred = points - centroids[:, None]
    sizes = centroid_sizes(centred, w)
    factors = np.ones(len(points))
    if scale:
        small = np.flatnonzero(sizes <= NO_SIZE * (1e-300 + np.abs(points).max(axis=(1, 2))))
        if len(small):
            raise InvalidInput(
                f"shapes {some(small)} have all vertices in one place and so no size; drop them, "
                "or keep sizes as they are (scale=False)"
            )
        factors = sizes.mean() / sizes
    centred *= factors[:, None, None]
    rotations, rounds = mutual_rotations(products(centred, w))
    aligned = np.einsum("kij,knj->kni", rotations, centred) + centroids[0]
    similarities = tuple(
        Similarity(rotation, float(factor), centroids[0] - factor * (rotation @ centroid))
        for rotation, factor, centroid in zip(rotations, factors, centroids, strict=True)
    )
    return Procrustes(aligned, aligned.mean(axis=0), sizes, similarities, w, rounds)


def products(centred: Floats, weights: Floats) -> Floats:
    """(k, 3, k, 3): of each axis of each shape with each axis of each shape, over the vertices."""
    count = len(centred)
    columns = (np.sqrt(weights)[:, None] * centred).transpose(1, 0, 2).reshape(-1, 3 * count)
    found: Floats = (columns.T @ columns).reshape(count, 3, count, 3)
    return found


def mutual_rotations(products: Floats) -> tuple[Floats, int]:
    """Rotations (k, 3, 3) of shapes onto their mean, the first's the identity; and the rounds.

    The mean is linear in the rotations, so all that a round needs are the shapes' products with
    each other, however many vertices there are.

    Raises
    ------
    NotConverged : after :data:`ROUNDS` rounds.
    """
    count = len(products)
    table = products.reshape(3 * count, 3 * count)
    rotations = best_rotations(products[0].transpose(1, 0, 2))
    for done in range(1, ROUNDS + 1):
        onto = rotations.transpose(1, 0, 2).reshape(3, -1) @ table  # k times the mean, by each axis
        turned = best_rotations(onto.reshape(3, count, 3).transpose(1, 0, 2))
        change = float(np.abs(turned - rotations).max())
        rotations = turned
        if change <= TOLERANCE:
            return rotations[0].T @ rotations, done
    raise NotConverged(
        f"after {ROUNDS} rounds shapes still turn by {change:.1e}: they have too little in common "
        "for a pose; align them first, or leave out those that differ most"
    )


def area_weights(shapes: Floats, faces: ArrayLike) -> Floats:
    """(n,) share of each vertex in the area, mean over the shapes, with sum n.

    A vertex has a third of the faces around it; each shape counts by its own whole. Statistics with
    these weights depend on the surfaces, not on where their mesh is fine.

    Raises
    ------
    InvalidInput : no shape has an area.
    """
    corners = np.asarray(faces)
    total = np.zeros(shapes.shape[1])
    for vertices in shapes:
        p, q, r = (vertices[corners[:, k]] for k in range(3))
        areas = np.linalg.norm(np.cross(q - p, r - p), axis=1) / 2
        whole = areas.sum()
        if whole > 0:
            total += np.bincount(corners.ravel(), np.repeat(areas / whole, 3), len(total))
    if not total.any():
        raise InvalidInput("the shapes have no area to weigh vertices by; weigh them equally")
    weights: Floats = total * (len(total) / total.sum())
    return weights


def centroid_sizes(centred: Floats, weights: Floats) -> Floats:
    """(k,) of shapes (k, n, 3) about the origin."""
    sizes: Floats = np.sqrt((centred * centred).sum(axis=2) @ weights)
    return sizes


def checked_shapes(shapes: ArrayLike) -> Floats:
    """The shapes as an array (k, n, 3).

    Raises
    ------
    InvalidInput : another shape.
    NotFinite : a coordinate is NaN or infinite.
    """
    try:
        points = np.asarray(shapes, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(
            "shapes must be numbers (k, n, 3): all shapes need the same number of vertices"
        ) from None
    if points.ndim != 3 or points.shape[2] != 3 or not points.size:
        raise InvalidInput(f"shapes must be (k, n, 3) with k, n > 0; these are {points.shape}")
    bad = np.argwhere(~np.isfinite(points).all(axis=2))
    if len(bad):
        shape = bad[0, 0]
        rows = bad[bad[:, 0] == shape, 1]
        raise NotFinite(f"shape {shape}: vertices {some(rows)} are NaN or infinite")
    return points


def checked_weights(weights: ArrayLike | None, count: int) -> Floats:
    """The weights (n,) brought to sum n.

    Raises
    ------
    InvalidInput : another shape, or negative, not finite or all zero.
    """
    w = np.ones(count) if weights is None else np.asarray(weights, dtype=np.float64)
    if w.shape != (count,):
        raise InvalidInput(f"weights must have shape ({count},), these have {w.shape}")
    bad = np.flatnonzero(~(np.isfinite(w) & (w >= 0)))
    if len(bad):
        raise InvalidInput(f"weights must be finite and not negative; see vertices {some(bad)}")
    if not w.any():
        raise InvalidInput("weights must not all be zero")
    w = w / w.max()  # so that the sum is finite
    scaled: Floats = w * (count / w.sum())
    return scaled
