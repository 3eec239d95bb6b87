"""The deform tab by mouse and keyboard; what it draws is what its recipe makes in Python."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import henkei as hk
from driven import Driven
from henkei.mesh import Mesh
from henkei.recipes.deform import DeformRecipe
from henkei.shapes import bracket, bumper, bumper_parts
from henkei.workflows.deform_by_recipe import deform_by_recipe

Floats = NDArray[np.float64]
DRAWN = 1e-6  # of the diagonal, that positions of 32 bits may be off


def wanted(page: Driven, mesh: Mesh) -> Floats:
    """What the recipe of the page makes of the mesh."""
    recipe = DeformRecipe.of(page.recipe("deform"))
    return deform_by_recipe(mesh, recipe).mesh.vertices


def assert_drawn(page: Driven, mesh: Mesh, positions: Floats) -> None:
    """The page draws these positions, or does so as soon as they have come."""

    def apart() -> float:
        return float(np.abs(page.positions("mesh") - positions).max())

    page.until(lambda: apart() <= DRAWN * mesh.diagonal, f"a surface that is {apart():.3g} away")


def moved(page: Driven, mesh: Mesh) -> float:
    return float(np.abs(page.positions("mesh") - mesh.vertices).max())


def parts(page: Driven) -> dict[str, str]:
    """Kinds of the parts by name."""
    return {part["name"]: part["kind"] for part in page.tab("deform")["view"]["parts"]}


def note(page: Driven) -> str:
    return " ".join(page.page.locator(".panel .note, [role=tabpanel] .note").all_inner_texts())


def select(page: Driven, region: NDArray[np.integer]) -> None:
    """By the lasso, as seen from the front: a box around these vertices."""
    pixels = np.array([page.project("mesh", vertex) for vertex in region.tolist()])
    (left, top), (right, bottom) = pixels.min(axis=0) - 4, pixels.max(axis=0) + 4
    page.press("r")
    page.rectangle((left, top), (right, bottom))


def is_blended(page: Driven, mesh: Mesh, way: list[tuple[float, float]]) -> bool:
    """Whether the surface follows the mouse along a way without a frame from the server."""
    received = "() => window.henkei.stats.received.frames"
    before, places = page.page.evaluate(received), []
    for place in way:
        page.page.mouse.move(*place)
        places.append(moved(page, mesh))
    return page.page.evaluate(received) == before and len(set(places)) == len(way)


def test_a_bumper_is_bent_by_its_arrows(page: Driven) -> None:
    mesh = bumper()
    page.open_example("Bend a bumper")
    page.draw(False)
    assert "drag its arrows" in note(page)
    (x, y), way = page.grasp("z")
    steps = [(x + k * 12 * way[0], y + k * 12 * way[1]) for k in range(6)]
    page.drag(steps[:4], release=False)
    page.until(lambda: moved(page, mesh) > 20, "the surface to follow")
    page.until(lambda: is_blended(page, mesh, steps[4:]), "it to be blended on the page")
    page.page.mouse.up()
    page.settle()
    handle = page.recipe("deform")["handles"][0]
    assert handle["name"] == "emblem"
    assert handle["move"]["translation"][:2] == [0, 0]
    assert 40 < handle["move"]["translation"][2] < 70
    bent = wanted(page, mesh)
    assert_drawn(page, mesh, bent)
    hole = hk.find_features(mesh)["hole 5"]
    circle = hk.find_features(replace(mesh, vertices=bent))["hole 5"].circle
    assert abs(circle.radius - hole.circle.radius) < 1e-9 * hole.circle.radius

    (x, y), _ = page.grasp("x", "rotate")
    page.drag([(x, y), (x + 8, y + 12), (x + 20, y + 30)])
    turned = page.recipe("deform")["handles"][0]["move"]
    assert turned["translation"] == handle["move"]["translation"]
    assert abs(turned["rotation"][0]) > 0.1
    assert np.abs(turned["rotation"][1:]).max() < 1e-6
    assert_drawn(page, mesh, wanted(page, mesh))

    (x, y), way = page.grasp("z")
    page.drag([(x, y), (x + 30 * way[0], y + 30 * way[1])], release=False)
    page.page.keyboard.press("Escape")
    page.page.mouse.up()
    page.settle()
    assert page.recipe("deform")["handles"][0]["move"] == turned
    assert_drawn(page, mesh, wanted(page, mesh))

    page.press("Control+z")
    assert_drawn(page, mesh, bent)
    page.press("Control+z")
    assert_drawn(page, mesh, mesh.vertices)
    page.press("Control+Shift+Z")
    page.load()
    assert_drawn(page, mesh, bent)


def test_from_a_file_to_a_bent_bracket(page: Driven, tmp_path: Path) -> None:
    page.open_tab("Deform")
    page.open_mesh(bracket(), tmp_path / "bracket.obj")
    mesh = Mesh.from_any(hk.read(tmp_path / "bracket.obj"))
    page.draw(False)
    assert "press Fix" in note(page)
    select(page, np.flatnonzero(mesh.vertices[:, 1] < mesh.vertices[:, 1].min() + 8))
    page.press("x")
    assert "press Handle" in note(page)
    page.button("Keep all holes").click()
    page.settle()
    x, y = page.project("mesh", int(np.argmax(mesh.vertices[:, 2])))
    page.press("b")
    page.drag([(x + 30, y + 14), (x + 60, y + 20)])
    page.press("g")
    page.press("h")
    assert list(parts(page).items())[:2] == [("fixed 1", "fixed"), ("handle 1", "handles")]
    assert sum(kind == "features" for kind in parts(page).values()) == 4

    field = page.page.get_by_role("spinbutton", name="Move z", exact=True)
    field.fill("12")
    page.until(lambda: moved(page, mesh) > 11, "to be shown while it is typed")
    assert page.recipe("deform")["handles"][0]["move"]["translation"] == [0, 0, 0]
    field.press("Enter")
    page.settle()
    assert page.recipe("deform")["handles"][0]["move"]["translation"] == [0, 0, 12]

    parts_list = page.page.get_by_role("list", name="Parts")
    parts_list.get_by_role("button", name="hole 3", exact=True).click()
    before, bent, undo = page.recipe("deform"), page.positions("mesh"), page.state["undo"]
    field = page.page.get_by_role("spinbutton", name="Radius value", exact=True)
    field.fill("9")
    page.until(lambda: np.abs(page.positions("mesh") - bent).max() > 0.1, "to be shown")
    field.press("Escape")
    assert_drawn(page, mesh, bent)
    page.settle()
    page.load()  # what is still being tried out then would become a step
    assert page.recipe("deform") == before
    assert page.state["undo"] == undo
    page.draw(False)
    parts_list.get_by_role("button", name="hole 3", exact=True).click()
    slider = page.page.get_by_role("slider", name="Radius", exact=True)
    for _ in range(3):
        slider.press("ArrowRight")
    page.settle()
    page.page.get_by_role("spinbutton", name="Radius value", exact=True).fill("10")
    page.page.keyboard.press("Enter")
    page.settle()
    hole = next(one for one in page.recipe("deform")["features"] if one["region"] == "hole 3")
    assert (hole["keep"], hole["radius"]) == ("circle", 10)
    assert_drawn(page, mesh, wanted(page, mesh))

    page.button("Export").click()
    with page.page.expect_download() as waiting:
        page.page.get_by_role("menuitem", name="Recipe", exact=True).click()
    waiting.value.save_as(tmp_path / "recipe.json")
    again = deform_by_recipe(mesh, tmp_path / "recipe.json")
    assert_drawn(page, mesh, again.mesh.vertices)
    assert again.quality.feature_error < 1e-12


def test_pins_are_dragged_in_the_plane_of_the_screen(page: Driven, tmp_path: Path) -> None:
    page.open_tab("Deform")
    page.open_mesh(bumper(2000), tmp_path / "bumper.obj")
    mesh = Mesh.from_any(hk.read(tmp_path / "bumper.obj"))
    page.page.get_by_role("list", name="Found on the surface").get_by_role(
        "button", name="rim 1", exact=True
    ).click()
    page.settle()
    page.press("x")
    assert page.recipe("deform")["fixed"][0]["region"] == "rim 1"
    vertex = int(bumper_parts(2000)["handle"][0])
    page.press("p")
    page.click_vertex("mesh", vertex)
    assert page.recipe("deform")["pins"][0]["point"] == vertex
    page.page.evaluate("() => window.henkei.stage.render()")
    start = page.project("mesh", vertex)
    page.drag_vertex("mesh", vertex, (30, -24))
    pin = page.recipe("deform")["pins"][0]
    assert_drawn(page, mesh, wanted(page, mesh))
    np.testing.assert_allclose(page.project("mesh", vertex), np.add(start, (30, -24)), atol=0.01)
    camera = page.camera()
    ahead = np.subtract(camera["target"], camera["position"])
    places = np.array([pin["to"], mesh.vertices[vertex]])
    np.testing.assert_allclose(*(places - camera["position"]) @ ahead, rtol=1e-6)

    page.page.evaluate("() => window.henkei.stage.render()")
    x, y = page.project("mesh", vertex)
    page.drag([(x, y), (x + 40, y), (x + 60, y)], release=False)
    page.page.keyboard.press("Escape")
    page.page.mouse.up()
    page.settle()
    assert page.recipe("deform")["pins"][0] == pin
    assert_drawn(page, mesh, wanted(page, mesh))
    page.press("Delete")
    assert page.recipe("deform")["pins"] == []
    assert_drawn(page, mesh, mesh.vertices)


def test_settings_colours_and_comparing(page: Driven) -> None:
    mesh = bumper()
    page.open_example("Bend a bumper")
    page.draw(False)
    panel = page.page.get_by_role("tabpanel")
    panel.get_by_role("spinbutton", name="Move z", exact=True).fill("30")
    page.page.keyboard.press("Enter")
    page.settle()
    linear = wanted(page, mesh)
    assert_drawn(page, mesh, linear)

    page.button("Method").click()
    panel.get_by_role("radio", name="Refined").check(force=True)
    panel.get_by_role("radio", name="x", exact=True).check(force=True)
    page.settle()
    refined = wanted(page, mesh)
    assert np.abs(refined - linear).max() > 0.1
    assert page.recipe("deform")["symmetry"]["normal"] == [1, 0, 0]
    assert_drawn(page, mesh, refined)
    panel.get_by_role("radio", name="y", exact=True).check(force=True)
    page.settle()
    assert any("not symmetric" in told for told in page.toasts())
    assert page.recipe("deform")["symmetry"]["normal"] == [1, 0, 0]

    panel.get_by_role("radio", name="Moved").check(force=True)
    legend = page.page.locator(".viewer-legend").first
    assert "Displacement" in legend.inner_text()
    panel.get_by_role("radio", name="Stretch").check(force=True)
    page.until(lambda: "%" in legend.inner_text())
    panel.get_by_role("radio", name="Parts").check(force=True)
    page.until(lambda: not legend.is_visible())

    visible = "(key) => window.henkei.stage.viewports[0].surface(key)?.styled.visible ?? false"
    page.page.locator(".viewer-viewport").first.focus()
    page.page.keyboard.down("c")
    page.until(lambda: page.page.evaluate(visible, "rest"))
    assert not page.page.evaluate(visible, "mesh")
    assert np.abs(page.positions("rest") - mesh.vertices).max() < DRAWN * mesh.diagonal
    page.page.keyboard.up("c")
    page.until(lambda: page.page.evaluate(visible, "mesh"))
    assert not page.page.evaluate(visible, "rest")
    figures = page.page.get_by_label("Figures of the result").inner_text()
    assert "exactly" in figures


def test_parts_are_renamed_removed_and_brought_back(page: Driven) -> None:
    page.open_example("Bend a bumper")
    page.draw(False)
    rows = page.page.get_by_role("list", name="Parts")
    rows.get_by_role("button", name="plate", exact=True).dblclick()
    page.page.get_by_label("New name of plate").fill("licence plate")
    page.page.keyboard.press("Enter")
    page.settle()
    assert parts(page)["licence plate"] == "features"
    found = page.page.get_by_role("list", name="Found on the surface")
    found.get_by_role("checkbox", name="hole 3", exact=True).click()
    page.settle()
    assert "hole 3" not in parts(page)
    assert {"hole 2", "hole 14"} <= set(parts(page))
    page.button("Remove licence plate").click()
    page.settle()
    assert "licence plate" not in parts(page)
    page.press("Control+z")
    page.press("Control+z")
    assert {"licence plate", "hole *"} <= set(parts(page))


def test_numbers_typed_one_after_the_other_are_all_kept(page: Driven) -> None:
    page.open_example("Bend a bumper")
    page.draw(False)
    for name, value in (
        ("Move y", "25"),
        ("Move z", "110"),
        ("Turn x", "8"),
        ("Size value", "1.1"),
    ):
        field = page.page.get_by_role("spinbutton", name=name, exact=True)
        field.fill(value)
        field.press("Enter")  # and on, without waiting for an answer
    page.settle()
    move = page.recipe("deform")["handles"][0]["move"]
    assert (move["translation"], move["rotation"]) == ([0, 25, 110], [8, 0, 0])
    assert move["scale"] == 1.1
