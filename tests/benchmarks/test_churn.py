"""A minute of churn: clients that come, go and come back leave a station as it was."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

CHURN = Path(__file__).parents[2] / "benchmarks" / "churn.py"

SECONDS, CLIENTS, SPEED = 60, 60, 6
"""A minute of station time in ten seconds."""


@pytest.mark.skipif(sys.platform != "linux", reason="what a process waits for, Linux tells")
def test_a_minute_of_clients_that_come_and_go() -> None:
    finished = subprocess.run(
        [sys.executable, str(CHURN), str(SECONDS), str(CLIENTS), str(SPEED)],
        capture_output=True,
        text=True,
        check=False,
        timeout=110,
    )
    printed = finished.stdout
    assert finished.returncode == 0, printed + finished.stderr
    came = re.search(r"^(\d+) clients came in 60 s, (\d+) of them again", printed, re.MULTILINE)
    assert came is not None, printed
    assert int(came[1]) >= CLIENTS
    assert int(came[2]) > 0
    assert re.search(r"^steady client: \d{3,} samples .* 0 missed$", printed, re.MULTILINE)
