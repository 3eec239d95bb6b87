"""Who gets in: tokens, hosts, origins, and what is kept of them."""

from __future__ import annotations

import os
import stat

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.requests import HTTPConnection

from henkei.errors import InvalidInput
from henkei.studio import security
from henkei.studio.security import Access, Place, allowed, checked_token, is_loopback, kept_token

TOKEN = "a-token-for-the-tests"
HUB = "https://hub.example.org"


def request(query: str = "", **headers: str | list[str]) -> HTTPConnection:
    """A request with these headers; a list stands for one that comes several times."""
    rows = [
        (name.replace("_", "-").encode(), value.encode("utf-8", "surrogateescape"))
        for name, values in headers.items()
        for value in ([values] if isinstance(values, str) else values)
    ]
    return HTTPConnection({"type": "http", "headers": rows, "query_string": query.encode()})


@pytest.mark.parametrize(
    ("host", "origin", "enters"),
    [
        ("127.0.0.1:8642", None, True),
        ("127.0.0.1:8642", "http://127.0.0.1:8642", True),
        ("localhost:8642", "http://LOCALHOST:8642", True),
        ("[::1]:8642", "http://[::1]:8642", True),
        ("localhost", "http://localhost:80", True),
        ("studio.localhost:8642", "http://studio.localhost:8642", True),
        ("localhost:8888", "https://localhost:8888", True),
        ("127.0.0.1:8642", "http://127.0.0.1:8643", False),
        ("127.0.0.1:8642", "http://localhost:8642", False),
        ("127.0.0.1:8642", "http://evil.example.org", False),
        ("127.0.0.1:8642", "http://127.0.0.1:8642.evil.example.org", False),
        ("127.0.0.1:8642", "http://127.0.0.1:8642@evil.example.org", False),
        ("127.0.0.1:8642", "null", False),
        ("127.0.0.1:8642", "", False),
        ("127.0.0.1:8642", "file://", False),
        ("127.0.0.1:8642", "http://127.0.0.1:8642/", False),
        ("127.0.0.1:8642", "ws://127.0.0.1:8642", False),
        ("evil.example.org:8642", "http://evil.example.org:8642", False),
        ("evil.example.org:8642", None, False),
        ("127.0.0.1.evil.example.org", None, False),
        ("localhost@evil.example.org", None, False),
        ("evil@localhost", None, False),
        ("2130706433:8642", None, False),
        ("0.0.0.0:8642", None, False),
        ("", None, False),
    ],
)
def test_who_gets_in_by_host_and_origin(host, origin, enters):
    headers = {"host": host} | ({} if origin is None else {"origin": origin})
    reason = Access(TOKEN).misplaced(request(**headers))
    assert (reason is None) == enters


def test_a_host_or_origin_that_is_missing_or_comes_twice():
    access = Access(TOKEN)
    own = "http://localhost:1"
    assert access.misplaced(request())
    assert access.misplaced(request(host=["localhost:1", "evil.example.org"]))
    assert access.misplaced(request(host="localhost:1", origin=[own, "http://evil.example.org"]))


@pytest.mark.parametrize(
    ("host", "origin", "enters"),
    [
        ("hub.example.org", HUB, True),
        ("hub.example.org:443", HUB, True),
        ("127.0.0.1:8642", HUB, True),
        ("hub.example.org", None, True),
        ("hub.example.org", "https://hub.example.org:444", False),
        ("hub.example.org", "http://other.example.org", False),
        ("other.example.org", HUB, False),
    ],
)
def test_a_proxy_that_is_allowed(host, origin, enters):
    access = Access(TOKEN, origins=allowed((HUB + "/",)))
    headers = {"host": host} | ({} if origin is None else {"origin": origin})
    assert (access.misplaced(request(**headers)) is None) == enters


def test_bound_to_the_network_any_name_will_do_but_no_foreign_page():
    access = Access(TOKEN, host="0.0.0.0")
    assert access.misplaced(request(host="desk:8642", origin="http://desk:8642")) is None
    told = access.misplaced(request(host="desk:8642", origin="http://evil.example.org:81"))
    assert told is not None
    assert "--allow-origin http://evil.example.org:81" in told


