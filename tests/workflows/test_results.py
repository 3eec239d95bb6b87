"""Saved results: equal in every bit when read again, refused when damaged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.shapes import hemisphere, icosphere, random_disk

NUMBERS = hnp.integer_dtypes(endianness="=") | hnp.floating_dtypes(endianness="=", sizes=(32, 64))
NAMES = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=12)


@pytest.fixture(scope="module")
def combined() -> hk.CombinedMesh:
    a, b = random_disk(0, 30), random_disk(1, 30)
    return hk.combine(a, b, [[0, 0], [5, 5], [10, 10]])


@pytest.fixture(scope="module")
def saved(combined, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("saved") / "c.npz"
    hk.save(path, combined)
    return path.read_bytes()


def assert_equal(one, other) -> None:
    arrays, others = one.to_arrays(), other.to_arrays()
    assert arrays.keys() == others.keys()
    for name, values in arrays.items():
        assert values.dtype == others[name].dtype, name
        assert values.shape == others[name].shape, name
        assert values.tobytes() == others[name].tobytes(), name
    assert one.quality == other.quality


@settings(max_examples=30, deadline=None)
@given(names=st.lists(NAMES, max_size=3, unique=True), data=st.data())
def test_round_trip_with_any_attributes(combined, tmp_path_factory, names, data):
    path = tmp_path_factory.mktemp("any") / "c.npz"
    count = len(combined.vertices_a)
    values = {
        name: data.draw(hnp.arrays(data.draw(NUMBERS), (count, 2), fill=st.just(1)))
        for name in names
    }
    texts = {"label": np.array(["left", "right"] * count)[:count]}
    correspondence = replace(
        combined.correspondence,
        attributes_a=hk.Attributes(vertex=values),
        attributes_b=hk.Attributes(vertex=texts),
    )
    result = replace(combined, correspondence=correspondence)
    hk.save(path, result)
    assert_equal(hk.load(path), result)
    first = path.read_bytes()
    hk.save(path, hk.load(path))
    assert path.read_bytes() == first


def test_other_programs_can_read_the_arrays(saved, tmp_path, combined):
    path = tmp_path / "c.npz"
    path.write_bytes(saved)
    with np.load(path, allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["vertices_b"], combined.vertices_b)
        assert str(archive["henkei.kind"]) == "combined mesh"


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_damage_is_refused_or_harmless(saved, combined, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("damaged") / "c.npz"
    content = bytearray(saved)
    if data.draw(st.booleans()):
        content = content[: data.draw(st.integers(0, len(content) - 1))]
    else:  # mostly in the headers, where it hurts in more ways
        headers = [at for at in range(len(content) - 4) if content[at : at + 2] == b"PK"]
        start = data.draw(st.sampled_from(headers) | st.integers(0, len(content) - 1))
        at = min(start + data.draw(st.integers(0, 59)), len(content) - 1)
        content[at] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    try:
        read = hk.load(path)
    except InvalidFile as error:
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert_equal(read, combined)


def change(name: str, values: object):
    def changed(arrays: dict) -> dict:
        return {**arrays, name: np.asarray(values)}

    return changed


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (lambda arrays: {"x": np.zeros(3)}, r"not one that henkei\.save wrote"),
        (change("henkei.version", 99), "version 99"),
        (change("henkei.version", [1, 1]), "version"),
        (change("henkei.kind", "soup"), "'soup'"),
        (change("faces", np.full((4, 3), 10**6)), "damaged: face_on_a is"),
        (change("vertices_a", np.zeros((4, 3))), "damaged: vertices_b is"),
        (change("vertices_a", "text"), "damaged: vertices_a is"),
        (change("on_a.face", np.zeros(3)), "damaged: on_a.face is"),
        (change("quality.bits", [1, 2]), "damaged"),
        (lambda arrays: {n: v for n, v in arrays.items() if n != "edges"}, "edges missing"),
        (lambda arrays: {**arrays, "faces": arrays["faces"] + 10**6}, "do not exist"),
        (lambda arrays: {**arrays, "edges": arrays["edges"] + 10**6}, "do not exist"),
        (change("attributes_a.vertex.color", np.zeros((2, 3))), "attribute 'color'"),
    ],
)
def test_other_content_is_refused(saved, tmp_path, changed, message):
    path = tmp_path / "c.npz"
    path.write_bytes(saved)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **changed(arrays))
    with pytest.raises(InvalidFile, match=message):
        hk.load(path)


def test_pickles_are_not_opened(tmp_path):
    path = tmp_path / "c.npz"
    np.savez(path, **{"henkei.kind": np.array([{}], dtype=object)})
    with pytest.raises(InvalidFile, match="damaged"):
        hk.load(path)


@pytest.mark.parametrize("content", [b"", b"PK\3\4", b"not a zip file", b"\x93NUMPY\1\0"])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "c.npz"
    path.write_bytes(content)
    with pytest.raises(InvalidFile, match="damaged, or not"):
        hk.load(path)


def test_a_single_array_is_refused(tmp_path):
    with (tmp_path / "c.npz").open("wb") as stream:
        np.save(stream, np.zeros(3))
    with pytest.raises(InvalidFile, match=r"not an \.npz"):
        hk.load(tmp_path / "c.npz")


def test_names(tmp_path, combined):
    with pytest.raises(InvalidFile, match="no such file"):
        hk.load(tmp_path / "none.npz")
    with pytest.raises(InvalidInput, match=r"\.npz"):
        hk.save(tmp_path / "c.npy", combined)
    with pytest.raises(InvalidInput, match="path"):
        hk.save(3, combined)  # type: ignore[arg-type]
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(InvalidFile, match="cannot be read"):
        hk.load(tmp_path / "folder.npz")


def test_what_is_no_result_is_not_saved(tmp_path, combined):
    with pytest.raises(InvalidInput, match=r"henkei\.write"):
        hk.save(tmp_path / "c.npz", combined.mesh_a)  # type: ignore[arg-type]
    objects = hk.Attributes(vertex={"tag": np.full(len(combined.vertices_a), None)})
    correspondence = replace(combined.correspondence, attributes_a=objects)
    with pytest.raises(InvalidInput, match=r"attributes_a\.vertex\.tag"):
        hk.save(tmp_path / "c.npz", replace(combined, correspondence=correspondence))
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def registered() -> hk.Registration:
    ball = icosphere(1)
    colors = hk.Attributes(vertex={"color": ball.vertices, "normal": ball.vertices})
    return hk.register(
        hk.Mesh(ball.vertices * [1, 2, 3], ball.faces, attributes=colors),
        icosphere(2),
        landmarks=[[0, 0], [1, 1]],
    )


def test_registrations_go_round(registered, tmp_path):
    hk.save(tmp_path / "r.npz", registered)
    again = hk.load(tmp_path / "r.npz")
    assert isinstance(again, hk.Registration)
    assert_equal(again, registered)
    np.testing.assert_array_equal(again.mesh.attributes.vertex["color"], icosphere(1).vertices)
    assert set(again.mesh.attributes.vertex) == {"color"}
    np.testing.assert_array_equal(again.at(0.5).vertices, registered.at(0.5).vertices)
    assert repr(again) == repr(registered)
    hk.save(tmp_path / "again.npz", again)
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "r.npz").read_bytes()


def test_bridged_registrations_go_round(tmp_path):
    """Face -1 where a vertex has no place."""
    result = hk.register(icosphere(2), hemisphere(2))
    assert result.quality.bridged > 0
    hk.save(tmp_path / "r.npz", result)
    assert_equal(hk.load(tmp_path / "r.npz"), result)


@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_damaged_registrations_are_refused_or_harmless(registered, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("damaged") / "r.npz"
    hk.save(path, registered)
    content = bytearray(path.read_bytes())
    if data.draw(st.booleans()):
        content = content[: data.draw(st.integers(0, len(content) - 1))]
    else:
        content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    try:
        read = hk.load(path)
    except InvalidFile as error:
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert_equal(read, registered)


@pytest.mark.parametrize(
    "missing", ["faces", "on_b.face", "target_faces", "similarity.scale", "quality.flipped"]
)
def test_registrations_that_are_not_whole_are_refused(registered, tmp_path, missing):
    path = tmp_path / "r.npz"
    hk.save(path, registered)
    with np.load(path) as archive:
        arrays = {name: values for name, values in archive.items() if name != missing}
    np.savez(path, **arrays)
    with pytest.raises(InvalidFile, match=f"r.npz: damaged: .*{missing}.* missing"):
        hk.load(path)
