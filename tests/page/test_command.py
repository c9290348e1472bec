"""The command `newtonjax app`: where it listens, how it ends, and what it says without its extra."""

import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from serving_page import PATIENCE
from shell import refusal

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-c", "from fitting.shell.entry import main; main()", "app"]


def test_without_the_extra_it_says_how_to_get_it(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "nicegui", None)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    monkeypatch.delitem(sys.modules, "fitting.shell.page.server", raising=False)
    assert "pip install 'newtonjax[app]'" in refusal(capsys, "app")


def test_a_port_that_is_taken_is_said(capsys):
    pytest.importorskip("nicegui", reason="the extra app is not installed")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        assert "name another --port" in refusal(capsys, "app", "--port", str(taken.getsockname()[1]))


def listening(process: int) -> set[str]:
    """Addresses at which a process listens, as the system writes them."""
    inodes = set()
    for link in Path(f"/proc/{process}/fd").iterdir():
        with suppress(FileNotFoundError):  # closed since the folder was read
            match = re.fullmatch(r"socket:\[(\d+)\]", os.readlink(link))
            inodes |= {match[1]} if match else set()
    rows = [line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()[1:]]
    return {row[1].split(":")[0] for row in rows if row[3] == "0A" and row[9] in inodes}


def test_it_listens_at_this_machine_alone_and_leaves_nothing(tmp_path):
    pytest.importorskip("nicegui", reason="the extra app is not installed")
    environment = os.environ | {"TMPDIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    with subprocess.Popen([*COMMAND, "--port", "0"], stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            line = process.stdout.readline()
            assert re.fullmatch(r"the page is at http://127\.0\.0\.1:\d+/ \(Ctrl-C ends it\)\n", line)
            address = int(line.split(":")[2].split("/")[0])
            with socket.create_connection(("127.0.0.1", address)):
                pass
            if Path("/proc/net/tcp").exists():
                assert listening(process.pid) == {"0100007F"}
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 0
        finally:
            process.kill()
    assert list(tmp_path.iterdir()) == []
