"""A person's way through the combine tab, by mouse and keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import henkei as hk
from driven import Driven
from henkei.shapes import random_disk
from henkei.workflows.morph_by_recipe import swept
from sheets import plate

A, B = random_disk(0, 200, wavy=0.2), random_disk(1, 240)
RIM_A, RIM_B = (mesh.topology.boundary_loops[0] for mesh in (A, B))
EXACT = 1e-6  # of the size: positions are drawn in single precision


def opened(page: Driven, folder: Path, a: hk.Mesh = A, b: hk.Mesh = B) -> None:
    page.open_tab("Combine")
    page.draw(False)
    page.open_mesh(a, folder / "wavy.ply")
    page.open_mesh(b, folder / "disk.ply")


def view(page: Driven) -> dict[str, Any]:
    found: dict[str, Any] = page.tab("combine")["view"]
    return found


def pairs(page: Driven, kind: str = "pairs") -> list[list[int]]:
    return [[row["a"], row["b"]] for row in view(page)[kind]]


def combined(page: Driven) -> hk.CombinedMesh:
    """What was made, once it is there and shown."""
    page.until(lambda: (view(page).get("result") or {}).get("current"), "the combined mesh")
    page.settle()
    result: hk.CombinedMesh = page.studio.blobs.result(
        page.tab("combine")["state"]["result"]["result"]
    )
    return result


def at_angle(mesh: hk.Mesh, rim: Any, degrees: float) -> int:
    """The boundary vertex in a direction, seen along z."""
    x, y, _ = mesh.vertices[rim].T
    away = np.angle(np.exp(1j * (np.arctan2(y, x) - np.radians(degrees))))
    return int(rim[np.abs(away).argmin()])


def nearest_on_screen(page: Driven, key: str, viewport: int, rim: Any, x: float, y: float) -> int:
    places = np.array([page.project(key, vertex, viewport) for vertex in rim])
    return int(rim[np.linalg.norm(places - (x, y), axis=1).argmin()])


def mark(page: Driven, first: tuple[str, int], second: tuple[str, int]) -> None:
    for key, vertex in (first, second):
        page.click_vertex(key, vertex, "ab".index(key))


def to_time(page: Driven, time: float) -> None:
    field = page.page.get_by_label("Time value")
    field.fill(str(time))
    field.press("Enter")
    page.settle()


def drawn_at(page: Driven, time: float) -> np.ndarray:
    to_time(page, time)
    return page.positions("morph")


def stopped(page: Driven) -> None:
    """Wait until the morph that plays by itself is at its end."""
    page.until(lambda: page.button("Play").count() == 1, "the morph to end")


def assert_near(drawn: np.ndarray, expected: np.ndarray, tolerance: float = EXACT) -> None:
    assert np.abs(drawn - expected).max() <= tolerance * np.ptp(expected)


def test_two_meshes_are_marked_combined_and_morphed(page: Driven, tmp_path: Path) -> None:
    opened(page, tmp_path)
    assert pairs(page) == hk.combine(A, B).pairs.tolist()
    page.button("Clear pairs").click()
    page.settle()
    assert page.button("Combine").is_disabled()
    assert "at least three are needed" in page.page.get_by_role("alert").inner_text()

    # boundary pairs: left and right, the other way around, and beside a vertex
    chosen = [[at_angle(A, RIM_A, d), at_angle(B, RIM_B, d)] for d in (20, 110, 200, 290)]
    mark(page, ("a", chosen[0][0]), ("b", chosen[0][1]))
    mark(page, ("b", chosen[2][1]), ("a", chosen[2][0]))
    page.click_vertex("a", chosen[1][0])
    assert "partner on the right" in page.hint()
    x, y = page.project("b", chosen[1][1], 1)
    snapped = nearest_on_screen(page, "b", 1, RIM_B, x + 9, y - 12)
    page.click(x + 9, y - 12)
    assert pairs(page) == [chosen[0], chosen[2], [chosen[1][0], snapped]]
    assert page.button("Combine").is_enabled()

    # a mark is dragged along the boundary
    x, y = page.project("b", snapped, 1)
    to = page.project("b", chosen[1][1], 1)
    page.draw(True)  # so that the new mark is in its place
    page.drag([(x, y), ((x + to[0]) / 2, (y + to[1]) / 2 + 9), to])
    assert pairs(page)[2] == chosen[1]
    page.draw(False)
    page.press("Control+z")
    assert pairs(page)[2][1] == snapped
    page.press("Control+Shift+z")

    # landmarks inside
    inner_a = int(np.linalg.norm(A.vertices[:, :2] - (0.2, 0.1), axis=1).argmin())
    inner_b = int(np.linalg.norm(B.vertices[:, :2] - (0.25, 0.1), axis=1).argmin())
    page.press("l")
    mark(page, ("a", inner_a), ("b", inner_b))
    assert pairs(page, "landmarks") == [[inner_a, inner_b]]

    page.page.keyboard.press("Enter")
    c = combined(page)
    again = hk.combine_by_recipe(A, B, page.recipe("combine"))
    assert np.array_equal(c.vertices_b, again.vertices_b)
    assert np.array_equal(c.faces, again.faces)
    assert c.vertex_of_a[inner_a] == c.vertex_of_b[inner_b]
    stopped(page)
    for time in (0.0, 0.3, 1.0):
        assert_near(drawn_at(page, time), c.at(time).vertices)

    # the same after loading the page anew, and scrubbing sends nothing
    heard: list[Any] = []
    page.page.on("websocket", lambda socket: socket.on("framereceived", lambda m: heard.append(m)))
    page.load()
    page.draw(False)
    page.press("m")
    assert_near(drawn_at(page, 0.6), c.at(0.6).vertices)
    before = len(heard)
    assert before > 0
    for time in (0.2, 0.7, 0.9):
        assert_near(drawn_at(page, time), c.at(time).vertices)
    assert len(heard) == before


@pytest.fixture
def made(page: Driven, tmp_path: Path) -> hk.CombinedMesh:
    """Both are combined by proposed pairs, and the morph is looked at, halfway."""
    page.page.emulate_media(reduced_motion="reduce")
    opened(page, tmp_path)
    page.button("Combine").click()
    c = combined(page)
    page.until(lambda: page.page.get_by_label("Time value").input_value() == "0.5")
    assert_near(page.positions("morph"), c.at(0.5).vertices)
    return c


def test_the_morph_turns_and_sweeps_as_recipes_say(page: Driven, made: hk.CombinedMesh) -> None:
    page.page.get_by_role("radio", name="Eased").click()
    page.settle()
    assert_near(drawn_at(page, 0.3), made.at(0.3, time="smoothstep").vertices)
    page.page.get_by_label("Changes first").select_option("right")
    page.settle()
    delay = swept(made.vertices_a, "right")
    swept_at = made.at(0.4, time="smoothstep", delay=delay)
    assert_near(drawn_at(page, 0.4), swept_at.vertices)
    page.page.get_by_role("radio", name="Turning").click()
    page.until(lambda: view(page)["result"]["turning"], "the turning path")
    page.settle()
    turned = made.at(0.4, path="rotation", time="smoothstep", delay=delay)
    assert not np.allclose(turned.vertices, swept_at.vertices, atol=1e-3)
    assert_near(drawn_at(page, 0.4), turned.vertices, 1e-5)
    assert_near(drawn_at(page, 1.0), made.vertices_b)
    assert page.recipe("combine")["morph"]["path"] == "rotation"
    page.press("Control+z")
    assert_near(drawn_at(page, 0.4), swept_at.vertices)

    page.page.keyboard.press("Space")
    page.until(lambda: page.button("Pause").count() == 1)
    now = page.page.get_by_label("Time value").input_value()
    page.until(lambda: page.page.get_by_label("Time value").input_value() != now)
    page.page.keyboard.press("Space")
    stopped(page)


def test_the_result_is_seen_flattened_and_on_both(page: Driven, made: hk.CombinedMesh) -> None:
    plane = made.plane_vertices / 2.0**61
    page.press("p")
    for viewport, key in enumerate(("plane a", "plane b")):
        flat = page.positions(key, viewport)
        assert np.abs(flat[:, :2] - plane).max() <= 1e-6
        assert not flat[:, 2].any()
    page.page.get_by_label("Mark pairs").click()
    page.settle()
    page.draw(True)
    x, y = page.project("disk", int(made.vertex_of_a[made.pairs[0, 0]]))
    assert page.page.locator(".viewer-mark:not(.viewer-hidden)").count() == 2 * len(made.pairs)
    left, top, width, height = page.stage_box()
    assert left < x < left + width / 2
    assert top < y < top + height
    page.draw(False)
    page.page.get_by_label("Overlay").click()
    page.settle()
    assert page.positions("plane b", 0).shape == (len(plane), 3)
    assert "edges of b" in page.page.locator(".viewer-legend").first.inner_text()

    page.press("s")
    page.page.get_by_label("Combined mesh").click()
    page.settle()
    assert_near(page.positions("edges of a", 0), made.vertices_a)
    assert_near(page.positions("edges of b", 1), made.vertices_b)
    assert page.camera(0)["position"] != page.camera(1)["position"]  # each in its own unit
    page.page.get_by_label("Combined mesh").click()

    page.press("m")
    page.page.get_by_label("Colour by").select_option("Growth from a to b")
    page.settle()
    assert "Growth" in page.page.locator(".viewer-legend").first.inner_text()
    rows = page.page.get_by_label("Figures of the combined mesh").inner_text()
    assert "Euler characteristic\n1" in rows
    to_time(page, 0.5)
    page.button("Keep shape").click()
    page.until(lambda: len(page.state["meshes"]) == 3)
    kept = page.studio.blobs.surface(page.state["meshes"][2]["surface"])
    assert_near(kept.vertices, made.at(0.5).vertices, 1e-12)


def test_linked_cameras_turn_together_until_they_are_let_go(page: Driven, tmp_path: Path) -> None:
    opened(page, tmp_path)
    left, top, width, height = page.stage_box()
    way = [(left + 0.1 * width, top + 0.9 * height), (left + 0.2 * width, top + 0.8 * height)]

    def directions() -> list[np.ndarray]:
        cameras = [page.camera(viewport) for viewport in (0, 1)]
        ways = [np.subtract(one["position"], one["target"]) for one in cameras]
        return [one / np.linalg.norm(one) for one in ways]

    before = directions()
    page.drag(way)
    together = directions()
    assert not np.allclose(before[0], together[0], atol=0.01)
    assert np.allclose(*together)
    page.page.get_by_label("Link cameras").click()
    page.settle()
    page.drag(way)
    apart = directions()
    assert np.allclose(apart[1], together[1])
    assert not np.allclose(apart[0], together[0], atol=0.01)


def test_pairs_are_chosen_left_and_removed(page: Driven, tmp_path: Path) -> None:
    opened(page, tmp_path)
    start = pairs(page)
    page.page.get_by_role("list", name="Boundary pairs").get_by_text("Pair 2").click()
    assert page.page.locator(".viewer-mark.viewer-selected").count() == 2
    page.press("Delete")
    assert pairs(page) == start[:1] + start[2:]
    free = next(vertex for vertex in RIM_A if vertex not in [row[0] for row in start])
    page.click_vertex("a", int(free))
    assert "Now its partner" in page.hint()
    page.press("Escape")
    assert "Now its partner" not in page.hint()
    taken = start[0][1]
    page.button("Add by vertex number").click()
    for side, vertex in (("a", int(free)), ("b", taken)):
        field = page.page.get_by_label(f"Vertex of {side}")
        field.fill(str(vertex))
        field.press("Enter")
    page.button("Add").click()
    page.until(lambda: page.toasts() or None, "a refusal")
    assert f"vertex {taken} of b belongs to pair 1 already" in page.toasts()[0]
    assert len(pairs(page)) == len(start) - 1


def test_what_stands_in_the_way_comes_with_a_button(page: Driven, tmp_path: Path) -> None:
    soup = hk.Mesh(B.vertices[B.faces].reshape(-1, 3), np.arange(3 * len(B.faces)).reshape(-1, 3))
    opened(page, tmp_path, plate(8, 0.4), soup)
    assert page.button("Combine").is_disabled()
    assert "2 boundary loops" in page.page.get_by_role("alert").inner_text()
    page.button("Fill holes").click()
    page.until(lambda: view(page)["trouble"]["side"] == "b")
    page.settle()
    page.button("Weld duplicate vertices").click()
    page.until(lambda: view(page)["ready"])
    page.settle()
    page.button("Combine").click()
    c = combined(page)
    assert c.quality.filled_a == 1
    assert (c.face_on_a < 0).any()
