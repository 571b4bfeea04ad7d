"""The modules of the pages, by `node --test`: connection, view, numbers, forms, what is loaded."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SUITES = sorted(HERE.glob("*.test.mjs"))


@pytest.mark.parametrize("suite", SUITES, ids=lambda path: path.name.removesuffix(".test.mjs"))
def test_the_modules_do_what_their_tests_say(suite: Path, witness: Callable[[str], None]) -> None:
    witness("node")
    run = subprocess.run(
        ["node", "--test-reporter=tap", str(suite)], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stdout + run.stderr
    passed = re.findall(r"^# pass (\d+)$", run.stdout, re.MULTILINE)
    assert sum(map(int, passed)) > 0, run.stdout
