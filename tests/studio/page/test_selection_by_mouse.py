"""What the mouse selects is what an independent computation finds, vertex by vertex.

The oracle projects and casts rays in NumPy by itself: from the camera that the page tells, and the
pixels that the mouse was at.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import henkei as hk
from data import real
from driven import Driven
from henkei.shapes import bumper, bumper_parts, head, icosphere

Floats = NDArray[np.float64]
Way = list[tuple[float, float]]

CELL = 16  # pixels


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
        self.cells: dict[tuple[int, int], list[int]] = {}
        low, high = (np.floor(end / CELL).astype(int).tolist() for end in (self.low, self.high))
        for triangle, ((left, top), (right, bottom)) in enumerate(zip(low, high, strict=True)):
            for x in range(left, right + 1):
                for y in range(top, bottom + 1):
                    self.cells.setdefault((x, y), []).append(triangle)

    def near(self, x: float, y: float) -> NDArray[np.int64]:
        """The triangles that may be seen at a pixel."""
        found = self.cells.get((int(np.floor(x / CELL)), int(np.floor(y / CELL))), [])
        return np.array(found, dtype=np.int64)

    def clicked(self, x: float, y: float) -> int | None:
        """The corner nearest to a pixel, of the first triangle behind it; None for none."""
        near = self.near(x, y)
        distance = self._met(near, self.eye.ray(x, y))
        if not np.isfinite(distance).any():
            return None
        corners = self.triangles[near[np.argmin(distance)]]
        return int(corners[np.linalg.norm(self.pixels[corners] - (x, y), axis=1).argmin()])

    def inside(self, way: Way) -> NDArray[np.int64]:
        """The visible vertices that a closed way goes around."""
        used = np.unique(self.triangles)
        enclosed = used[winding(np.array(way), self.pixels[used]) != 0]
        return enclosed[~self.hidden(enclosed)]

    def hidden(self, vertices: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether a triangle that they do not have is between the eye and vertices (k,)."""
        near = [self.near(x, y) for x, y in self.pixels[vertices].tolist()]
        row = np.repeat(np.arange(len(vertices)), [len(some) for some in near])
        triangle = np.concatenate([np.empty(0, np.int64), *near])
        apart = (self.triangles[triangle] != vertices[row, None]).all(axis=1)
        row, triangle = row[apart], triangle[apart]
        toward = self.points[vertices[row]] - self.eye.position
        found = np.zeros(len(vertices), dtype=bool)
        found[row[self._met(triangle, toward) < 1 - 1e-9]] = True
        return found

    def _met(self, near: NDArray[np.int64], direction: Floats) -> Floats:
        """How far along a ray from the eye each triangle is, infinity if it is not met.

        After Moeller and Trumbore; there is one ray (3,), or one for each triangle.
        """
        a, b, c = (self.points[self.triangles[near, k]] for k in range(3))
        u_axis, v_axis, to = b - a, c - a, self.eye.position - a
        direction = np.broadcast_to(direction, a.shape)
        normal, across = np.cross(direction, v_axis), np.cross(to, u_axis)
        volume = (u_axis * normal).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (to * normal).sum(axis=1) / volume
            v = (across * direction).sum(axis=1) / volume
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


def free(eye: Eye, places: Floats) -> Floats:
    """Whole pixels on the stage, beside its toolbars, near to places (n, 2)."""
    left, top, width, height = eye.box
    return np.clip(np.rint(places), (left + 70, top + 60), (left + width - 5, top + height - 5))


def over(oracle: Oracle, rng: np.random.Generator) -> tuple[float, float]:
    """A pixel somewhere in the picture of the surface."""
    place = rng.uniform(oracle.pixels.min(axis=0), oracle.pixels.max(axis=0))
    x, y = free(oracle.eye, place).tolist()
    return x, y


def lasso(oracle: Oracle, rng: np.random.Generator) -> Way:
    """A closed way over the surface, often across itself."""
    centre, size = np.array(over(oracle, rng)), rng.uniform(60, 160)
    angles = np.linspace(0, 2 * np.pi * rng.integers(1, 3), 24, endpoint=False)
    radii = size * rng.uniform(0.35, 1, len(angles))
    way = centre + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return [(x, y) for x, y in free(oracle.eye, way).tolist()]


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
        page.page.mouse.click(x, y)
        wanted ^= {vertex}
        done += 1
        if done % 10 == 0:
            page.settle()
            assert selection(page).tolist() == sorted(wanted)
    page.settle()
    assert selection(page).tolist() == sorted(wanted)


def test_all_of_it_on_a_bumper(page: Driven, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    page.open_tab("Deform")
    page.open_mesh(bumper(), tmp_path / "bumper.obj")
    page.draw(False)
    turned(page, (60, 90))
    oracle = looked_at(page)
    try_rectangles(page, oracle, rng, 10)
    try_lassos(page, oracle, rng, 10)
    try_clicks(page, oracle, rng, 100)


def test_where_much_is_hidden(page: Driven, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    page.open_tab("Deform")
    page.open_mesh(head("goblin", resolution=0.5), tmp_path / "goblin.ply")
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
    try_rectangles(page, oracle, rng, 2)
    try_lassos(page, oracle, rng, 2)
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
    sphere = icosphere(3)
    page.open_mesh(sphere, tmp_path / "sphere.obj")
    page.draw(False)
    page.press("r")
    pixels = looked_at(page).pixels
    (left, top), (right, bottom) = pixels.min(axis=0).tolist(), pixels.max(axis=0).tolist()
    corners = (left - 3, top - 3), (right + 3, bottom + 3)
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
    x, y = np.rint(oracle.pixels[bumper_parts(2000)["handle"]].mean(axis=0)).tolist()
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
