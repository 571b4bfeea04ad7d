"""The tools that read the code without running it are content."""

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


@pytest.mark.timeout(600)
@pytest.mark.parametrize("command", CHECKS.values(), ids=CHECKS)
def test_the_check_finds_nothing(command: list[str], root: Path) -> None:
    run = subprocess.run(
        command, cwd=root, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert run.returncode == 0, f"{' '.join(command[1:])}\n{run.stdout}"
