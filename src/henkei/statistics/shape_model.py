"""A model of shapes over one connectivity: their mean, and the modes in which they vary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry.connectivity import shared
from henkei.geometry.rotations import best_rotations
from henkei.io.scene import Scene, Slide
from henkei.mesh import Attributes, Floats, Mesh
from henkei.progress import Progress, silent
from henkei.showing import Showing
from henkei.statistics import curves
from henkei.statistics.colors import ramp
from henkei.statistics.curves import Curve
from henkei.statistics.procrustes import centroid_sizes
from henkei.topology import Ints

SAMPLES = 1000  # random shapes that tell the specificity
MOST_SLIDES = 5  # modes that can be tried in a view
MOST_NUMBERS = 3_000_000  # of all of them
SEEN = 0.005  # share of the variance from which on a mode is
LEVELS = (0.9, 0.95, 0.99)  # shares of the variance whose modes are counted


@dataclass(frozen=True)
class ModelQuality:
    """Figures that tell whether to trust a model.

    shapes : how many it was made from.
    rounds : how often they were turned onto their mean before they were at rest.
    residual : root mean square distance of their vertices from the mean's.
    relative_residual : the same by the diagonal of the mean's bounding box.
    farthest : the shape farthest from the mean; a failed registration often is.
    farthest_distance : its root mean square distance.
    modes : how many modes there are.
    modes_90, modes_95, modes_99 : how many hold that much of the variance.
    """

    shapes: int
    rounds: int
    residual: float
    relative_residual: float
    farthest: int
    farthest_distance: float
    modes: int
    modes_90: int
    modes_95: int
    modes_99: int


@dataclass(frozen=True, eq=False, repr=False)
class ShapeModel(Showing):
    """The mean of aligned shapes and the modes in which they vary, most first.

    A shape is ``mean + sum score * deviation * mode``; scores are in standard deviations, so those
    of the shapes the model was made from have variance 1 in each mode.

    faces : (m, 3) int32.
    mean : (n, 3), with the pose and centroid of the first shape.
    modes : (p, n, 3) displacements, of length 1 in the product ``sum w u . v`` of the weights and
        orthogonal in it.
    variances : (p,) along each mode, divided by the number of shapes less one.
    scores : (k, p) of the shapes that the model was made from.
    vertex_variance : (n,) mean squared distance of each vertex from the mean's (by k - 1).
    total_variance : of all modes, those that :meth:`truncated` dropped included.
    beyond : (k,) squared norm of what dropped modes hold of each shape.
    weights : (n,) of the vertices, with sum n.
    names : of the k shapes.
    centroid_sizes : (k,) of the shapes as they were given.
    size : the centroid size that shapes are brought to; 0 where they keep theirs.
    rounds : how often the shapes were turned onto their mean.
    attributes : texture coordinates and labels, the same for all shapes.
    """

    faces: Ints
    mean: Floats
    modes: Floats
    variances: Floats
    scores: Floats
    vertex_variance: Floats
    total_variance: float
    beyond: Floats
    weights: Floats
    names: tuple[str, ...]
    centroid_sizes: Floats
    size: float
    rounds: int
    attributes: Attributes = field(default_factory=Attributes)

    def __repr__(self) -> str:
        return (
            f"ShapeModel({len(self.names)} shapes, {len(self.variances)} modes, "
            f"{len(self.mean)} vertices)"
        )

    def _scene_(self) -> Scene:
        """The mean, with a slider of three standard deviations for each of the first modes."""
        most = min(MOST_SLIDES, MOST_NUMBERS // max(self.mean.size, 1))
        count = int(np.clip((self.shares >= SEEN).sum(), 1, max(1, most)))
        moves = self.standard_deviations[:count, None, None] * self.modes[:count]
        slides = tuple(
            Slide(f"mode {k + 1} ({share:.0%})", move, -3.0, 3.0)
            for k, (move, share) in enumerate(zip(moves, self.shares, strict=False))
        )
        scene = Scene.of(self.mesh, slides=slides)
        return scene.coloured({"standard deviation": np.sqrt(self.vertex_variance)})

    @property
    def standard_deviations(self) -> Floats:
        """(p,) along each mode."""
        deviations: Floats = np.sqrt(self.variances)
        return deviations

    @property
    def shares(self) -> Floats:
        """(p,) share of each mode in the total variance."""
        shares: Floats = self.variances / (self.total_variance or 1.0)
        return shares

    @property
    def mesh(self) -> Mesh:
        """The mean."""
        return Mesh(self.mean, self.faces, attributes=self.attributes)

    @property
    def distances(self) -> Floats:
        """(k,) root mean square distance of each shape's vertices from the mean's."""
        squares = self.scores**2 @ self.variances + self.beyond
        distances: Floats = np.sqrt(squares / self.weights.sum())
        return distances

    @property
    def quality(self) -> ModelQuality:
        """Figures that tell whether to trust the model."""
        distances = self.distances
        residual = float(np.sqrt(np.mean(distances**2)))
        farthest = int(distances.argmax())
        return ModelQuality(
            len(self.names),
            self.rounds,
            residual,
            residual / (self.mesh.diagonal or 1.0),
            farthest,
            float(distances[farthest]),
            len(self.variances),
            *(self.modes_for(level) for level in LEVELS),
        )

    def modes_for(self, share: float) -> int:
        """How many of the first modes hold at least this share of the variance.

        Of a truncated model, all its modes where they hold less.
        """
        reached = np.cumsum(self.variances) >= share * self.total_variance * (1 - 1e-12)
        return int(reached.argmax()) + 1 if reached.any() else len(self.variances)

    def shape(self, scores: ArrayLike) -> Mesh:
        """The shape with these scores.

        Parameters
        ----------
        scores : (m,) standard deviations along the first m modes, of any sign.

        Raises
        ------
        InvalidInput : more scores than modes, or a score is not finite.
        """
        given = np.atleast_1d(np.asarray(scores, dtype=np.float64))
        if given.ndim != 1 or len(given) > len(self.variances) or not np.isfinite(given).all():
            raise InvalidInput(
                f"scores must be up to {len(self.variances)} finite numbers, one per mode; "
                f"they have shape {given.shape}"
            )
        count = len(given)
        moved = np.tensordot(given * self.standard_deviations[:count], self.modes[:count], 1)
        return Mesh(self.mean + moved, self.faces, attributes=self.attributes)

    def scores_of(self, shape: Any) -> Floats:
        """Scores (p,) of another shape, which is moved onto the mean first.

        What the modes cannot say is left out: ``model.shape(model.scores_of(x))`` is the shape of
        the model nearest to x.

        Parameters
        ----------
        shape : (n, 3) vertices, a mesh or a registration of the same connectivity.

        Raises
        ------
        InvalidInput : another connectivity, or a shape without size.
        NotFinite : a coordinate is NaN or infinite.
        """
        vertices = shape
        if not isinstance(shape, np.ndarray | list):
            vertices = shared([self.mesh, shape], ["the model", "this shape"]).vertices[1]
        moved = self._moved(np.asarray(vertices, dtype=np.float64))
        pulled = self.weights[:, None] * (moved - self.mean)
        scores: Floats = np.tensordot(self.modes, pulled, 2) / self.standard_deviations
        return scores

    def variance_mesh(self) -> Mesh:
        """The mean with the vertex attributes ``variance`` and ``color``.

        The colour goes with the standard deviation, the root of the variance: dark violet where
        shapes agree, yellow where they differ most.
        """
        spread = np.sqrt(self.vertex_variance)
        shown = {"variance": self.vertex_variance, "color": ramp(spread, 0.0, spread.max())}
        return Mesh(self.mean, self.faces, attributes=Attributes(vertex=shown))

    def truncated(self, count: int) -> ShapeModel:
        """The same with the first modes only; what is dropped stays in the total variance.

        Raises
        ------
        InvalidInput : ``count`` is negative.
        """
        if count < 0:
            raise InvalidInput(f"the number of modes must not be negative, it is {count}")
        dropped = self.scores[:, count:] ** 2 @ self.variances[count:]
        return replace(
            self,
            modes=self.modes[:count],
            variances=self.variances[:count],
            scores=self.scores[:, :count],
            beyond=self.beyond + dropped,
        )

    def compactness(self) -> Curve:
        """Variance in the first modes, see :func:`henkei.statistics.curves.compactness`."""
        return curves.compactness(self.variances, len(self.names))

    def generalisation(self, progress: Progress = silent) -> Curve:
        """How well shapes left out are described, by up to k - 2 modes, see
        :func:`henkei.statistics.curves.generalisation`.

        Raises
        ------
        InvalidInput : modes were dropped, so that the shapes are no longer known.
        """
        if self.beyond.any():
            raise InvalidInput(
                "modes were dropped, and with them what shapes left out look like; take the "
                "generalisation of the whole model"
            )
        moved = np.tensordot(self.scores * self.standard_deviations, self.modes, 1)
        most = min(len(self.variances), len(self.names) - 2)
        return curves.generalisation(self.mean + moved, self.weights, most, progress)

    def specificity(self, samples: int = SAMPLES, seed: int = 0) -> Curve:
        """How near random shapes are to real ones, see
        :func:`henkei.statistics.curves.specificity`."""
        mass = float(self.weights.sum())
        return curves.specificity(self.variances, self.scores, self.beyond, mass, samples, seed)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name, for a file; :meth:`from_arrays` undoes it."""
        arrays = {name: np.asarray(getattr(self, name)) for name in _ARRAYS}
        for domain in ("vertex", "corner", "face"):
            for name, values in getattr(self.attributes, domain).items():
                arrays[f"attributes.{domain}.{name}"] = values
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> ShapeModel:
        """The model that :meth:`to_arrays` took apart.

        Raises
        ------
        InvalidFile : an array is missing, or does not fit the others.
        InvalidMesh, InvalidInput : faces or attributes do not fit the vertices.
        """
        missing = [name for name in _ARRAYS if name not in arrays]
        if missing:
            raise InvalidFile(f"not a whole shape model: {', '.join(missing)} missing")
        sizes = {
            "n": len(np.atleast_1d(arrays["mean"])),
            "m": len(np.atleast_1d(arrays["faces"])),
            "k": len(np.atleast_1d(arrays["names"])),
            "p": len(np.atleast_1d(arrays["variances"])),
        }
        for name, (shape, kind) in _ARRAYS.items():
            expected = tuple(sizes.get(str(size), size) for size in shape)
            values = arrays[name]
            if values.shape != expected or values.dtype.kind != kind:
                raise InvalidFile(
                    f"not a whole shape model: {name} is {values.dtype} of shape {values.shape}, "
                    f"not {expected}"
                )
        domains: dict[str, dict[str, NDArray[Any]]] = {"vertex": {}, "corner": {}, "face": {}}
        for key, values in arrays.items():
            prefix, _, rest = key.partition(".")
            domain, _, name = rest.partition(".")
            if prefix == "attributes" and domain in domains:
                domains[domain][name] = values
        own: dict[str, Any] = {name: arrays[name] for name in _ARRAYS}
        own |= {name: own[name].item() for name in ("total_variance", "size", "rounds")}
        own["names"] = tuple(own["names"].tolist())
        model = cls(**own, attributes=Attributes(**domains))
        _ = model.mesh  # refuses faces and attributes that do not fit
        return model

    def _moved(self, vertices: Floats) -> Floats:
        """Vertices moved onto the mean as the shapes of the model were."""
        if vertices.shape != self.mean.shape:
            raise InvalidInput(
                f"vertices must have shape {self.mean.shape}, these have {vertices.shape}"
            )
        place = self.weights @ self.mean / self.weights.sum()
        centred = vertices - self.weights @ vertices / self.weights.sum()
        size = float(centroid_sizes(centred[None], self.weights)[0])
        if not np.isfinite(size) or (self.size and not size):
            raise InvalidInput("the shape has no size, or vertices that are NaN or infinite")
        factor = self.size / size if self.size else 1.0
        covariance = (self.weights[:, None] * (self.mean - place)).T @ centred
        turned: Floats = factor * centred @ best_rotations(covariance[None])[0].T + place
        return turned


_ARRAYS: dict[str, tuple[tuple[str | int, ...], str]] = {
    "faces": (("m", 3), "i"),
    "mean": (("n", 3), "f"),
    "modes": (("p", "n", 3), "f"),
    "variances": (("p",), "f"),
    "scores": (("k", "p"), "f"),
    "vertex_variance": (("n",), "f"),
    "total_variance": ((), "f"),
    "beyond": (("k",), "f"),
    "weights": (("n",), "f"),
    "names": (("k",), "U"),
    "centroid_sizes": (("k",), "f"),
    "size": ((), "f"),
    "rounds": ((), "i"),
}
"""Arrays of a model, their shapes (n vertices, m faces, k shapes, p modes) and kinds."""
