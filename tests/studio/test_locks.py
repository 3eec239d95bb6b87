"""Locks: one holder at a time, and none that outlives its process."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from henkei.errors import InvalidInput
from henkei.studio.locks import Lock, alone, held

HOLDS = "from pathlib import Path; from henkei.studio.locks import Lock; import sys, os, time;"
HOLDS += "lock = Lock(Path(sys.argv[1])); assert lock.take();"


def test_one_holder_at_a_time(tmp_path):
    first, second = Lock(tmp_path / "lock"), Lock(tmp_path / "lock")
    assert not held(first.path)
    assert first.take()
    assert held(first.path)
    assert not second.take()
    first.release()
    assert not held(first.path)
    assert second.take()
    second.release()
    second.release()


def test_a_block_keeps_others_out_also_when_it_fails(tmp_path):
    def fail():
        with alone(tmp_path / "lock"):
            assert held(tmp_path / "lock")
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert not held(tmp_path / "lock")


def test_a_place_that_cannot_be_locked_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="cannot lock"):
        Lock(tmp_path / "nowhere" / "lock").take()


def test_a_killed_process_lets_go(tmp_path):
    path = tmp_path / "lock"
    program = f"{HOLDS} print('held', flush=True); time.sleep(600)"
    command = [sys.executable, "-c", program, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        assert held(path)
        process.kill()
        process.wait(60)
    assert not held(path)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_child_that_outlives_its_parent_holds_nothing(tmp_path):
    path = tmp_path / "lock"
    program = f"""{HOLDS}
reading, writing = os.pipe()
if os.fork():
    os.read(reading, 1)
    print("free" if Lock(lock.path).take() else "held", flush=True)
    os.kill(os.getpid(), 9)
os.write(writing, b"x")
sys.stdin.read()
print("ended", flush=True)
"""
    command = [sys.executable, "-c", program, str(path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        assert process.stdout.readline() == "held\n"
        assert process.wait(60) == -9
        assert not held(path)
        process.stdin.close()
        assert process.stdout.readline() == "ended\n"
