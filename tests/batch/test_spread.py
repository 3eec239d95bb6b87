"""Workers in processes of their own, and clusters: the same bytes, whatever happens to a worker."""

from __future__ import annotations

from pathlib import Path

import pytest

import henkei as hk
import stand_in
from henkei.batch import Report, register_many, spread
from henkei.shapes import random_disk


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder with a template and five scans, the third of which kills its worker."""
    monkeypatch.chdir(tmp_path)
    Path("scans").mkdir()
    hk.write("template.obj", random_disk(0, 20))
    for seed, size in enumerate([25, stand_in.REFUSED, stand_in.DEADLY, 26, 27]):
        hk.write(f"scans/{seed}.ply", random_disk(seed, size))
    return tmp_path


def run(scans: list[Path], output: str, **settings) -> Report:
    settings = {"method": stand_in.registered, **settings}
    return register_many(Path("template.obj"), scans, Path(output), **settings)


def contents(folder: str) -> dict[str, bytes]:
    return {
        path.name: path.read_bytes()
        for path in Path(folder).iterdir()
        if not path.name.startswith("report.")
    }


def test_processes_give_the_same_bytes_and_survive_a_deadly_scan():
    report = run([Path("scans")], "many", workers=2)
    assert [row.status for row in report.rows] == ["done", "failed", "failed", "done", "done"]
    assert report.rows[2].error.startswith("the worker's process ended each time it was tried")
    harmless = [Path(f"scans/{k}.ply") for k in (4, 3, 0)]
    run(harmless, "one_by_one", workers=1)
    assert contents("many") == contents("one_by_one")
    assert len(contents("many")) == 6


def test_a_cluster_gives_the_same_bytes(monkeypatch):
    distributed = pytest.importorskip("distributed")
    harmless = [Path(f"scans/{k}.ply") for k in (0, 1, 3, 4)]
    run(harmless, "one_by_one", workers=1)
    options = {"n_workers": 1, "processes": False, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(threads_per_worker=1, **options) as cluster:
        address = cluster.scheduler_address
        monkeypatch.setattr(spread, "FEWEST_IN_FLIGHT", 1)
        report = run(harmless, "cluster", scheduler=address)
        assert [row.status for row in report.rows] == ["done", "failed", "done", "done"]
        assert contents("cluster") == contents("one_by_one")
        monkeypatch.setattr(hk, "__version__", "99.0", raising=False)
        with pytest.raises(hk.errors.InvalidInput, match=r"need henkei 99.0, as here: the sched"):
            run(harmless, "cluster", scheduler=address)


@pytest.mark.parametrize(
    ("scheduler", "reason"),
    [("tcp://127.0.0.1:1", "no Dask scheduler answers at tcp"), ("nonsense", "missing port")],
)
def test_no_scheduler_there(monkeypatch, scheduler, reason):
    pytest.importorskip("distributed")
    monkeypatch.setattr(spread, "PATIENCE", 0.2)
    with pytest.raises(hk.errors.InvalidInput, match=reason):
        run([Path("scans")], "out", scheduler=scheduler)
