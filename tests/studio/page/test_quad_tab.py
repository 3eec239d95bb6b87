"""A person makes quads in the page, looks at them, and takes them along."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import henkei as hk
from driven import Driven
from henkei.geometry.creases import Folds
from parts import circle, plate, subdivided_box

SEEN = """() => {
  const [viewport] = window.henkei.stage.viewports;
  return viewport.keys.filter((key) => viewport.surface(key).styled.visible);
}"""
DRAWN_LINES = """() => {
  const lines = window.henkei.stage.viewports[0].surface("lines");
  return lines.drawn.outlines.creases.drawRange.count / 2;
}"""


def seen(page: Driven) -> set[str]:
    """Keys of the surfaces that are in the picture."""
    return set(page.page.evaluate(SEEN))


def is_seen(page: Driven, *keys: str) -> None:
    page.until(lambda: seen(page) == set(keys), f"{keys} in the picture, not {seen(page)}")


def legend(page: Driven) -> str:
    shown = page.page.locator(".viewer-legend:visible")
    return str(shown.inner_text()) if shown.count() else ""


def wish(page: Driven, quads: int) -> None:
    field = page.page.get_by_role("spinbutton", name="Quads value")
    field.fill(str(quads))
    field.press("Enter")
    page.settle()


def made(page: Driven) -> dict[str, Any]:
    """The result as the page has it, once it is there."""
    result: dict[str, Any] = page.until(
        lambda: page.tab("quad")["view"].get("result") or None, "quads"
    )
    page.settle()
    return result


def figures(page: Driven) -> dict[str, str]:
    rows = page.page.get_by_label("Figures of the quads").locator("div").all_inner_texts()
    return dict(row.split("\n", 1) for row in rows)  # type: ignore[misc]


def test_quads_are_made_looked_at_and_taken_along(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_tab("Quad")
    page.open_mesh(plate(circle(5, 4, 1.5, 24)), tmp_path / "sheet.obj")
    is_seen(page, "input", "lines")
    wish(page, 150)
    page.press("Enter")
    result = made(page)
    by_recipe = hk.quad_by_recipe(tmp_path / "sheet.obj", page.recipe("quad"))
    vertices = by_recipe.mesh.vertices

    is_seen(page, "quads", "irregular")
    np.testing.assert_allclose(page.positions("quads"), vertices, atol=1e-5)
    told = figures(page)
    assert told["Quads"] == str(by_recipe.quality.quads)
    assert told["Irregular vertices"] == str(by_recipe.quality.irregular)
    for kind in result["kinds"]:
        assert (kind["count"] > 0) == (f"{kind['label']}: {kind['count']}" in legend(page))

    page.press("w")
    assert "scaled Jacobian" in legend(page)
    middle = vertices[np.asarray(by_recipe.mesh.faces)[20]].mean(axis=0)
    page.page.mouse.move(*page.place(middle.tolist()))
    page.until(lambda: page.hint().startswith("Quad 20: shape "), "what is under the pointer")
    page.press("p")
    is_seen(page, "quads", "arcs", "irregular")
    page.press("v")
    is_seen(page, "quads", "arcs")
    page.press("q")
    is_seen(page, "quads")
    page.press("l")
    is_seen(page, "quads", "arcs")
    page.page.keyboard.down("c")
    is_seen(page, "input", "lines")
    page.page.keyboard.up("c")
    is_seen(page, "quads", "arcs")
    page.page.get_by_role("radio", name="Input").check(force=True)
    is_seen(page, "input", "lines")
    page.page.get_by_role("switch", name="Creases and boundaries").click()
    is_seen(page, "input")
    page.press("q")

    page.press("Control+z")
    assert "result" not in page.tab("quad")["view"]
    is_seen(page, "input")
    page.press("Control+Shift+Z")
    is_seen(page, "quads", "arcs")
    page.load()
    page.draw(False)
    is_seen(page, "quads", "irregular")
    np.testing.assert_allclose(page.positions("quads"), vertices, atol=1e-5)

    page.button("Export").click()
    with page.page.expect_download() as coming:
        page.page.get_by_role("menuitem", name="Whole result").click()
    coming.value.save_as(tmp_path / "quads.npz")
    np.testing.assert_array_equal(hk.load(tmp_path / "quads.npz").mesh.vertices, vertices)

    page.button("Use as mesh").click()
    page.until(lambda: len(page.state["meshes"]) == 2, "the quads among the meshes")
    quads = page.state["meshes"][1]
    assert quads["name"] == "sheet.obj quads"
    np.testing.assert_array_equal(page.studio.blobs.surface(quads["surface"]).vertices, vertices)
    page.open_tab("Design")
    page.page.get_by_role("button", name=quads["name"], exact=True).click()
    page.settle()
    assert page.tab("design")["state"]["cage"] == quads["id"]


def test_edges_follow_the_slider_and_old_quads_say_so(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_tab("Quad")
    page.open_mesh(hk.shapes.bracket(), tmp_path / "bracket.obj")
    wish(page, 200)
    page.button("Make quads").click()
    first = made(page)
    page.page.get_by_role("radio", name="By angle").check(force=True)
    page.settle()
    is_seen(page, "input", "lines")
    assert not made(page)["current"]
    assert page.button("Make quads again").is_enabled()

    surface = hk.read(tmp_path / "bracket.obj")
    folds, border = Folds(surface), int((surface.topology.twin < 0).sum())
    assert len(folds.sharp(40)) < len(folds.sharp(5))
    slider = page.page.get_by_role("slider", name="Fold from", exact=True)
    box = slider.bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    page.page.mouse.move(box["x"] + 0.3 * box["width"], y)
    page.page.mouse.down()
    for share in (0.2, 0.1, 0.05, 0.0):
        page.page.mouse.move(box["x"] + 1 + share * box["width"], y)
        angle = float(slider.get_attribute("aria-valuetext") or "nan")
        assert page.page.evaluate(DRAWN_LINES) == border + len(folds.sharp(angle))
    assert page.recipe("quad")["sharp"] == 40
    page.page.mouse.up()
    page.settle()
    assert page.recipe("quad")["sharp"] == angle == 5
    page.press("Control+z")
    assert page.page.evaluate(DRAWN_LINES) == border + len(folds.sharp(40))
    page.press("Control+z")
    assert made(page) == first


def test_long_work_is_cancelled_and_troubles_are_told(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_example("An animal in quads")
    page.page.get_by_role("button", name="Layout, density, symmetry").click()
    page.page.get_by_role("radio", name="z", exact=True).check(force=True)
    page.settle()
    assert "not symmetric" in page.page.locator(".panel .note").first.inner_text()
    assert page.button("Make quads").is_disabled()
    page.page.get_by_role("radio", name="x", exact=True).check(force=True)
    page.settle()
    is_seen(page, "input", "lines", "plane")
    wish(page, 40_000)
    page.button("Make quads").click()
    works = page.page.get_by_role("progressbar")
    page.until(lambda: works.count() > 0, "the work")
    assert [works.nth(k).get_attribute("aria-label") for k in range(works.count())] == [
        "Make quads"
    ]
    assert page.button("Make quads").is_disabled()
    page.button("Cancel Make quads").click()
    page.settle()
    assert "result" not in page.tab("quad")["view"]
    assert page.button("Make quads").is_enabled()
    assert page.toasts() == []
    assert page.recipe("quad")["quads"] == 40_000


def test_a_cage_is_made_and_taken_along(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_tab("Quad")
    page.open_mesh(subdivided_box(), tmp_path / "box.obj")
    page.page.get_by_role("button", name="Cage", exact=True).click()
    page.button("Make cage").click()
    cage = page.until(lambda: page.tab("quad")["state"]["cage"], "the cage")
    page.settle()
    is_seen(page, "input", "cage")
    page.button("Use cage as mesh").click()
    page.until(lambda: len(page.state["meshes"]) == 2, "the cage among the meshes")
    assert page.state["meshes"][1]["surface"] == cage["surface"]
    page.page.get_by_role("switch", name="Show the cage").click()
    is_seen(page, "input", "lines")
