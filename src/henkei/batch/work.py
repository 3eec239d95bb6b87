"""One scan: what is needed for it, the work itself, and what comes of it, all to be sent about."""

from __future__ import annotations

import hashlib
import json
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, is_dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

import henkei
from henkei.batch.files import Files, Hash, by_file
from henkei.batch.notes import Note, annotate
from henkei.errors import Cancelled, HenkeiError, InvalidInput
from henkei.io import write
from henkei.mesh import Mesh
from henkei.progress import Progress, silent
from henkei.workflows.labels import labels_in
from henkei.workflows.results import SUFFIX, save

Labels = NDArray[np.int64]


@dataclass(frozen=True)
class Plan:
    """What is the same for all scans.

    method : registers two meshes, as :func:`henkei.register` does.
    template : the mesh whose connectivity all results have.
    mediator : the name of a built-in one, or a mesh.
    labels : (n,) regions of the template's vertices, or None.
    options : further keyword arguments of the method; plain values and dataclasses of them.
    mesh_suffix : in which format the meshes are written.
    version : of the henkei that planned it.
    """

    method: Callable[..., Any]
    template: Files
    mediator: str | Files = "sphere"
    labels: Labels | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    mesh_suffix: str = ".ply"
    version: str = field(default_factory=lambda: str(henkei.__version__))

    @property
    def plain_options(self) -> dict[str, Any]:
        """The options, as JSON has them."""
        plain: dict[str, Any] = json.loads(json.dumps(self.options, default=_plain))
        return plain

    def key(self, job: Job) -> str:
        """SHA-256 over all that the result of a scan follows from."""
        digest = self._digest.copy()
        job.scan.feed(digest)
        _feed(digest, job.landmarks)
        _feed(digest, job.labels)
        return str(digest.hexdigest())

    @cached_property
    def _digest(self) -> Any:
        digest = hashlib.sha256()
        method = f"{self.method.__module__}.{self.method.__qualname__}"
        _feed(digest, f"henkei {self.version} {method}")
        _feed(digest, json.dumps(self.plain_options, sort_keys=True))
        self.template.feed(digest)
        if isinstance(self.mediator, Files):
            self.mediator.feed(digest)
        else:
            _feed(digest, self.mediator)
        _feed(digest, self.labels)
        return digest

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_digest"}


@dataclass(frozen=True)
class Job:
    """A scan to be registered.

    name : of its results. index : its number among the scans.
    landmarks : (k, 2) vertices of template and scan, or (k, 2, 3) points.
    labels : (n,) regions of the scan's vertices, the name of the attribute that has them, or None.
    key : see :meth:`Plan.key`.
    """

    name: str
    index: int
    scan: Files
    landmarks: NDArray[Any]
    labels: Labels | str | None = None
    key: str = ""

    def with_key(self, key: str) -> Job:
        """The same with its key."""
        return replace(self, key=key)


@dataclass(frozen=True)
class Outcome:
    """What came of a scan.

    files : bytes by ending, the result and the mesh; nothing if it failed.
    quality : figures by name.
    error : why it failed, or nothing; ``trace`` has more where henkei itself is at fault.
    told : warnings.
    """

    index: int
    seconds: float
    files: Mapping[str, bytes] = field(default_factory=dict)
    quality: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""
    trace: str = ""
    told: tuple[str, ...] = ()


def worked(plan: Plan, job: Job, progress: Progress = silent) -> Outcome:
    """Register one scan. Whatever is wrong with it comes back as text, not as an exception.

    Raises
    ------
    Cancelled : the progress function asked to stop.
    """
    started = time.perf_counter()
    error, trace = "", ""
    files: dict[str, bytes] = {}
    quality: dict[str, Any] = {}
    with (
        TemporaryDirectory(prefix="henkei-") as place,
        warnings.catch_warnings(record=True) as told,
    ):
        warnings.simplefilter("always", UserWarning)
        try:
            files, quality = _made(plan, job, Path(place), progress)
        except Cancelled:
            raise
        except HenkeiError as refused:
            error = str(refused)
        except MemoryError:
            error = "there is not enough memory for this scan; use fewer workers or a smaller mesh"
        except Exception as fault:
            error = f"a fault of henkei, please report it: {type(fault).__name__}: {fault}"
            trace = traceback.format_exc()
    texts = [_for_people(text, plan, job, place) for text in (error, *map(_text, told))]
    seconds = time.perf_counter() - started
    return Outcome(
        job.index, seconds, files, quality, texts[0], trace, tuple(dict.fromkeys(texts[1:]))
    )


def _text(warning: warnings.WarningMessage) -> str:
    return str(warning.message)


def _for_people(text: str, plan: Plan, job: Job, place: str) -> str:
    """A message with the files as the user named them, for those that lie in a folder here."""
    for own, files in (("template", plan.template), ("scan", job.scan)):
        text = text.replace(str(Path(place, own, next(iter(files.contents)))), files.path)
    return by_file(text, source=plan.template.path, target=job.scan.path)


def _made(
    plan: Plan, job: Job, folder: Path, progress: Progress
) -> tuple[dict[str, bytes], dict[str, Any]]:
    """The files of a result, as bytes by ending, and its quality."""
    if plan.version != henkei.__version__:
        raise InvalidInput(
            f"this worker has henkei {henkei.__version__}, the run was started with {plan.version};"
            " install the same everywhere"
        )
    template, scan = (
        Mesh.from_any(files.lay_in(folder / name))
        for name, files in (("template", plan.template), ("scan", job.scan))
    )
    result = plan.method(
        template,
        scan,
        mediator=_mediator(plan, folder),
        landmarks=job.landmarks,
        regions=_regions(plan, job, scan),
        progress=progress,
        **plan.options,
    )
    quality = asdict(result.quality)
    npz, mesh = (folder / f"{job.name}{suffix}" for suffix in (SUFFIX, plan.mesh_suffix))
    save(npz, result)
    annotate(npz, Note(job.key, plan.mesh_suffix, quality))
    write(mesh, result.mesh)
    return {SUFFIX: npz.read_bytes(), plan.mesh_suffix: mesh.read_bytes()}, quality


def _mediator(plan: Plan, folder: Path) -> str | Mesh:
    if isinstance(plan.mediator, str):
        return plan.mediator
    return Mesh.from_any(plan.mediator.lay_in(folder / "mediator"))


def _regions(plan: Plan, job: Job, scan: Mesh) -> tuple[Labels, Labels] | None:
    if plan.labels is None or job.labels is None:
        return None
    own = job.labels
    return plan.labels, labels_in(scan, own, job.scan.path) if isinstance(own, str) else own


def _feed(digest: Hash, value: NDArray[Any] | str | None) -> None:
    """Add a value to a hash, in a way that is unambiguous."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str} {value.shape}:".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    else:
        text = repr(value)
        digest.update(f"{len(text)}:{text}".encode())


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    raise InvalidInput(f"{value!r} cannot be sent to workers as an option; use plain values")
