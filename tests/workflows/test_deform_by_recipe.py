"""A recipe does what the same calls of a deformer do; families are what their members are alone."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

import henkei as hk
from data import real
from henkei.errors import Cancelled, InvalidInput
from henkei.geometry.element_quality import element_quality
from henkei.geometry.rotations import matrices_from_vectors
from henkei.recipes.deform import DeformRecipe
from henkei.shapes import bar
from henkei.shapes.panels import bumper, door_panel, plate_with_holes
from henkei.shapes.profiles import bracket
from henkei.workflows.deform_by_recipe import Deformed, deform_by_recipe, solved, staged
from henkei.workflows.deform_family import deformed_family, first_of
from henkei.workflows.sweeps import combinations, parsed_sweeps, with_values

EXAMPLES = Path(__file__).parents[2] / "examples" / "recipes"


@pytest.fixture(scope="module")
def plate() -> hk.Mesh:
    """100 x 60 mm, holes of radius 5 at (+-36, +-18) and of radius 12 in the middle."""
    return plate_with_holes(600, solid=False)


@pytest.fixture(scope="module")
def beam() -> hk.Mesh:
    return bar(across=4, along=24)


END = {"box": [[6, None, None], [None] * 3]}


def bent(beam, **more) -> Deformed:
    """The beam held at one end, with a handle at the other."""
    handle = {"name": "end", "region": END, "move": more.pop("move", {})}
    recipe = {"fixed": [{"box": [[None] * 3, [0, None, None]]}], "handles": [handle]}
    return deform_by_recipe(beam, recipe | more)


def test_the_calls_of_a_deformer(plate):
    recipe = DeformRecipe.of(
        {
            "fixed": [{"region": "rim 1", "name": "edge"}],
            "features": [
                {"region": "hole 2", "scale": 1.1},
                {"name": "bolt", "region": "hole 3", "radius": 6},
                {"region": {"box": [[20, -4, 0], [24, 4, 0]]}, "keep": "plane", "weight": 3},
            ],
            "handles": [
                {
                    "region": "hole 1",
                    "weight": 1000,
                    "move": {"translation": [1, 2, 8], "rotation": [0, 90, 0], "scale": 1.2},
                }
            ],
            "pins": [{"point": {"face": 40, "barycentric": [0.2, 0.3, 0.5]}, "move": [0, 0, 1]}],
            "offsets": [{"between": ["hole 2", "bolt"]}],
            "settings": {"steps": 2},
            "method": "refined",
        }
    )
    features = hk.geometry.form_features.find_features(plate)
    d = hk.Deformer(plate, settings=hk.deform.Settings(steps=2))
    d.fix(features["rim 1"])
    a = d.feature(features["hole 2"], name="hole 2")
    b = d.feature(features["hole 3"], keep="circle", name="bolt")
    inside = (np.abs(plate.vertices - [22, 0, 0]) <= [2, 4, 0]).all(axis=1)
    d.feature(inside, keep="plane", weight=3)
    handle = d.handle(features["hole 1"], weight=1000)
    pin = d.pin((40, [0.2, 0.3, 0.5]))
    d.keep_offset(a, b)
    a.scale, b.radius = 1.1, 6
    handle.move([1, 2, 8], np.radians([0, 90, 0]), 1.2)
    pin.move(pin.rest + np.array([0, 0, 1]))
    expected = d.solve(method="refined")
    done = deform_by_recipe(plate, recipe)
    np.testing.assert_array_equal(done.mesh.vertices, expected)
    np.testing.assert_array_equal(done.mesh.faces, plate.faces)
    assert done.quality.method == "refined"
    elements = element_quality(done.mesh)
    assert done.figures["worst_scaled_jacobian"] == elements.worst_scaled_jacobian
    names = [body.name for body in staged(recipe, plate).deformer.features]
    assert names == ["hole 2", "bolt", "feature 3"]


@pytest.mark.parametrize(
    ("name", "mesh"),
    [
        ("bumper", lambda: bumper(2000)),
        ("bracket", lambda: bracket(size=1000)),
        ("bracket", lambda: bracket("U", 1000, quads=True)),
        ("door", lambda: door_panel(2000)),
        ("hood", lambda: hk.read(real("cad-panel/f50_hood.obj"))),
    ],
)
def test_examples(name, mesh):
    surface, recipe = mesh(), DeformRecipe.read(EXAMPLES / f"{name}.json")
    stage = staged(recipe, surface)
    done = solved(stage, recipe)
    assert type(done.mesh) is type(surface)
    np.testing.assert_array_equal(done.mesh.indices, surface.indices)
    assert done.quality.hard_position_error < 1e-12
    assert done.quality.feature_error < 1e-9
    moved = done.mesh.vertices - surface.vertices
    for handle, part in zip(stage.handles, recipe.handles, strict=True):
        mean = moved[handle.vertices].mean(axis=0)
        np.testing.assert_allclose(mean, part.move.translation, atol=1e-9)
    if recipe.symmetry:
        mirrored = done.mesh.vertices * [-1, 1, 1]
        far, _ = KDTree(done.mesh.vertices).query(mirrored)
        assert far.max() < 1e-9 * surface.diagonal


def test_a_radius_is_exact():
    surface = door_panel(2000)
    recipe = DeformRecipe.read(EXAMPLES / "door.json")
    stage = staged(recipe, surface)
    positions = solved(stage, recipe).mesh.vertices
    circle = hk.geometry.form_features.fitted_circle(positions[stage.features[0][0].vertices])
    assert abs(circle.radius - 12.5) < 1e-9


@pytest.mark.parametrize(
    "rotation",
    [
        [0, 0, 40],
        [30, -20, 400],
        {"axis": [0, 3, 0], "angle": -75},
        {"axis": [1e-200, 0, 0], "angle": 9},
    ],
)
def test_turns_and_scales_about_a_point(beam, rotation):
    about = np.array([5.0, 1.0, -2.0])
    move = {"translation": [1, 2, 3], "rotation": rotation, "scale": 1.3, "about": about.tolist()}
    done = bent(beam, move=move)
    if isinstance(rotation, dict):
        vector = np.sign(rotation["axis"]) * rotation["angle"]
    else:
        vector = np.array(rotation)
    turn = matrices_from_vectors(np.radians(vector)[None])[0]
    end = beam.vertices[:, 0] == 6
    expected = about + 1.3 * (beam.vertices[end] - about) @ turn.T + [1, 2, 3]
    np.testing.assert_allclose(done.mesh.vertices[end], expected, atol=1e-12)


def test_without_a_point_it_is_the_centroid(beam):
    centroid = beam.vertices[beam.vertices[:, 0] == 6].mean(axis=0).tolist()
    move = {"rotation": [10, 20, 30], "scale": 0.7}
    a, b = bent(beam, move=move), bent(beam, move=move | {"about": centroid})
    np.testing.assert_allclose(a.mesh.vertices, b.mesh.vertices, atol=1e-12)


def test_identity_gives_the_mesh_back(beam):
    error = np.abs(bent(beam).mesh.vertices - beam.vertices).max()
    assert error < 1e-10 * beam.diagonal


def test_pins(beam):
    rest = np.array([3.1, 0.5, 0.2])
    quads = bar(across=4, along=24, quads=True)
    for surface in (beam, quads):
        for target in ({"move": [0, 1, 0]}, {"to": [3.1, 1.5, 0.2]}):
            done = bent(surface, pins=[{"point": [3.1, 0.55, 0.2], **target}])
            stage = staged(
                DeformRecipe.of({"fixed": ["pad 5"], "pins": [{"point": [3.1, 0.55, 0.2]}]}),
                surface,
            )
            pin = stage.pins[0]
            np.testing.assert_allclose(pin.rest, rest, atol=1e-12)
            now = pin.coefficients @ done.mesh.vertices[pin.vertices]
            np.testing.assert_allclose(now, rest + np.array([0, 1, 0]), atol=1e-9)
    i, j = beam.topology.edges[100].tolist()
    stage = staged(
        DeformRecipe.of(
            {
                "fixed": ["pad 5"],
                "pins": [{"point": {"edge": [i, j], "at": 0.25}}, {"point": 7}],
            }
        ),
        beam,
    )
    a, b = beam.vertices[[i, j]]
    np.testing.assert_allclose(stage.pins[0].rest, a + 0.25 * (b - a), atol=1e-15)
    np.testing.assert_array_equal(stage.pins[1].rest, beam.vertices[7])


def test_one_name_for_several_features(plate):
    recipe = DeformRecipe.of({"fixed": ["rim 1"], "features": ["hole *"]})
    stage = staged(recipe, plate)
    assert [feature.name for feature in stage.features[0]] == [f"hole {k}" for k in range(1, 6)]
    together = DeformRecipe.of(
        {"fixed": ["rim 1"], "features": [{"name": "pattern", "region": "hole *"}]}
    )
    (pattern,) = staged(together, plate).features[0]
    assert len(pattern.vertices) == sum(len(feature.vertices) for feature in stage.features[0])


def test_options_of_finding(beam):
    region = {"fixed": ["line 5"]}
    staged(DeformRecipe.of(region), beam)
    with pytest.raises(InvalidInput, match="no feature 'line 5'"):
        staged(DeformRecipe.of(region | {"finding": {"shortest": 0.5}}), beam)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"fixed": ["rim 2"]}, "fixed[0].region.feature: the mesh has no feature 'rim 2'"),
        (
            {"fixed": ["rim 1"], "features": ["hole 1", "hole 7"]},
            "features[1].region: the mesh has no feature 'hole 7'",
        ),
        (
            {"fixed": ["rim 1"], "handles": [{"name": "top", "region": {"boundary_loop": 1}}]},
            "'top' and 'fixed 1' overlap",
        ),
        (
            {"features": ["hole *"], "offsets": [{"between": ["hole 1", "hole 8"]}]},
            "offsets[0].between: there is no feature 'hole 8'",
        ),
        ({"fixed": ["rim 1"], "symmetry": {"normal": [1, 2, 0]}}, "symmetry: the mesh is not"),
        ({"fixed": ["rim 1"], "pins": [{"point": 10**6}]}, "'pin 1'"),
        (
            {"fixed": ["rim 1"], "pins": [{"point": [-20, 0, 7]}]},
            "pins[0].point: [-20.0, 0.0, 7.0] is 7 away from the surface, more than 1% of its "
            "diagonal; the point nearest to it is [-20.0, 0.0, 0.0]",
        ),
        (
            {"fixed": ["rim 1", {"grow": {"region": "hole 1"}}], "features": ["hole 1", "hole 2"]},
            'as in {"without": [{"grow": {"region": "hole 1"}}, "hole 1"]}, or make one part soft',
        ),
        (
            {"fixed": ["hole *"], "features": ["hole 1", "hole 2"]},
            "'hole 1' and 'fixed 1' overlap in 24 vertices",
        ),
        (
            {"fixed": ["rim 1"], "features": ["hole 2", {"name": "two", "region": "hole 2"}]},
            "these two regions are one, so leave one of them out, or make one part soft",
        ),
        ({"fixed": ["rim 1"], "features": [{"region": "rim 1", "keep": "line"}]}, "'rim 1'"),
    ],
)
def test_what_does_not_fit_the_mesh_is_named(plate, data, told):
    with pytest.raises(InvalidInput) as caught:
        staged(DeformRecipe.of(data), plate)
    assert told in str(caught.value)


def test_all_overlaps_are_told_at_once(plate):
    recipe = {"fixed": [{"box": [[None] * 3, [-1, None, None]]}], "features": ["hole *"]}
    with pytest.raises(InvalidInput) as caught:
        staged(DeformRecipe.of(recipe), plate)
    left = [
        f"'{hole.name}' and 'fixed 1' overlap"
        for hole in hk.find_features(plate).holes
        if (plate.vertices[hole.vertices, 0] <= -1).any()
    ]
    assert len(left) == 3
    assert all(told in str(caught.value) for told in left)
    assert str(caught.value).count("overlap") == 3
    cure = ', "hole 1", "hole 2", "hole 3"]}, or make one part soft'
    assert cure in str(caught.value)


def test_meshes_and_recipes_are_taken_in_any_form(tmp_path, plate):
    rim = hk.find_features(plate)["rim 1"].vertices
    (tmp_path / "rim.txt").write_text(" ".join(map(str, rim)))
    data = {"fixed": [{"file": "rim.txt"}], "features": [{"region": "hole 3", "radius": 6}]}
    recipe = DeformRecipe.of(data)
    recipe.write(tmp_path / "change.json")
    hk.write(tmp_path / "plate.obj", plate)
    wanted = deform_by_recipe(plate, recipe, folder=tmp_path).mesh.vertices
    assert np.abs(wanted - plate.vertices).max() > 0.9
    for done in (
        deform_by_recipe((plate.vertices, plate.faces), data, folder=tmp_path),
        deform_by_recipe(str(tmp_path / "plate.obj"), tmp_path / "change.json"),
    ):
        np.testing.assert_allclose(done.mesh.vertices, wanted, atol=1e-9)


def test_the_recipe_first_is_refused(plate):
    with pytest.raises(InvalidInput, match=r"mesh comes before .*: deform_by_recipe\(mesh, recipe"):
        deform_by_recipe(DeformRecipe.of({"fixed": ["rim 1"]}), plate)


@pytest.mark.parametrize(("fixed", "told"), [([], "nothing is fixed;"), (["soft"], "but softly;")])
def test_something_must_be_fixed(plate, fixed, told):
    parts = [{"region": "rim 1", "weight": 2} for _ in fixed]
    with pytest.raises(InvalidInput, match=rf'{told} say what stays, as in "fixed": \["rim 1"\]'):
        deform_by_recipe(plate, {"fixed": parts})


def test_poses_do_not_depend_on_the_ones_before(plate):
    def recipe(**size):
        feature = {"region": "hole 3", "keep": "circle", **size}
        return DeformRecipe.of({"fixed": ["rim 1"], "features": [feature]})

    stage = staged(recipe(), plate)
    for size, radius in (
        ({"radius": 6}, 6),
        ({}, 5),
        ({"scale": 1.2, "radius": 4}, 4),
        ({"scale": 1.2}, 6),
        ({}, 5),
    ):
        stage.pose(recipe(**size))
        np.testing.assert_allclose(stage.features[0][0].radius, radius)


def family_of(recipe, surface, texts, write=None):
    sweeps = parsed_sweeps(texts, recipe)
    meshes = {}

    def keep(number, done):
        meshes[number] = done.mesh
        return Path(f"{number}.obj")

    stage = staged(first_of(recipe, sweeps), surface)
    return sweeps, meshes, deformed_family(stage, recipe, sweeps, write or keep)


@pytest.fixture(scope="module")
def swept() -> DeformRecipe:
    return DeformRecipe.of(
        {
            "fixed": ["rim 1"],
            "features": ["hole 1", {"region": "hole 4"}],
            "handles": [{"region": {"sphere": {"center": [20, 0, 0], "radius": 4}}}],
            "pins": [{"point": [-20, 0, 0]}],
            "method": "refined",
        }
    )


def test_each_member_is_what_its_recipe_gives_alone(plate, swept):
    texts = ["handle 1.z=0:6:3", "handle1.rx=0,200", "hole 4.radius=4,6", "pin 1.z=-1"]
    sweeps, meshes, family = family_of(swept, plate, texts)
    assert family.parameters == ("handle 1.z", "handle 1.rx", "hole 4.radius", "pin 1.z")
    assert [member.values for member in family.members] == combinations(sweeps)
    assert not family.failed
    for member in family.members[::4]:
        alone = deform_by_recipe(plate, with_values(swept, sweeps, member.values))
        mesh = meshes[member.number]
        np.testing.assert_array_equal(mesh.faces, plate.faces)
        np.testing.assert_allclose(mesh.vertices, alone.mesh.vertices, atol=1e-9)
        elements = element_quality(mesh)
        assert member.figures["worst_scaled_jacobian"] == elements.worst_scaled_jacobian
        assert member.figures["worst_aspect_ratio"] == elements.worst_aspect_ratio
        assert member.figures["hard_position_error"] < 1e-9
        assert member.figures["feature_error"] < 1e-9


def test_a_member_that_fails_does_not_stop_the_others(plate, swept):
    _, meshes, family = family_of(swept, plate, ["hole 4.radius=4,-1,6"])
    assert [member.number for member in family.failed] == [2]
    assert "radius of 'hole 4' must be positive" in family.failed[0].error
    assert sorted(meshes) == [1, 3]
    rows = list(csv.DictReader(io.StringIO(family.table())))
    assert [row["file"] for row in rows] == ["1.obj", "", "3.obj"]
    assert [float(row["hole 4.radius"]) for row in rows] == [4, -1, 6]
    assert rows[1]["error"] == family.failed[0].error
    told = family.as_dict()["members"]
    assert [set(row) >= {"file", "worst_scaled_jacobian"} for row in told] == [True, False, True]
    assert float(rows[2]["worst_scaled_jacobian"]) == told[2]["worst_scaled_jacobian"]


def test_a_file_that_cannot_be_written_is_a_failure_of_its_member(plate, swept):
    def refuse(number, done):
        if number == 2:
            raise InvalidInput("the disk is full")
        return Path("x")

    _, _, family = family_of(swept, plate, ["handle 1.z=0,1,2"], refuse)
    assert [member.error for member in family.members] == ["", "the disk is full", ""]

    def cancel(number, done):
        raise Cancelled("enough")

    with pytest.raises(Cancelled):
        family_of(swept, plate, ["handle 1.z=0,1,2"], cancel)
