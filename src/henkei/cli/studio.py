"""``henkei studio``: all methods live in a browser."""

from __future__ import annotations

import os
import warnings
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from henkei.errors import HenkeiError, InvalidInput, MissingDependency

if TYPE_CHECKING:
    from henkei.studio.engine import Post
    from henkei.studio.link import Session

_LIBRARIES = ("starlette", "uvicorn", "websockets", "platformdirs")
_NO_DEFAULT = Parameter(show_default=False)


def studio(
    *files: Path,
    port: Annotated[int | None, _NO_DEFAULT] = None,
    host: str = "127.0.0.1",
    token: Annotated[
        str | None, Parameter(show_default=False, env_var="HENKEI_STUDIO_TOKEN")
    ] = None,
    no_browser: Annotated[bool, _NO_DEFAULT] = False,
    folder: Annotated[Path | None, _NO_DEFAULT] = None,
    largest_upload: float = 1000,
    allow_origin: Annotated[tuple[str, ...], _NO_DEFAULT] = (),
) -> None:
    """Open all five methods in a browser, to work on meshes by hand.

    Example: `henkei studio head.obj`

    Prints the address of the page and opens it. What is done there is kept as it is done, and
    offered again at the next start; it can be saved as recipes for the other commands. Ctrl-C
    ends the studio.

    Nobody else can use it: it is bound to this machine, and its address holds a secret token. On
    another machine, by ssh: `ssh -L 8642:localhost:8642 machine henkei studio --no-browser`.

    Parameters
    ----------
    files
        Meshes to begin with; more are opened on the page.
    port
        Where to listen. Without it: 8642, or the next that is free. 0: any that is free.
    host
        The address to bind to; `0.0.0.0` for everyone who reaches this machine and has the token.
    token
        A token of your own, of 16 characters or more. Without it one is made and kept.
    no_browser
        Only print the address.
    folder
        Where sessions are kept, in place of your state folder.
    largest_upload
        In MB.
    allow_origin
        Let a page from there talk to the studio too, as `https://hub.example.org` behind whose
        proxy it is; may be repeated.
    """
    for library in _LIBRARIES:
        if find_spec(library) is None:
            raise MissingDependency(f"the studio needs {library}: pip install henkei[studio]")
    from platformdirs import user_state_path

    from henkei.studio.engine import Engine
    from henkei.studio.security import Access, allowed, checked_token, is_loopback, kept_token
    from henkei.studio.server import Settings, serve

    state = user_state_path("henkei", appauthor=False)
    files = tuple(_present(path) for path in files)
    if not 0 < largest_upload < 1e9:
        raise InvalidInput(f"--largest-upload {largest_upload:g}: more than 0 MB are needed")
    access = Access(
        token=checked_token(token) if token else kept_token(state / "studio-token"),
        host=host,
        origins=allowed(allow_origin),
    )
    page, without_page = _page()
    settings = Settings(access, page, without_page, int(largest_upload * 1e6))
    sessions = _made(folder or state / "studio")

    def opened(post: Post) -> Session:
        return _session(sessions, files, post)

    def ready(address: str) -> None:
        print(address, flush=True)
        if not is_loopback(host):
            warnings.warn(
                f"the studio is bound to {host}: whoever reaches this machine and sees the token "
                "can use it, and nothing is encrypted on the way; ssh -L is safer",
                stacklevel=2,
            )
        if not no_browser:
            _open_browser(address)

    engine = Engine(opened)
    serve(engine, settings, port, ready)
    print("stopped; what was open is kept and offered at the next start", flush=True)
    if engine.busy:  # with something long, which would hold up the end or crash in it
        os._exit(0)


def _session(folder: Path, files: tuple[Path, ...], post: Post) -> Session:
    """The session, on the engine's thread; the files are opened after it is there."""
    from henkei.studio.session import Session

    session = Session(folder, post)
    for path in files:
        post(partial(_open, session, path))
    return session


def _open(session: Session, path: Path) -> None:
    try:
        session.open(path)
    except HenkeiError as error:
        warnings.warn(str(error), stacklevel=2)


def _page() -> tuple[Path | None, str]:
    """The folder of the bundled page, or what to do without it.

    It is looked for here first, as the module that knows it comes with NumPy and SciPy.
    """
    folder = Path(__file__).parents[1] / "page"
    if (folder / "index.html").is_file():
        return folder, ""
    from henkei.io.page import page_folder

    try:
        return page_folder(), ""
    except MissingDependency as error:
        return None, str(error)


def _present(path: Path) -> Path:
    if not path.is_file():
        what = "this is a folder, not a mesh" if path.is_dir() else "there is no such file"
        raise InvalidInput(f"{path}: {what}")
    return path.resolve()


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(
            f"sessions cannot be kept in {folder} ({error.strerror}); choose another --folder"
        ) from error
    return folder.resolve()


def _open_browser(address: str) -> None:
    """In a thread of its own, as some browsers only return when they are closed."""
    import threading
    import webbrowser

    threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
