"""Watching a registration: what is shown on the way, and that it changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy, with_unused_vertices
from henkei.errors import Cancelled
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Floats, Mesh
from henkei.register.alignment import aligned
from henkei.register.landmarks import no_landmarks
from henkei.register.settings import Settings

SOURCE, TARGET = bumpy(3, 0), bumpy(3, 1)
ROUNDING = 1e-9  # by the size of the bodies, about 1


def watched(*surfaces: Mesh, **options: object) -> tuple[hk.Registration, list[Floats]]:
    shown: list[Floats] = []
    return hk.register(*surfaces, watch=shown.append, **options), shown


def away(points: Floats, surface: Mesh) -> float:
    return float(ClosestPoints(surface).query(points)[1].max())


@pytest.fixture(scope="module")
def usual() -> tuple[hk.Registration, list[Floats]]:
    return watched(SOURCE, TARGET)


def test_it_changes_nothing(usual):
    result, shown = usual
    alone = hk.register(SOURCE, TARGET)
    assert alone.mesh.vertices.tobytes() == result.mesh.vertices.tobytes()
    assert alone.quality == result.quality
    assert len({id(one) for one in shown}) == len(shown)


def test_it_begins_with_the_source_where_it_was_aligned(usual):
    result, shown = usual
    np.testing.assert_allclose(shown[0], result.similarity.apply(SOURCE.vertices), atol=ROUNDING)


def test_it_ends_with_the_result(usual):
    result, shown = usual
    np.testing.assert_allclose(shown[-1], result.mesh.vertices, atol=ROUNDING)


def test_from_space_it_comes_onto_the_target_and_stays_there_while_it_moves(usual):
    _, shown = usual
    on_target = [away(points, TARGET) < ROUNDING for points in shown]
    assert not on_target[0]
    assert on_target == sorted(on_target)
    last = [points for points, on in zip(shown, on_target, strict=True) if on]
    assert len({points.tobytes() for points in last}) > 3


def test_it_is_shown_on_the_mediator():
    target, mediator = bumpy(2, 4), bumpy(2, 2)
    _, shown = watched(bumpy(2, 0), target, mediator=mediator)
    to_mediator = aligned(target, mediator, no_landmarks())
    on_mediator = [away(to_mediator.apply(points), mediator) < ROUNDING for points in shown]
    on_target = [away(points, target) < ROUNDING for points in shown]
    assert any(on_mediator)
    first = on_target.index(True)
    assert on_mediator.index(True) < first
    assert all(on_target[first:])


def test_vertices_without_a_face_move_along():
    source = with_unused_vertices(SOURCE, [0, 51])
    result, shown = watched(source, TARGET)
    for points in shown:
        np.testing.assert_allclose(
            points[[0, 51]], result.similarity.apply(source.vertices[[0, 51]]), atol=ROUNDING
        )
    assert away(shown[-1][source.indices], TARGET) < ROUNDING


def test_onto_a_target_with_a_hole():
    middles = TARGET.vertices[TARGET.faces].mean(axis=1)
    cut = Mesh(TARGET.vertices, TARGET.faces[middles[:, 2] < 0.8])
    result, shown = watched(SOURCE, cut)
    assert result.quality.bridged > 0
    assert np.isfinite(shown).all()
    placed = result.on_target.face >= 0
    np.testing.assert_allclose(shown[-1][placed], result.mesh.vertices[placed], atol=ROUNDING)


def test_the_literal_form_begins_and_ends_alike():
    result, shown = watched(bumpy(1, 0), bumpy(2, 1), settings=Settings(rule="literal"))
    moved = result.similarity.apply(result.correspondence.vertices_a)
    np.testing.assert_allclose(shown[0], moved, atol=ROUNDING)
    np.testing.assert_allclose(shown[-1], result.mesh.vertices, atol=ROUNDING)


@pytest.mark.parametrize("after", [0, 2, 6])
def test_raising_while_watching_ends_it(after):
    seen: list[Floats] = []

    def watch(points: Floats) -> None:
        seen.append(points)
        if len(seen) > after:
            raise Cancelled("enough")

    with pytest.raises(Cancelled, match="enough"):
        hk.register(SOURCE, TARGET, watch=watch)
    assert len(seen) == after + 1


def test_raising_in_the_middle_of_the_refinement_ends_it():
    told: list[float] = []

    def progress(message: str, fraction: float) -> None:
        told.append(fraction)
        if message == "refining" and fraction > 0.62:
            raise Cancelled("enough")

    with pytest.raises(Cancelled, match="enough"):
        hk.register(SOURCE, TARGET, progress=progress)
    assert 0.62 < told[-1] < 0.8


def test_by_a_recipe():
    shown: list[Floats] = []
    result = hk.register_by_recipe(SOURCE, TARGET, {"seed": 3}, watch=shown.append)
    np.testing.assert_allclose(shown[-1], result.mesh.vertices, atol=ROUNDING)
