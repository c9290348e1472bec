"""One code on several devices and processes: image, loss and gradient are those of one."""

import json
import socket
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "sharded.py"


def start(*arguments):
    command = [sys.executable, str(SCRIPT), *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def answer(process):
    out, error = process.communicate(timeout=900)
    assert process.returncode == 0, error[-3000:]
    return json.loads(next(line for line in out.splitlines()[::-1] if line.startswith("{")))


@pytest.fixture(scope="module")
def alone():
    return answer(start(1))


def test_two_devices_agree_with_one(alone):
    assert answer(start(2)) == pytest.approx(alone, rel=1e-12)


def test_two_processes_on_loopback_agree_with_one(alone):
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    other, first = start(1, 2, 1, port), start(1, 2, 0, port)
    found = answer(first)
    _, error = other.communicate(timeout=300)
    assert other.returncode == 0, error[-3000:]
    assert found == pytest.approx(alone, rel=1e-12)
