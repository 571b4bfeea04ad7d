"""Masters by others take the drives of `achse drive serve` for real: find, map, enable, move."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.drive.identity import PRODUCT, VENDOR
from achse.drive.objects import DICTIONARY, OBJECTS

SAFEOP, OP, SAFEOP_ERROR = 0x04, 0x08, 0x14
WATCHDOG = 0x1B
FAULT = 0x08
LONGEST_NAME = 40
"""SOEM keeps no more of a name."""
CSP_STEP = 400
CYCLES = 2000

Judge = Callable[[Path], int]
Witness = Callable[[str], None]


def _check_slaves(report: Any, count: int) -> None:
    assert report["count"] == count
    assert report["identity"] == [[VENDOR, PRODUCT]] * count
    assert report["1018h"] == [
        [4, VENDOR, PRODUCT, 0x0001_0000, serial] for serial in range(1, count + 1)
    ]


@pytest.mark.parametrize(("count", "code"), [(1, "plain"), (8, "machine"), (32, "machine")])
def test_pysoem_moves_drives(
    bus: Any, judge: Judge, witness: Witness, count: int, code: str, many: Callable[[int], int]
) -> None:
    witness("pysoem")
    if code == "machine":
        pytest.importorskip("llvmlite")
    ready = bus.drives("--count", count, "--code", code)
    assert ready.startswith(f"achse drive ready interface=cable1 drives={count} type=ac")
    bus.record()
    cycles = many(CYCLES)
    report = bus.master("pysoem_drives.py", "move", cycles)
    bus.end_record()
    _check_slaves(report, count)
    assert report["map size"] == (15 + 23) * count
    assert report["dc"]
    assert report["0981h"] == [3] * count
    assert report["1C32h"] == [[2, 4_000_000]] * count
    assert (report["safeop"], report["op"]) == (SAFEOP, OP)
    assert report["ready"] == [0x21] * count
    assert report["switched on"] == [0x23] * count
    assert report["enabled"] == [0x27] * count
    assert report["mode"] == [8] * count
    assert report["expected"] == 3 * count
    assert report["counters"] == [3 * count]  # in each cycle
    assert report["way"] == 250 * CSP_STEP
    assert report["worst"] < 20 * CSP_STEP  # the position follows some cycles behind
    assert all(abs(rest) < 20 for rest in report["rest"])
    assert report["silent"] == [[SAFEOP_ERROR, WATCHDOG]] * count
    assert report["fault"] == [FAULT] * count
    assert report["emergencies"] == report["603Fh"]
    assert all(code >> 8 == 0xFF for code in report["603Fh"])
    assert (report["acknowledged"], report["recovered"]) == (SAFEOP, OP)
    assert report["reset"] == [0x40] * count
    assert report["again"] == [0x27] * count
    assert judge(bus.capture) > 2 * cycles


def test_pysoem_adds_an_object_to_the_mapping(bus: Any, judge: Judge, witness: Witness) -> None:
    witness("pysoem")
    bus.drives("--count", 2, "--code", "plain")
    bus.record()
    report = bus.master("pysoem_drives.py", "remap")
    bus.end_record()
    _check_slaves(report, 2)
    assert report["in SafeOp"] == "0x6010002"
    assert report["sizes"] == [[19, 23], [15, 23]]
    assert (report["safeop"], report["op"]) == (SAFEOP, OP)
    assert report["607Fh"] == 4711
    assert judge(bus.capture) > 200


def test_each_wrong_step_of_the_mapping_procedure_has_its_code(
    bus: Any, judge: Judge, witness: Witness
) -> None:
    witness("pysoem")
    bus.drives("--code", "plain")
    bus.record()
    report = bus.master("pysoem_objects.py", "steps")
    bus.end_record()
    assert report["aborts"] == {
        "count while assigned": "0x6010000",
        "entry while assigned": "0x6010000",
        "PDO while assigned": "0x6010000",
        "count of nine while assigned": "0x6090030",
        "entry while counted": "0x6010000",
        "not in the dictionary": "0x6020000",
        "not mappable": "0x6020000",
        "read-only object received": "0x6020000",
        "wrong length": "0x6020000",
        "ninth entry": "0x6020000",
        "nine objects": "0x6040042",
        "object twice": "0x6010000",
        "no such PDO": "0x6090030",
        "a PDO of the other direction": "0x6090030",
        "two PDOs": "0x6090030",
        "count not a byte": "0x6010000",
    }
    assert report["mapped"] == ["02", "10004060", "20007a60"]
    assert judge(bus.capture) > 100


def test_pysoem_lists_the_whole_dictionary_and_reads_it_both_ways(
    bus: Any, judge: Judge, witness: Witness
) -> None:
    witness("pysoem")
    bus.drives("--code", "plain")
    bus.record()
    report = bus.master("pysoem_objects.py", "dictionary")
    bus.end_record()
    listed = report["objects"]
    assert [each[:4] for each in listed] == [
        [each.index, each.name[:LONGEST_NAME], each.code, each.data_type] for each in OBJECTS
    ]
    for index, _, _, _, entries in listed:
        for subindex, (name, data_type, bits, access) in enumerate(entries):
            row = DICTIONARY.get(index << 8 | subindex)
            if row is None:
                assert bits == 0, (hex(index), subindex)  # a gap: 1C32h has no subindex 3
            else:
                assert (name, data_type, bits, access) == (
                    row.entry_name[:LONGEST_NAME],
                    row.type,
                    row.type.bits,
                    row.access_word,
                )
    assert report["records"] == sum(each.code != 7 for each in OBJECTS)
    assert report["differs"] == []
    assert judge(bus.capture) > 1000


def test_pysoem_homes_a_drive_and_moves_it_in_the_profile_modes(
    bus: Any, judge: Judge, witness: Witness
) -> None:
    witness("pysoem")
    bus.drives("--code", "plain")
    bus.record()
    report = bus.master("pysoem_modes.py", "modes")
    bus.end_record()
    assert (report["safeop"], report["op"], report["enabled"]) == (SAFEOP, OP, True)
    assert report["hm"]["mode"]
    assert report["hm"]["done"]
    assert abs(report["hm"]["position"] - 1000) < 100  # 607Ch is where home is
    assert report["pp"]["mode"]
    assert report["pp"]["absolute"][:3] == [True, True, True]
    assert abs(report["pp"]["absolute"][3] - 100_000) < 20
    assert report["pp"]["relative"][:3] == [True, True, True]
    assert abs(report["pp"]["relative"][3] - 70_000) < 20
    assert report["pv"]["mode"]
    assert report["pv"]["reached"]
    assert report["pv"]["velocity"] == pytest.approx(150_000, rel=0.02)
    assert report["pv"]["stopped"]
    assert report["tq"]["mode"]
    assert report["tq"]["6077h"] == pytest.approx(60, abs=3)
    assert report["tq"]["faster"] > 10_000
    assert abs(report["tq"]["zero"]) <= 3
    assert (report["tq"]["6041h"], report["tq"]["603Fh"]) == (0x27, 0)
    assert judge(bus.capture) > 1000


def test_kickcat_brings_a_drive_to_op(bus: Any, judge: Judge, witness: Witness) -> None:
    witness("kickcat")
    bus.drives("--code", "plain")
    bus.record()
    report = bus.master("kickcat_drive.py")
    bus.end_record()
    assert report == {
        "1018h": [VENDOR, PRODUCT],
        "inputs": 23,
        "op": "State.OPERATIONAL",
        "states": [0x21, 0x23, 0x27],
    }
    assert judge(bus.capture) > 400


def test_pysoem_writes_an_alias_into_the_eeprom(bus: Any, judge: Judge, witness: Witness) -> None:
    witness("pysoem")
    bus.drives("--code", "plain")
    bus.record()
    report = bus.master("pysoem_eeprom.py", "alias")
    bus.end_record()
    assert (report["valid"], report["vendor"], report["written"]) == (True, VENDOR, True)
    assert (report["before"], report["count"], report["after"]) == (0, 1, 0x1234)
    assert judge(bus.capture) > 100


def test_faults_come_from_the_command_line_while_a_master_exchanges(
    bus: Any, judge: Judge, witness: Witness
) -> None:
    witness("pysoem")
    bus.drives("--count", 2, "--code", "plain")
    bus.record()
    with bus.beside("pysoem_faults.py", "watch", ready="in Op") as report:
        bus.run(bus.achse, "fault", "add", "--served", "alarm", "code=AL.720", "drive=1")
        bus.run(bus.achse, "fault", "add", "--served", "link_break", "drive=2")
        watched = bus.run(bus.achse, "bus", "state", "--served", "--json")
        bus.run(bus.achse, "fault", "clear", "--served")
    bus.end_record()
    assert [each["alarm"] for each in json.loads(watched)] == ["AL.720", ""]
    assert report["op"] == OP
    assert report["counters"] == [6, 3]  # the second drive was out of reach for a while
    assert report["alarms"] == [0, 0xFF19]
    assert report["state"] == [OP, OP]
    assert judge(bus.capture) > 300


def test_a_drive_on_the_wire_passes_the_conformance_check(
    bus: Any, judge: Judge, witness: Witness
) -> None:
    witness("pysoem")
    bus.drives("--code", "plain")
    bus.record()
    report = bus.master("pysoem_check.py", "check")
    bus.end_record()
    assert report == {"count": 1, "faults": []}
    assert judge(bus.capture) > 2000
