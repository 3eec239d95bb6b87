"""The studio's server, as browsers and strangers meet it: a real one, on a free port."""

from __future__ import annotations

import json
import logging
import socket
import struct
import tempfile
import threading
from contextlib import closing
from pathlib import Path

import httpx
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from henkei.errors import InvalidFile, InvalidInput
from henkei.studio import server
from henkei.studio.engine import Engine
from henkei.studio.messages import encode
from henkei.studio.security import Access, allowed
from henkei.studio.server import Settings, display_name, listening, url
from served import TOKEN, Noting, hear, plain_client, say, served, until

BLOB = "0123456789abcdef" * 2
FOREIGN = {"Origin": "http://evil.example.org"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A page, a blob, a file that was exported and the uploads that are being received."""
    folder = tmp_path_factory.mktemp("studio")
    for name in ("page", "uploads"):
        (folder / name).mkdir()
    (folder / "page" / "index.html").write_text("<title>henkei studio</title>")
    (folder / "page" / "studio.js").write_text("studio")
    (folder / BLOB).write_bytes(bytes(range(256)) * 1000)
    (folder / "exported").write_bytes(b"v 0 0 0\n")
    return folder


@pytest.fixture(scope="module")
def module_studio(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(folder / "uploads"))
        with served(Noting(folder), page=folder / "page", largest_upload=3_000_000) as studio:
            yield studio


@pytest.fixture
def studio(module_studio, folder):
    """The studio, with nothing noted yet."""
    fresh = Noting(folder, files={"j1": (folder / "exported", "head.obj")})
    for name, value in vars(fresh).items():
        setattr(module_studio.session, name, value)
    yield module_studio
    assert not list((folder / "uploads").iterdir())


# Who gets in


ROUTES = [
    ("GET", "/"),
    ("GET", f"/data/{BLOB}"),
    ("POST", "/upload?name=a.obj"),
    ("POST", "/export"),
    ("GET", "/file/j1"),
]


def refused(answer: httpx.Response, told: str) -> None:
    assert answer.status_code == 403
    assert told in answer.json()["message"]


@pytest.mark.parametrize(("method", "path"), ROUTES)
def test_no_token_a_wrong_one_a_foreign_page_or_name_is_refused(studio, method, path):
    http, base = studio.http, str(studio.http.base_url).rstrip("/")
    with plain_client() as stranger:
        refused(stranger.request(method, base + path), "The token is missing")
        wrong = {"X-Token": TOKEN + "x"}
        refused(stranger.request(method, base + path, headers=wrong), "is not the studio's")
        good = stranger.request(method, base + path, headers={"X-Token": TOKEN}, content=b"{}")
        assert good.status_code == 200
    studio.session.noted.clear()
    refused(http.request(method, path, headers=FOREIGN), "http://evil.example.org")
    refused(http.request(method, path, headers={"Origin": "null"}), "does not say where it came")
    refused(http.request(method, path, headers={"Host": "evil.example.org"}), "no name of this")
    assert not studio.session.noted


@pytest.mark.parametrize(
    ("query", "headers"),
    [
        ("", {}),
        ("?token=wrong", {}),
        (f"?token={TOKEN}", FOREIGN),
        (f"?token={TOKEN}", {"Origin": "null"}),
        (f"?token={TOKEN}", {"Origin": "http://127.0.0.1:1"}),
    ],
)
def test_a_websocket_is_refused_before_it_opens(studio, query, headers):
    with (
        pytest.raises(InvalidStatus) as caught,
        connect(f"ws://127.0.0.1:{studio.port}/ws{query}", additional_headers=headers, proxy=None),
    ):
        pass
    response = caught.value.response
    assert response.status_code == 403
    assert json.loads(response.body)["message"]
    assert not studio.session.noted


def test_the_own_page_gets_in(studio):
    own = {"Origin": f"http://127.0.0.1:{studio.port}"}
    assert studio.http.get("/", headers=own).status_code == 200
    with studio.page(additional_headers=own) as page:
        say(page, kind="hello", session=None, id=1)
        assert hear(page).kind == "done"


def test_a_browser_without_token_sees_a_page(studio):
    with plain_client() as stranger:
        headers = {"Accept": "text/html,*/*"}
        answer = stranger.get(f"http://127.0.0.1:{studio.port}/", headers=headers)
    assert answer.status_code == 403
    assert answer.headers["content-type"].startswith("text/html")
    assert "Open the whole address" in answer.text


def test_what_a_proxy_that_is_allowed_passes_on(folder):
    access = Access(TOKEN, origins=allowed(("https://hub.example.org",)))
    with served(Noting(folder), access=access, page=folder / "page") as studio:
        headers = {"Host": "hub.example.org", "Origin": "https://hub.example.org"}
        answer = studio.http.get("/", headers=headers)
        assert answer.status_code == 200
        assert (
            "frame-ancestors 'self' https://hub.example.org"
            in (answer.headers["content-security-policy"])
        )
        assert studio.http.get("/", headers=FOREIGN).status_code == 403


# The page and its files


def test_the_page_and_its_files(studio):
    answer = studio.http.get("/")
    assert answer.text == "<title>henkei studio</title>"
    assert answer.headers["content-type"].startswith("text/html")
    with plain_client() as stranger:
        script = stranger.get(f"http://127.0.0.1:{studio.port}/studio.js")
    assert (script.status_code, script.text) == (200, "studio")
    assert "javascript" in script.headers["content-type"]
    again = studio.http.get("/studio.js", headers={"If-None-Match": script.headers["etag"]})
    assert again.status_code == 304


@pytest.mark.parametrize(
    "path", ["/none.js", "/../exported", "/%2e%2e/exported", "//etc/passwd", "/%00"]
)
def test_nothing_else_is_served(studio, path):
    answer = studio.http.get(path)
    assert answer.status_code == 404
    assert answer.json()["message"]


@pytest.mark.parametrize("path", ["/", f"/data/{BLOB}", "/studio.js", "/none", "/file/j1"])
def test_browsers_are_told_what_a_page_may_do(studio, path):
    headers = studio.http.get(path).headers
    policy = headers["content-security-policy"]
    assert "default-src 'self'; script-src 'self';" in policy
    assert "connect-src 'self' ws: wss:" in policy
    assert policy.endswith("frame-ancestors 'self'")
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert "server" not in headers
    if not path.startswith(("/data", "/file")):
        assert headers["cache-control"] == "no-cache"


def test_without_a_bundle_a_page_says_what_to_do(folder):
    with served(Noting(folder), without_page="install <Node.js>, then make") as studio:
        answer = studio.http.get("/")
        assert answer.status_code == 200
        assert "install &lt;Node.js&gt;, then make" in answer.text
        assert studio.http.get("/studio.js").status_code == 404


# Data, exports and downloads


def test_data_is_kept_by_browsers_for_good(studio, folder):
    answer = studio.http.get(f"/data/{BLOB}")
    assert answer.content == (folder / BLOB).read_bytes()
    assert answer.headers["content-type"] == "application/octet-stream"
    assert "immutable" in answer.headers["cache-control"]
    again = studio.http.get(f"/data/{BLOB}", headers={"If-None-Match": answer.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


@pytest.mark.parametrize(
    "name", ["f" * 32, BLOB[:-1], BLOB.upper(), "%2e%2e%2fexported", "x" * 5000]
)
def test_no_other_data(studio, name):
    assert studio.http.get(f"/data/{name}").status_code == 404
    assert studio.session.all("data") in ([], ["f" * 32])


@pytest.mark.parametrize(
    ("name", "saved"),
    [
        ("head.obj", 'filename="head.obj"'),
        ("Schädel 1.obj", "filename*=utf-8''Sch%C3%A4del%201.obj"),
        ('a"; x="\r\nSet-Cookie: b.obj', "filename*=utf-8''a_%3B%20x%3D_Set-Cookie_%20b.obj"),
        ("../../etc/passwd", 'filename="passwd"'),
    ],
)
def test_a_file_is_saved_under_its_name(studio, folder, name, saved):
    studio.session.files = {"j1": (folder / "exported", name)}
    answer = studio.http.get("/file/j1")
    assert answer.content == b"v 0 0 0\n"
    assert answer.headers["content-disposition"] == f"attachment; {saved}"
    assert answer.headers["content-type"] == "application/octet-stream"
    assert "set-cookie" not in answer.headers
    assert studio.http.get("/file/j2").status_code == 404


def test_an_export_is_asked_for(studio):
    answer = studio.http.post("/export", json={"tab": "quad", "format": "obj"})
    assert answer.json() == {"job": "j1"}
    assert studio.session.all("export") == [{"tab": "quad", "format": "obj"}]


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"", 400),
        (b"{", 400),
        (b"[]", 400),
        (b"[" * 100_000, 400),
        (b"\xff", 400),
        (b"1" * 2_000_000, 413),
    ],
)
def test_an_export_that_makes_no_sense(studio, body, status):
    answer = studio.http.post("/export", content=body)
    assert answer.status_code == status
    assert answer.json()["message"]
    assert not studio.session.noted


def test_what_the_session_refuses_and_what_fails_in_it(studio, caplog):
    def refuse(request: dict) -> dict:
        raise InvalidInput("no such format; choose another")

    def fail(request: dict) -> dict:
        raise ZeroDivisionError

    studio.session.on_export = refuse
    answer = studio.http.post("/export", json={})
    assert (answer.status_code, answer.json()["message"]) == (400, "no such format; choose another")
    studio.session.on_export = fail
    answer = studio.http.post("/export", json={})
    assert (answer.status_code, "failed inside henkei" in answer.json()["message"]) == (500, True)
    until(lambda: "ZeroDivisionError" in caplog.text)
    assert studio.http.get("/").status_code == 200


# Uploads


def test_an_upload_is_a_temporary_file_of_its_kind(studio):
    body = np.random.default_rng(0).bytes(2_500_000)
    answer = studio.http.post("/upload", params={"name": "C:\\my meshes\\Head.OBJ"}, content=body)
    assert answer.json() == {"mesh": "m1"}
    ((path, name, content),) = studio.session.all("uploaded")
    assert (name, path.suffix, content) == ("Head.OBJ", ".obj", body)
    assert "Head" not in str(path)


@pytest.mark.parametrize(
    ("given", "name", "suffix"),
    [
        ("", "mesh", ""),
        ("../../x.ply", "x.ply", ".ply"),
        ("/etc/cron.d/..", "mesh", ""),
        ("a.obj/../b", "b", ""),
        ("a.o;rm -rf", "a.o;rm -rf", ""),
        ("x." + "y" * 300, "x." + "y" * 58 + "y" * 40, ""),
        ("gpj\u202eexe.\u0000obj\u200b", "gpjexe.obj", ".obj"),
        ("頭.stl", "頭.stl", ".stl"),
    ],
)
def test_only_the_last_part_of_a_name_counts(studio, given, name, suffix):
    studio.http.post("/upload", params={"name": given}, content=b"x")
    ((path, told, _),) = studio.session.all("uploaded")
    assert (told, path.suffix) == (name, suffix)
    assert path.parent == Path(tempfile.gettempdir())


def too_large(answer: httpx.Response) -> bool:
    return answer.status_code == 413 and "larger than 3 MB" in answer.json()["message"]


def test_a_file_that_is_too_large_is_told_at_once_or_as_it_comes(studio):
    body = bytes(4_000_000)
    assert too_large(studio.http.post("/upload", params={"name": "a.obj"}, content=body))
    pieces = (body[k : k + 100_000] for k in range(0, len(body), 100_000))
    assert too_large(studio.http.post("/upload", params={"name": "a.obj"}, content=pieces))
    assert studio.http.post("/upload", content=bytes(3_000_000)).status_code == 200
    assert len(studio.session.all("uploaded")) == 1


def raw(studio, *lines: str, body: bytes = b"", ends: bool = False) -> bytes:
    """What the server answers to bytes, after which the page ends or waits, until it hangs up."""
    own = f"Host: localhost:{studio.port}", f"X-Token: {TOKEN}", "Connection: close"
    with closing(socket.create_connection(("127.0.0.1", studio.port), 30)) as stream:
        stream.sendall("\r\n".join([*lines, *own, "", ""]).encode() + body)
        if ends:
            stream.shutdown(socket.SHUT_WR)
        answer = b""
        while data := stream.recv(65536):
            answer += data
        return answer


def test_a_content_length_that_lies(studio):
    post = "POST /upload?name=a.obj HTTP/1.1"
    assert b" 200 " not in raw(studio, post, "Content-Length: 1000", body=b"too little", ends=True)
    assert b" 200 " in raw(studio, post, "Content-Length: 4", body=b"v 0 and more")
    assert b" 413 " in raw(studio, post, "Content-Length: 99999999999999999999")
    assert b" 400 " in raw(studio, post, "Content-Length: -5")
    assert b" 400 " in raw(studio, post, "Content-Length: 5, 6")
    assert [content for *_, content in studio.session.all("uploaded")] == [b"v 0 "]


def test_an_upload_that_breaks_off_leaves_nothing(studio, folder):
    with socket.create_connection(("127.0.0.1", studio.port), 30) as stream:
        head = f"POST /upload HTTP/1.1\r\nHost: localhost\r\nX-Token: {TOKEN}\r\n"
        stream.sendall(f"{head}Content-Length: 2000000\r\n\r\n".encode() + bytes(1000))
        until(lambda: any((folder / "uploads").iterdir()))
        # A reset in place of an orderly end.
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    until(lambda: not any((folder / "uploads").iterdir()))
    assert not studio.session.noted


def test_a_file_that_the_session_refuses(studio):
    def refuse(path: Path, name: str) -> dict:
        raise InvalidFile(f"{name}, line 3: a face has one corner")

    studio.session.on_upload = refuse
    answer = studio.http.post("/upload", params={"name": "a.obj"}, content=b"x")
    assert answer.json() == {"message": "a.obj, line 3: a face has one corner"}


def test_a_full_disk_is_said(studio, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(Path(tempfile.gettempdir()) / "none"))
    answer = studio.http.post("/upload", params={"name": "a.obj"}, content=b"x")
    assert answer.status_code == 507
    assert "a.obj cannot be kept: No such file" in answer.json()["message"]


def test_the_studio_lives_while_a_file_is_parsed(studio):
    parsed = threading.Event()

    def parse(path: Path, name: str) -> dict:
        assert parsed.wait(30)
        return {"mesh": "m9"}

    studio.session.on_upload = parse
    answers: list[httpx.Response] = []
    upload = threading.Thread(
        target=lambda: answers.append(studio.http.post("/upload", content=b"x"))
    )
    upload.start()
    until(lambda: bool(studio.session.all("uploaded")))
    with studio.page() as page:
        say(page, kind="do", id=1)
        assert hear(page).kind == "done"
    parsed.set()
    upload.join()
    assert answers[0].json() == {"mesh": "m9"}


# The connection of a page


def test_messages_and_arrays_both_ways(studio):
    def answer(client, message) -> None:
        client.state({"revision": 1})
        client.frame({"tab": "deform", "surface": "s"}, **message.arrays)

    studio.session.on_receive = answer
    positions = np.arange(300_000, dtype=np.float32).reshape(-1, 3)
    with studio.page() as page:
        page.send(encode({"kind": "do", "id": 1, "tab": "deform"}, positions=positions))
        assert hear(page).header["revision"] == 1
        message = hear(page)
        assert message.kind == "frame"
        np.testing.assert_array_equal(message.arrays["positions"], positions)
    until(lambda: bool(studio.session.all("disconnected")))
    assert studio.session.threads == {"engine"}


def test_nonsense_leaves_the_studio_as_it_was(studio):
    chance = np.random.default_rng(1)
    with studio.page() as page:
        for k in range(200):
            page.send(chance.bytes(k) if k % 2 else "text")
            assert hear(page).kind == "refused"
        say(page, kind="undo", id=3)
        assert hear(page).header["id"] == 3


def test_a_message_that_is_too_large_ends_the_connection_only(studio, monkeypatch):
    with studio.page() as page:
        # The head of a frame of 2^40 bytes; only the head, as nothing may wait for the rest.
        page.socket.sendall(b"\x82\xff" + struct.pack("!Q", 1 << 40) + b"mask")
        with pytest.raises(ConnectionClosed) as caught:
            hear(page)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1009
    with studio.page() as page:
        say(page, kind="undo", id=3)
        assert hear(page).header["id"] == 3


@pytest.mark.parametrize(
    "data", [b"\x00" * 100, b"GET\r\n\r\n", b"\x16\x03\x01\x02\x00", b"A" * 200_000]
)
def test_what_is_no_http_at_all(studio, data):
    with closing(socket.create_connection(("127.0.0.1", studio.port), 30)) as stream:
        try:
            stream.sendall(data)
            stream.shutdown(socket.SHUT_WR)
            while stream.recv(65536):
                pass
        except OSError:
            pass  # hung up before all was said
    assert studio.http.get("/").status_code == 200


def test_a_page_that_stops_reading_holds_nothing_up(studio):
    """Its system's buffers fill; another page works on, and the session is told when it goes."""
    with studio.page(max_queue=1, close_timeout=0.01) as deaf, studio.page() as page:
        until(lambda: len(studio.session.clients) == 2)
        noise = np.zeros(500_000, np.float32)
        for _ in range(20):
            studio.session.clients[0].send({"kind": "basis"}, start=noise)
        say(page, kind="do", id=4)
        assert hear(page).header["id"] == 4
        assert len(studio.session.all("disconnected")) == 0
        assert hear(deaf).kind == "basis"
    until(lambda: len(studio.session.all("disconnected")) == 2)


# Beginning and end


def test_pages_are_answered_before_the_session_is_open(folder):
    opened = threading.Event()
    session = Noting(folder)

    def open_late(post) -> Noting:
        assert opened.wait(30)
        return session

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("served.Engine", lambda _: Engine(open_late))
        with served(session, page=folder / "page") as studio:
            assert studio.http.get("/").status_code == 200
            with studio.page() as page:
                say(page, kind="do", id=1)
                opened.set()
                assert hear(page).header["id"] == 1


def test_at_the_end_pages_are_told_and_the_session_is_closed_last(folder):
    session = Noting(folder)
    with served(session) as studio, studio.page() as page:
        until(lambda: bool(session.clients))
    with pytest.raises(ConnectionClosed):
        page.recv(timeout=30)
    assert [name for name, _ in session.noted] == ["connected", "disconnected", "close"]
    assert not studio.engine.busy


def test_serve_says_where_and_ends_with_the_reason_if_the_session_cannot_be_opened(monkeypatch):
    monkeypatch.setattr(server, "_HEAD_START", 0.0)

    def fail(post) -> Noting:
        raise InvalidInput("the folder is full; choose another")

    told: list[str] = []
    with pytest.raises(InvalidInput, match="the folder is full"):
        server.serve(Engine(fail), Settings(Access(TOKEN)), 0, told.append)
    assert told[0].startswith("http://127.0.0.1:")
    assert told[0].endswith(f"/?token={TOKEN}")


def test_the_next_port_is_taken_if_the_first_is_not_free(monkeypatch):
    with listening("127.0.0.1", 0) as taken:
        number = taken.getsockname()[1]
        with pytest.raises(InvalidInput, match=f"port {number} of 127.0.0.1"):
            listening("127.0.0.1", number)
        monkeypatch.setattr(server, "PORT", number)
        with listening("127.0.0.1", None) as free:
            assert number < free.getsockname()[1] < number + server.PORTS
        monkeypatch.setattr(server, "PORTS", 1)
        with pytest.raises(InvalidInput, match="choose another --port"):
            listening("127.0.0.1", None)


@pytest.mark.parametrize(
    ("host", "port"), [("no.such.host.invalid", 0), ("127.0.0.1", 70_000), ("", -1)]
)
def test_an_address_that_is_none(host, port):
    with pytest.raises(InvalidInput, match=r"--(port|host)"):
        listening(host, port)


@pytest.mark.parametrize(
    ("host", "start"),
    [
        ("127.0.0.1", "http://127.0.0.1:"),
        ("localhost", "http://localhost:"),
        ("::1", "http://[::1]:"),
        ("[::1]", "http://[::1]:"),
        ("0.0.0.0", f"http://{socket.gethostname()}:"),
    ],
)
def test_the_address_of_the_page(host, start):
    if ":" in host and not Path("/proc/net/if_inet6").exists():
        pytest.skip("no IPv6 here")
    with listening(host, 0) as listener:
        port = listener.getsockname()[1]
        assert url(listener, Access(TOKEN, host)) == f"{start}{port}/?token={TOKEN}"


def test_a_name_is_never_empty():
    assert [display_name(name) for name in ("", "/", ".", " .. ", "\n", "a/")] == ["mesh"] * 6


def test_the_token_is_in_no_log(studio, caplog):
    with caplog.at_level(logging.DEBUG), studio.page() as page:
        say(page, kind="do", id=1)
        hear(page)
        studio.http.get("/")
    told = [r.getMessage() for r in caplog.records if r.name.startswith(("uvicorn", "henkei"))]
    assert not any(TOKEN in line for line in told)
