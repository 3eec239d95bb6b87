"""Any number of shapes: blended by weights, and as targets of one glTF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from henkei.errors import InvalidInput, NotFinite
from henkei.mesh import Attributes, Mesh
from henkei.morph.film import unit_normals
from henkei.morph.targets import blend, write_targets
from henkei.shapes import grid, random_disk

DISK = random_disk(0, 40)
DTYPES = {5123: "<u2", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}


def family(count: int) -> list[Mesh]:
    rng = np.random.default_rng(0)
    return [
        Mesh(DISK.vertices + 0.2 * rng.standard_normal(DISK.vertices.shape), DISK.faces)
        for _ in range(count)
    ]


class Gltf:
    """A glTF file with morph targets, read by pygltflib."""

    def __init__(self, path: Path) -> None:
        pygltflib = pytest.importorskip("pygltflib")
        self.file = pygltflib.GLTF2().load(path)
        self.data = self.file.binary_blob()
        if self.data is None:
            self.data = self.file.get_data_from_buffer_uri(self.file.buffers[0].uri)
        (self.mesh,) = self.file.meshes
        (self.primitive,) = self.mesh.primitives
        self.names = self.mesh.extras["targetNames"]

    def array(self, index: int) -> np.ndarray:
        accessor = self.file.accessors[index]
        view = self.file.bufferViews[accessor.bufferView]
        dtype, width = np.dtype(DTYPES[accessor.componentType]), WIDTHS[accessor.type]
        values = np.frombuffer(self.data, dtype, accessor.count * width, view.byteOffset)
        return values.reshape(accessor.count, width)

    def shape(self, weights: np.ndarray, name: str = "POSITION") -> np.ndarray:
        """What a viewer shows."""
        total = self.array(getattr(self.primitive.attributes, name)).astype(float)
        for weight, target in zip(weights, self.primitive.targets, strict=True):
            total += weight * self.array(target[name])
        return total

    def animation(self) -> tuple[np.ndarray, np.ndarray]:
        (animation,) = self.file.animations
        (sampler,), (channel,) = animation.samplers, animation.channels
        assert (channel.target.node, channel.target.path) == (0, "weights")
        assert sampler.interpolation == "LINEAR"
        times = self.array(sampler.input)[:, 0]
        return times, self.array(sampler.output).reshape(len(times), -1)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_nine_targets_in_one_file(tmp_path, suffix):
    base, *shapes = family(10)
    write_targets(tmp_path / f"t{suffix}", base, shapes)
    found = Gltf(tmp_path / f"t{suffix}")
    assert found.names == [f"shape {k}" for k in range(1, 10)]
    assert list(found.mesh.weights) == [0] * 9
    faces = found.array(found.primitive.indices).reshape(-1, 3)
    np.testing.assert_array_equal(faces, DISK.faces)
    np.testing.assert_allclose(found.shape(np.zeros(9)), base.vertices, atol=1e-6)
    for k, shape in enumerate(shapes):
        only = np.eye(9)[k]
        np.testing.assert_allclose(found.shape(only), shape.vertices, atol=1e-6)
        normals = unit_normals(shape.vertices, DISK.faces)
        np.testing.assert_allclose(found.shape(only, "NORMAL"), normals, atol=1e-6)


def test_a_viewer_shows_the_blend(tmp_path):
    base, *shapes = family(6)
    write_targets(tmp_path / "t.glb", base, shapes, names=list("vwxyz"))
    found = Gltf(tmp_path / "t.glb")
    assert found.names == list("vwxyz")
    weights = np.array([0.3, -0.2, 0.5, 0.1, 0.7])
    mixed = blend([base, *shapes], [1 - weights.sum(), *weights])
    np.testing.assert_allclose(found.shape(weights), mixed.vertices, atol=1e-6)


@pytest.mark.parametrize(
    ("sweep", "turning"),
    [
        ((0, 1), [0, 1, 0]),
        ((-2, 2), [0, 2, -2, 0]),
        ((-1, 0), [0, -1, 0]),
        ((-1, 3), [0, 3, -1, 0]),
    ],
)
def test_the_animation_takes_one_target_after_another(tmp_path, sweep, turning):
    base, *shapes = family(4)
    write_targets(tmp_path / "t.glb", base, shapes, sweep=sweep, seconds=3)
    times, weights = Gltf(tmp_path / "t.glb").animation()
    assert times[0] == 0
    assert times[-1] == pytest.approx(9)
    assert (np.diff(times) > 0).all()
    for turn in range(3):
        mine = (times >= 3 * turn - 1e-6) & (times <= 3 * turn + 3 + 1e-6)
        others = np.delete(weights[mine], turn, axis=1)
        assert not others.any()
        way = weights[mine, turn]
        stops = way[np.r_[True, np.sign(np.diff(way))[1:] != np.sign(np.diff(way))[:-1], True]]
        np.testing.assert_allclose(stops, turning, atol=1e-6)
    length = np.abs(np.diff(turning)).sum()
    speed = np.abs(np.diff(weights.sum(axis=1))) / np.diff(times)
    assert speed.max() < 2 * length / 3


def test_texture_and_colour_of_the_base_are_kept(tmp_path):
    sheet = grid(2, 2)
    uv = np.random.default_rng(0).random((24, 2))
    uv[3] = np.nan
    color = np.linspace(0, 1, 27).reshape(9, 3)
    base = Mesh(
        sheet.vertices,
        sheet.faces,
        attributes=Attributes(corner={"uv": uv}, vertex={"color": color, "label": np.arange(9)}),
    )
    target = (2 * sheet.vertices, sheet.faces)
    write_targets(tmp_path / "t.glb", base, [target])
    found = Gltf(tmp_path / "t.glb")
    corners = found.array(found.primitive.indices)[:, 0]
    shown = found.array(found.primitive.attributes.TEXCOORD_0)[corners] * [1, -1] + [0, 1]
    np.testing.assert_allclose(shown, np.nan_to_num(uv), atol=1e-6)
    colors = found.array(found.primitive.attributes.COLOR_0)[corners]
    np.testing.assert_allclose(colors, color[sheet.faces.ravel()], atol=1e-6)
    np.testing.assert_allclose(found.shape([1])[corners], 2 * sheet.vertices[sheet.faces.ravel()])
    write_targets(tmp_path / "plain.glb", base, [target], keep=())
    assert Gltf(tmp_path / "plain.glb").primitive.attributes.COLOR_0 is None


def test_far_from_the_origin_digits_are_kept(tmp_path):
    far = np.array([4.5e6, -1.2e6, 300.0])
    base, target = ((mesh.vertices + far, mesh.faces) for mesh in family(2))
    write_targets(tmp_path / "t.glb", base, [target])
    found = Gltf(tmp_path / "t.glb")
    place = np.array(found.file.nodes[0].translation)
    np.testing.assert_allclose(found.shape([1]) + place, target[0], atol=2e-6, rtol=0)


def test_the_same_bytes_each_time(tmp_path):
    base, *shapes = family(4)
    for name in ("a.glb", "b.glb"):
        write_targets(tmp_path / name, base, shapes)
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


@pytest.mark.parametrize(
    ("name", "targets", "options", "message"),
    [
        ("t.obj", 1, {}, "written as .glb or .gltf"),
        ("nowhere/t.glb", 1, {}, "does not exist"),
        ("t.glb", 0, {}, "no targets"),
        ("t.glb", 2, {"names": ["a"]}, "1 names for 2 targets"),
        ("t.glb", 1, {"sweep": (1, 2)}, "one below and one above 0"),
        ("t.glb", 1, {"sweep": (0, 0)}, "one below and one above 0"),
        ("t.glb", 1, {"sweep": (0, np.inf)}, "one below and one above 0"),
        ("t.glb", 1, {"seconds": 0}, "seconds must be"),
    ],
)
def test_bad_arguments_are_refused(tmp_path, name, targets, options, message):
    with pytest.raises(InvalidInput, match=message):
        write_targets(tmp_path / name, DISK, family(targets), **options)
    assert not list(tmp_path.iterdir())


def test_bad_shapes_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match="beard: has 9 vertices, the base has 40"):
        write_targets(tmp_path / "t.glb", DISK, [DISK, grid(2, 2)], names=["nose", "beard"])
    holed = DISK.vertices.copy()
    holed[3] = np.nan
    with pytest.raises(NotFinite, match="nose: vertices 3"):
        write_targets(tmp_path / "t.glb", DISK, [(holed, DISK.faces)], names=["nose"])
    empty = np.empty((0, 3), int)
    with pytest.raises(InvalidInput, match="no faces"):
        write_targets(tmp_path / "t.glb", (DISK.vertices, empty), [(DISK.vertices, empty)])
    with pytest.raises(InvalidInput, match="a path is needed"):
        write_targets(3, DISK, [DISK])  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_blends_are_affine():
    shapes = family(5)
    weights = np.array([0.1, 0.5, -0.4, 0.3, 0.5])
    mixed = blend(shapes, weights)
    np.testing.assert_array_equal(mixed.faces, DISK.faces)
    expected = sum(w * mesh.vertices for w, mesh in zip(weights, shapes, strict=True))
    np.testing.assert_allclose(mixed.vertices, expected, atol=1e-14)
    for k in range(5):
        np.testing.assert_array_equal(blend(shapes, np.eye(5)[k]).vertices, shapes[k].vertices)
    np.testing.assert_allclose(blend([DISK] * 3, [5, -5, 1]).vertices, DISK.vertices, atol=1e-14)
    far = np.array([1e3, 0, 0])
    shifted = [Mesh(mesh.vertices + far, mesh.faces) for mesh in shapes]
    np.testing.assert_allclose(blend(shifted, weights).vertices, mixed.vertices + far, atol=1e-11)


def test_attributes_are_blended():
    def shape(color: float, normal: list[float], label: int, **more: np.ndarray) -> Mesh:
        values = {
            "color": np.full((40, 3), color),
            "normal": np.tile(np.array(normal, float), (40, 1)),
            "label": np.full(40, label),
        }
        return Mesh(DISK.vertices, DISK.faces, attributes=Attributes(vertex={**values, **more}))

    only = {"age": np.full(40, 7.0)}
    shapes = [shape(0.2, [1, 0, 0], 1), shape(0.8, [0, 1, 0], 2, **only), shape(0.6, [0, 0, 1], 3)]
    mixed = blend(shapes, [0.25, 0.5, 0.25]).attributes.vertex
    np.testing.assert_allclose(mixed["color"], 0.6)
    np.testing.assert_allclose(mixed["normal"], np.tile([1, 2, 1] / np.sqrt(6), (40, 1)))
    assert set(mixed["label"]) == {2}
    assert set(mixed["age"]) == {7.0}
    assert blend(shapes, [-4, 5, 0]).attributes.vertex["color"].max() == 1


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ([1, 0], "weights must be 3 finite numbers"),
        ([1, 0, np.nan], "finite"),
        ([0.5, 0.4, 0], "sum to 0.9, they must sum to 1"),
        ([[1, 0, 0]], r"shape \(1, 3\)"),
    ],
)
def test_unusable_weights_are_refused(weights, message):
    with pytest.raises(InvalidInput, match=message):
        blend(family(3), weights)


def test_other_connectivity_is_refused():
    with pytest.raises(InvalidInput, match="shape 1: has 9 vertices"):
        blend([DISK, grid(2, 2)], [0.5, 0.5])
