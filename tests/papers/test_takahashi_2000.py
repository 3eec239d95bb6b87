"""What the paper's equations say, by dense matrices and closed forms.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import csr_array, hstack, vstack

from cages import CAGES, WAYS, faces_of, levels_of, pinned, prism
from henkei.design.filters import INTERPOLATING, filters
from henkei.design.inner_products import hat_products
from henkei.design.literal import filtered, literal_details, literal_surfaces
from henkei.design.multilevel import powers
from henkei.design.refinement import Connectivity, connectivity, prolongation, refined
from henkei.design.smoothing import PASS_BAND, STEP
from henkei.shapes import torus_cage
from oracles import multiresolution as oracle

GAMMA = (2.0, 0.5, 1.0)  # of the axes
STEPS = 8
P, Q = oracle.TAUBIN

ways = pytest.mark.parametrize(("name", "quads"), WAYS)
supports = pytest.mark.parametrize("support", [None, INTERPOLATING, 1])


def constrained(name: str, quads: bool, finest: int = 2, pins: bool = True):
    """Levels of a cage, their M(k) and r(k); the whole cage pinned at level 0, or some places."""
    cage = CAGES[name]()
    levels = levels_of(cage, finest, quads)
    rows, targets = zip(
        *(pinned(3, seed, c.vertex_count) for seed, c in enumerate(levels)), strict=True
    )
    if not pins:
        return levels, list(rows), list(targets)
    return levels, [np.eye(len(cage.vertices)), *rows[1:]], [cage.vertices, *targets[1:]]


def sparse(rows: list[np.ndarray]) -> list[csr_array]:
    return [csr_array(r) for r in rows]


def close(found, expected, within: float) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=within * np.abs(expected).max())


@pytest.mark.parametrize(("quads", "expected"), [(False, (10, 24, 16)), (True, (14, 24, 12))])
def test_figure_1(quads, expected):
    """A tetrahedron in triangles and in quads: its shape stays as it is."""
    cage = CAGES["tetrahedron"]()
    coarse = connectivity(cage)
    fine = refined(coarse, quads)
    assert (fine.vertex_count, len(fine.edges), fine.face_count) == expected
    points = prolongation(coarse, quads) @ cage.vertices
    children = 3 if quads else 4
    for number, face in enumerate(faces_of(fine)):
        origin, *sides = cage.vertices[cage.faces[number // children]]
        normal = np.cross(*(np.array(sides) - origin))
        assert np.abs((points[face] - origin) @ normal).max() < 1e-15
        around = points[face] - points[face].mean(axis=0)
        assert (np.cross(around, np.roll(around, -1, axis=0)) @ normal > 0).all()


@ways
@supports
def test_analysis_and_synthesis_are_inverse(name, quads, support):
    """Eq. 5 to rounding, and what it is for: eq. 3 and 4."""
    coarse, fine = levels_of(CAGES[name](), 2, quads)[1:]
    bank = filters(coarse, fine, 1, support)
    both = vstack([bank.analysis, bank.details]).toarray()
    whole = hstack([bank.synthesis, bank.wavelets]).toarray()
    assert np.abs(both @ whole - np.eye(fine.vertex_count)).max() < 1e-14
    assert np.abs(whole @ both - np.eye(fine.vertex_count)).max() < 1e-14
    points = np.random.default_rng(0).normal(size=(fine.vertex_count, 3))
    again = bank.synthesis @ (bank.analysis @ points) + bank.wavelets @ (bank.details @ points)
    close(again, points, 1e-14)


@ways
def test_inner_products_follow_from_the_next_level(name, quads):
    """Eq. 8 to rounding."""
    for level, (coarse, fine) in enumerate(pairwise(levels_of(CAGES[name](), 3, quads))):
        synthesis = oracle.prolongation(coarse, fine)
        expected = oracle.hat_products(coarse, level, quads)
        found = synthesis.T @ hat_products(fine, level + 1).toarray() @ synthesis
        close(found, expected, 1e-14)


@ways
@pytest.mark.parametrize("support", [None, 0, 1])
def test_wavelets_are_least_squares_projections(name, quads, support):
    """Eq. 9 on the support of each."""
    coarse, fine = levels_of(CAGES[name](), 1, quads)
    alpha = filters(coarse, fine, 0, support).alpha.toarray()
    products = oracle.hat_products(coarse, 0, quads)
    mixed = oracle.hat_products(fine, 1, quads) @ oracle.prolongation(coarse, fine)
    left, right = products @ alpha, mixed[coarse.vertex_count :].T
    rho = oracle.within(coarse, fine, support)
    close(left[rho], right[rho], 1e-14)
    assert not alpha[~rho].any()


@ways
@supports
def test_filters_are_made_of_midpoints_and_lifting(name, quads, support):
    """Eq. 10 and 11."""
    coarse, fine = levels_of(CAGES[name](), 1, quads)
    bank = filters(coarse, fine, 0, support)
    middles = oracle.prolongation(coarse, fine)[coarse.vertex_count :]
    alpha, old, new = bank.alpha.toarray(), np.eye(len(middles.T)), np.eye(len(middles))
    blocks = {
        "synthesis": [[old], [middles]],
        "wavelets": [[-alpha], [new - middles @ alpha]],
        "analysis": [[old - alpha @ middles, alpha]],
        "details": [[-middles, new]],
    }
    for field, expected in blocks.items():
        np.testing.assert_allclose(getattr(bank, field).toarray(), np.block(expected), atol=1e-16)


@pytest.mark.parametrize("dependent", [False, True])
def test_constraints_are_met_by_the_least_move(dependent):
    """Eq. 18: by the Lagrange function it comes from, and by its closed form."""
    c = levels_of(CAGES["torus of quads"](), 1)[1]
    rows, right = pinned(6, 1, c.vertex_count)
    if dependent:
        rows, right = (
            np.vstack([rows, rows[:2] - rows[2:4]]),
            np.vstack([right, right[:2] - right[2:4]]),
        )
    start = np.random.default_rng(2).normal(size=(c.vertex_count, 3))
    moved = filtered(c, start, csr_array(rows), right, steps=0) - start
    close(rows @ (start + moved), right, 1e-14)
    zero = np.zeros((len(rows), len(rows)))
    system = np.block([[np.eye(c.vertex_count), rows.T], [rows, zero]])
    sides = np.vstack([0 * start, right - rows @ start])
    close(moved, np.linalg.lstsq(system, sides, rcond=None)[0][: c.vertex_count], 1e-13)


def test_factors_of_taubin():
    """6.1: 0 < p < 1, q < -p, 1/p + 1/q = 0.1."""
    assert (STEP, PASS_BAND) == (0.33, 0.1)
    assert -Q > P
    assert pytest.approx(0.1) == 1 / P + 1 / Q
    frequency = np.linspace(0, 2, 2001)  # k
    gain = (1 - P * frequency) * (1 - Q * frequency)
    kept = frequency <= 0.1
    assert (gain[kept] >= 1 - 1e-15).all()
    assert gain.max() == pytest.approx(1 - P * Q / 400)  # at k = 0.05: no more than 1.0003
    assert np.abs(gain[~kept]).max() < 1


def unconstrained(c: Connectivity, start: np.ndarray, steps: int) -> np.ndarray:
    return filtered(c, start, csr_array((0, len(start))), np.zeros((0, start.shape[1])), steps)


@pytest.mark.parametrize("waves", [(0, 0), (1, 0), (0, 2), (3, 1), (4, 3)])
@pytest.mark.parametrize("steps", [1, 5])
def test_transfer_function_on_a_torus(waves, steps):
    """Eq. 16, 17: waves of frequency k are multiplied by (1 - p k) (1 - q k)."""
    around, across = 8, 6
    cage = torus_cage(around, across)
    x, y, z = cage.vertices.T
    phase = waves[0] * np.arctan2(y, x) + waves[1] * np.arctan2(z, np.hypot(x, y) - 1)
    start = np.stack([np.cos(phase), np.sin(phase), np.cos(phase + 1)], axis=1)
    frequency = 1 - np.cos(2 * np.pi * np.array(waves) / (around, across)).mean()
    gain = (1 - P * frequency) * (1 - Q * frequency)
    close(unconstrained(connectivity(cage), start, steps), gain**steps * start, 1e-13)


@pytest.mark.parametrize("waves", [0, 1, 3])
def test_transfer_function_along_a_boundary(waves):
    """It is that of a closed curve, whatever is inside."""
    c = connectivity(prism(7, lid=False))
    phase = 2 * np.pi * waves * np.arange(7) / 7
    start = np.random.default_rng(0).normal(size=(14, 3))
    start[7:, 0] = np.cos(phase)
    frequency = 1 - np.cos(2 * np.pi * waves / 7)
    gain = (1 - P * frequency) * (1 - Q * frequency)
    close(unconstrained(c, start, 3)[7:, 0], gain**3 * start[7:, 0], 1e-13)


@ways
@pytest.mark.parametrize(("support", "pins"), [(None, True), (None, False), (1, True)])
def test_details_meet_what_their_levels_are_given(name, quads, support, pins):
    """Eq. 33 (and 21 to 27 within it), Mhat (eq. 30) by products of inverted matrices."""
    levels, rows, targets = constrained(name, quads, pins=pins)
    kappa = powers(np.array(GAMMA), 2)
    found = literal_details(levels, sparse(rows), targets, kappa, STEPS, support=support)
    matrices = oracle.stacked(levels, rows, support)
    so_far = np.zeros((levels[0].vertex_count, 3))
    for k, (matrix, detail) in enumerate(zip(matrices, found, strict=True)):
        share = kappa[: k + 1].sum(axis=0) / kappa.sum(axis=0)
        right = share * np.vstack(targets[: k + 1]) - matrix @ so_far
        close(matrix @ detail, right, 1e-12)
        if k < 2:
            so_far = oracle.prolongation(levels[k], levels[k + 1]) @ (so_far + detail)  # eq. 34


@ways
def test_details_start_from_the_surface_so_far(name, quads):
    """Eq. 24, 28 and 35: without smoothing, a detail is the start's nearest that meets eq. 33."""
    levels, rows, targets = constrained(name, quads)
    kappa = powers(np.array(GAMMA), 2)
    found = literal_details(levels, sparse(rows), targets, kappa, steps=0)
    matrices = oracle.stacked(levels, rows, None)
    so_far = start = np.zeros((levels[0].vertex_count, 3))
    for k, (matrix, detail) in enumerate(zip(matrices, found, strict=True)):
        if k:
            so_far = oracle.prolongation(*levels[k - 1 : k + 1]) @ (so_far + found[k - 1])
            start = kappa[k] / kappa[:k].sum(axis=0) * so_far
        lacking = matrix @ (detail - start)
        close(detail, start + np.linalg.lstsq(matrix, lacking, rcond=1e-8)[0], 1e-12)


