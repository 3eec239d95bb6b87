"""A session: what is done is the document, and pages are told what is."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import henkei as hk
from henkei.shapes import bumper
from henkei.studio.messages import Message
from henkei.studio.outcomes import Done
from seated import Studio, bending, opened


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    studio = Studio(tmp_path / "sessions")
    yield studio
    studio.close()


def test_an_uploaded_mesh_is_open_and_chosen(studio: Studio, tmp_path: Path) -> None:
    studio.do("document", "show", name="deform")
    assert opened(studio, tmp_path, bumper()) == {"mesh": "m1"}
    (mesh,) = studio.page.last["meshes"]
    assert (mesh["name"], mesh["vertices"]) == ("mesh.obj", len(bumper().vertices))
    assert studio.page.tabs["deform"]["state"]["mesh"] == "m1"
    assert studio.page.tabs["deform"]["view"]["surfaces"]["mesh"]["live"]


def test_a_file_that_is_no_mesh_is_refused(studio: Studio, tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nf 1 2 3\n")
    answer = studio.session.uploaded(path, "a.obj")
    assert set(answer) == {"message"}
    assert "a.obj" in answer["message"]
    assert studio.page.last["meshes"] == []


def test_what_a_page_sees_is_what_its_recipe_makes(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    move = {"translation": [0.0, 5.0, 40.0], "rotation": [10.0, 0.0, 0.0]}
    studio.do("deform", "move_handle", name="handle 1", move=move)
    document = studio.on_engine(lambda: studio.session.desk.now)
    made = hk.deform_by_recipe(tmp_path / "mesh.obj", document.deform.recipe)
    shown = studio.page.positions["mesh"]
    centre, scale = studio.on_engine(
        lambda: studio.session._services.frame(
            studio.page.tabs["deform"]["view"]["surfaces"]["mesh"]["data"]
        )
    )
    np.testing.assert_allclose(centre + scale * shown, made.mesh.vertices, atol=1e-6 * scale)


def test_a_drag_is_shown_but_no_step(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    rest, undo = studio.page.positions["mesh"].copy(), studio.page.last["undo"]
    for z in (1.0, 2.0, 40.0):
        move = {"translation": [0.0, 0.0, z]}
        studio.live("deform", "move_handle", name="handle 1", move=move)
    assert not studio.page.exact["mesh"]
    assert np.abs(studio.page.positions["mesh"] - rest).max() > 0.01
    assert studio.page.last["undo"] == undo
    studio.receive("drop")
    np.testing.assert_array_equal(studio.page.positions["mesh"], rest)


def test_undo_and_redo_go_all_the_way(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    last = studio.page.tabs["deform"]["state"]
    steps = 0
    while studio.page.last["undo"]:
        assert studio.receive("undo")["kind"] == "done"
        steps += 1
    assert studio.page.last["meshes"] == []
    assert studio.receive("undo")["kind"] == "refused"
    for _ in range(steps):
        assert studio.receive("redo")["kind"] == "done"
    assert studio.page.tabs["deform"]["state"] == last
    assert studio.page.last["redo"] is None


def test_an_answer_that_was_lost_is_given_again_without_doing_it_twice(
    studio: Studio, tmp_path: Path
) -> None:
    message = Message(
        {
            "kind": "do",
            "id": "page-1",
            "tab": "document",
            "action": "keep",
            "arguments": {"tab": "combine", "what": "weld a"},
        }
    )
    opened(studio, tmp_path, bumper(2000))
    for _ in range(2):
        studio.on_engine(lambda: studio.session.receive(studio.page, message))
    assert len(studio.page.last["meshes"]) == 2


def test_what_was_saved_before_a_kill_is_not_done_again(tmp_path: Path) -> None:
    studio = Studio(tmp_path / "0")
    change = {"tab": "quad", "action": "change"}
    changes = [{**change, "arguments": {"options": {"seed": seed}}} for seed in (5, 5, 6)]
    asked = [*(("do", header) for header in changes), ("undo", {}), ("redo", {})]
    messages = [Message({"kind": kind, "id": f"p-{n}", **h}) for n, (kind, h) in enumerate(asked)]
    for number, message in enumerate(messages, 1):
        assert told(studio, message)["kind"] == "done"
        before, session = known(studio), studio.page.last["session"]
        shutil.copytree(tmp_path / str(number - 1), tmp_path / str(number))  # as a kill leaves it
        studio.close()
        studio = Studio(tmp_path / str(number))
        studio.receive("hello", session=session)
        answers = [told(studio, again)["kind"] for again in messages[:number]]
        assert (answers, known(studio)) == (["done"] * number, before)
    studio.close()


def told(studio: Studio, message: Message) -> dict[str, Any]:
    """What a message is answered with."""
    studio.on_engine(lambda: studio.session.receive(studio.page, message))
    while (header := studio.page.told.get(timeout=60)[0]).get("id") != message.header["id"]:
        pass
    return header


def known(studio: Studio) -> dict[str, Any]:
    """What a page knows of what was done."""
    labels = {name: studio.page.last[name] for name in ("undo", "redo")}
    history = studio.on_engine(lambda: studio.session.desk.kept.history)
    steps = {"steps": len(history.steps), "position": history.position}
    return labels | steps | {"seed": studio.page.tabs["quad"]["state"]["recipe"]["seed"]}


@pytest.mark.parametrize(
    "header",
    [
        {"kind": "nothing"},
        {"kind": "do"},
        {"kind": "do", "tab": "deform"},
        {"kind": "do", "tab": ["deform"], "action": "add"},
        {"kind": "do", "tab": "deform", "action": {"a": 1}},
        {"kind": "do", "tab": "deform", "action": "add", "arguments": []},
        {"kind": "do", "tab": "deform", "action": "add", "arguments": {"kind": "nothing"}},
        {"kind": "do", "tab": "deform", "action": "select_vertices", "arguments": {"vertices": -1}},
        {"kind": "do", "tab": "document", "action": "example", "arguments": {"name": "../x"}},
        {"kind": "do", "tab": "document", "action": "restore", "arguments": {"session": "../x"}},
        {"kind": "do", "tab": "document", "action": ["restore"]},
        {"kind": "grab", "tab": "deform", "arguments": {"name": 3}},
        {"kind": "grab", "tab": {}},
        {"kind": "undo"},
        {"kind": "redo"},
    ],
)
def test_what_cannot_be_done_is_refused_in_words(studio: Studio, header: dict[str, Any]) -> None:
    told = studio.receive(**header)
    if header["kind"] == "grab" and isinstance(header["tab"], str):
        assert told["kind"] == "done"  # nothing to drag, and nothing wrong
    else:
        assert told["kind"] == "refused"
        assert len(told["message"]) > 20
        assert "Error" not in told["message"]
        assert "fault of ours" not in told["message"]


def test_a_session_that_was_killed_is_offered_with_its_drag(tmp_path: Path) -> None:
    first = Studio(tmp_path / "sessions")
    bending(first, tmp_path)
    ident = first.page.last["session"]
    move = {"translation": [0.0, 0.0, 12.0]}
    first.live("deform", "move_handle", name="handle 1", move=move)
    first.on_engine(lambda: first.session.desk.kept._journal.flush())
    first.on_engine(lambda: first.session._works.close())
    second = Studio(tmp_path / "copy")
    second.close()
    first.on_engine(lambda: first.session.desk.kept.close())
    first.close(kill=True)
    again = Studio(tmp_path / "sessions")
    try:
        assert [offer["session"] for offer in again.page.last["offers"]] == [ident]
        assert again.do("document", "restore", session=ident)["kind"] == "done"
        (handle,) = again.page.tabs["deform"]["state"]["recipe"]["handles"]
        assert handle["move"]["translation"] == [0.0, 0.0, 12.0]
        assert again.page.last["undo"] == "move handle"
    finally:
        again.close()


@pytest.mark.parametrize("tab", ["combine", "register", "deform", "quad", "design"])
def test_every_example_opens_in_its_tab(studio: Studio, tab: str) -> None:
    for example in studio.page.last["examples"]:
        if example["tab"] == tab:
            assert studio.do("document", "example", name=example["name"])["kind"] == "done"
            while (ended := studio.page.until("ended"))["job"] == "engine":
                pass
            assert ended["outcome"] == "done", ended
            assert studio.page.last["tab"] == tab
            assert "problem" not in studio.page.tabs[tab]["view"]
            assert studio.page.tabs[tab]["view"]["exports"]
            studio.do("document", "new")


def test_an_example_is_made_beside_the_engine_and_can_be_cancelled(studio: Studio) -> None:
    studio.do("document", "example", name="heads")
    assert studio.do("document", "show", name="quad")["kind"] == "done"  # which goes on
    ((job, tab, title),) = ((one["job"], one["tab"], one["title"]) for one in works(studio))
    assert (tab, title) == ("combine", "Open Woman to goblin")
    studio.receive("cancel", job=job)
    assert studio.page.until("ended")["outcome"] == "cancelled"
    assert (works(studio), studio.page.last["meshes"]) == ([], [])
    assert studio.page.last["undo"] is None


def works(studio: Studio) -> list[dict[str, Any]]:
    """What goes on."""
    return studio.on_engine(lambda: studio.session._works.listed)


def test_an_example_is_opened_in_one_step_and_always_the_same(studio: Studio) -> None:
    surfaces = []
    for _ in range(2):
        studio.example("animal and man")
        surfaces.append([one["surface"] for one in studio.page.last["meshes"]])
        assert studio.page.last["undo"] == "open animal and man"
        studio.receive("undo")
        assert studio.page.last["meshes"] == []
    assert surfaces[0] == surfaces[1]
    assert len(surfaces[0]) == 2


def test_closing_a_mesh_empties_the_tabs_that_had_it(studio: Studio) -> None:
    studio.example("plate")
    studio.do("document", "remove", mesh="m1")
    assert studio.page.last["meshes"] == []
    assert studio.page.tabs["quad"]["state"]["mesh"] is None
    studio.receive("undo")
    assert studio.page.tabs["quad"]["state"]["mesh"] == "m1"


def test_a_result_for_a_mesh_that_was_closed_is_left_out(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Any] = []
    studio.example("plate")
    with monkeypatch.context() as patched:
        patched.setattr(studio.session._works, "start", lambda *started: begun.append(started))
        studio.do("quad", "run")
    studio.do("document", "remove", mesh="m1")
    studio.example("animal")
    before = studio.page.tabs["quad"]["state"]
    assert before["mesh"] == "m1"  # again, but another one
    ((_, work, ended, _),) = begun
    studio.on_engine(lambda: ended(Done({"mesh": work.request["mesh"], "result": "0" * 32})))
    assert studio.page.tabs["quad"]["state"] == before


def test_what_was_made_is_opened_as_a_mesh(studio: Studio) -> None:
    keep = {"tab": "document", "action": "keep", "arguments": {"tab": "quad", "what": "quads"}}
    studio.example("plate")
    assert "made" in studio.receive("do", **keep)["message"]
    studio.do("quad", "change", options={"quads": 300})
    studio.do("quad", "run")
    while studio.page.until("ended")["job"] == "engine":
        pass
    assert studio.receive("do", **keep)["kind"] == "done"
    quads = studio.page.last["meshes"][1]
    assert quads["name"] == "plate quads"
    assert quads["faces"] == studio.page.tabs["quad"]["state"]["result"]["quality"]["quads"]


def test_a_mesh_is_there_when_another_tab_comes_to_the_front(studio: Studio) -> None:
    studio.example("plate")
    studio.do("document", "show", name="deform")
    assert studio.page.tabs["deform"]["state"]["mesh"] == "m1"


def test_an_export_is_the_recipe_run_by_the_library(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    studio.do("deform", "move_handle", name="handle 1", move={"translation": [0.0, 0.0, 30.0]})
    known = {one["format"] for one in studio.page.tabs["deform"]["view"]["exports"]}
    assert "recipe" in known
    answer = studio.on_engine(
        lambda: studio.session.export({"tab": "deform", "format": "recipe", "options": {}})
    )
    ended = studio.page.until("ended")
    assert ended["job"] == answer["job"]
    assert ended["outcome"] == "done", ended
    assert ended["file"] == answer["file"]
    studio.receive("hello", session=None)  # as a page does that was away when it ended
    assert studio.page.last["exported"] == [ended]
    path, name = studio.session.download(ended["file"])  # type: ignore[misc]
    studio.receive("hello", session=None)
    assert studio.page.last["exported"] == []
    recipe = hk.DeformRecipe.read(path)
    assert name.endswith(".json")
    document = studio.on_engine(lambda: studio.session.desk.now)
    wanted = document.deform.recipe.model_dump(exclude_defaults=True)
    assert recipe.model_dump(exclude_defaults=True, exclude={"schema_file"}) == wanted


def test_a_dropped_recipe_goes_to_its_tab(studio: Studio, tmp_path: Path) -> None:
    studio.example("bumper")
    studio.do("document", "show", name="quad")
    recipe = studio.on_engine(lambda: studio.session.desk.now.deform.recipe)
    path = tmp_path / "recipe.json"
    recipe.model_copy(update={"handles": ()}).write(path)
    assert studio.session.uploaded(path, "recipe.json") == {"recipe": "deform"}
    assert studio.page.last["tab"] == "deform"
    assert studio.page.tabs["deform"]["state"]["recipe"]["handles"] == []
