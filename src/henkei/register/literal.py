"""The paper's own form of the method, step by step as printed. For study: it does not work well.

S. Matsui, K. Morooka, H. Nagahashi: 3-D morphing by direct mapping between mesh models using
Self-organizing Deformable Model, algorithms 1 and 2.

What the paper leaves open is decided here as follows.

- Control points are the vertices of the control surface; for a sphere, those of an icosphere with
  about as many vertices as the model.
- Step 1, the control surface inside the model: the model is enlarged and shifted until its bounding
  box encloses that of the control surface. In algorithm 2, step 3, it stays where step 2 put it.
- T is ``Settings.draws`` by the number of vertices, less for large models: looking at all vertices
  for each winner has a cost.
- Omega_i are the control points whose nearest vertex is i. D (eq. 4) is the mean over the vertices
  that have any. tau and xi are ``REACHED`` squared, by the control surface's diagonal; repeating
  ends after some rounds, or where D gets no less, too, and the best so far is kept.
- w is one half. Candidates come from the control points of Omega_i nearest to the vertex, and all
  vertices take theirs at once.
- Landmarks (eq. 19, 20) are pairs of initial and final model, so they hold in algorithm 2, step 3;
  on the mediator there are none.

Why it does badly: eq. 7 is the distance from a plane, not from a point. The winner may be far away
along that plane, so that control points pull at vertices all over the model; and once vertices are
inside a convex surface, no vertex is in front of most planes. Models hardly become the mediator,
step 2 joins what has nothing to do with each other, and step 3 cannot undo it: on a bunny and a
goat's head half of the faces end the wrong way round, and vertices 4 % of the diagonal away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from henkei.geometry.alignment import Similarity
from henkei.geometry.bridge import bridged
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import ClosestPoints
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, part, silent
from henkei.register.adaptation import ControlPoints, adapted
from henkei.register.alignment import aligned
from henkei.register.landmarks import Landmarks, no_landmarks
from henkei.register.mediators import round_mesh
from henkei.register.quality import measured
from henkei.register.registration import Registration
from henkei.register.settings import Settings
from henkei.register.surfaces import Closed
from henkei.register.watching import Watcher
from henkei.topology import Ints

Numbers = NDArray[np.integer]

AS_PRINTED = Settings(
    rule="literal", rate_start=0.5, rate_end=0.005, radius_start=3.0, radius_end=0.1
)  # 4.1
REACHED = 1e-3  # root of tau and xi, in diagonals of the control surface
ROUNDS = 3  # of the adaptation, at most
REFINEMENTS = 5  # at most
CANDIDATES = 8  # per vertex, at most
STEP = 0.5  # w of eq. 12
COMPARISONS = 3e9  # of vertices with planes in one adaptation, at most


def registered(
    ours: Closed,
    theirs: Closed,
    shape: Closed | None,
    marks: Landmarks,
    motion: Similarity,
    seed: int,
    settings: Settings,
    progress: Progress,
    watcher: Watcher,
) -> Registration:
    """Algorithm 2 as printed.

    Vertices stay where the algorithm leaves them, near the target's surface at best; ``on_target``
    is the place nearest to each, and landmarks are only drawn to theirs. ``quality.inverted``
    counts faces of I' that do not look outward from the middle of the mediator, which says
    something of a round mediator only.

    Parameters
    ----------
    shape : the mediator; None for the sphere.
    motion : source to target.
    """
    between, (to_shape, from_target) = _mediator(ours, theirs, shape, motion)
    control = ControlPoints.of(between.vertices, between.vertex_normals)
    drawn = []  # I' and F'
    for side, move, start in ((ours, to_shape, 0.1), (theirs, from_target, 0.4)):
        outside = around(move.apply(side.mesh.vertices), between.vertices)
        mapped = part(progress, start, start + 0.3)
        drawn.append(deformed(outside, side.mesh, control, settings, seed, mapped))
    nearest = np.asarray(cKDTree(drawn[1]).query(drawn[0])[1])  # eq. 16
    held = np.searchsorted(ours.used, marks.vertices).astype(np.int32)
    joined = theirs.mesh.vertices[nearest]  # eq. 17
    watcher.show(joined)
    control = ControlPoints.of(theirs.mesh.vertices, theirs.mesh.vertex_normals)
    vertices = deformed(
        joined,
        ours.mesh,
        with_landmarks(control, marks.points, held),
        settings,
        seed,
        part(progress, 0.7, 0.9),
    )
    watcher.show(vertices)
    progress("measuring", 0.9)
    middle = (between.vertices.min(axis=0) + between.vertices.max(axis=0)) / 2
    inverted = inverted_on_sphere((drawn[0] - middle) / between.diagonal, ours.mesh.faces)
    return _registration(ours, theirs, vertices, marks, motion, len(inverted))


def _mediator(
    ours: Closed, theirs: Closed, shape: Closed | None, motion: Similarity
) -> tuple[Mesh, tuple[Similarity, Similarity]]:
    """The mediator's mesh, and how source and target are turned to it."""
    if shape is None:
        count = max(len(ours.mesh.vertices), len(theirs.mesh.vertices))
        return round_mesh(count), (motion, Similarity(np.eye(3), 1.0, np.zeros(3)))
    nobody = no_landmarks()
    return shape.mesh, (
        aligned(ours.given, shape.given, nobody),
        aligned(theirs.given, shape.given, nobody),
    )


