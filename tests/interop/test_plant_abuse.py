"""Bad input to the plant: each a documented code, and an unharmed station beside it."""

import asyncio
import random
import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import DeviceError
from achse.client import Client

PLANT = Path(__file__).parent / "plant" / "station.toml"
NOT_FOUND, BAD_INDEX = 0x710, 0x721


@pytest.fixture(scope="module")
def station(start_station: Callable[..., AbstractContextManager[Any]]) -> Iterator[Any]:
    with start_station(str(PLANT)) as running:
        yield running


def _with(station: Any, use: Callable[[Client], Any]) -> None:
    async def main() -> None:
        async with achse.connect(station.host) as plc:
            await use(plc)
            assert await plc.read("GVL.cMost") == 3

    asyncio.run(main())


async def _code(request: Any) -> int:
    with pytest.raises(DeviceError) as refusal:
        await request
    return int(refusal.value.code)


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("x" * 10_000, NOT_FOUND),
        ("GVL.aStations" + "[0]" * 3_333, NOT_FOUND),
        ("GVL" + ".a" * 5_000, NOT_FOUND),
        ("GVL.aStations[3]", BAD_INDEX),
        ("GVL.aStations[-1].sName", BAD_INDEX),
        ("GVL.aStations[99999999999999999999999]", BAD_INDEX),
        ("GVL.aStations[0].aPoints[0]", BAD_INDEX),
        ("GVL.aStations[", NOT_FOUND),
        ("GVL.aStations[0]^", NOT_FOUND),
        ("MAIN.fbFeeder#Nothing", NOT_FOUND),
        ("", NOT_FOUND),
    ],
)
def test_names(station: Any, name: str, code: int) -> None:
    async def use(plc: Client) -> None:
        for group in (0xF003, 0xF004, 0xF007, 0xF009):
            assert await _code(plc.read_write_raw(group, 0, 0xFFFF, name.encode())) == code

    _with(station, use)


def test_read_only_oversize_and_undersize_writes(station: Any) -> None:
    async def use(plc: Client) -> None:
        constant = await plc.read_write_raw(0xF003, 0, 4, b"GVL.cMost")
        handle = int.from_bytes(constant, "little")
        assert await _code(plc.write_raw(0xF005, handle, b"\0\0")) == 0x704
        shift = int.from_bytes(await plc.read_write_raw(0xF003, 0, 4, b"GVL.nShift"), "little")
        for size in (3, 1000, 1_000_000):
            assert await _code(plc.write_raw(0xF005, shift, bytes(size))) == 0x705
        await plc.write_raw(0xF005, shift, b"\x34\x12")
        await plc.write_raw(0xF005, shift, b"\x56")
        await plc.write_raw(0xF005, shift, b"")
        assert await plc.read("GVL.nShift") == 0x1256
        feed = await plc.read_write_raw(0xF003, 0, 4, b"MAIN.fbFeeder#Feed")
        method = int.from_bytes(feed, "little")
        for size in (0, 30, 32, 10_000):  # 2 + 8 + 21 bytes of inputs are due
            assert await _code(plc.read_write_raw(0xF005, method, 8, bytes(size))) == 0x705
        assert await _code(plc.read_raw(0xF005, method, 8)) == 0x704
        assert await _code(plc.write_raw(0xF005, method, b"\0")) == 0x704

    _with(station, use)


def test_random_requests_to_the_symbol_services(station: Any) -> None:
    async def use(plc: Client) -> None:
        chance = random.Random(3)
        names = [b"GVL.aStations", b"MAIN.fbFeeder#Feed", b"GVL.aStations[1].aPoints[2].fX", b"\0"]

        async def one() -> None:
            data = bytearray(chance.choice(names)) * chance.choice([1, 1, 1, 50])
            for _ in range(chance.randrange(4)):
                data.insert(chance.randrange(len(data) + 1), chance.randrange(256))
            group = chance.randrange(0xF000, 0xF020)
            offset = chance.choice([0, 1, 0x8000_0000, chance.getrandbits(32)])
            try:
                kind = chance.randrange(3)
                if kind == 0:
                    await plc.read_raw(group, offset, chance.choice([0, 4, 0xFFFF_FFFF]))
                elif kind == 1:
                    await plc.write_raw(group, offset, bytes(data))
                else:
                    length = chance.choice([0, 4, 0xFFFF, 0xFFFF_FFFF])
                    await plc.read_write_raw(group, offset, length, bytes(data))
            except DeviceError as refusal:
                assert 0x701 <= refusal.code < 0x740, refusal  # noqa: PT017

        for _ in range(20):
            await asyncio.gather(*(one() for _ in range(50)))
        assert struct.unpack("<H", await plc.read_raw(0xF100, 0, 2)) == (5,)

    _with(station, use)
