"""Work on many scans: in this process, on the cores of this machine, or on a Dask cluster.

A scan goes to a worker as the bytes of its files and comes back as the bytes of its results, so the
workers need no file system in common with the one who asks, and whoever does the work, the bytes
are the same.
"""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Generator, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from itertools import chain, islice
from pathlib import Path
from secrets import token_hex
from typing import TYPE_CHECKING, Any

import henkei
from henkei.batch.work import Job, Outcome, Plan, worked
from henkei.errors import HenkeiError, InvalidInput, MissingDependency, some
from henkei.progress import Progress, part

if TYPE_CHECKING:
    from distributed import Client, Future

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
THIS_MACHINE = "127.0.0.1:0"  # any port, for nobody else
PATIENCE = 30.0  # seconds to wait for a scheduler to answer
FEWEST_IN_FLIGHT = 8  # so that a cluster that grows by demand sees some


def outcomes(
    plan: Plan,
    jobs: Iterator[Job],
    count: int,
    workers: int | None,
    scheduler: str | None,
    progress: Progress,
) -> Generator[Outcome]:
    """The outcome of each job, as they come. Jobs are taken when there is a place for them.

    Parameters
    ----------
    count : how many scans there are in all, for the progress.
    workers : processes on this machine, or None for one a core.
    scheduler : the address or the scheduler file of a Dask cluster, used in place of those.

    Raises
    ------
    MissingDependency : Dask is needed and not installed.
    InvalidInput : no scheduler answers.
    HenkeiError : the scheduler is lost.
    """
    first = list(islice(jobs, 2))
    jobs = chain(first, jobs)
    workers = workers or cores()
    if not first:
        return
    if scheduler is not None:
        with _connected(scheduler) as client:
            if not client.nthreads():
                progress("waiting for the cluster's workers", 0.0)
            yield from _on_dask(client, plan, jobs)
    elif workers == 1 or len(first) == 1:
        for job in jobs:
            yield worked(plan, job, _of_job(progress, job, count))
    else:
        with _local(min(workers, count)) as client:
            # Were one more on its way, it would wait at a worker, and be blamed if that one dies.
            yield from _on_dask(client, plan, jobs, at_once=min(workers, count))


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _of_job(progress: Progress, job: Job, count: int) -> Progress:
    own = part(progress, job.index / count, (job.index + 1) / count)

    def report(message: str, fraction: float) -> None:
        own(f"{job.index + 1} of {count}, {job.name}: {message}", fraction)

    return report


def _require_dask(otherwise: str = "") -> None:
    if find_spec("distributed") is None:
        raise MissingDependency(f"this needs Dask: pip install henkei[batch]{otherwise}")


@contextmanager
def _local(workers: int) -> Iterator[Client]:
    """A cluster of processes on this machine, each with one thread."""
    _require_dask("; or do one scan after the other: --workers 1")
    import dask
    from distributed import Client, LocalCluster
    from distributed.system import MEMORY_LIMIT

    settings = {
        # A scan that ends its worker twice (by all the memory it takes, say) is given up.
        "distributed.scheduler.allowed-failures": 1,
        "distributed.nanny.pre-spawn-environ": ONE_THREAD,
        "distributed.worker.preload": ["henkei.batch.worker"],
    }
    with dask.config.set(settings), _quiet():
        try:
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                memory_limit=MEMORY_LIMIT // workers,
                dashboard_address=THIS_MACHINE,
                worker_dashboard_address=THIS_MACHINE,
                silence_logs=logging.CRITICAL,
            )
        except RuntimeError as error:
            raise HenkeiError(
                f"the worker processes do not start ({error}); a script must do its work under "
                'if __name__ == "__main__", and one read from standard input cannot have any'
            ) from None
        with cluster, Client(cluster) as client:
            yield client


