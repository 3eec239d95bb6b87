"""Many scans into one connectivity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from henkei.batch.files import Files, by_file
from henkei.batch.landmarks import Pairs, landmarks_of_scans
from henkei.batch.report import Report, Row
from henkei.batch.scans import checked_output, listed, named
from henkei.batch.spread import outcomes
from henkei.batch.store import Store
from henkei.batch.work import Job, Labels, Outcome, Plan
from henkei.errors import HenkeiError, InvalidFile, InvalidMesh
from henkei.io import read
from henkei.mesh import Mesh
from henkei.progress import Progress, silent
from henkei.register import Settings, register
from henkei.register.mediators import chosen
from henkei.workflows.labels import is_label_file, labels_in, read_labels


def register_many(
    template: Path,
    scans: Sequence[Path],
    output: Path,
    *,
    mediator: str | Path = "sphere",
    landmarks: Pairs | Path | None = None,
    regions: tuple[str, str] | None = None,
    seed: int = 0,
    settings: Settings | None = None,
    mesh_suffix: str = ".ply",
    workers: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    method: Callable[..., Any] = register,
    progress: Progress = silent,
) -> Report:
    """Register a template onto each scan; ``NAME.npz`` and a mesh of each go into a folder.

    A scan that cannot be done is reported with its error, and the others go on. What an earlier run
    left in the folder is kept if it was made from the same bytes by the same version. The report is
    in the folder too, up to date when this ends, however it ends.

    Where worker processes are started, a script must do its work under ``if __name__ ==
    "__main__"``, as with :mod:`multiprocessing`.

    Parameters
    ----------
    template : file of the mesh whose connectivity all results get.
    scans : files, or folders of them.
    output : folder for the results, made if need be.
    mediator : name of a built-in mediator, or the file of a mesh.
    landmarks : see :func:`henkei.batch.landmarks.landmarks_of_scans`.
    regions : labels of the template's and of the scans' vertices. Each is the name of an attribute
        or a file (see :mod:`henkei.workflows.labels`); the second may be a folder with a file for
        each scan, of the scan's name.
    seed, settings : as of :func:`henkei.register`.
    mesh_suffix : format of the meshes.
    workers : processes on this machine; one for each core by default.
    scheduler : address or scheduler file of a Dask cluster, which does the work instead.
    force : do again what could be kept.
    method : registers two meshes, called as :func:`henkei.register` is; workers must be able to
        import it.
    progress : see :mod:`henkei.progress`; counts scans.

    Raises
    ------
    InvalidInput : no scan, a folder without meshes, two scans of one name, an output folder with
        inputs in it or that cannot be written, no scheduler.
    InvalidFile, InvalidMesh : the template, the mediator, landmarks or labels for all are not
        usable.
    MissingDependency : Dask is needed and not installed.
    """
    by_name = named(listed(scans, template))
    plan = Plan(
        method,
        Files.read(template),
        _mediator(mediator),
        _labels_of_template(template, regions),
        {"seed": seed, "settings": settings or Settings()},
        mesh_suffix,
    )
    run = _Run(
        plan,
        Store(checked_output(output, [template, *by_name.values()]), mesh_suffix),
        Report(_about(plan), [Row(name, str(scan)) for name, scan in by_name.items()]),
        landmarks_of_scans(landmarks, template),
        _labels_of_scans(regions),
        force,
        progress,
    )
    run.go(workers, scheduler)
    return run.report


@dataclass
class _Run:
    """A run under way: what is asked, where results go, and what came of each scan so far."""

    plan: Plan
    store: Store
    report: Report
    landmarks: Callable[[Path], Pairs]
    labels: Callable[[Path], Labels | str | None]
    force: bool
    progress: Progress

    def go(self, workers: int | None, scheduler: str | None) -> None:
        """Do all scans. The report is written however that ends."""
        count = len(self.report.rows)
        keys: dict[int, str] = {}
        try:
            self.report.write(self.store.folder)
            coming = outcomes(self.plan, self._jobs(keys), count, workers, scheduler, self.progress)
            with closing(coming):
                for outcome in coming:
                    self._take(outcome, keys.pop(outcome.index))
        finally:
            self.report.write(self.store.folder)

    def _jobs(self, keys: dict[int, str]) -> Iterator[Job]:
        """The scans that are to be worked on; what is known of the others goes to the report."""
        for index, row in enumerate(self.report.rows):
            scan = Path(row.scan)
            try:
                job = Job(
                    row.name, index, Files.read(scan), self.landmarks(scan), self.labels(scan)
                )
            except HenkeiError as error:
                row.status, row.error = "failed", str(error)
                continue
            job = job.with_key(self.plan.key(job))
            quality = None if self.force else self.store.kept(row.name, job.key)
            if quality is not None:
                row.status, row.quality = "kept", quality
                self._tell(row)
                continue
            keys[index] = job.key
            yield job

    def _take(self, outcome: Outcome, key: str) -> None:
        """Keep what came of a scan."""
        row = self.report.rows[outcome.index]
        if outcome.error:
            self.store.drop(row.name, key)
        else:
            self.store.put(row.name, outcome.files)
        row.status = "failed" if outcome.error else "done"
        row.error, row.trace, row.warnings = outcome.error, outcome.trace, outcome.told
        row.seconds, row.quality = outcome.seconds, outcome.quality
        self.report.write_now_and_then(self.store.folder)
        self._tell(row)

    def _tell(self, row: Row) -> None:
        count = len(self.report.rows)
        ended = count - self.report.count("waiting")
        self.progress(f"{ended} of {count}, {row.name}: {row.told}", ended / count)


def _mediator(given: str | Path) -> str | Files:
    """The mediator, refused now rather than with every scan if it is none."""
    if isinstance(given, str):
        chosen(given)
        return given
    try:
        chosen(read(given))
    except InvalidMesh as error:
        raise type(error)(by_file(str(error), mediator=given)) from None
    return Files.read(given)


def _labels_of_template(template: Path, regions: tuple[str, str] | None) -> Labels | None:
    """The template's labels; the template is looked at in any case."""
    mesh = Mesh.from_any(read(template))
    if regions is None:
        return None
    if not is_label_file(regions[0]):
        return labels_in(mesh, regions[0], str(template))
    labels = read_labels(Path(regions[0]))
    if len(labels) != len(mesh.vertices):
        raise InvalidFile(
            f"{regions[0]}: {len(labels)} labels for the {len(mesh.vertices)} vertices of "
            f"{template}"
        )
    return labels


def _labels_of_scans(regions: tuple[str, str] | None) -> Callable[[Path], Labels | str | None]:
    """A function from a scan to its labels, or to the name of the attribute that has them."""
    if regions is None:
        return lambda scan: None
    given = Path(regions[1])
    if given.is_dir():
        return lambda scan: read_labels(_label_file(given, scan))
    if is_label_file(regions[1]):
        labels = read_labels(given)
        return lambda scan: labels
    return lambda scan: regions[1]


def _label_file(folder: Path, scan: Path) -> Path:
    files = [folder / f"{scan.stem}{ending}" for ending in (".npy", ".txt")]
    found = [file for file in files if file.is_file()]
    if not found:
        raise InvalidFile(
            f"no labels for {scan.stem}: {folder} has neither {files[0].name} nor {files[1].name}"
        )
    return found[0]


def _about(plan: Plan) -> dict[str, Any]:
    """What was the same for all scans, for the report."""
    mediator = plan.mediator if isinstance(plan.mediator, str) else plan.mediator.path
    return {
        "henkei": plan.version,
        "template": plan.template.path,
        "mediator": mediator,
        **plan.plain_options,
    }
