"""Who may talk to the studio: who has the token, from its own page, by a name of this machine.

The token alone keeps strangers out. That a browser says where a page came from (``Origin``), and
which name it asked for (``Host``), is checked as well, so that a page from elsewhere that somehow
learned the token gets nothing, whatever its name resolves to.
"""

from __future__ import annotations

import ipaddress
import os
import re
import secrets
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import NamedTuple

from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, JSONResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from henkei.errors import InvalidInput

_TOKEN = re.compile(r"[A-Za-z0-9._~-]{16,256}")
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(?::(\d{1,5}))?", re.IGNORECASE)
_PORTS = {"http": "80", "https": "443"}


class Place(NamedTuple):
    """A scheme, a host and a port, in small letters."""

    scheme: str
    host: str
    port: str

    @classmethod
    def of(cls, origin: str) -> Place | None:
        """What an ``Origin`` names, or None where it names no website (``null``)."""
        scheme, found, rest = origin.strip().lower().partition("://")
        named = _HOST.fullmatch(rest)
        if not found or scheme not in _PORTS or named is None:
            return None
        return cls(scheme, named[1], named[2] or _PORTS[scheme])

    def is_named(self, host: str) -> bool:
        """Whether a ``Host`` header means this place."""
        return Place.of(f"{self.scheme}://{host}") == self

    def __str__(self) -> str:
        port = "" if self.port == _PORTS[self.scheme] else f":{self.port}"
        return f"{self.scheme}://{self.host}{port}"


@dataclass(frozen=True)
class Access:
    """What is asked of a request.

    token : what it must carry, as ``?token=`` or ``X-Token``.
    host : the address that the server is bound to.
    origins : where pages may come from, beside the studio itself.
    """

    token: str
    host: str = "127.0.0.1"
    origins: frozenset[Place] = frozenset()

    def misplaced(self, request: HTTPConnection) -> str | None:
        """Why a request by this name, or from a page of that place, is refused."""
        hosts, origins = request.headers.getlist("host"), request.headers.getlist("origin")
        if len(hosts) != 1 or _HOST.fullmatch(hosts[0]) is None:
            return "The request does not say which host it is meant for."
        if is_loopback(self.host) and not self._is_own(hosts[0]):
            return (
                f"The studio is asked for as {hosts[0]}, which is no name of this machine for "
                "itself. If that is a proxy of yours, start the studio with --allow-origin and "
                "the address of the proxy."
            )
        if not origins:
            return None
        place = Place.of(origins[0]) if len(origins) == 1 else None
        if place is None:
            return "A page that does not say where it came from gets nothing from the studio."
        if place in self.origins or place.is_named(hosts[0]):
            return None
        return (
            f"A page from {place} gets nothing from the studio. If that is where you opened it, "
            f"start the studio with --allow-origin {place}"
        )

    def without_token(self, request: HTTPConnection) -> str | None:
        """Why a request is refused whose token is missing or wrong."""
        given = request.headers.get("x-token") or request.query_params.get("token", "")
        if secrets.compare_digest(given.encode(errors="replace"), self.token.encode()):
            return None
        what = "is not the studio's" if given else "is missing"
        return (
            f"The token {what}. Open the whole address that henkei studio printed when it "
            "started; it ends with ?token= and the token."
        )

    def _is_own(self, host: str) -> bool:
        named = _HOST.fullmatch(host)
        return (named is not None and is_loopback(named[1])) or any(
            place.is_named(host) for place in self.origins
        )


class Guard:
    """Answers 403 for what is refused, before anything else sees it; WebSockets are not opened.

    script : of the studio, in the page that is shown then: a tab of a browser that has the token
        goes on with it.
    """

    def __init__(
        self, app: ASGIApp, refused: Callable[[HTTPConnection], str | None], script: str = ""
    ) -> None:
        self._app, self._refused, self._script = app, refused, script

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        app = self._app
        if scope["type"] != "lifespan":
            request = HTTPConnection(scope)
            reason = self._refused(request)
            app = self._app if reason is None else _refusal(reason, request, self._script)
        await app(scope, receive, send)


