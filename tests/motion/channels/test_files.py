"""Tools, zero shifts and snapshots survive in their files."""

import json

from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.offsets import ZeroShift
from achse.motion.channels.files import ChannelFiles


def test_there_and_back() -> None:
    data = MachineData()
    files = ChannelFiles(3, data, None)
    assert files.load_tools() == files.load_shifts() == 0x4110
    data.tools[4][2] = 55.0
    data.shifts[ZeroShift.G55_FINE, 1] = -7.5
    data.registers[12] = 3.25
    assert files.save_tools() == files.save_shifts() == files.save_snapshot("all", 7) == 0
    data.tools.clear()
    data.shifts.clear()
    data.registers[12] = 0.0
    assert files.load_tools() == files.load_shifts() == 0
    assert data.tools[4][2] == 55.0
    assert data.shifts[ZeroShift.G55_FINE, 1] == -7.5
    assert data.registers[12] == 0.0
    assert files.load_snapshot("all", 1) == 0
    assert data.registers[12] == 3.25


def test_what_a_snapshot_cannot_be() -> None:
    files = ChannelFiles(1, MachineData(), None)
    for name in ("", "../x", "a/b", "c:x"):
        assert files.save_snapshot(name, 1) == files.load_snapshot(name, 1) == 0x4108
    assert files.save_snapshot("x", 8) == 0x4108
    assert files.load_snapshot("x", 1) == 0x4110
    for text in ("no json", "[1]", '{"registers": [1]}', '{"tools": 5}', '{"shifts": "?"}'):
        files.store.save("x", text)
        assert files.load_snapshot("x", 7) == 0x4170
    files.store.save("1.wz", "D999")
    assert files.load_tools() == 0x4170


def test_a_snapshot_that_is_wrong_anywhere_changes_nothing() -> None:
    data = MachineData()
    files = ChannelFiles(1, data, None)
    data.shifts[ZeroShift.G55_FINE, 1] = 2.0
    data.registers[12] = 3.25
    files.save_snapshot("good", 7)
    good = json.loads(files.store.read("good") or "")
    data.shifts[ZeroShift.G55_FINE, 1] = 5.0
    data.registers[12] = 4.0
    for wrong in (
        {"tools": "D999"},
        {"registers": [float("nan"), *good["registers"][1:]]},
        {"registers": [*good["registers"][:-1], float("inf")]},
    ):
        files.store.save("wrong", json.dumps(good | wrong))
        assert files.load_snapshot("wrong", 7) == 0x4170
        assert data.shifts[ZeroShift.G55_FINE, 1] == 5.0
        assert data.registers[12] == 4.0


def test_the_default_program() -> None:
    files = ChannelFiles(1, MachineData(), None)
    assert files.default_program() is None
    files.store.save("DefaultGCode1.def", "G60\n")
    result = files.default_program()
    assert result is not None
    assert result.lines[0] == "G60"
