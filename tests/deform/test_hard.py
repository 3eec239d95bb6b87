"""What is left free once hard rows are eliminated: the null space of eq. 2 and 12."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.deform import Feature, Fixed, Handle
from henkei.deform.hard import freedom, turning_freedom
from henkei.shapes import grid

COUNT = 40
POINTS = grid(7, 4).vertices


def bodies_of(seed: int, keeps: list[str]) -> list[Fixed | Handle | Feature]:
    """Random regions that share no vertex, of five vertices each; straight and flat as needed."""
    order = np.random.default_rng(seed).permutation(COUNT).astype(np.int64)
    fixed, moved, *others = np.split(order[: 5 * (2 + len(keeps))], 2 + len(keeps))
    bodies: list[Fixed | Handle | Feature] = [
        Fixed("fixed", np.sort(fixed)),
        Handle("handle", np.sort(moved), POINTS[np.sort(moved)]),
    ]
    for name, keep in enumerate(keeps):
        region = np.sort(others[name])
        rest = POINTS[region].copy()
        if keep == "line":
            rest = np.outer(np.arange(5.0), [1, 2, 2])
        bodies.append(Feature(f"feature {name}", region, rest, keep))
    return bodies


def rows_of(bodies) -> np.ndarray:
    """Hard rows: all differences inside a rigid feature, second ones along a line, and so on."""
    rows = []
    for body in bodies:
        if not isinstance(body, Feature):
            rows.append(np.eye(COUNT)[body.vertices])
            continue
        spread = np.linalg.svd(body.basis, full_matrices=True)[0][:, body.basis.shape[1] :]
        part = np.zeros((spread.shape[1], COUNT))
        part[:, body.vertices] = spread.T
        rows.append(part)
    return np.vstack(rows)


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    keeps=st.lists(st.sampled_from(["rigid", "plane", "line"]), max_size=4),
)
def test_freedom_is_all_that_meets_the_rows(seed, keeps):
    bodies = bodies_of(seed, keeps)
    found = freedom(COUNT, np.arange(COUNT), bodies, range(len(bodies)))
    matrix, rows = found.toarray(), rows_of(bodies)
    assert np.abs(rows @ matrix).max() < 1e-12
    assert matrix.shape[1] == np.linalg.matrix_rank(matrix) == COUNT - np.linalg.matrix_rank(rows)
    stretches = {"rigid": 1, "line": 2, "plane": 3}
    assert matrix.shape[1] == COUNT - 5 * len(bodies) + sum(stretches[keep] for keep in keeps)


def test_features_that_keep_their_offset_share_one_translation():
    bodies = bodies_of(0, ["rigid", "plane", "rigid"])
    alone = freedom(COUNT, np.arange(COUNT), bodies, range(5))
    shared = freedom(COUNT, np.arange(COUNT), bodies, [0, 1, 2, 2, 4])
    assert shared.shape[1] == alone.shape[1] - 1
    together = np.concatenate([bodies[2].vertices, bodies[3].vertices])
    translations = (shared.toarray()[together] == 1).all(axis=0)
    assert np.count_nonzero(translations) == 1
    assert shared.toarray()[:, translations].sum() == len(together)


def test_unused_vertices_have_no_freedom():
    bodies = bodies_of(0, [])
    free = np.setdiff1d(np.arange(COUNT), np.concatenate([b.vertices for b in bodies]))
    matrix = freedom(COUNT, np.setdiff1d(np.arange(COUNT), free[:3]), bodies, range(2))
    assert matrix.shape[1] == len(free) - 3


def test_all_vertices_of_a_feature_turn_as_one():
    bodies = bodies_of(0, ["rigid", "line", "rigid"])
    matrix = turning_freedom(COUNT, np.arange(COUNT), bodies, [0, 1, 2, 3, 2]).toarray()
    assert matrix.shape == (COUNT, COUNT - 5 * 5 + 2)
    np.testing.assert_array_equal(
        matrix[np.concatenate([bodies[0].vertices, bodies[1].vertices])], 0
    )
    together = np.concatenate([bodies[2].vertices, bodies[4].vertices])
    assert len(np.unique(matrix[together], axis=0)) == len(np.unique(matrix[bodies[3].vertices],
                                                                     axis=0)) == 1  # fmt: skip
    assert not np.array_equal(matrix[together[0]], matrix[bodies[3].vertices[0]])