@contextmanager
def _connected(scheduler: str) -> Iterator[Client]:
    """A client of a running cluster."""
    _require_dask()
    from distributed import Client

    place: dict[str, Any] = {"address": scheduler}
    if "://" not in scheduler and (scheduler.endswith(".json") or Path(scheduler).is_file()):
        if not Path(scheduler).is_file():
            raise InvalidInput(f"{scheduler}: there is no such scheduler file; is it running?")
        place = {"scheduler_file": scheduler}
    with _quiet():
        try:
            client = Client(**place, timeout=PATIENCE)
        except (OSError, ValueError, TypeError) as error:
            raise InvalidInput(
                f"no Dask scheduler answers at {scheduler} ({error}); start one with: dask "
                "scheduler"
            ) from None
        with client:
            _check_versions(client)
            yield client


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Dask's own messages; what matters is told in the report."""
    import distributed  # noqa: F401, sets the levels of its loggers when it is imported

    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    levels = {name: logging.getLogger(name).level for name in names}
    try:
        for name in names:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def _check_versions(client: Client) -> None:
    """Refuse a cluster that has not the same henkei: it could not even say what is wrong.

    Raises
    ------
    InvalidInput : naming who has another.
    """
    told = client.get_versions(packages=["henkei"])
    own = str(henkei.__version__)
    others = []
    for name, about in {"the scheduler": told["scheduler"], **told["workers"]}.items():
        found = (about or {}).get("packages", {}).get("henkei")
        if found != own:
            others.append(f"{name} has {found or 'none'}")
    if others:
        raise InvalidInput(
            f"scheduler and workers need henkei {own}, as here: {some(others)}; install it there"
        )


def _on_dask(
    client: Client, plan: Plan, jobs: Iterator[Job], at_once: int | None = None
) -> Iterator[Outcome]:
    """Outcomes from a cluster, with a bounded number of jobs on their way."""
    from distributed import as_completed

    run = token_hex(4)
    # A task rather than scattered data: it is made again if the worker that has it dies.
    shared = client.submit(_itself, plan, key=f"plan-{run}")
    on_the_way: dict[str, Job] = {}
    blamed: list[Job] = []
    running = as_completed()

    def send(job: Job, key: str) -> None:
        on_the_way[key] = job
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Sending large graph")
            running.add(client.submit(worked, shared, job, key=key, pure=False))

    def fill() -> None:
        room = (at_once or _in_flight(client)) - running.count()
        for job in islice(jobs, max(room, 0)):
            send(job, f"scan-{run}-{job.index}")

    try:
        fill()
        for future in running:
            job = on_the_way.pop(future.key)
            if _killed(future):
                blamed.append(job)
                fill()
                continue
            outcome = _outcome(future, job.index)
            fill()
            yield outcome
        # Of those that were with a worker when it died, one did it: each is tried by itself.
        for job in blamed:
            send(job, f"scan-{run}-{job.index}-alone")
            future = next(running)
            yield _outcome(future, on_the_way.pop(future.key).index)
    finally:
        with suppress(Exception):
            client.cancel([shared, *running.futures], force=True)


def _itself(plan: Plan) -> Plan:
    return plan


def _in_flight(client: Client) -> int:
    """A job for each thread, and a few that are there when one gets free."""
    threads = int(sum(client.nthreads().values()))
    return max(FEWEST_IN_FLIGHT, threads + threads // 4)


def _killed(future: Future) -> bool:
    """Whether workers died each time they had this job."""
    from distributed import KilledWorker

    return future.status == "error" and isinstance(future.exception(), KilledWorker)


def _outcome(future: Future, index: int) -> Outcome:
    """What came of a job, whatever happened to it."""
    if future.status in ("cancelled", "lost"):
        raise HenkeiError(
            "the Dask scheduler is gone, or dropped the work; run the same command again to go on "
            "with what is left"
        )
    error = future.exception()
    if error is None:
        outcome: Outcome = future.result()
        return outcome
    if _killed(future):
        reason = "the worker's process ended each time it was tried; was there enough memory?"
    else:
        reason = f"the worker could not do it: {type(error).__name__}: {error}"
    return Outcome(index, 0.0, error=reason)
