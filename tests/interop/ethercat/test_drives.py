"""pysoem takes the drives of `achse drive serve` for real: finds, maps, enables and moves them."""

from collections.abc import Callable
from typing import Any

import pytest

SAFEOP, OP, SAFEOP_ERROR = 0x04, 0x08, 0x14
WATCHDOG = 0x1B
VENDOR, PRODUCT = 0xAAAA, 5
FAULT = 0x08


def _found(found: Any, count: int) -> None:
    assert found["count"] == count
    assert found["identity"] == [[VENDOR, PRODUCT]] * count
    assert found["1018h"] == [
        [4, VENDOR, PRODUCT, 0x0001_0000, serial] for serial in range(1, count + 1)
    ]


@pytest.mark.parametrize("count", [1, 8])
def test_pysoem_moves_drives(bus: Any, witness: Callable[[str], None], count: int) -> None:
    witness("pysoem")
    ready = bus.drives("--count", count, "--interpreted")
    assert ready == f"achse drive ready interface=cable1 drives={count} type=ac\n"
    found = bus.master("pysoem_drives.py", "move")
    _found(found, count)
    assert found["map size"] == (15 + 23) * count
    assert (found["safeop"], found["op"]) == (SAFEOP, OP)
    assert found["ready"] == [0x21] * count
    assert found["switched on"] == [0x23] * count
    assert found["enabled"] == [0x27] * count
    assert found["mode"] == [8] * count
    assert found["expected"] == 3 * count
    assert found["counters"] == [3 * count]
    assert found["worst"] < 20 * 400  # the position follows some cycles behind
    assert all(abs(rest) < 20 for rest in found["rest"])
    assert found["silent"] == [[SAFEOP_ERROR, WATCHDOG]] * count
    assert found["fault"] == [FAULT] * count
    assert found["emergencies"] == found["603Fh"]
    assert all(code >> 8 == 0xFF for code in found["603Fh"])
    assert (found["acknowledged"], found["recovered"]) == (SAFEOP, OP)
    assert found["reset"] == [0x40] * count
    assert found["again"] == [0x27] * count


def test_pysoem_adds_an_object_to_the_mapping(bus: Any, witness: Callable[[str], None]) -> None:
    witness("pysoem")
    bus.drives("--count", 2, "--interpreted")
    found = bus.master("pysoem_drives.py", "remap")
    _found(found, 2)
    assert found["aborts"] == {
        "assigned": "0x6010000",
        "counted": "0x6010000",
        "not in the dictionary": "0x6020000",
        "in SafeOp": "0x6010002",
    }
    assert found["sizes"] == [[19, 23], [15, 23]]
    assert (found["safeop"], found["op"]) == (SAFEOP, OP)
    assert found["607Fh"] == 4711
