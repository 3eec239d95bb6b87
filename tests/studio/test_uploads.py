"""Files from outside: read as they are, or refused in words; never more than that."""

from __future__ import annotations

import json
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from bodies import together
from henkei.errors import InvalidInput
from henkei.shapes import cube_cage, random_disk
from henkei.studio import uploads
from henkei.studio.blobs import Blobs
from henkei.studio.jobs import TASKS, Done, Failed, Jobs, Refused, Task
from henkei.studio.tasks.read_file import about
from hostile_files import gltf, lies, mutated, sound
from topologies import handlebody, tetrahedron, tube
from written import decoded, encoded, patchwork, same_shape, sheet

SOON = 60.0
MUTATIONS = 160
linux = pytest.mark.skipif(sys.platform != "linux", reason="limits as Linux has them")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with one of the blobs in it, and jobs."""
    place = tmp_path_factory.mktemp("studio")
    jobs = Jobs(place / "blobs", memory=2**28, idle=0, allowed=(*TASKS, "studio_tasks:"))
    yield place, jobs
    closing = threading.Thread(target=jobs.close, daemon=True)
    closing.start()
    closing.join(SOON)
    assert not closing.is_alive()


class End:
    """Of a job; called by it, and waited for by the test."""

    def __init__(self):
        self._over = threading.Event()

    def __call__(self, job, outcome):
        self._outcome = outcome
        self._over.set()

    @property
    def outcome(self):
        assert self._over.wait(SOON)
        return self._outcome


def parsed(place, path, name, **options):
    folder, jobs = place
    end = End()
    uploads.parse(path, name, jobs, on_end=end, **options)
    outcome = end.outcome
    assert not list(folder.glob("upload-*"))
    return outcome


def listing(folder):
    return {
        (str(path), path.stat().st_size)
        for path in folder.rglob("*")
        if "blobs" not in path.relative_to(folder).parts
    }


@pytest.mark.parametrize(("surface", "suffix"), [(patchwork(), ".obj"), (sheet(), ".GLB")])
def test_a_sound_file(place, surface, suffix):
    folder, _ = place
    kind = suffix[1:].lower()
    data = encoded(kind, surface)
    (folder / "temporary").write_bytes(data)
    outcome = parsed(place, folder / "temporary", f"C:\\Meshes\\My head{suffix}")
    assert isinstance(outcome, Done)
    read = Blobs(folder / "blobs").surface(outcome.result.pop("surface"))
    expected = decoded(kind, data)
    assert same_shape(read, expected)
    assert list(read.attributes.vertex) == list(expected.attributes.vertex)
    assert outcome.result == {
        "name": f"My head{suffix}",
        "vertices": len(surface.vertices),
        "faces": surface.face_count,
        "about": about(expected),
    }
    assert (folder / "temporary").read_bytes() == data


def test_a_file_of_ones_own_may_have_others_beside_it(place, tmp_path):
    (tmp_path / "b.bin").write_bytes(np.array([0, 0, 0, 1, 0, 0, 0, 1, 0], "<f4").tobytes())
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps(gltf("b.bin")))
    before = listing(tmp_path)
    assert parsed(place, path, "a.gltf", alone=False).result["faces"] == 1
    refused = parsed(place, path, "from outside.gltf")
    assert refused.message == (
        "from outside.gltf: its numbers are in another file, 'b.bin', which did not come with it; "
        "save it as .glb, which has everything in one file"
    )
    assert listing(tmp_path) == before


def test_messages_and_warnings_have_the_name_of_the_file(place, tmp_path):
    path = tmp_path / "received"
    path.write_bytes(b"ply\nformat ascii 1.0\n")
    outcome = parsed(place, path, "kopf <b>.obj")
    assert outcome == Refused(
        "kopf <b>.obj: the content is PLY, not OBJ; rename it to kopf <b>.ply"
    )
    colours = b"v 0 0 0 nan 0 0\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n"
    path.write_bytes(colours)
    outcome = parsed(place, path, "a.obj")
    assert outcome.warnings == ("a.obj: NaN in the colours of 0",)


@pytest.mark.parametrize(
    ("function", "kind", "message"),
    [
        ("spins", Refused, "a.obj: this took longer than 0.2 seconds"),
        ("exits", Failed, "a.obj: the work ended unexpectedly"),
    ],
)
def test_a_reader_that_hangs_or_dies(place, tmp_path, monkeypatch, function, kind, message):
    monkeypatch.setattr(uploads, "READ_FILE", f"studio_tasks:{function}")
    path = tmp_path / "a.obj"
    path.write_bytes(b"v 0 0 0\n")
    outcome = parsed(place, path, path.name, seconds=0.2 if function == "spins" else SOON)
    assert isinstance(outcome, kind)
    assert outcome.message.startswith(message)
    assert [file.name for file in tmp_path.iterdir()] == ["a.obj"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("result.npz", "a result of henkei, not a mesh; write its surface as a mesh first"),
        ("bones.VTS", "landmarks, not a mesh"),
        ("bones.pp", "landmarks, not a mesh"),
        ("bones.mrk.json", "landmarks, not a mesh"),
        ("bones.fcsv", "landmarks, not a mesh"),
        ("recipe.json", "landmarks or a recipe, not a mesh"),
        ("head.obj.zip", "unpack it"),
    ],
)
def test_what_is_no_mesh_is_refused_by_its_name(place, tmp_path, name, message):
    with pytest.raises(InvalidInput, match=message) as caught:
        uploads.parse(tmp_path / "received", name, place[1], on_end=End())
    assert str(caught.value).startswith(f"{name}: ")


def test_what_is_too_large_or_not_there_is_refused_at_once(place, tmp_path):
    path = tmp_path / "received"
    with pytest.raises(InvalidInput, match=r"^a\.obj: cannot be read \(No such file"):
        uploads.parse(path, "a.obj", place[1], on_end=End())
    with path.open("wb") as stream:
        stream.truncate(3 * 2**30)
    with pytest.raises(InvalidInput, match=r"3,072 MiB are more than the 2,048 MiB"):
        uploads.parse(path, "a.obj", place[1], on_end=End())
    with pytest.raises(InvalidInput, match="not a file"):
        uploads.parse(tmp_path, "a.obj", place[1], on_end=End())
    assert list(tmp_path.iterdir()) == [path]


def test_too_many_faces_are_refused(place, tmp_path, monkeypatch):
    monkeypatch.setattr("henkei.studio.tasks.read_file.MOST_FACES", 7)
    hk.write(tmp_path / "a.off", sheet())
    from henkei.studio.tasks import read_file

    with pytest.raises(InvalidInput, match="8 faces are more than the 7"):
        read_file.run({"path": str(tmp_path / "a.off"), "alone": True}, None, Silent())


class Silent:
    """A report that tells nobody."""

    def progress(self, message, fraction):
        pass


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("head.obj", "head.obj"),
        ("/home/me/head.obj", "head.obj"),
        ("C:\\Users\\me\\head.obj", "head.obj"),
        ("../../etc/passwd", "passwd"),
        ("голова 頭.ply", "голова 頭.ply"),
        ("e\u0301.obj", "é.obj"),
        ("a\x00b\nc\x1b[31m.obj", "a b c [31m.obj"),
        ("moc.\u202efbo.obj", "moc. fbo.obj"),
        ("x" * 300 + ".obj", "x" * 75 + "….obj"),
        ("x" * 300 + "." + "y" * 300, "x" * 79 + "…"),
        ("", "mesh"),
        ("..", "mesh"),
        ("/", "mesh"),
        (" \t ", "mesh"),
    ],
)
def test_display_names(name, shown):
    assert uploads.display_name(name) == shown
    assert uploads.display_name(shown) == shown


@linux
def test_mangled_files_end_in_a_surface_or_a_refusal(place, tmp_path):
    """All in one restricted process, which survives them; half are mutations that may be sound."""
    folder, jobs = place
    hostile = tmp_path / "hostile"
    hostile.mkdir()
    originals = list(sound(tmp_path).items())
    for seed in range(MUTATIONS):
        name, data = originals[seed % len(originals)]
        (hostile / f"{seed}-{name}").write_bytes(mutated(data, seed))
    made = lies()
    for name, data in made.items():
        (hostile / name).write_bytes(data)
    assert len(made) + MUTATIONS >= 200
    before, memory = listing(tmp_path) | listing(folder), resident()
    end = End()
    jobs.start(
        Task("studio_tasks:reads_all", {"folder": str(hostile)}, (str(hostile),)),
        title="hostile files",
        on_end=end,
        limit_seconds=SOON,
        restricted=True,
    )
    ends = end.outcome.result
    assert listing(tmp_path) | listing(folder) == before
    assert resident() - memory < 2**26
    assert set(ends) == {path.name for path in hostile.iterdir()}
    blobs = Blobs(folder / "blobs")
    for name, (kind, told) in ends.items():
        if kind == "surface":
            surface = blobs.surface(told)
            assert surface.face_count > 0
            assert np.isfinite(surface.vertices).all()
        else:
            assert name in told
            assert "root:" not in told
    assert {ends[name][0] for name in made} == {"refused"}
    assert {kind for kind, _ in ends.values()} == {"surface", "refused"}


def resident():
    """Bytes of memory of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.parametrize(
    ("surface", "line"),
    [
        (tetrahedron(), "closed, genus 0, 1 piece"),
        (together(tetrahedron(), tetrahedron()), "closed, genus 0, 2 pieces"),
        (handlebody(3), "closed, genus 3, 1 piece"),
        (random_disk(0, 30), "1 boundary loop, genus 0, 1 piece"),
        (tube(8, 3), "2 boundary loops, genus 0, 1 piece"),
        (cube_cage(), "quads, closed, genus 0, 1 piece"),
        (patchwork(), "polygons, "),
        (
            hk.Mesh(np.eye(5, 3), [[0, 1, 2], [1, 0, 3], [0, 1, 4]]),
            "not manifold: 1 edge of more than two faces; 1 piece",
        ),
        (
            hk.Mesh(np.eye(5, 3), [[0, 1, 2], [0, 3, 4]]),
            "not manifold: 1 vertex of more than one fan; 2 pieces",
        ),
        (
            hk.Mesh(np.eye(4, 3), [[0, 1, 2], [1, 1, 3]]),
            "not manifold: 1 vertex of more than one fan, 1 face that repeats a vertex; 2 pieces",
        ),
        (
            hk.Mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3]]),
            "1 boundary loop, genus 0, 1 piece; faces wind against each other along 1 edge",
        ),
        (
            hk.Mesh(np.eye(5, 3), [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]]),
            "one-sided, 1 piece",
        ),
    ],
)
def test_about(surface, line):
    assert about(surface).startswith(line)
