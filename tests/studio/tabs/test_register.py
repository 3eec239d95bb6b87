"""The register tab: what is marked is a recipe, and what is made of it is what the recipe makes."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import henkei as hk
from bodies import bumpy, moved, with_unused_vertices
from henkei.errors import Cancelled, HenkeiError, InvalidInput
from henkei.geometry.alignment import similarity
from henkei.geometry.distance import ClosestPoints
from henkei.geometry.rotation_path import KNOTS, RotationAwarePath
from henkei.mesh import Attributes, Mesh, PolygonMesh, Surface
from henkei.recipes.register import RegisterRecipe
from henkei.studio.blobs import Blobs
from henkei.studio.document import MeshEntry
from henkei.studio.register_state import RegisterState
from henkei.studio.services import Services
from henkei.studio.tabs.register import TAB
from topologies import torus

SOURCE, TARGET = bumpy(2, 0), moved(bumpy(2, 1), 3.0, shift=(5, 0, 0))
PAIRS = [[3, 7], [40, 90], [120, 12]]
PLACES = [[SOURCE.vertices[i].tolist(), TARGET.vertices[j].tolist()] for i, j in PAIRS]


class Report:
    """Takes what work tells; fractions must not fall."""

    due = True

    def __init__(self, cancelled_from: float = 2.0) -> None:
        self.fraction = 0.0
        self.shown: list[tuple[dict[str, Any], NDArray[np.float32]]] = []
        self._cancelled_from = cancelled_from

    def progress(self, message: str, fraction: float) -> None:
        assert message
        assert self.fraction - 1e-9 <= fraction <= 1
        self.fraction = fraction
        if fraction >= self._cancelled_from:
            raise Cancelled("cancelled")

    def snapshot(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        self.shown.append((header, arrays["positions"]))


class Desk:
    """Meshes that are open, and the state of the tab."""

    def __init__(self, folder: Path, *surfaces: Surface) -> None:
        self.blobs = Blobs(folder)
        self.services = Services(self.blobs)
        self.state = RegisterState()
        for number, surface in enumerate(surfaces or (SOURCE, TARGET), 1):
            self.open(f"m{number}", surface)
        self.do("use", slot="source", mesh="m1")
        self.do("use", slot="target", mesh="m2")

    def open(self, ident: str, surface: Surface, name: str = "") -> None:
        entry = MeshEntry(
            id=ident,
            name=name or f"{ident}.ply",
            surface=self.blobs.put_surface(surface),
            vertices=len(surface.vertices),
            faces=surface.face_count,
        )
        self.services.meshes = (*self.services.meshes, entry)

    def do(self, action: str, **arguments: Any) -> None:
        self.state = TAB.action(action, arguments).apply(self.state, self.services)

    def work(self, action: str, report: Any = None, **arguments: Any) -> dict[str, Any]:
        """What a long action makes, in this process, as it comes from another one."""
        asked: Any = TAB.action(action, arguments)
        work = asked.work(self.state, self.services)
        module, _, name = work.function.partition(":")
        function = getattr(import_module(module), name)
        made = function(json.loads(json.dumps(work.request)), self.blobs, report or Report())
        plain: dict[str, Any] = json.loads(json.dumps(made, default=lambda one: one.tolist()))
        return plain

    def long(self, action: str, report: Any = None, **arguments: Any) -> None:
        asked: Any = TAB.action(action, arguments)
        self.state = asked.finished(self.state, self.work(action, report, **arguments))

    def result(self) -> hk.Registration:
        assert self.state.made is not None
        result: hk.Registration = self.blobs.result(self.state.made)
        return result

    def drawn(self, blob: str) -> Any:
        """A surface as it is drawn; its arrays of positions in space."""
        message = self.blobs.get_message(blob)
        centre, scale = np.array(message.header["centre"]), message.header["scale"]
        return {
            name: centre + scale * array if array.dtype == np.float32 else array
            for name, array in message.arrays.items()
        }

    @property
    def view(self) -> dict[str, Any]:
        return TAB.view(self.state, self.services)

    @property
    def recipe(self) -> RegisterRecipe:
        return self.state.recipe

    def refused(self, action: str, **arguments: Any) -> str:
        before = self.state
        with pytest.raises(InvalidInput) as caught:
            self.do(action, **arguments)
        assert self.state is before
        return str(caught.value)


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[Desk, Report]:
    """A desk on which three landmarks were registered."""
    desk, report = Desk(tmp_path_factory.mktemp("desk")), Report()
    desk.do("load", recipe={"landmarks": PAIRS, "seed": 2})
    desk.long("run", report)
    return desk, report


def as_marked(desk: Desk) -> list[list[int]]:
    return [[row["source"], row["target"]] for row in desk.view["landmarks"]]


# Meshes


def test_a_person_is_told_what_to_open(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    assert "Take the tool Landmark" in desk.view["next"]
    desk.do("use", slot="target", mesh=None)
    assert "Open the target" in desk.view["next"]
    assert set(desk.view["surfaces"]) == {"source"}
    desk.do("use", slot="source", mesh=None)
    assert "Open two meshes" in desk.view["next"]
    with pytest.raises(InvalidInput, match="no mesh is chosen"):
        desk.work("run")


def test_another_mesh_takes_landmarks_along_and_leaves_options(done: tuple[Desk, Report]) -> None:
    desk, _ = done
    state = desk.state.with_mesh("target", "m1")
    assert (state.recipe.landmarks, state.recipe.seed, state.result) == ((), 2, None)


def test_swapping(desk: Desk) -> None:
    desk.do("load", recipe={"landmarks": PAIRS, "regions": ["a", "b"], "distortion": 0.1})
    desk.do("swap")
    assert (desk.state.source, desk.state.target) == ("m2", "m1")
    turned = {"landmarks": [pair[::-1] for pair in PAIRS], "regions": ["b", "a"], "distortion": 0.1}
    assert desk.recipe == RegisterRecipe.of(turned)


def test_a_mesh_that_does_not_serve_is_told_and_mended(tmp_path: Path) -> None:
    apart = Mesh(
        np.concatenate([SOURCE.vertices, SOURCE.vertices[:3] + 9]),
        np.concatenate([SOURCE.faces, [[162, 163, 164]]]),
    )
    desk = Desk(tmp_path, apart, TARGET)
    trouble = desk.view["trouble"]
    assert "m1.ply" in trouble["message"]
    assert (trouble["side"], trouble["fixes"]) == ("source", ("largest_component",))
    assert not desk.view["ready"]
    with pytest.raises(InvalidInput, match="pieces"):
        desk.work("run")
    made = TAB.product(desk.state, "largest_component source", desk.services)
    np.testing.assert_array_equal(desk.blobs.surface(made.surface).vertices, SOURCE.vertices)


def test_faces_that_look_inward_are_turned_round(tmp_path: Path) -> None:
    desk = Desk(tmp_path, SOURCE, TARGET.flipped())
    trouble = desk.view["trouble"]
    assert (trouble["side"], trouble["fixes"]) == ("target", ("flipped",))
    made = TAB.product(desk.state, "flipped target", desk.services)
    desk.open("m3", desk.blobs.surface(made.surface))
    desk.do("use", slot="target", mesh="m3")
    assert desk.view["ready"]


def test_a_torus_is_told(tmp_path: Path) -> None:
    view = Desk(tmp_path, SOURCE, torus()).view
    assert "handle" in view["trouble"]["message"]
    assert not view["ready"]


# Landmarks


def test_landmarks_are_marked_moved_and_removed(desk: Desk) -> None:
    for i, j in PAIRS:
        desk.do("add_landmark", source=i, target=j)
    assert desk.recipe == RegisterRecipe.of({"landmarks": PAIRS})
    assert as_marked(desk) == PAIRS
    desk.do("move_landmark", index=1, side="target", vertex=91)
    desk.do("move_landmark", index=0, side="source", vertex=4)
    assert desk.recipe.landmarks == ((4, 7), (40, 91), (120, 12))
    desk.do("move_landmark", index=0, side="source", vertex=4)
    desk.do("remove_landmark", index=0)
    assert as_marked(desk) == [[40, 91], [120, 12]]
    desk.do("clear_landmarks")
    assert desk.recipe == RegisterRecipe()


def test_landmarks_that_cannot_be_are_refused(tmp_path: Path) -> None:
    desk = Desk(tmp_path, with_unused_vertices(SOURCE, [5]), TARGET)
    desk.do("add_landmark", source=3, target=7)
    assert "landmark 1 already" in desk.refused("add_landmark", source=3, target=8)
    assert "landmark 1 already" in desk.refused("add_landmark", source=4, target=7)
    assert "no vertex 5000" in desk.refused("add_landmark", source=4, target=5000)
    assert "no face of m1.ply" in desk.refused("add_landmark", source=5, target=8)
    assert "no landmark 2" in desk.refused("remove_landmark", index=1)
    assert "no landmark 2" in desk.refused("move_landmark", index=1, side="source", vertex=1)
    desk.do("add_landmark", source=4, target=8)
    assert "already" in desk.refused("move_landmark", index=1, side="target", vertex=7)


def test_among_points_landmarks_are_points(desk: Desk) -> None:
    desk.do("load", recipe={"landmarks": PLACES[:2]})
    assert as_marked(desk) == PAIRS[:2]
    assert desk.view["landmarks"][0]["points"] == tuple(map(tuple, PLACES[0]))
    desk.do("add_landmark", source=PAIRS[2][0], target=PAIRS[2][1])
    assert desk.recipe == RegisterRecipe.of({"landmarks": PLACES})
    desk.do("move_landmark", index=0, side="target", vertex=8)
    assert desk.recipe.landmarks[0][1] == tuple(TARGET.vertices[8])
    assert desk.recipe.landmarks[0][0] == tuple(PLACES[0][0])


def test_landmarks_of_another_mesh_are_told_and_cleared(desk: Desk) -> None:
    beyond = [[[0, k, away], [0, away, k]] for k in (1, 2) for away in (1e160, 1e308)]
    for landmarks in ([[3, 7], [9000, 1]], [[[0, 0, 99], [0, 0, 0]]], [[3, 7], [3, 8]], beyond):
        desk.do("load", recipe={"landmarks": landmarks})
        assert "landmarks" in desk.view["trouble"]["message"]
        with pytest.raises(InvalidInput, match="landmarks"):
            desk.work("run")
    desk.do("clear_landmarks")
    assert desk.view["ready"]


def vts(vertices: NDArray[np.float64], ids: list[int]) -> str:
    return "\n".join(" ".join(map(str, [i, *vertices[i].tolist()])) for i in ids)


@pytest.mark.parametrize("turned", [False, True])
def test_landmarks_from_a_file_for_each_mesh_in_any_order(desk: Desk, turned: bool) -> None:
    one = {"name": "b.vts", "text": vts(SOURCE.vertices, [i for i, _ in PAIRS])}
    other = {"name": "a.vts", "text": vts(TARGET.vertices, [j for _, j in PAIRS])}
    desk.long("read_landmarks", files=[other, one] if turned else [one, other])
    assert desk.recipe == RegisterRecipe.of({"landmarks": PLACES})
    assert as_marked(desk) == PAIRS


@pytest.mark.parametrize("data", [PAIRS, PLACES, {"landmarks": PAIRS, "seed": 1}])
def test_landmarks_from_one_file(desk: Desk, data: Any) -> None:
    desk.long("read_landmarks", files=[{"name": "pairs.json", "text": json.dumps(data)}])
    assert as_marked(desk) == PAIRS
    assert desk.recipe.seed == 0


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ([("pairs.json", "[[1,")], "pairs.json, line 1"),
        ([("pairs.json", "[[1, 2], [3]]")], "landmarks"),
        ([("pairs.json", "[[1, 99999]]")], "no vertex 99999"),
        ([("a.vts", "0 0 0 0")], "choose both at once"),
        ([("a.vts", "0 0 0 0"), ("../b.vts", "0 0 0 x")], "b.vts: line 1"),
        ([("a.vts", "0 0 0 0"), ("b.vts", "0 0 0 99")], "not on"),
        ([("a.obj", "v 0 0 0"), ("b.obj", "v 0 0 0")], "not a landmark file"),
        ([("a.pp", "<a><point x='1'/></a>"), ("b.vts", "0 0 0 0")], "a.pp: point 0"),
    ],
)
def test_files_that_do_not_serve_are_refused_by_their_names(
    desk: Desk, files: list[tuple[str, str]], said: str
) -> None:
    given = [{"name": name, "text": text} for name, text in files]
    with pytest.raises(HenkeiError) as caught:
        desk.work("read_landmarks", files=given)
    assert said in str(caught.value)
    assert "/" not in str(caught.value).split(":")[0]


# Options


def test_options_are_fields_of_the_recipe(desk: Desk) -> None:
    desk.do("change", options={"distortion": 0.02, "seed": 4, "rule": "literal"})
    desk.do("change", options={"rule": None, "settings": {"sweeps": 2}, "about": "a trial"})
    desk.do("change_morph", morph={"sweep": "top", "seconds": 3.0})
    assert desk.recipe == RegisterRecipe.of(
        {
            "distortion": 0.02,
            "seed": 4,
            "settings": {"sweeps": 2},
            "about": "a trial",
            "morph": {"sweep": "top", "seconds": 3.0},
        }
    )
    assert "distortion" in desk.refused("change", options={"distortion": -1.0})
    assert "sweeps" in desk.refused("change", options={"settings": {"sweeps": "many"}})
    assert "labels.npy" in desk.refused("change", options={"regions": ["labels.npy", "label"]})
    assert "path" in desk.refused("change_morph", morph={"path": "crooked"})


def test_mediators_by_name_and_by_mesh(desk: Desk) -> None:
    desk.do("set_mediator", name="quadruped")
    assert (desk.recipe.mediator, desk.state.mediator) == ("quadruped", None)
    desk.open("m3", bumpy(2, 3), "ball")
    desk.do("set_mediator", mesh="m3")
    assert (desk.recipe.mediator, desk.state.mediator) == ("ball.ply", "m3")
    assert desk.state.meshes == {"source": "m1", "target": "m2", "mediator": "m3"}
    desk.do("change", options={"seed": 1})
    assert desk.state.mediator == "m3"
    closed = desk.state.with_mesh("mediator", None)
    assert (closed.recipe.mediator, closed.mediator, closed.recipe.seed) == ("sphere", None, 1)
    desk.do("load", recipe={"mediator": "humanoid"})
    assert desk.state.mediator is None
    assert "not 'ball'" in desk.refused("set_mediator", name="ball")
    assert "by name, or" in desk.refused("set_mediator")
    assert "not open" in desk.refused("set_mediator", mesh="m9")


def test_a_recipe_that_names_a_file_means_the_open_mesh_of_that_name(desk: Desk) -> None:
    assert "'goat.obj'" in desk.refused("load", recipe={"mediator": "animals/goat.obj"})
    desk.open("m3", bumpy(2, 3), "goat.obj")
    desk.do("load", recipe={"mediator": "animals/goat.obj"})
    assert desk.state.mediator == "m3"


# Registering


def test_it_is_what_the_recipe_makes(done: tuple[Desk, Report], tmp_path: Path) -> None:
    desk, _ = done
    alone = hk.register_by_recipe(SOURCE, TARGET, desk.recipe)
    hk.save(tmp_path / "one.npz", desk.result())
    hk.save(tmp_path / "other.npz", alone)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()


def test_it_is_shown_on_its_way(done: tuple[Desk, Report]) -> None:
    desk, report = done
    shapes = desk.blobs.get_message(desk.view["result"]["shapes"])
    centre, scale = np.array(shapes.header["centre"]), shapes.header["scale"]
    assert all(header == {"surface": "model"} for header, _ in report.shown)
    assert len(report.shown) > 4
    last = centre + scale * report.shown[-1][1]
    np.testing.assert_allclose(last, desk.result().mesh.vertices, atol=1e-5 * scale)
    first = centre + scale * report.shown[0][1]
    moved_source = desk.result().similarity.apply(SOURCE.vertices)
    np.testing.assert_allclose(first, moved_source, atol=1e-5 * scale)


def test_its_shapes_are_the_ends_of_the_morph(done: tuple[Desk, Report]) -> None:
    desk, _ = done
    result, drawn = desk.result(), desk.drawn(desk.view["result"]["shapes"])
    np.testing.assert_allclose(drawn["positions"], result.mesh.vertices, atol=1e-4)
    onto = similarity(drawn["start"], SOURCE.vertices)
    np.testing.assert_allclose(onto.apply(drawn["start"]), SOURCE.vertices, atol=1e-4)
    halfway = (drawn["start"] + drawn["positions"]) / 2
    aligned = result.aligned()
    np.testing.assert_allclose(
        onto.scale * np.ptp(halfway @ onto.rotation.T, axis=0),
        np.ptp(aligned.at(0.5).vertices, axis=0),
        rtol=1e-4,
    )
    np.testing.assert_array_equal(drawn["triangles"], SOURCE.faces)
    assert not len(drawn["bridged"])


def test_heat_maps_are_distances(done: tuple[Desk, Report]) -> None:
    desk, _ = done
    result, made = desk.result(), desk.view["result"]
    by_title = {one["title"]: one for one in made["colours"]}
    unreached = by_title["Target not reached"]
    values = desk.blobs.get_message(unreached["data"]).arrays["values"]
    away = ClosestPoints(result.mesh).query(TARGET.vertices)[1]
    np.testing.assert_allclose(values, 100 * away / TARGET.diagonal, atol=1e-4)
    assert 0 < unreached["limits"][1] <= 100 * result.quality.to_source_max
    assert made["missed"] == away.argmax()
    off = desk.blobs.get_message(by_title["Distance from the target"]["data"]).arrays["values"]
    middles = result.mesh.vertices[result.faces].mean(axis=1)
    assert (off >= 99 * ClosestPoints(TARGET).query(middles)[1] / TARGET.diagonal).all()
    grown = desk.blobs.get_message(by_title["Growth"]["data"]).arrays["values"]
    before, after = (m.face_areas / m.face_areas.sum() for m in (SOURCE, result.mesh))
    np.testing.assert_allclose(2.0**grown * before, after, rtol=1e-4)
    stretch = desk.blobs.get_message(by_title["Stretch"]["data"]).arrays["values"]
    assert stretch.min() >= 1 - 1e-6
    assert before @ stretch == pytest.approx(result.quality.angle_distortion, rel=1e-4)


def test_figures_are_those_of_the_quality(done: tuple[Desk, Report]) -> None:
    desk, _ = done
    quality = desk.result().quality
    rows = {row["label"]: row for row in desk.view["result"]["figures"]}
    mean = rows["Target off the model, mean"]
    assert mean["value"] == pytest.approx(100 * quality.to_source_mean, rel=1e-2)
    assert mean["unit"] == "%"
    assert rows["Faces turned over"]["value"] == quality.inverted == 0
    assert rows["Landmarks off their places"]["value"] == 0
    assert rows["Change of area"]["value"] == pytest.approx(quality.area_distortion, rel=1e-2)
    assert not any(row["bad"] for row in rows.values())
    assert desk.view["warnings"] == []


def test_a_change_makes_it_old_until_it_is_taken_back(done: tuple[Desk, Report]) -> None:
    desk = done[0]
    before = desk.state
    assert desk.view["result"]["current"]
    for action, arguments in (
        ("change", {"options": {"seed": 9}}),
        ("remove_landmark", {"index": 0}),
        ("set_mediator", {"mesh": "m1"}),
    ):
        desk.do(action, **arguments)
        assert desk.state.made is None
        assert not desk.view["result"]["current"]
        assert "again" in desk.view["next"]
        desk.state = before
    desk.do("change_morph", morph={"seconds": 5.0})
    desk.do("change", options={"about": "seen"})
    assert desk.state.made is not None
    desk.state = before


def test_a_result_of_meshes_chosen_no_longer_is_dropped(desk: Desk) -> None:
    made = desk.work("run")
    asked: Any = TAB.action("run", {})
    desk.do("swap")
    assert asked.finished(desk.state, made).result is None


def test_with_a_mesh_as_mediator(desk: Desk) -> None:
    ball = bumpy(2, 3)
    desk.open("m3", ball, "ball.obj")
    desk.do("set_mediator", mesh="m3")
    desk.long("run")
    alone = hk.register(SOURCE, TARGET, mediator=ball)
    np.testing.assert_array_equal(desk.result().mesh.vertices, alone.mesh.vertices)


def test_vertices_in_holes_are_told_and_marked(tmp_path: Path) -> None:
    middles = TARGET.vertices[TARGET.faces].mean(axis=1)
    cut = Mesh(TARGET.vertices, TARGET.faces[middles[:, 2] < 1.5])
    desk = Desk(tmp_path, SOURCE, cut)
    desk.long("run")
    result = desk.result()
    drawn = desk.drawn(desk.view["result"]["shapes"])
    np.testing.assert_array_equal(drawn["bridged"], np.flatnonzero(result.on_target.face < 0))
    assert result.quality.bridged == len(drawn["bridged"]) > 0
    rows = {row["label"]: row["value"] for row in desk.view["result"]["figures"]}
    assert rows["Vertices in holes of the target"] == result.quality.bridged
    assert any("holes of the target" in warning for warning in desk.view["warnings"])
    off, values = (
        desk.blobs.get_message(one["data"]).arrays["values"]
        for one in desk.view["result"]["colours"][:2]
    )
    np.testing.assert_array_equal(
        np.isnan(off), (result.on_target.face[result.faces] < 0).any(axis=1)
    )
    assert set(np.flatnonzero(np.isnan(values))) == set(cut.topology.unused_vertices.tolist())


def test_regions_are_attributes(tmp_path: Path) -> None:
    source, target = (
        Mesh(
            m.vertices,
            m.faces,
            attributes=Attributes(vertex={"half": (m.vertices[:, 2] > 0).astype(int)}),
        )
        for m in (SOURCE, bumpy(2, 1))
    )
    desk = Desk(tmp_path, source, target)
    assert desk.view["labels"] == [["half"], ["half"]]
    desk.do("change", options={"regions": ["half", "half"]})
    desk.long("run")
    alone = hk.register_by_recipe(source, target, {"regions": ["half", "half"]})
    np.testing.assert_array_equal(desk.result().mesh.vertices, alone.mesh.vertices)


def test_edges_are_those_of_polygons(tmp_path: Path) -> None:
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    desk = Desk(tmp_path, PolygonMesh.from_faces(corners, faces), TARGET)
    desk.long("run")
    drawn = desk.drawn(desk.view["result"]["shapes"])
    assert len(drawn["triangles"]) == 12
    assert len(drawn["edges"]) == 12


def test_cancelling_leaves_all_as_it_was(desk: Desk) -> None:
    with pytest.raises(Cancelled):
        desk.work("run", Report(cancelled_from=0.6))
    assert desk.state.result is None


# The morph


def test_a_turning_path_is_prepared(done: tuple[Desk, Report]) -> None:
    desk = done[0]
    before = desk.state
    desk.long("turn")
    assert desk.recipe.morph.path == "rotation"
    assert desk.state.made == before.made
    turning = desk.view["result"]["turning"]
    knots = desk.blobs.get_message(turning).arrays["knots"]
    assert knots.shape == (KNOTS + 3, len(SOURCE.vertices), 3)
    shapes = desk.blobs.get_message(desk.view["result"]["shapes"]).arrays
    np.testing.assert_allclose(knots[1], shapes["start"], atol=1e-5)
    np.testing.assert_allclose(knots[-2], shapes["positions"], atol=1e-5)
    exported = RotationAwarePath(desk.result().aligned().correspondence).positions(0.5)
    middle = knots[1 + KNOTS // 2].astype(float)
    onto = similarity(middle, exported)
    np.testing.assert_allclose(onto.apply(middle), exported, atol=1e-4)
    desk.state = before


def test_it_comes_with_the_result_where_the_recipe_turns(desk: Desk) -> None:
    desk.do("load", recipe={"morph": {"path": "rotation"}})
    desk.long("run")
    assert desk.state.result is not None
    assert desk.state.result.turning is not None


def test_delays_grow_from_one_side(done: tuple[Desk, Report]) -> None:
    desk = done[0]
    before = desk.state
    assert desk.view["result"]["delay"] is None
    desk.do("change_morph", morph={"sweep": "top"})
    delay = desk.blobs.get_message(desk.view["result"]["delay"]).arrays["values"]
    assert delay.argmin() == SOURCE.vertices[:, 1].argmax()
    assert delay.argmax() == SOURCE.vertices[:, 1].argmin()
    desk.state = before


def test_shapes_are_kept_as_meshes(done: tuple[Desk, Report]) -> None:
    desk, _ = done
    last = TAB.product(desk.state, "at 1", desk.services)
    np.testing.assert_array_equal(
        desk.blobs.surface(last.surface).vertices, desk.result().mesh.vertices
    )
    assert last.name == "m1 on m2"
    half = TAB.product(desk.state, "at 0.5", desk.services)
    drawn = desk.drawn(desk.view["result"]["shapes"])
    np.testing.assert_allclose(
        desk.blobs.surface(half.surface).vertices,
        (drawn["start"] + drawn["positions"]) / 2,
        atol=1e-4,
    )
    for what in ("at noon", "at", "weld nothing", "model"):
        with pytest.raises(InvalidInput):
            TAB.product(desk.state, what, desk.services)
