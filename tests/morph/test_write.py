"""Morph files: read back by other libraries, they hold the shapes, exactly where they should."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from henkei.combine import combine
from henkei.errors import Cancelled, InvalidInput, NotFinite
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.interpolation import between, path_of
from henkei.io import read
from henkei.mesh import Attributes, Mesh
from henkei.morph.film import unit_normals
from henkei.morph.write import write_morph
from henkei.shapes import hemisphere

DTYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@pytest.fixture
def sheet() -> Correspondence:
    """A strip of 6 x 2 squares, on b bent to three quarters of a ring."""
    u, v = np.meshgrid(np.linspace(0, 6, 7), np.linspace(0, 2, 3), indexing="ij")
    a = np.stack([u, v, 0 * u], axis=-1).reshape(-1, 3)
    angle = a[:, 0] / 6 * 1.5 * np.pi
    b = np.stack([2 * np.sin(angle), a[:, 1], 2 - 2 * np.cos(angle)], axis=1)
    i = np.arange(21).reshape(7, 3)
    corners = [i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    nowhere = SurfacePoints(np.full(21, -1, np.int32), np.zeros((21, 3)))
    return Correspondence(faces, a, b, nowhere, nowhere)


class Gltf:
    """A .glb or .gltf, taken apart by the letter of the specification."""

    def __init__(self, path: Path) -> None:
        import pygltflib

        self.file = pygltflib.GLTF2().load(path)
        self.data = self.file.binary_blob()
        if self.data is None:
            self.data = self.file.get_data_from_buffer_uri(self.file.buffers[0].uri)
        self.primitive = self.file.meshes[0].primitives[0]

    def array(self, index: int) -> np.ndarray:
        accessor = self.file.accessors[index]
        view = self.file.bufferViews[accessor.bufferView]
        assert view.byteOffset % 4 == 0
        dtype, width = np.dtype(DTYPES[accessor.componentType]), WIDTHS[accessor.type]
        assert view.byteLength == accessor.count * width * dtype.itemsize
        assert view.byteOffset + view.byteLength <= len(self.data)
        values = np.frombuffer(self.data, dtype, accessor.count * width, view.byteOffset)
        values = values.reshape(accessor.count, width)
        if accessor.min:
            np.testing.assert_array_equal(values.min(axis=0), np.float32(accessor.min))
            np.testing.assert_array_equal(values.max(axis=0), np.float32(accessor.max))
        return values

    def attribute(self, name: str) -> np.ndarray:
        return self.array(getattr(self.primitive.attributes, name))

    def target(self, k: int, name: str) -> np.ndarray:
        return self.array(self.primitive.targets[k][name])

    @property
    def faces(self) -> np.ndarray:
        return self.array(self.primitive.indices).reshape(-1, 3).astype(int)

    def weights(self, seconds: float) -> np.ndarray:
        sampler = self.file.animations[0].samplers[0]
        assert sampler.interpolation == "LINEAR"
        keys = self.array(sampler.input)[:, 0]
        values = self.array(sampler.output).reshape(len(keys), -1)
        assert (np.diff(keys) > 0).all()
        assert keys[0] == 0
        return np.array([np.interp(seconds, keys, column) for column in values.T])

    def shape(self, seconds: float, name: str = "POSITION") -> np.ndarray:
        total = self.attribute(name).astype(float)
        for k, weight in enumerate(self.weights(seconds)):
            total += weight * self.target(k, name)
        return total + (np.array(self.file.nodes[0].translation or 0) if name == "POSITION" else 0)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_a_straight_morph_has_one_target(sheet: Correspondence, tmp_path: Path, suffix) -> None:
    write_morph(tmp_path / f"m{suffix}", sheet, seconds=3)
    found = Gltf(tmp_path / f"m{suffix}")
    np.testing.assert_array_equal(found.faces, sheet.faces)
    np.testing.assert_array_equal(found.attribute("POSITION"), np.float32(sheet.vertices_a))
    assert found.file.meshes[0].extras == {"targetNames": ["b"]}
    for seconds, t in ((0, 0), (1.5, 0.5), (3, 1), (4.5, 0.5), (6, 0)):
        expected = (1 - t) * sheet.vertices_a + t * sheet.vertices_b
        np.testing.assert_allclose(found.shape(seconds), expected, atol=1e-6)
    normals = unit_normals(sheet.vertices_b, sheet.faces)
    np.testing.assert_allclose(found.shape(3, "NORMAL"), normals, atol=1e-6)
    channel = found.file.animations[0].channels[0]
    assert (channel.target.node, channel.target.path) == (0, "weights")
    assert found.file.scenes[0].nodes == [0]


def test_a_curved_morph_passes_through_its_shapes(sheet: Correspondence, tmp_path: Path) -> None:
    write_morph(tmp_path / "m.glb", sheet, path_kind="rotation", seconds=1)
    found, path = Gltf(tmp_path / "m.glb"), path_of(sheet, "rotation")
    assert len(found.primitive.targets) == 10
    for t in (0, 0.1, 0.5, 0.9, 1):
        np.testing.assert_allclose(found.shape(t), path.positions(t), atol=1e-6)
        np.testing.assert_allclose(found.shape(2 - t), path.positions(t), atol=1e-6)
    halfway = (path.positions(0.1) + path.positions(0.2)) / 2
    np.testing.assert_allclose(found.shape(0.15), halfway, atol=1e-6)


@pytest.mark.parametrize("kind", ["linear", "rotation"])
def test_time_passes_as_asked(sheet: Correspondence, tmp_path: Path, kind) -> None:
    options = {"path_kind": kind, "time": lambda t: t**3, "ping_pong": False, "frames": 31}
    write_morph(tmp_path / "m.glb", sheet, seconds=1, **options)
    found, path = Gltf(tmp_path / "m.glb"), path_of(sheet, kind)
    for t in (0, 0.4, 0.8, 1):
        close = 1e-6 if kind == "linear" else 0.05
        np.testing.assert_allclose(found.shape(t), path.positions(t**3), atol=close)
    assert found.file.accessors[found.file.animations[0].samplers[0].input].max == [1]


def test_delays_are_kept(sheet: Correspondence, tmp_path: Path) -> None:
    delay = sheet.vertices_a[:, 0] / 10
    write_morph(tmp_path / "m.glb", sheet, delay=delay, seconds=1, time="smoothstep")
    found = Gltf(tmp_path / "m.glb")
    for t in (0, 0.3, 0.7, 1):
        expected = between(sheet, t, time="smoothstep", delay=delay).vertices
        np.testing.assert_allclose(found.shape(t), expected, atol=1e-6)
    np.testing.assert_array_equal(found.shape(0.3)[-3:], sheet.vertices_a[-3:])


def test_seams_split_vertices_and_v_points_down(sheet: Correspondence, tmp_path: Path) -> None:
    uv = sheet.vertices_a[sheet.faces.ravel(), :2] / 6
    uv[: 3 * 4] += 0.5
    color = np.linspace(0, 1, 21)[:, None] * [1, 0.5, 0.25]
    color[4] = np.nan
    painted = replace(
        sheet,
        attributes_a=Attributes(corner={"uv": uv}),
        attributes_b=Attributes(vertex={"color": color, "label": np.arange(21)}),
    )
    with pytest.warns(UserWarning, match="NaN in the colours"):
        write_morph(tmp_path / "m.glb", painted)
    found = Gltf(tmp_path / "m.glb")
    corners = found.faces.ravel()
    wanted = sheet.faces.ravel()
    np.testing.assert_array_equal(
        found.attribute("POSITION")[corners], np.float32(sheet.vertices_a[wanted])
    )
    flipped = found.attribute("TEXCOORD_0")[corners] * [1, -1] + [0, 1]
    np.testing.assert_allclose(flipped, uv, atol=1e-6)
    expected = np.where(np.isnan(color), 1, color)[wanted]
    np.testing.assert_allclose(found.attribute("COLOR_0")[corners], expected, atol=1e-6)
    np.testing.assert_allclose(found.shape(2)[corners], sheet.vertices_b[wanted], atol=1e-6)
    pairs = np.unique(np.column_stack([wanted, np.float32(uv)]), axis=0)
    assert len(found.attribute("POSITION")) == len(pairs)
    plain = tmp_path / "plain.glb"
    write_morph(plain, painted, keep=())
    assert Gltf(plain).primitive.attributes.TEXCOORD_0 is None


def test_far_from_the_origin_digits_are_kept(sheet: Correspondence, tmp_path: Path) -> None:
    far = np.array([4.5e6, -1.2e6, 300.0])
    moved = replace(sheet, vertices_a=sheet.vertices_a + far, vertices_b=sheet.vertices_b + far)
    write_morph(tmp_path / "m.glb", moved)
    found = Gltf(tmp_path / "m.glb")
    np.testing.assert_allclose(found.shape(0), moved.vertices_a, atol=2e-6, rtol=0)
    np.testing.assert_allclose(found.shape(2), moved.vertices_b, atol=2e-6, rtol=0)


def test_large_rounding_is_said(sheet: Correspondence, tmp_path: Path) -> None:
    apart = replace(sheet, vertices_b=sheet.vertices_b + 1e6)
    with pytest.warns(UserWarning, match="rounded by up to"):
        write_morph(tmp_path / "m.glb", apart)
    with pytest.raises(InvalidInput, match="too large for float32"):
        write_morph(tmp_path / "m.glb", replace(sheet, vertices_b=sheet.vertices_b * 1e40))


def test_a_glb_is_framed_by_the_letter(sheet: Correspondence, tmp_path: Path) -> None:
    write_morph(tmp_path / "m.glb", sheet)
    data = (tmp_path / "m.glb").read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    tree = json.loads(data[20 : 20 + size])
    rest, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    assert rest % 4 == 0
    assert 0 <= rest - tree["buffers"][0]["byteLength"] < 4


def test_other_readers_see_a(sheet: Correspondence, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    write_morph(tmp_path / "m.glb", sheet, path_kind="rotation")
    scene = trimesh.load(tmp_path / "m.glb", process=False)
    mesh = next(iter(scene.geometry.values()))
    np.testing.assert_allclose(mesh.vertices, sheet.vertices_a, atol=1e-6)
    np.testing.assert_array_equal(mesh.faces, sheet.faces)
    back = read(tmp_path / "m.glb")
    np.testing.assert_allclose(back.vertices, sheet.vertices_a, atol=1e-6)


def test_normals_have_length_one_where_faces_have_no_area() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    points = np.vstack([square, [[0.5, 0.5, 0], [9, 9, 9], [0, 0, 5], [0, 0, 6], [0, 0, 7]]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 2, 4], [6, 7, 8]], np.int32)
    normals = unit_normals(points, faces)
    np.testing.assert_allclose(normals, np.tile([0, 0, 1.0], (9, 1)))
    tilted = unit_normals(points[:, [2, 0, 1]], faces)
    np.testing.assert_allclose(tilted[:5], np.tile([1.0, 0, 0], (5, 1)))
    np.testing.assert_allclose(tilted[5:], np.tile([0, 0, 1.0], (4, 1)))


@pytest.mark.parametrize("name", ["m.glb", "m.gltf", "m.usda", "m.usdc", "m_%d.ply"])
def test_bytes_are_the_same_each_time(sheet: Correspondence, tmp_path: Path, name: str) -> None:
    if "usd" in name:
        pytest.importorskip("pxr")
    contents = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        write_morph(tmp_path / folder / name, sheet, path_kind="rotation", frames=3)
        files = sorted((tmp_path / folder).iterdir())
        contents.append([(file.name, file.read_bytes()) for file in files])
    assert contents[0] == contents[1]
    assert contents[0]


@pytest.mark.parametrize(
    ("name", "first"),
    [("f_%04d.ply", "f_0000.ply"), ("f%d.obj", "f0.obj"), ("", "frame_0000.obj")],
)
def test_numbered_frames(sheet: Correspondence, tmp_path: Path, name: str, first: str) -> None:
    write_morph(tmp_path / name, sheet, frames=5, time="smoothstep")
    files = sorted(tmp_path.iterdir())
    assert len(files) == 5
    assert files[0].name == first
    for file, t in zip(files, np.linspace(0, 1, 5), strict=True):
        expected = between(sheet, float(t), time="smoothstep").vertices
        np.testing.assert_array_equal(read(file).vertices, expected)


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
@pytest.mark.parametrize("kind", ["linear", "rotation"])
def test_usd_holds_samples_and_a_blend_shape(
    sheet: Correspondence, tmp_path: Path, suffix: str, kind
) -> None:
    pytest.importorskip("pxr")
    from pxr import Gf, Usd, UsdGeom, UsdSkel

    uv = sheet.vertices_a[sheet.faces.ravel(), :2]
    painted = replace(sheet, attributes_a=Attributes(corner={"uv": uv}))
    file = tmp_path / f"m{suffix}"
    write_morph(file, painted, path_kind=kind, time="smoothstep", frames=11, seconds=1)
    stage = Usd.Stage.Open(str(file))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/morph/mesh"))
    path = path_of(sheet, kind)
    assert stage.GetTimeCodesPerSecond() == 24
    assert stage.GetEndTimeCode() == 48
    for k, t in enumerate(np.linspace(0, 1, 11)):
        expected = np.float32(path.positions(t * t * (3 - 2 * t)))
        for code in (24 * t, 48 - 24 * t):
            found = np.array(mesh.GetPointsAttr().Get(float(code)))
            np.testing.assert_allclose(found, expected, atol=0 if k in (0, 10) else 1e-6)
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    np.testing.assert_array_equal(faces, sheet.faces)
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get()
    np.testing.assert_array_equal(np.array(st), np.float32(uv))

    stage.GetPrimAtPath("/morph").GetVariantSet("morph").SetVariantSelection("blendShape")
    assert mesh.GetPointsAttr().GetNumTimeSamples() == 0
    UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetPrimAtPath("/morph")), Gf.Interval(0, 48))
    for code, t in ((0, 0), (12, 0.5), (24, 1), (36, 0.5), (48, 0)):
        baked = np.array(mesh.GetPointsAttr().Get(float(code)))
        np.testing.assert_allclose(baked, path.positions(t), atol=2e-6)


def test_usd_keeps_digits_far_from_the_origin(sheet: Correspondence, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    far = np.array([4.5e6, -1.2e6, 300.0])
    moved = replace(sheet, vertices_a=sheet.vertices_a + far, vertices_b=sheet.vertices_b + far)
    write_morph(tmp_path / "m.usdc", moved, ping_pong=False)
    stage = Usd.Stage.Open(str(tmp_path / "m.usdc"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/morph/mesh"))
    matrix = np.array(mesh.ComputeLocalToWorldTransform(0))
    points = np.array(mesh.GetPointsAttr().Get(48.0), dtype=float) + matrix[3, :3]
    np.testing.assert_allclose(points, moved.vertices_b, atol=2e-6, rtol=0)


def test_pictures(sheet: Correspondence, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    pytest.importorskip("matplotlib")
    write_morph(tmp_path / "m.png", sheet, frames=2)
    write_morph(tmp_path / "m.gif", sheet, frames=3, seconds=1)
    with image.open(tmp_path / "m.png") as strip, image.open(tmp_path / "m.gif") as film:
        assert strip.width > strip.height
        assert film.n_frames == 4


@pytest.mark.parametrize("name", ["m.glb", "m.usda", "m_%02d.ply"])
def test_cancelling_leaves_no_file(sheet: Correspondence, tmp_path: Path, name: str) -> None:
    if "usd" in name:
        pytest.importorskip("pxr")

    def stop(message: str, fraction: float) -> None:
        raise Cancelled(message)

    with pytest.raises(Cancelled):
        write_morph(tmp_path / name, sheet, progress=stop)
    assert not list(tmp_path.iterdir())


def test_progress_rises_to_one(sheet: Correspondence, tmp_path: Path) -> None:
    seen: list[float] = []
    report: Callable[[str, float], None] = lambda message, fraction: seen.append(fraction)  # noqa: E731
    write_morph(tmp_path / "m.glb", sheet, path_kind="rotation", progress=report)
    assert seen == sorted(seen)
    assert seen[-1] == 1


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("m.stp", {}, "unknown ending '.stp'.*frame_%04d"),
        ("m", {}, "unknown ending"),
        ("m.obj", {}, "number in the name, as in .*m_%04d.obj"),
        ("nowhere/m.glb", {}, "does not exist"),
        ("nowhere/m_%d.ply", {}, "does not exist"),
        ("m.glb", {"frames": 1}, "frames must be"),
        ("m.glb", {"frames": 2.5}, "frames must be"),
        ("m.glb", {"seconds": 0}, "seconds must be"),
        ("m.glb", {"seconds": np.nan}, "seconds must be"),
        ("m.glb", {"time": "slow"}, "unknown time"),
        ("m.glb", {"path_kind": "spline"}, "unknown path"),
        ("m.glb", {"delay": [0.5]}, "delay must have shape"),
        ("m.glb", {"delay": np.ones(21)}, r"delay must be in \[0, 1\)"),
    ],
)
def test_bad_arguments_are_refused(
    sheet: Correspondence, tmp_path: Path, name: str, options: dict, message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        write_morph(tmp_path / name, sheet, **options)
    assert not list(tmp_path.iterdir())


def test_bad_morphs_are_refused(sheet: Correspondence, tmp_path: Path) -> None:
    holed = sheet.vertices_b.copy()
    holed[3] = np.nan
    with pytest.raises(NotFinite, match="vertices 3"):
        write_morph(tmp_path / "m.glb", replace(sheet, vertices_b=holed))
    with pytest.raises(InvalidInput, match="no faces"):
        write_morph(tmp_path / "m.glb", replace(sheet, faces=np.empty((0, 3), np.int32)))
    with pytest.raises(InvalidInput, match="not Mesh"):
        write_morph(tmp_path / "m.glb", Mesh(sheet.vertices_a, sheet.faces))  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_frames_of_a_longer_sequence_are_not_left_among_new_ones(tmp_path):
    c = combine(hemisphere(1), hemisphere(1))
    write_morph(tmp_path / "f_%03d.ply", c, frames=5)
    write_morph(tmp_path / "f_%03d.ply", c, frames=5)
    with pytest.raises(InvalidInput, match=r"would not replace: f_003.ply, f_004.ply"):
        write_morph(tmp_path / "f_%03d.ply", c, frames=3)
    with pytest.raises(InvalidInput, match="numbered names are for meshes"):
        write_morph(tmp_path / "f_%03d.png", c)
