"""Tc2_ModbusSrv: each block, over TCP and UDP, against a device that has memory."""

from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.modbus_memory import Memory
from tests.transport.modbus_devices import tcp_device, udp_device


def run(folder: Path, port: int, variables: str, *steps: tuple[str, str]) -> Any:
    """`MAIN` after steps: block and inputs, each until it is not busy; errors are kept."""
    body = "CASE step OF\n"
    for number, (block, inputs) in enumerate(steps):
        body += (
            f"{number}: {block}(sIPAddr := '127.0.0.1', nTCPPort := {port}, {inputs},"
            f" tTimeout := T#60S, bExecute := TRUE);\n IF NOT {block}.bBUSY THEN\n"
            f" errors[{number}] := {block}.nErrId; failed[{number}] := {block}.bError;\n"
            f" {block}(bExecute := FALSE); step := step + 1; END_IF\n"
        )
    last = len(steps)
    text = (
        f"PROGRAM MAIN VAR step : INT; errors : ARRAY [0..{last}] OF UDINT;"
        f" failed : ARRAY [0..{last}] OF BOOL; {variables} END_VAR\n{body}END_CASE END_PROGRAM"
    )
    (folder / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}], "modbus": {}}, "a.toml"), base=folder)
    station.advance(1.0)
    assert station.plcs[851].failure == ""
    main = station.plcs[851].instance("MAIN")
    assert main["step"] == last
    station.shut_down()
    station.advance(0.1)
    return main


VARIABLES = """
    coils : FB_MB{0}ReadCoils; inputs : FB_MB{0}ReadInputs; regs : FB_MB{0}ReadRegs;
    inputRegs : FB_MB{0}ReadInputRegs; coil : FB_MB{0}WriteSingleCoil; reg : FB_MB{0}WriteSingleReg;
    someCoils : FB_MB{0}WriteCoils; someRegs : FB_MB{0}WriteRegs; both : FB_MB{0}ReadWriteRegs;
    diagnose : FB_MB{0}Diagnose;
    bits, otherBits : ARRAY [0..3] OF BYTE := [4(255)];
    words, otherWords, found : ARRAY [0..3] OF WORD;
    newBits : ARRAY [0..1] OF BYTE := [16#75, 16#03];
    newWords : ARRAY [0..2] OF WORD := [100, 200, 300];
"""
STEPS = (
    ("coils", "nQuantity := 10, nMBAddr := 3, cbLength := 4, pDestAddr := ADR(bits)"),
    ("inputs", "nQuantity := 8, nMBAddr := 0, cbLength := 4, pDestAddr := ADR(otherBits)"),
    ("regs", "nQuantity := 2, nMBAddr := 5, cbLength := SIZEOF(words), pDestAddr := ADR(words)"),
    ("inputRegs", "nQuantity := 1, nMBAddr := 9, cbLength := 8, pDestAddr := ADR(otherWords)"),
    ("coil", "nMBAddr := 1, nValue := 16#FF00, nUnitID := 7"),
    ("reg", "nMBAddr := 40, nValue := 16#1234"),
    ("someCoils", "nQuantity := 10, nMBAddr := 20, cbLength := 2, pSrcAddr := ADR(newBits)"),
    ("someRegs", "nQuantity := 3, nMBAddr := 30, cbLength := 6, pSrcAddr := ADR(newWords)"),
    (
        "both",
        "nReadQuantity := 4, nMBReadAddr := 30, nWriteQuantity := 1, nMBWriteAddr := 31,"
        " cbDestLength := 8, pDestAddr := ADR(found), cbSrcLength := 6, pSrcAddr := ADR(newWords)",
    ),
    ("diagnose", "nSubFnc := 0, nWriteData := 16#A537"),
)


@pytest.mark.parametrize("udp", [False, True])
def test_each_block(tmp_path: Path, udp: bool) -> None:
    memory = Memory()
    variables = VARIABLES.format("Udp" if udp else "")
    if udp:
        with udp_device(memory.answer) as port:
            main = run(tmp_path, port, variables, *STEPS)
    else:
        with tcp_device(memory.answer) as device:
            main = run(tmp_path, device.port, variables, *STEPS)
            assert device.connections == 1
    assert not any(main["failed"])
    assert not any(main["errors"])
    assert list(main["bits"]) == [0b01001001, 0b10, 255, 255]
    assert list(main["otherBits"]) == [0b01001001, 255, 255, 255]
    assert [main[name]["cbRead"] for name in ("coils", "inputs", "regs", "inputRegs", "both")] == [
        *(2, 1, 4, 2, 8)
    ]
    assert list(main["words"]) == [0x1105, 0x1106, 0, 0]
    assert list(main["otherWords"]) == [0x1109, 0, 0, 0]
    assert memory.bits[1]
    assert memory.registers[40] == 0x1234
    assert [int(bit) for bit in memory.bits[20:30]] == [1, 0, 1, 0, 1, 1, 1, 0, 1, 1]
    assert list(main["found"]) == [100, 100, 300, 0x1121]
    assert main["diagnose"]["nReadData"] == 0xA537
    assert memory.unit == 0xFF


def test_errors(tmp_path: Path) -> None:
    memory = Memory()
    with tcp_device(memory.answer) as device:
        main = run(
            tmp_path,
            device.port,
            VARIABLES.format(""),
            ("regs", "nQuantity := 1, nMBAddr := 64, cbLength := 8, pDestAddr := ADR(words)"),
            ("regs", "nQuantity := 0, nMBAddr := 0, cbLength := 8, pDestAddr := ADR(words)"),
            ("regs", "nQuantity := 5, nMBAddr := 0, cbLength := 8, pDestAddr := ADR(words)"),
            ("someRegs", "nQuantity := 4, nMBAddr := 0, cbLength := 6, pSrcAddr := ADR(newWords)"),
            ("someRegs", "nQuantity := 3, nMBAddr := 0, cbLength := 6, pSrcAddr := 0"),
            ("regs", "nQuantity := 1, nMBAddr := 0, cbLength := 8, pDestAddr := 0"),
            ("regs", "nQuantity := 4, nMBAddr := 0, cbLength := 8, pDestAddr := ADR(words)"),
        )
    errors = list(main["errors"])[:7]
    assert errors == [0x8002, 0x8003, 0x8002, 0x8002, 0x741, 0x741, 0]
    assert list(main["failed"])[:7] == [*[True] * 6, False]
    assert list(main["words"]) == [0x1100, 0x1101, 0x1102, 0x1103]
    assert memory.registers[0] == 0x1100
