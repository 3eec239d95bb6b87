"""Views: what they take, where they go, and what is seen where there is no picture."""

from __future__ import annotations

import subprocess
import sys
import types
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput, MissingDependency
from henkei.io import html, view
from henkei.io import page as built
from written import patchwork, sheet

MESH = sheet()


@pytest.fixture(autouse=True)
def _viewer(monkeypatch):
    """The viewer need not be built."""
    monkeypatch.setattr(html, "_bundle", lambda folder: (b"look", b"viewer"))
    monkeypatch.setattr(html, "page_folder", lambda: Path())


@pytest.fixture
def no_viewer(monkeypatch, tmp_path):
    monkeypatch.setattr(built, "_FOLDER", tmp_path / "nowhere")
    monkeypatch.setattr(html, "page_folder", built.page_folder)


class Frames(HTMLParser):
    """The frames of a notebook's output, and the text around them."""

    def __init__(self, output: str) -> None:
        super().__init__()
        self.frames: list[dict[str, str | None]] = []
        self.tags: set[str] = set()
        self.text = ""
        self.feed(output)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        if tag == "iframe":
            self.frames.append(dict(attrs))

    def handle_data(self, data):
        self.text += data


def test_what_it_takes(tmp_path):
    hk.write(tmp_path / "a.ply", MESH)
    for source in (MESH, patchwork(), tmp_path / "a.ply", (MESH.vertices, MESH.faces)):
        assert hk.view(source).scene.surface.face_count in (8, 3)
    again = hk.view(hk.view(MESH, title="a"), edges=False).scene
    assert (again.title, again.edges, again.surface) == ("a", False, MESH)


def test_other_libraries():
    trimesh = pytest.importorskip("trimesh")
    pyvista = pytest.importorskip("pyvista")
    assert hk.view(trimesh.creation.box()).scene.surface.face_count == 12
    plane = pyvista.Plane(i_resolution=2, j_resolution=3)
    plane.point_data["height"] = np.arange(12.0)
    scene = hk.view(plane, "height").scene
    assert scene.surface.face_count == 6
    assert "height" in [one.name for one in scene.colourings]


@pytest.mark.parametrize("source", [None, 3, "no such file.obj", "x", object(), [1, 2]])
def test_what_it_does_not_take(source):
    with pytest.raises(InvalidInput):
        hk.view(source)


def test_arguments():
    shown = hk.view(
        MESH,
        np.linspace(-1, 1, 9),
        colormap="coolwarm",
        range=(-2, 2),
        title="Sheet",
        height=300,
        edges=False,
        marks=[1],
        lines=[[0, 1], [1, 2]],
        up="z",
    )
    scene = shown.scene
    (one,) = scene.colourings
    assert (one.name, one.colormap, one.limits) == ("values", "coolwarm", (-2, 2))
    assert (scene.title, scene.edges, scene.up, scene.shown) == ("Sheet", False, "z", 0)
    assert (len(scene.marks), len(scene.lines), shown.height) == (1, 2, 300)
    assert hk.view(patchwork(), colormap="magma", range=(0, 1), scalars="label")
    coloured = hk.view(hk.view(MESH, np.arange(9.0)), colormap="magma").scene
    assert coloured.colourings[0].colormap == "magma"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"scalars": np.zeros(5)}, "9 vertices and 8 faces"),
        ({"scalars": "height"}, "there are none"),
        ({"colormap": "magma"}, "for scalars; give some"),
        ({"up": "x"}, "up is 'y' or 'z'"),
        ({"height": 3}, "from 100 to 10000"),
        ({"height": 300.5}, "from 100 to 10000"),
        ({"height": True}, "from 100 to 10000"),
        ({"marks": [99]}, "there is no vertex 99"),
        ({"lines": [[0, 99]]}, "there is no vertex 99"),
    ],
)
def test_arguments_that_do_not_fit(arguments, told):
    with pytest.raises(InvalidInput) as caught:
        hk.view(MESH, **arguments)
    assert told in str(caught.value)


def test_surfaces_that_cannot_be_seen(monkeypatch):
    with pytest.raises(InvalidInput, match="no faces"):
        hk.view(hk.Mesh(np.eye(3), []))
    monkeypatch.setattr(html, "MOST_FACES", 5)
    with pytest.raises(InvalidInput, match="at most 5"):
        hk.view(MESH)


def test_a_notebook_gets_a_frame_that_cannot_reach_it():
    evil = "</iframe><script>alert(1)</script>\"'"
    output = Frames(hk.view(MESH, {evil: np.arange(9.0)}, title=evil, height=321)._repr_html_())
    (frame,) = output.frames
    assert frame["sandbox"] == "allow-scripts"
    assert frame["srcdoc"] == hk.view(MESH, {evil: np.arange(9.0)}, title=evil).html
    assert "height:321px" in str(frame["style"])
    assert frame["title"] == evil
    assert output.tags == {"div", "b", "iframe"}
    assert "9 vertices, 8 triangles" in output.text  # where frames are left out


