"""The combine tab: what is marked is a recipe, and what is made of it is what the recipe makes."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from bodies import bumpy, moved, together
from henkei.errors import InvalidInput
from henkei.geometry.rotation_path import KNOTS, RotationAwarePath
from henkei.mesh import Surface
from henkei.recipes.combine import CombineRecipe
from henkei.shapes import hemisphere, random_disk
from henkei.studio.blobs import Blobs
from henkei.studio.document import MeshEntry
from henkei.studio.services import Services
from henkei.studio.tabs.combine import TAB, CombineState
from henkei.studio.tasks import combine as task
from henkei.studio.tasks.combine import growth, quantile
from sheets import plate

A, B = random_disk(0, 30), random_disk(1, 40)
RIM_A, RIM_B = A.topology.boundary_loops[0], B.topology.boundary_loops[0]
PAIRS = [[0, 0], [5, 6], [10, 12]]
INSIDE = [
    [i, len(RIM_B) + int(np.linalg.norm(B.vertices[len(RIM_B) :] - A.vertices[i], axis=1).argmin())]
    for i in (20, 25)
]
PLACES = [[A.vertices[i].tolist(), B.vertices[j].tolist()] for i, j in PAIRS]


class Desk:
    """Meshes that are open, and the state of the tab."""

    def __init__(self, folder: Path, *surfaces: Surface) -> None:
        self.blobs = Blobs(folder)
        self.services = Services(self.blobs)
        self.state = CombineState()
        for number, surface in enumerate(surfaces or (A, B), 1):
            self.open(f"m{number}", surface)
        self.do("use", slot="a", mesh="m1")
        self.do("use", slot="b", mesh="m2")

    def open(self, ident: str, surface: Surface) -> None:
        entry = MeshEntry(
            id=ident,
            name=f"{ident}.ply",
            surface=self.blobs.put_surface(surface),
            vertices=len(surface.vertices),
            faces=surface.face_count,
        )
        self.services.meshes = (*self.services.meshes, entry)

    def do(self, action: str, **arguments: Any) -> None:
        self.state = TAB.action(action, arguments).apply(self.state, self.services)

    def work(self, action: str, report: Any = None) -> dict[str, Any]:
        """What a long action makes, in this process."""
        asked: Any = TAB.action(action, {})
        work = asked.work(self.state, self.services)
        module, _, name = work.function.partition(":")
        assert module == task.__name__
        made: dict[str, Any] = getattr(task, name)(work.request, self.blobs, report or Report())
        return made

    def long(self, action: str) -> None:
        asked: Any = TAB.action(action, {})
        self.state = asked.finished(self.state, self.work(action))

    def combine(self) -> hk.CombinedMesh:
        self.long("combine")
        assert self.state.made is not None
        result: hk.CombinedMesh = self.blobs.result(self.state.made)
        return result

    def arrays(self, blob: str) -> Any:
        return self.blobs.get_message(blob).arrays

    @property
    def view(self) -> dict[str, Any]:
        return TAB.view(self.state, self.services)

    @property
    def recipe(self) -> CombineRecipe:
        return self.state.recipe

    def refused(self, action: str, **arguments: Any) -> str:
        before = self.state
        with pytest.raises(InvalidInput) as caught:
            self.do(action, **arguments)
        assert self.state is before
        return str(caught.value)


class Report:
    """Takes what work tells; fractions must not fall."""

    def __init__(self) -> None:
        self.fraction = 0.0

    def progress(self, message: str, fraction: float) -> None:
        assert message
        assert 0 <= fraction <= 1
        assert fraction >= self.fraction - 1e-9
        self.fraction = fraction


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def same_bytes(folder: Path, one: hk.CombinedMesh, other: hk.CombinedMesh) -> bool:
    hk.save(folder / "one.npz", one)
    hk.save(folder / "other.npz", other)
    return (folder / "one.npz").read_bytes() == (folder / "other.npz").read_bytes()


# Pairs


def test_pairs_are_proposed_until_one_is_changed(desk: Desk) -> None:
    proposed = hk.combine(A, B).pairs.tolist()
    assert [[row["a"], row["b"]] for row in desk.view["pairs"]] == proposed
    assert desk.recipe.pairs == "auto"
    assert desk.view["ready"]
    desk.do("remove_pair", kind="pairs", index=1)
    assert [list(pair) for pair in desk.recipe.pairs] == proposed[:1] + proposed[2:]
    desk.do("propose")
    assert desk.recipe.pairs == "auto"


def test_pairs_are_marked_in_any_order_and_moved(desk: Desk) -> None:
    desk.do("clear", kind="pairs")
    for i, j in reversed(PAIRS):
        desk.do("add_pair", kind="pairs", a=i, b=j)
    for i, j in INSIDE:
        desk.do("add_pair", kind="landmarks", a=i, b=j)
    assert desk.recipe == CombineRecipe.of({"pairs": PAIRS[::-1], "landmarks": INSIDE})
    desk.do("move_pair", kind="pairs", index=0, side="b", vertex=14)
    desk.do("move_pair", kind="landmarks", index=1, side="a", vertex=26)
    assert desk.recipe.pairs == ((10, 14), (5, 6), (0, 0))
    assert desk.recipe.landmarks == (tuple(INSIDE[0]), (26, INSIDE[1][1]))


def test_a_mark_that_is_dropped_where_it_was_changes_nothing(desk: Desk) -> None:
    before = desk.state
    vertex = desk.view["pairs"][0]["a"]
    desk.do("move_pair", kind="pairs", index=0, side="a", vertex=vertex)
    assert desk.state is before


@pytest.mark.parametrize(
    ("kind", "a", "b", "told"),
    [
        ("pairs", 25, 15, "vertex 25 of a is not on the boundary that is matched; inside, use"),
        ("pairs", 5, 15, "vertex 5 of a belongs to pair 2 already"),
        ("pairs", 6, 6, "vertex 6 of b belongs to pair 2 already"),
        ("pairs", 30, 0, "a has no vertex 30; it has 0 to 29"),
        ("landmarks", 3, 39, "vertex 3 of a is not inside the surface; on the boundary, use"),
        ("landmarks", 20, 39, "vertex 20 of a belongs to landmark 1 already"),
    ],
)
def test_vertices_that_cannot_be_marked_are_refused(
    desk: Desk, kind: str, a: int, b: int, told: str
) -> None:
    desk.do("load", recipe={"pairs": PAIRS, "landmarks": INSIDE})
    assert told in desk.refused("add_pair", kind=kind, a=a, b=b)


def test_pairs_that_are_not_there_are_refused(desk: Desk) -> None:
    assert "there is no landmark 1" in desk.refused("remove_pair", kind="landmarks", index=0)
    assert "there is no pair 100" in desk.refused(
        "move_pair", kind="pairs", index=99, side="a", vertex=0
    )


def test_points_of_a_recipe_become_vertices_when_one_is_changed(desk: Desk) -> None:
    desk.do("load", recipe={"pairs": PLACES})
    assert [[row["a"], row["b"]] for row in desk.view["pairs"]] == PAIRS
    assert desk.view["snaps"]
    desk.do("move_pair", kind="pairs", index=2, side="a", vertex=11)
    assert desk.recipe.pairs == ((0, 0), (5, 6), (11, 12))
    assert not desk.view["snaps"]


def test_points_that_are_too_far_away_are_told(desk: Desk) -> None:
    far = [[(np.array(p) + 0.05).tolist(), q] for p, q in PLACES]
    desk.do("load", recipe={"pairs": far})
    assert "allowed (snap)" in desk.view["trouble"]["message"]
    desk.do("change", options={"snap": 0.1})
    assert desk.view["ready"]


@pytest.mark.parametrize("kind", ["pairs", "landmarks"])
@pytest.mark.parametrize("away", [1e90, 1e160, 1e308])
def test_points_beyond_all_measure_are_told_and_can_be_taken_away(
    desk: Desk, kind: str, away: float
) -> None:
    given = {"pairs": [[p, [away, -away, 0.0]] for p, _ in PLACES]}
    if kind == "landmarks":
        given = {"pairs": PLACES, "landmarks": [[[0.0, away, 0.0], A.vertices[25].tolist()]]}
    desk.do("load", recipe={**given, "snap": 1e308})
    if away > 1e154:  # the square of that is no number
        assert f"the points of {kind} 0" in desk.view["trouble"]["message"]
    count = len(given[kind])
    assert len(desk.view[kind]) == count
    desk.do("remove_pair", kind=kind, index=0)
    assert len(desk.view[kind]) == count - 1


step = st.one_of(
    st.tuples(
        st.just("add_pair"),
        st.fixed_dictionaries(
            {
                "kind": st.sampled_from(["pairs", "landmarks"]),
                "a": st.integers(0, 31),
                "b": st.integers(0, 41),
            }
        ),
    ),
    st.tuples(
        st.just("move_pair"),
        st.fixed_dictionaries(
            {
                "kind": st.sampled_from(["pairs", "landmarks"]),
                "index": st.integers(0, 9),
                "side": st.sampled_from(["a", "b"]),
                "vertex": st.integers(0, 41),
            }
        ),
    ),
    st.tuples(
        st.just("remove_pair"),
        st.fixed_dictionaries(
            {"kind": st.sampled_from(["pairs", "landmarks"]), "index": st.integers(0, 9)}
        ),
    ),
)


@settings(max_examples=60, deadline=None)
@given(steps=st.lists(step, max_size=12))
def test_whatever_is_marked_lies_where_it_may_and_only_once(
    tmp_path_factory: pytest.TempPathFactory, steps: list[tuple[str, dict[str, Any]]]
) -> None:
    desk = Desk(tmp_path_factory.mktemp("desk"))
    for action, arguments in steps:
        with suppress(InvalidInput):
            desk.do(action, **arguments)
    for kind, inside in (("pairs", False), ("landmarks", True)):
        rows = [[row["a"], row["b"]] for row in desk.view[kind]]
        for column, rim, count in ((0, RIM_A, 30), (1, RIM_B, 40)):
            chosen = [row[column] for row in rows]
            assert len(set(chosen)) == len(chosen)
            assert all(one < count for one in chosen)
            assert (np.isin(chosen, rim) != inside).all()


# What stands in the way


def test_too_few_pairs_are_explained(desk: Desk) -> None:
    desk.do("clear", kind="pairs")
    for count, (i, j) in enumerate(PAIRS):
        assert desk.view["trouble"]["fixes"] == ("propose",)
        assert ("three", "two more", "one more")[count] in desk.view["trouble"]["message"]
        desk.do("add_pair", kind="pairs", a=i, b=j)
    assert desk.view["trouble"] is None
    desk.do("clear", kind="pairs")
    with pytest.raises(InvalidInput, match="at least three are needed"):
        desk.work("combine")


def test_pairs_in_crossing_order_are_explained(desk: Desk) -> None:
    crossing = [[0, 0], [5, 12], [10, 6], [15, 18]]
    desk.do("load", recipe={"pairs": crossing})
    assert "crossing order" in desk.view["trouble"]["message"]
    assert desk.view["trouble"]["fixes"] == ()


def test_a_surface_that_is_inside_out_is_flipped(tmp_path: Path) -> None:
    desk = Desk(tmp_path, A, B.flipped())
    desk.do("load", recipe={"pairs": PAIRS})
    assert desk.view["trouble"]["fixes"] == ("flip_b",)
    assert ".flipped()" not in desk.view["trouble"]["message"]
    desk.do("change", options={"flip_b": True})
    assert desk.view["trouble"] is None
    assert same_bytes(tmp_path, desk.combine(), hk.combine(A, B, PAIRS))


def test_holes_are_filled_and_another_loop_may_stay_open(tmp_path: Path) -> None:
    holed = plate(8, 0.4)
    desk = Desk(tmp_path, holed, B)
    assert desk.view["trouble"]["fixes"] == ("fill_holes",)
    assert "m1.ply has 2 boundary loops" in desk.view["trouble"]["message"]
    assert [loop["outer"] for loop in desk.view["sides"]["a"]["loops"]] == [True, False]
    assert "m1.ply has 2 boundary loops" in desk.refused("add_pair", kind="pairs", a=0, b=0)
    desk.do("change", options={"fill_holes": True, "drop_fill": True})
    assert desk.view["trouble"] is None
    hole = desk.view["sides"]["a"]["loops"][1]
    desk.do("change", options={"outer": [hole["vertex"], None]})
    assert desk.view["sides"]["a"]["loops"][0] | {"vertices": 0} == {
        **hole,
        "outer": True,
        "vertices": 0,
    }
    vertices = [row["a"] for row in desk.view["pairs"]]
    assert np.isin(vertices, hole["vertices"]).all()
    desk.do("change", options={"fill_holes": False})
    assert desk.recipe == CombineRecipe()


def test_meshes_are_repaired_one_step_after_the_other(tmp_path: Path) -> None:
    soup = hk.Mesh(A.vertices[A.faces].reshape(-1, 3), np.arange(3 * len(A.faces)).reshape(-1, 3))
    turned = soup.faces.copy()
    turned[::3] = turned[::3, ::-1]
    apart = together(hk.Mesh(soup.vertices, turned), B)
    desk = Desk(tmp_path, apart, B)
    for number, fix in enumerate(("weld", "oriented", "largest_component")):
        trouble = desk.view["trouble"]
        assert fix in trouble["fixes"]
        assert trouble["side"] == "a"
        assert "henkei." not in trouble["message"]
        product = TAB.product(desk.state, f"{fix} a", desk.services)
        desk.open(f"r{number}", desk.blobs.surface(product.surface))
        desk.do("use", slot="a", mesh=f"r{number}")
    assert desk.view["trouble"] is None


def test_closed_surfaces_are_sent_to_their_tab(tmp_path: Path) -> None:
    desk = Desk(tmp_path, bumpy(1, 0), B)
    trouble = desk.view["trouble"]
    assert "m1.ply: the surface is closed" in trouble["message"]
    assert "Register" in trouble["message"]
    assert trouble["fixes"] == ()


@pytest.mark.parametrize(
    ("moved_b", "told"),
    [
        ({"scale": 0.5}, "b is 2 times smaller than a:"),
        ({"scale": 4.0, "shift": (0, 0, 9)}, "b is 4 times larger than a and elsewhere in space:"),
        ({"turn": (0, 0, 1.5)}, "b is turned by 86 degrees:"),
        (
            {"scale": 4.0, "turn": (0, 0, 1.5), "shift": (0, 0, 9)},
            "b is 4 times larger than a, turned by 86 degrees and elsewhere in space:",
        ),
        ({"shift": (2.0, 0, 0)}, "b is elsewhere in space:"),
        ({"scale": 1.1, "turn": (0.2, 0, 0), "shift": (0.3, 0, 0)}, None),
    ],
)
def test_aligning_is_advised_where_the_place_would_change(
    tmp_path: Path, moved_b: dict[str, Any], told: str | None
) -> None:
    desk = Desk(tmp_path, A, moved(A, **moved_b))
    desk.do("load", recipe={"pairs": [[i, i] for i in (0, 4, 8, 12)]})
    advice = desk.view["advice"]
    assert desk.view["ready"]
    if told is None:
        assert advice is None
        return
    assert told in advice["message"]
    desk.do("change", options={"align": True})
    assert desk.view["advice"] is None
    c = desk.combine()
    assert np.abs(c.vertices_b - c.vertices_a).max() <= 1e-9


def test_proposed_pairs_that_turn_b_are_doubted(tmp_path: Path) -> None:
    desk = Desk(tmp_path, A, moved(A, turn=(1.5, 0, 0)))
    desk.do("load", recipe={})
    assert "they do not belong together" in desk.view["advice"]["message"]
    desk.do("load", recipe={"pairs": [[i, i] for i in (0, 4, 8, 12)], "landmarks": [[20, 20]]})
    assert "b is turned by 86 degrees" in desk.view["advice"]["message"]


# Meshes and recipes


def test_what_is_about_a_mesh_goes_with_it(desk: Desk) -> None:
    desk.open("m3", hemisphere(1))
    desk.do("load", recipe={"pairs": PAIRS, "landmarks": INSIDE, "align": True})
    desk.combine()
    desk.do("use", slot="b", mesh="m3")
    assert desk.recipe == CombineRecipe(align=True)
    assert desk.state.result is None


def test_a_recipe_that_came_first_waits_for_its_meshes(desk: Desk) -> None:
    desk.state = CombineState()
    desk.do("load", recipe={"pairs": PAIRS})
    assert "Open two meshes" in desk.view["next"]
    desk.do("use", slot="a", mesh="m1")
    assert "second mesh" in desk.view["next"]
    desk.do("use", slot="b", mesh="m2")
    assert desk.view["ready"]
    assert desk.recipe.pairs == tuple(map(tuple, PAIRS))


def test_options_are_checked(desk: Desk) -> None:
    assert "fill_holes" in desk.refused("change", options={"drop_fill": True})
    assert "greater than 0" in desk.refused("change_morph", morph={"seconds": 0})
    with pytest.raises(InvalidInput, match="pairs"):
        desk.do("change", options={"pairs": []})


# Results


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"pairs": PAIRS, "landmarks": INSIDE},
        {"pairs": PLACES, "snap": 0.0, "align": True, "attributes": False},
    ],
)
def test_what_is_made_is_what_the_recipe_makes(
    desk: Desk, data: dict[str, Any], tmp_path: Path
) -> None:
    desk.do("load", recipe=data)
    made = desk.combine()
    again = CombineRecipe.read(_written(desk.recipe, tmp_path / "r.json"))
    assert same_bytes(tmp_path, made, hk.combine_by_recipe(A, B, again))


def _written(recipe: CombineRecipe, path: Path) -> Path:
    recipe.write(path)
    return path


def test_what_is_drawn_is_what_was_made(desk: Desk) -> None:
    desk.do("load", recipe={"pairs": PAIRS[::-1], "landmarks": INSIDE})
    c = desk.combine()
    result = desk.state.result
    assert result is not None
    header, drawn = desk.blobs.get_message(result.shapes).header, desk.arrays(result.shapes)
    centre, scale = np.array(header["centre"]), header["scale"]
    for name, vertices in (("positions", c.vertices_a), ("other", c.vertices_b)):
        assert np.abs(drawn[name]).max() <= 1
        assert np.abs(centre + scale * drawn[name] - vertices).max() <= 2e-7 * scale
    assert np.array_equal(drawn["triangles"], c.faces)
    border = hk.Mesh(c.vertices_a, c.faces).topology.boundary_loops[0]
    assert np.array_equal(np.unique(drawn["creases"]), np.sort(border))
    flat = desk.arrays(result.plane)
    corners = flat["positions"][list(result.pairs)].astype(np.float64)
    assert np.allclose(np.linalg.norm(corners, axis=1), 1, atol=1e-6)
    assert np.array_equal(result.pairs, c.vertex_of_a[[i for i, _ in PAIRS[::-1]]])
    assert np.array_equal(result.landmarks, c.vertex_of_b[[j for _, j in INSIDE]])
    for own, on in (("edges_a", c.edge_on_a), ("edges_b", c.edge_on_b)):
        assert np.array_equal(flat[own], c.edges[on >= 0])
    assert not any(figure.bad for figure in result.figures)


def test_a_result_is_told_to_be_old_when_the_recipe_changes(desk: Desk) -> None:
    desk.combine()
    made = desk.state.made
    desk.do("change_morph", morph={"time": "smoothstep", "frames": 12, "sweep": "left"})
    desk.do("change", options={"about": "two disks"})
    assert desk.state.made == made
    assert desk.view["result"]["current"]
    desk.do("change", options={"align": True})
    assert desk.state.made is None
    assert not desk.view["result"]["current"]
    assert "combine again" in desk.view["next"]
    desk.do("change", options={"align": False})
    assert desk.state.made == made


def test_a_result_of_other_meshes_is_dropped(desk: Desk) -> None:
    late = desk.work("combine")
    desk.open("m3", hemisphere(1))
    desk.do("use", slot="b", mesh="m3")
    finished: Any = TAB.action("combine", {})
    assert finished.finished(desk.state, late) is desk.state


def test_parts_turn_as_along_the_path_itself(desk: Desk) -> None:
    desk.do("load", recipe={"pairs": PAIRS})
    c = desk.combine()
    desk.long("turn")
    result = desk.state.result
    assert result is not None
    assert result.turning is not None
    assert desk.recipe.morph.path == "rotation"
    assert desk.state.made == result.result
    header = desk.blobs.get_message(result.shapes).header
    knots = header["scale"] * desk.arrays(result.turning)["knots"].astype(np.float64)
    path = RotationAwarePath(c.correspondence)
    for place in range(-1, KNOTS + 2):
        there = knots[place + 1] + header["centre"]
        assert np.abs(there - path.positions(place / KNOTS)).max() <= 1e-6 * header["scale"]


def test_with_a_turning_recipe_all_is_made_at_once(desk: Desk) -> None:
    desk.do("load", recipe={"pairs": PAIRS, "morph": {"path": "rotation"}})
    desk.combine()
    result = desk.state.result
    assert result is not None
    first = result.turning
    desk.long("turn")
    assert desk.state.result is not None
    assert first == desk.state.result.turning


def test_turning_needs_a_result_and_belongs_to_it(desk: Desk) -> None:
    with pytest.raises(InvalidInput, match="combine the meshes first"):
        desk.work("turn")
    desk.combine()
    late = desk.work("turn")
    desk.do("load", recipe={"pairs": PAIRS})
    desk.combine()
    finished: Any = TAB.action("turn", {})
    assert finished.finished(desk.state, late) is desk.state


def test_sweeps_tell_when_each_vertex_starts(desk: Desk) -> None:
    c = desk.combine()
    assert desk.view["result"]["delay"] is None
    desk.do("change_morph", morph={"sweep": "right"})
    delay = desk.arrays(desk.view["result"]["delay"])["values"]
    x = c.vertices_a[:, 0]
    assert delay.min() == 0
    assert delay.max() < 1
    assert np.abs(delay / delay.max() - (x.max() - x) / np.ptp(x)).max() <= 1e-5


@pytest.mark.parametrize("time", ["0", "0.25", "1"])
def test_a_shape_can_be_kept_as_a_mesh(desk: Desk, time: str) -> None:
    desk.do("load", recipe={"pairs": PAIRS, "morph": {"time": "smoothstep", "sweep": "top"}})
    c = desk.combine()
    product = TAB.product(desk.state, f"at {time}", desk.services)
    kept = desk.blobs.surface(product.surface)
    t = float(time)
    delay = desk.arrays(desk.view["result"]["delay"])["values"]
    expected = c.at(t, time="smoothstep", delay=delay).vertices
    assert np.abs(kept.vertices - expected).max() <= 1e-5
    assert (product.vertices, product.faces) == (len(kept.vertices), kept.face_count)
    assert product.name == f"m1 to m2, {t:.3g}"


def test_shapes_that_are_not_there_are_refused(desk: Desk) -> None:
    with pytest.raises(InvalidInput, match="combine the meshes first"):
        TAB.product(desk.state, "at 0.5", desk.services)
    desk.combine()
    for what in ("at noon", "weld c", "0.5"):
        with pytest.raises(InvalidInput):
            TAB.product(desk.state, what, desk.services)
    with pytest.raises(InvalidInput, match="from 0 to 1"):
        TAB.product(desk.state, "at 2", desk.services)


# Colours and figures


def test_attributes_and_differences_colour_the_result(tmp_path: Path) -> None:
    red = np.tile([1.0, 0.0, 0.25], (30, 1))
    attributes = hk.Attributes(
        vertex={"color": red, "normal": np.tile([0.0, 0.0, 1.0], (30, 1))},
        face={"label": np.full(A.face_count, 7), "heat": np.linspace(2, 3, A.face_count)},
    )
    desk = Desk(tmp_path, hk.Mesh(A.vertices, A.faces, attributes=attributes), B)
    c = desk.combine()
    assert desk.state.result is not None
    colours = {one.title: one for one in desk.state.result.colours}
    assert set(colours) == {
        *("Colours of a", "label of a", "heat of a"),
        *("Distance from a to b", "Growth from a to b"),
    }
    rgb = desk.arrays(colours["Colours of a"].data)["rgb"]
    assert (rgb == [255, 0, 64]).all()
    assert len(rgb) == len(c.vertices_a)
    assert colours["label of a"].colormap == "categorical"
    heat = colours["heat of a"]
    assert heat.per == "face"
    assert heat.limits == (2.0, 3.0)
    assert len(desk.arrays(heat.data)["values"]) == len(c.faces)
    apart = desk.arrays(colours["Distance from a to b"].data)["values"]
    assert np.allclose(apart, np.linalg.norm(c.vertices_b - c.vertices_a, axis=1), atol=1e-6)


def test_a_larger_copy_grows_nowhere(tmp_path: Path) -> None:
    larger = hk.Mesh(3 * A.vertices + 10, A.faces)
    desk = Desk(tmp_path, A, larger)
    c = desk.combine()
    factor, area = growth(c)
    assert np.allclose(factor, 1, atol=1e-9)
    assert np.isclose(area.sum(), 1)


@settings(max_examples=50, deadline=None)
@given(
    values=st.lists(st.integers(0, 50), min_size=1, max_size=20),
    share=st.floats(0.01, 1),
)
def test_quantiles_of_equal_weights_are_those_of_the_sorted(
    values: list[int], share: float
) -> None:
    found = quantile(np.array(values, float), np.ones(len(values)), share)
    below = sum(value <= found for value in values)
    assert below >= share * len(values) - 1e-9
    assert sum(value < found for value in values) < share * len(values)
