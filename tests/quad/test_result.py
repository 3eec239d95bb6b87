"""The result of quads: what it says of itself, and its way through a file."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidFile
from henkei.quad.quality import QuadQuality
from henkei.shapes import hemisphere, icosphere


@pytest.fixture(scope="module")
def ball() -> hk.QuadResult:
    return hk.quadrangulate(icosphere(2), quads=60)


@pytest.fixture(scope="module")
def saved(ball, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "quads.npz"
    hk.save(path, ball)
    return path


def test_tables_fit_the_quads(ball):
    count = ball.quality.quads
    assert ball.mesh.faces.shape == (count, 4)
    assert ball.patches.shape == (count,)
    assert ball.uv.shape == (count, 4, 2)
    np.testing.assert_array_equal(ball.uv.reshape(-1, 2), ball.mesh.attributes.corner["uv"])
    assert len(ball.on_input) == len(ball.mesh.vertices) == ball.quality.vertices
    assert repr(ball).startswith(f"QuadResult({count} quads, {ball.quality.irregular} irregular")


def test_read_again_it_is_equal(ball, saved):
    read = hk.load(saved)
    assert isinstance(read, hk.QuadResult)
    arrays, others = ball.to_arrays(), read.to_arrays()
    assert arrays.keys() == others.keys()
    for name, values in arrays.items():
        assert values.dtype == others[name].dtype, name
        assert values.shape == others[name].shape, name
        assert values.tobytes() == others[name].tobytes(), name
    for name in QuadQuality.__dataclass_fields__:
        if name != "seconds":
            assert getattr(read.quality, name) == getattr(ball.quality, name), name
    assert read.quality.seconds == {}
    assert isinstance(read.layout, hk.Mesh)


def test_equal_quads_give_equal_bytes(saved, tmp_path):
    hk.save(tmp_path / "again.npz", hk.quadrangulate(icosphere(2), quads=60))
    assert (tmp_path / "again.npz").read_bytes() == saved.read_bytes()


def test_a_result_without_features(tmp_path):
    ball = hk.quadrangulate(icosphere(1), quads=24)
    assert ball.features.shape == (0, 2)
    hk.save(tmp_path / "quads.npz", ball)
    assert hk.load(tmp_path / "quads.npz").features.shape == (0, 2)


def test_features_of_a_sheet_are_its_boundary(tmp_path):
    sheet = hk.quadrangulate(hemisphere(2), quads=40)
    hk.save(tmp_path / "quads.npz", sheet)
    read = hk.load(tmp_path / "quads.npz")
    topology = read.mesh.topology
    rim = np.column_stack([read.mesh.indices, topology.target])[topology.twin < 0]
    assert {frozenset(edge) for edge in rim.tolist()} <= {
        frozenset(edge) for edge in read.features.tolist()
    }


def change(name: str, values: object):
    def changed(arrays: dict) -> dict:
        return {**arrays, name: np.asarray(values)}

    return changed


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (lambda arrays: {n: v for n, v in arrays.items() if n != "uv"}, "uv missing"),
        (lambda arrays: {n: v for n, v in arrays.items() if n != "quality.quads"}, "is missing"),
        (lambda arrays: {**arrays, "faces": arrays["faces"] + 10**6}, "do not exist"),
        (lambda arrays: {**arrays, "layout.faces": arrays["layout.faces"] + 10**6}, "not exist"),
        (lambda arrays: {**arrays, "faces": arrays["faces"][:, :3]}, "damaged: faces is"),
        (lambda arrays: {**arrays, "patch": arrays["patch"][:-1]}, "damaged: patch is"),
        (change("features", [[0, 10**6]]), "features names vertices"),
        (change("quality.irregular", [1, 2]), "quality.irregular is not one figure"),
    ],
)
def test_other_content_is_refused(saved, tmp_path, changed, message):
    with np.load(saved) as archive:
        arrays = dict(archive)
    path = tmp_path / "quads.npz"
    np.savez(path, **changed(arrays))
    with pytest.raises(InvalidFile, match=message):
        hk.load(path)
