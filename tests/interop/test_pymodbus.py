"""pymodbus as the device that the blocks of Tc2_ModbusSrv ask."""

import asyncio
import importlib
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.libraries.test_tc2_modbussrv import run

VARIABLES = """
    regs : FB_MB{0}ReadRegs; write : FB_MB{0}WriteRegs; coil : FB_MB{0}WriteSingleCoil;
    coils : FB_MB{0}ReadCoils; both : FB_MB{0}ReadWriteRegs; inputs : FB_MB{0}ReadInputs;
    inputRegs : FB_MB{0}ReadInputRegs; someCoils : FB_MB{0}WriteCoils; reg : FB_MB{0}WriteSingleReg;
    words : ARRAY [0..124] OF WORD; new : ARRAY [0..122] OF WORD := [123(16#ABCD)];
    bits : ARRAY [0..249] OF BYTE; newBits : ARRAY [0..1] OF BYTE := [16#75, 16#03];
    one, found : WORD; oneBit : BYTE;
"""
STEPS = (
    ("write", "nQuantity := 123, nMBAddr := 1, cbLength := 246, pSrcAddr := ADR(new)"),
    ("reg", "nMBAddr := 2, nValue := 16#0102"),
    ("regs", "nQuantity := 125, nMBAddr := 1, cbLength := 250, pDestAddr := ADR(words)"),
    (
        "both",
        "nReadQuantity := 1, nMBReadAddr := 9, nWriteQuantity := 1, nMBWriteAddr := 9,"
        " cbDestLength := 2, pDestAddr := ADR(found), cbSrcLength := 2, pSrcAddr := ADR(one)",
    ),
    ("coil", "nMBAddr := 5, nValue := 16#FF00"),
    ("someCoils", "nQuantity := 10, nMBAddr := 20, cbLength := 2, pSrcAddr := ADR(newBits)"),
    ("coils", "nQuantity := 1999, nMBAddr := 0, cbLength := 250, pDestAddr := ADR(bits)"),
    ("inputs", "nQuantity := 3, nMBAddr := 0, cbLength := 1, pDestAddr := ADR(oneBit)"),
    ("inputRegs", "nQuantity := 1, nMBAddr := 0, cbLength := 2, pDestAddr := ADR(one)"),
    ("regs", "nQuantity := 2, nMBAddr := 60000, cbLength := 250, pDestAddr := ADR(words)"),
)


@contextmanager
def served(udp: bool) -> Iterator[int]:
    """Port of a server with 2,000 of everything, in a thread."""
    datastore: Any = importlib.import_module("pymodbus.datastore")
    servers: Any = importlib.import_module("pymodbus.server")

    ready, port, ends = threading.Event(), [0], list[Callable[[], object]]()

    async def serve() -> None:
        def block(value: int) -> Any:
            return datastore.ModbusSequentialDataBlock(1, [value] * 2000)

        device = datastore.ModbusDeviceContext(di=block(1), co=block(0), hr=block(7), ir=block(9))
        context = datastore.ModbusServerContext(devices=device, single=True)
        kind = servers.ModbusUdpServer if udp else servers.ModbusTcpServer
        server = kind(context, address=("127.0.0.1", 0))
        await server.serve_forever(background=True)
        transport: Any = server.transport
        where = transport.get_extra_info("sockname") if udp else None
        port[0] = where[1] if where else transport.sockets[0].getsockname()[1]
        ended = asyncio.Event()
        loop = asyncio.get_running_loop()
        ends.append(lambda: loop.call_soon_threadsafe(ended.set))
        ready.set()
        await ended.wait()
        await server.shutdown()

    thread = threading.Thread(target=lambda: asyncio.run(serve()), daemon=True)
    thread.start()
    assert ready.wait(60)
    try:
        yield port[0]
    finally:
        ends[0]()
        thread.join()


@pytest.mark.parametrize("udp", [False, True])
def test_the_blocks_understand_it(
    tmp_path: Path, witness: Callable[[str], None], udp: bool
) -> None:
    witness("pymodbus")
    with served(udp) as port:
        main = run(tmp_path, port, VARIABLES.format("Udp" if udp else ""), *STEPS)
    assert list(main["errors"]) == [*[0] * 9, 0x8002, 0]
    words = list(main["words"])
    assert words[:3] == [0xABCD, 0x0102, 0xABCD]
    assert words[122:] == [0xABCD, 7, 7]
    assert main["found"] == 0
    assert main["one"] == 9
    assert main["oneBit"] == 0b111
    bits = bytes(main["bits"])
    assert bits[0] == 0b10_0000
    assert bits[2:4] == bytes((0x50, 0x37))
    assert not any(bits[4:])
