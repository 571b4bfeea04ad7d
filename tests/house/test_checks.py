"""The tools that read the code without running it are content."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.background import CHECKS, result_of


@pytest.mark.parametrize("check", CHECKS)
def test_the_check_finds_nothing(check: str) -> None:
    code, output = result_of(check)
    assert code == 0, f"{' '.join(CHECKS[check][1:])}\n{output}"


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
