"""Masters by others bring slaves to Op through a real network interface."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

WATCHDOG = 0x1B
SAFEOP_ERROR = 0x14


@pytest.mark.parametrize("count", [1, 2, 32])
def test_pysoem(
    bus: Any, judge: Callable[[Path], int], witness: Callable[[str], None], count: int
) -> None:
    witness("pysoem")
    bus.slaves("loopbacks.py", count)
    bus.record()
    found = bus.master("pysoem_loopback.py")
    bus.end_record()
    assert found["count"] == count
    assert found["names"] == ["loopback"] * count
    assert found["serial"] == list(range(count))
    assert found["name object"] == "loopback"
    assert found["long"]
    assert found["short"] == "short"
    assert found["complete"] == "01000016"  # subindex 0 in 16 bits, then 1600h
    assert found["aborts"] == {
        "no object": "0x6020000",
        "no subindex": "0x6090011",
        "read-only": "0x6010002",
    }
    assert [0x1018, "Identity", 5] in found["dictionary"]
    assert len(found["dictionary"]) == 11
    assert found["map size"] == 8 * count
    assert found["dc"]
    assert (found["safeop"], found["op"]) == (4, 8)
    assert found["expected"] == 3 * count
    assert found["counters"] == [3 * count]
    assert found["silent"] == [[SAFEOP_ERROR, WATCHDOG]] * count
    assert (found["acknowledged"], found["recovered"], found["init"]) == (4, 8, 1)
    assert judge(bus.capture) > 2000


def test_kickcat(bus: Any, judge: Callable[[Path], int], witness: Callable[[str], None]) -> None:
    witness("kickcat")
    bus.slaves("loopbacks.py", 2)
    bus.record()
    found = bus.master("kickcat_loopback.py")
    bus.end_record()
    assert found["count"] == 2
    assert found["serial"] == [0, 1]
    assert found["op"] == ["State.OPERATIONAL"] * 2
    assert found["echoes"] == 100
    assert judge(bus.capture) > 400
