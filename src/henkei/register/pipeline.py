"""Registering one surface onto another: the method's steps in order.

S. Matsui, K. Morooka, H. Nagahashi: 3-D morphing by direct mapping between mesh models using
Self-organizing Deformable Model.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.errors import Infeasible, InvalidInput
from henkei.geometry.alignment import Similarity
from henkei.geometry.bridge import bridged
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import points_on, surface_distance
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.mesh import Mesh
from henkei.progress import Progress, part, silent
from henkei.register import literal, mediators
from henkei.register.alignment import aligned
from henkei.register.expectation import Expectation, expectation
from henkei.register.landmarks import (
    Landmarks,
    no_landmarks,
    resolved,
)
from henkei.register.quality import measured
from henkei.register.refinement import Refinement, unfolded
from henkei.register.regions import anywhere, labelled
from henkei.register.registration import Registration
from henkei.register.settings import Settings
from henkei.register.spheres import OnSphere, brought_together, turned
from henkei.register.surfaces import Closed, refuse_opposite
from henkei.register.watching import UNSEEN, Watch, Watcher


def register(
    source: Any,
    target: Any,
    *,
    mediator: Any = "sphere",
    landmarks: Any = (),
    regions: Any = None,
    seed: int = 0,
    settings: Settings | None = None,
    progress: Progress = silent,
    watch: Watch | None = None,
) -> Registration:
    """Give the source the shape of the target; vertices, edges and faces stay the source's.

    Both surfaces are laid out on one sphere without folds, directly or through a mediator. There
    the source is drawn to where the target has form, and refined until it covers it; no face is
    ever turned over on the sphere. Every vertex ends on the target's surface.

    Parameters
    ----------
    source, target : meshes, or what :meth:`Mesh.from_any` takes: in one piece, manifold,
        consistently oriented, without handles. Boundary loops are closed by membranes; vertices
        that land in a membrane of the target are bridged smoothly and marked by face -1.
    mediator : a shape of like structure that both are brought to first: ``"sphere"``,
        ``"quadruped"``, ``"humanoid"``, or a mesh.
    landmarks : corresponding places, as vertex indices (k, 2), or as points (k, 2, 3) on or near
        both surfaces, the source's standing for the nearest vertex. They are met exactly.
    regions : integer labels of the source's vertices and of the target's, ``(n,)`` and ``(m,)``; a
        region of the source goes to the region of the target with the same label. Negative labels
        leave a vertex free.
    seed : for the random choice of control points.
    settings : see :class:`Settings`.
    progress : see :mod:`henkei.progress`.
    watch : shown the model on its way: called with where the source's vertices (n, 3) are, in the
        target's space, after each step and up to ten times a second in the refinement. That takes a
        tenth of the time, and does not change the result. On the way to a mediator, the model is
        shown on it.

    Raises
    ------
    InvalidMesh : (its kinds) a surface cannot be used; the message says which, where and why.
    InvalidInput : landmarks, regions or the mediator cannot be used.
    Infeasible : the landmarks cannot be brought together without folds.
    """
    chosen = Settings() if settings is None else settings
    if not isinstance(chosen, Settings):
        raise InvalidInput(
            f"settings must be henkei.register.Settings, not {type(chosen).__name__}"
        )
    if not isinstance(seed, (int, np.integer)) or not 0 <= seed < 2**63:
        raise InvalidInput(f"seed must be an integer from 0 to 2^63 - 1, not {seed!r}")
    progress("checking the surfaces", 0.0)
    ours, theirs = Closed.of("source", source), Closed.of("target", target)
    refuse_opposite(ours, theirs)
    shape = mediators.chosen(mediator)
    marks = resolved(ours, theirs, landmarks)
    where = labelled(ours, theirs, regions)
    progress("aligning", 0.05)
    motion = aligned(ours.given, theirs.given, marks)
    watcher = Watcher(ours, motion, watch)
    watcher.show(motion.apply(ours.mesh.vertices))
    if chosen.rule == "literal":
        if regions is not None:
            raise InvalidInput('regions are not part of the literal form; take rule="nearest"')
        return literal.registered(
            ours, theirs, shape, marks, motion, seed, chosen, progress, watcher
        )
    known = expectation(ours, theirs, motion, marks)
    watcher.show(known.points * np.sqrt(theirs.mesh.face_areas.sum()))
    laying = part(progress, 0.1, 0.5)
    model, onto = _on_spheres(ours, theirs, shape, known, seed, chosen, laying, watcher)
    view = watcher.over(onto, theirs.mesh)
    view.show(model)
    progress("unfolding onto the target", 0.5)  # algorithm 2, step 3
    model = brought_together(model, onto, known.landmarks, marks)
    view.show(model)
    model = unfolded(model, onto, known, chosen, seed)
    model = brought_together(model, onto, known.landmarks, marks)
    view.show(model)
    progress(f"refining, {_far(model, onto)} so far", 0.6)  # algorithm 1, steps 9 to 11
    refinement = Refinement(onto, known, where, chosen, seed)
    model = refinement.refined(model, part(progress, 0.6, 0.9), view)
    view.show(model)
    progress(f"measuring, {_far(model, onto)}", 0.9)
    result = registration(ours, theirs, model, onto, marks, motion)
    progress("done", 1.0)
    return result


def _far(model: OnSphere, onto: OnSphere) -> str:
    """How far the target's vertices are from the model, for a message."""
    result = Mesh(points_on(onto.mesh, onto.locate(model.directions)), model.mesh.faces)
    mean = surface_distance(onto.mesh, result).mean / onto.mesh.diagonal
    return f"mean distance {mean:.2%}"


