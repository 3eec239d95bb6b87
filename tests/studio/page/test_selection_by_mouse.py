"""What the mouse selects is what an independent computation finds, vertex by vertex.

The oracle projects and casts rays in NumPy by itself: from the camera that the page tells, and the
pixels that the mouse was at.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from data import real
from driven import Driven
from numpy.typing import NDArray

import henkei as hk
from henkei.shapes import bumper, head

Floats = NDArray[np.float64]
Way = list[tuple[float, float]]


@dataclass
class Eye:
    """A camera and the place of its picture on the page."""

    camera: dict[str, Any]
    box: tuple[float, float, float, float]

    def __post_init__(self) -> None:
        self.position = np.array(self.camera["position"])
        ahead = np.array(self.camera["target"]) - self.position
        self.ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(self.ahead, self.camera["up"])
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.right, self.ahead)
        self.focal = self.box[3] / 2 / np.tan(np.radians(self.camera["field_of_view"]) / 2)

    def pixels(self, points: Floats) -> Floats:
        """Where points (n, 3) are on the page (n, 2)."""
        seen = points - self.position
        across, upward, depth = (seen @ axis for axis in (self.right, self.up, self.ahead))
        left, top, width, height = self.box
        x = left + width / 2 + self.focal * across / depth
        return np.stack([x, top + height / 2 - self.focal * upward / depth], axis=1)

    def ray(self, x: float, y: float) -> Floats:
        """The direction (3,) in which a pixel is seen."""
        left, top, width, height = self.box
        across, upward = x - left - width / 2, top + height / 2 - y
        return self.ahead + (across * self.right + upward * self.up) / self.focal


@dataclass
class Oracle:
    """A surface of triangles, looked at."""

    points: Floats
    triangles: NDArray[np.int64]
    eye: Eye

    def __post_init__(self) -> None:
        self.pixels = self.eye.pixels(self.points)
        corners = self.pixels[self.triangles]
        self.low, self.high = corners.min(axis=1), corners.max(axis=1)

    def clicked(self, x: float, y: float) -> int | None:
        """The corner nearest to a pixel, of the first triangle behind it; None for none."""
        near = np.flatnonzero(((self.low <= (x, y)) & (self.high >= (x, y))).all(axis=1))
        distance = self._met(near, self.eye.position, self.eye.ray(x, y))
        if not np.isfinite(distance).any():
            return None
        corners = self.triangles[near[np.argmin(distance)]]
        return int(corners[np.linalg.norm(self.pixels[corners] - (x, y), axis=1).argmin()])

    def inside(self, way: Way) -> NDArray[np.int64]:
        """The visible vertices that a closed way goes around."""
        used = np.unique(self.triangles)
        enclosed = used[winding(np.array(way), self.pixels[used]) != 0]
        return np.array([v for v in enclosed if not self.hides(int(v))], dtype=np.int64)

    def hides(self, vertex: int) -> bool:
        """Whether a triangle is between the eye and a vertex that it does not have."""
        pixel, point = self.pixels[vertex], self.points[vertex]
        over = ((self.low <= pixel) & (self.high >= pixel)).all(axis=1)
        near = np.flatnonzero(over & (self.triangles != vertex).all(axis=1))
        distance = self._met(near, self.eye.position, point - self.eye.position)
        return bool((distance < 1 - 1e-9).any())

    def _met(self, near: NDArray[np.int64], origin: Floats, direction: Floats) -> Floats:
        """How far along a ray each triangle is met, infinity for not; after Moeller, Trumbore."""
        a, b, c = (self.points[self.triangles[near, k]] for k in range(3))
        u_axis, v_axis = b - a, c - a
        normal = np.cross(np.broadcast_to(direction, v_axis.shape), v_axis)
        volume = (u_axis * normal).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            to = origin - a
            u = (to * normal).sum(axis=1) / volume
            across = np.cross(to, u_axis)
            v = (across @ direction) / volume
            distance = (v_axis * across).sum(axis=1) / volume
        met = (volume != 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
        return np.where(met, distance, np.inf)


def winding(way: Floats, points: Floats) -> NDArray[np.int64]:
    """How often a closed way goes around points (n, 2): the angle it is seen under, in turns."""
    turned = np.zeros(len(points))
    for start, end in zip(way, np.roll(way, -1, axis=0), strict=True):
        (ax, ay), (bx, by) = (start - points).T, (end - points).T
        turned += np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    return np.rint(turned / (2 * np.pi)).astype(np.int64)


def looked_at(page: Driven) -> Oracle:
    """The surface as the page shows it."""
    surface = page.studio.blobs.surface(page.state["meshes"][0]["surface"])
    triangles = np.array(hk.Mesh.from_any(surface).faces, dtype=np.int64)
    return Oracle(surface.vertices, triangles, Eye(page.camera(), page.stage_box()))


def turned(page: Driven, by: tuple[float, float]) -> None:
    """Turn the view by a drag with the right button."""
    left, top, width, height = page.stage_box()
    x, y = left + width / 2, top + height / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down(button="right")
    page.page.mouse.move(x + by[0] / 2, y + by[1] / 2)
    page.page.mouse.move(x + by[0], y + by[1])
    page.page.mouse.up(button="right")


def selection(page: Driven) -> NDArray[np.int64]:
    """The vertices that are selected."""
    return np.array(page.tab("deform")["state"]["selection"], dtype=np.int64)


def over(oracle: Oracle, rng: np.random.Generator) -> tuple[int, int]:
    """A whole pixel somewhere in the picture of the surface."""
    low, high = oracle.pixels.min(axis=0), oracle.pixels.max(axis=0)
    x, y = rng.uniform(low, high)
    return round(x), round(y)


def lasso(oracle: Oracle, rng: np.random.Generator) -> Way:
    """A closed way over the surface, often across itself."""
    centre, size = np.array(over(oracle, rng)), rng.uniform(60, 160)
    angles = np.linspace(0, 2 * np.pi * rng.integers(1, 3), 24, endpoint=False)
    radii = size * rng.uniform(0.35, 1, len(angles))
    way = centre + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    left, top, width, height = oracle.eye.box
    clipped = np.clip(np.rint(way), (left + 70, top + 5), (left + width - 5, top + height - 5))
    return [(x, y) for x, y in clipped.tolist()]


def try_rectangles(page: Driven, oracle: Oracle, rng: np.random.Generator, count: int) -> None:
    page.press("r")
    sizes = []
    while len(sizes) < count:
        (ax, ay), (bx, by) = over(oracle, rng), over(oracle, rng)
        if min(abs(ax - bx), abs(ay - by)) < 20:
            continue
        page.rectangle((ax, ay), (bx, by))
        wanted = oracle.inside([(ax, ay), (bx, ay), (bx, by), (ax, by)])
        np.testing.assert_array_equal(selection(page), wanted)
        sizes.append(len(wanted))
    assert max(sizes) > 100


def try_lassos(page: Driven, oracle: Oracle, rng: np.random.Generator, count: int) -> None:
    page.press("l")
    sizes = []
    for _ in range(count):
        way = lasso(oracle, rng)
        page.drag(way)
        kept = [way[0]]  # the page leaves out what is within two pixels of the corner before
        for x, y in way[1:]:
            if np.hypot(x - kept[-1][0], y - kept[-1][1]) >= 2:
                kept.append((x, y))
        wanted = oracle.inside(kept)
        np.testing.assert_array_equal(selection(page), wanted)
        sizes.append(len(wanted))
    assert max(sizes) > 20


def try_clicks(page: Driven, oracle: Oracle, rng: np.random.Generator, count: int) -> None:
    page.press("v")
    page.press("n")
    wanted: set[int] = set()
    done = 0
    while done < count:
        x, y = over(oracle, rng)
        vertex = oracle.clicked(x, y)
        if vertex is None:
            continue  # beside the surface, a click means the nearest vertex that is seen
        page.click(x, y)
        wanted ^= {vertex}
        done += 1
        if done % 10 == 0:
            assert selection(page).tolist() == sorted(wanted)
    assert selection(page).tolist() == sorted(wanted)


@pytest.mark.parametrize(("rectangles", "lassos", "clicks"), [(10, 10, 100)])
def test_all_of_it_on_a_bumper(
    page: Driven, tmp_path: Path, rectangles: int, lassos: int, clicks: int
) -> None:
    rng = np.random.default_rng(0)
    page.open_tab("Deform")
    page.open_mesh(bumper(), tmp_path / "bumper.obj")
    page.draw(False)
    turned(page, (60, 90))
    oracle = looked_at(page)
    try_rectangles(page, oracle, rng, rectangles)
    try_lassos(page, oracle, rng, lassos)
    try_clicks(page, oracle, rng, clicks)


def test_where_much_is_hidden(page: Driven, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    page.open_tab("Deform")
    page.open_mesh(head("goblin"), tmp_path / "goblin.ply")
    page.draw(False)
    turned(page, (-150, 40))
    oracle = looked_at(page)
    try_rectangles(page, oracle, rng, 2)
    try_lassos(page, oracle, rng, 2)
    try_clicks(page, oracle, rng, 10)


def test_on_a_scanned_face(page: Driven) -> None:
    rng = np.random.default_rng(2)
    page.open_tab("Deform")
    page.open_file(real("faces-disk/bff_face.obj"))
    page.draw(False)
    turned(page, (100, -30))
    oracle = looked_at(page)
    try_rectangles(page, oracle, rng, 3)
    try_lassos(page, oracle, rng, 3)
    try_clicks(page, oracle, rng, 10)


def test_shift_adds_and_control_takes_away(page: Driven, tmp_path: Path) -> None:
    page.open_tab("Deform")
    page.open_mesh(bumper(2000), tmp_path / "bumper.obj")
    page.draw(False)
    oracle = looked_at(page)
    centre = (oracle.pixels.min(axis=0) + oracle.pixels.max(axis=0)) / 2
    x, y = (float(round(part)) for part in centre)

    def box(dx: float, dy: float) -> Way:
        return [(x, y), (x + dx, y), (x + dx, y + dy), (x, y + dy)]

    page.press("r")
    page.rectangle((x, y), (x + 150, y + 60))
    page.rectangle((x, y), (x - 150, y + 60), ["Shift"])
    first, second = oracle.inside(box(150, 60)), oracle.inside(box(-150, 60))
    both = np.union1d(first, second)
    np.testing.assert_array_equal(selection(page), both)
    page.rectangle((x, y), (x + 150, y + 60), ["Control"])
    np.testing.assert_array_equal(selection(page), np.setdiff1d(both, first))
    page.press("Control+z")
    np.testing.assert_array_equal(selection(page), both)


def test_hidden_ones_are_selected_if_asked_for(page: Driven, tmp_path: Path) -> None:
    page.open_tab("Deform")
    sphere = hk.shapes.sphere(3)
    page.open_mesh(sphere, tmp_path / "sphere.obj")
    page.draw(False)
    page.press("r")
    left, top, width, height = page.stage_box()
    corners = (left + 70, top + 10), (left + width - 10, top + height - 60)
    page.rectangle(*corners)
    assert 0 < len(selection(page)) < 0.6 * len(sphere.vertices)
    page.page.get_by_role("switch", name="Hidden ones too").click()
    page.rectangle(*corners)
    assert len(selection(page)) == len(sphere.vertices)


def test_a_brush_selects_what_it_touches(page: Driven, tmp_path: Path) -> None:
    page.open_tab("Deform")
    page.open_mesh(bumper(2000), tmp_path / "bumper.obj")
    page.draw(False)
    oracle = looked_at(page)
    x, y = np.rint(oracle.pixels[hk.shapes.bumper_parts(2000)["handle"]].mean(axis=0)).tolist()
    page.press("b")
    page.drag([(x, y), (x + 5, y)])
    small = selection(page)
    hit = oracle.clicked(x, y)
    radius = 0.05 * np.linalg.norm(np.ptp(oracle.points, axis=0)) / 2
    assert hit in small
    reach = np.linalg.norm(oracle.points[small] - oracle.points[hit], axis=1).max()
    assert reach <= 1.3 * radius
    for _ in range(4):
        page.press("]")
    page.drag([(x, y), (x + 5, y)])
    assert len(selection(page)) > 1.5 * len(small)
    assert np.isin(small, selection(page)).all()
