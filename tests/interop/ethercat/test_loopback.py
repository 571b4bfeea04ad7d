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
    report = bus.master("pysoem_loopback.py")
    bus.end_record()
    assert report["count"] == count
    assert report["names"] == ["loopback"] * count
    assert report["serial"] == list(range(count))
    assert report["name object"] == "loopback"
    assert report["long"]
    assert report["short"] == "short"
    assert report["complete"] == "01000016"  # subindex 0 in 16 bits, then 1600h
    assert report["aborts"] == {
        "no object": "0x6020000",
        "no subindex": "0x6090011",
        "read-only": "0x6010002",
    }
    assert [0x1018, "Identity", 5] in report["dictionary"]
    assert len(report["dictionary"]) == 11
    assert report["map size"] == 8 * count
    assert report["dc"]
    assert (report["safeop"], report["op"]) == (4, 8)
    assert report["expected"] == 3 * count
    assert report["counters"] == [3 * count]
    assert report["silent"] == [[SAFEOP_ERROR, WATCHDOG]] * count
    assert (report["acknowledged"], report["recovered"], report["init"]) == (4, 8, 1)
    assert judge(bus.capture) > 2000


def test_kickcat(bus: Any, judge: Callable[[Path], int], witness: Callable[[str], None]) -> None:
    witness("kickcat")
    bus.slaves("loopbacks.py", 2)
    bus.record()
    report = bus.master("kickcat_loopback.py")
    bus.end_record()
    assert report["count"] == 2
    assert report["serial"] == [0, 1]
    assert report["op"] == ["State.OPERATIONAL"] * 2
    assert report["echoes"] == 100
    assert judge(bus.capture) > 400