def _on_spheres(
    ours: Closed,
    theirs: Closed,
    shape: Closed | None,
    known: Expectation,
    seed: int,
    settings: Settings,
    progress: Progress,
    watcher: Watcher,
) -> tuple[OnSphere, OnSphere]:
    """Both surfaces on one sphere (algorithm 2, step 1: I' and F')."""
    progress("laying the source out on the sphere", 0.0)
    model = OnSphere.of(ours.mesh)
    progress("laying the target out on the sphere", 0.3)
    onto = OnSphere.of(theirs.mesh)
    nobody = no_landmarks()
    if shape is None:
        return turned(model, onto, known), onto
    progress("laying the mediator out on the sphere", 0.55)
    between = OnSphere.of(shape.mesh)
    to_shape = aligned(ours.given, shape.given, nobody), aligned(theirs.given, shape.given, nobody)
    placed = Mesh(to_shape[1].undo(shape.mesh.vertices), shape.mesh.faces)
    views = watcher.over(between, placed), UNSEEN
    drawn = []
    for i, side in enumerate((ours, theirs)):
        said = f"bringing the {side.name} to the mediator"
        bringing = part(progress, 0.6 + 0.2 * i, 0.8 + 0.2 * i, said)
        bringing(said, 0.0)
        places = expectation(side, shape, to_shape[i], nobody)
        start = turned((model, onto)[i], between, places)
        start = unfolded(start, between, places, settings, seed)
        refinement = Refinement(between, places, anywhere(side), settings, seed)
        drawn.append(refinement.refined(start, bringing, views[i]))
    return drawn[0], drawn[1]


def registration(
    ours: Closed,
    theirs: Closed,
    model: OnSphere,
    onto: OnSphere,
    marks: Landmarks,
    motion: Similarity,
) -> Registration:
    """The result: every vertex of the source where the target is in its direction."""
    count = len(ours.used)
    places = onto.locate(model.directions[:count])
    landed = points_on(theirs.mesh, places)[np.searchsorted(ours.used, marks.vertices)]
    error = np.linalg.norm(landed - marks.points, axis=1).max(initial=0.0)
    own = theirs.is_own(places.face)
    face = np.full(len(ours.given.vertices), -1, dtype=np.int32)
    barycentric = np.zeros((len(face), 3))
    face[ours.used] = np.where(own, places.face, -1)
    barycentric[ours.used] = np.where(own[:, None], places.barycentric, 0)
    face[marks.vertices], barycentric[marks.vertices] = marks.places.face, marks.places.barycentric
    on_target = SurfacePoints(face, barycentric)
    vertices = points_on(theirs.given, on_target)
    vertices[marks.vertices] = marks.points
    missing = face < 0
    if missing.all():
        raise Infeasible(
            "the whole source comes to lie in holes of the target; give landmarks, or a target "
            "with more surface than holes"
        )
    vertices = bridged(ours.given, np.where(missing[:, None], 0, vertices), missing)
    inverted = len(inverted_on_sphere(model.directions, model.mesh.faces))
    quality = measured(
        ours.given, theirs.given, vertices, missing, error / theirs.given.diagonal, inverted
    )
    return Registration.of(
        ours.given, theirs.given, vertices, on_target, marks.vertices, motion, quality
    )