def test_weights_of_levels():
    """Eq. 36; only their proportions count, and a single level has them all (eq. 19, 20)."""
    np.testing.assert_allclose(powers(np.array([2.0]), 3)[:, 0], [1 / 8, 1 / 4, 1 / 2, 1])
    levels, rows, targets = constrained("hexagonal prism", True)
    kappa = powers(np.array(GAMMA), 2)
    first, scaled = (
        literal_surfaces(levels, sparse(rows), targets, factor * kappa, STEPS)
        for factor in (1, np.array([8.0, 0.25, 3.0]))
    )
    for a, b in zip(first, scaled, strict=True):
        close(a, b, 1e-13)
    alone = filtered(levels[0], 0 * first[0], csr_array(rows[0]), targets[0], STEPS)
    close(first[0], alone, 1e-13)


@ways
@pytest.mark.parametrize("support", [None, 1])
def test_figure_2_and_constraints_of_all_levels(name, quads, support):
    """The last surface is the sum of all details; analysed down to any level, it obeys eq. 14."""
    levels, rows, targets = constrained(name, quads)
    kappa = powers(np.array(GAMMA), 2)
    given = levels, sparse(rows), targets, kappa, STEPS
    surface = literal_surfaces(*given, support=support)[-1]
    total = np.zeros((levels[0].vertex_count, 3))
    for k, detail in enumerate(literal_details(*given, support=support)):
        total = detail + (oracle.prolongation(*levels[k - 1 : k + 1]) @ total if k else total)
    close(surface, total, 1e-13)
    for k in (2, 1, 0):
        close(rows[k] @ surface, targets[k], 1e-10)
        if k:
            surface = oracle.analysis(*levels[k - 1 : k + 1], k - 1, support)[0] @ surface


