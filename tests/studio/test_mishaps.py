"""What may go wrong around a session: nothing is lost, and no page is left without an answer."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.shapes import bumper
from henkei.studio.downloads import OLD, Downloads, clear_old
from henkei.studio.messages import Message, encode
from henkei.studio.outcomes import Done
from henkei.studio.pages import BROKEN
from henkei.studio.tabs import quad
from seated import Page, Studio, bending, opened

AT = {"translation": [0.0, 0.0, 12.0]}


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    studio = Studio(tmp_path / "sessions")
    yield studio
    studio.close()


def another(studio: Studio, **hello: Any) -> Page:
    """One more page."""
    page = Page()
    studio.on_engine(lambda: studio.session.connected(page))
    message = Message({"kind": "hello", "session": None, **hello})
    studio.on_engine(lambda: studio.session.receive(page, message))
    return page


def says(studio: Studio, client: Page, kind: str, **header: Any) -> None:
    message = Message({"kind": kind, **header})
    studio.on_engine(lambda: studio.session.receive(client, message))


def leaves(studio: Studio, page: Page) -> None:
    studio.on_engine(lambda: studio.session.disconnected(page))


def place(tabs: dict[str, Any]) -> list[float]:
    """Where the handle is."""
    (handle,) = tabs["deform"]["state"]["recipe"]["handles"]
    translation: list[float] = handle["move"]["translation"]
    return translation


@pytest.mark.parametrize(
    ("action", "arguments"),
    [
        ("show", {"name": "quad"}),
        ("rename", {"mesh": "m1", "name": "a"}),
    ],
)
def test_a_drag_does_not_become_a_step_of_something_else(
    studio: Studio, tmp_path: Path, action: str, arguments: dict[str, Any]
) -> None:
    bending(studio, tmp_path)
    studio.live("deform", "move_handle", name="handle 1", move=AT)
    studio.do("document", action, **arguments)
    studio.receive("drop")
    assert place(studio.page.tabs) == [0.0, 0.0, 0.0]


def test_a_drag_that_is_dropped_is_gone_from_all_pages(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    studio.live("deform", "move_handle", name="handle 1", move=AT)
    page = another(studio)
    assert place(page.tabs) == [0.0, 0.0, 12.0]
    studio.receive("drop")
    assert place(page.tabs) == [0.0, 0.0, 0.0]


def test_what_a_page_dragged_that_is_closed_is_a_step(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    before = studio.page.last["undo"]
    studio.live("deform", "move_handle", name="handle 1", move=AT)
    leaves(studio, studio.page)
    page = another(studio)
    assert (place(page.tabs), page.last["undo"]) == ([0.0, 0.0, 12.0], "move handle")
    says(studio, page, "undo")
    assert (place(page.tabs), page.last["undo"]) == ([0.0, 0.0, 0.0], before)
    says(studio, page, "redo")
    assert place(page.tabs) == [0.0, 0.0, 12.0]


def test_a_page_that_was_away_goes_on_with_its_drag(studio: Studio, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    before = studio.page.last["undo"]
    says(studio, studio.page, "hello", page="one")
    studio.live("deform", "move_handle", name="handle 1", move=AT)
    leaves(studio, studio.page)
    page = another(studio, page="one")
    assert page.last["undo"] == before
    says(studio, page, "drop")
    assert place(page.tabs) == [0.0, 0.0, 0.0]


def test_to_look_at_another_tab_leaves_what_was_undone(studio: Studio) -> None:
    studio.example("plate")
    studio.do("quad", "change", options={"quads": 300})
    studio.receive("undo")
    studio.do("document", "show", name="deform")
    assert studio.page.tabs["deform"]["state"]["mesh"] is None
    assert studio.page.last["redo"] == "change settings"
    studio.receive("redo")
    studio.do("document", "show", name="deform")
    assert studio.page.tabs["deform"]["state"]["mesh"] == "m1"


def test_a_view_that_fails_is_told_and_can_be_undone(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    studio.example("plate")
    shown = quad.described

    def described(state: Any, services: Any) -> Any:
        if state.recipe.quads == 7:
            raise ZeroDivisionError
        return shown(state, services) | {"figure": float("nan") * state.recipe.quads}

    monkeypatch.setattr(quad, "described", described)
    assert studio.do("quad", "change", options={"quads": 7})["kind"] == "done"
    assert studio.page.tabs["quad"]["view"]["problem"] == BROKEN
    assert another(studio).tabs["quad"]["view"]["problem"] == BROKEN
    assert studio.receive("undo")["kind"] == "done"
    assert "problem" not in studio.page.tabs["quad"]["view"]
    encode(studio.page.last)  # what is no number is left out


def test_positions_that_fail_do_not_keep_the_state_back(
    studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bending(studio, tmp_path)
    page = another(studio)

    def broken(*_: Any) -> Any:
        raise RuntimeError

    monkeypatch.setattr(studio.session._pages, "_positions", broken)
    assert studio.do("deform", "move_handle", name="handle 1", move=AT)["kind"] == "done"
    assert place(page.tabs) == [0.0, 0.0, 12.0]
    assert page.until("notice")["message"] == BROKEN


def test_a_disk_that_is_full_does_not_keep_the_state_back(
    studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    studio.do("document", "show", name="deform")
    opened(studio, tmp_path, bumper())

    def full(data: bytes) -> str:
        raise InvalidInput("the disk is full")

    monkeypatch.setattr(studio.session._services.blobs, "put", full)
    chosen = list(range(200))
    assert studio.do("deform", "select_vertices", vertices=chosen)["kind"] == "done"
    assert studio.page.tabs["deform"]["state"]["selection"] == chosen


def test_an_upload_is_answered_whatever_becomes_of_it(
    studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(**entry: Any) -> str:
        raise RuntimeError

    monkeypatch.setattr(studio.session.desk, "add", broken)
    assert "fault of ours" in opened(studio, tmp_path, bumper())["message"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"handles": [{"nme": 3}]}', "line 1: handles[0].nme: there is no key 'nme'"),
        ("[" * 100_000, "not usable as JSON"),
        ('{"quads": 300, "density": "/etc/passwd.npy"}', "reads no files"),
    ],
)
def test_a_recipe_that_is_refused_is_called_by_its_name(
    studio: Studio, tmp_path: Path, text: str, said: str
) -> None:
    path = tmp_path / "tmp1234.json"
    path.write_text(text)
    message = studio.session.uploaded(path, "mine.json")["message"]
    assert message.startswith("mine.json")
    assert said in message
    assert "tmp" not in message


def test_a_recipe_that_is_too_large_is_not_read(studio: Studio, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    with path.open("wb") as stream:
        stream.truncate(2**30)
    with pytest.raises(InvalidInput, match=r"recipe\.json: 1,024 MiB are more than the 32 MiB"):
        studio.session.uploaded(path, "recipe.json")


def test_data_that_are_not_there_are_none(studio: Studio) -> None:
    assert studio.session.data("0" * 32) is None


def test_the_same_work_is_begun_once(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    ends: list[Any] = []

    def start(*_: Any, on_end: Any, **__: Any) -> str:
        ends.append(on_end)
        return f"j{len(ends)}"

    studio.example("plate")
    monkeypatch.setattr(studio.session._works._jobs, "start", start)
    for _ in range(3):
        assert studio.do("quad", "run")["kind"] == "done"
    assert len(ends) == 1
    studio.do("quad", "change", options={"quads": 300})
    studio.do("quad", "run")
    assert len(ends) == 2
    assert [job["job"] for job in studio.on_engine(lambda: studio.session._works.listed)] == [
        "j1",
        "j2",
    ]


def begun(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> Any:
    """What is called with the outcome of work that was begun."""
    ends: list[Any] = []

    def start(*_: Any, on_end: Any, **__: Any) -> str:
        ends.append(on_end)
        return "j1"

    studio.example("plate")
    monkeypatch.setattr(studio.session._works._jobs, "start", start)
    studio.do("quad", "run")
    return ends[0]


def ended(page: Page) -> dict[str, Any]:
    """How a job ended that is not the engine's own."""
    while (told := page.until("ended"))["job"] == "engine":
        pass
    return told


