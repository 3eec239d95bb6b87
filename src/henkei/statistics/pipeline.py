"""From shapes to a model of them: align, find the mean, find the modes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidInput
from henkei.geometry.connectivity import SharedConnectivity, shared
from henkei.progress import Progress, silent
from henkei.statistics.modes import principal_modes
from henkei.statistics.procrustes import area_weights, procrustes
from henkei.statistics.shape_model import ShapeModel

Weights = Literal["area", "equal"]


def shape_model(
    shapes: Sequence[Any],
    *,
    scale: bool = True,
    weights: Weights | ArrayLike = "area",
    names: Sequence[str] | None = None,
    progress: Progress = silent,
) -> ShapeModel:
    """Align shapes over one connectivity and find their mean and modes.

    Generalised Procrustes analysis (:func:`procrustes`) takes place and pose out, and with
    ``scale`` size; principal component analysis finds the modes. Nothing is mirrored: a shape whose
    left is the others' right is far from the mean (``quality.farthest``).

    Parameters
    ----------
    shapes : at least two registrations, meshes, or what :meth:`henkei.Mesh.from_any` takes, all
        over the same vertices and faces.
    scale : whether size is taken out; it stays in ``centroid_sizes``.
    weights : of the vertices: ``"area"``, so that the result does not depend on where the mesh is
        fine; ``"equal"``; or (n,) numbers.
    names : of the shapes, for messages and tables.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    InvalidInput : fewer than two shapes, different connectivity (the message says where), unusable
        weights, or a shape without size.
    NotFinite : a coordinate is NaN or infinite.
    NotConverged : the shapes have nothing in common.
    """
    progress("aligning", 0.0)
    return model_of(shared(shapes, names), scale=scale, weights=weights, progress=progress)


def model_of(
    shapes: SharedConnectivity,
    *,
    scale: bool = True,
    weights: Weights | ArrayLike = "area",
    progress: Progress = silent,
) -> ShapeModel:
    """:func:`shape_model` of shapes that are known to share their connectivity."""
    if len(shapes) < 2:
        raise InvalidInput(f"{shapes.names[0]} is the only shape; how shapes vary takes two")
    moved = procrustes(shapes.vertices, scale, _weights(weights, shapes))
    progress("finding modes", 0.5)
    found = principal_modes(moved.aligned, moved.weights)
    variances = found.deviations**2
    progress("modes found", 1.0)
    return ShapeModel(
        shapes.faces,
        found.mean,
        found.fields,
        variances,
        found.scores,
        np.einsum("p,pni,pni->n", variances, found.fields, found.fields),
        float(variances.sum()),
        np.zeros(len(shapes)),
        moved.weights,
        shapes.names,
        moved.centroid_sizes,
        float(moved.centroid_sizes.mean()) if scale else 0.0,
        moved.rounds,
        shapes.lasting,
    )


def _weights(weights: Weights | ArrayLike, shapes: SharedConnectivity) -> ArrayLike | None:
    if isinstance(weights, str):
        if weights == "area":
            return area_weights(shapes.vertices, shapes.faces)
        if weights == "equal":
            return None
        raise InvalidInput(f"weights are 'area', 'equal' or numbers, not {weights!r}")
    return weights
