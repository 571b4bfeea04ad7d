"""The tools that read the code without running it are content."""

import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

LINT_IMPORTS = str(Path(sysconfig.get_path("scripts")) / "lint-imports")

CHECKS = {
    "lint": [sys.executable, "-m", "ruff", "check", "--output-format=concise"],
    "format": [sys.executable, "-m", "ruff", "format", "--check"],
    "types": [sys.executable, "-m", "mypy", "--no-error-summary"],
    "layers": [LINT_IMPORTS, "--no-logo"],
}


@pytest.mark.parametrize("command", CHECKS.values(), ids=CHECKS)
def test_the_check_finds_nothing(command: list[str], root: Path) -> None:
    run = subprocess.run(
        command, cwd=root, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert run.returncode == 0, f"{' '.join(command[1:])}\n{run.stdout}"


def test_the_same_checks_run_before_each_commit(root: Path) -> None:
    configured = (root / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    hooks = re.findall(r"- id: (\w+)\n(?: +name:[^\n]*\n) +entry: ([^\n]+)", configured)
    entries = dict(hooks)
    assert set(entries) == {*CHECKS, "house"}
    for name, command in CHECKS.items():
        tool = Path(command[0]).name if len(command) < 3 or command[1] != "-m" else command[2]
        assert tool in entries[name].split(), (name, entries[name])
    manifest = [sys.executable, "-m", "pre_commit", "validate-config", ".pre-commit-config.yaml"]
    run = subprocess.run(manifest, cwd=root, text=True, capture_output=True)
    assert run.returncode == 0, run.stdout + run.stderr
