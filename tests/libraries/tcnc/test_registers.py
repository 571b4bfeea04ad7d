"""FB_RegisterComKL25xx, over a terminal that answers in the I/O structures (004 §3.3).

One of the tests' own stands on the way to the NC: it sees what is written to the output structures
and shows its status and data in the input ones. The last test is with the station's.
"""

import struct
from dataclasses import dataclass, field
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Flags, Frame
from achse.codes.nc.choices import DriveType

TERMINAL = 2541
CODE = 0x1235


@dataclass
class Terminal:
    """Register access by control and status byte, as terminals of this series have it."""

    in_drive: bool
    hand_on: Any
    registers: dict[int, int] = field(default_factory=lambda: {8: TERMINAL})
    outputs: dict[int, bytearray] = field(default_factory=dict)
    silent: bool = False
    seen: list[tuple[int, int]] = field(default_factory=list)
    """Groups and offsets that were asked for."""
    shown: tuple[int, int] = (0, 0)
    """Status byte and input data."""

    def deliver(self, frame: Frame) -> bool:
        if AmsAddress(frame.source).port == 851 and not frame.flags & Flags.RESPONSE:
            group, offset = struct.unpack_from("<II", frame.data)
            self.seen.append((group, offset))
            if group in (0x5301, 0x7301):
                return self.answer(frame, group, offset)
        return bool(self.hand_on(frame))

    def answer(self, frame: Frame, group: int, offset: int) -> bool:
        if frame.command == Command.WRITE:
            assert offset == 0x01
            place, mask, value = struct.unpack("<III", frame.data[12:])
            image = self.outputs.setdefault(group, bytearray(44))
            (before,) = struct.unpack_from("<I", image, place)
            struct.pack_into("<I", image, place, before & ~mask | value & mask)
            self.exchange()
            data = bytes(4)
        else:
            assert offset == 0x80
            status, word = self.shown
            control_group = 0x7301 if self.in_drive else 0x5301
            image = bytearray(40)
            if group == control_group:
                image[8] = 0 if self.silent else status
            if group == 0x5301:
                struct.pack_into("<H", image, 0, word)
            data = struct.pack("<II", 0, 40) + image
        response = Frame(
            frame.source, frame.target, frame.command,
            flags=frame.flags | Flags.RESPONSE, invoke_id=frame.invoke_id, data=data,
        )  # fmt: skip
        return bool(self.hand_on(response))

    def exchange(self) -> None:
        """What the control byte asks for, for as long as it does."""
        control = self.outputs.get(0x7301 if self.in_drive else 0x5301, bytes(9))[8]
        if not control & 0x80:
            self.shown = (0, 0)
            return
        number = control & 0x3F
        out = self.outputs.get(0x7301, bytearray(44))
        (value,) = struct.unpack_from("<H", out, 4 if self.in_drive else 0)
        if control & 0x40 and (number < 32 or self.registers.get(31) == CODE):
            self.registers[number] = value
        self.shown = (0x80 | number, self.registers.get(number, 0))


def _placed(bench: Any, kind: DriveType) -> tuple[Any, Terminal]:
    on = bench(
        variables="r : FB_RegisterComKL25xx;",
        calls="r(AxisRefIn := fromNc1, AxisRefOut := toNc1);",
        axis={"drive_type": kind.value},
    )
    on.main["toNc1"]["nDeCtrlDWord"] = 0
    terminal = Terminal(kind == DriveType.KL2531_KL2541, on.station.router.deliver)
    on.station.router.deliver = terminal.deliver
    on.call(2)
    return on, terminal


KINDS = (DriveType.KL2531_KL2541, DriveType.MDP_252)


def _wait(on: Any, most: int = 60) -> Any:
    block = on.main["r"]
    on.call()
    assert block["Busy"] or block["Error"]
    for _ in range(most):
        if not block["Busy"]:
            break
        on.call()
    return block


@pytest.mark.parametrize("kind", KINDS)
def test_a_register_is_read(bench: Any, kind: DriveType) -> None:
    on, terminal = _placed(bench, kind)
    terminal.registers[35] = 4711
    on.set("r", Read=True, RegisterNumber=35, RegisterValue=9)
    block = _wait(on)
    assert (block["Done"], block["Error"], block["ErrorID"]) == (True, False, 0)
    assert block["TerminalType"] == TERMINAL
    assert (block["CurrentRegisterNumber"], block["CurrentRegisterValue"]) == (35, 4711)
    assert terminal.registers == {8: TERMINAL, 35: 4711}
    services = [each for each in terminal.seen if each[0] >> 12 == 4]
    assert services == [(0x4001, 0x31), (0x4201, 0x60), (0x4201, 0x61)]  # off, and on again
    assert terminal.seen[-1] == (0x4201, 0x61)
    assert not on.axis().drive_output_disabled
    assert terminal.shown == (0, 0)
    assert not any(terminal.outputs[0x7301][:8])  # no velocity is left behind


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_user_register_is_unlocked_written_locked_and_read_back(
    bench: Any, kind: DriveType, both: bool
) -> None:
    on, terminal = _placed(bench, kind)
    on.set("r", Write=True, Read=both, RegisterNumber=40, RegisterValue=1234)
    block = _wait(on)
    assert (block["Done"], block["CurrentRegisterValue"]) == (True, 1234)
    assert terminal.registers == {8: TERMINAL, 31: 0, 40: 1234}
    on.set("r", Write=False, Read=False)
    on.call(2)
    assert block["Done"]  # until the next edge


def test_the_code_register_itself(bench: Any) -> None:
    on, terminal = _placed(bench, KINDS[0])
    on.set("r", Write=True, RegisterNumber=31, RegisterValue=CODE)
    assert _wait(on)["Done"]
    assert terminal.registers[31] == CODE


@pytest.mark.parametrize(("number", "code"), [(0, 0x4B41), (30, 0x4B41), (64, 0x4B06)])
def test_registers_that_are_not_written(bench: Any, number: int, code: int) -> None:
    on, terminal = _placed(bench, KINDS[0])
    before = list(terminal.seen)
    on.set("r", Write=True, RegisterNumber=number)
    on.call()
    block = on.main["r"]
    assert (block["Error"], block["ErrorID"], block["Busy"]) == (True, code, False)
    assert terminal.seen == before


def test_a_terminal_that_does_not_answer(bench: Any) -> None:
    on, terminal = _placed(bench, KINDS[0])
    terminal.silent = True
    on.set("r", Read=True, RegisterNumber=8)
    block = _wait(on, 600)
    assert (block["Error"], block["ErrorID"]) == (True, 0x4B07)
    assert terminal.seen[-1] == (0x4201, 0x61)
    assert not on.axis().drive_output_disabled


@pytest.mark.parametrize(
    ("kind", "type"), [(DriveType.KL2531_KL2541, 2541), (DriveType.MDP_252, 2502)]
)
def test_the_terminal_of_the_station(bench: Any, kind: DriveType, type: int) -> None:
    on, terminal = _placed(bench, kind)
    on.station.router.deliver = terminal.hand_on
    on.set("r", Write=True, RegisterNumber=40, RegisterValue=1234)
    block = _wait(on)
    assert (block["Done"], block["ErrorID"]) == (True, 0)
    assert (block["TerminalType"], block["CurrentRegisterValue"]) == (type, 1234)
    on.set("r", Write=False, Read=True, RegisterNumber=31)
    block = _wait(on)
    assert (block["Done"], block["CurrentRegisterValue"]) == (True, 0)  # locked again
