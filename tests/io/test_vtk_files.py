"""VTK's files as VTK writes them, and VTK's reading of ours."""

from __future__ import annotations

import numpy as np
import pytest

from henkei.errors import InvalidFile
from written import decoded, encoded, patchwork, sheet

LEGACY = """# vtk DataFile Version 3.0
by hand
ASCII
DATASET POLYDATA
POINTS 3 float
0 0 0 1 0 0
0 1 0
POLYGONS 1 4
3 0 1 2
"""


def model():
    """A sphere with arrays, of VTK itself."""
    pyvista = pytest.importorskip("pyvista")
    sphere = pyvista.Sphere(theta_resolution=6, phi_resolution=5)
    sphere.point_data["two words"] = np.arange(sphere.n_points) * 0.5
    sphere.cell_data["cell"] = np.arange(sphere.n_cells)
    return sphere


def check(mesh, peer) -> None:
    np.testing.assert_allclose(mesh.vertices, peer.points, atol=1e-6)
    np.testing.assert_array_equal(mesh.faces, peer.regular_faces)
    assert set(mesh.attributes.vertex) == {"normal", "two words"}
    np.testing.assert_array_equal(mesh.attributes.vertex["two words"], peer["two words"])
    np.testing.assert_array_equal(mesh.attributes.face["cell"], peer["cell"])


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("suffix", ["vtk", "vtp"])
def test_files_of_vtk(suffix, binary, tmp_path):
    sphere = model()
    sphere.save(tmp_path / f"a.{suffix}", binary=binary)
    check(decoded(suffix, (tmp_path / f"a.{suffix}").read_bytes()), sphere)


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
@pytest.mark.parametrize("encode", [False, True])
@pytest.mark.parametrize("order", ["BigEndian", "LittleEndian"])
def test_encodings_of_vtp(mode, compressor, encode, order, tmp_path):
    sphere = model()
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    for header in ("SetHeaderTypeToUInt32", "SetHeaderTypeToUInt64"):
        writer = vtkXMLPolyDataWriter()
        for setting in (
            f"SetDataModeTo{mode}",
            f"SetCompressorTypeTo{compressor}",
            f"SetByteOrderTo{order}",
            header,
        ):
            getattr(writer, setting)()
        writer.SetEncodeAppendedData(encode)
        writer.SetBlockSize(512)  # several blocks an array
        writer.SetFileName(str(tmp_path / "a.vtp"))
        writer.SetInputData(sphere)
        assert writer.Write()
        check(decoded("vtp", (tmp_path / "a.vtp").read_bytes()), sphere)


@pytest.mark.parametrize("suffix", ["vtk", "vtp"])
def test_vtk_reads_ours(suffix, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    (tmp_path / f"a.{suffix}").write_bytes(encoded(suffix, patchwork()))
    peer = pyvista.read(tmp_path / f"a.{suffix}")
    np.testing.assert_array_equal(peer.points, patchwork().vertices)
    np.testing.assert_array_equal(peer.GetPolys().GetConnectivityArray(), patchwork().indices)
    np.testing.assert_array_equal(peer["color"], patchwork().attributes.vertex["color"])
    np.testing.assert_array_equal(peer["material"], patchwork().attributes.face["material"])


def test_grid_of_polygonal_cells(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    cells = np.array([3, 0, 1, 2, 2, 0, 1, 4, 0, 1, 2, 3])
    grid = pyvista.UnstructuredGrid(cells, [5, 3, 9], np.eye(4, 3))
    grid.cell_data["number"] = [10, 11, 12]
    grid.save(tmp_path / "a.vtk", binary=False)
    mesh = decoded("vtk", (tmp_path / "a.vtk").read_bytes())
    assert mesh.indices.tolist() == [0, 1, 2, 0, 1, 2, 3]
    assert mesh.attributes.face["number"].tolist() == [10, 12]
    solid = pyvista.UnstructuredGrid(np.array([4, 0, 1, 2, 3]), [10], np.eye(4, 3))
    solid.save(tmp_path / "a.vtk")
    skin = decoded("vtk", (tmp_path / "a.vtk").read_bytes())
    assert sorted(sorted(face) for face in skin.faces.tolist()) == [
        [0, 1, 2],
        [0, 1, 3],
        [0, 2, 3],
        [1, 2, 3],
    ]


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_old_ascii(newline):
    text = LEGACY + "POINT_DATA 3\nSCALARS height double 1\nLOOKUP_TABLE default\n1 2 3\n"
    mesh = decoded("vtk", text.replace("\n", newline).encode())
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert mesh.attributes.vertex["height"].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("ASCII", "UTF8", "line 1: three lines belong here"),
        ("POLYDATA", "STRUCTURED_GRID", "'DATASET STRUCTURED_GRID' is not read"),
        ("POINTS 3", "POINTS 4", "line 8: 'POLYGONS' is not a number"),
        ("3 float", "3 string", "'string'"),
        ("3 0 1 2", "3 0 1 3", "face 0 names vertex 3"),
        ("3 0 1 2", "2 0 1 2", "the sizes of cells do not add up"),
        ("3 0 1 2", "3 0 1", "truncated, 4 numbers are promised"),
        ("0 1 0", "0 nan 0", "vertex 1 has a NaN coordinate; 2 of 3"),
        ("POLYGONS 1 4\n3 0 1 2\n", "", "a point cloud of 3 vertices"),
        ("POLYGONS 1 4", "TRIANGLE_STRIPS 1 4", "triangle strips are not read"),
    ],
)
def test_faults_of_legacy_files(before, after, message):
    with pytest.raises(InvalidFile, match=message):
        decoded("vtk", LEGACY.replace(before, after).encode())


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (b"PolyData", b"ImageData", "no VTK file of type PolyData"),
        (b'NumberOfPolys="8"', b'NumberOfPolys="9"', "the offsets of polygons do not fit"),
        (b'NumberOfPolys="8"', b'NumberOfPolys="0"', "a point cloud of 9 vertices"),
        (b'offset="0"', b'offset="999999"', "truncated, data at byte 999999"),
        (b"</AppendedData>", b"", "truncated, AppendedData is not closed"),
        (b"<Points>", b"<Point>", "mismatched tag"),
        (b"Float64", b"Float99", "Float99"),
        (b'byte_order="', b'compressor="vtkLZ4DataCompressor" byte_order="', "too long|not read"),
    ],
)  # fmt: skip
def test_faults_of_xml_files(before, after, message):
    data = encoded("vtp", sheet())
    assert before in data
    with pytest.raises(InvalidFile, match=message):
        decoded("vtp", data.replace(before, after, 1))
