"""What a picture shows is where it should be, in both ways of drawing, and the same every time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from data import real
from henkei.errors import DegenerateFaces, InvalidInput, MissingDependency, NotFinite
from henkei.io import drawing, pictures, read
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import grid, hemisphere

SMALL = {"size": (64, 48), "background": "#f6f5f2"}
GROUND = [246, 245, 242]
CUBE = PolygonMesh(
    np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]),
    np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]),
)


@pytest.fixture(params=["pyvista", "matplotlib"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "pyvista" and drawing.vtk_window() is None:
        pytest.skip("VTK finds nothing to draw with here")
    return request.param


def corners(pixels: np.ndarray) -> np.ndarray:
    return pixels[[0, 0, -1, -1], [0, -1, 0, -1]]


def middle(pixels: np.ndarray) -> np.ndarray:
    return pixels[pixels.shape[0] // 2, pixels.shape[1] // 2].astype(int)


@pytest.mark.parametrize("mesh", [hemisphere(3), CUBE], ids=["triangles", "quads"])
def test_the_mesh_is_in_the_middle_and_the_background_around(backend: str, mesh) -> None:
    pixels = pictures.render(mesh, backend=backend, **SMALL)
    assert pixels.shape == (48, 64, 3)
    assert pixels.dtype == np.uint8
    np.testing.assert_array_equal(corners(pixels), [GROUND] * 4)
    covered = (pixels != GROUND).any(axis=2)
    assert 0.2 < covered.mean() < 0.9
    rows, columns = np.nonzero(covered)
    np.testing.assert_allclose([rows.mean(), columns.mean()], [23.5, 31.5], atol=1.5)


def test_same_pixels_again(backend: str) -> None:
    first, again = (pictures.render(CUBE, backend=backend, **SMALL) for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_both_ways_of_drawing_agree_on_what_is_covered() -> None:
    if drawing.vtk_window() is None:
        pytest.skip("VTK finds nothing to draw with here")
    covered = [
        (pictures.render(CUBE, view="three-quarter", backend=name, **SMALL) != GROUND).any(axis=2)
        for name in ("pyvista", "matplotlib")
    ]
    assert np.mean(covered[0] != covered[1]) < 0.03  # the outline


def test_right_is_right_and_up_is_up(backend: str) -> None:
    mesh = grid(2, 2)
    color = np.column_stack([mesh.vertices[:, :2], np.zeros(9)])
    colored = Mesh(mesh.vertices, mesh.faces, attributes=Attributes(vertex={"color": color}))
    pixels = pictures.render(colored, backend=backend, **SMALL).astype(int)
    left, right, top, bottom = pixels[24, 18], pixels[24, 45], pixels[10, 32], pixels[38, 32]
    assert right[0] > left[0] + 40
    assert top[1] > bottom[1] + 40


def test_views_see_the_two_sides(backend: str) -> None:
    settings = {"color": "#00ff00", "back_color": (1.0, 0.0, 0.0), "backend": backend, **SMALL}
    for view, channel in [("front", 1), ("back", 0), ((0.1, 0.2, 3.0), 1), ((0.0, 0.3, -1.0), 0)]:
        assert middle(pictures.render(hemisphere(3), view=view, **settings)).argmax() == channel


def test_edges_darken_the_picture(backend: str) -> None:
    plain, lined = (
        pictures.render(grid(8, 8), edges=edges, backend=backend, **SMALL).mean()
        for edges in (False, True)
    )
    assert lined < plain - 2


directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1)
points = st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 3), min_size=1, max_size=20)


@given(points, directions, st.integers(16, 500), st.integers(16, 500))
def test_camera_sees_every_point(cloud, direction, width: int, height: int) -> None:
    toward = np.array(direction) / np.linalg.norm(direction)
    camera = drawing.Camera.showing(np.array(cloud), toward, (width, height))
    np.testing.assert_allclose(camera.frame @ camera.frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(camera.frame), 1)
    seen = (np.array(cloud) - camera.focus) @ camera.frame.T
    depth = camera.distance - seen[:, 2]
    assert np.all(depth > 0)
    assert np.all(np.abs(seen[:, :2]) / drawing.slopes((width, height)) <= depth[:, None])


def test_scalars_become_colours_with_a_legend(backend: str) -> None:
    mesh = grid(8, 8)
    values = np.where(mesh.vertices[:, 0] < 0.5, -1.0, 1.0)
    settings = {"scalars": values, "colormap": "coolwarm", "backend": backend, **SMALL}
    pixels = pictures.render(mesh, **settings).astype(int)
    assert pixels.shape[0] == 48
    assert pixels.shape[1] > 64
    assert pixels[24, 15, 2] > pixels[24, 15, 0]  # low is blue
    assert pixels[24, 48, 0] > pixels[24, 48, 2]  # high is red
    bare = pictures.render(mesh, legend=None, **settings)
    np.testing.assert_array_equal(bare, pixels[:, :64])
    np.testing.assert_array_equal(corners(pixels), [GROUND] * 4)


def test_values_outside_the_limits_and_without_number() -> None:
    values = np.array([-9.0, 0.0, 1.0, 9.0, np.nan])
    low, at_low, at_high, high, unknown = pictures._mapped(values, (0.0, 1.0), "viridis")
    np.testing.assert_array_equal(low, at_low)
    np.testing.assert_array_equal(high, at_high)
    assert len(set(unknown.tolist())) == 1


def test_strip_is_the_pictures_side_by_side(backend: str, tmp_path: Path) -> None:
    meshes = [hemisphere(2), CUBE]
    path = tmp_path / "strip.png"
    assert pictures.strip(meshes, path, same_camera=False, backend=backend, **SMALL) == path
    single = [pictures.render(mesh, backend=backend, **SMALL) for mesh in meshes]
    np.testing.assert_array_equal(np.asarray(Image.open(path)), np.concatenate(single, axis=1))
    before = path.read_bytes()
    pictures.strip(meshes, path, same_camera=False, backend=backend, **SMALL)
    assert path.read_bytes() == before


def test_one_camera_for_all_keeps_proportions(tmp_path: Path) -> None:
    large = hemisphere(3)
    small = Mesh(0.5 * large.vertices, large.faces)
    path = pictures.strip([large, small], tmp_path / "s.png", backend="matplotlib", **SMALL)
    covered = (np.asarray(Image.open(path)) != GROUND).any(axis=2)
    ratio = covered[:, :64].sum() / covered[:, 64:].sum()
    assert 3.2 < ratio < 4.5


def test_gif_has_every_frame_and_the_exact_background(tmp_path: Path) -> None:
    meshes = [Mesh(scale * CUBE.vertices, CUBE.triangulated().faces) for scale in (1, 2, 3, 4)]
    settings = {"seconds": 1.0, "swing": True, "backend": "matplotlib", **SMALL}
    path = pictures.animation(meshes, tmp_path / "film.gif", **settings)
    with Image.open(path) as film:
        assert film.n_frames == 6
        assert film.info["loop"] == 0
        durations, covered = [], []
        for frame in range(film.n_frames):
            film.seek(frame)
            durations.append(film.info["duration"])
            pixels = np.asarray(film.convert("RGB"))
            np.testing.assert_array_equal(corners(pixels), [GROUND] * 4)
            covered.append((pixels != GROUND).any(axis=2).sum())
    assert sum(durations) == 1500
    assert covered[0] < covered[1] < covered[2] < covered[3]
    assert covered[4:] == covered[2:0:-1]
    before = path.read_bytes()
    assert pictures.animation(meshes, path, **settings).read_bytes() == before


def test_turntable_turns_once(backend: str, tmp_path: Path) -> None:
    settings = {"color": "#00ff00", "back_color": "#ff0000", "backend": backend, **SMALL}
    path = pictures.turntable(hemisphere(2), tmp_path / "t.gif", frames=4, **settings)
    with Image.open(path) as film:
        assert film.n_frames == 4
        front, _, back, _ = (
            middle(np.asarray(film.convert("RGB")))
            for frame in range(4)
            if film.seek(frame) is None
        )
    assert front.argmax() == 1
    assert back.argmax() == 0


def fake_ffmpeg(folder: Path, body: str) -> None:
    program = folder / "ffmpeg"
    program.write_text(f"#!{sys.executable}\nimport pathlib, sys\n{body}\n")
    program.chmod(0o755)


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in for ffmpeg is a script")
def test_mp4_gets_every_pixel_to_ffmpeg(tmp_path: Path, monkeypatch) -> None:
    fake_ffmpeg(
        tmp_path,
        "data = sys.stdin.buffer.read()\n"
        "pathlib.Path(sys.argv[-1]).write_text(' '.join([str(len(data)), *sys.argv[1:]]))",
    )
    monkeypatch.setenv("PATH", str(tmp_path))
    settings = {"seconds": 0.5, "backend": "matplotlib", **SMALL}
    path = pictures.animation([CUBE, hemisphere(1)], tmp_path / "film.mp4", **settings)
    count, *arguments = path.read_text().split()
    assert int(count) == 2 * 64 * 48 * 3
    assert arguments[arguments.index("-s") + 1] == "64x48"
    assert float(arguments[arguments.index("-framerate") + 1]) == 4
    assert sorted(file.name for file in tmp_path.iterdir()) == ["ffmpeg", "film.mp4"]


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in for ffmpeg is a script")
def test_mp4_that_fails_leaves_nothing(tmp_path: Path, monkeypatch) -> None:
    fake_ffmpeg(
        tmp_path,
        "pathlib.Path(sys.argv[-1]).write_text('half')\n"
        "sys.stdin.buffer.read()\nsys.exit('no such codec')",
    )
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InvalidInput, match="no such codec"):
        pictures.animation([CUBE], tmp_path / "film.mp4", backend="matplotlib", **SMALL)
    assert [file.name for file in tmp_path.iterdir()] == ["ffmpeg"]


def test_mp4_without_ffmpeg_says_so(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingDependency, match="ffmpeg"):
        pictures.turntable(CUBE, tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())


NAN = Mesh([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], np.array([[0, 1, 2]]))
TWO_GON = PolygonMesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1]])


@pytest.mark.parametrize(
    ("mesh", "settings", "error", "message"),
    [
        (CUBE, {"view": "behind"}, InvalidInput, "three-quarter"),
        (CUBE, {"view": (0, 0, 0)}, InvalidInput, "direction"),
        (CUBE, {"colour": "red"}, InvalidInput, "colour.*back_color"),
        (CUBE, {"color": "skin"}, InvalidInput, "skin"),
        (CUBE, {"color": (0, 0, 255)}, InvalidInput, r"\[0, 1\]"),
        (CUBE, {"size": (0, 10)}, InvalidInput, "pixels"),
        (CUBE, {"scalars": np.zeros(7)}, InvalidInput, "8 vertices"),
        (CUBE, {"scalars": np.zeros(8), "colormap": "mud"}, InvalidInput, "mud"),
        (CUBE, {"scalars": np.zeros(8), "limits": (1, 0)}, InvalidInput, "limits"),
        (CUBE, {"backend": "crayon"}, InvalidInput, "crayon"),
        (Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), {}, InvalidInput, "no faces"),
        (NAN, {}, NotFinite, "vertices 2"),
        (TWO_GON, {}, DegenerateFaces, "faces 1"),
    ],
)
def test_what_cannot_be_drawn_is_refused(mesh, settings, error, message) -> None:
    with pytest.raises(error, match=message):
        pictures.render(mesh, **settings)


def test_files_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"\.png"):
        pictures.strip([CUBE], tmp_path / "strip.jpg")
    with pytest.raises(InvalidInput, match=r"\.gif or \.mp4"):
        pictures.animation([CUBE], tmp_path / "film.avi")
    with pytest.raises(InvalidInput, match="at least one mesh"):
        pictures.strip([], tmp_path / "strip.png")
    with pytest.raises(InvalidInput, match="for 1 of 2"):
        pictures.strip([CUBE, CUBE], tmp_path / "strip.png", scalars=[np.zeros(8)])
    with pytest.raises(InvalidInput, match="seconds"):
        pictures.animation([CUBE], tmp_path / "film.gif", seconds=0)
    with pytest.raises(InvalidInput, match="frame"):
        pictures.turntable(CUBE, tmp_path / "film.gif", frames=0)
    assert not list(tmp_path.iterdir())


@pytest.fixture
def fresh_probe():
    drawing.vtk_window.cache_clear()
    yield
    drawing.vtk_window.cache_clear()


@pytest.mark.skipif(sys.platform != "linux", reason="VTK asks for no library elsewhere")
@pytest.mark.usefixtures("fresh_probe")
def test_matplotlib_draws_where_vtk_would_crash(monkeypatch) -> None:
    monkeypatch.setattr(drawing, "_TRIAL", "import os; os.abort()")
    assert drawing.vtk_window() is None
    np.testing.assert_array_equal(
        pictures.render(CUBE, **SMALL), pictures.render(CUBE, backend="matplotlib", **SMALL)
    )
    with pytest.raises(MissingDependency, match="EGL"):
        pictures.render(CUBE, backend="pyvista", **SMALL)


def test_without_libraries_the_message_says_what_to_install(monkeypatch) -> None:
    monkeypatch.setattr(drawing, "find_spec", lambda name: None)
    for backend in ("auto", "pyvista", "matplotlib"):
        with pytest.raises(MissingDependency, match=r"pip install henkei\[pictures\]"):
            pictures.render(CUBE, backend=backend, **SMALL)


def test_importing_the_module_imports_no_viewer() -> None:
    viewers = "{'pyvista', 'vtkmodules', 'matplotlib', 'PIL'}"
    check = f"import sys, henkei.io.pictures; print(sorted({viewers} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_a_real_head_fills_its_picture(backend: str) -> None:
    mesh = read(real("faces-disk/ict_head_disk_neutral.obj"))
    pixels = pictures.render(mesh, size=(120, 120), backend=backend)
    covered = (pixels != pixels[0, 0]).any(axis=2)
    assert covered.any(axis=1).mean() > 0.85
    assert pixels[covered].std() > 15  # light and shade
