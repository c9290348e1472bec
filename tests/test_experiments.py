"""Every experiment's quick form runs, and its own assertions hold."""

import subprocess
import sys
from pathlib import Path

import pytest

EXPERIMENTS = Path(__file__).parents[1] / "experiments"

SCRIPTS = {
    path.stem: text
    for path in sorted(EXPERIMENTS.glob("*.py"))
    if '__name__ == "__main__"' in (text := path.read_text(encoding="utf-8"))
}
QUICK = [name for name, text in SCRIPTS.items() if "--quick" in text]


@pytest.mark.parametrize("name", QUICK)
def test_quick_form_holds_its_claim(name, tmp_path):
    command = [sys.executable, str(EXPERIMENTS / f"{name}.py"), "--quick"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=600, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    assert done.stdout


def test_every_claim_stands_in_the_readme_with_its_command():
    readme = (EXPERIMENTS / "README.md").read_text(encoding="utf-8")
    assert len(QUICK) > 10
    for name, text in SCRIPTS.items():
        assert f"`python experiments/{name}.py" in readme
        assert "Claim" in text.split('"""')[1]
