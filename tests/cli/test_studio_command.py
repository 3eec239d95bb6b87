"""``henkei studio``: what it refuses before it starts, what it starts, and how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import henkei.cli.studio as command
from apart import run
from henkei.cli import main
from henkei.errors import InvalidInput, MissingDependency
from henkei.io.page import page_folder
from henkei.studio import server
from henkei.studio.engine import Engine
from henkei.studio.server import Settings, listening
from served import TOKEN, Noting, plain_client, until


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """A folder for the token and sessions, and no token from outside."""
    monkeypatch.setattr("platformdirs.user_state_path", lambda *_, **__: tmp_path / "state")
    monkeypatch.delenv("HENKEI_STUDIO_TOKEN", raising=False)
    return tmp_path / "state"


@pytest.fixture
def started(monkeypatch):
    """What is served, without being served."""
    started: list[tuple[Engine, Settings, int | None]] = []

    def serve(engine, settings, port, ready) -> None:
        started.append((engine, settings, port))
        ready("http://127.0.0.1:8642/?token=secret")

    monkeypatch.setattr(server, "serve", serve)
    return started


@pytest.fixture
def browsed(monkeypatch):
    browsed: list[str] = []
    monkeypatch.setattr("webbrowser.open", browsed.append)
    return browsed


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["none.obj"], "none.obj: there is no such file"),
        (["."], ".: this is a folder"),
        (["--token", "short"], "a token has 16 to 256"),
        (["--allow-origin", "*"], "write it as browsers do"),
        (["--largest-upload", "0"], "more than 0 MB"),
        (["--largest-upload", "nan"], "more than 0 MB"),
        (["--folder", "file"], "sessions cannot be kept in file"),
        (["--host", "no.such.host.invalid"], "no address of this machine"),
        (["--port", "70000"], "choose another --port"),
        (["--port", "x"], "Invalid value"),
    ],
)
def test_what_is_refused_before_the_start(arguments, told, tmp_path, monkeypatch, capsys, browsed):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("")
    assert main(["studio", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in " ".join(err.split())
    assert not browsed


def test_a_port_that_is_taken_is_refused_if_it_was_asked_for(capsys):
    with listening("127.0.0.1", 0) as taken:
        assert main(["studio", "--no-browser", "--port", str(taken.getsockname()[1])]) == 2
    assert "cannot listen at port" in capsys.readouterr().err


def test_the_address_comes_first_and_is_opened(started, browsed, capsys):
    assert main(["studio"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "http://127.0.0.1:8642/?token=secret"
    assert lines[-1] == "stopped; what was open is kept and offered at the next start"
    until(lambda: browsed == lines[:1])


def test_without_a_browser(started, browsed, capsys):
    assert main(["studio", "--no-browser"]) == 0
    assert capsys.readouterr().out.startswith("http://")
    assert not browsed


def test_what_is_asked_for_is_served(started, tmp_path, state):
    sessions = tmp_path / "new" / "sessions"
    arguments = ["--port", "0", "--host", "::1", "--token", TOKEN, "--folder", str(sessions)]
    arguments += ["--largest-upload", "2.5", "--allow-origin", "https://a.org", "--no-browser"]
    assert main(["studio", *arguments]) == 0
    ((_, settings, port),) = started
    assert (port, settings.access.host, settings.access.token) == (0, "::1", TOKEN)
    assert [str(place) for place in settings.access.origins] == ["https://a.org"]
    assert settings.largest_upload == 2_500_000
    assert sessions.is_dir()
    assert not state.exists()


def test_the_token_is_from_the_environment_or_the_same_as_last_time(started, monkeypatch):
    for _ in range(2):
        main(["studio", "--no-browser"])
    monkeypatch.setenv("HENKEI_STUDIO_TOKEN", TOKEN)
    main(["studio", "--no-browser"])
    first, second, third = (settings.access.token for _, settings, _ in started)
    assert first == second != third == TOKEN


@pytest.mark.filterwarnings("default")
def test_whoever_opens_it_to_the_network_is_warned(started, capsys):
    assert main(["studio", "--host", "0.0.0.0", "--no-browser"]) == 0
    assert "warning: the studio is bound to 0.0.0.0" in capsys.readouterr().err
    assert len(started[0][1].access.token) >= 43
    assert main(["studio", "--host", "localhost", "--no-browser"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("library", ["starlette", "websockets"])
def test_a_library_that_is_missing_is_named(library, monkeypatch, capsys):
    monkeypatch.setattr(command, "find_spec", lambda name: None if name == library else True)
    assert main(["studio"]) == 2
    assert f"needs {library}: pip install henkei[studio]" in capsys.readouterr().err


def begin_and_end(engine: Engine) -> None:
    engine.start()
    run(engine.close(30))


def test_files_are_opened_when_the_session_is_there(started, tmp_path, monkeypatch):
    opened: list[Path] = []

    class Session(Noting):
        def open(self, path: Path) -> None:
            opened.append(path)
            if path.name == "b.obj":
                raise InvalidInput("b.obj, line 1: this is no mesh")

    module = SimpleNamespace(Session=lambda folder, post: Session(folder))
    monkeypatch.setitem(sys.modules, "henkei.studio.session", module)
    files = [tmp_path / name for name in ("a.obj", "b.obj", "c.obj")]
    for file in files:
        file.write_text("")
    main(["studio", *map(str, files), "--no-browser"])
    engine = started[0][0]
    with pytest.warns(UserWarning, match=r"b\.obj, line 1: this is no mesh"):
        begin_and_end(engine)
    assert opened == files


def test_the_page_is_found_where_the_rest_of_henkei_finds_it(monkeypatch):
    try:
        expected = page_folder(), ""
    except MissingDependency as error:
        expected = None, str(error)
    assert command._page() == expected


STUDIO = """
import sys, time
import henkei.cli.studio as command

