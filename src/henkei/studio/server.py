"""The studio's server: the page, its data, uploads, downloads, and a WebSocket for the rest.

Nothing heavy is imported before the page was answered; then the session is opened, on the engine's
thread.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import re
import socket
import tempfile
import unicodedata
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future
from contextlib import ExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from henkei.errors import HenkeiError, InvalidInput
from henkei.studio.engine import Engine, Worker
from henkei.studio.security import Access, Guard, SecureHeaders, page

if TYPE_CHECKING:
    import uvicorn

    from henkei.studio.link import Session

PORT, PORTS = 8642, 20  # the first that is tried, and how many
LARGEST_UPLOAD = 10**9  # bytes
LARGEST_MESSAGE = 64 << 20  # bytes, on the WebSocket
_LARGEST_REQUEST = 1 << 20  # bytes, of JSON
_AT_ONCE = 1 << 20  # bytes of an upload that are written together
_HEAD_START = 1.0  # seconds for a page to be asked for, before the session takes processor time
_PATIENCE = 3  # seconds that open connections get when the studio ends, and then the session
_UNREACHABLE = 60_000  # milliseconds until the system gives up a page that takes nothing
_BLOB = re.compile(r"[0-9a-f]{32}")
_SUFFIX = re.compile(r"\.[a-z0-9]{1,10}")
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Settings:
    """How a studio is served.

    access : who may talk to it, and the address it is bound to.
    page : the folder of the bundled page.
    without_page : what is said where that is missing.
    largest_upload : bytes.
    """

    access: Access
    page: Path | None = None
    without_page: str = "The page of the studio was not built."
    largest_upload: int = LARGEST_UPLOAD


class _Studio:
    """What is answered at each address."""

    def __init__(self, engine: Engine, settings: Settings) -> None:
        self._engine, self._settings = engine, settings
        self._uploads = Worker("upload")

    def routes(self) -> list[BaseRoute]:
        """The addresses; all but the files of the page want the token."""
        without_token = self._settings.access.without_token
        guarded = [Middleware(Guard, refused=without_token)]
        front = [Middleware(Guard, refused=without_token, script="studio.js")]
        routes: list[BaseRoute] = [
            Route("/", self.page, middleware=front),
            Route("/data/{blob}", self.data, middleware=guarded),
            Route("/upload", self.upload, methods=["POST"], middleware=guarded),
            Route("/export", self.export, methods=["POST"], middleware=guarded),
            Route("/file/{ident}", self.file, middleware=guarded),
            WebSocketRoute("/ws", self.link, middleware=guarded),
        ]
        if self._settings.page is not None:
            routes.append(Mount("/", StaticFiles(directory=self._settings.page)))
        return routes

    @asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        """The session is opened once somebody has the page, or nobody comes, and closed last."""
        waiting = asyncio.get_running_loop().call_later(_HEAD_START, self._engine.start)
        self._uploads.start()
        yield
        waiting.cancel()
        await self._engine.close(_PATIENCE)
        self._uploads.end()

    async def page(self, request: Request) -> Response:
        """The studio."""
        then = BackgroundTask(self._engine.start)
        if self._settings.page is None:
            text = page("henkei studio", self._settings.without_page)
            return HTMLResponse(text, background=then)
        return FileResponse(self._settings.page / "index.html", background=then)

    async def data(self, request: Request) -> Response:
        """A blob; what a name stands for never changes."""
        blob = request.path_params["blob"]
        path = (await self._session()).data(blob) if _BLOB.fullmatch(blob) else None
        if path is None:
            raise HTTPException(404, "the studio has no such data (any more)")
        headers = {"etag": f'"{blob}"', "cache-control": "private, max-age=31536000, immutable"}
        if headers["etag"] in request.headers.get("if-none-match", ""):
            return Response(status_code=304, headers=headers)
        return FileResponse(path, headers=headers, media_type="application/octet-stream")

    async def upload(self, request: Request) -> Response:
        """A file, received whole before the session looks at it."""
        name = display_name(request.query_params.get("name", ""))
        session = await self._session()
        received = await self._received(request, name)
        try:
            answer = await self._uploads.run(session.uploaded, received, name)
        except HenkeiError as error:
            answer = {"message": str(error)}
        finally:
            received.unlink(missing_ok=True)
        return JSONResponse(answer)

    async def _received(self, request: Request, name: str) -> Path:
        """A temporary file with the body of a request."""
        limit = self._settings.largest_upload
        too_large = HTTPException(
            413,
            f"{name} is larger than {limit / 1e6:g} MB, the most that this studio takes; "
            "start it with --largest-upload to have it take more",
        )
        if int(request.headers.get("content-length", 0)) > limit:
            raise too_large
        suffix = PurePosixPath(name).suffix.lower()
        try:
            descriptor, path = tempfile.mkstemp(suffix if _SUFFIX.fullmatch(suffix) else "")
            with ExitStack() as on_error, os.fdopen(descriptor, "wb") as stream:
                on_error.callback(Path(path).unlink, missing_ok=True)
                size, waiting = 0, bytearray()
                async for chunk in request.stream():
                    size += len(chunk)
                    if size > limit:
                        raise too_large
                    waiting += chunk
                    if len(waiting) >= _AT_ONCE:
                        await asyncio.to_thread(stream.write, bytes(waiting))
                        waiting.clear()
                stream.write(waiting)
                stream.flush()
                on_error.pop_all()
            return Path(path)
        except OSError as error:
            raise HTTPException(507, f"{name} cannot be kept: {error.strerror}") from error

    async def export(self, request: Request) -> Response:
        """Begin to write a file."""
        body = bytearray()
        async for chunk in request.stream():
            body += chunk
            if len(body) > _LARGEST_REQUEST:
                raise HTTPException(413, "what is asked for is too long")
        try:
            asked = json.loads(body)
        except (ValueError, RecursionError) as error:
            raise HTTPException(400, f"what is asked for is no JSON: {error}") from None
        if not isinstance(asked, dict):
            raise HTTPException(400, "what is asked for must be a JSON object")
        return JSONResponse(await self._of_session("export", asked))

    async def file(self, request: Request) -> Response:
        """A file that was written, to be saved by the browser."""
        found = await self._of_session("download", request.path_params["ident"])
        if found is None:
            raise HTTPException(404, "this file is not there (any more); export it again")
        path, name = found
        headers = {"cache-control": "no-store"}
        media = "application/octet-stream"
        return FileResponse(path, headers=headers, media_type=media, filename=display_name(name))

    async def link(self, websocket: WebSocket) -> None:
        """The page's connection."""
        await websocket.accept()
        try:
            session = await self._session()
        except HenkeiError as error:
            await websocket.close(1011, str(error)[:40])
            return
        from henkei.studio.link import Link

        await Link(websocket, session, self._engine.submit).run()

    async def _session(self) -> Session:
        self._engine.start()
        return await asyncio.shield(asyncio.wrap_future(self._engine.session))

    async def _of_session(self, method: str, argument: Any) -> Any:
        """What a method of the session says, on the engine's thread."""
        try:
            session = await self._session()
            return await self._engine.run(getattr(session, method), argument)
        except HenkeiError as error:
            raise HTTPException(400, str(error)) from error


