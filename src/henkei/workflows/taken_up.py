"""A scan taken up as a design: a coarse quad cage, and the scan's detail as wavelets over it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from henkei.design.constraints import Curve, Derivative, Pin
from henkei.design.designer import Designer
from henkei.design.paths import position
from henkei.design.pyramid import Pyramid
from henkei.design.settings import MOST_LEVELS, checked_count
from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry.correspondence import SurfacePoints, attribute_arrays, attributes_in
from henkei.geometry.distance import ClosestPoints, points_on, sampled, used_vertices
from henkei.io.scene import Scene
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh
from henkei.progress import Progress, part, silent
from henkei.quad.relaxation import scaled_jacobians, split_quads
from henkei.quad.surfaces import Wound
from henkei.quad.wishes import checked_seed
from henkei.showing import Showing
from henkei.workflows.scan_levels import (
    LaidLevel,
    Mask,
    Scan,
    first_levels,
    next_level,
    without_folds,
)
from henkei.workflows.scan_turns import rotations_between

T = TypeVar("T")

SAMPLES = 50_000  # places at which each distance is measured, beside the vertices


@dataclass(frozen=True)
class TakenUpQuality:
    """How well quads of the finest level stand for a scan.

    cage_quads, quads, levels : how many there are.
    distance_to_scan, distance_from_scan : largest distance of the quads from the scan, and of the
        scan from the quads (one-sided Hausdorff distances, at samples), as parts of its diagonal.
    mean_distance_to_scan, mean_distance_from_scan : their means, likewise.
    worst_scaled_jacobian, mean_scaled_jacobian : of the quads; 1 for a rectangle, 0 or less for one
        that is folded.
    folded : quads with a scaled Jacobian of 0 or less, or that face against the scan they are on.
    off_scan : vertices that leave the scan, where quads on it would be folded.
    """

    cage_quads: int
    quads: int
    levels: int
    distance_to_scan: float
    distance_from_scan: float
    mean_distance_to_scan: float
    mean_distance_from_scan: float
    worst_scaled_jacobian: float
    mean_scaled_jacobian: float
    folded: int
    off_scan: int


@dataclass(frozen=True, eq=False, repr=False)
class TakenUp(Showing):
    """A scan as a coarse cage with details. Made by :func:`take_up`.

    scan : its triangles.
    pyramid : the surface of quads on the scan in levels: coarse forms, and wavelet coefficients.
    on_scan : the nearest place on the scan to each vertex of the finest level, to carry values.
    off_scan : (k,) vertices that are off the scan, see :class:`TakenUpQuality`.
    """

    scan: Mesh
    pyramid: Pyramid
    on_scan: SurfacePoints
    off_scan: NDArray[np.intp]
    quality: TakenUpQuality
    _solved: dict[str, tuple[object, Any]] = field(default_factory=dict, init=False)

    def _scene_(self) -> Scene:
        """The quads on the scan, with the scan's values as colours."""
        return Scene.of(self.carried(self.surface))

    @property
    def levels(self) -> int:
        """The number of the finest level."""
        return self.pyramid.levels

    @property
    def cage(self) -> PolygonMesh:
        """The coarse form of the scan: quads nearest to it in the sense of least squares."""
        return _polygons(self.pyramid.surface(0))

    @property
    def surface(self) -> PolygonMesh:
        """The quads of the finest level, on the scan."""
        return _polygons(self.pyramid.surface())

    def designer(self, **settings: Any) -> Designer:
        """A designer of the scan's coarse form, for :meth:`shape`.

        Parameters
        ----------
        settings : as for :class:`.Designer`, but for the levels and the refinement.
        """
        return Designer(self.cage, self.levels, refinement="quads", **settings)

    def shape(self, design: Designer, *, frames: bool = True) -> PolygonMesh:
        """The scan's surface, its coarse form changed as a design says, its detail kept.

        Every point moves as far as the design moves it from where it is *at rest*, with constraints
        of the same kind at the same places that ask for nothing but the :meth:`forms`. So a
        constraint whose target is its place there leaves the scan as it is, to rounding, and
        vertices of the cage that are let go leave it alone.

        Parameters
        ----------
        design : by :meth:`designer`, with constraints at any level, targets being places of the
            smooth forms.
        frames : turn the detail, what the scan has beyond the finest of the forms, with the surface
            beneath it; else it is only shifted, and the result is linear in what is asked for.

        Raises
        ------
        InvalidInput : a design on another cage, or with other levels.
        """
        now, after = self.surface, self.form(design)
        before = self.forms(design)[-1]
        change = after.vertices - before.vertices
        points = now.vertices + change
        if frames and change.any():
            turn = rotations_between(before, after) - np.eye(3)
            points += np.einsum("nij,nj->ni", turn, now.vertices - before.vertices)
        return PolygonMesh(points, (now.indices, now.offsets), attributes=now.attributes)

    def form(self, design: Designer) -> PolygonMesh:
        """The finest of the :meth:`forms`, moved as :meth:`shape` moves the scan.

        Raises
        ------
        InvalidInput : a design on another cage, or with other levels.
        """
        designed = self._designed(design)
        form, move = self.forms(design)[-1], designed.vertices - self._at_rest(design)
        return PolygonMesh(form.vertices + move, (form.indices, form.offsets))

    def with_detail_of(
        self, design: Designer, level: int = 1, *, frames: bool = True
    ) -> PolygonMesh:
        """The reverse: the scan's form at a level, with what a design adds at that and finer ones.

        Parameters
        ----------
        level : the details of it and of all finer levels are the design's; at 0 only the cage is
            the scan's.
        frames : turn details from the surface of the design beneath them to the scan's.

        Raises
        ------
        InvalidInput : a design on another cage or with other levels, or there is no such level.
        """
        other = Pyramid.on(self.cage, self._designed(design).vertices, refinement="quads")
        return _polygons(self.pyramid.with_detail_of(other, level, frames=frames).surface())

    def _designed(self, design: Designer) -> PolygonMesh:
        """What a design has made of this cage."""
        cage, own = design.cage, self.cage
        same = isinstance(cage, PolygonMesh) and np.array_equal(cage.indices, own.indices)
        if not (same and np.array_equal(cage.vertices, own.vertices)):
            raise InvalidInput("this design has another cage: make one by designer()")
        surface = _polygons(design.solve())
        if len(surface.vertices) != len(self.on_scan):
            raise InvalidInput(
                f"this design has {len(surface.vertices):,} vertices at its finest level, the scan "
                f"taken up has {len(self.on_scan):,}: make one by designer(), and don't refine it"
            )
        return surface

    def forms(self, design: Designer) -> list[PolygonMesh]:
        """The smooth surfaces of all levels that a designer with these settings makes of the cage
        without constraints."""

        def made() -> list[PolygonMesh]:
            plain = self._like(design)
            return [_polygons(plain.surface(level)) for level in range(self.levels + 1)]

        return self._kept("forms", _settings(design), made)

    def carried(self, surface: PolygonMesh) -> PolygonMesh:
        """A surface of the finest level with the scan's colours, labels and other values at
        vertices; normals are left out."""
        values = self.scan.attributes.without("normal").vertex
        pulled = {name: self.on_scan.pull(self.scan, array) for name, array in values.items()}
        faces = surface.indices, surface.offsets
        return PolygonMesh(surface.vertices, faces, attributes=Attributes(vertex=pulled))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name, for a file; :meth:`from_arrays` undoes it."""
        arrays: dict[str, NDArray[Any]] = {
            "scan.vertices": self.scan.vertices,
            "scan.faces": self.scan.faces,
            "cage.faces": np.asarray(self.cage.faces),
            "vertices": self.surface.vertices,
            "on_scan.face": self.on_scan.face,
            "on_scan.barycentric": self.on_scan.barycentric,
            "off_scan": self.off_scan,
        }
        arrays |= attribute_arrays(self.scan.attributes, "attributes")
        return arrays | {f"quality.{n}": np.array(v) for n, v in asdict(self.quality).items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> TakenUp:
        """The scan that :meth:`to_arrays` took apart.

        Raises
        ------
        InvalidFile : an array is missing, or names what does not exist.
        InvalidMesh, InvalidInput : faces or positions that do not fit each other.
        """
        try:
            attributes = attributes_in(arrays, "attributes")
            scan = Mesh(arrays["scan.vertices"], arrays["scan.faces"], attributes=attributes)
            on_scan = SurfacePoints(arrays["on_scan.face"], arrays["on_scan.barycentric"])
            quads, points, off = arrays["cage.faces"], arrays["vertices"], arrays["off_scan"]
            fields = TakenUpQuality.__dataclass_fields__
            quality = TakenUpQuality(**{n: arrays[f"quality.{n}"].item() for n in fields})
        except KeyError as missing:
            raise InvalidFile(f"not a whole scan taken up: {missing} is missing") from None
        for name, values, count in (
            ("on_scan.face", on_scan.face, scan.face_count),
            ("off_scan", off, len(points)),
        ):
            if not np.isin(values, np.arange(count)).all():
                raise InvalidFile(f"{name} names what does not exist")
        # Vertices of the cage have the same numbers at the finest level.
        cage = PolygonMesh(points[: quads.max(initial=-1) + 1], quads)
        return cls(scan, Pyramid.on(cage, points, refinement="quads"), on_scan, off, quality)

    def __reduce__(self) -> tuple[Any, ...]:
        return TakenUp.from_arrays, (self.to_arrays(),)

    def _at_rest(self, design: Designer) -> Floats:
        """Vertices (n, 3) of a design with the same constraints, that ask for what is there."""

        def made() -> Floats:
            rest, forms = self._like(design), self.forms(design)
            rest.unpin(np.flatnonzero(~design.pinned))
            for one in design.constraints:
                form = forms[one.level]
                match one:
                    case Pin():
                        rest.pin(one.level, one.place, position(form, one.place))
                    case Curve():
                        path = [position(form, place) for place in one.path]
                        rest.curve(one.level, one.path, path, cutoff=one.cutoff)
                    case Derivative():
                        there = (one.rows @ form.vertices)[0]
                        rest.derivative(one.level, one.place, one.direction, there)
            return rest.solve().vertices

        # Rows of constraints never change.
        asked = _settings(design), design.pinned.tobytes(), tuple(design.constraints)
        return self._kept("at rest", asked, made)

    def _like(self, design: Designer) -> Designer:
        """A designer of this cage with the same settings and no constraints."""
        plain = self.designer(
            gamma=design.gamma,
            steps=design.steps,
            support=design.support,
            interpolating=design.interpolating,
        )
        plain.axis_gamma = design.axis_gamma
        plain.axis_smoothing = design.axis_smoothing
        return plain

    def _kept(self, name: str, asked: object, made: Callable[[], T]) -> T:
        """What was made when this was asked for last, or is made now."""
        if name not in self._solved or self._solved[name][0] != asked:
            self._solved[name] = asked, made()
        kept: T = self._solved[name][1]
        return kept

    def __repr__(self) -> str:
        q = self.quality
        return f"TakenUp({q.cage_quads:,} quads to {q.quads:,} at level {q.levels})"


def take_up(
    scan: Any,
    *,
    quads: int | None = None,
    levels: int | None = None,
    seed: int = 0,
    progress: Progress = silent,
) -> TakenUp:
    """A scan as a coarse quad cage, refined onto it level by level, to be edited like a design.

    Parameters
    ----------
    scan : triangles (polygons are split): manifold and orientable, open or closed, of any genus.
    quads : about how many the cage is to have; where none is said, as few of 250 to 2,000 as lie
        without folds within 4 % of the diagonal.
    levels : how often the cage is refined; by default until there are as many quads as vertices of
        the scan.
    seed : for what is left to chance where quads are bad.
    progress : is told how far the work is; may raise to end it.

    Raises
    ------
    NotFinite, NotManifold, NotOriented, DegenerateFaces, InvalidMesh : the scan is not fit.
    InvalidInput : an argument is not.
    Infeasible : the scan takes far more quads than were asked for.
    """
    seed = checked_seed(seed)
    count = None if levels is None else _checked_levels(levels)
    mesh = Wound.of(scan).mesh
    on, laid = first_levels(mesh, quads, seed, part(progress, 0.0, 0.3))
    cage = laid[0]
    if count is None:
        count = _levels_for(cage.faces.face_count, len(mesh.vertices))
    share = 4.0 ** np.arange(2, count + 1)
    done = np.cumsum([0.0, *share]) / max(share.sum(), 1.0)
    while len(laid) <= count:
        within = part(progress, *(0.3 + 0.6 * done[len(laid) - 2 : len(laid)]).tolist())
        laid.append(next_level(on, laid[-1], seed, within))
    finest, off = without_folds(on, laid[-1])
    flat = PolygonMesh(cage.points, (cage.faces.indices, cage.faces.offsets))
    pyramid = Pyramid.on(flat, finest.points, refinement="quads", progress=part(progress, 0.9, 1.0))
    quality = _measured(on, cage, finest, count, off)
    on_scan, _ = on.places.query(finest.points)
    return TakenUp(mesh, pyramid, on_scan, np.flatnonzero(off), quality)


def _checked_levels(levels: Any) -> int:
    count = checked_count(levels, "levels", MOST_LEVELS)
    if not count:
        raise InvalidInput("levels must be 1 or more: at level 0 there is no detail")
    return count


def _levels_for(quads: int, vertices: int) -> int:
    levels = 1
    while quads * 4**levels < vertices:
        levels += 1
    return levels


def _measured(
    scan: Scan, cage: LaidLevel, finest: LaidLevel, levels: int, off: Mask
) -> TakenUpQuality:
    mesh, diagonal = scan.mesh, scan.mesh.diagonal
    triangles = Mesh(finest.points, split_quads(finest.points, finest.quads))
    out = np.vstack([points_on(triangles, sampled(triangles, SAMPLES)), finest.points])
    back = np.vstack([points_on(mesh, sampled(mesh, SAMPLES)), used_vertices(mesh)])
    to_scan = scan.places.query(out)[1] / diagonal
    from_scan = ClosestPoints(triangles).query(back)[1] / diagonal
    shape = scaled_jacobians(finest.points, finest.quads)
    return TakenUpQuality(
        cage_quads=cage.faces.face_count,
        quads=finest.faces.face_count,
        levels=levels,
        distance_to_scan=float(to_scan.max()),
        distance_from_scan=float(from_scan.max()),
        mean_distance_to_scan=float(to_scan.mean()),
        mean_distance_from_scan=float(from_scan.mean()),
        worst_scaled_jacobian=float(shape.min()),
        mean_scaled_jacobian=float(shape.mean()),
        folded=int(np.count_nonzero(finest.folded(scan, off))),
        off_scan=int(np.count_nonzero(off)),
    )


def _settings(design: Designer) -> tuple[object, ...]:
    """What decides a design without constraints, to be compared."""
    axes = None if design.axis_gamma is None else tuple(design.axis_gamma)
    shared = tuple(np.ravel(design.gamma)), axes, design.axis_smoothing
    return *shared, design.steps, design.support, design.interpolating


def _polygons(surface: Mesh | PolygonMesh) -> PolygonMesh:
    assert isinstance(surface, PolygonMesh), "refined into quads"
    return surface
