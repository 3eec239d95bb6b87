"""Long work of a session: what methods compute, files that are read and written."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from henkei.studio import uploads
from henkei.studio.downloads import MOST, Downloads
from henkei.studio.jobs import Cancelled, Done, Jobs, Outcome, Task
from henkei.studio.tabs.base import Work

Post = Callable[[Callable[[], None]], None]
Tell = Callable[[dict[str, Any]], None]
Ended = Callable[[Outcome], None]
Show = Callable[[dict[str, Any], NDArray[Any]], None]
EXPORT = "henkei.studio.tasks.export:run"
DOWNLOADS = "downloads"


class Works:
    """Starts work in other processes, and tells pages how far it is.

    Parameters
    ----------
    folder : of sessions; blobs : of blobs.
    post : runs something on the session's thread.
    tell : says something to all pages.
    """

    def __init__(self, folder: Path, blobs: Path, post: Post, tell: Tell) -> None:
        self._post, self._tell = post, tell
        self._jobs = Jobs(blobs)
        self._downloads = Downloads(folder / DOWNLOADS / secrets.token_hex(8))
        self._exported: dict[str, dict[str, Any]] = {}  # how it ended, until fetched
        self._started: dict[str, tuple[str, Work]] = {}  # by tabs, for the open document

    @property
    def listed(self) -> list[dict[str, Any]]:
        """The work that goes on, for pages that come."""
        return [
            {"job": job, "tab": tab, "title": work.title, "cancellable": True}
            for job, (tab, work) in self._started.items()
        ]

    @property
    def exported(self) -> list[dict[str, Any]]:
        """How exports ended that nobody has fetched, for pages that were not there."""
        return list(self._exported.values())

    def is_going_on(self, tab: str, work: Work) -> bool:
        """Whether just this is being done already."""
        return (tab, work) in self._started.values()

    def start(self, tab: str, work: Work, ended: Ended, show: Show) -> None:
        """Do what an action of a tab asks for.

        Parameters
        ----------
        ended : called on the session's thread, unless another document was opened meanwhile.
        show : called there with header and positions of what the work shows on its way.
        """

        def snapshot(job: str, header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> None:
            self._post(lambda: shown(job, header, arrays["positions"]))

        def shown(job: str, header: dict[str, Any], positions: NDArray[Any]) -> None:
            if job in self._started:
                show({"exact": False, **header, "tab": tab}, positions)

        def over(job: str, outcome: Outcome) -> None:
            self._post(lambda: finished(job, outcome))

        def finished(job: str, outcome: Outcome) -> None:
            if self._started.pop(job, None) is None:  # of another document
                self._told(job, Cancelled())
                return
            self._warn(outcome)
            try:
                ended(outcome)
            finally:
                self._told(job, outcome)

        job = self._jobs.start(
            Task(work.function, work.request),
            title=work.title,
            on_progress=self._progress(work.title, tab),
            on_snapshot=snapshot,
            on_end=over,
        )
        self._started[job] = tab, work

    def read(self, path: Path, name: str, ended: Ended, *, alone: bool) -> None:
        """Read a mesh file in a restricted process; see :func:`henkei.studio.uploads.parse`."""
        over, progress = self._read(ended), self._progress(f"Open {name}")
        uploads.parse(path, name, self._jobs, on_end=over, on_progress=progress, alone=alone)

    def read_recipe(self, path: Path, name: str, ended: Ended) -> None:
        """Read a recipe so; see :func:`henkei.studio.uploads.parse_recipe`."""
        over, progress = self._read(ended), self._progress(f"Open {name}")
        uploads.parse_recipe(path, name, self._jobs, on_end=over, on_progress=progress)

    def _read(self, ended: Ended) -> Callable[[str, Outcome], None]:
        """What is done when a file was read."""

        def over(job: str, outcome: Outcome) -> None:
            self._post(lambda: finished(job, outcome))

        def finished(job: str, outcome: Outcome) -> None:
            self._warn(outcome)
            try:
                ended(outcome)
            finally:
                self._tell({"kind": "ended", "job": job, "outcome": _kind(outcome), "message": ""})

        return over

    def write(self, tab: str, request: Mapping[str, Any]) -> dict[str, str]:
        """Write a file, and tell when it can be fetched; the ids of the job and of the file."""
        ident, folder = self._downloads.place()

        def over(job: str, outcome: Outcome) -> None:
            self._post(lambda: finished(job, outcome))

        def finished(job: str, outcome: Outcome) -> None:
            name = ""
            if isinstance(outcome, Done):
                path = Path(outcome.result["file"])
                self._downloads.put(ident, path)
                name = path.name
            for earlier in [one for one, how in self._exported.items() if not how["name"]]:
                del self._exported[earlier]  # that it failed was told long ago
            self._exported[ident] = self._told(job, outcome, file=ident, name=name)
            while len(self._exported) > MOST:
                self._exported.pop(next(iter(self._exported)))

        task = Task(EXPORT, {"tab": tab, "folder": str(folder), **request})
        progress = self._progress("Export", tab)
        job = self._jobs.start(task, title="Export", on_progress=progress, on_end=over)
        return {"job": job, "file": ident}

    def written(self, ident: str) -> tuple[Path, str] | None:
        """A file that was written, and its name; it counts as fetched."""
        self._exported.pop(ident, None)
        return self._downloads.get(ident)

    def cancel(self, job: str) -> None:
        """Stop a job."""
        self._jobs.cancel(job)

    def abandon(self) -> None:
        """Another document is opened: nobody waits for what is computed."""
        for job in list(self._started):
            self._jobs.cancel(job)
        self._started.clear()

    def close(self) -> None:
        """End everything."""
        self._jobs.close()
        self._downloads.close()

    def _progress(self, title: str, tab: str | None = None) -> Callable[[str, str, float], None]:
        def progress(job: str, message: str, fraction: float) -> None:
            told = {"job": job, "tab": tab, "title": title, "message": message}
            self._tell({"kind": "progress", **told, "fraction": fraction, "cancellable": True})

        return progress

    def _warn(self, outcome: Outcome) -> None:
        for warning in outcome.warnings if isinstance(outcome, Done) else ():
            self._tell({"kind": "notice", "level": "warning", "message": warning})

    def _told(self, job: str, outcome: Outcome, **more: str) -> dict[str, Any]:
        """Tell how a job ended; what was told."""
        how = {"outcome": _kind(outcome), "message": reason(outcome)}
        told = {"kind": "ended", "job": job, **how, **more}
        self._tell(told)
        return told


def reason(outcome: Outcome) -> str:
    """Why it did not end well; nothing if it did."""
    return str(getattr(outcome, "message", ""))


def _kind(outcome: Outcome) -> str:
    if isinstance(outcome, Done | Cancelled):
        return "done" if isinstance(outcome, Done) else "cancelled"
    return type(outcome).__name__.lower()
