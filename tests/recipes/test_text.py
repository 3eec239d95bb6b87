"""JSON that people write: what is wrong where, and a layout that reads well."""

from __future__ import annotations

import json
from copy import deepcopy

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidFile
from henkei.recipes.text import WIDTH, line_of, parsed, pretty

words = st.text(max_size=8)
scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | words
    | st.floats(allow_nan=False, allow_infinity=False)
)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(words, inner, max_size=5),
    max_leaves=25,
)


@st.composite
def places(draw):
    """A value, and the place of one inside it."""
    whole = draw(st.lists(values, min_size=1) | st.dictionaries(words, values, min_size=1))
    place, here = [], whole
    while isinstance(here, list | dict) and here and (not place or draw(st.booleans())):
        place.append(
            draw(st.sampled_from(range(len(here)) if isinstance(here, list) else list(here)))
        )
        here = here[place[-1]]
    return whole, place


@given(values)
def test_pretty_text_gives_the_same_data(data):
    text = pretty(data)
    assert json.loads(text) == data
    assert pretty(json.loads(text)) == text


@settings(max_examples=25)
@given(st.lists(st.integers(0, 10**6), min_size=40), st.integers(0, 5))
def test_numbers_fill_lines_of_limited_width(numbers, depth):
    data = {"vertices": numbers}
    for _ in range(depth):
        data = {"region": data}
    lines = pretty(data).splitlines()
    assert max(map(len, lines)) <= WIDTH
    rows = [line.strip() for line in lines if line.strip()[0].isdigit()]
    assert len(rows) <= 2 + sum(len(str(number)) + 2 for number in numbers) / (WIDTH - 30)


def test_what_fits_a_line_is_on_one():
    assert pretty({"a": {"b": [1.0, 2.5, -0.0, 1e300]}, "c": "ü"}) == (
        '{\n  "a": {"b": [1, 2.5, -0.0, 1e+300]},\n  "c": "ü"\n}\n'
    )


@settings(max_examples=40)
@given(places(), st.sampled_from([None, 0, 3]))
def test_the_line_of_a_place(placed, indent):
    whole, place = placed
    marked = deepcopy(whole)
    here = marked
    for step in place[:-1]:
        here = here[step]
    here[place[-1]] = "the mark \x00"
    lines = json.dumps(marked, indent=indent).splitlines()
    expected = next(n for n, line in enumerate(lines, 1) if json.dumps("the mark \x00") in line)
    assert line_of(json.dumps(whole, indent=indent), place) == expected


def test_the_line_of_a_key_that_is_on_another_line_than_its_value():
    assert line_of('{"a":\n\n1, "b"\n:[2,\n3]}', ["a"]) == 1
    assert line_of('{"a":\n\n1, "b"\n:[2,\n3]}', ["b", 1]) == 5
    assert line_of('{"a":\n\n1, "b"\n:[2,\n3]}', ["b", 7, "c"]) == 4
    assert line_of('{"a":\n\n1}', ["missing"]) == 1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('{"a": 1,\n "b": }', "line 2, column 7: not JSON: expecting value"),
        ('{"a": 1,\n "b": [2, 3,\n]}', "line 2, column 12: not JSON: a trailing comma"),
        ('{"a": 1,\n "b": {"c": 2} , }', "line 2, column 16: not JSON: a trailing comma"),
        ('{"a": 1 "b": 2}', "line 1, column 9: not JSON: expecting ',' delimiter"),
        ('{"a": 1,\n "a": 2}', "an object has the key 'a' twice"),
        ("", "line 1, column 1: not JSON"),
        ("[" * 100_000, "not usable as JSON"),
        ("1" * 5000, "not usable as JSON"),
    ],
)
def test_damaged_files(tmp_path, text, told):
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(InvalidFile) as caught:
        parsed(path)
    assert told in str(caught.value)
    assert str(caught.value).startswith(str(path))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InvalidFile, match="no such file"):
        parsed(tmp_path / "none.json")
    with pytest.raises(InvalidFile, match="a folder"):
        parsed(tmp_path)
    (tmp_path / "x.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidFile, match="as text"):
        parsed(tmp_path / "x.json")


def test_a_byte_order_mark_is_no_fault(tmp_path):
    (tmp_path / "x.json").write_bytes(b'\xef\xbb\xbf{"a": 1}')
    assert parsed(tmp_path / "x.json") == ('{"a": 1}', {"a": 1})


def test_the_line_of_a_key_that_is_further_out_too():
    text = json.dumps({"region": {"grow": {"region": {"box": 1}}}}, indent=1)
    assert line_of(text, ["region", "grow", "region"]) == 4
    assert line_of(text, ["region", "grow", "region", "box"]) == 5
