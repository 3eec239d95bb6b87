"""Long lists of numbers go to blobs and come back, value for value and type for type."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidFile, InvalidInput
from henkei.studio.blobs import Blobs
from henkei.studio.packing import packed, unpacked

ANY_FLOATS = st.floats(allow_nan=False)
SCALARS = st.none() | st.booleans() | st.integers() | ANY_FLOATS | st.text(max_size=3)


@st.composite
def long_lists(draw):
    """Lists around and beyond the limit: of one kind of number, or of two, flat or in rows."""
    values = draw(
        st.sampled_from([
            st.integers(0, 2**32 - 1),
            st.integers(-(2**31), 2**31 - 1),
            st.integers(-(2**33), 2**33),
            st.just(2**70),
            ANY_FLOATS,
            st.integers(0, 1) | st.booleans(),
            st.integers(0, 1) | st.just(0.5),
        ])
    )  # fmt: skip
    width = draw(st.sampled_from([0, 1, 3]))
    base = draw(st.lists(values, min_size=1, max_size=4))
    flat = (base * 70)[: draw(st.sampled_from([63, 64, 65, 66, 198]))]
    if not width:
        return flat
    rows = [flat[i : i + width] for i in range(0, len(flat), width)]
    return [*rows, [1, 2, 3, 4]] if draw(st.booleans()) else rows


DATA = st.recursive(
    SCALARS | long_lists(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


@pytest.fixture(scope="module")
def blobs(tmp_path_factory) -> Blobs:
    return Blobs(tmp_path_factory.mktemp("blobs"))


def longest(data) -> int:
    """The most numbers in one list, rows included."""
    if isinstance(data, dict):
        return max(map(longest, data.values()), default=0)
    if isinstance(data, list):
        return max([sum(type(x) in (int, float) for x in data), *map(longest, data)])
    return 0


@settings(max_examples=80, deadline=None)
@given(data=DATA)
def test_data_comes_back(blobs, data):
    text = json.dumps(packed(data, blobs))
    # the text tells 1, 1.0, true and -0.0 apart
    assert json.dumps(unpacked(json.loads(text), blobs)) == json.dumps(data)


@pytest.mark.parametrize(
    ("values", "dtype"),
    [
        (list(range(65)), "uint32"),
        ([0] * 64 + [2**32 - 1], "uint32"),
        ([0] * 64 + [-1], "int32"),
        ([-(2**31)] * 64 + [2**31 - 1], "int32"),
        ([0.0] * 64 + [-0.0], "float64"),
        ([[1, 2, 3]] * 22, "uint32"),
        ([[0.1, 0.2, 0.3]] * 22, "float64"),
        (((1, -2),) * 33, "int32"),
        ([float("inf"), 1e-320] * 40, "float64"),
    ],
)
def test_long_lists_are_arrays_of_the_narrowest_kind(blobs, values, dtype):
    data = packed({"ids": values}, blobs)
    assert list(data["ids"]) == ["blob"]
    array = blobs.get_message(data["ids"]["blob"]).arrays["values"]
    assert array.dtype == dtype
    assert array.tolist() == json.loads(json.dumps(values))


@pytest.mark.parametrize(
    "values",
    [
        list(range(64)),
        [[1, 2, 3]] * 21,
        [True] * 100,
        [1, 2.0] * 50,
        [2**32] * 100,
        [-1, 2**31] * 50,
        [10**30] * 100,
        ["a"] * 100,
        [None] * 100,
        [[]] * 100,
    ],
)
def test_what_is_short_or_would_change_stays(blobs, values):
    assert json.dumps(packed(values, blobs)) == json.dumps(values)


def test_not_a_number_is_kept(blobs):
    again = unpacked(packed([float("nan")] * 65, blobs), blobs)
    assert len(again) == 65
    assert all(value != value for value in again)


def test_equal_lists_are_one_blob(blobs):
    ids = list(range(1000))
    data = packed([ids, {"again": tuple(ids)}], blobs)
    assert data[0] == data[1]["again"]


def test_data_that_reads_as_a_blob_is_refused(blobs):
    with pytest.raises(InvalidInput, match="reads as the name of a blob"):
        packed({"regions": {"blob": "0" * 32}}, blobs)
    region = {"blob": list(range(100))}  # a name that a person may choose
    assert unpacked(packed(region, blobs), blobs) == region


def test_blobs_of_other_kinds_are_refused(blobs):
    other = blobs.put_message({"kind": "surface"})
    for blob in (other, blobs.put(b"text"), "f" * 32):
        with pytest.raises(InvalidFile, match="blob"):
            unpacked({"deep": [{"blob": blob}]}, blobs)