def app(engine: Engine, settings: Settings) -> Starlette:
    """The studio as an ASGI application; the engine starts and ends with it."""
    studio = _Studio(engine, settings)
    return Starlette(
        routes=studio.routes(),
        middleware=[
            Middleware(SecureHeaders, origins=settings.access.origins),
            Middleware(Guard, refused=settings.access.misplaced),
        ],
        exception_handlers={HTTPException: _told, ClientDisconnect: _gone, Exception: _failed},
        lifespan=studio.lifespan,
    )


def server(application: Starlette) -> uvicorn.Server:
    """The server of an application, to be run on sockets."""
    import uvicorn

    logging.getLogger("uvicorn.error").addFilter(_is_told)
    config = uvicorn.Config(
        application,
        loop="asyncio",
        http="h11",
        ws="websockets-sansio",
        ws_max_size=LARGEST_MESSAGE,
        ws_per_message_deflate=False,
        ws_ping_timeout=60.0,
        lifespan="on",
        log_config=None,
        log_level="error",
        access_log=False,
        proxy_headers=False,
        server_header=False,
        timeout_graceful_shutdown=_PATIENCE,
    )
    return uvicorn.Server(config)


def listening(host: str, port: int | None) -> socket.socket:
    """A socket that listens; without a port, on the first free one from :data:`PORT` on.

    Raises
    ------
    InvalidInput : the address is not this machine's, or the ports are taken.
    """
    ports = range(PORT, PORT + PORTS) if port is None else (port,)
    host = host.strip("[]")
    try:
        options = socket.getaddrinfo(host, ports[0], type=socket.SOCK_STREAM)
    except (OSError, UnicodeError, OverflowError) as error:
        raise InvalidInput(f"--host {host}: this is no address of this machine ({error})") from None
    family, kind, protocol, _, address = options[0]
    for number in ports:
        # asyncio sends small messages at once only where the protocol is told
        found = socket.socket(family, kind, protocol)
        try:
            _prepare(found)
            found.bind((address[0], number, *address[2:]))
            found.listen(128)
        except (OSError, OverflowError) as error:
            found.close()
            reason = error
        else:
            return found
    which = f"port {ports[0]}" if len(ports) == 1 else f"ports {ports[0]} to {ports[-1]}"
    raise InvalidInput(f"cannot listen at {which} of {host} ({reason}); choose another --port")