def test_work_for_a_document_that_was_left_ends_on_the_page(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    end = begun(studio, monkeypatch)
    studio.do("document", "new")
    end("j1", Done({}))
    assert (ended(studio.page)["job"], studio.page.last["meshes"]) == ("j1", [])


def test_a_result_that_is_none_is_told(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    end = begun(studio, monkeypatch)
    end("j1", Done({"what": "is no result"}))
    assert ended(studio.page)["job"] == "j1"
    assert "fault of ours" in studio.page.until("notice")["message"]
    assert studio.do("quad", "change", options={"quads": 300})["kind"] == "done"


def test_downloads_that_a_killed_studio_left_go(tmp_path: Path) -> None:
    old, new = Downloads(tmp_path / "old"), Downloads(tmp_path / "new")
    for one in (old, new):
        one.place()
    then = time.time() - OLD - 1
    os.utime(tmp_path / "old", (then, then))
    clear_old(tmp_path)
    assert [one.name for one in tmp_path.iterdir()] == ["new"]
    clear_old(tmp_path / "nothing")


def test_what_no_session_needs_goes(studio: Studio, tmp_path: Path) -> None:
    session = studio.session
    blob = session._services.blobs.put_surface(hk.Mesh.from_any(bumper()))
    file = session._services.blobs.path(blob)
    os.utime(file, (0, 0))
    session._tidy()
    assert not file.exists()


def test_a_design_that_cannot_be_had_shows_its_cage_alone(studio: Studio) -> None:
    studio.example("torus")
    name = studio.page.tabs["design"]["view"]["parts"][0]["name"]
    studio.do("design", "move_pin", name=name, to=[1e300, 0.0, 0.0])
    view = studio.page.tabs["design"]["view"]
    assert "finite" in view["problem"]
    assert list(view["surfaces"]) == ["cage"]


def test_faces_that_wind_against_each_other_are_told_of(studio: Studio, tmp_path: Path) -> None:
    surface = bumper()
    faces = surface.faces.copy()
    faces[0] = faces[0, ::-1]
    turned = hk.Mesh(surface.vertices, faces)
    assert opened(studio, tmp_path, turned, "turned.obj") == {"mesh": "m1"}
    notice = studio.page.until("notice")
    assert notice["level"] == "warning"
    assert "turned.obj: faces wind against each other along " in notice["message"]
    assert "henkei.oriented(mesh)" in notice["message"]