@pytest.mark.parametrize(
    ("query", "header", "enters"),
    [
        (f"token={TOKEN}", None, True),
        ("", TOKEN, True),
        (f"token={TOKEN}", "wrong", False),
        ("token=wrong", TOKEN, True),
        ("", None, False),
        ("token=", "", False),
        (f"token={TOKEN[:-1]}", None, False),
        (f"token={TOKEN}x", None, False),
        (f"token={TOKEN.upper()}", None, False),
        ("token=%C3%A9%ff%00", None, False),
        (f"tokens={TOKEN}", None, False),
    ],
)
def test_the_token(query, header, enters):
    headers = {} if header is None else {"x_token": header}
    reason = Access(TOKEN).without_token(request(query, **headers))
    assert (reason is None) == enters


@given(st.lists(st.text(), max_size=2), st.lists(st.text(), max_size=2), st.text(), st.text())
def test_no_headers_are_too_strange(hosts, origins, token, query):
    plain = request(query, host=hosts, origin=origins, x_token=token)
    access = Access(TOKEN, origins=allowed((HUB,)))
    assert access.without_token(plain) is not None
    if access.misplaced(plain) is None:
        assert all(is_loopback(host.rpartition(":")[0] or host) for host in hosts)


@given(st.text())
def test_a_place_names_itself(text):
    place = Place.of(text)
    assert place is None or Place.of(str(place)) == place


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "127.1.2.3", "::1", "[::1]", "localhost", "a.localhost."]
)
def test_loopback(host):
    assert is_loopback(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "10.0.0.1", "localhost.org", "notlocalhost", ""])
def test_not_loopback(host):
    assert not is_loopback(host)


@pytest.mark.parametrize("origin", ["hub.example.org", "*", "null", "https://", f"{HUB}/lab", ""])
def test_an_origin_that_is_none_is_refused(origin):
    with pytest.raises(InvalidInput, match="write it as browsers do"):
        allowed((origin,))


@pytest.mark.parametrize("token", ["short", "", "with a space in it, long", "é" * 20, "x" * 257])
def test_a_token_that_is_too_weak_or_does_not_fit_an_address(token):
    with pytest.raises(InvalidInput, match="16 to 256"):
        checked_token(token)


# The token that is kept


@pytest.fixture
def path(tmp_path):
    return tmp_path / "state" / "studio-token"


def test_the_token_stays_and_only_its_owner_reads_it(path):
    token = kept_token(path)
    assert checked_token(token) == token
    assert len(token) >= 43
    assert kept_token(path) == token
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_two_places_have_two_tokens(tmp_path):
    assert kept_token(tmp_path / "a") != kept_token(tmp_path / "b")


@pytest.mark.parametrize(
    "text", ["", "short", "\x00" * 40, "two words that are long enough", "é" * 30]
)
def test_a_damaged_token_is_replaced(path, text):
    path.parent.mkdir()
    path.write_text(text, encoding="utf-8")
    path.chmod(0o600)
    token = kept_token(path)
    assert token != text
    assert kept_token(path) == token


@pytest.mark.skipif(os.name == "nt", reason="POSIX permissions")
@pytest.mark.parametrize("mode", [0o644, 0o640, 0o602])
def test_a_token_that_others_could_read_or_write_is_replaced(path, mode):
    path.parent.mkdir()
    path.write_text(TOKEN)
    path.chmod(mode)
    token = kept_token(path)
    assert token != TOKEN
    assert kept_token(path) == token
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.skipif(os.name == "nt", reason="symbolic links")
def test_a_link_is_not_followed(path, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text(TOKEN)
    elsewhere.chmod(0o600)
    path.parent.mkdir()
    path.symlink_to(elsewhere)
    assert kept_token(path) != TOKEN
    assert elsewhere.read_text() == TOKEN


def test_where_nothing_can_be_kept_there_is_a_token_all_the_same(tmp_path):
    (tmp_path / "file").write_text("")
    assert len(kept_token(tmp_path / "file" / "token")) >= 43


def test_of_two_studios_that_start_at_once_the_second_token_is_both_their_own(path, monkeypatch):
    """It has been written while the first studio still made its own."""
    keep, second = security._keep, []

    def late(token, path):
        monkeypatch.setattr(security, "_keep", keep)
        second.append(kept_token(path))
        keep(token, path)

    monkeypatch.setattr(security, "_keep", late)
    assert [kept_token(path)] == second == [path.read_text()]
