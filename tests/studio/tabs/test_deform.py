"""Deforming live gives what the recipe gives, whatever was done on the way."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from deform_desk import SIZE, Desk
from henkei.errors import HenkeiError, InvalidInput
from henkei.mesh import Mesh
from henkei.recipes.deform import DeformRecipe
from henkei.shapes import bracket, bumper, bumper_parts, grid
from henkei.studio import deform_view
from henkei.studio.tabs.deform import TAB


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path, bumper(SIZE))


def test_what_is_to_be_done_next_is_told(desk: Desk) -> None:
    assert "press Fix" in desk.view["next"]
    desk.select(bumper_parts(SIZE)["sides"])
    desk.do("add", kind="fixed")
    assert "press Handle" in desk.view["next"]
    assert_array_equal(desk.positions, desk.surface.vertices)
    desk.select(bumper_parts(SIZE)["handle"])
    desk.do("add", kind="handles")
    assert "drag" in desk.view["next"]
    desk.do("move_handle", name="handle 1", move={"translation": [0, 0, 9]})
    assert desk.view["next"] is None
    assert_allclose(desk.positions, desk.by_recipe, atol=1e-9)
    assert desk.view["figures"][4]["value"] == "exactly"


def test_a_handle_is_dragged_by_a_basis_and_committed(desk: Desk) -> None:
    desk.bend()
    desk.do("keep", names=["hole 1", "hole 5"])
    basis = desk.grab(name="handle 1")
    assert basis is not None
    for step in ([0, 0, 5], [3, -2, 20.0]):
        blended = basis.start + basis.response[:, None] * step
        live = desk.live("move_handle", name="handle 1", move={"translation": step})
        assert_allclose(blended, live, atol=1e-6)
    desk.do("move_handle", name="handle 1", move={"translation": [3, -2, 20.0]})
    assert_allclose(desk.positions, live, atol=1e-6)
    assert_allclose(desk.positions, desk.by_recipe, atol=1e-9)


def test_where_there_is_no_basis_frames_come(desk: Desk) -> None:
    assert desk.grab(name="handle 1") is None
    desk.bend()
    assert desk.grab(name="another") is None
    desk.do("change", recipe={"method": "refined"})
    assert desk.grab(name="handle 1") is None
    move = {"translation": [0, 0, 30], "rotation": [20, 0, 0]}
    live = desk.live("move_handle", name="handle 1", move=move)
    desk.do("move_handle", name="handle 1", move=move)
    assert_allclose(live, desk.by_recipe, atol=1e-9)


def test_parts_tell_their_vertices_and_poses(desk: Desk) -> None:
    desk.bend()
    handle = bumper_parts(SIZE)["handle"]
    told = desk.part("handle 1")
    assert_array_equal(told["ids"], np.unique(handle))
    assert_allclose(told["centre"], desk.surface.vertices[np.unique(handle)].mean(axis=0))
    about = {"rotation": {"axis": [0, 0, 2], "angle": 90}, "about": [0, 0, 0]}
    desk.do("move_handle", name="handle 1", move=about)
    turned = desk.part("handle 1")["move"]
    assert_allclose(turned["rotation"], [0, 0, 90])
    was = desk.positions
    desk.do("move_handle", name="handle 1", move=turned)
    assert_allclose(desk.positions, was, atol=1e-9)
    assert_allclose(desk.part("handle 1")["move"]["translation"], turned["translation"])


def test_what_was_found_keeps_its_name_in_the_recipe(desk: Desk) -> None:
    rim = desk.view["found"][0]
    assert (rim["name"], rim["part"]) == ("rim 1", None)
    desk.do("select_region", region="rim 1")
    assert len(desk.state.selection) == rim["count"]
    desk.do("add", kind="fixed")
    assert desk.state.recipe.fixed[0].region.feature == "rim 1"
    desk.do("keep", names=["hole 7"])
    hole = desk.state.recipe.features[0]
    assert (hole.region.feature, hole.keep) == ("hole 7", "circle")
    assert desk.view["found"][7]["part"] == "hole 7"
    desk.do("set_feature", name="hole 7", radius=20.0, keep="circle")
    assert desk.part("hole 7")["rest_radius"] == pytest.approx(16, rel=0.01)
    assert_allclose(desk.positions, desk.by_recipe, atol=1e-9)
    assert any(row["label"] == "Radius of hole 7" for row in desk.view["figures"])
    desk.do("set_feature", name="hole 7", keep="circle")
    assert_allclose(desk.positions, desk.surface.vertices, atol=1e-9)


def test_vertices_of_other_parts_are_left_out_and_told(desk: Desk) -> None:
    desk.bend()
    desk.do("keep", names=["pad 1", "hole 1"])
    desk.do("select_region", region="pad 1", mode="replace")
    with pytest.raises(InvalidInput, match="belong to other parts"):
        desk.do("add", kind="handles")
    desk.do("grow", rings=3)
    desk.do("add", kind="features")
    assert "left out" in desk.told[-1]
    bodies = [set(desk.part(name)["ids"].tolist()) for name in ("pad 1", "feature 1")]
    assert not bodies[0] & bodies[1]
    assert desk.view["trouble"] is None


def test_a_hole_that_is_partly_fixed_stays_rigid(desk: Desk) -> None:
    hole = desk.services.blobs.get_message(desk.view["found"][5]["ids"]).arrays["values"]
    desk.select(hole[:20])
    desk.do("add", kind="fixed")
    desk.do("keep", names=["hole 5", "hole 6"])
    assert "of hole 5" in desk.told[-1]
    first, second = desk.state.recipe.features
    assert (first.kept, second.kept) == ("rigid", "circle")
    assert [one["part"] for one in desk.view["found"][5:7]] == ["hole 5", "hole 6"]


def test_one_hole_is_taken_out_of_all(desk: Desk) -> None:
    desk.do("load", recipe={"fixed": ["rim 1"], "features": ["hole *"]})
    holes = [one["name"] for one in desk.view["found"] if one["kind"] == "hole"]
    assert {one["part"] for one in desk.view["found"] if one["kind"] == "hole"} == {"hole *"}
    desk.do("keep", names=["hole 3"], kept=False)
    assert desk.state.recipe.names("features") == [name for name in holes if name != "hole 3"]
    pattern = {"name": "pattern", "region": "hole *"}
    desk.do("load", recipe={"fixed": ["rim 1"], "features": [pattern]})
    before = set(desk.part("pattern")["ids"].tolist())
    desk.do("keep", names=["hole 3"], kept=False)
    hole = next(one for one in desk.view["found"] if one["name"] == "hole 3")
    assert len(before) - len(desk.part("pattern")["ids"]) == hole["count"]


def test_parts_without_names_get_some_that_stay(desk: Desk) -> None:
    boxes = [{"box": [[x, None, None], [x + 60, None, None]]} for x in (-700, 640)]
    handle = {"region": {"sphere": {"center": [0, 295, -12], "radius": 60}}}
    desk.do("load", recipe={"fixed": boxes, "handles": [handle]})
    desk.do("remove", kind="fixed", name="fixed 1")
    assert desk.state.recipe.names("fixed") == ["fixed 2"]


def test_offsets_follow_names_and_go_with_their_features(desk: Desk) -> None:
    desk.bend()
    desk.do("keep", names=["hole 7", "hole 8"])
    desk.do("change", recipe={"offsets": [{"between": ["hole 7", "hole 8"]}]})
    desk.do("rename", kind="features", name="hole 7", to="left")
    assert desk.state.recipe.offsets[0].between == ("left", "hole 8")
    desk.do("move_handle", name="handle 1", move={"translation": [0, 0, 15]})
    assert_allclose(desk.positions, desk.by_recipe, atol=1e-9)
    desk.do("remove", kind="features", name="left")
    assert desk.state.recipe.offsets == ()


def test_a_mirror_is_found_and_a_wrong_one_refused(desk: Desk) -> None:
    desk.bend()
    desk.do("mirror", axis="x")
    assert desk.state.recipe.symmetry.normal == (1, 0, 0)
    before = desk.state
    with pytest.raises(InvalidInput, match="not symmetric"):
        desk.do("mirror", axis="y")
    with pytest.raises(InvalidInput, match="at x = 5"):
        desk.do("mirror", axis="x", at=5.0)
    assert desk.state is before
    basis = desk.grab(name="handle 1")
    assert basis is not None
    assert basis.response.shape == (3, len(desk.surface.vertices), 3)
    blended = basis.start + np.einsum("k,knj->nj", [0, 2, 9], basis.response)
    live = desk.live("move_handle", name="handle 1", move={"translation": [0, 2, 9]})
    assert_allclose(blended, live, atol=1e-6)
    desk.do("mirror", axis=None)
    assert desk.state.recipe.symmetry is None


def test_a_mesh_beside_the_origin_has_its_mirror_in_its_middle(tmp_path: Path) -> None:
    flat = grid(6, 6)
    desk = Desk(tmp_path, Mesh(flat.vertices + np.array([50, 0, 0]), flat.faces))
    desk.do("mirror", axis="x")
    low, high = desk.surface.vertices[:, 0].min(), desk.surface.vertices[:, 0].max()
    assert desk.state.recipe.symmetry.point[0] == pytest.approx((low + high) / 2)


def test_pins_are_set_where_the_surface_is_and_moved(desk: Desk) -> None:
    desk.bend()
    desk.do("move_handle", name="handle 1", move={"translation": [0, 0, 15]})
    was = desk.positions
    desk.do("add_pin", vertex=700)
    assert_allclose(desk.positions, was, atol=1e-6)
    to = (was[700] + [1, 2, 3]).tolist()
    live = desk.live("move_pin", name="pin 1", to=to)
    assert_allclose(live[700], to, atol=1e-9)
    desk.do("move_pin", name="pin 1", to=to)
    assert desk.part("pin 1") == {"kind": "pins", "name": "pin 1", "vertex": 700, "to": to}
    assert_allclose(desk.positions, desk.by_recipe, atol=1e-9)
    with pytest.raises(InvalidInput, match="does not exist"):
        desk.do("add_pin", vertex=10**7)


def test_contradictions_are_told_and_the_surface_stays(desk: Desk) -> None:
    desk.bend()
    desk.do("keep", names=["hole 1"])
    hole = desk.part("hole 1")["ids"]
    for vertex in (int(hole[0]), int(hole[30])):
        desk.do("add_pin", vertex=vertex)
    was = desk.positions
    apart = {"name": "pin 1", "to": (was[hole[0]] + [0, 0, 9]).tolist()}
    assert_array_equal(desk.live("move_pin", **apart), was)
    desk.do("move_pin", **apart)
    assert "contradict" in desk.view["trouble"]
    assert_array_equal(desk.positions, was)
    desk.do("select_vertices", vertices=[3])  # all else goes on
    desk.do("remove", kind="pins", name="pin 1")
    assert desk.view["trouble"] is None


def test_what_does_not_fit_is_refused_and_changes_nothing(desk: Desk) -> None:
    desk.bend()
    desk.do("keep", names=["pad 1"])
    before, engine = desk.state, desk.services.present("deform")
    refused: list[tuple[str, dict[str, Any]]] = [
        ("set_feature", {"name": "pad 1", "keep": "line"}),
        ("keep", {"names": ["hole 99"]}),
        ("change", {"recipe": {"finding": {"angle": 30.0, "smallest": 0.5}}}),
        ("change", {"recipe": {"settings": {"steps": "many"}}}),
        ("rename", {"kind": "handles", "name": "handle 1", "to": "pad 1"}),
        ("remove", {"kind": "pins", "name": "pin 9"}),
        ("load", {"recipe": {"fixed": ["hole 99"]}}),
        ("load", {"recipe": {"fixed": [{"file": "/etc/passwd"}]}}),
        ("select_region", {"region": {"without": ["rim 1", {"file": "/etc/passwd"}]}}),
        ("select_vertices", {"vertices": [10**6]}),
        ("use", {"slot": "mesh", "mesh": "m7"}),
    ]
    for action, arguments in refused:
        with pytest.raises(HenkeiError):
            desk.do(action, **arguments)
        assert desk.state is before
    assert desk.services.present("deform") is engine


def test_large_meshes_are_searched_when_asked_for(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deform_view, "MANY_VERTICES", 100)
    desk.bend()
    view = desk.view
    assert view["found"] is None
    assert view["figures"] == []
    assert view["parts"]
    desk.do("find")
    assert desk.view["found"][0]["name"] == "rim 1"


def test_without_a_mesh_there_is_nothing(tmp_path: Path) -> None:
    desk = Desk(tmp_path, bracket())
    desk.do("use", slot="mesh", mesh=None)
    assert desk.view == {"surfaces": {}}
    assert TAB.frames(desk.state, desk.services) == {}
    assert desk.grab(name="handle 1") is None
    with pytest.raises(InvalidInput, match="no mesh is chosen"):
        desk.do("find")


names = st.sampled_from(["hole 1", "hole 7", "pad 1", "rim 1", "handle 1", "pin 1", "x", "hole *"])
kinds = st.sampled_from(["fixed", "handles", "features", "pins"])
few = st.floats(-30, 30)
steps = st.one_of(
    st.tuples(
        st.just("select_vertices"),
        st.fixed_dictionaries(
            {
                "vertices": st.lists(st.integers(0, 1900), max_size=9),
                "mode": st.sampled_from(["replace", "add", "subtract", "toggle"]),
            }
        ),
    ),
    st.tuples(st.just("select_region"), st.fixed_dictionaries({"region": names})),
    st.tuples(st.just("grow"), st.fixed_dictionaries({"rings": st.integers(-2, 3)})),
    st.tuples(st.just("invert"), st.just({})),
    st.tuples(st.just("add"), st.fixed_dictionaries({"kind": kinds})),
    st.tuples(
        st.just("keep"),
        st.fixed_dictionaries({"names": st.lists(names, max_size=3), "kept": st.booleans()}),
    ),
    st.tuples(st.just("remove"), st.fixed_dictionaries({"kind": kinds, "name": names})),
    st.tuples(
        st.just("rename"), st.fixed_dictionaries({"kind": kinds, "name": names, "to": names})
    ),
    st.tuples(
        st.just("move_handle"),
        st.fixed_dictionaries(
            {
                "name": names,
                "move": st.fixed_dictionaries(
                    {"translation": st.tuples(few, few, few), "rotation": st.tuples(few, few, few)}
                ),
            }
        ),
    ),
    st.tuples(
        st.just("set_feature"),
        st.fixed_dictionaries(
            {
                "name": names,
                "scale": st.floats(0.5, 2),
                "keep": st.sampled_from(["rigid", "circle", "plane", "line"]),
                "radius": st.none() | st.floats(5, 50),
            }
        ),
    ),
    st.tuples(st.just("add_pin"), st.fixed_dictionaries({"vertex": st.integers(0, 2100)})),
    st.tuples(
        st.just("move_pin"),
        st.fixed_dictionaries({"name": names, "to": st.tuples(few, few, few)}),
    ),
    st.tuples(st.just("mirror"), st.fixed_dictionaries({"axis": st.sampled_from(["x", None])})),
)


@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(done=st.lists(steps, min_size=4, max_size=10), bent=st.booleans())
def test_whatever_is_done_the_tab_can_be_shown(
    done: list[tuple[str, dict[str, Any]]], bent: bool, tmp_path: Path
) -> None:
    desk = Desk(tmp_path, bumper(SIZE))
    if bent:
        desk.bend()
    for action, arguments in done:
        before = desk.state
        with suppress(HenkeiError):
            desk.do(action, **arguments)
        view, positions = desk.view, desk.positions
        assert positions.shape == desk.surface.vertices.shape
        assert np.isfinite(positions).all()
        assert DeformRecipe.of(desk.state.recipe.model_dump()) == desk.state.recipe
        assert len(view["parts"]) <= len(desk.state.selection) + 40
        if desk.state is not before and view["trouble"] is None and not desk.state.missing:
            size = desk.surface.diagonal
            assert_allclose(positions, desk.by_recipe, atol=1e-7 * size)
