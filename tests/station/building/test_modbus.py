"""The Modbus server of a station: there if it is configured, in virtual time and in a loop."""

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.transport.modbus_devices import tcp_device

MAIN = """
PROGRAM MAIN
VAR read : FB_MBReadRegs; registers : ARRAY [0..1] OF WORD; answers, cycles : UDINT; END_VAR
cycles := cycles + 1;
read(sIPAddr := '10.0.0.1', nQuantity := 2, nMBAddr := 5, cbLength := SIZEOF(registers),
     pDestAddr := ADR(registers), bExecute := NOT read.bBUSY AND answers = 0, tTimeout := T#60S);
IF answers = 0 AND NOT read.bBUSY AND (read.cbRead > 0 OR read.bError) THEN
    answers := answers + 1;
END_IF
END_PROGRAM
"""


def station(folder: Path, modbus: dict[str, Any] | None) -> Station:
    (folder / "a.st").write_text(MAIN, encoding="utf-8")
    document: dict[str, Any] = {"plc": [{"sources": "a.st"}]}
    if modbus is not None:
        document["modbus"] = modbus
    return Station(parse(document, "a.toml"), base=folder)


def main(there: Station) -> Any:
    assert there.plcs[851].failure == ""
    return there.plcs[851].instance("MAIN")


async def until(holds: Callable[[], bool]) -> None:
    while not holds():  # noqa: ASYNC110 - a PLC notifies nobody
        await asyncio.sleep(0.001)


def answer(unit: int, pdu: bytes) -> bytes:
    return b"\x03\x04\x12\x34\x56\x78"


def test_without_it_no_device_is_there(tmp_path: Path) -> None:
    there = station(tmp_path, None)
    there.advance(0.1)
    assert main(there)["read"]["nErrId"] == 6


def test_virtual_time_waits_for_the_device(tmp_path: Path) -> None:
    with tcp_device(answer) as device:
        there = station(tmp_path, {"peers": {"10.0.0.1": f"127.0.0.1:{device.port}"}})
        there.advance(0.05)
        assert list(main(there)["registers"]) == [0x1234, 0x5678]
        assert device.requests == [b"\x03\0\5\0\2"]


def test_a_restart_ends_what_is_under_way(tmp_path: Path) -> None:
    with tcp_device(answer) as device:
        there = station(tmp_path, {"peers": {"10.0.0.1": f"127.0.0.1:{device.port}"}})
        there.advance(0.05)
        there.restart()
        there.advance(1.0)
        assert list(main(there)["registers"]) == [0x1234, 0x5678]
        assert device.connections == 2


def test_the_cycle_goes_on_while_a_device_thinks(tmp_path: Path) -> None:
    go = threading.Event()

    def slow(unit: int, pdu: bytes) -> bytes:
        go.wait(60)
        return answer(unit, pdu)

    async def run() -> None:
        async with there.running("127.0.0.1", 0):
            await until(lambda: bool(device.requests))
            before = main(there)["cycles"]
            await until(lambda: main(there)["cycles"] >= before + 3)
            assert main(there)["read"]["bBUSY"]
            go.set()
            await until(lambda: main(there)["answers"] > 0)

    with tcp_device(slow) as device:
        there = station(tmp_path, {"peers": {"10.0.0.1": f"127.0.0.1:{device.port}"}})
        asyncio.run(run())
    assert list(main(there)["registers"]) == [0x1234, 0x5678]
