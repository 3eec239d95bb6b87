"""Models of simulation codes: the same file back, with moved nodes."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import henkei as hk
from data import real
from henkei.errors import InvalidInput, NotFinite
from henkei.io.cae import read_model, write_model
from henkei.mesh import Mesh, PolygonMesh
from models import FORMS, abaqus, box, corners_of, nastran, parsed, second_order, sheet, text_of

SOLIDS = ["tetra", "pyramid", "wedge", "hexahedron"]


def written(folder, form: str, points, blocks):
    text, suffix = text_of(form, points, blocks)
    path = folder / f"a.{suffix}"
    path.write_text(text)
    return path


def shaken(model, seed: int = 0):
    return model.nodes + np.random.default_rng(seed).normal(size=model.nodes.shape)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["sheet", "tetra", "wedge", "hexahedron"])
def test_there_and_back(form, order, kind, tmp_path):
    """All nodes read back; not a byte changes outside the coordinates; elements stay."""
    points, blocks = sheet() if kind == "sheet" else box(kind, 2, 2, 2)
    points, blocks = second_order(points, blocks) if order == 2 else (points, blocks)
    path = written(tmp_path, form, points, blocks)
    model = read_model(path)
    np.testing.assert_allclose(model.nodes, points, atol=1e-5 if form == "small" else 1e-13)
    assert [(b.kind, b.nodes.tolist()) for b in model.blocks] == [
        (k, table.tolist()) for k, table in blocks
    ]
    write_model(tmp_path / path.name, model, model.nodes)
    assert path.read_text() == text_of(form, points, blocks)[0]
    nodes = shaken(model)
    nodes[3] = model.nodes[3]
    write_model(tmp_path / f"b{path.suffix}", model, nodes)
    again = read_model(tmp_path / f"b{path.suffix}")
    exact = form == "inp"
    np.testing.assert_allclose(again.nodes, nodes, rtol=0, atol=1e-18 if exact else 1e-12)
    assert (again.nodes[3] == model.nodes[3]).all()
    before, after = path.read_text().splitlines(), (tmp_path / f"b{path.suffix}").read_text()
    words = ("1", " ") if form == "inp" else ("GRID", "*   ", "*,.", "*,-", "*,0", "*,1", "*,2")
    kept = [line for line in before if not line.startswith(words) or form == "inp"]
    rest = after.splitlines()
    if form == "inp":
        start, count = 4, len(points)
        assert before[:start] + before[start + count :] == rest[:start] + rest[start + count :]
        assert before[start + 3] == rest[start + 3]
    else:
        assert [line for line in rest if not line.startswith(words)] == kept


@pytest.mark.parametrize("form", FORMS)
def test_unmoved_cards_stay_byte_for_byte(form, tmp_path):
    path = written(tmp_path, form, *sheet())
    model = read_model(path)
    nodes = model.nodes.copy()
    nodes[5, 1] += 0.5
    write_model(path, model, nodes)
    before = text_of(form, *sheet())[0].splitlines()
    after = path.read_text().splitlines()
    assert len(before) == len(after)
    assert sum(a != b for a, b in zip(before, after, strict=True)) == 1


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", SOLIDS)
def test_the_skin_is_closed_and_looks_outward(form, kind, tmp_path):
    points, blocks = box(kind, 3, 2, 2, noise=0.0)
    model = read_model(written(tmp_path, form, points, blocks))
    surface = model.surface if isinstance(model.surface, Mesh) else model.surface.triangulated()
    assert not model.surface.topology.boundary_loops
    a, b, c = (surface.vertices[surface.faces[:, i]] for i in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(12)
    np.testing.assert_array_equal(model.nodes[model.surface_nodes], model.surface.vertices)
    face = model.surface.attributes.face
    number = np.concatenate([block.ids for block in model.blocks])
    assert (face["element"] == number[model.surface_elements]).all()
    assert (face["property"] == 1).all()
    assert model.surface.attributes.vertex["node"].tolist() == (model.surface_nodes + 101).tolist()


@pytest.mark.parametrize("kind", ["triangle", "quad", "tetra", "hexahedron", "tetra10"])
@pytest.mark.parametrize("form", ["inp", "small"])  # it reads no elements in large field
def test_elements_as_meshio_reads_them(form, kind, tmp_path):
    meshio = pytest.importorskip("meshio")
    points, blocks = sheet() if kind in ("triangle", "quad") else box(kind[:10].rstrip("10"))
    blocks = [(k, t) for k, t in blocks if k == kind or not kind.startswith(("tri", "quad"))]
    points, blocks = second_order(points, blocks) if kind == "tetra10" else (points, blocks)
    path = written(tmp_path, form, points, blocks)
    if form == "inp":  # it knows few of the types
        path.write_text(path.read_text().replace("C3D10M", "C3D10").replace("S3R", "S3"))
    model, peer = read_model(path), meshio.read(path)
    np.testing.assert_array_equal(model.nodes, peer.points)
    assert [(b.kind, b.nodes.tolist()) for b in model.blocks] == [
        (b.type, b.data.tolist()) for b in peer.cells
    ]


@pytest.mark.parametrize("suffix", ["vtu", "vtk", "msh", "mesh", "inp", "bdf"])
@pytest.mark.parametrize("form", ["inp", "large"])
def test_into_other_formats(form, suffix, tmp_path):
    """Elements, properties, numbers and sets go along as far as the format has a place."""
    pytest.importorskip("meshio")
    points, blocks = box("hexahedron", 2, 2, 2)
    model = read_model(written(tmp_path, form, points, blocks))
    other = parsed(abaqus(points, blocks, 101))
    model = other if form == "inp" else model
    nodes = shaken(model)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        write_model(tmp_path / f"b.{suffix}", model, nodes)
    again = read_model(tmp_path / f"b.{suffix}")
    rounded = 1e-13 if suffix == "bdf" else 1e-15
    np.testing.assert_allclose(again.nodes, nodes, rtol=0, atol=rounded)
    assert [b.nodes.tolist() for b in again.blocks] == [b.nodes.tolist() for b in model.blocks]
    if suffix in ("inp", "bdf"):
        assert again.node_ids.tolist() == model.node_ids.tolist()
    if suffix in ("vtu", "vtk"):
        assert again.surface.attributes.face["element"].tolist() == (
            model.surface.attributes.face["element"].tolist()
        )
    if suffix != "inp" and not (suffix == "bdf" and form == "inp"):
        assert [b.properties.tolist() for b in again.blocks] == (
            [b.properties.tolist() for b in model.blocks]
        )
    if suffix in ("vtu", "vtk", "inp"):
        for name, rows in model.groups.elements.items():
            assert again.groups.elements[name].tolist() == rows.tolist()
        for name, rows in model.groups.nodes.items():
            assert again.groups.nodes[name].tolist() == rows.tolist()


@pytest.mark.parametrize("version", ["gmsh22", "gmsh"])
@pytest.mark.parametrize("binary", [False, True])
def test_gmsh_there_and_back(version, binary, tmp_path):
    meshio = pytest.importorskip("meshio")
    points, blocks = box("tetra", 2, 2, 2)
    mesh = meshio.Mesh(points, blocks)
    mesh.write(tmp_path / "a.msh", file_format=version, binary=binary)
    model = read_model(tmp_path / "a.msh")
    nodes = shaken(model)
    write_model(tmp_path / "b.msh", model, nodes)
    again = read_model(tmp_path / "b.msh")
    np.testing.assert_array_equal(again.nodes, nodes)
    assert [b.nodes.tolist() for b in again.blocks] == [b.nodes.tolist() for b in model.blocks]
    if not binary:
        write_model(tmp_path / "c.msh", again, model.nodes)
        before, after = (tmp_path / "a.msh").read_text(), (tmp_path / "c.msh").read_text()
        assert before.split("$EndNodes")[1] == after.split("$EndNodes")[1]


def test_vtu_keeps_its_arrays(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    points, [(_, cells)] = box("hexahedron", 2, 2, 2)
    grid = pyvista.UnstructuredGrid({pyvista.CellType.HEXAHEDRON: cells}, points)
    grid.point_data["temperature"] = np.arange(len(points)) * 0.5
    grid.cell_data["part"] = np.arange(len(cells))
    grid.cell_data["set front"] = (np.arange(len(cells)) < 3).astype(np.uint8)
    for suffix in ("vtu", "vtk"):
        grid.save(tmp_path / f"a.{suffix}")
        model = read_model(tmp_path / f"a.{suffix}")
        assert model.groups.elements["front"].tolist() == [0, 1, 2]
        part = model.surface.attributes.face["part"]
        assert part.tolist() == model.surface_elements.tolist()
        nodes = shaken(model)
        write_model(tmp_path / f"b.{suffix}", model, nodes)
        peer = pyvista.read(tmp_path / f"b.{suffix}")
        np.testing.assert_array_equal(peer.points, nodes)
        np.testing.assert_array_equal(peer["temperature"], grid["temperature"])
        np.testing.assert_array_equal(peer["part"], grid["part"])
        assert hk.read(tmp_path / f"a.{suffix}").face_count == model.surface.face_count
    outside = grid.extract_surface(algorithm="dataset_surface")
    assert corners_of(model) == sorted(
        sorted(map(tuple, outside.points[face].tolist())) for face in outside.regular_faces
    )


def test_what_is_not_written(tmp_path):
    model = parsed(abaqus(*sheet()))
    with pytest.raises(InvalidInput, match="nodes have shape"):
        write_model(tmp_path / "b.inp", model, model.nodes[1:])
    nodes = model.nodes.copy()
    nodes[2, 0] = np.nan
    with pytest.raises(NotFinite, match="nodes 2"):
        write_model(tmp_path / "b.inp", model, nodes)
    with pytest.raises(InvalidInput, match="unknown extension"):
        write_model(tmp_path / "b.docx", model, model.nodes)
    pentagon = PolygonMesh(np.eye(5, 3), [[0, 1, 2, 3, 4]])
    with pytest.raises(InvalidInput, match="5 corners"):
        hk.write(tmp_path / "b.bdf", pentagon)
    assert not list(tmp_path.iterdir())


def test_a_warning_where_digits_are_lost(tmp_path):
    model = parsed(nastran(*sheet()), "a.bdf")
    with pytest.warns(UserWarning, match="digits of .* nodes are lost"):
        write_model(tmp_path / "b.bdf", model, model.nodes + 123456789.123456789)


def test_missing_coordinates_and_normals(tmp_path):
    text = "*NODE\n1\n2, 1\n3, 1, 1,\n4, 0, , 0.\n5, 0, 1, , 0., 0., 1.\n"
    text += "*ELEMENT, TYPE=S4\n1, 1, 2, 3, 5\n2, 1, 2, 3, 4\n"
    with pytest.warns(UserWarning, match="normals given with nodes stay"):
        model = parsed(text)
    nodes = model.nodes + np.array([0, 0, 0.5])
    write_model(tmp_path / "a.inp", model, nodes)
    after = (tmp_path / "a.inp").read_text()
    assert after.splitlines()[5].endswith(", .5, 0., 0., 1.")
    with pytest.warns(UserWarning, match="normals"):
        np.testing.assert_array_equal(read_model(tmp_path / "a.inp").nodes, nodes)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_line_ends_and_the_last_line(newline, tmp_path):
    for form in FORMS:
        text, suffix = text_of(form, *sheet())
        path = tmp_path / f"a.{suffix}"
        data = text.replace("\n", newline).removesuffix(newline).encode()
        path.write_bytes(data)
        with warnings.catch_warnings():
            model = read_model(path)
        nodes = shaken(model)
        write_model(path, model, nodes)
        after = path.read_bytes()
        assert after.count(b"\r") in (0, after.count(b"\n"))
        np.testing.assert_allclose(read_model(path).nodes, nodes, rtol=0, atol=1e-13)


def test_shells_on_solids_and_between_them():
    """A shell on the skin gives its labels to it; one between two solids lies inside."""
    points, [(_, cubes)] = box("hexahedron", 2, 1, 1, noise=0.0)
    outer, inner = cubes[0, [0, 1, 2, 3]], cubes[0, [1, 2, 6, 5]]
    text = abaqus(points, [("hexahedron", cubes), ("quad", np.array([outer, inner]))])
    model = parsed(text)
    assert model.surface.face_count == 10
    assert not model.surface.topology.boundary_loops
    assert model.surface.attributes.face["element"].tolist().count(3) == 1
    assert 4 not in model.surface.attributes.face["element"]
    assert model.surface.attributes.face["set set_quad"].sum() == 1


def test_collapsed_elements():
    """A quad with a node twice is a triangle; a brick like that is a wedge."""
    points, [(_, cubes)] = box("hexahedron", 1, 1, 1, noise=0.0)
    wedge = cubes[:, [0, 1, 2, 2, 4, 5, 6, 6]]
    model = parsed(abaqus(points, [("hexahedron", wedge)]))
    assert sorted(np.diff(model.surface.offsets).tolist()) == [3, 3, 4, 4, 4]
    assert not model.surface.topology.boundary_loops
    model = parsed(abaqus(points, [("quad", cubes[:, [0, 1, 2, 2]])]))
    assert np.diff(model.surface.offsets).tolist() == [3]


def test_a_surface_as_a_deck_and_back(tmp_path):
    model = parsed(nastran(*sheet(), first=55), "a.bdf")
    for suffix in ("inp", "bdf"):
        hk.write(tmp_path / f"a.{suffix}", model.surface)
        again = hk.read(tmp_path / f"a.{suffix}")
        np.testing.assert_array_equal(again.vertices, model.surface.vertices)
        for name in ("element", "property") if suffix == "bdf" else ("element",):
            now, then = again.attributes.face, model.surface.attributes.face
            assert now[name][np.argsort(now["element"])].tolist() == (
                then[name][np.argsort(then["element"])].tolist()
            )


def test_real_surfaces(tmp_path):
    mesh = hk.read(real("cad-panel/hexme_s1.obj"))
    for form in ("inp", "large"):
        model = read_model(written(tmp_path, form, mesh.vertices, [("triangle", mesh.faces)]))
        np.testing.assert_array_equal(model.surface.faces, mesh.faces)
        nodes = model.nodes * 1.01
        suffix = "inp" if form == "inp" else "bdf"
        write_model(tmp_path / f"b.{suffix}", model, nodes)
        again = read_model(tmp_path / f"b.{suffix}")
        np.testing.assert_allclose(again.nodes, nodes, rtol=0, atol=1e-14 * mesh.diagonal)