def _prepare(listener: socket.socket) -> None:
    """Take a port over from a studio that has just ended, and let go of pages that hang."""
    if hasattr(socket, "SO_EXCLUSIVEADDRUSE"):  # where SO_REUSEADDR would share the port
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    else:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if hasattr(socket, "TCP_USER_TIMEOUT"):
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNREACHABLE)


def url(listener: socket.socket, access: Access) -> str:
    """Where the page is, with its token."""
    host, port = access.host.strip("[]"), listener.getsockname()[1]
    if host in ("0.0.0.0", "::", ""):
        host = socket.gethostname()
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/?token={access.token}"


def serve(
    engine: Engine, settings: Settings, port: int | None, ready: Callable[[str], None]
) -> None:
    """Serve until the person or the system stops it.

    Parameters
    ----------
    port : see :func:`listening`.
    ready : told where the page is, as soon as a browser may ask for it.

    Raises
    ------
    InvalidInput : there is no such address, or no free port.
    HenkeiError : the session could not be opened.
    """
    with listening(settings.access.host, port) as listener:
        ready(url(listener, settings.access))
        running = server(app(engine, settings))

        def opened(session: Future[Session]) -> None:
            running.should_exit = running.should_exit or session.exception() is not None

        engine.session.add_done_callback(opened)
        with suppress(KeyboardInterrupt):
            running.run(sockets=[listener])
    if engine.session.done():
        engine.session.result()


def display_name(name: str) -> str:
    """The last part of a file's name, without what might mislead a person or a system."""
    last = re.split(r"[/\\]", name)[-1]
    plain = "".join(c for c in last if unicodedata.category(c)[0] not in "CZ" or c == " ")
    plain = re.sub(r'[<>:"|?*]', "_", plain).strip(" .")
    return (plain if len(plain) <= 100 else plain[:60] + plain[-40:]) or "mesh"


def _is_told(record: logging.LogRecord) -> bool:
    """Whether a person is to see it: uvicorn takes every WebSocket that is refused for a fault."""
    return "without completing handshake" not in record.getMessage()


async def _told(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return JSONResponse({"message": error.detail}, error.status_code, error.headers)


async def _gone(request: Request, error: Exception) -> Response:
    return Response(status_code=400)


async def _failed(request: Request, error: Exception) -> Response:
    return JSONResponse({"message": "this failed inside henkei; try again, or another way"}, 500)
