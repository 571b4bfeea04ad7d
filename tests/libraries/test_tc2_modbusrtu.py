"""Tc2_ModbusRTU: each function of the masters, against a device at the end of the serial line."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from tests.libraries.modbus_memory import Memory
from tests.plc.code.conftest import Ran

KINDS = {"PcCOM": (2, 64), "KL6x22B": (2, 22), "KL6x5B": (1, 5)}
"""Bytes before the data, and bytes of data."""


def check_sum(frame: bytes) -> bytes:
    remainder = 0xFFFF
    for byte in frame:
        remainder ^= byte
        for _ in range(8):
            remainder = remainder >> 1 ^ (0xA001 if remainder & 1 else 0)
    return struct.pack("<H", remainder)


class Line:
    """The terminal of a master, and a device behind it that answers frames."""

    def __init__(
        self, ran: Ran, kind: str, answer: Callable[[bytes], bytes], block: str = "m"
    ) -> None:
        self.ran, self.answer = ran, answer
        self.head, self.most = KINDS[kind]
        self.block: Any = ran.plc.instance("MAIN")[block]
        self.received = b""
        self.to_send = b""

    def cycle(self, count: int = 1) -> None:
        status, control = ("SerStatus", "SerCtrl") if self.most == 64 else ("Status", "Ctrl")
        for _ in range(count):
            self.ran.cycle()
            ins, outs = self.block["InData"], self.block["OutData"]
            sent, state = int(outs[control]), int(ins[status])
            if (sent ^ state) & 1:
                length = sent >> 8 if self.head == 2 else sent >> 4 & 7
                self.received += bytes(outs["D"])[:length]
                state ^= 1
            if self._is_whole():
                self.to_send += self.answer(self.received)
                self.received = b""
            if self.to_send and not (sent ^ state) & 2:
                piece, self.to_send = self.to_send[: self.most], self.to_send[self.most :]
                ins["D"] = [*piece, *bytes(self.most - len(piece))]
                state = state & 0xF ^ 2 | len(piece) << (8 if self.head == 2 else 4)
            ins[status] = state

    def _is_whole(self) -> bool:
        return len(self.received) > 3 and check_sum(self.received[:-2]) == self.received[-2:]


def device(memory: Memory, unit: int = 7) -> Callable[[bytes], bytes]:
    def answer(frame: bytes) -> bytes:
        if frame[0] != unit:
            return b""
        answer = frame[:1] + memory.answer(frame[0], frame[1:-2])
        return answer + check_sum(answer)

    return answer


def _master(block: str, action: str, inputs: str) -> Ran:
    return Ran(
        f"PROGRAM MAIN VAR m : {block}; go : BOOL; data : ARRAY [0..19] OF WORD;"
        " aux : ARRAY [0..19] OF WORD := [20(16#AA)]; bits : ARRAY [0..9] OF BYTE; END_VAR"
        f" m(UnitID := 7, {inputs}, Execute := go, Timeout := T#1S); m.{action}(); END_PROGRAM"
    )


def _run(ran: Ran, line: Line) -> tuple[bool, int]:
    """Whether the request failed, and its error."""
    ran.plc.instance("MAIN")["go"] = True
    line.cycle()
    for _ in range(150):
        if not ran["m.BUSY"]:
            break
        line.cycle()
    assert ran.plc.failure == ""
    assert ran["m.BUSY"] is False
    return ran["m.Error"], int(ran["m.ErrorId"])


REGISTERS = "cbLength := SIZEOF(data), pMemoryAddr := ADR(data)"
BITS = "cbLength := SIZEOF(bits), pMemoryAddr := ADR(bits)"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("version", ["", "V2"])
def test_registers_are_read(kind: str, version: str) -> None:
    ran = _master(
        f"ModbusRtuMaster{version}_{kind}", "ReadRegs", f"Quantity := 12, MBAddr := 3, {REGISTERS}"
    )
    assert _run(ran, Line(ran, kind, device(Memory()))) == (False, 0)
    assert list(ran["data"])[:12] == [0x1103 + index for index in range(12)]
    assert ran["m.cbRead"] == 24


def test_functions_that_read_and_write() -> None:
    memory = Memory()
    for action, inputs in (
        ("ReadCoils", f"Quantity := 13, MBAddr := 3, {BITS}"),
        ("ReadInputStatus", f"Quantity := 13, MBAddr := 3, {BITS}"),
    ):
        ran = _master("ModbusRtuMaster_PcCOM", action, inputs)
        assert _run(ran, Line(ran, "PcCOM", device(memory))) == (False, 0)
        expected = sum(memory.bits[3 + index] << index for index in range(13))
        assert bytes(ran["bits"])[:2] == expected.to_bytes(2, "little")
    for action, inputs in (
        ("WriteSingleCoil", f"MBAddr := 20, {BITS}"),
        ("WriteMultipleCoils", f"Quantity := 10, MBAddr := 30, {BITS}"),
        ("WriteSingleRegister", f"MBAddr := 5, {REGISTERS}"),
        ("WriteRegs", f"Quantity := 3, MBAddr := 10, {REGISTERS}"),
    ):
        ran = _master("ModbusRtuMaster_PcCOM", action, inputs)
        main: Any = ran.plc.instance("MAIN")
        main["bits"] = [0b101, 0b11, *bytes(8)]
        main["data"] = [0x1234, 0x5678, 0x9ABC, *[0] * 17]
        assert _run(ran, Line(ran, "PcCOM", device(memory))) == (False, 0)
    assert memory.bits[20] is True
    written = sum(memory.bits[30 + index] << index for index in range(10))
    assert written == 0b11_0000_0101
    assert memory.registers[5] == 0x1234
    assert memory.registers[10:13] == [0x1234, 0x5678, 0x9ABC]


def test_diagnosis_comes_back() -> None:
    ran = _master(
        "ModbusRtuMaster_PcCOM",
        "Diagnostics",
        "MBAddr := 0, cbLength := 2, pMemoryAddr := ADR(data)",
    )
    ran.plc.instance("MAIN")["data"] = [0xA537, *[0] * 19]
    assert _run(ran, Line(ran, "PcCOM", device(Memory()))) == (False, 0)
    assert (ran["data"][0], ran["m.cbRead"]) == (0xA537, 2)


def test_functions_that_send_and_receive() -> None:
    memory = Memory()
    aux = (
        "pAuxMemoryAddr := ADR(aux), AuxcbLength := SIZEOF(aux), AuxMBAddr := 40, AuxQuantity := 2"
    )
    ran = _master(
        "ModbusRtuMasterV2_PcCOM",
        "ReadWriteRegs",
        f"Quantity := 4, MBAddr := 1, {REGISTERS}, {aux}",
    )
    assert _run(ran, Line(ran, "PcCOM", device(memory))) == (False, 0)
    assert list(ran["data"])[:4] == [0x1101, 0x1102, 0x1103, 0x1104]
    assert memory.registers[40:42] == [0xAA, 0xAA]
    ran = _master(
        "ModbusRtuMasterV2_PcCOM",
        "UserReadWrite",
        f"cbLength := 5, pMemoryAddr := ADR(bits), {aux}",
    )
    ran.plc.instance("MAIN")["bits"] = [3, 0, 2, 0, 1, *bytes(5)]
    assert _run(ran, Line(ran, "PcCOM", device(memory))) == (False, 0)
    assert ran["m.cbRead"] == 4
    assert list(ran["aux"])[:2] == [0x0203, 0x0211]


def _damaged(frame: bytes) -> bytes:
    return b"\7\3\2\1\2\0\0"


@pytest.mark.parametrize(
    ("inputs", "answer", "error"),
    [
        (f"Quantity := 12, MBAddr := 60, {REGISTERS}", device(Memory()), 2),
        (f"Quantity := 1, MBAddr := 0, {REGISTERS}", device(Memory(), 9), 0x25),
        (f"Quantity := 1, MBAddr := 0, {REGISTERS}", lambda _: b"\7\3\2", 0x20),
        (f"Quantity := 1, MBAddr := 0, {REGISTERS}", _damaged, 150),
        (f"Quantity := 21, MBAddr := 0, {REGISTERS}", device(Memory()), 0x21),
        (f"Quantity := 0, MBAddr := 0, {REGISTERS}", device(Memory()), 0x21),
        ("Quantity := 1, MBAddr := 0, cbLength := 2", device(Memory()), 120),
    ],
)
def test_errors_of_requests(inputs: str, answer: Callable[[bytes], bytes], error: int) -> None:
    ran = _master("ModbusRtuMaster_PcCOM", "ReadRegs", inputs)
    assert _run(ran, Line(ran, "PcCOM", answer)) == (True, error)


def test_a_request_is_the_frame_of_the_protocol() -> None:
    """Modbus over serial line: unit, function, address, number, check sum with its low byte
    first."""
    frames: list[bytes] = []

    def keep(frame: bytes) -> bytes:
        frames.append(frame)
        return b""

    ran = _master("ModbusRtuMaster_PcCOM", "ReadRegs", f"Quantity := 10, MBAddr := 0, {REGISTERS}")
    assert _run(ran, Line(ran, "PcCOM", keep)) == (True, 0x25)
    assert frames == [b"\x07\x03\x00\x00\x00\x0a" + check_sum(b"\x07\x03\x00\x00\x00\x0a")]
    assert check_sum(b"\x01\x03\x00\x00\x00\x0a") == b"\xc5\xcd"
