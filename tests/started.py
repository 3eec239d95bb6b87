"""``henkei studio`` in a process of its own, as a person starts it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from henkei.studio.blobs import Blobs

PATIENCE = 30.0  # seconds until something that should happen counts as never


@dataclass
class RunningStudio:
    """A studio that was started by the command.

    address : of the page, with its token.
    folder : where its sessions are.
    """

    process: subprocess.Popen[str]
    address: str
    folder: Path

    @property
    def blobs(self) -> Blobs:
        """What it keeps."""
        return Blobs(self.folder / "blobs")

    @property
    def port(self) -> int:
        """Where it listens."""
        found = re.search(r":(\d+)/", self.address)
        assert found is not None
        return int(found[1])

    def kill(self) -> None:
        """End it without a warning, as a crash does."""
        self.process.kill()
        self.process.wait()

    def stop(self) -> None:
        """End it as Ctrl-C does."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.kill()
            raise


@contextmanager
def studio_running(
    folder: Path, *arguments: str | os.PathLike[str], port: int = 0
) -> Iterator[RunningStudio]:
    """``henkei studio`` with files or options, until the block ends."""
    main = "import sys; from henkei.cli import main; sys.exit(main())"
    options = ["--no-browser", "--port", str(port), "--folder", str(folder)]
    environment = {**os.environ, "XDG_STATE_HOME": str(folder / "state")}
    process = subprocess.Popen(
        [sys.executable, "-c", main, "studio", *map(str, arguments), *options],
        stdout=subprocess.PIPE,
        stderr=None,
        text=True,
        env=environment,
    )
    assert process.stdout is not None
    try:
        address = process.stdout.readline().strip()
        assert address.startswith("http"), f"the studio did not start: {address!r}"
        studio = RunningStudio(process, address, folder)
        yield studio
        studio.stop()
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def eventually(condition: Callable[[], Any], what: str = "") -> Any:
    """What a condition says, once that is neither None nor False."""
    end = time.monotonic() + PATIENCE
    while True:
        said = condition()
        if said is not None and said is not False:
            return said
        assert time.monotonic() < end, f"it never came: {what or condition}"
        time.sleep(0.02)