@ways
@pytest.mark.parametrize("support", [None, 1])
def test_the_method_blends_a_smooth_surface_with_a_faceted_one(name, quads, support):
    """Another form of eq. 33 and 35: with w the share of the last level's weight, w times the
    surface so far, smoothed, and 1 - w times it plus what it lacks, smoothed."""
    levels, rows, targets = constrained(name, quads, pins=name != "cube")
    kappa = powers(np.array(GAMMA), 2)
    found = literal_surfaces(levels, sparse(rows), targets, kappa, STEPS, support=support)
    expected = oracle.surface_by_blending(levels, rows, targets, kappa, STEPS, support)
    close(found[-1], expected, 1e-13)


@pytest.mark.parametrize("name", ["icosahedron", "torus of quads", "open sheet of quads"])
def test_wider_supports_come_nearer_to_the_full_one(name):
    """The paper leaves rho open: every ring of it helps, and three give a digit."""
    levels, rows, targets = constrained(name, quads=name != "icosahedron", finest=3)
    kappa = powers(np.full(3, 2.0), 3)
    full, *local = (
        literal_surfaces(levels, sparse(rows), targets, kappa, 30, support=support)[-1]
        for support in (None, 0, 1, 2, 3)
    )
    errors = [np.linalg.norm(surface - full, axis=1).max() for surface in local]
    assert all(wide < narrow for narrow, wide in pairwise(errors))
    assert errors[3] < 0.1 * errors[0]
