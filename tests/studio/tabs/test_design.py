"""Designing live gives what the recipe gives, whatever was done on the way."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import henkei as hk
from cages import CAGES, fine
from henkei.errors import HenkeiError, InvalidInput
from henkei.mesh import Floats, Surface
from henkei.recipes.design import DesignRecipe
from henkei.shapes import cube_cage, sheet_cage, tetrahedron_cage, torus_cage
from henkei.studio import designing
from henkei.studio.design_state import DesignState, named
from henkei.studio.designing import Engine, pulled
from henkei.studio.tabs.base import Basis
from henkei.studio.tabs.design import TAB
from henkei.workflows.design_examples import EXAMPLES
from tab_desk import TabDesk

CLOSE = 1e-11  # of surfaces about as large as 1


class Desk(TabDesk[DesignState]):
    """The tab with a cage on it."""

    def __init__(self, folder: Path, cage: Surface, recipe: dict[str, Any] | None = None) -> None:
        super().__init__(folder, TAB, DesignState(), "surface", cage)
        self.do("load", recipe={"levels": 2, **(recipe or {})})

    @property
    def by_recipe(self) -> Floats:
        """By the recipe alone, at the level that is shown."""
        designed = hk.design_by_recipe(self.surface, self.state.recipe)
        level = self.view["shown"]
        return np.asarray(designed.designer.surface(level).vertices)


def blended(basis: Basis, by: Floats) -> Floats:
    """What a page makes of a drag."""
    response = basis.response[:, None] if basis.response.ndim == 1 else basis.response
    return np.asarray(basis.start + response * by)


@pytest.mark.parametrize("name", CAGES)
def test_any_cage_is_shown_at_every_level(name: str, tmp_path: Path) -> None:
    desk = Desk(tmp_path, CAGES[name]())
    for level in range(3):
        desk.do("show", level=level)
        view = desk.view
        assert "problem" not in view
        message = desk.services.blobs.get_message(_drawn(view))
        header, arrays = message.header, message.arrays
        flat = fine(desk.surface, level).vertices
        size = view["levels"][level]
        assert (header["vertices"], header["faces"]) == (size["vertices"], size["faces"])
        assert_allclose(arrays["positions"] * header["scale"] + header["centre"], flat, atol=1e-6)
        assert len(desk.positions) == len(flat)
        assert_allclose(desk.positions, desk.by_recipe, atol=CLOSE)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=12, deadline=None)
def test_whatever_is_done_gives_what_the_recipe_gives(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    rng = np.random.default_rng(seed)
    names = list(CAGES)
    desk = Desk(tmp_path_factory.mktemp("s"), CAGES[names[seed % len(names)]]())
    before = [desk.state]
    for _ in range(8):
        _do_something(desk, rng)
        before.append(desk.state)
        if rng.random() < 0.2:
            desk.state = before[rng.integers(len(before))]  # undone
        assert_allclose(desk.positions, desk.by_recipe, atol=CLOSE)


def _do_something(desk: Desk, rng: np.random.Generator) -> None:
    """One edit at random; some are refused, and change nothing."""
    level = int(rng.integers(desk.state.recipe.levels + 1))
    vertex = int(rng.integers(desk.view["levels"][level]["vertices"]))
    recipe, move = desk.state.recipe, rng.normal(size=3) / 10
    names = [name for kind in ("pins", "curves") for name in recipe.names(kind)]
    edits: list[tuple[str, dict[str, Any]]] = [
        ("add_pin", {"level": level, "vertex": vertex}),
        ("draw", {"level": level, "vertex": vertex}),
        ("end_curve", {}),
        ("show", {"level": level}),
        ("change", {"gamma": float(rng.uniform(0.3, 9))}),
        ("change", {"axis_gamma": rng.uniform(0.3, 9, 3).tolist()}),
        ("change", {"axis_gamma": "off", "axis_smoothing": [True, bool(rng.integers(2)), True]}),
        ("change", {"steps": int(rng.integers(1, 20))}),
        ("change", {"interpolating": bool(rng.integers(2))}),
        ("hold", {"held": False, "vertices": [int(rng.integers(len(desk.surface.vertices)))]}),
        ("hold", {"held": True}),
        ("set_levels", {"levels": int(rng.integers(1, 4))}),
    ]
    if names:
        name = names[rng.integers(len(names))]
        edits += [("remove", {"name": name}), ("rename", {"name": name, "to": "another"})]
    if recipe.pins:
        name = recipe.names("pins")[rng.integers(len(recipe.pins))]
        edits += 2 * [("move_pin", {"name": name, "to": rng.normal(size=3).tolist()})]
    if recipe.curves:
        name = recipe.names("curves")[rng.integers(len(recipe.curves))]
        edits += 2 * [("move_curve", {"name": name, "by": move.tolist()})]
        edits += [("move_curve", {"name": name, "by": move.tolist(), "index": 0, "reach": 0.3})]
    action, arguments = edits[rng.integers(len(edits))]
    with suppress(HenkeiError):
        desk.do(action, **arguments)


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_are_met(name: str, tmp_path: Path) -> None:
    desk = Desk(tmp_path, EXAMPLES[name].cage(), EXAMPLES[name].recipe | {"levels": 4})
    assert desk.view["shown"] == desk.state.recipe.levels
    assert desk.view["warnings"] == []
    assert all("to" in part for part in desk.view["parts"])
    assert_array_equal(desk.positions, desk.by_recipe)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_new_pin_changes_nothing_at_its_level_there(level: int, tmp_path: Path) -> None:
    desk = Desk(tmp_path, torus_cage())
    desk.do("show", level=level)
    before, vertex = desk.positions, desk.view["levels"][level]["vertices"] - 1
    desk.do("add_pin", level=level, vertex=vertex)
    (part,) = desk.view["parts"]
    assert part["vertex"] == vertex
    assert_allclose(part["to"], before[vertex], atol=CLOSE)
    assert_allclose(desk.positions[vertex], before[vertex], atol=CLOSE)
    assert np.abs(desk.positions - before).max() < 0.02  # of a torus about 3 wide


def test_a_pin_brings_its_vertex_where_it_is_put(tmp_path: Path) -> None:
    desk = Desk(tmp_path, cube_cage())
    desk.do("add_pin", level=2, vertex=60)
    desk.do("move_pin", name="pin 1", to=[1.5, 0.25, -2.0])
    assert_allclose(desk.positions[60], [1.5, 0.25, -2.0], atol=CLOSE)


def test_a_drag_is_what_is_committed_at_its_end(tmp_path: Path) -> None:
    desk = Desk(tmp_path, sheet_cage(3, 3), {"axis_gamma": [1, 2, 4]})
    for alike in (False, True):
        if alike:
            desk.do("change", axis_gamma="off")
        desk.do("load", recipe=desk.state.recipe.model_dump(exclude={"pins", "curves"}))
        desk.do("add_pin", level=1, vertex=20)
        for vertex in (16, 30, 40):
            desk.do("draw", level=1, vertex=vertex)
        desk.do("end_curve")
        to, by = np.array(desk.state.recipe.pins[0].to), np.array([0.1, -0.2, 0.3])
        pin = desk.grab(name="pin 1")
        whole = desk.grab(name="curve 1")
        point = desk.grab(name="curve 1", index=2, reach=0.4)
        assert pin is not None
        assert whole is not None
        assert point is not None
        assert (pin.response.ndim == 1) == alike
        one = {"name": "curve 1", "by": by.tolist()}
        expected = [
            (pin, desk.live("move_pin", name="pin 1", to=(to + by).tolist())),
            (whole, desk.live("move_curve", **one)),
            (point, desk.live("move_curve", **one, index=2, reach=0.4)),
        ]
        for basis, moved in expected:
            assert np.abs(moved - basis.start).max() > 0.05
            assert_allclose(blended(basis, by), moved, atol=CLOSE)


def test_what_is_finer_than_the_level_shown_answers_no_drag(tmp_path: Path) -> None:
    desk = Desk(tmp_path, cube_cage())
    desk.do("add_pin", level=2, vertex=60)
    desk.do("show", level=1)
    assert desk.grab(name="pin 1") is None
    assert "to" not in desk.view["parts"][0]


def test_faces_are_not_sent_again_for_pins_and_gamma(tmp_path: Path) -> None:
    desk = Desk(tmp_path, cube_cage())
    before, at = _drawn(desk.view), desk.positions
    desk.do("add_pin", level=1, vertex=10)
    desk.do("move_pin", name="pin 1", to=[2, 2, 2])
    desk.do("change", gamma=0.5)
    assert _drawn(desk.view) == before
    assert np.abs(desk.positions - at).max() > 0.1


def test_names_stay_when_others_go(tmp_path: Path) -> None:
    pins = [{"level": 1, "point": k, "move": [0, 0, 0.1]} for k in (9, 10, 11)]
    desk = Desk(tmp_path, cube_cage(), {"pins": pins})
    desk.do("remove", name="pin 1")
    assert desk.state.recipe.names("pins") == ["pin 2", "pin 3"]
    desk.do("add_pin", level=1, vertex=12)
    assert desk.state.recipe.names("pins") == ["pin 2", "pin 3", "pin 1"]
    with pytest.raises(InvalidInput, match="has the name"):
        desk.do("rename", name="pin 2", to="pin 3")


def test_a_curve_is_drawn_along_edges_and_ends(tmp_path: Path) -> None:
    desk = Desk(tmp_path, sheet_cage(4, 4))
    designer = hk.Designer(desk.surface, 2)
    corners = [
        designer.nearest(2, point) for point in ([0.2, 0.2, 0], [0.8, 0.2, 0], [0.8, 0.8, 0])
    ]
    for vertex in corners:
        desk.do("draw", level=2, vertex=vertex)
    assert desk.view["path"] == designer.path(2, corners)
    desk.do("draw", level=2, vertex=corners[-1])  # twice the same: nothing
    assert desk.view["path"] == designer.path(2, corners)
    at = desk.positions
    desk.do("end_curve")
    assert "path" not in desk.view
    (part,) = desk.view["parts"]
    assert part["path"] == designer.path(2, corners)
    assert_allclose(part["to"], at[part["path"]], atol=CLOSE)
    assert_allclose(desk.positions[part["path"]], part["to"], atol=CLOSE)


def test_a_curve_through_its_first_point_is_closed(tmp_path: Path) -> None:
    desk = Desk(tmp_path, sheet_cage(4, 4))
    for vertex in (6, 8, 18, 6):
        desk.do("draw", level=1, vertex=vertex)
    (part,) = desk.view["parts"]
    assert part["path"][0] == part["path"][-1] == 6
    desk.do("move_curve", name="curve 1", by=[0, 0, 0.2], index=0)
    (part,) = desk.view["parts"]
    assert_array_equal(part["to"][0], part["to"][-1])


def test_drawing_is_refused_where_it_cannot_go(tmp_path: Path) -> None:
    desk = Desk(tmp_path, CAGES["two pieces"]())
    with pytest.raises(InvalidInput, match="two points"):
        desk.do("end_curve")
    desk.do("draw", level=0, vertex=0)
    with pytest.raises(InvalidInput, match="two points"):
        desk.do("end_curve")
    with pytest.raises(InvalidInput, match="no edges lead"):
        desk.do("draw", level=0, vertex=5)
    with pytest.raises(InvalidInput, match="level 0"):
        desk.do("draw", level=1, vertex=5)
    desk.do("drop_curve")
    assert desk.state.stroke is None


def test_vertices_of_the_cage_are_let_go_and_held_again(tmp_path: Path) -> None:
    desk = Desk(tmp_path, cube_cage())
    held = desk.positions
    desk.do("hold", held=False, vertices=[0, 3])
    assert desk.view["free"] == [0, 3]
    freed = desk.positions
    assert np.abs(freed - held).max() > 0.01
    desk.do("hold", held=True, vertices=[3])
    assert_allclose(desk.positions, desk.by_recipe, atol=CLOSE)
    desk.do("hold", held=True)
    assert_array_equal(desk.positions, held)


def test_something_must_hold_the_surface(tmp_path: Path) -> None:
    desk = Desk(tmp_path, cube_cage())
    with pytest.raises(InvalidInput, match="add a pin"):
        desk.do("hold", held=False)
    for vertex in (8, 9, 20, 25):
        desk.do("add_pin", level=1, vertex=vertex)
    desk.do("hold", held=False)
    assert desk.state.recipe.unpin == "all"
    assert_allclose(desk.positions, desk.by_recipe, atol=1e-9)
    for number in (1, 2, 3):
        desk.do("remove", name=f"pin {number}")
    with pytest.raises(InvalidInput, match="add a pin"):
        desk.do("remove", name="pin 4")


def test_levels_and_refinement_keep_what_counts_on_them(tmp_path: Path) -> None:
    desk = Desk(tmp_path, tetrahedron_cage(), {"gamma": [1, 2, 3]})
    desk.do("add_pin", level=2, vertex=20)
    with pytest.raises(InvalidInput, match=r"'pin 1'.*at least 2"):
        desk.do("set_levels", levels=1)
    with pytest.raises(InvalidInput, match="how faces are cut"):
        desk.do("change", refinement="quads")
    desk.do("change", refinement="triangles")  # as they are cut already
    desk.do("set_levels", levels=3)
    assert desk.state.recipe.gamma == (1, 2, 3, 3)
    assert_allclose(desk.positions, desk.by_recipe, atol=CLOSE)
    desk.do("remove", name="pin 1")
    desk.do("change", refinement="quads")
    assert_allclose(desk.positions, desk.by_recipe, atol=CLOSE)
    desk.do("set_levels", levels=1)
    assert desk.state.recipe.gamma == (1, 2)


def test_conflicts_are_told_in_words(tmp_path: Path) -> None:
    desk = Desk(tmp_path, sheet_cage(4, 4))
    for vertex in (6, 8):
        desk.do("draw", level=1, vertex=vertex)
    desk.do("end_curve")
    desk.do("add_pin", level=1, vertex=desk.view["parts"][0]["path"][0])
    assert desk.view["warnings"] == []
    desk.do("move_pin", name="pin 1", to=[0.5, 0.5, 3.0])
    assert any("pin 1" in warning and "curve 1" in warning for warning in desk.view["warnings"])
    assert desk.view["conflicts"] == [["pin 1", "curve 1"]]


def test_edges_of_coarse_levels_come_first(tmp_path: Path) -> None:
    desk = Desk(tmp_path, CAGES["hexagonal prism"]())
    view = desk.view
    message = desk.services.blobs.get_message(_drawn(view))
    positions, edges = message.arrays["positions"].astype(float), message.arrays["edges"]
    lengths = np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1)
    for level, count in enumerate(view["grid"]):
        flat = fine(desk.surface, level)
        ends = flat.vertices[flat.topology.edges]
        whole = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
        assert_allclose(lengths[:count].sum() * message.header["scale"], whole, rtol=1e-5)


def test_large_levels_follow_settings_nearly_while_they_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(designing, "LIVE", 100)
    desk = Desk(tmp_path, cube_cage(), {"levels": 3, "gamma": 2.0})
    start = desk.positions
    assert desk.grab() is None
    assert_allclose(desk.live("change", gamma=2.0), start, atol=CLOSE)
    near = desk.live("change", gamma=8.0)
    desk.do("change", gamma=8.0)
    assert_array_equal(desk.positions, desk.by_recipe)
    moved = np.abs(desk.positions - start).max()
    assert 0 < np.abs(near - desk.positions).max() < moved / 3


def test_a_level_with_too_many_vertices_is_not_shown_unasked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(designing, "QUICK", 100)
    desk = Desk(tmp_path, cube_cage(), {"levels": 3})
    assert desk.view["shown"] == 2
    desk.do("show", level=3)
    assert desk.view["shown"] == 3


def test_a_mesh_that_is_no_cage_says_why(tmp_path: Path) -> None:
    fan = hk.Mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3], [1, 0, 2]])
    with pytest.raises(HenkeiError, match="manifold"):
        Desk(tmp_path, fan)
    desk = Desk(tmp_path, cube_cage())
    entry = desk.services.meshes[0]
    blob = desk.services.blobs.put_surface(fan)
    desk.services.meshes = (entry.model_copy(update={"surface": blob}),)
    assert "manifold" in desk.view["problem"]
    assert list(desk.view["surfaces"]) == ["cage"]
    with pytest.raises(HenkeiError, match="manifold"):
        desk.do("add_pin", level=0, vertex=0)


@pytest.mark.parametrize(
    ("action", "arguments", "told"),
    [
        ("add_pin", {"level": 7, "vertex": 0}, "no level 7"),
        ("add_pin", {"level": 1, "vertex": 26}, "no vertices 26"),
        ("add_pin", {"level": 1, "vertex": 1}, "already"),
        ("add_pin", {"level": -1, "vertex": 1}, "level"),
        ("move_pin", {"name": "nobody", "to": [0, 0, 0]}, "no 'nobody'"),
        ("move_pin", {"name": "pin 1", "to": [0, 0]}, "to"),
        ("move_pin", {"name": "pin 1", "to": [0, 0, float("nan")]}, "to"),
        ("move_curve", {"name": "pin 1", "by": [0, 0, 0]}, "no curve"),
        ("draw", {"level": 1, "vertex": 26}, "no vertices 26"),
        ("hold", {"held": False, "vertices": [8]}, "0 to 7"),
        ("show", {"level": 3}, "finest is 2"),
        ("change", {"gamma": 0}, "gamma"),
        ("change", {"gamma": 1e300}, "gamma"),
        ("change", {"axis_gamma": [1, 1, 1e300]}, "axis_gamma"),
        ("change", {"steps": 1000}, "steps"),
        ("change", {"colour": "red"}, "colour"),
        ("set_levels", {"levels": 99}, "levels"),
        ("load", {"recipe": {"pins": [{"level": 9, "point": 0}]}}, "level 9"),
        ("load", {"recipe": {"pins": [{"level": 1, "point": 26}]}}, "no vertex 26"),
        ("load", {"recipe": {"refinement": "triangles"}}, "no triangles"),
        ("nothing", {}, "no action"),
    ],
)
def test_what_cannot_be_done_is_refused(
    action: str, arguments: dict[str, Any], told: str, tmp_path: Path
) -> None:
    desk = Desk(tmp_path, cube_cage())
    desk.do("add_pin", level=1, vertex=1)
    with pytest.raises(InvalidInput, match=told):
        desk.do(action, **arguments)


def test_another_cage_begins_anew(tmp_path: Path) -> None:
    desk = Desk(tmp_path, cube_cage())
    desk.do("add_pin", level=1, vertex=1)
    desk.do("use", slot="cage", mesh=None)
    assert desk.state == DesignState()
    assert desk.view["surfaces"] == {}
    assert TAB.frames(desk.state, desk.services) == {}


@given(
    index=st.integers(0, 6),
    reach=st.floats(0, 1),
    by=st.tuples(*[st.floats(-1, 1)] * 3),
    closed=st.booleans(),
)
def test_a_pulled_point_goes_all_the_way_and_others_less(
    index: int, reach: float, by: tuple[float, float, float], closed: bool
) -> None:
    angle = np.linspace(0, 2 * np.pi if closed else 4.0, 7)
    line = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    if closed:
        line[-1] = line[0]
    moved = pulled(line, index, np.array(by), reach) - line
    assert_allclose(moved[index], by, atol=1e-15)
    share = np.linalg.norm(moved, axis=1)
    assert (share <= np.linalg.norm(by) + 1e-12).all()
    if closed:
        assert_array_equal(moved[0], moved[-1])
    if reach == 0:
        still = np.arange(7) != index
        if closed and index in (0, 6):
            still[[0, 6]] = False
        assert not moved[still].any()


def test_a_recipe_with_names_is_the_same_surface() -> None:
    recipe = DesignRecipe.of(EXAMPLES["torus"].recipe | {"levels": 2})
    unnamed = DesignRecipe.of(
        {**recipe.model_dump(), "pins": [p.model_dump(exclude={"name"}) for p in recipe.pins]}
    )
    said = named(unnamed)
    assert said.names("pins") == unnamed.names("pins") == [pin.name for pin in said.pins]
    engine = Engine(torus_cage(), said)
    assert_array_equal(engine.positions(said, 2), engine.positions(unnamed, 2))


def _drawn(view: dict[str, Any]) -> str:
    drawn: str = view["surfaces"]["surface"]["data"]
    return drawn
