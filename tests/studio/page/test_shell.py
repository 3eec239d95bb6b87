"""The page around the tabs: opening, keys, messages, exports, and a server that goes away."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from driven import Driven, studio_running
from henkei import write
from henkei.recipes.deform import DeformRecipe
from henkei.shapes import bracket, mediator, plate_with_holes

if TYPE_CHECKING:
    from playwright.sync_api import Browser

TAB = "() => document.querySelector('[role=tab][aria-selected=true]').textContent"
THEME = "() => document.documentElement.dataset.theme"


def meshes(page: Driven) -> list[str]:
    """Names on the shelf."""
    shelf = page.page.get_by_role("list", name="Open meshes")
    return shelf.locator(".name").all_inner_texts()


def test_meshes_are_opened_renamed_removed_and_brought_back(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_mesh(mediator(), tmp_path / "one.obj")
    page.open_mesh(bracket(), tmp_path / "two.obj")
    assert meshes(page) == ["one.obj", "two.obj"]
    page.button("Rename one.obj").click()
    page.page.keyboard.type("first 1 f")  # neither a tab nor the view
    page.press("Enter")
    page.until(lambda: meshes(page) == ["first 1 f", "two.obj"], "the new name")
    page.button("Remove two.obj").click()
    page.until(lambda: meshes(page) == ["first 1 f"], "one mesh less")
    page.press("Control+z")
    page.press("Control+z")
    page.until(lambda: meshes(page) == ["one.obj", "two.obj"], "all as it was")
    page.press("Control+Shift+Z")
    page.until(lambda: meshes(page) == ["first 1 f", "two.obj"], "the new name again")


def test_files_are_open_in_the_order_in_which_they_were_chosen(
    page: Driven, tmp_path: Path
) -> None:
    page.draw(False)
    large, small = tmp_path / "large.obj", tmp_path / "small.obj"
    write(large, plate_with_holes(60_000))
    write(small, bracket())
    page.page.set_input_files("#files", [large, small])
    page.until(lambda: meshes(page) == ["large.obj", "small.obj"], "both")
    page.settle()
    state = page.tab("combine")["state"]
    assert (state["a"], state["b"]) == ("m1", "m2")


def test_keys_work_after_a_release_that_the_page_was_not_told_of(page: Driven) -> None:
    page.draw(False)
    page.page.evaluate(
        "() => document.body.dispatchEvent("
        "new PointerEvent('pointerdown', {bubbles: true, button: 2, buttons: 2}))"
    )
    page.page.keyboard.press("4")
    assert page.page.evaluate(TAB) == "Combine"
    page.page.mouse.move(300, 300)
    page.page.keyboard.press("4")
    page.until(lambda: page.page.evaluate(TAB) == "Quad", "the tab")


def test_a_page_that_is_loaded_again_in_a_drag_has_it_as_a_step(page: Driven) -> None:
    page.draw(False)
    page.open_example("Bend a bumper")
    page.page.evaluate(
        "() => window.henkei.studio.live('deform', 'move_handle',"
        " {name: 'emblem', move: {translation: [0, 0, 33]}})"
    )
    page.page.wait_for_function("() => window.henkei.stats.received.frames > 1")
    page.load()
    assert page.state["undo"] == "move handle"
    (handle,) = page.recipe("deform")["handles"]
    assert handle["move"]["translation"] == [0, 0, 33]


def test_files_are_dropped_and_what_is_wrong_with_them_is_told(page: Driven) -> None:
    page.draw(False)
    text = "\\n".join(["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1"])
    text += "\\n" + "\\n".join(["f 1 3 2", "f 1 2 4", "f 2 3 4", "f 1 4 3"])
    dropped = page.page.evaluate_handle(
        "() => { const held = new DataTransfer();"
        f" held.items.add(new File(['{text}'], 'dropped.obj'));"
        " held.items.add(new File(['v 1 nonsense'], 'broken.obj'));"
        " held.items.add(new File(['words'], 'letter.txt')); return held; }"
    )
    page.page.dispatch_event("body", "dragover", {"dataTransfer": dropped})
    assert page.page.get_by_text("Drop to open").is_visible()
    page.page.dispatch_event("body", "drop", {"dataTransfer": dropped})
    page.until(lambda: meshes(page) == ["dropped.obj"], "the mesh")
    page.until(lambda: len(page.toasts()) == 2, "two refusals")
    assert not page.page.get_by_text("Drop to open").is_visible()
    told = "\n".join(page.toasts())
    assert "broken.obj" in told
    assert "letter.txt" in told
    assert ".ply" in told  # what could be opened instead
    page.button("Dismiss").first.click()
    page.until(lambda: len(page.toasts()) == 1, "one was closed")


def test_keys_open_tabs_and_help_but_not_while_typing(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_mesh(bracket(), tmp_path / "part.obj")
    for key, title in enumerate(["Combine", "Register", "Deform", "Quad", "Design"], start=1):
        page.press(str(key))
        assert page.page.evaluate(TAB) == title
    page.press("?")
    told = page.page.get_by_role("dialog", name="Keyboard and mouse")
    assert "Undo" in told.inner_text()
    page.press("2")  # the dialog has the keyboard
    assert page.page.evaluate(TAB) == "Design"
    page.press("Escape")
    assert not told.is_visible()
    page.button("Dark theme").click()
    page.load()
    assert page.page.evaluate(THEME) == "dark"
    assert page.page.evaluate(TAB) == "Design"
    assert meshes(page) == ["part.obj"]


def test_exports_are_downloaded_or_it_is_told_what_is_missing(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.open_tab("Deform")
    page.open_mesh(bracket(), tmp_path / "part.obj")
    page.button("Export").click()
    page.page.get_by_role("menuitem", name="PLY").click()
    page.until(lambda: any("nothing is fixed" in told for told in page.toasts()), "a refusal")
    page.button("Export").click()
    with page.page.expect_download() as download:
        page.page.get_by_role("menuitem", name="Recipe", exact=True).click()
    download.value.save_as(tmp_path / "recipe.json")
    written = DeformRecipe.read(tmp_path / "recipe.json").model_copy(update={"schema_file": None})
    assert written == DeformRecipe.of(page.recipe("deform"))


EXPORT = """() => {
  const {studio} = window.henkei;
  studio.onEnded = (ended) => { window.missed = ended; };
  return studio.exportAs("deform", "recipe");
}"""
CUT = "() => { delete henkei.studio.onEnded; henkei.studio.connection.socket.close(); }"


@pytest.mark.parametrize("loaded", [True, False], ids=["loaded again", "cut off"])
def test_an_export_that_the_page_was_not_told_of_is_saved(
    page: Driven, tmp_path: Path, loaded: bool
) -> None:
    page.draw(False)
    page.open_tab("Deform")
    page.open_mesh(bracket(), tmp_path / "part.obj")
    page.forgive("404")  # it asks whether the server is there
    page.page.evaluate(EXPORT)
    page.page.wait_for_function("() => window.missed?.file")
    saved: list[Any] = []
    page.page.on("download", lambda one: saved.append(one))
    with page.page.expect_download() as download:
        if loaded:
            page.load()
        else:
            page.page.evaluate(CUT)
    download.value.save_as(tmp_path / "recipe.json")
    written = DeformRecipe.read(tmp_path / "recipe.json").model_copy(update={"schema_file": None})
    assert written == DeformRecipe.of(page.recipe("deform"))
    page.load()
    page.open_tab("Quad")
    assert len(saved) == 1


def test_a_mistake_of_the_page_is_told_and_the_page_lives(page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    page.forgive("on purpose")
    page.open_mesh(bracket(), tmp_path / "part.obj")
    page.page.evaluate("() => void setTimeout(() => { throw new Error('on purpose'); })")
    page.until(lambda: page.toasts(), "a message")
    assert "on purpose" in page.toasts()[0]
    assert page.button("Load again").is_visible()
    page.press("4")
    assert page.page.evaluate(TAB) == "Quad"


def test_what_is_done_while_the_server_is_away_is_done_when_it_is_back(
    browser: Browser, tmp_path: Path
) -> None:
    folder = tmp_path / "studio"
    with studio_running(folder) as first:
        port = first.port
        page = Driven(browser.new_page(), first)
        page.forgive("ERR_CONNECTION_REFUSED|WebSocket|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE")
        page.load()
        page.draw(False)
        page.open_mesh(bracket(), tmp_path / "part.obj")
        first.kill()
    away = page.page.get_by_text("The studio's server is away")
    away.wait_for()
    page.button("Rename part.obj").click()
    page.page.keyboard.type("renamed")
    page.page.keyboard.press("Enter")
    with studio_running(folder, port=port):
        away.wait_for(state="hidden")
        page.until(lambda: meshes(page) == ["renamed"], "the new name")
        page.press("Control+z")
        page.until(lambda: meshes(page) == ["part.obj"], "the name before")
        page.page.close()
    assert not page.errors


def test_a_recipe_is_opened_after_the_mesh_that_it_is_for(page: Driven, tmp_path: Path) -> None:
    mesh, recipe = tmp_path / "bracket.obj", tmp_path / "a_recipe.json"
    write(mesh, bracket())
    recipe.write_text(json.dumps({"fixed": ["rim 1"], "features": ["hole *"]}))
    page.page.set_input_files("#files", [recipe, mesh])
    page.until(lambda: page.tab("deform")["view"].get("parts"), "the recipe")
    assert page.recipe("deform")["fixed"][0]["region"] == "rim 1"
    assert [one["name"] for one in page.state["meshes"]] == ["bracket.obj"]
