"""A minute of churn: clients that come, go and come back leave a station as it was."""

import re
import sys
from collections.abc import Callable

import pytest

SECONDS, CLIENTS, SPEED = 60, 30, 6
"""A minute of station time in ten seconds."""


@pytest.mark.skipif(sys.platform != "linux", reason="what a process waits for, Linux tells")
def test_a_minute_of_clients_that_come_and_go(run_benchmark: Callable[..., str]) -> None:
    printed = run_benchmark("churn.py", str(SECONDS), str(CLIENTS), str(SPEED))
    came = re.search(r"^(\d+) clients came in 60 s, (\d+) of them again", printed, re.MULTILINE)
    assert came is not None, printed
    assert int(came[1]) >= CLIENTS
    assert int(came[2]) > 0
    assert re.search(r"^steady client: \d{3,} samples .* 0 missed$", printed, re.MULTILINE)
