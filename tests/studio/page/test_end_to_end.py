"""The studio as a whole: killed and started again, seen by two pages, by strangers, by a proxy."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import numpy as np
import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect as connect_async
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import henkei as hk
from driven import Driven, RunningStudio, eventually, studio_running
from henkei.recipes.deform import DeformRecipe
from henkei.shapes import random_disk
from served import plain_client

if TYPE_CHECKING:
    from playwright.sync_api import Browser

DISK = random_disk(0, 400)
MIDDLE = np.flatnonzero(np.linalg.norm(DISK.vertices[:, :2], axis=1) < 0.2)
NEAR = 3e-6  # of positions that are drawn in 32 bits, of a disk of radius 1
AWAY = "ERR_CONNECTION_REFUSED|WebSocket|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE"
LOST = 2.0  # seconds of work that may be
PAUSE = 0.02  # seconds between moves of the mouse
RECIPE = {
    "fixed": [{"name": "rim", "region": {"vertices": DISK.topology.boundary_loops[0].tolist()}}],
    "handles": [{"name": "middle", "region": {"vertices": MIDDLE.tolist()}}],
}
GIZMO = "window.henkei.stage.viewports[0].gizmo"
NOTE_SENT = """
window.sent = [];
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (data) {
  const length = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const {move} = header.arguments ?? {};
  if (header.kind === "live" && move) window.sent.push([Date.now() / 1000, move.translation]);
  return send.call(this, data);
};
"""
TRY_ALL = """async ({base, token, blob}) => {
  const tries = {
    page: [`${base}/?token=${token}`, {}],
    data: [`${base}/data/${blob}?token=${token}`, {}],
    header: [`${base}/data/${blob}`, {headers: {"X-Token": token}}],
    upload: [`${base}/upload?name=a.obj&token=${token}`, {method: "POST", body: "v 0 0 0"}],
    blind: [`${base}/upload?name=b.obj&token=${token}`,
      {method: "POST", mode: "no-cors", body: "v 0 0 0"}],
    export: [`${base}/export?token=${token}`, {method: "POST", body: "{}"}],
    file: [`${base}/file/j1?token=${token}`, {}],
  };
  const told = {};
  for (const [name, [address, how]] of Object.entries(tries)) {
    try {
      const answer = await fetch(address, how);
      told[name] = answer.type === "opaque" ? "opaque" : await answer.text();
    } catch (error) { told[name] = error.name; }
  }
  const socket = new WebSocket(`${base.replace("http", "ws")}/ws?token=${token}`);
  told.socket = await new Promise((settle) => {
    socket.onopen = () => settle("open");
    socket.onclose = ({code, wasClean}) => settle([code, wasClean]);
  });
  return told;
}"""


def opened(browser: Browser, studio: RunningStudio, address: str | None = None) -> Driven:
    """A page by itself, as of another person, that notes what it sends in drags."""
    context = browser.new_context(viewport={"width": 1000, "height": 700})
    context.set_default_timeout(20_000)
    context.add_init_script(NOTE_SENT)
    page = Driven(context.new_page(), studio)
    page.forgive(AWAY)
    page.page.goto(address or studio.address)
    page.settle()
    page.draw(False)
    return page


def begin(page: Driven, folder: Path) -> None:
    """A disk whose middle can be dragged."""
    page.open_tab("Deform")
    page.open_mesh(DISK, folder / "disk.obj")
    page.page.evaluate("(recipe) => window.henkei.studio.do('deform', 'load', {recipe})", RECIPE)
    page.until(lambda: page.tab("deform")["view"].get("parts"), "the recipe")
    page.settle()
    choose(page)


def choose(page: Driven) -> None:
    """Choose the handle, which gets a gizmo."""
    page.click_vertex("mesh", int(MIDDLE[0]))
    page.until(lambda: page.page.evaluate(f"() => {GIZMO}.place !== null"), "the gizmo")


def arrow(page: Driven) -> tuple[float, float]:
    """A pixel of the arrow along x, by looking for it."""
    middle = np.mean([page.project("mesh", int(vertex)) for vertex in MIDDLE], axis=0)
    for radius in range(40, 80, 8):
        for angle in np.linspace(0, 2 * np.pi, 16, endpoint=False).tolist():
            x, y = middle + radius * np.array([np.cos(angle), np.sin(angle)])
            page.page.mouse.move(x, y)
            if page.page.evaluate(f"() => {GIZMO}.controls.get('translate')?.axis") == "X":
                return float(x), float(y)
    raise AssertionError("there is no arrow")


def drag(page: Driven, start: tuple[float, float], seconds: float) -> tuple[float, float]:
    """Go to and fro with the mouse; where it is at the end."""
    x, y = start
    steps = int(seconds / PAUSE)
    for step in range(1, steps + 1):
        x = start[0] + 60 * np.sin(1.7 * np.pi * step / steps)
        page.page.mouse.move(x, y)
        time.sleep(PAUSE)
    return x, y


def moved(recipe: dict[str, Any]) -> Any:
    """How far the handle is moved in a recipe."""
    return recipe["handles"][0]["move"]["translation"]


def with_move(recipe: dict[str, Any], translation: Any) -> dict[str, Any]:
    """A recipe with the handle moved otherwise."""
    handle = recipe["handles"][0]
    move = {**handle["move"], "translation": translation}
    return {**recipe, "handles": [{**handle, "move": move}]}


def assert_drawn(page: Driven, recipe: dict[str, Any]) -> None:
    """What is drawn comes to be what a recipe makes of the disk."""
    wanted = hk.deform_by_recipe(DISK, recipe).mesh.vertices

    def same() -> bool:
        return bool(np.abs(page.positions("mesh") - wanted).max() < NEAR)

    page.until(same, "the surface of the recipe")


def changed(page: Driven, about: str) -> dict[str, Any]:
    """The recipe after one more step."""
    page.page.evaluate(
        "(about) => window.henkei.studio.do('deform', 'change', {recipe: {about}})", about
    )
    page.until(lambda: page.recipe("deform")["about"] == about, "a change")
    return page.recipe("deform")


def gone(page: Driven) -> None:
    """The page is closed; nothing was wrong with it."""
    page.page.context.close()
    assert not page.errors


def goes_to(page: Driven, keys: str, recipe: dict[str, Any]) -> None:
    """Press keys, after which a recipe is there."""
    page.press(keys)
    page.until(lambda: page.recipe("deform") == recipe, f"what {keys} should give")


def test_killed_in_the_middle_of_a_drag(browser: Browser, tmp_path: Path) -> None:
    folder = tmp_path / "studio"
    with studio_running(folder) as first:
        page = opened(browser, first)
        begin(page, tmp_path)
        steps = [page.recipe("deform"), changed(page, "first"), changed(page, "second")]
        start = arrow(page)
        page.page.mouse.down()
        hand = drag(page, start, LOST + 0.5)
        killed = time.time()
        first.kill()
    sent = page.page.evaluate("() => window.sent")
    assert sent[0][0] < killed - LOST
    page.page.get_by_text("The studio's server is away").wait_for()

    with studio_running(folder, port=first.port) as second:
        page.until(lambda: moved(page.recipe("deform")) != moved(steps[-1]), "the drag as it was")
        kept = moved(page.recipe("deform"))
        moves = [move for _, move in sent]
        lost = sent[moves.index(kept) + 1 :]
        assert all(at > killed - LOST for at, _ in lost)
        assert_drawn(page, with_move(steps[-1], moves[-1]))  # where the hand is
        other = opened(browser, second)
        assert other.state["session"] == page.state["session"]
        assert_drawn(other, with_move(steps[-1], kept))

        drag(page, hand, 0.3)
        page.page.mouse.up()
        page.settle()
        steps += [with_move(steps[-1], kept), page.recipe("deform")]
        assert moved(steps[-1]) not in moves
        for step in steps[-2::-1]:
            goes_to(page, "Control+z", step)
            assert_drawn(page, step)
        for step in steps[1:]:
            goes_to(page, "Control+Shift+Z", step)
        assert page.state["redo"] is None
        assert_drawn(page, steps[-1])
        assert_drawn(other, steps[-1])
        gone(page)
        gone(other)
        second.kill()

    with studio_running(folder) as third:
        page = opened(browser, third)
        earlier = page.page.get_by_role("region", name="Earlier work")
        assert "disk.obj" in earlier.inner_text()
        earlier.get_by_role("button", name="Restore").click()
        page.until(lambda: page.state["meshes"], "the session")
        page.settle()
        assert page.recipe("deform") == steps[-1]
        assert_drawn(page, steps[-1])
        goes_to(page, "Control+z", steps[-2])
        gone(page)


def test_two_pages_see_the_same(browser: Browser, page: Driven, tmp_path: Path) -> None:
    page.draw(False)
    begin(page, tmp_path)
    other = opened(browser, page.studio)
    before = page.recipe("deform")
    assert other.recipe("deform") == before

    def alike() -> bool:
        return bool(np.abs(other.positions("mesh") - page.positions("mesh")).max() < NEAR)

    start = arrow(page)
    page.page.mouse.down()
    drag(page, start, 0.4)
    assert np.abs(page.positions("mesh") - DISK.vertices).max() > 0.01
    other.until(alike, "the drag on the other page")
    page.page.mouse.up()
    page.settle()
    after = page.recipe("deform")
    other.until(lambda: other.recipe("deform") == after, "the end of the drag")
    assert_drawn(other, after)
    goes_to(other, "Control+z", before)
    page.until(lambda: page.recipe("deform") == before, "what the other page undid")
    assert_drawn(page, before)
    gone(other)


@contextmanager
def serving(folder: Path) -> Iterator[str]:
    """A website of a stranger; its address."""
    files = partial(Quiet, directory=str(folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), files) as website:
        thread = threading.Thread(target=website.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{website.server_port}"
        finally:
            website.shutdown()
            thread.join()


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        """Say nothing."""


def test_a_page_from_elsewhere_gets_nothing_even_with_the_token(
    browser: Browser, studio: RunningStudio, page: Driven, tmp_path: Path
) -> None:
    page.draw(False)
    page.open_mesh(DISK, tmp_path / "disk.obj")
    blob = page.state["meshes"][0]["surface"]
    base, token = studio.address.split("/?token=")
    (tmp_path / "index.html").write_text("<link rel='icon' href='data:,'>")
    with serving(tmp_path) as elsewhere:
        context = browser.new_context()
        foreign = context.new_page()
        network = context.new_cdp_session(foreign)
        answers: list[int] = []
        network.on(
            "Network.responseReceivedExtraInfo", lambda one: answers.append(one["statusCode"])
        )
        console: list[str] = []
        foreign.on("console", lambda said: console.append(said.text))
        foreign.goto(elsewhere)
        network.send("Network.enable")
        told = foreign.evaluate(TRY_ALL, {"base": base, "token": token, "blob": blob})
        context.close()
    assert told.pop("socket") == [1006, False]
    assert any("WebSocket" in text and "403" in text for text in console)
    assert len(told) == len(answers)
    assert set(answers) == {403}
    assert set(told.values()) == {"TypeError"}  # what fetch says where nothing may be read
    page.forgive("404")  # there is no file to be had
    own = page.page.evaluate(TRY_ALL, {"base": base, "token": token, "blob": blob})
    assert own["socket"] == "open"
    assert "henkei" in own["page"]
    page.until(lambda: page.page.evaluate("() => !window.henkei.studio.working"))
    assert [one["name"] for one in page.state["meshes"]] == ["disk.obj"]


@pytest.mark.parametrize("given", [{}, {"X-Token": "wrong"}])
def test_without_the_token_there_is_nothing(studio: RunningStudio, given: dict[str, str]) -> None:
    base = studio.address.partition("/?")[0]
    with plain_client(base_url=base, headers=given) as stranger:
        for method, path in (
            *(("GET", "/"), ("GET", f"/data/{'0' * 32}"), ("GET", "/file/j1")),
            *(("POST", "/upload?name=a.obj"), ("POST", "/export")),
        ):
            answer = stranger.request(method, path, content=b"" if method == "GET" else b"{}")
            assert answer.status_code == 403
            assert "token" in answer.json()["message"]
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(f"{base.replace('http', 'ws')}/ws", additional_headers=given, proxy=None),
    ):
        pass
    assert refused.value.response.status_code == 403


class Proxy:
    """Passes what comes below a prefix on to a studio, as Jupyter's proxy and others do."""

    prefix = "/user/x/proxy/8642"

    def __init__(self, upstream: str) -> None:
        self._upstream, self._http = upstream, httpx.AsyncClient(trust_env=False, timeout=60)

    def application(self) -> Starlette:
        path = self.prefix + "/{path:path}"
        passed = Route(path, self.passed, methods=["GET", "POST"])
        routes = [WebSocketRoute(path, self.linked), passed]
        return Starlette(routes=routes, lifespan=self.open)

    @asynccontextmanager
    async def open(self, _: Starlette) -> AsyncIterator[None]:
        async with self._http:
            yield

    async def passed(self, request: Request) -> Response:
        answer = await self._http.request(
            request.method,
            f"{self._upstream}/{request.path_params['path']}",
            params=request.query_params,
            headers=_onward(request.headers),
            content=await request.body(),
        )
        return Response(answer.content, answer.status_code, _onward(answer.headers))

    async def linked(self, page: WebSocket) -> None:
        address = f"{self._upstream.replace('http', 'ws')}/{page.path_params['path']}"
        origin = {"Origin": page.headers["origin"]}
        async with connect_async(
            f"{address}?{page.query_params}", additional_headers=origin, max_size=None, proxy=None
        ) as studio:
            await page.accept()

            async def inward() -> None:
                while True:
                    await studio.send(await page.receive_bytes())

            async def outward() -> None:
                async for data in studio:
                    await page.send_bytes(data)

            ways = [asyncio.ensure_future(inward()), asyncio.ensure_future(outward())]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)


