"""Files of pairs: read as they were written, and refused by line."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from henkei.errors import InvalidFile
from henkei.workflows.pairs import read_pairs, write_pairs


@given(
    hnp.arrays(np.int32, st.tuples(st.integers(1, 9), st.just(2)), elements=st.integers(0, 10**9))
)
def test_round_trip(tmp_path_factory, pairs):
    path = tmp_path_factory.mktemp("pairs") / "pairs.json"
    write_pairs(path, pairs)
    np.testing.assert_array_equal(read_pairs(path), pairs)
    assert len(path.read_text().splitlines()) == len(pairs) + 2


def test_forms(tmp_path):
    path = tmp_path / "pairs.json"
    path.write_text("\ufeff[[1, 2], [3, 4]]", encoding="utf-8")
    assert read_pairs(path).tolist() == [[1, 2], [3, 4]]
    assert read_pairs(path, "landmarks").tolist() == [[1, 2], [3, 4]]
    path.write_text('{"landmarks": [[7, 8]], "pairs": [[[0, 0, 1], [1.5, 0, 0]]]}')
    assert read_pairs(path).tolist() == [[[0, 0, 1], [1.5, 0, 0]]]
    assert read_pairs(path, "landmarks").tolist() == [[7, 8]]


def test_both_lists_in_one_file(tmp_path):
    path = tmp_path / "pairs.json"
    write_pairs(path, np.array([[1, 2], [3, 4]]), np.array([[5, 6]]))
    assert read_pairs(path).tolist() == [[1, 2], [3, 4]]
    assert read_pairs(path, "landmarks").tolist() == [[5, 6]]
    path.write_text(path.read_text().replace("6", "true"))
    with pytest.raises(InvalidFile, match=r"line 5: pair 0 .* is \[5, true\]"):
        read_pairs(path, "landmarks")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[1, 2],\n [3, 4]\n [5, 6]]", "not JSON, line 3, column 2"),
        ("[[1, 2],\n\n [3],\n [5, 6]]", r"line 3: pair 1 .* is \[3\]"),
        ('{"a": [1],\n "pairs": [\n[1, 2],\n[3, "x"]]}', r'line 4: pair 1 .* is \[3, "x"\]'),
        ("[[1, 2],\n[[0, 0, 0], [1, 1, 1]]]", "line 2: .* the pairs before are vertices"),
        ("[[1, 2], [true, 4]]", "line 1: pair 1"),
        ("[[1, 2], [3.5, 4]]", r"pair 1 .* is \[3\.5, 4\]"),
        ("[[1, 99999999999999999999]]", "pair 0"),
        ("[[[0, 0], [1, 1]]]", "pair 0"),
        ("[]", "empty"),
        ("", "not JSON, line 1"),
        ("3", "holds no pairs"),
        ('{"pair": [[1, 2]]}', "holds no pairs"),
        ("[" * 100_000, "nested too deeply|not JSON"),
    ],
)
def test_what_is_wrong_is_said_by_line(tmp_path, text, message):
    path = tmp_path / "pairs.json"
    path.write_text(text)
    with pytest.raises(InvalidFile, match=message) as caught:
        read_pairs(path)
    assert str(caught.value).startswith(str(path))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InvalidFile, match="no such file"):
        read_pairs(tmp_path / "pairs.json")
    with pytest.raises(InvalidFile, match="cannot be read"):
        read_pairs(tmp_path)
    (tmp_path / "pairs.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidFile, match="not a text file"):
        read_pairs(tmp_path / "pairs.json")
