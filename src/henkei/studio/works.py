"""Long work of a session: what methods compute, files that are read and written."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from henkei.studio import uploads
from henkei.studio.downloads import Downloads
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
        self._started: dict[str, tuple[str, Work]] = {}  # by tabs, for the open document

    @property
    def listed(self) -> list[dict[str, Any]]:
        """The work that goes on, for pages that come."""
        return [
            {"job": job, "tab": tab, "title": work.title, "cancellable": True}
            for job, (tab, work) in self._started.items()
        ]

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
                return self._told(job, Cancelled())
            for warning in outcome.warnings if isinstance(outcome, Done) else ():
                self._tell({"kind": "notice", "level": "warning", "message": warning})
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
            try:
                ended(outcome)
            finally:
                self._tell({"kind": "ended", "job": job, "outcome": _kind(outcome), "message": ""})

        return over

    def write(self, tab: str, request: Mapping[str, Any]) -> str:
        """Write a file, and tell where it can be fetched; the id of the job."""
        ident, folder = self._downloads.place()

        def over(job: str, outcome: Outcome) -> None:
            self._post(lambda: finished(job, outcome))

        def finished(job: str, outcome: Outcome) -> None:
            if isinstance(outcome, Done):
                path = Path(outcome.result["file"])
                self._downloads.put(ident, path)
                self._told(job, outcome, file=ident, name=path.name)
            else:
                self._told(job, outcome)

        task = Task(EXPORT, {"tab": tab, "folder": str(folder), **request})
        progress = self._progress("Export", tab)
        return self._jobs.start(task, title="Export", on_progress=progress, on_end=over)

    def written(self, ident: str) -> tuple[Path, str] | None:
        """A file that was written, and its name."""
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

    def _told(self, job: str, outcome: Outcome, **more: str) -> None:
        told = {"outcome": _kind(outcome), "message": reason(outcome)}
        self._tell({"kind": "ended", "job": job, **told, **more})


def reason(outcome: Outcome) -> str:
    """Why it did not end well; nothing if it did."""
    return str(getattr(outcome, "message", ""))


def _kind(outcome: Outcome) -> str:
    if isinstance(outcome, Done | Cancelled):
        return "done" if isinstance(outcome, Done) else "cancelled"
    return type(outcome).__name__.lower()
