"""What decks of simulation codes may hold, and how faults in them are told."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidFile
from henkei.io.abaqus_keywords import kind_of
from henkei.io.cae import read_model
from models import FORMS, parsed, second_order, sheet, text_of


def quietly(text: str, name: str = "a.inp"):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return parsed(text, name)


PARTS = """*Heading
*PART, NAME=Door
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
9, 5, 5, 5
*ELEMENT, TYPE=s4r, ELSET="Outer skin"
1, 1, 2, 3, 4
*NSET, NSET=Hole
1, 2
*SHELL SECTION, ELSET="Outer skin", MATERIAL=steel
1.2
*END PART
*PART, NAME=HINGE
*NODE
1, 2, 0, 0
2, 3, 0, 0
3, 3, 1, 0
*ELEMENT, TYPE=S3
1, 1, 2, 3
*ELSET, ELSET=all, GENERATE
1, 1
*END PART
*ASSEMBLY, NAME=Assembly
*INSTANCE, NAME=Door-1, PART=Door
*END INSTANCE
*INSTANCE, NAME=Hinge-1, PART=HINGE
*END INSTANCE
*NODE
1, 7, 7, 7
*NSET, NSET=both, INSTANCE=door-1
 Hole, 4
*NSET, NSET=both
 Hinge-1.3, 1
