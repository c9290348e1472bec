"""One code on several devices and processes: image, loss and gradient are those of one."""

import json
import socket
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "sharded.py"
DEVICES, PROCESSES = 2, 2


@pytest.fixture(scope="module")
def answers():
    """Of one device, of two of one process, and of two of each of two processes on loopback."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    first, other = (
        subprocess.Popen(
            [sys.executable, str(SCRIPT), *map(str, (DEVICES, PROCESSES, number, port))],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for number in range(PROCESSES)
    )
    out, error = first.communicate(timeout=900)
    _, error_of_other = other.communicate(timeout=300)
    assert (first.returncode, other.returncode) == (0, 0), error[-3000:] + error_of_other[-3000:]
    return json.loads(next(line for line in out.splitlines()[::-1] if line.startswith("{")))


@pytest.mark.parametrize("devices", ["one process", "all processes"])
def test_several_devices_agree_with_one(answers, devices):
    shared = answers[devices]
    assert shared == pytest.approx({name: answers["one device"][name] for name in shared}, rel=1e-12)
    assert {"Chebyshev", "Chebyshev loss", "Chebyshev gradient", "batch"} <= set(shared)
