"""A surface as a page: what is in it is what was given, and names in it do no harm."""

from __future__ import annotations

import base64
import gzip
import json
import struct
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput, MissingDependency, NotFinite
from henkei.io import html
from henkei.io import page as built
from henkei.io.packed import packed
from henkei.io.scene import Line, Mark, Scene, Slide, colouring
from written import patchwork, sheet, surfaces

EVIL = "</script><script>alert(1)</script>\"'<!--&"


@pytest.fixture(autouse=True)
def _viewer(monkeypatch):
    """The viewer need not be built to look into pages."""
    monkeypatch.setattr(html, "_bundle", lambda folder: (b"look", b"viewer"))
    monkeypatch.setattr(html, "page_folder", lambda: Path())


class Elements(HTMLParser):
    """The elements of a page, and the text in each."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data):
        tag, attributes = self.found[-1] if self.found else ("", {})
        name = attributes.get("id") or tag
        self.texts[name] = self.texts.get(name, "") + data


def unpacked(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[np.int64]]]:
    """Header and arrays, number by number."""
    plain = gzip.decompress(data)
    (length,) = struct.unpack_from("<I", plain)
    header = json.loads(plain[4 : 4 + length])
    at, found = 4 + length, {}
    for name, (rows, columns, width) in header["arrays"].items():
        size = rows * columns
        table = np.zeros((rows, columns), dtype=np.int64)
        for column in range(columns):
            value = 0
            for row in range(rows):
                place = at + column * rows + row
                number = sum(plain[place + k * size] << (8 * k) for k in range(width))
                value += -(number + 1) // 2 if number % 2 else number // 2
                table[row, column] = value
        found[name] = table
        at += size * width
    assert at == len(plain)
    return header, found


def shown(scene: Scene) -> tuple[dict[str, Any], dict[str, NDArray[np.int64]]]:
    """What the viewer gets of a scene, by way of its page."""
    text = b"".join(html.page(scene)).decode()
    return unpacked(base64.b64decode(Elements(text).texts["surface"]))


def places(header: dict[str, Any], codes: NDArray[np.int64]) -> NDArray[np.float64]:
    """Vertices as the viewer has them."""
    low, step = np.array(header["positions"]["low"]), header["positions"]["step"]
    return np.array(header["centre"]) + header["scale"] * (low + step * codes)


@settings(max_examples=60, deadline=None)
@given(
    arrays.arrays(
        np.int64,
        st.tuples(st.integers(0, 20), st.integers(1, 3)),
        elements=st.integers(-(2**30) + 1, 2**30 - 1),
    )
)
def test_whole_numbers_come_back(table):
    header, found = unpacked(packed({"a": "ü"}, {"one": table, "two": table[:, :1]}))
    assert header["a"] == "ü"
    assert np.array_equal(found["one"], table)
    assert np.array_equal(found["two"], table[:, :1])


@settings(max_examples=60, deadline=None)
@given(surfaces(coordinates=st.floats(-1e6, 1e6)))
def test_any_surface_is_in_its_page(surface):
    header, found = shown(Scene.of(surface))
    half = header["positions"]["step"] * header["scale"] / 2
    used = np.unique(surface.indices)
    apart = np.abs(places(header, found["positions"]) - surface.vertices)[used]
    assert apart.max() <= half * (1 + 1e-6) + 1e-9
    triangles = found["triangles"].reshape(-1, 3)
    if isinstance(surface, hk.Mesh):
        assert np.array_equal(triangles, surface.faces)
        assert "face" not in found
    else:
        sizes = np.diff(surface.offsets)
        assert np.array_equal(np.bincount(found["face"].ravel()), sizes - 2)
        for triangle, face in zip(triangles, found["face"].ravel(), strict=True):
            corners = surface.indices[surface.offsets[face] : surface.offsets[face + 1]]
            assert set(triangle) <= set(corners)


def test_far_from_the_origin_nothing_is_lost():
    mesh = hk.shapes.icosphere(3)
    far = hk.Mesh(mesh.vertices + 1e7, mesh.faces)
    header, found = shown(Scene.of(far))
    assert np.abs(places(header, found["positions"]) - far.vertices).max() < 1e-3


def test_rounding_is_a_small_part_of_an_edge():
    for level in (2, 5):
        mesh = hk.shapes.icosphere(level)
        header, _ = shown(Scene.of(mesh))
        ends = mesh.vertices[mesh.topology.edges]
        shortest = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).min()
        assert header["positions"]["step"] * header["scale"] < shortest / 200


def test_values_come_with_their_limits_and_gaps():
    mesh = sheet()
    height = mesh.vertices[:, 2].copy()
    height[3] = np.nan
    labels = np.array([5, -1, 5, 900, 5, 5, -1, 5, 5])
    per_face = np.linspace(-2, 1, 8)
    rgb = np.tile([1.0, 0.5, 0.0], (9, 1))
    table = {"height": height, "labels": labels, "face": per_face, "rgb": rgb}
    header, found = shown(Scene.of(mesh).coloured(table))
    first, second, third, fourth = header["colourings"]
    known = ~np.isnan(height)
    codes = [found[f"colouring {k}"][:, 0] for k in range(3)]
    drawn = first["low"][0] + first["step"] * codes[0]
    assert drawn[known] == pytest.approx(height[known], abs=1e-4)
    assert codes[0][3] == -1
    assert (first["min"], first["max"]) == (np.nanmin(height), np.nanmax(height))
    assert first["colormap"] == "viridis"
    assert np.array_equal(second["low"][0] + second["step"] * codes[1], labels)
    assert second["kind"] == "labels"
    assert second["labels"] == [{"value": v, "name": str(v)} for v in (-1, 5, 900)]
    assert (third["per"], third["kind"]) == ("face", "values")
    assert third["low"][0] + third["step"] * codes[2] == pytest.approx(per_face, abs=1e-4)
    assert fourth["kind"] == "rgb"
    assert found["colouring 3"].tolist() == [[255, 128, 0]] * 9
    assert header["shown"] == 0


@pytest.mark.parametrize("value", [0.0, 1.5, np.nan, 1e300, -5e-324])
def test_values_that_are_all_the_same(value):
    values = np.full(9, value)
    header, found = shown(Scene.of(sheet()).coloured({"same": values}))
    (one,) = header["colourings"]
    codes = found["colouring 0"][:, 0]
    if np.isnan(value):
        assert (codes == -1).all()
    else:
        assert np.array_equal(one["low"][0] + one["step"] * codes, values)


@settings(max_examples=60, deadline=None)
@given(arrays.arrays(np.float64, 9, elements=st.floats(-8e307, 8e307)))
def test_values_are_right_to_a_part_of_their_range(values):
    header, found = shown(Scene.of(sheet()).coloured({"any": values}))
    (one,) = header["colourings"]
    drawn = one["low"][0] + one["step"] * found["colouring 0"][:, 0].astype(float)
    assert (np.abs(drawn - values) <= (np.max(values) - np.min(values)) / 1e5 + 5e-324).all()


def test_slides_marks_and_lines():
    mesh = sheet()
    move = np.random.default_rng(0).standard_normal((9, 3))
    scene = Scene(
        mesh,
        slides=(Slide("bend", move, -2.0, 2.0, 0.5),),
        marks=(Mark(4, "here"), Mark(np.array([1.0, 2.0, 3.0]))),
        lines=(Line(np.array([0, 1, 2])), Line(np.eye(3), "#ff0000", closed=True)),
        creases=np.array([[0, 1]]),
    )
    header, found = shown(scene)
    (slide,) = header["slides"]
    drawn = slide["step"] * found["slide 0"] * header["scale"]
    assert np.abs(drawn - move).max() <= header["positions"]["step"] * header["scale"]
    assert (slide["from"], slide["to"], slide["start"]) == (-2, 2, 0.5)
    assert [mark["place"] for mark in header["marks"]] == [4, [1, 2, 3]]
    assert header["lines"][0]["places"] == [0, 1, 2]
    assert header["lines"][1]["places"] == np.eye(3).tolist()
    assert found["creases"].ravel().tolist() == [0, 1]


def test_names_and_titles_do_no_harm():
    mesh = sheet()
    attributes = hk.Attributes(vertex={EVIL: np.arange(9.0)})
    hostile = hk.Mesh(mesh.vertices, mesh.faces, attributes=attributes)
    scene = Scene.of(hostile, title=EVIL, marks=(Mark(0, EVIL),))
    text = b"".join(html.page(scene)).decode()
    harmless = Elements(b"".join(html.page(Scene.of(mesh))).decode())
    elements = Elements(text)
    assert elements.found == harmless.found
    assert elements.texts["title"] == EVIL
    header, _ = unpacked(base64.b64decode(elements.texts["surface"]))
    assert (header["title"], header["colourings"][0]["name"]) == (EVIL, EVIL)


def test_a_page_may_load_nothing():
    elements = Elements(b"".join(html.page(Scene.of(sheet()))).decode())
    policies = [a["content"] for _, a in elements.found if a.get("http-equiv")]
    assert len(policies) == 1
    assert str(policies[0]).startswith("default-src 'none'")
    assert not any("src" in a or "href" in a for _, a in elements.found)


def test_equal_surfaces_give_equal_bytes(tmp_path):
    hk.write(tmp_path / "one.html", patchwork())
    hk.write(tmp_path / "one.htm", patchwork())
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "one.htm").read_bytes()


def test_figures_without_a_picture():
    assert html.figures(hk.shapes.icosphere(2)) == (
        "<b>Mesh</b>: 162 vertices, 320 triangles, 2 × 2 × 2, closed"
    )
    assert "open, 1 boundary loop" in html.figures(sheet())
    assert "PolygonMesh</b>: 7 vertices, 3 faces" in html.figures(patchwork())
    two = hk.Mesh(np.random.default_rng(0).random((6, 3)), [[0, 1, 2], [3, 4, 5]])
    assert "2 boundary loops, 2 pieces" in html.figures(two)
    fan = hk.Mesh(np.random.default_rng(0).random((5, 3)), [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert "not manifold" in html.figures(fan)
    assert "&lt;b&gt;" in html.figures(sheet(), "<b>")


def test_what_cannot_be_written(tmp_path, monkeypatch):
    path = tmp_path / "a.html"
    path.write_text("before")
    with pytest.raises(InvalidInput, match="a page has one form"):
        hk.write(path, sheet(), text=True)
    with pytest.raises(InvalidInput, match="no faces"):
        hk.write(path, hk.Mesh(np.eye(3), []))
    with pytest.raises(InvalidInput, match="coordinates beyond 1e"):
        hk.write(path, hk.Mesh(1e200 * np.eye(3), [[0, 1, 2]]))
    with pytest.raises(NotFinite):
        hk.write(path, hk.Mesh([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]]))
    monkeypatch.setattr(html, "MOST_FACES", 7)
    with pytest.raises(InvalidInput, match=r"8 faces, a page shows at most 7"):
        hk.write(path, sheet())
    monkeypatch.undo()
    monkeypatch.setattr(built, "_FOLDER", tmp_path / "nowhere")
    with pytest.raises(MissingDependency, match=r"install Node\.js"):
        hk.write(path, sheet())
    assert path.read_text() == "before"
    assert [one.name for one in tmp_path.iterdir()] == ["a.html"]


def test_half_a_viewer_is_none(tmp_path, monkeypatch):
    monkeypatch.undo()
    (tmp_path / "viewer.js").write_text("")
    with pytest.raises(MissingDependency, match="make studio"):
        html._bundle(tmp_path)


def test_the_licences_go_with_the_viewer(tmp_path, monkeypatch):
    monkeypatch.undo()
    for name, text in (("viewer.js", "x()"), ("viewer.css", "y"), ("licences.txt", "MIT */ *")):
        (tmp_path / name).write_text(text)
    look, viewer = html._bundle(tmp_path)
    assert gzip.decompress(look) == b"y"
    assert gzip.decompress(viewer) == b"/*\nMIT * / *\n*/\nx()"


def test_a_page_is_not_read(tmp_path):
    hk.write(tmp_path / "a.html", sheet())
    with pytest.raises(InvalidFile, match="to be looked at"):
        hk.read(tmp_path / "a.html")


def test_vertices_without_a_position_are_out_of_the_way():
    mesh = sheet()
    vertices = np.vstack([mesh.vertices, [[np.nan, np.inf, 0.0]]])
    header, found = shown(Scene.of(hk.Mesh(vertices, mesh.faces)))
    drawn = places(header, found["positions"])
    assert drawn[-1, :2] == pytest.approx(np.array(header["centre"])[:2], abs=1e-4)
    assert drawn[:-1] == pytest.approx(mesh.vertices, abs=1e-3)


def test_one_point_is_no_obstacle():
    header, _ = shown(Scene.of(hk.Mesh(np.ones((3, 3)), [[0, 1, 2]])))
    assert header["scale"] == 1.0


def test_attributes_of_results_are_checked_when_they_are_given():
    with pytest.raises(InvalidInput, match="infinite"):
        colouring("x", np.full(9, np.inf), sheet())