def _onward(headers: Any) -> dict[str, str]:
    """Headers without those of one connection."""
    own = {"host", "connection", "content-length", "transfer-encoding", "content-encoding"}
    return {name: value for name, value in headers.items() if name.lower() not in own}


@contextmanager
def running(application: Starlette, port: int) -> Iterator[None]:
    config = uvicorn.Config(application, port=port, log_config=None, ws_max_size=1 << 26)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        eventually(lambda: server.started)
        yield
    finally:
        server.should_exit = True
        thread.join()


def test_behind_the_prefix_of_a_proxy(browser: Browser, tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    hub = f"http://localhost:{port}"
    with studio_running(tmp_path / "studio", "--allow-origin", hub) as studio:
        base, _, token = studio.address.partition("/?token=")
        proxy = Proxy(base)
        with running(proxy.application(), port):
            page = opened(browser, studio, f"{hub}{proxy.prefix}/?token={token}")
            begin(page, tmp_path)
            start = arrow(page)
            page.page.mouse.down()
            drag(page, start, 0.3)
            page.page.mouse.up()
            page.settle()
            assert moved(page.recipe("deform")) != [0, 0, 0]
            assert_drawn(page, page.recipe("deform"))
            page.button("Export").click()
            with page.page.expect_download() as download:
                page.page.get_by_role("menuitem", name="Recipe", exact=True).click()
            download.value.save_as(tmp_path / "recipe.json")
            written = DeformRecipe.read(tmp_path / "recipe.json")
            assert written.handles == DeformRecipe.of(page.recipe("deform")).handles
            page.forgive("403")  # without its token, which it gets back by itself
            page.page.reload()
            page.settle()
            assert page.page.url.startswith(f"{hub}{proxy.prefix}/")
            assert_drawn(page, page.recipe("deform"))
            gone(page)
