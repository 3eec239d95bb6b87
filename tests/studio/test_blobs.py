"""Blobs: the same bytes are kept once, come back in every bit, or are refused."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import zipfile
from contextlib import suppress
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import icosphere, random_disk
from henkei.studio.blobs import Blobs

UNKNOWN = "0123456789abcdef" * 2
NUMBERS = (
    hnp.integer_dtypes()
    | hnp.unsigned_integer_dtypes()
    | hnp.floating_dtypes()
    | hnp.complex_number_dtypes()
    | hnp.boolean_dtypes()
)
NAMES = st.text(min_size=1, max_size=8)
TRIANGLES = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 2, 3]])
RAGGED = PolygonMesh.from_faces(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0]], [[0, 1, 2, 3], [3, 2, 4]]
)
QUADS = PolygonMesh(np.eye(4, 3), [[0, 1, 2, 3]])
EMPTY = [
    Mesh(np.empty((0, 3)), np.empty((0, 3), int)),
    PolygonMesh(np.eye(3), (np.empty(0, int), [0])),
    PolygonMesh(np.eye(3), np.empty((0, 4), int)),
]


@pytest.fixture
def blobs(tmp_path) -> Blobs:
    return Blobs(tmp_path / "blobs")


@pytest.fixture(scope="module")
def shared(tmp_path_factory) -> Blobs:
    return Blobs(tmp_path_factory.mktemp("shared"))


def assert_equal(one, other) -> None:
    assert type(one) is type(other)
    assert type(one.faces) is type(other.faces)
    pairs = [(one.vertices, other.vertices), (one.indices, other.indices)]
    pairs.append((one.offsets, other.offsets))
    for domain in ("vertex", "corner", "face"):
        arrays, others = getattr(one.attributes, domain), getattr(other.attributes, domain)
        assert list(arrays) == list(others)
        pairs += [(arrays[name], others[name]) for name in arrays]
    for values, others in pairs:
        assert values.dtype == others.dtype
        assert values.shape == others.shape
        assert values.tobytes() == others.tobytes()


def age(blobs: Blobs, seconds: float) -> None:
    """Let all that is there be so old."""
    then = time.time() - seconds
    for file in blobs.folder.iterdir():
        os.utime(file, (then, then))


def kept(blobs: Blobs) -> set[str]:
    return {file.name for file in blobs.folder.iterdir() if not file.name.startswith(".")}


# Bytes and messages


@settings(max_examples=30, deadline=None)
@given(data=st.binary(max_size=200))
def test_bytes_come_back_and_are_there_once(shared, data):
    blob = shared.put(data)
    assert shared.put(bytes(data)) == blob
    assert shared.get(blob) == data
    assert sum(name.startswith(blob) for name in kept(shared)) == 1


def test_other_bytes_have_another_id(blobs):
    assert len({blobs.put(bytes([n])) for n in range(20)}) == 20


def test_a_message_comes_back(blobs):
    arrays = {"positions": np.eye(3, dtype=np.float32), "ids": np.arange(5, dtype=np.uint32)}
    blob = blobs.put_message({"kind": "surface", "scale": 0.1}, **arrays)
    message = blobs.get_message(blob)
    assert message.header == {"kind": "surface", "scale": 0.1}
    for name, values in arrays.items():
        np.testing.assert_array_equal(message.arrays[name], values)
    with pytest.raises(InvalidFile, match="no message"):
        blobs.get_message(blobs.put(b"no message at all"))


@pytest.mark.parametrize(
    "bad",
    ["", "../blobs", "/etc/passwd", UNKNOWN[:-1], UNKNOWN + "0", UNKNOWN.upper(), UNKNOWN + "\n",
     "." + UNKNOWN[1:], None, 7, b"0" * 32, [UNKNOWN]],
)  # fmt: skip
def test_only_ids_are_looked_up(blobs, bad):
    for look in (blobs.path, blobs.get, blobs.get_message, blobs.result):
        with pytest.raises(InvalidInput, match="no id of a blob"):
            look(bad)


def test_what_is_not_there_is_told(blobs):
    for look in (blobs.path, blobs.get, blobs.get_message, blobs.surface, blobs.result):
        with pytest.raises(InvalidFile, match="there is no blob"):
            look(UNKNOWN)


@pytest.mark.parametrize("change", [lambda d: d[:-1], lambda d: b"", lambda d: d + b"x",
                                    lambda d: d[:40] + bytes([d[40] ^ 1]) + d[41:]])  # fmt: skip
def test_damage_is_seen_and_put_right_by_the_same_bytes(blobs, change):
    blob = blobs.put_surface(TRIANGLES)
    file = blobs.path(blob)
    data = file.read_bytes()
    file.write_bytes(change(data))
    for look in (blobs.get, blobs.surface, blobs.result, blobs.get_message):
        with pytest.raises(InvalidFile, match="damaged"):
            look(blob)
    assert blobs.put(data) == blob
    assert_equal(blobs.surface(blob), TRIANGLES)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InvalidInput, match="cannot make"):
        Blobs(tmp_path / "file" / "blobs")


# Surfaces and results


@settings(max_examples=60, deadline=None)
@given(bare=st.sampled_from([TRIANGLES, RAGGED, QUADS]), data=st.data())
def test_surfaces_come_back_in_every_bit(shared, bare, data):
    counts = {"vertex": len(bare.vertices), "corner": len(bare.indices), "face": bare.face_count}
    attributes = {}
    for domain, count in counts.items():
        names = data.draw(st.lists(NAMES, max_size=2, unique=True))
        shape = (count, *data.draw(st.sampled_from([(), (2,), (3, 1)])))
        attributes[domain] = {
            name: data.draw(hnp.arrays(data.draw(NUMBERS), shape, fill=st.just(1)))
            for name in names
        }
    surface = type(bare)(bare.vertices, bare.faces, attributes=Attributes(**attributes))
    blob = shared.put_surface(surface)
    assert_equal(shared.surface(blob), surface)
    assert shared.put_surface(shared.surface(blob)) == blob


@pytest.mark.parametrize("surface", EMPTY)
def test_surfaces_without_faces_come_back(blobs, surface):
    assert_equal(blobs.surface(blobs.put_surface(surface)), surface)


def test_nan_infinity_and_minus_zero_are_kept(blobs):
    payload = np.array([0x7FF8000000000123, 0x8000000000000000], np.uint64).view(float)
    vertices = np.array([[*payload, np.inf]])
    surface = blobs.surface(blobs.put_surface(Mesh(vertices, np.empty((0, 3), int))))
    assert surface.vertices.tobytes() == vertices.tobytes()


def test_texts_ride_along(blobs):
    surface = Mesh(np.eye(3), [[0, 1, 2]], attributes=Attributes(face={"label": ["côté"]}))
    assert_equal(blobs.surface(blobs.put_surface(surface)), surface)


def test_equal_surfaces_have_one_id_whenever_and_however_they_are_made(blobs, monkeypatch):
    values = np.arange(12.0).reshape(4, 3)

    def made(values):
        return Mesh(
            TRIANGLES.vertices, TRIANGLES.faces, attributes=Attributes(vertex={"normal": values})
        )

    blob = blobs.put_surface(made(values))
    monkeypatch.setattr(time, "localtime", lambda *_: time.gmtime(2e9))
    assert blobs.put_surface(made(np.asfortranarray(values))) == blob
    assert blobs.put_surface(made(np.repeat(values, 2, axis=0)[::2])) == blob
    assert blobs.put_surface(made(values.astype(np.float32))) != blob
    assert blobs.put_surface(made(values + 1)) != blob


def test_triangles_as_polygons_are_another_surface(blobs):
    polygons = PolygonMesh(TRIANGLES.vertices, TRIANGLES.faces)
    blob = blobs.put_surface(polygons)
    assert blob != blobs.put_surface(TRIANGLES)
    assert_equal(blobs.surface(blob), polygons)


def test_python_objects_are_refused(blobs):
    surface = Mesh(
        np.eye(3), [[0, 1, 2]], attributes=Attributes(face={"any": np.array([{}], dtype=object)})
    )
    with pytest.raises(InvalidInput, match="any hold Python objects"):
        blobs.put_surface(surface)


def test_a_surface_that_was_asked_for_is_the_same_object(blobs):
    blob = blobs.put_surface(TRIANGLES)
    assert blobs.surface(blob) is blobs.surface(blob)
    others = [blobs.put_surface(icosphere(0).flipped()) for _ in range(2)]
    assert blobs.surface(others[0]) is blobs.surface(others[1])


def _changed(blobs: Blobs, change) -> str:
    """The id of an archive in which ``change`` changed the files of a surface."""
    with zipfile.ZipFile(blobs.path(blobs.put_surface(TRIANGLES))) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    content = BytesIO()
    with zipfile.ZipFile(content, "w", change(files) or zipfile.ZIP_STORED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return blobs.put(content.getvalue())


class _Ends:
    """Ends the process when it is read from a pickle."""

    def __reduce__(self):
        return os.abort, ()


def _pickled(files):
    content = BytesIO()
    values = np.array([_Ends()], dtype=object)
    np.lib.format.write_array(content, values, allow_pickle=True)
    files["vertices.npy"] = content.getvalue()


CHANGES = {
    "nothing": lambda files: files.clear(),
    "no faces": lambda files: files.pop("faces.npy") and None,
    "no about": lambda files: files.pop("about.json") and None,
    "about is a list": lambda files: files.update({"about.json": b"[1, 2]"}),
    "about is no JSON": lambda files: files.update({"about.json": b"{"}),
    "another form": lambda files: files.update({"about.json": b'{"form": 99}'}),
    "attributes that are not there": lambda files: files.update(
        {"about.json": b'{"form": 1, "polygons": false, "attributes": [["vertex", "a"]]}'}
    ),
    "an unknown domain": lambda files: files.update(
        {"about.json": b'{"form": 1, "polygons": false, "attributes": [["edge", "a"]]}'}
    ),
    "too few vertices": lambda files: files.update({"vertices.npy": _npy(np.eye(2, 3))}),
    "flat vertices": lambda files: files.update({"vertices.npy": _npy(np.eye(4, 2))}),
    "no array": lambda files: files.update({"vertices.npy": b"\x93NUMPY\x01\x00"}),
    "compressed": lambda files: zipfile.ZIP_DEFLATED,
    "something that runs": _pickled,
}


def _npy(values) -> bytes:
    content = BytesIO()
    np.save(content, values)
    return content.getvalue()


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_archives_that_are_no_surface_are_refused(blobs, change):
    with pytest.raises(InvalidFile):
        blobs.surface(_changed(blobs, change))


def test_mangled_archives_are_surfaces_or_refused(blobs):
    data = blobs.get(blobs.put_surface(RAGGED))
    random = np.random.default_rng(0)
    for _ in range(200):
        mangled = bytearray(data)
        for place in random.integers(len(data), size=random.integers(1, 6)):
            mangled[place] = random.integers(256)
        cut = random.integers(len(data) // 2, len(data) + 1)
        blob = blobs.put(bytes(mangled[:cut]))
        with suppress(InvalidFile):
            assert isinstance(blobs.surface(blob), Mesh | PolygonMesh)


def test_results_come_back(blobs, tmp_path):
    result = hk.combine(random_disk(0, 30), random_disk(1, 30), [[0, 0], [5, 5], [10, 10]])
    blob = blobs.put_result(result)
    assert blobs.put_result(result) == blob
    again = blobs.result(blob)
    assert isinstance(again, hk.CombinedMesh)
    np.testing.assert_array_equal(again.vertices_a, result.vertices_a)
    hk.save(tmp_path / "same.npz", again)
    assert blobs.get(blob) == (tmp_path / "same.npz").read_bytes()
    assert len(kept(blobs)) == 1
    with pytest.raises(InvalidFile, match="no result"):
        blobs.result(blobs.put(b"text"))
    with pytest.raises(InvalidInput, match="no result that can be saved"):
        blobs.put_result(TRIANGLES)


# Several processes


def test_two_processes_put_the_same_at_once(blobs):
    program = (
        "import sys; from henkei.studio.blobs import Blobs; b = Blobs(sys.argv[1]);"
        "print('ready', flush=True); sys.stdin.readline();"
        "print(*[b.put(bytes([n]) * 20_000) for n in range(30)])"
    )
    command = [sys.executable, "-c", program, str(blobs.folder)]
    pipe = subprocess.PIPE
    processes = [subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) for _ in range(2)]
    for process in processes:
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()
    answers = [process.communicate(timeout=60)[0] for process in processes]
    assert answers[0] == answers[1]
    assert set(answers[0].split()) == kept(blobs)
    for n, blob in enumerate(answers[0].split()):
        assert blobs.get(blob) == bytes([n]) * 20_000


# Sweeping


def test_a_sweep_removes_what_is_old_and_not_needed(blobs):
    needed, old = blobs.put(b"needed"), blobs.put(b"old")
    archive = blobs.put_surface(TRIANGLES)
    (blobs.folder / ".0123456789ab.npz").touch()
    (blobs.folder / "a file of a person.txt").touch()
    age(blobs, 100)
    young = blobs.put(b"young")
    assert blobs.sweep({needed}, time.time() - 50) == 3
    assert kept(blobs) == {needed, young, "a file of a person.txt"}
    for gone in (old, archive):
        with pytest.raises(InvalidFile):
            blobs.get(gone)


def test_what_is_put_again_or_asked_for_counts_as_young(blobs):
    put, asked, neither = blobs.put(b"put"), blobs.put(b"asked"), blobs.put(b"neither")
    age(blobs, 100)
    blobs.put(b"put")
    blobs.get(asked)
    assert blobs.sweep(set(), time.time() - 50) == 1
    assert kept(blobs) == {put, asked}
    assert neither not in kept(blobs)
