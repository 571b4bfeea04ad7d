"""pyads asks the buses of a station: every object of a drive by CoE, states, lists, counters."""

import asyncio
import struct
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.codes import SdoAbort
from achse.devices.io import default_net_id
from achse.drive.identity import PRODUCT, VENDOR
from achse.station import Station

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

EXAMPLE = Path(__file__).parents[2] / "examples" / "drives" / "station.toml"
IO, MASTER, FIRST_DRIVE = 300, 0xFFFF, 1001
SDO, SDO_ERROR = 0xF302, 0xF303
OP = 8
LONGEST = 256
READ = {1: "BYTE", 2: "UINT", 4: "UDINT"}


class LiveBus:
    """The example's station in a thread, at an address of its own."""

    def __init__(self, host: str) -> None:
        self.host = host
        self.net_id = f"{host}.1.1"
        self.station = Station.load(EXAMPLE, net_id=self.net_id)
        self.bus = str(default_net_id(NetId(self.net_id), 1))
        self._loop = asyncio.new_event_loop()
        self._leave = asyncio.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(
            target=lambda: self._loop.run_until_complete(self._serve()), daemon=True
        )
        self._thread.start()
        assert self._ready.wait(60)

    async def _serve(self) -> None:
        async with self.station.running(self.host, 48898):
            self._ready.set()
            await self._leave.wait()

    def ask(self, question: Callable[[], Any]) -> Any:
        """Do something in the station's thread."""

        async def answer() -> Any:
            return question()

        return asyncio.run_coroutine_threadsafe(answer(), self._loop).result(60)

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._leave.set)
        self._thread.join()
        self._loop.close()


@pytest.fixture(scope="module")
def live(free_host: Callable[[], str]) -> Iterator[LiveBus]:
    running = LiveBus(free_host())
    yield running
    running.close()


@pytest.fixture
def at(
    live: LiveBus, until: Callable[..., None], witness: Callable[[str], None]
) -> Iterator[Callable[..., Any]]:
    """`at(1001)` is pyads at a port of the bus; `at(300, station=True)` at one of the station."""
    witness("pyads")
    opened: dict[tuple[str, int], Any] = {}

    def connect(port: int, station: bool = False) -> Any:
        key = (live.net_id if station else live.bus, port)
        if key not in opened:
            opened[key] = pyads.Connection(*key, live.host)
            opened[key].open()
        return opened[key]

    master = connect(MASTER)
    until(lambda: master.read(0x3, 0x100, pyads.PLCTYPE_UINT) == OP)
    yield connect
    for each in opened.values():
        each.close()


def raw(connection: Any, group: int, offset: int, length: int = LONGEST) -> bytes:
    """Bytes of a Read, as many as come."""
    answer = connection.read(group, offset, pyads.PLCTYPE_BYTE * length, check_length=False)
    return bytes(answer)


def test_every_object_of_a_drive_is_what_sdo_gives(live: LiveBus, at: Callable[..., Any]) -> None:
    """All entries: the value that the drive's dictionary gives, or the abort code it refuses with.

    What moves by itself, as temperatures and counters, has to be between two looks.
    """
    drive = live.station.buses[0].bus.drives[0]
    slave = at(FIRST_DRIVE)

    def value(index: int, subindex: int) -> bytes | int:
        try:
            return bytes(drive.read_object(index, subindex))
        except SdoAbort as abort:
            return int(abort.code.number)

    compared = 0
    for described in drive.objects():
        for entry in described.entries:
            key = described.index, entry.subindex
            before = live.ask(partial(value, *key))
            try:
                came: bytes | int = raw(slave, SDO, key[0] << 16 | key[1])
            except pyads.ADSError:
                came = int.from_bytes(raw(slave, SDO_ERROR, 0)[8:12], "little")
            after = live.ask(partial(value, *key))
            if isinstance(before, bytes) and isinstance(came, bytes):
                came = came[: len(before)]  # pyads fills up with zeros
            low, high = sorted((number(before), number(after)))
            assert low <= number(came) <= high, f"{key[0]:04X}:{key[1]:02X}"
            compared += 1
    assert compared >= 203


def number(value: bytes | int) -> int:
    return value if isinstance(value, int) else int.from_bytes(value, "little")


def test_objects_are_written_and_refused(at: Callable[..., Any]) -> None:
    slave = at(FIRST_DRIVE + 1)
    slave.write(SDO, 0x6081_0000, 4711, pyads.PLCTYPE_UDINT)
    assert slave.read(SDO, 0x6081_0000, pyads.PLCTYPE_UDINT) == 4711
    with pytest.raises(pyads.ADSError, match="1796"):  # 0x704: read only
        slave.write(SDO, 0x6064_0000, 1, pyads.PLCTYPE_UDINT)
    assert raw(slave, SDO_ERROR, 0)[8:12] == (0x0601_0002).to_bytes(4, "little")
    whole = raw(slave, SDO, 0x1018_0100, 18)
    assert struct.unpack_from("<HII", whole) == (4, VENDOR, PRODUCT)


def test_lists_and_states_as_clients_walk_them(live: LiveBus, at: Callable[..., Any]) -> None:
    """From port 300 to the bus, its slaves, their states and identities."""
    io, master = at(IO, station=True), at(MASTER)
    assert struct.unpack_from("<HH", raw(io, 0x5000, 1)) == (1, 1)
    assert raw(io, 0x5001, 5, 6) == bytes(NetId(live.bus))
    assert io.read(0x5001, 7, pyads.PLCTYPE_UINT) == 111
    count = master.read(0x6, 0, pyads.PLCTYPE_UINT)
    assert count == 4
    stations = struct.unpack("<4H", raw(master, 0x7, 0, 8))
    assert stations == (1001, 1002, 1003, 1004)
    assert raw(master, 0x9, 0, 8) == bytes((OP, 0)) * 4
    for station in stations:
        assert struct.unpack_from("<II", raw(master, 0x11, station, 16)) == (VENDOR, PRODUCT)
    assert master.read(0x45, 0, pyads.PLCTYPE_UINT) == 0
    sent = struct.unpack("<5I", raw(master, 0x0C, 0, 20))
    assert sent[1] > 0


def test_an_axis_leads_to_its_drive(live: LiveBus, at: Callable[..., Any]) -> None:
    """Parameter 0x31 of an axis is the address where CoE answers."""
    nc = at(500, station=True)
    address = raw(nc, 0x4001, 0x31, 10)
    assert address[:6] == bytes(NetId(live.bus))
    port = int.from_bytes(address[6:8], "little")
    status = at(port).read(SDO, 0x6041_0000, pyads.PLCTYPE_UINT)
    assert status & 0x0200  # remote
