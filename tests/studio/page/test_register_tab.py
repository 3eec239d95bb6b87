"""A person registers in the page: landmarks, the model on its way, and what the recipe makes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import henkei as hk
from bodies import bumpy, moved
from driven import Driven
from henkei.mesh import Mesh
from henkei.recipes.register import RegisterRecipe
from henkei.studio.tasks.register import LIVE

SOURCE, TARGET = bumpy(2, 0), moved(bumpy(3, 1), 2.0, shift=(3, 0, 0))
SIDES = ("source", "target")
DONE = "registered"
NEAR = 3e-6  # of positions that are drawn in 32 bits, by the size of what is drawn
_COUNT_FRAMES = """(key) => {
  const app = window.henkei.studio, take = app.onFrame.bind(app);
  window.seen = [];
  app.onFrame = (message) => {
    take(message);
    const view = window.henkei.stage.viewports[0].surface(key);
    if (message.header.surface === key && view) window.seen.push([...view.positions]);
  };
}"""


def opened(page: Driven, folder: Path, source: Mesh = SOURCE, target: Mesh = TARGET) -> None:
    page.draw(False)
    page.open_tab("Register")
    page.open_mesh(source, folder / "source.obj")
    page.open_mesh(target, folder / "target.obj")


def state(page: Driven) -> dict[str, Any]:
    found: dict[str, Any] = page.tab("register")["state"]
    return found


def view(page: Driven) -> dict[str, Any]:
    found: dict[str, Any] = page.tab("register")["view"]
    return found


def seen(page: Driven, side: int, count: int) -> list[int]:
    """Vertices of a mesh that a click would mean, well apart."""
    found = page.page.evaluate(
        "([side, key]) => { const viewport = window.henkei.stage.viewports[side];"
        " const { count } = viewport.surface(key);"
        " return [...Array(count).keys()].filter((vertex) => {"
        " const hit = viewport.pick(...viewport.project(key, vertex));"
        " return hit?.vertex === vertex && !hit.snapped; }); }",
        [side, SIDES[side]],
    )
    points = (SOURCE, TARGET)[side].vertices[found]
    chosen = [0]
    while len(chosen) < count:  # the farthest from those that are chosen
        away = np.linalg.norm(points[:, None] - points[chosen], axis=2).min(axis=1)
        chosen.append(int(away.argmax()))
    return [int(found[k]) for k in chosen]


def made(page: Driven, source: Mesh = SOURCE, target: Mesh = TARGET) -> hk.Registration:
    """What the recipe makes without the page; the page has the same, and draws it."""
    alone = hk.register_by_recipe(source, target, RegisterRecipe.of(page.recipe("register")))
    kept: hk.Registration = page.studio.blobs.result(state(page)["result"]["result"])
    assert kept.mesh.vertices.tobytes() == alone.mesh.vertices.tobytes()
    assert kept.quality == alone.quality
    size = np.ptp(target.vertices, axis=0).max()
    np.testing.assert_allclose(page.positions(DONE), alone.mesh.vertices, atol=NEAR * size)
    return alone


def slide(page: Driven, label: str, value: float) -> None:
    field = page.page.get_by_role("spinbutton", name=f"{label} value")
    field.fill(str(value))
    field.press("Enter")
    page.settle()


def figures(page: Driven) -> dict[str, str]:
    """What the panel says, by its labels."""
    rows = page.page.get_by_label("Figures of the registration").locator("div").all()
    return dict(row.inner_text().split("\n", 1) for row in rows)


def test_landmarks_are_clicked_dragged_and_removed(page: Driven, tmp_path: Path) -> None:
    opened(page, tmp_path)
    ours, theirs = seen(page, 0, 4), seen(page, 1, 4)
    for i, j in zip(ours[:3], theirs[:3], strict=True):
        page.click_vertex("source", i, 0)
        assert "target" in page.hint()
        page.click_vertex("target", j, 1)
    pairs = [list(pair) for pair in zip(ours[:3], theirs[:3], strict=True)]
    assert page.recipe("register")["landmarks"] == pairs

    page.draw(True)
    end = page.project("target", theirs[3], 1)
    start = page.project("target", theirs[1], 1)
    page.drag([start, ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2), end])
    page.draw(False)
    pairs[1][1] = theirs[3]
    assert page.recipe("register")["landmarks"] == pairs

    page.button("Remove Landmark 1").click()
    page.settle()
    assert page.recipe("register")["landmarks"] == pairs[1:]
    page.page.get_by_label("Landmarks", exact=True).get_by_text("Landmark 2").click()
    page.press("Delete")
    assert page.recipe("register")["landmarks"] == pairs[1:2]
    page.press("Control+z")
    page.press("Control+z")
    assert page.recipe("register")["landmarks"] == pairs

    page.button("By vertex number …").click()
    page.page.get_by_label("Vertex of the source").fill(str(ours[3]))
    page.page.get_by_label("Vertex of the target").fill(str(pairs[0][1]))
    page.button("Add").click()
    page.until(lambda: "landmark 1 already" in " ".join(page.toasts()), "a refusal")
    page.page.get_by_label("Vertex of the target").fill(str(theirs[1]))
    page.button("Add").click()
    page.settle()
    assert page.recipe("register")["landmarks"] == [*pairs, [ours[3], theirs[1]]]


def test_landmarks_come_from_files(page: Driven, tmp_path: Path) -> None:
    opened(page, tmp_path)
    pairs = [[3, 7], [40, 300], [120, 12]]
    for name, mesh, column in (("z.vts", SOURCE, 0), ("a.vts", TARGET, 1)):
        rows = ([pair[column], *mesh.vertices[pair[column]].tolist()] for pair in pairs)
        (tmp_path / name).write_text("\n".join(" ".join(map(str, row)) for row in rows))
    page.page.set_input_files(
        "input[aria-label='Files of landmarks']", [tmp_path / "a.vts", tmp_path / "z.vts"]
    )
    page.until(lambda: page.recipe("register")["landmarks"] or None, "landmarks")
    page.settle()
    rows = view(page)["landmarks"]
    assert [[row["source"], row["target"]] for row in rows] == pairs
    page.button("Clear").click()
    page.settle()

    (tmp_path / "pairs.json").write_text(json.dumps(pairs[:2]))
    page.page.set_input_files("#files", str(tmp_path / "pairs.json"))
    page.until(lambda: page.recipe("register")["landmarks"] == pairs[:2], "landmarks")
    page.settle()
    (tmp_path / "pairs.json").write_text("[[1, 2], [3, 99999]]")
    page.page.set_input_files("#files", str(tmp_path / "pairs.json"))
    page.until(lambda: "no vertex 99999" in " ".join(page.toasts()), "a refusal")
    assert page.recipe("register")["landmarks"] == pairs[:2]


def test_the_model_deforms_and_is_what_the_recipe_makes(page: Driven, tmp_path: Path) -> None:
    source, target = bumpy(3, 0), bumpy(3, 1)
    opened(page, tmp_path, source, target)
    assert "Landmark" in view(page)["next"]
    slide(page, "Keep form", 0.002)
    page.page.get_by_label("Mediator").select_option("sphere")
    page.page.evaluate(_COUNT_FRAMES, LIVE)
    page.press("Enter")
    page.until(lambda: state(page)["result"], "a result")
    page.settle()

    shown: list[NDArray[np.float64]] = [
        np.array(one) for one in page.page.evaluate("() => window.seen")
    ]
    assert len(shown) > 2
    assert np.abs(shown[0] - shown[-1]).max() > 0.01  # of half the diagonal
    result = made(page, source, target)
    assert page.recipe("register")["distortion"] == 0.002
    told = figures(page)
    mean = float(told["Target off the model, mean"].split()[0])
    assert mean == pytest.approx(100 * result.quality.to_source_mean, rel=0.01)
    assert told["Faces turned over"] == str(result.quality.inverted) == "0"

    legend = page.page.locator(".viewer-legend:visible")
    assert "Distance from the target" in legend.inner_text()
    assert "% of the diagonal" in legend.inner_text()
    page.page.get_by_label("Colour by").select_option("Growth")
    page.settle()
    assert "doublings of area" in legend.inner_text()

    last = page.positions(DONE)
    slide(page, "Time", 0.0)
    first = page.positions(DONE)
    slide(page, "Time", 0.5)
    np.testing.assert_allclose(page.positions(DONE), (first + last) / 2, atol=1e-5)
    page.press("Space")
    page.until(lambda: np.abs(page.positions(DONE) - (first + last) / 2).max() > 1e-3, "a morph")
    page.press("Space")

    page.button("Export").click()
    with page.page.expect_download() as coming:
        page.page.get_by_role("menuitem", name="PLY").first.click()
    coming.value.save_as(tmp_path / "model.ply")
    np.testing.assert_array_equal(hk.read(tmp_path / "model.ply").vertices, result.mesh.vertices)

    page.press("Control+z")
    assert state(page)["result"] is None
    page.press("Control+Shift+Z")
    page.load()
    page.draw(False)
    page.press("m")
    made(page, source, target)


def test_cancelling_leaves_what_was(page: Driven, tmp_path: Path) -> None:
    opened(page, tmp_path, bumpy(5, 0), bumpy(5, 1))
    before = state(page)
    page.button("Register").click()
    page.until(lambda: LIVE in page.page.evaluate("() => henkei.stage.viewports[0].keys"))
    page.button("Cancel Register").click()
    page.settle()
    assert state(page) == before
    assert page.page.evaluate("() => window.henkei.stage.viewports.length") == 2
    assert page.button("Register").is_enabled()
    assert not page.toasts()
