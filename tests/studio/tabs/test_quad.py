"""Quads made in the studio are those of the recipe, and what is told of them is so."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

import henkei as hk
from bodies import bumpy
from henkei.errors import HenkeiError, Infeasible, InvalidInput, InvalidMesh
from henkei.mesh import Attributes, Surface
from henkei.quad.features import feature_half_edges
from henkei.quad.sizing import expected_quads
from henkei.quad.wishes import Wish
from henkei.studio.blobs import Blobs
from henkei.studio.document import Document, MeshEntry
from henkei.studio.services import Services
from henkei.studio.tabs.quad import TAB, QuadState
from henkei.studio.tasks import quad as task
from parts import circle, plate, subdivided_box


class Report:
    """Takes what work tells; fractions must not fall."""

    def __init__(self) -> None:
        self.fraction = 0.0

    def progress(self, message: str, fraction: float) -> None:
        assert message
        assert self.fraction - 1e-9 <= fraction <= 1
        self.fraction = fraction


class Desk:
    """The tab with a mesh on it, as a session would use it."""

    def __init__(self, folder: Path, mesh: Surface, **recipe: Any) -> None:
        self.blobs = Blobs(folder)
        self.services = Services(self.blobs)
        self.mesh = mesh
        self.state = QuadState()
        self.open("m1", "part", mesh)
        self.do("use", slot="mesh", mesh="m1")
        self.do("load", recipe=recipe)

    def open(self, ident: str, name: str, mesh: Surface) -> None:
        entry = MeshEntry(
            id=ident,
            name=name,
            surface=self.blobs.put_surface(mesh),
            vertices=len(mesh.vertices),
            faces=mesh.face_count,
        )
        self.services.meshes = (*self.services.meshes, entry)

    def do(self, action: str, /, **arguments: Any) -> None:
        self.state = TAB.action(action, arguments).apply(self.state, self.services)
        self.survives()

    def change(self, **options: Any) -> None:
        self.do("change", options=options)

    def worked(self, action: str) -> dict[str, Any]:
        """What long work returns, as it comes from its process."""
        work = TAB.action(action, {}).work(self.state, self.services)
        module, name = work.function.split(":")
        assert module == task.__name__
        request = json.loads(json.dumps(work.request))
        return json.loads(json.dumps(getattr(task, name)(request, self.blobs, Report())))

    def run(self, action: str = "run") -> None:
        result = self.worked(action)
        self.state = TAB.action(action, {}).finished(self.state, result)
        self.survives()

    def survives(self) -> None:
        """The state is what is read from what is written of it."""
        document = Document(quad=self.state)
        assert Document.model_validate(document.model_dump(mode="json")) == document

    @property
    def view(self) -> dict[str, Any]:
        return TAB.view(self.state, self.services)

    def arrays(self, blob: str) -> dict[str, NDArray[Any]]:
        return dict(self.blobs.get_message(blob).arrays)

    @property
    def details(self) -> dict[str, NDArray[Any]]:
        return self.arrays(self.view["result"]["details"])

    @property
    def lines(self) -> dict[str, NDArray[Any]]:
        return self.arrays(self.view["wish"]["lines"])


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """A sheet with a hole, in quads; tests take copies of its state."""
    sheet = plate(circle(5, 4, 1.5, 24))
    desk = Desk(tmp_path_factory.mktemp("made"), sheet, quads=150, seed=3, about="a sheet")
    desk.run()
    return desk


@pytest.fixture(scope="module")
def by_recipe(made: Desk) -> hk.QuadResult:
    """The same, by its recipe alone."""
    return hk.quad_by_recipe(made.mesh, json.loads(made.state.recipe.text()))


def ends(edges: NDArray[Any]) -> set[tuple[int, int]]:
    return {(min(edge), max(edge)) for edge in edges.tolist()}


def test_quads_are_those_of_the_recipe(made: Desk, by_recipe: hk.QuadResult) -> None:
    assert made.state.made is not None
    mine, other = made.blobs.result(made.state.made).to_arrays(), by_recipe.to_arrays()
    assert mine.keys() == other.keys()
    for name, values in mine.items():
        assert_array_equal(values, other[name], err_msg=name)


def test_what_is_drawn_is_the_result(made: Desk, by_recipe: hk.QuadResult) -> None:
    message = made.blobs.get_message(made.view["surfaces"]["quads"]["data"])
    centre, scale = np.array(message.header["centre"]), message.header["scale"]
    drawn = centre + scale * message.arrays["positions"].astype(np.float64)
    assert_allclose(drawn, by_recipe.mesh.vertices, atol=1e-6 * scale)
    assert ends(message.arrays["edges"]) == ends(by_recipe.mesh.topology.edges)
    assert ends(message.arrays["creases"]) == ends(by_recipe.features)
    assert message.header["faces"] == by_recipe.quality.quads


def test_details_are_counted_face_by_face(made: Desk, by_recipe: hk.QuadResult) -> None:
    quads, details = by_recipe, made.details
    around = Counter(quads.mesh.indices.tolist())
    sides: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number, face in enumerate(np.asarray(quads.mesh.faces).tolist()):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            sides[min(a, b), max(a, b)].append(number)
    border = {v for edge, faces in sides.items() if len(faces) == 1 for v in edge}
    arcs = {
        edge
        for edge, faces in sides.items()
        if len(faces) == 1 or quads.patches[faces[0]] != quads.patches[faces[1]]
    }
    assert ends(details["arcs"]) == arcs
    inside = {v: count for v, count in around.items() if v not in border and count != 4}
    found = dict(zip(details["irregular"].tolist(), details["kind"].tolist(), strict=True))
    assert inside.keys() <= found.keys()
    assert found.keys() - inside.keys() <= border
    kinds = {3: 0, 5: 1}
    assert all(found[v] == kinds.get(count, 2) for v, count in inside.items())
    counted = [kind["count"] for kind in made.view["result"]["kinds"]]
    assert counted == [list(found.values()).count(kind) for kind in range(3)]
    assert sum(counted) == quads.quality.irregular > 0


def test_shapes_are_the_least_sine_of_each_quad(made: Desk, by_recipe: hk.QuadResult) -> None:
    quads = by_recipe.mesh
    corners = quads.vertices[np.asarray(quads.faces)][..., :2]  # of a flat sheet
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    area = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
    sines = area / np.linalg.norm(ahead, axis=2) / np.linalg.norm(back, axis=2)
    assert_allclose(made.details["shape"], sines.min(axis=1), atol=1e-6)


def test_neighbouring_patches_have_other_colours(made: Desk, by_recipe: hk.QuadResult) -> None:
    patches, colours = by_recipe.patches, made.details["patch"]
    of_patch = defaultdict(set)
    for patch, colour in zip(patches.tolist(), colours.tolist(), strict=True):
        of_patch[patch].add(tuple(colour))
    assert all(len(colours) == 1 for colours in of_patch.values())
    assert len(set.union(*of_patch.values())) > 1


def test_figures_are_those_of_the_result(made: Desk, by_recipe: hk.QuadResult) -> None:
    quality = by_recipe.quality
    rows = {row["label"]: row for row in made.view["result"]["figures"]}
    assert rows["Quads"]["value"] == quality.quads
    assert "150" in rows["Quads"]["hint"]
    assert rows["Flipped quads"]["value"] == rows["Folded quads"]["value"] == 0
    assert rows["Worst shape"]["value"] == pytest.approx(quality.worst_scaled_jacobian, abs=1e-3)
    assert rows["Mean distance"]["value"] == pytest.approx(100 * quality.mean_distance, rel=0.06)
    assert not any(row["bad"] for row in rows.values())
    assert made.view["result"]["warnings"] == []


def test_a_result_is_of_its_recipe_only(made: Desk) -> None:
    before = made.state
    try:
        made.change(quads=151)
        assert made.state.made is None
        assert not made.view["result"]["current"]
        assert "again" in made.view["next"]
        made.change(quads=150, about="the same")
        assert made.state.made == before.made
        assert made.view["result"]["current"]
        made.do("use", slot="mesh", mesh=None)
        assert made.state.result is None
    finally:
        made.state = before


def test_a_result_for_another_mesh_is_left_out(made: Desk) -> None:
    result = made.state.result
    assert result is not None
    told = {"mesh": "m2", **result.model_dump(mode="json")}
    run = TAB.action("run", {})
    bare = made.state.model_copy(update={"result": None})
    assert run.finished(bare, told) is bare
    assert run.finished(bare, {**told, "mesh": "m1"}) == made.state


def test_quads_can_be_opened_as_a_mesh(made: Desk, by_recipe: hk.QuadResult) -> None:
    product = TAB.product(made.state, "quads", made.services)
    surface = made.blobs.surface(product.surface)
    assert_array_equal(surface.vertices, by_recipe.mesh.vertices)
    assert (product.vertices, product.faces) == (len(surface.vertices), surface.face_count)
    assert product.name == "part quads"
    assert product.about.startswith("quads, 2 boundary loops")
    with pytest.raises(InvalidInput, match="cage"):
        TAB.product(made.state, "cage", made.services)


def test_a_cage_is_that_of_the_recipe(tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), layout="field")
    desk.run("make_cage")
    product = TAB.product(desk.state, "cage", desk.services)
    cage = hk.quad.quad_cage(desk.mesh, layout="field")
    surface = desk.blobs.surface(product.surface)
    assert_array_equal(surface.vertices, cage.vertices)
    assert_array_equal(surface.faces, cage.faces)
    drawn = desk.arrays(desk.view["surfaces"]["cage"]["data"])
    assert len(drawn["creases"]) == cage.attributes.corner["crease"].sum() / 2  # it is closed


# Before they are made


@pytest.mark.parametrize("angle", [30, 90, 179])
def test_edges_that_fold_come_first(angle: float, tmp_path: Path) -> None:
    desk = Desk(tmp_path, bumpy(2, seed=1), sharp=angle)
    lines = desk.lines
    normals = np.cross(*np.moveaxis(np.diff(desk.mesh.vertices[desk.mesh.faces], axis=1), 1, 0))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    beside: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number, (a, b, c) in enumerate(desk.mesh.faces.tolist()):
        for p, q in ((a, b), (b, c), (c, a)):
            beside[min(p, q), max(p, q)].append(number)
    fold = {
        edge: np.degrees(np.arccos(np.clip(normals[i] @ normals[j], -1, 1)))
        for edge, (i, j) in beside.items()
    }
    kept = lines["edges"][lines["angles"] >= angle]
    assert ends(kept) == {edge for edge, degrees in fold.items() if degrees >= angle}
    assert (np.diff(lines["angles"]) <= 0).all()
    told = [fold[min(a, b), max(a, b)] for a, b in lines["edges"].tolist()]
    assert_allclose(lines["angles"], told, atol=1e-3)


def test_boundaries_are_always_among_them(tmp_path: Path) -> None:
    desk = Desk(tmp_path, plate(circle(5, 4, 1.5, 24)))
    topology = desk.mesh.topology
    border = np.flatnonzero(topology.twin < 0)
    expected = ends(np.stack([desk.mesh.indices[border], topology.target[border]], axis=1))
    assert desk.view["wish"]["border"] == len(expected) == len(ends(desk.lines["edges"]))
    for sharp in (None, 30, 180, [[int(v) for v in topology.edges[0]]]):
        desk.change(sharp=sharp)
        assert ends(desk.lines["edges"][: len(expected)]) == expected


@pytest.mark.parametrize("size", [{"quads": 400}, {"edge_length": 0.2}, {"quads": 3}])
def test_found_edges_are_those_that_the_method_keeps(size: Any, tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), **size)
    wish = Wish.of(desk.mesh, size.get("quads"), size.get("edge_length"), None)
    marked = np.flatnonzero(feature_half_edges(desk.mesh, None, wish.sizes))
    topology = desk.mesh.topology
    kept = np.stack([desk.mesh.indices[marked], topology.target[marked]], axis=1)
    assert ends(desk.lines["edges"]) == ends(kept)
    assert len(desk.lines["edges"]) == len(ends(kept))


def test_sizes_give_the_number_that_is_asked_for(tmp_path: Path) -> None:
    mesh = subdivided_box()
    near = 1 + 7 * np.exp(-(mesh.vertices[:, 0] ** 2))
    values = {"near": near, "signed": mesh.vertices[:, 0] - 1, "color": np.ones((len(near), 3))}
    mesh = hk.Mesh(mesh.vertices, mesh.faces, attributes=Attributes(vertex=values))
    desk = Desk(tmp_path, mesh, quads=700)
    assert desk.view["wish"]["densities"] == ["near"]
    assert "sizes" not in desk.view["wish"]
    desk.change(density="near")
    sizes = desk.view["wish"]["sizes"]
    lengths = desk.arrays(sizes["data"])["values"].astype(np.float64)
    assert expected_quads(mesh, lengths) == pytest.approx(700, rel=1e-4)
    assert_allclose(lengths * np.sqrt(near), lengths[0] * np.sqrt(near[0]), rtol=1e-5)
    assert_allclose(sizes["limits"], [lengths.min(), lengths.max()], rtol=1e-6)
    desk.change(density="signed")
    assert "not positive" in desk.view["trouble"]


def test_a_plane_of_symmetry_is_shown_and_tried(tmp_path: Path) -> None:
    box = subdivided_box()
    desk = Desk(tmp_path, box, symmetry="y")
    assert "trouble" not in desk.view
    point, normal = desk.view["wish"]["plane"]
    assert_allclose(normal, [0, 1, 0])
    assert_allclose(point, (box.vertices.min(axis=0) + box.vertices.max(axis=0)) / 2, atol=1e-9)
    desk.do("load", recipe={"symmetry": {"point": [0, 0, 0], "normal": [1, 2, 3]}})
    told = desk.view["trouble"]
    assert desk.view["next"] == ""
    with pytest.raises(HenkeiError) as refused:
        desk.worked("run")
    assert str(refused.value) == told


def test_a_mesh_that_cannot_be_done_says_why(tmp_path: Path) -> None:
    fan = hk.Mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3], [1, 0, 2]])
    desk = Desk(tmp_path, fan)
    assert list(desk.view["surfaces"]) == ["input"]
    assert "wish" not in desk.view
    with pytest.raises(InvalidMesh) as refused:
        desk.worked("run")
    assert str(refused.value) == desk.view["trouble"]


@pytest.mark.parametrize("size", [{"edge_length": 1e-300}, {"edge_length": 1e-5}])
@pytest.mark.parametrize("more", [{}, {"sharp": 30.0}])
def test_more_quads_than_can_be_made_are_told(size: Any, more: Any, tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), **size, **more)
    assert desk.view["wish"]["area"] == pytest.approx(22.0)
    assert "20,000,000 are the most" in desk.view["trouble"]
    with pytest.raises(InvalidInput) as refused:
        desk.worked("run")
    assert str(refused.value) == desk.view["trouble"]


def test_edges_longer_than_the_surface_give_the_fewest_quads(tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), edge_length=1e300, sharp=[], density="curvature")
    assert "trouble" not in desk.view
    values = desk.arrays(desk.view["wish"]["sizes"]["data"])["values"]
    assert expected_quads(desk.mesh, values) == pytest.approx(1, rel=1e-5)


def test_large_meshes_are_only_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("henkei.studio.quad_preview.MANY_FACES", 10)
    desk = Desk(tmp_path, subdivided_box(), density="curvature", symmetry="x")
    wish = desk.view["wish"]
    assert wish["large"]
    assert wish["area"] == pytest.approx(22.0)
    assert not {"lines", "sizes", "plane"} & wish.keys()


# Settings


def test_one_size_takes_the_place_of_the_other(tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), quads=300, seed=2)
    desk.change(edge_length=0.5)
    assert (desk.state.recipe.quads, desk.state.recipe.edge_length) == (None, 0.5)
    desk.change(quads=10)
    assert (desk.state.recipe.quads, desk.state.recipe.edge_length) == (10, None)
    desk.change(quads=None, seed=None)
    assert desk.state.recipe.text() == "{}\n"
    desk.change(layout="vsa", patches=9)
    desk.change(layout="field")
    assert desk.state.recipe.patches is None


def test_another_mesh_keeps_what_is_not_about_the_first(tmp_path: Path) -> None:
    plane = {"point": [0, 0, 0], "normal": [1, 0, 0]}
    told = {"edge_length": 0.5, "sharp": [[0, 1]], "density": "near", "symmetry": plane, "seed": 7}
    desk = Desk(tmp_path, subdivided_box(), **told)
    desk.open("m2", "other", bumpy(1, seed=0))
    desk.do("use", slot="mesh", mesh="m2")
    assert desk.state.recipe.model_dump(exclude_defaults=True) == {"seed": 7}
    general = {"quads": 50, "sharp": 30.0, "density": "curvature", "symmetry": "x"}
    desk.do("load", recipe=general)
    desk.do("use", slot="mesh", mesh="m1")
    assert desk.state.recipe.model_dump(exclude_defaults=True) == general


def test_a_recipe_that_came_before_the_mesh_stays(tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box())
    desk.state = QuadState()
    desk.do("load", recipe={"edge_length": 0.5})
    desk.do("use", slot="mesh", mesh="m1")
    assert desk.state.recipe.edge_length == 0.5


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"quads": 0}, "quads"),
        ({"quads": 10, "edge_length": 1.0}, "give one"),
        ({"edge_length": float("nan")}, "edge_length"),
        ({"layout": "field", "patches": 9}, "patches"),
        ({"layout": "best"}, "layout"),
        ({"sharp": 0}, "sharp"),
        ({"sharp": [[1, 2, 3]]}, "sharp"),
        ({"density": "sizes.npy"}, "no files"),
        ({"symmetry": "w"}, "symmetry"),
        ({"seed": -1}, "seed"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_what_cannot_be_is_refused(options: dict[str, Any], told: str, tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), quads=300)
    before = desk.state
    with pytest.raises(InvalidInput, match=told):
        desk.change(**options)
    assert desk.state is before
    with pytest.raises(InvalidInput, match="no files"):
        desk.do("load", recipe={"density": "/somewhere/sizes.txt"})


def test_edges_that_the_mesh_lacks_are_told(tmp_path: Path) -> None:
    desk = Desk(tmp_path, subdivided_box(), sharp=[[0, 10**6]])
    assert "lacks" in desk.view["trouble"]


def test_without_a_mesh_there_is_nothing_to_make(tmp_path: Path) -> None:
    services = Services(Blobs(tmp_path))
    view = TAB.view(QuadState(), services)
    assert view["surfaces"] == {}
    assert "Open" in view["next"]
    with pytest.raises(InvalidInput, match="no mesh"):
        TAB.action("run", {}).work(QuadState(), services)


def test_too_few_quads_are_refused_with_what_it_takes(tmp_path: Path) -> None:
    holes = [circle(x, y, 0.7, 16) for x in (2, 5, 8) for y in (2, 6)]
    desk = Desk(tmp_path, plate(*holes), quads=4)
    with pytest.raises(Infeasible, match="ask for that many"):
        desk.worked("run")
