"""Combining by recipe: the bytes of the plain call."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.recipes.combine import CombineRecipe
from henkei.shapes import grid, random_disk
from henkei.workflows.combine_by_recipe import combine_by_recipe, combined, pair_array

A, B = random_disk(0, 30), random_disk(1, 40)
PAIRS = [[0, 0], [5, 6], [10, 12]]
COLORS = hk.Attributes(vertex={"color": np.linspace(0, 1, 90).reshape(30, 3)})
COLOURED = hk.Mesh(A.vertices, A.faces, attributes=COLORS)


def points(mesh_a: hk.Mesh, mesh_b: hk.Mesh, pairs: list[list[int]]) -> list[list[list[float]]]:
    return [[mesh_a.vertices[i].tolist(), mesh_b.vertices[j].tolist()] for i, j in pairs]


def ring() -> hk.Mesh:
    whole = grid(4, 4)
    inner = np.isin(whole.faces, [12]).any(axis=1)
    return hk.without_unused_vertices(hk.Mesh(whole.vertices, whole.faces[~inner]))


def saved(folder: Path, result: hk.CombinedMesh) -> bytes:
    hk.save(folder / "c.npz", result)
    return (folder / "c.npz").read_bytes()


RIM = len(B.topology.boundary_loops[0])
INSIDE = [[20, RIM + int(np.linalg.norm(B.vertices[RIM:] - A.vertices[20], axis=1).argmin())]]


@pytest.mark.parametrize(
    ("a", "b", "data", "plain"),
    [
        (A, B, {}, lambda: hk.combine(A, B)),
        (A, B, {"pairs": "auto"}, lambda: hk.combine(A, B, "auto")),
        (
            A,
            B,
            {"pairs": PAIRS, "landmarks": INSIDE},
            lambda: hk.combine(A, B, PAIRS, landmarks=INSIDE),
        ),
        (
            A,
            B,
            {
                "pairs": points(A, B, PAIRS),
                "landmarks": points(A, B, INSIDE),
                "snap": 0,
            },
            lambda: hk.combine(A, B, PAIRS, landmarks=INSIDE),
        ),
        (
            A,
            B.flipped(),
            {"pairs": PAIRS, "flip_b": True},
            lambda: hk.combine(A, B.flipped().flipped(), PAIRS),
        ),
        (COLOURED, B, {"pairs": PAIRS}, lambda: hk.combine(COLOURED, B, PAIRS)),
        (
            COLOURED,
            B,
            {"pairs": PAIRS, "attributes": False},
            lambda: hk.combine(COLOURED, B, PAIRS, attributes=False),
        ),
        (A, B, {"pairs": PAIRS, "align": True}, lambda: hk.combine(A, B, PAIRS).aligned()),
        (ring(), ring(), {"fill_holes": True}, lambda: hk.combine(ring(), ring(), fill_holes=True)),
        (
            ring(),
            ring(),
            {"fill_holes": True, "drop_fill": True, "outer": [0, None]},
            lambda: hk.combine(ring(), ring(), fill_holes=True, outer=(0, None)).without_fill(),
        ),
    ],
)
def test_the_same_as_the_plain_call(tmp_path, a, b, data, plain):
    recipe = CombineRecipe.of(data)
    recipe.write(tmp_path / "r.json")
    expected = saved(tmp_path, plain())
    assert saved(tmp_path, combine_by_recipe(a, b, tmp_path / "r.json")) == expected
    assert saved(tmp_path, hk.combine_by_recipe(a, b, data)) == expected


def test_before_it_is_aligned():
    recipe = CombineRecipe.of({"pairs": PAIRS, "align": True})
    np.testing.assert_array_equal(
        combined(A, B, recipe).vertices_b, hk.combine(A, B, PAIRS).vertices_b
    )


def test_the_pairs_that_were_used_make_a_recipe_of_the_same_result(tmp_path):
    proposed = combine_by_recipe(A, B, {})
    again = CombineRecipe.of({"pairs": proposed.pairs.tolist()})
    assert saved(tmp_path, combine_by_recipe(A, B, again)) == saved(tmp_path, proposed)


def test_meshes_from_files_and_progress(tmp_path):
    hk.write(tmp_path / "a.obj", A)
    hk.write(tmp_path / "b.ply", B)
    told = []
    files = tmp_path / "a.obj", tmp_path / "b.ply"
    result = combine_by_recipe(
        *files, {"pairs": PAIRS}, progress=lambda message, fraction: told.append(fraction)
    )
    assert saved(tmp_path, result) == saved(tmp_path, hk.combine(*files, PAIRS))
    assert told[0] == 0
    assert told[-1] == 1


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"pairs": PAIRS[:2]}, "2 pairs of corresponding boundary vertices were given"),
        ({"pairs": []}, "0 pairs of corresponding"),
        ({"pairs": [*PAIRS, [99, 1]]}, "pairs name vertices 99 of a, which has 30"),
        ({"pairs": [*PAIRS, [20, 1]]}, "pairs are taken from the boundary loops only"),
        ({"landmarks": [[0, 20]]}, "landmarks 0 of a are not inside the surface"),
        ({"landmarks": [[[9, 9, 9], [0, 0, 0]]]}, "the points of landmarks 0 are not near"),
        ({"pairs": {}}, "pairs: should be a list of pairs"),
    ],
)
def test_a_refusal_names_the_field(data, told):
    with pytest.raises(InvalidInput) as caught:
        combine_by_recipe(A, B, data)
    assert told in str(caught.value)


def test_pairs_as_arrays():
    for given, dtype in ((PAIRS, np.int64), (points(A, B, PAIRS), np.float64), ([], np.int64)):
        recipe = CombineRecipe.of(json.loads(json.dumps({"pairs": given})))
        found = pair_array(recipe.pairs)
        assert found.dtype == dtype
        assert found.tolist() == given
    assert pair_array(()).shape == (0, 2)