def around(vertices: Floats, inner: Floats) -> Floats:
    """Vertices (n, 3) shifted and enlarged so that their bounding box just encloses that of the
    points ``inner`` (algorithm 1, step 1)."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    inner_low, inner_high = inner.min(axis=0), inner.max(axis=0)
    sides = high - low
    thinnest = np.maximum(sides, 1e-3 * sides.max())
    scale = ((inner_high - inner_low) / thinnest).max()
    return np.asarray((inner_low + inner_high) / 2 + scale * (vertices - (low + high) / 2))


def with_landmarks(control: ControlPoints, points: Floats, winners: Ints) -> ControlPoints:
    """Control points with landmarks among them: ``winners`` (k,) always win ``points`` (k, 3)
    (eq. 19, 20)."""
    if not len(points):
        return control
    away, nearest = map(np.asarray, cKDTree(control.points).query(points))
    others = np.delete(np.arange(len(control.points)), nearest[away == 0])
    return ControlPoints(
        np.concatenate([control.points[others], points]),
        np.concatenate([control.normals[others], control.normals[nearest]]),
        np.concatenate([control.winners[others], winners]),
    )


def deformed(
    vertices: Floats,
    mesh: Mesh,
    control: ControlPoints,
    settings: Settings,
    seed: int,
    progress: Progress = silent,
) -> Floats:
    """Algorithm 1, steps 2 to 11: the vertices (n, 3) of a model after its deformation onto the
    control points. ``mesh`` says what is joined to what."""
    most = COMPARISONS / len(vertices) ** 2
    settings = replace(settings, draws=min(settings.draws, most))
    size = float(np.linalg.norm(np.ptp(control.points, axis=0)))
    best, least = vertices, np.inf
    for turn in range(ROUNDS):
        moved, without = adapted(best, mesh, control, settings, seed + turn)
        distance = Assignment(moved, mesh, control.points).distance()
        progress(
            f"adapting, distance {np.sqrt(distance) / size:.3g}, {without} draws without winner",
            turn / (ROUNDS + 1),
        )
        if distance >= least:
            break
        best, least = moved, distance
        if least < (REACHED * size) ** 2:  # eq. 11
            break
    return _refined(best, least, mesh, control.points, size, part(progress, 0.75, 1.0))


def _refined(
    best: Floats, least: float, mesh: Mesh, points: Floats, size: float, progress: Progress
) -> Floats:
    """Algorithm 1, steps 9 to 11."""
    for turn in range(REFINEMENTS):
        if least < (REACHED * size) ** 2:  # eq. 14
            break
        moved = Assignment(best, mesh, points).best_candidates()
        distance = Assignment(moved, mesh, points).distance()
        progress(f"refining, distance {np.sqrt(distance) / size:.3g}", turn / REFINEMENTS)
        if distance >= least:
            break
        best, least = moved, distance
    return best


@dataclass(frozen=True, eq=False)
class Assignment:
    """Control points (k, 3) dealt out to the vertices (n, 3) of a model: each to the nearest."""

    vertices: Floats
    mesh: Mesh
    points: Floats

    @cached_property
    def _dealt(self) -> tuple[Numbers, Numbers, Numbers]:
        """Control points ordered by vertex, near ones first; where each vertex's start, and how
        many there are."""
        away, vertex = map(np.asarray, cKDTree(self.vertices).query(self.points))
        order = np.lexsort((away, vertex))
        counts = np.bincount(vertex, minlength=len(self.vertices))
        return order, np.cumsum(counts) - counts, counts

    @cached_property
    def _incident(self) -> tuple[Numbers, Numbers, Numbers]:
        """Faces ordered by vertex, where each vertex's start, and how many there are."""
        order = np.argsort(self.mesh.indices, kind="stable")
        counts = np.bincount(self.mesh.indices, minlength=len(self.vertices))
        return order // 3, np.cumsum(counts) - counts, counts

    @property
    def counts(self) -> Numbers:
        """How many control points each vertex has, (n,)."""
        return self._dealt[2]

    def energies(self, which: Numbers, places: Floats) -> Floats:
        """E (eq. 5) of some vertices (k,) if each, alone, were at ``places`` (k, 3)."""
        points, first_point, point_counts = self._dealt
        faces, first_face, face_counts = self._incident
        pairs = point_counts[which] * face_counts[which]
        at = np.repeat(np.arange(len(which)), pairs)
        number = np.arange(len(at)) - np.repeat(np.cumsum(pairs) - pairs, pairs)
        vertex = which[at]
        point = points[first_point[vertex] + number // face_counts[vertex]]
        corners = self.mesh.faces[faces[first_face[vertex] + number % face_counts[vertex]]]
        moves = (corners == vertex[:, None])[:, :, None]
        triangles = np.where(moves, places[at][:, None], self.vertices[corners])
        squared = squared_distances(self.points[point], triangles)
        return np.asarray(np.bincount(at, squared, len(which)), dtype=np.float64)

    def distance(self) -> float:
        """D (eq. 4)."""
        which = np.flatnonzero(self.counts)
        pairs = self.counts[which] * self._incident[2][which]
        return float((self.energies(which, self.vertices[which]) / (3 * pairs)).mean())

    def best_candidates(self) -> Floats:
        """Where the vertices are after one refinement (eq. 12, 13), (n, 3); those without control
        points stay."""
        chosen, least = self.vertices.copy(), np.full(len(self.vertices), np.inf)
        points, first_point, counts = self._dealt
        for number in range(min(CANDIDATES, int(counts.max()))):
            which = np.flatnonzero(counts > number)
            aim = self.points[points[first_point[which] + number]]
            places = self.vertices[which] + STEP * (aim - self.vertices[which])
            energies = self.energies(which, places)
            better = energies < least[which]
            least[which[better]] = energies[better]
            chosen[which[better]] = places[better]
        return chosen


def squared_distances(points: Floats, triangles: Floats) -> Floats:
    """H squared of eq. 5: from points (k, 3) to triangles (k, 3, 3), one each."""
    ends = np.roll(triangles, -1, axis=1)
    sides = ends - triangles
    to_points = points[:, None] - triangles
    lengths = np.einsum("ijk,ijk->ij", sides, sides)
    along = np.einsum("ijk,ijk->ij", to_points, sides) / np.where(lengths > 0, lengths, 1)
    rest = to_points - np.clip(along, 0, 1)[:, :, None] * sides
    nearest = np.einsum("ijk,ijk->ij", rest, rest).min(axis=1)
    normals = np.cross(sides[:, 0], sides[:, 1])
    squares = np.einsum("ij,ij->i", normals, normals)
    over = squares > 0
    over &= (np.einsum("ijk,ik->ij", np.cross(sides, to_points), normals) >= 0).all(axis=1)
    height = np.einsum("ij,ij->i", to_points[:, 0], normals)
    return np.asarray(np.where(over, height * height / np.where(over, squares, 1), nearest))


def _registration(
    ours: Closed,
    theirs: Closed,
    drawn: Floats,
    marks: Landmarks,
    motion: Similarity,
    inverted: int,
) -> Registration:
    """The result, measured as it is."""
    unused: NDArray[np.bool_] = np.ones(len(ours.given.vertices), dtype=bool)
    unused[ours.used] = False
    vertices = np.zeros((len(unused), 3))
    vertices[ours.used] = drawn[: len(ours.used)]
    vertices = bridged(ours.given, vertices, unused)
    places, _ = ClosestPoints(theirs.mesh).query(vertices)
    nowhere = unused | ~theirs.is_own(places.face)
    on_target = SurfacePoints(
        np.where(nowhere, -1, places.face).astype(np.int32),
        np.where(nowhere[:, None], 0, places.barycentric),
    )
    error = np.linalg.norm(vertices[marks.vertices] - marks.points, axis=1).max(initial=0.0)
    error /= theirs.given.diagonal
    quality = measured(ours.given, theirs.given, vertices, nowhere, error, inverted)
    return Registration.of(
        ours.given, theirs.given, vertices, on_target, marks.vertices, motion, quality
    )