class SecureHeaders:
    """Adds to every answer what browsers are to keep a page from doing."""

    def __init__(self, app: ASGIApp, origins: frozenset[Place]) -> None:
        ancestors = " ".join(["'self'", *sorted(map(str, origins))])
        policy = (
            "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
            "img-src 'self' data: blob:; connect-src 'self' ws: wss:; worker-src 'self' blob:; "
            "object-src 'none'; base-uri 'none'; form-action 'none'; "
            f"frame-ancestors {ancestors}"
        )
        self._app = app
        self._headers = [
            (b"content-security-policy", policy.encode()),
            (b"x-content-type-options", b"nosniff"),
            (b"referrer-policy", b"no-referrer"),
            (b"cross-origin-resource-policy", b"same-origin"),
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def sent(message: Message) -> None:
            if message["type"].endswith("http.response.start"):
                message["headers"] = [*message.get("headers", ()), *self._headers]
                if not any(name == b"cache-control" for name, _ in message["headers"]):
                    message["headers"].append((b"cache-control", b"no-cache"))
            await send(message)

        await self._app(scope, receive, sent)


def is_loopback(host: str) -> bool:
    """Whether a name or address, IPv6 with or without brackets, is this machine's for itself."""
    name = host.strip("[]").rstrip(".").lower()
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return name == "localhost" or name.endswith(".localhost")


def allowed(origins: tuple[str, ...]) -> frozenset[Place]:
    """The places that a person allows.

    Raises
    ------
    InvalidInput : one is not a scheme and a host, perhaps with a port.
    """
    places = {origin: Place.of(origin.removesuffix("/")) for origin in origins}
    for origin, place in places.items():
        if place is None:
            raise InvalidInput(
                f"--allow-origin {origin}: write it as browsers do, for example "
                "https://hub.example.org or http://localhost:8888"
            )
    return frozenset(place for place in places.values() if place is not None)


def checked_token(token: str) -> str:
    """A token that a person chose.

    Raises
    ------
    InvalidInput : it is short, or does not go into an address as it is.
    """
    if _TOKEN.fullmatch(token) is None:
        raise InvalidInput(
            "a token has 16 to 256 letters, digits or any of -._~; leave it out to get a good one"
        )
    return token


def kept_token(path: Path) -> str:
    """The token in a file that only its owner reads, made if there is none.

    Open pages find the studio again after it was restarted because the token stays. Where it
    cannot be kept, it lasts until the studio ends.
    """
    token = _kept(path)
    if token is None:
        token = secrets.token_urlsafe(32)
        with suppress(OSError):
            _keep(token, path)
    return _kept(path) or token


def _kept(path: Path) -> str | None:
    """What is in the file, unless others could have read or written it."""
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        with os.fdopen(descriptor, encoding="ascii", errors="replace") as stream:
            status = os.fstat(descriptor)
            text = stream.read(1000).strip()
    except OSError:
        return None
    private = os.name == "nt" or (status.st_uid == os.geteuid() and not status.st_mode & 0o077)
    return text if private and _TOKEN.fullmatch(text) else None


def _keep(token: str, path: Path) -> None:
    """Write the file whole; of two studios that start at once, the second takes the first's."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{secrets.token_hex(6)}")
    descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(descriptor, "w", encoding="ascii") as stream:
            stream.write(token)
        if _kept(path) is None:
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _refusal(reason: str, request: HTTPConnection, script: str) -> Response:
    if "text/html" not in request.headers.get("accept", ""):
        return JSONResponse({"message": reason}, status_code=403)
    said = page("The studio does not open here", reason, script)
    return HTMLResponse(said, status_code=403)


def page(title: str, text: str, script: str = "") -> str:
    """A plain page that says something, and runs a script if there is one."""
    module = f'<script type="module" src="{escape(script)}"></script>' if script else ""
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title>'
        '<meta name="viewport" content="width=device-width"><style>body{font:16px/1.5 system-ui,'
        "sans-serif;max-width:36em;margin:15vh auto;padding:0 1em;color-scheme:light dark}"
        f"</style><h1>{escape(title)}</h1><p>{escape(text)}</p>{module}</html>"
    )
