"""Every experiment's quick form runs, and its own assertions hold."""

import subprocess
import sys
from pathlib import Path

import pytest

EXPERIMENTS = Path(__file__).parents[1] / "experiments"


@pytest.mark.parametrize("name", ["scatter", "benches", "likelihood", "accuracy", "benchmark", "wavelets"])
def test_quick_form_holds_its_claim(name, tmp_path):
    command = [sys.executable, str(EXPERIMENTS / f"{name}.py"), "--quick"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=600, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    assert done.stdout
