"""Every claim is listed with its command, and `make claims` runs its quick form and fails where one fails."""

import subprocess
import sys
from pathlib import Path

from experiments import claims

EXPERIMENTS = Path(__file__).parents[2] / "experiments"

SCRIPTS = {
    path.stem: (path.parent.name, text)
    for path in sorted(EXPERIMENTS.glob("*/*.py"))
    if '__name__ == "__main__"' in (text := path.read_text(encoding="utf-8"))
}


def test_every_claim_stands_in_the_readme_with_its_command():
    readme = (EXPERIMENTS / "README.md").read_text(encoding="utf-8")
    for name, (folder, text) in SCRIPTS.items():
        assert f"`python -m experiments.{folder}.{name}" in readme
        assert "Claim" in text.split('"""')[1]


def test_every_quick_form_is_run():
    assert claims.quick_forms() == [name for name, (_, text) in SCRIPTS.items() if "--quick" in text]
    assert len(claims.quick_forms()) > 20


def test_a_claim_that_fails_is_shown_and_counted_and_the_others_go_on(tmp_path, monkeypatch, capsys):
    bodies = {
        "broken": "print('what it did'); assert sys.argv[1:] == [], 'what is wrong'",
        "exits": "print('a line'); sys.exit('a reason')",
        "good": "assert sys.argv[1:] == ['--quick'] and __name__ == '__main__'; print('all is well'); sys.exit()",
        "silent": "pass",
    }
    (tmp_path / "room").mkdir()
    for name, body in bodies.items():
        (tmp_path / "room" / f"{name}.py").write_text(f"import sys  # {name}.py [--quick]\n{body}\n")
    (tmp_path / "room" / "shared_by_them.py").write_text("# `--quick` of others\n1 / 0\n")
    monkeypatch.setattr(claims, "FOLDER", tmp_path)
    assert claims.main([]) == 3
    lines = capsys.readouterr().out.splitlines()
    verdicts = {line.split()[0]: line.split()[1] for line in lines if line.endswith("GiB")}
    assert verdicts == {"broken": "FAILED", "exits": "FAILED", "good": "passed", "silent": "FAILED"}
    assert lines[-1] == "1 passed, 3 failed"
    shown = "\n".join(lines)
    assert all(text in shown for text in ("what it did", "what is wrong", "a reason", "it printed nothing"))
    assert "all is well" not in shown


def test_the_runner_exits_with_one_where_a_claim_fails():
    command = [sys.executable, "-m", "experiments.claims", "no_such_claim"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=EXPERIMENTS.parent)
    assert done.returncode == 1
    assert done.stdout.endswith("0 passed, 1 failed\n")
