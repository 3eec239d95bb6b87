"""What a page was sent brings it to where the surface is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from henkei.studio.shown import Shown

KEY = {"tab": "deform", "surface": "mesh"}


class Page:
    """Applies frames as the page does."""

    def __init__(self) -> None:
        self.positions = np.zeros((0, 3), np.float32)

    def take(self, header: dict[str, Any], arrays: dict[str, Any]) -> None:
        sent = arrays["positions"]
        if header["bits"] == 16:
            low, high = np.float32(header["low"]), np.float32(header["high"])
            size = np.where(high > low, high - low, 1).astype(np.float32)
            sent = low + sent.astype(np.float32) / np.float32(65535) * size
        if "ids" in arrays:
            self.positions[arrays["ids"]] = sent
        else:
            self.positions = np.array(sent)


@given(
    st.sampled_from([16, 32]),
    st.lists(st.tuples(st.integers(0, 40), st.booleans(), st.booleans()), max_size=12),
    st.integers(0, 2**32 - 1),
)
def test_frames_add_up(bits: int, steps: list[tuple[int, bool, bool]], seed: int) -> None:
    rng = np.random.default_rng(seed)
    shown, page = Shown(bits), Page()
    positions = rng.normal(size=(40, 3)).astype(np.float32)
    data = "a"
    for moved, exact, other in steps:
        positions = positions.copy()
        positions[rng.permutation(40)[:moved]] += np.float32(rng.normal())
        data = f"{data}b" if other else data
        page.take(*shown.frame({**KEY, "data": data, "exact": exact}, positions))
        error = np.abs(page.positions - positions).max()
        assert error <= (0 if exact or bits == 32 else 1e-4 * np.ptp(positions))


def test_only_what_moved_is_sent() -> None:
    shown = Shown()
    positions = np.zeros((100, 3), np.float32)
    _, arrays = shown.frame({**KEY, "data": "a"}, positions)
    assert set(arrays) == {"positions"}
    positions = positions.copy()
    positions[[3, 70]] = 1
    _, arrays = shown.frame({**KEY, "data": "a"}, positions)
    np.testing.assert_array_equal(arrays["ids"], [3, 70])
    assert len(arrays["positions"]) == 2


@pytest.mark.parametrize("bits", [16, 32])
def test_a_slow_line_carries_half(bits: int) -> None:
    shown = Shown(bits)
    positions = np.random.default_rng(0).normal(size=(1000, 3)).astype(np.float32)
    _, arrays = shown.frame({**KEY, "data": "a", "exact": False}, positions)
    assert arrays["positions"].nbytes == 1000 * 3 * bits // 8