class Session:
    def close(self):
        print("closed", flush=True)

def session(folder, files, post):
    sys.stdin.readline()
    heavy = {"numpy", "scipy", "pydantic"} & sys.modules.keys()
    print("loaded for the first page:", sorted(heavy), flush=True)
    for path in files:
        from henkei.studio import server
        server._PATIENCE = 0.1
        post(lambda: time.sleep(600))
    return Session()

command._session = session
command._page = lambda: (None, "not built")
from henkei.cli import main
sys.exit(main(["studio", "--no-browser", "--port", "0", "--folder", "sessions", *sys.argv[1:]]))
"""
STOPPED = "stopped; what was open is kept and offered at the next start"


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C as a signal")
@pytest.mark.parametrize(
    ("long", "sent", "status", "last"),
    [
        (False, signal.SIGINT, 0, ["closed", STOPPED]),
        (False, signal.SIGTERM, -15, ["closed"]),
        (True, signal.SIGINT, 0, [STOPPED]),
    ],
)
def test_from_the_start_to_ctrl_c(long, sent, status, last, tmp_path):
    """The page is answered before anything heavy is loaded; at the end the session is closed, if
    it is not in the middle of something long."""
    environment = {**os.environ, "HENKEI_STUDIO_TOKEN": TOKEN}
    with (
        subprocess.Popen(
            [sys.executable, "-c", STUDIO, *([__file__] if long else [])],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env=environment,
        ) as studio,
        plain_client() as http,
    ):
        assert studio.stdin is not None
        assert studio.stdout is not None
        address = studio.stdout.readline().strip()
        assert address.endswith(f"/?token={TOKEN}")
        assert http.get(address).status_code == 200
        studio.stdin.write("\n")
        studio.stdin.flush()
        assert studio.stdout.readline() == "loaded for the first page: []\n"
        studio.send_signal(sent)
        out, err = studio.communicate(timeout=60)
    assert err == ""
    assert out.splitlines() == last
    assert studio.returncode == status
