"""glTF as other programs write it, and as they read ours."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest

from henkei import Attributes, Mesh
from henkei.errors import InvalidFile
from henkei.io import read
from written import again, decoded, encoded, patchwork, sheet

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype="<f4")
DATA = POINTS.tobytes() + bytes([0, 1, 2, 0, 2, 3])


def document(**changes) -> dict:
    """Two triangles of four points; the indices are bytes behind the points."""
    uri = "data:application/octet-stream;base64," + base64.b64encode(DATA).decode()
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 6},
        ],
        "buffers": [{"byteLength": len(DATA), "uri": uri}],
    } | changes


def read_gltf(tree: dict):
    return decoded("gltf", json.dumps(tree).encode())


def test_plain():
    mesh = read_gltf(document())
    assert mesh.vertices.tolist() == POINTS.tolist()
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_data_in_a_file_beside(tmp_path):
    tree = document()
    uri = tree["buffers"][0]["uri"]
    (tmp_path / "my data.bin").write_bytes(base64.b64decode(uri.partition(",")[2]))
    tree["buffers"][0]["uri"] = "my%20data.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    assert read(tmp_path / "a.gltf").face_count == 2
    (tmp_path / "my data.bin").unlink()
    with pytest.raises(InvalidFile, match=r"its data file .*my data.bin cannot be read"):
        read(tmp_path / "a.gltf")


OUTSIDE = [
    *("../a.bin", "b/../../a.bin", "./../a.bin", "b/c/../../../a.bin", "..", "../here/a.bin"),
    *("%2e%2e/a.bin", "..%2Fa.bin", "%2E%2E%2fa.bin", "b/%2e./.%2e/a.bin"),
    *("/a.bin", "%2Fa.bin", "//server/share/a.bin", "///a.bin"),
    *("..\\a.bin", "..%5Ca.bin", "b\\..\\..\\a.bin", "b\\c/../../../a.bin"),
    *("C:/a.bin", "C:\\a.bin", "C:a.bin", "c%3A/a.bin", "%43:%5Ca.bin", "\\a.bin"),
    *("\\\\server\\share\\a.bin", "%5C%5C%3F%5CC:%5Ca.bin"),
    *("b/D:a.bin", "b/D:/a.bin", "b/D%3Aa.bin", "b/C:../a.bin", "b\\D:a.bin", "b/a.bin:stream"),
]


def beside(folder: Path, uri: str) -> Path:
    """A glTF file with its data at a URI."""
    tree = document()
    tree["buffers"][0]["uri"] = uri
    path = folder / "a.gltf"
    path.write_text(json.dumps(tree))
    return path


@pytest.mark.parametrize("uri", OUTSIDE)
def test_nothing_outside_the_folder_is_read(tmp_path, uri):
    here = tmp_path / "here"
    (here / "b" / "c").mkdir(parents=True)
    for folder in (tmp_path, here):
        (folder / "a.bin").write_bytes(DATA)
    with pytest.raises(InvalidFile, match=r"a\.gltf: buffer 0 is at .*, outside the folder"):
        read(beside(here, uri))


def test_an_absolute_path_is_refused_also_to_the_folder_itself(tmp_path):
    (tmp_path / "a.bin").write_bytes(DATA)
    with pytest.raises(InvalidFile, match="outside the folder"):
        read(beside(tmp_path, (tmp_path / "a.bin").as_posix()))
    with pytest.raises(InvalidFile, match="only files are read"):
        read(beside(tmp_path, (tmp_path / "a.bin").as_uri()))


@pytest.mark.parametrize(
    ("uri", "file"),
    [
        ("a.bin", "a.bin"),
        ("./a.bin", "a.bin"),
        ("b/a.bin", "b/a.bin"),
        ("b/../a.bin", "a.bin"),
        ("b/c/..//a.bin", "b/a.bin"),
        ("b\\a.bin", "b/a.bin"),
        ("..a.bin", "..a.bin"),
        ("b../a..bin", "b../a..bin"),
        ("%252e%252e/a.bin", "%2e%2e/a.bin"),
        ("é%20%C3%A9.bin", "é é.bin"),
    ],
)
def test_data_in_the_folder_and_below(tmp_path, uri, file):
    data = tmp_path / file
    data.parent.mkdir(exist_ok=True)
    data.write_bytes(DATA)
    assert read(beside(tmp_path, uri)).face_count == 2


def test_dots_are_removed_before_links_are_followed(tmp_path):
    elsewhere, here = tmp_path / "elsewhere", tmp_path / "here"
    (elsewhere / "inside").mkdir(parents=True)
    here.mkdir()
    (elsewhere / "a.bin").write_bytes(DATA)
    (here / "link").symlink_to(elsewhere / "inside", target_is_directory=True)
    path = beside(here, "link/../a.bin")
    with pytest.raises(InvalidFile, match=r"here.a\.bin cannot be read"):
        read(path)


def test_pictures_are_never_opened():
    images = [{"uri": "../../skin.png"}, {"uri": "/skin.png"}, {"uri": "https://a.b/skin.png"}]
    assert read_gltf(document(images=images)).face_count == 2


def test_transforms_of_nested_nodes_and_several_meshes():
    half = np.sqrt(0.5)
    nodes = [
        {"children": [1, 2], "translation": [10, 0, 0]},
        {"mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 1, 1]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
    ]
    mesh = read_gltf(document(nodes=nodes))
    expected = [[10, 0, 0], [10, 2, 0], [9, 2, 0], [9, 0, 0]]
    expected += [[10, 0, 5], [9, 0, 5], [9, 1, 5], [10, 1, 5]]
    np.testing.assert_allclose(mesh.vertices, expected, atol=1e-12)
    assert mesh.faces[2:].tolist() == [[6, 5, 4], [7, 6, 4]]  # mirrored: turned round
    assert (mesh.face_normals[:, 2] > 0).all()


@pytest.mark.parametrize("scenes", [{"scenes": []}, {"scenes": [], "nodes": []}])
def test_files_without_scene(scenes):
    assert read_gltf(document(**scenes)).face_count == 2


@pytest.mark.parametrize(
    ("mode", "faces"),
    [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[1, 2, 0], [2, 3, 0]])],
)
def test_strips_and_fans(mode, faces):
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "mode": mode}]}]
    assert read_gltf(document(meshes=meshes)).faces.tolist() == faces


def test_materials_and_lines():
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    primitives = [primitive | {"material": 3}, primitive | {"mode": 1}, primitive | {"material": 1}]
    mesh = read_gltf(document(meshes=[{"primitives": primitives}]))
    assert mesh.attributes.face["material"].tolist() == [3, 3, 1, 1]
    with pytest.raises(InvalidFile, match="no vertices"):
        read_gltf(document(meshes=[{"primitives": [primitive | {"mode": 0}]}]))


def changed(path: str, value: object) -> dict:
    tree = document()
    *parents, last = [int(k) if k.isdigit() else k for k in path.split("/")]
    part = tree
    for key in parents:
        part = part[key]
    part[last] = value
    return tree


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        (changed("asset/version", "1.0"), "glTF 2.0 is read, this has version 1.0"),
        (changed("extensionsRequired", ["KHR_draco_mesh_compression"]), "extension KHR_draco"),
        (changed("accessors/0/count", 5), "accessor 0 reaches beyond"),
        (changed("accessors/0/count", -1), "accessor 0 reaches beyond"),
        (changed("accessors/0/count", "x"), "damaged glTF"),
        (changed("accessors/0/type", "VEC2"), "accessor 0 has 2 components"),
        (changed("accessors/0/sparse", {}), "accessor 0 is sparse"),
        (changed("accessors/1/componentType", 5120), "indices are int8, not unsigned"),
        (changed("accessors/1/count", 5), "5 indices are not whole triangles"),
        (changed("bufferViews/1/byteLength", 600), "truncated, buffer view 1"),
        (changed("buffers/0/uri", "https://a.b/c.bin"), "only files are read"),
        (changed("buffers", []), "damaged glTF"),
        (changed("nodes/0/children", [0]), "node 0 has two parents"),
        (changed("nodes/0/mesh", 7), "damaged glTF"),
        (changed("nodes/0/rotation", [0, 0]), "damaged glTF"),
    ],
)
def test_faults(tree, message):
    with pytest.raises(InvalidFile, match=message):
        read_gltf(tree)


def test_truncated_glb():
    data = encoded("glb", sheet())
    with pytest.raises(InvalidFile, match=rf"{len(data)} bytes are promised, the file has 100"):
        decoded("glb", data[:100])


def test_trimesh_and_pygltflib_read_ours(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pygltflib = pytest.importorskip("pygltflib")
    path = tmp_path / "a.glb"
    path.write_bytes(encoded("glb", sheet()))
    peer = trimesh.load(path, force="mesh", process=False)
    np.testing.assert_array_equal(peer.vertices, sheet().vertices)
    np.testing.assert_array_equal(peer.faces, sheet().faces)
    tree = pygltflib.GLTF2().load(path)
    assert tree.accessors[0].max == sheet().vertices.max(axis=0).tolist()
    assert all(view.byteOffset % 4 == 0 for view in tree.bufferViews)


def test_we_read_what_trimesh_writes():
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    scene = trimesh.Scene()
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    mesh = decoded("glb", scene.export(file_type="glb"))
    np.testing.assert_allclose(mesh.vertices[mesh.faces], box.vertices[box.faces] + [3, 0, 0])


def test_texture_points_up_here_and_down_there():
    uv = np.array([[0, 0], [1, 0], [1, 0.25]])
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes=Attributes(vertex={"uv": uv}))
    tree = json.loads(encoded("gltf", mesh))
    accessor = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]]
    start = tree["bufferViews"][accessor["bufferView"]]["byteOffset"]
    data = base64.b64decode(tree["buffers"][0]["uri"].partition(",")[2])
    assert np.frombuffer(data, "<f4", 6, start).tolist() == [0, 1, 1, 1, 1, 0.75]
    np.testing.assert_array_equal(again("gltf", mesh).attributes.vertex["uv"], uv)


def test_given_normals_are_kept():
    normal = np.eye(3)[[1, 2, 0]]
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes=Attributes(vertex={"normal": 7 * normal}))
    np.testing.assert_array_equal(again("glb", mesh).attributes.vertex["normal"], normal)
    assert again("glb", patchwork()).attributes.vertex["normal"].shape[1] == 3