*ELEMENT, TYPE=CONN3D2
1, Door-1.1, Hinge-1.1
*END ASSEMBLY
"""


def test_parts_and_instances():
    with pytest.warns(UserWarning, match=r"CONN3D2 \(1\) stay in the file"):
        model = parsed(PARTS)
    assert model.surface.face_count == 2
    assert model.surface_nodes.tolist() == [0, 1, 2, 3, 5, 6, 7]
    assert model.groups.nodes["Hole"].tolist() == [0, 1]
    assert model.groups.nodes["both"].tolist() == [0, 1, 3, 7, 8]
    assert model.groups.elements["Outer skin"].tolist() == [0]
    assert model.surface.attributes.face["property"].tolist() == [1, 0]
    assert model.surface.attributes.face["set Outer skin"].tolist() == [1, 0]


FAULTS = [
    ("*Heading", "*INCLUDE, INPUT=mesh.inp", "line 1: the model goes on in 'mesh.inp'"),
    ("*Heading", "*SYSTEM\n1, 0, 0", "line 1: .SYSTEM moves"),
    ("*NSET, NSET=Hole", "*NGEN\n", "line 11: .NGEN makes nodes"),
    ("2, 1, 0, 0", "1, 1, 0, 0", "line 5: node 1 is already there, on line 4"),
    ("2, 1, 0, 0", "2, 1, zero, 0", "line 5: 'zero' is not a number"),
    ("2, 1, 0, 0", "2, 1, nan, 0", "line 5: 'nan' is not a number"),
    ("2, 1, 0, 0", "2, 1, 1e999, 0", "line 5: '1e999' is not a number"),
    ("2, 1, 0, 0", "2.5, 1, 0, 0", "line 5: '2.5' is not a whole number"),
    ("2, 1, 0, 0", ", 1, 0, 0", "line 5: a node without a number"),
    ("1, 1, 2, 3, 4", "1, 1, 2, 3", "line 10: an element of type S4R has a number and 4 nodes"),
    ("1, 1, 2, 3, 4", "1, 1, 2, 3, 8", "line 10: element 1 names node 8, which is not there"),
    ("1, 1, 2, 3, 4", "1, 1, 2, 3, 4\n1, 4, 3, 2, 1", "line 11: element 1 is already there"),
    (" Hole, 4", " Hole, 4, nothing", "line 33: there is no set 'nothing'"),
    ("PART=Door", "PART=Roof", "there is no part 'ROOF'"),
    ("PART=HINGE\n", "PART=HINGE\n1, 0, 0\n", "line 29: instance 'HINGE-1' puts its part"),
    ("*NODE\n1, 0", "*NODE, SYSTEM=C\n1, 0", "line 3: nodes in SYSTEM=C are not read"),
]


@pytest.mark.parametrize(("before", "after", "message"), FAULTS)
def test_faults_of_abaqus(before, after, message):
    assert before in PARTS
    with pytest.raises(InvalidFile, match=message):
        quietly(PARTS.replace(before, after, 1))


BULK = """SOL 101
CEND
BEGIN BULK
GRID    1               0.      0.      0.
GRID    2               1.      0.      0.      $ a comment
GRID,3,,1.+0,1.,
grid*   4                               0.              1.              +
+       0.
GRID    5               5.      5.      5.
CQUAD4  1       7       1       2       3       4
CTRIA3,2,8,1,2,3
CBAR    3       9       3       5       0.      0.      1.
RBE2    4       5       123     1       2
RBE3    5               5       123     1.      123     1       2
+       3       2.0     123     4
SET1    6       1       THRU    3
SET3    7       ELEM    2
SPC     1       1       123456
ENDDATA
"""
BULK = BULK.replace("+\n+       0.", "\n*                     0.")


def test_a_deck_of_all_fields():
    with pytest.warns(UserWarning, match=r"RBE2 \(1\), RBE3 \(1\)"):
        model = parsed(BULK, "a.nas")
    expected = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]]
    assert model.nodes.tolist() == expected
    assert model.surface.attributes.face["property"].tolist() == [7, 8]
    assert model.groups.nodes["6"].tolist() == [0, 1, 2]
    assert model.groups.elements["7"].tolist() == [1]
    links = {tuple(pair) for pair in np.sort(model.links, axis=1).tolist()}
    assert links == {(2, 4), (0, 4), (1, 4), (3, 4)}


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("GRID    2 ", "GRID    1 ", "line 5: GRID 1 is already there, on line 4"),
        ("0.      0.      0.", "0.      0.      x.", "line 4: 'x.' is not a number"),
        ("       2       3       4", "       2       3       6", "line 10: CQUAD4 1 names node 6"),
        ("       2       3       4", "       2       3", "line 10: CQUAD4 1 lacks a node"),
        ("GRID,3,,", "GRID,3,4,", "line 6: GRID 3 is given in coordinate system 4"),
        ("GRID,3,,", "GRDSET,,5\nGRID,3,,", "line 4: GRID 1 is given in coordinate system 5"),
        ("CTRIA3,2,", "CTRIA3,1,", "element 1 is already there"),
        ("BEGIN BULK", "INCLUDE 'mesh.bdf'\nBEGIN BULK", "line 3: the model goes on in 'mesh.bdf'"),
        ("*                     0.", "+       0.", "line 7: a GRID card that goes on in another"),
        ("BEGIN BULK", "BEGIN SUPER=1", "line 3: superelements are not read"),
        ("BEGIN BULK\n", "BEGIN BULK\n+       1.\n", "line 4: a continuation without a card"),
        ("GRID    2 ", "GRID\t2 ", "line 5: a tab"),
    ],
)
def test_faults_of_nastran(before, after, message):
    assert before in BULK
    with pytest.raises(InvalidFile, match=message):
        quietly(BULK.replace(before, after, 1), "a.bdf")


@pytest.mark.parametrize("suffix", ["inp", "bdf", "dat"])
def test_what_is_no_model(suffix, tmp_path):
    for text, message in [
        ("", "empty"),
        ("hello\n\nworld, 1, 2\n", "no .NODE|no GRID"),
        ("a\0b", "byte 1 is zero"),
    ]:
        (tmp_path / f"a.{suffix}").write_text(text)
        with pytest.raises(InvalidFile, match=message):
            read_model(tmp_path / f"a.{suffix}")
    with pytest.raises(InvalidFile, match="no such file"):
        read_model(tmp_path / "b.inp")
    with pytest.raises(InvalidFile, match="no shell and no solid elements, only T3D2"):
        parsed("*NODE\n1, 0\n2, 1\n*ELEMENT, TYPE=T3D2\n1, 1, 2\n")


@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_damaged_decks(form, data):
    """Whatever happens to a deck: a sound model, or InvalidFile."""
    points, blocks = second_order(*sheet(2, 2))
    text, suffix = text_of(form, points, blocks)
    place = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 60))
    put = data.draw(st.text(alphabet="0123456789+-.,*$eEdD \n=GRIDCTX\t\0", max_size=12))
    damaged = text[:place] + put + text[place + length :]
    try:
        model = quietly(damaged, f"a.{suffix}")
    except InvalidFile:
        return
    assert np.isfinite(model.nodes).all()
    assert 0 <= model.surface.indices.min() <= model.surface.indices.max() < len(model.nodes)
    assert model.surface_nodes.max() < len(model.nodes)


def test_types_of_abaqus():
    kinds = {
        "triangle": "S3 S3R STRI3 M3D3 R3D3 CPS3 CAX3 SFM3D3",
        "quad": "S4 S4R S4RSW S4R5 M3D4R CPE4 CAX4P DS4",
        "triangle6": "STRI65 CPS6M M3D6",
        "quad8": "S8R S8R5 CPE8R SFM3D8R",
        "quad9": "S9R5",
        "tetra": "C3D4 C3D4H DC3D4",
        "tetra10": "C3D10 C3D10M C3D10MH",
        "wedge": "C3D6 SC6R",
        "wedge15": "C3D15",
        "hexahedron": "C3D8R C3D8I SC8R CSS8 DC3D8",
        "hexahedron20": "C3D20R C3D20RH",
        "line": "T3D2 B31 B31OS B33 PIPE31",
        "line3": "T3D3 B32 B22",
        "": "CONN3D2 SPRINGA MASS SAX1 R2D2 RB3D2 COH3D8 C3D15V C3D27 GK3D8",
    }
    for kind, names in kinds.items():
        assert [kind_of(name) for name in names.split()] == [kind] * len(names.split())
