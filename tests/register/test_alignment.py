"""Position, size and turn before the start: found without landmarks, exact with them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bodies import bumpy, moved
from henkei.mesh import Mesh
from henkei.register.alignment import aligned
from henkei.register.landmarks import no_landmarks, resolved
from henkei.register.surfaces import Closed
from henkei.shapes import icosphere, quadruped, random_blob

BODIES = {
    "potato": bumpy(3, 1),
    "limbs": random_blob(800, 0),
    "other limbs": random_blob(1000, 5, limbs=3),
    "animal": quadruped(),
}
TURNS = [(0, 0, 0), (np.pi, 0, 0), (0, np.pi / 2, 0), (1, 2, 0.5), (-0.3, 0.1, 2.5)]


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("name", ["potato", "limbs"])
def test_a_turned_body_is_turned_back(name, turn):
    """All signs of the principal axes are tried, so upside down is no harder than upright."""
    body = BODIES[name]
    target = moved(body, 2.5, turn, (10, 20, 30))
    motion = aligned(body, target, no_landmarks())
    away = np.linalg.norm(motion.apply(body.vertices) - target.vertices, axis=1)
    assert away.max() < 1e-3 * target.diagonal
    assert motion.scale == pytest.approx(2.5, rel=1e-6)
    assert np.linalg.det(motion.rotation) == pytest.approx(1)


@pytest.mark.parametrize("scale", [1e-6, 1, 1e6])
def test_landmarks_decide(scale):
    body = BODIES["potato"]
    target = moved(body, scale, (1, 2, 3), (4 * scale, 5 * scale, 6 * scale))
    sides = Closed.of("source", body), Closed.of("target", target)
    marks = resolved(*sides, [[0, 0], [9, 9], [100, 100], [400, 400]])
    motion = aligned(body, target, marks)
    np.testing.assert_allclose(motion.apply(body.vertices), target.vertices, atol=1e-9 * scale)


def test_wrong_landmarks_are_obeyed():
    """They may say that what is up here is down there."""
    body = BODIES["potato"]
    down = moved(body, turn=(np.pi, 0, 0)).vertices
    ours = np.array([0, 9, 100, 400])
    theirs = np.linalg.norm(down[ours, None] - body.vertices, axis=2).argmin(axis=1)
    sides = Closed.of("source", body), Closed.of("target", body)
    motion = aligned(body, body, resolved(*sides, np.stack([ours, theirs], axis=1)))
    turn = Rotation.from_matrix(motion.rotation).as_rotvec()
    assert abs(turn[0]) > 2.5


@pytest.mark.parametrize("pairs", [[[5, 5]], [[5, 5], [200, 200]]])
def test_landmarks_that_leave_the_turn_open(pairs):
    """The shape decides then."""
    body = BODIES["potato"]
    target = moved(body, 1, (2, 1, 0))
    sides = Closed.of("source", body), Closed.of("target", target)
    marks = resolved(*sides, pairs)
    away = aligned(body, target, marks).apply(body.vertices) - target.vertices
    assert np.abs(away).max() < 1e-3 * target.diagonal


@pytest.mark.parametrize(
    "pair", [("limbs", "other limbs"), ("potato", "limbs"), ("animal", "limbs")]
)
def test_never_mirrored(pair):
    source, target = (BODIES[name] for name in pair)
    mirrored = Mesh(target.vertices * [-1, 1, 1], target.faces[:, ::-1])
    for other in (target, mirrored):
        motion = aligned(source, other, no_landmarks())
        np.testing.assert_allclose(motion.rotation @ motion.rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(motion.rotation) == pytest.approx(1)
        ratio = Mesh(motion.apply(source.vertices), source.faces).diagonal / other.diagonal
        assert 0.5 < ratio < 2


def test_of_equals_the_given_turn_is_kept():
    """A ball looks the same from everywhere: it stays as it is."""
    ball = icosphere(2)
    motion = aligned(ball, moved(ball, 2, shift=(1, 0, 0)), no_landmarks())
    assert Rotation.from_matrix(motion.rotation).magnitude() < 0.1