def test_surfaces_show_themselves():
    for surface in (MESH, patchwork()):
        (frame,) = Frames(surface._repr_html_()).frames
        assert frame["srcdoc"] == hk.view(surface).html
    assert repr(MESH) == "Mesh(9 vertices, 8 faces)"


def test_large_surfaces_show_themselves_when_asked(monkeypatch):
    monkeypatch.setattr(view, "OF_ITSELF", 7)
    output = Frames(MESH._repr_html_())
    assert not output.frames
    assert "8 triangles" in output.text
    assert "Too large to be shown unasked; henkei.view(...) shows it." in output.text
    assert Frames(hk.view(MESH)._repr_html_()).frames


def test_figures_where_there_is_no_picture(no_viewer):
    for shown in (MESH, hk.view(MESH)):
        output = Frames(shown._repr_html_())
        assert not output.frames
        assert "9 vertices, 8 triangles, 2 × 2 × 1, open, 1 boundary loop" in output.text
        assert "install Node.js" in output.text
    with pytest.raises(MissingDependency, match=r"install Node\.js"):
        _ = hk.view(MESH).html


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        (np.zeros((0, 3)), []),
        (np.eye(3), []),
        (np.full((3, 3), np.nan), [[0, 1, 2]]),
        (np.full((3, 3), np.inf), [[0, 1, 2]]),
        (np.eye(3) * 1e300, [[0, 1, 2]]),
        (np.eye(3), [[0, 0, 0]]),
        (np.zeros((3, 3)), [[0, 1, 2], [0, 1, 2], [0, 1, 2]]),
    ],
)
def test_no_surface_raises_in_a_notebook(vertices, faces):
    assert "Mesh" in hk.Mesh(vertices, faces)._repr_html_()


def test_faces_of_two_corners_do_not_raise():
    assert hk.PolygonMesh.from_faces(np.eye(3), [[0, 1], [0, 1, 2], []])._repr_html_()


def test_what_cannot_say_what_it_shows_says_what_it_is():
    class Broken:
        def _scene_(self):
            raise RuntimeError("no")

        def __repr__(self):
            return "<Broken>"

    assert view.represented(Broken()) == "&lt;Broken&gt;"


def test_it_is_kept_whole_or_not_at_all(tmp_path):
    shown = hk.view(MESH)
    shown.write(tmp_path / "a.html")
    shown.write(str(tmp_path / "b.HTM"))
    assert (tmp_path / "a.html").read_text("utf-8") == shown.html
    with pytest.raises(InvalidInput, match=r"the ending \.html"):
        shown.write(tmp_path / "a.png")
    with pytest.raises(InvalidInput, match="does not exist"):
        shown.write(tmp_path / "nowhere/a.html")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.html", "b.HTM"]


def test_repr_is_short():
    assert repr(hk.view(MESH)).startswith("View(9 vertices, 8 faces; ")


@pytest.fixture
def opened(monkeypatch, tmp_path) -> list[str]:
    """Addresses that a browser was asked for; temporary files go to ``tmp_path``."""
    asked: list[str] = []
    monkeypatch.setattr(view.webbrowser, "open", lambda address: asked.append(address) or True)
    monkeypatch.setattr(view.tempfile, "mkdtemp", lambda prefix: str(tmp_path))
    return asked


def test_a_browser_opens_where_there_is_a_display(opened, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(view, "_has_display", lambda: True)
    hk.view(MESH).show()
    assert opened == [(tmp_path / "view.html").as_uri()]
    assert (tmp_path / "view.html").read_text("utf-8") == hk.view(MESH).html
    assert capsys.readouterr().out == ""


def test_without_a_display_it_says_what_to_do(opened, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    hk.view(MESH).show()
    said = capsys.readouterr().out
    assert opened == []
    assert said.startswith(str(tmp_path / "view.html"))
    assert "no display here" in said


@pytest.mark.parametrize(
    ("platform", "variables", "there"),
    [
        ("linux", {"DISPLAY": ":0"}, True),
        ("linux", {"WAYLAND_DISPLAY": "wayland-0"}, True),
        ("linux", {}, False),
        ("darwin", {}, True),
        ("darwin", {"SSH_CONNECTION": "a"}, False),
        ("win32", {}, True),
    ],
)
def test_displays(platform, variables, there, monkeypatch):
    monkeypatch.setattr(sys, "platform", platform)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SSH_CONNECTION"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert view._has_display() == there


def test_in_a_notebook_it_is_shown_there(opened, monkeypatch):
    shown: list[object] = []
    shell = type("ZMQInteractiveShell", (), {})()
    notebook = types.SimpleNamespace(get_ipython=lambda: shell)
    display = types.SimpleNamespace(display=shown.append)
    monkeypatch.setitem(sys.modules, "IPython", notebook)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    one = hk.view(MESH)
    one.show()
    assert shown == [one]
    assert opened == []


def test_showing_loads_little():
    code = "import sys, henkei as hk; hk.Mesh([[0,0,0],[1,0,0],[0,1,0]], [[0,1,2]])._repr_html_();"
    code += "hk.view; print({'pydantic', 'trimesh', 'pyvista', 'matplotlib', 'IPython'}"
    code += " & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
