"""Numbers in fields of text: read as they stand, written as near as a width allows."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from henkei.errors import InvalidFile
from henkei.io.fields import Lines, separated, shortest, spliced

finite = st.floats(-1e300, 1e300)
usual = st.floats(-1e6, 1e6, allow_nan=False)


def lines(text: str) -> Lines:
    return Lines(Path("a.txt"), text.encode())


def read_back(text: str) -> float:
    found = lines(text)
    return float(found.floats(separated(found, np.array([0]))[0])[0])


@given(finite | usual, st.sampled_from([8, 16, 20, 30]))
def test_written_numbers(value, width):
    """Within the width, with a decimal point, and read back as that text says."""
    text = shortest(value, width)
    assert len(text) <= width
    assert "." in text
    assert read_back(text) == float(text)
    if width == 30:
        assert float(text) == value
    room = width - 1 - (value < 0)  # digits that a number between 1 and 10^6 has room for
    if 1 <= abs(value) < 1e6:
        after = room - len(str(int(abs(value))))
        assert abs(float(text) - value) <= 0.51 * 10.0**-after
    elif math.frexp(value)[1] > -1000:
        assert abs(float(text) - value) <= abs(value) * 10.0 ** (7 - width + (value < 0))


@given(st.floats(0.01, 1e15) | st.floats(-1e15, -0.01))
def test_twenty_characters_hold_float64(value):
    assert float(shortest(value, 20)) == value


@given(usual, st.sampled_from(["e", "E", "d", "D", ""]), st.sampled_from("+-"), st.integers(0, 20))
def test_exponents(mantissa, letter, sign, exponent):
    text = f"{mantissa:.6f}{letter}{sign}{exponent}"
    assert read_back(text) == float(f"{mantissa:.6f}e{sign}{exponent}")


@pytest.mark.parametrize("word", ["1_0", "nan", "inf", "0x1", "1e", "--1", "1.2.3", "e5", "٣"])
def test_what_is_no_number(word):
    with pytest.raises(InvalidFile, match=r"line 1: .* is not a number"):
        read_back(word)
    found = lines(word)
    with pytest.raises(InvalidFile, match="is not a whole number"):
        found.integers(separated(found, np.array([0]))[0])


def test_integers_end_at_64_bits():
    found = lines("9223372036854775807\n9223372036854775808")
    fields = separated(found, np.array([0, 1]))[0]
    assert found.integers(fields[:1]).tolist() == [2**63 - 1]
    with pytest.raises(InvalidFile, match="line 2"):
        found.integers(fields)


@given(st.lists(st.lists(st.sampled_from(["1", " 2.5", "", " ", "-3 "]), max_size=5), max_size=6))
def test_fields_between_commas(rows):
    texts = [",".join(row) for row in rows]
    found = lines("\n".join([*texts, "end"]))
    fields, offsets = separated(found, np.arange(len(rows)))
    for text, low, high in zip(texts, offsets[:-1], offsets[1:], strict=True):
        expected = [word.strip() for word in text.split(",")]
        expected = expected if expected[-1] else expected[:-1]
        assert [found.data[a:b].decode() for a, b in fields[low:high].tolist()] == expected


@given(st.binary(max_size=30), st.lists(st.integers(0, 30), max_size=6))
def test_only_the_changes_change(data, cuts):
    edges = sorted(min(cut, len(data)) for cut in cuts)
    changes = [(a, b, b"<>") for a, b in zip(edges[::2], edges[1::2], strict=False)]
    result = b"".join(spliced(data, changes))
    parts = result.split(b"<>") if b"<>" not in data else None
    if parts is not None:
        assert len(parts) == len(changes) + 1
        assert sum(map(len, parts)) == len(data) - sum(b - a for a, b, _ in changes)
