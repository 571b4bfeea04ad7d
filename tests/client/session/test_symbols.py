"""What a client knows of a device's symbols, and when it forgets."""

import asyncio
import struct
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from achse.ams import AmsAddress, ConnectionLost, DecodeError, DeviceError
from achse.ams.commands import AddNotificationRequest, ReadRequest, ReadWriteRequest
from achse.client.session.raw import RawTarget
from achse.client.session.session import Backoff, Session
from achse.client.session.symbols import SymbolBook
from achse.iec import ARRAY, INT, LREAL, UDINT, Enumeration, Struct, iec_type, var
from achse.iec.describe import describe_type, types_within

Run = Callable[[Any], Any]


class E_Mode(Enumeration, base=INT):  # noqa: N801
    OFF = 0
    ON = 5


class ST_Point(Struct):  # noqa: N801
    fX = var(LREAL)  # noqa: N815
    eMode = var(E_Mode)  # noqa: N815


@asynccontextmanager
async def book_of(peer: Any, watch: bool = False) -> AsyncIterator[SymbolBook]:
    session = Session(peer, keep_alive=None, backoff=Backoff(0.1, 0.1))
    await session.open()
    try:
        yield SymbolBook(RawTarget(session, AmsAddress("5.4.3.2.1.1:851"), 5.0), watch)
    finally:
        await session.close()


def declare(peer: Any, *roots: Any) -> None:
    """Let the peer answer for these types."""
    for type_ in types_within([iec_type(root) for root in roots]):
        peer.types[type_.name] = describe_type(type_).encode()


def test_a_symbol_has_a_handle_a_size_and_a_type(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            assert book.known("MAIN.nCounter") is None
            place = await book.place("MAIN.nCounter")
            assert place == ("MAIN.nCounter", 0xF005, 101, 4, UDINT)
            assert book.known("main.NCOUNTER") is place
            assert await book.place("Main.nCounter") is place
            assert [p.name for p in await book.locate(["MAIN.NCOUNTER"])] == ["MAIN.NCOUNTER"]
            assert [r.index_group for r in peer.requests] == [0xF009, 0xF003]

    run(main())


def test_queries_at_the_same_time_are_one(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            places = await asyncio.gather(*[book.place("MAIN.nCounter") for _ in range(50)])
            assert len(set(map(id, places))) == 1
            assert len(peer.requests) == 2

    run(main())


def test_many_names_are_fetched_in_sums(run: Run, peer: Any) -> None:
    async def main() -> None:
        for number in range(600):
            peer.variables[f"GVL.v{number}"] = ["INT", 2, struct.pack("<h", number)]
        async with book_of(peer) as book:
            places = await book.locate([f"GVL.v{number}" for number in range(600)])
            assert len({place.offset for place in places}) == 600
            sums = [(r.index_group, r.index_offset) for r in peer.requests]
            assert sums == [(0xF082, 500), (0xF082, 100)] * 2

    run(main())


def test_an_unknown_name_fails_alone(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            good, bad, odd = await book.places(["GVL.fValue", "GVL.none", "GVL.\u4e2d"])
            assert not isinstance(good, Exception)
            for error in (bad, odd):
                assert isinstance(error, DeviceError)
                assert error.code == 0x710
            assert "symbol GVL.none" in str(bad)
            with pytest.raises(DeviceError):
                await book.locate(["GVL.fValue", "GVL.none"])

    run(main())


def test_a_cancelled_question_leaves_the_others_theirs(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            first = asyncio.create_task(book.place("GVL.fValue"))
            second = asyncio.create_task(book.place("GVL.fValue"))
            await asyncio.sleep(0)
            first.cancel()
            assert (await second).type is LREAL

    run(main())


def test_types_are_fetched_down_to_the_last_member(run: Run, peer: Any) -> None:
    async def main() -> None:
        points = ARRAY(ST_Point, (0, 1))
        declare(peer, points)
        peer.variables["GVL.aPoints"] = [points.name, 65, points.default]
        async with book_of(peer) as book:
            place = await book.place("GVL.aPoints")
            data = struct.pack("<dh6xdh6x", 1.5, 5, -2.0, 7)
            first, second = place.type.decode(data)
            assert (first.fX, first.eMode.name, second.fX, second.eMode) == (1.5, "ON", -2.0, 7)
            names = [r.data for r in peer.requests_of(ReadWriteRequest, 0xF011)]
            assert names == [b"ST_Point\0", b"E_Mode\0"]

    run(main())


def test_of_a_device_without_0xf011_all_types_are_requested(run: Run, peer: Any) -> None:
    async def main() -> None:
        declare(peer, ST_Point)
        table = b"".join(peer.types.values())
        peer.not_offered = {0xF011}
        peer.raw[0xF00F, 0] = struct.pack("<9I28x", 0, 0, 2, len(table), 0, 0, 0, 1252, 3)
        peer.raw[0xF00E, 0] = table
        peer.variables["GVL.stPoint"] = ["ST_Point", 65, bytes(16)]
        async with book_of(peer) as book:
            assert (await book.place("GVL.stPoint")).type.decode(bytes(16)).fX == 0.0

    run(main())


def test_a_name_that_is_not_there_has_a_hint_and_the_table_is_requested_once(
    run: Run, peer: Any
) -> None:
    async def main() -> None:
        declare(peer, ST_Point)
        peer.variables["GVL.stPoint"] = ["ST_Point", 65, bytes(16)]
        async with book_of(peer) as book:
            for name, hint in [
                ("GVL.fVlaue", "did you mean 'GVL.fValue'?"),
                ("GVL.stPoint.fY", "ST_Point has no member 'fY'; it has fX, eMode"),
                ("GVL.fVlaue", "did you mean 'GVL.fValue'?"),
                ("other", "Symbol not found."),
            ]:
                with pytest.raises(DeviceError) as refusal:
                    await book.place(name)
                assert (refusal.value.code, refusal.value.context) == (0x710, f"symbol {name}")
                assert str(refusal.value).endswith(hint)
            assert len(peer.requests_of(ReadRequest, 0xF00B)) == 1

    run(main())


@pytest.mark.parametrize("reason", ["not offered", "large", "mute"])
def test_without_a_table_a_name_has_no_hint(
    run: Run, peer: Any, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> None:
        if reason == "not offered":
            peer.not_offered = {0xF00B}
        if reason == "large":
            monkeypatch.setattr("achse.client.session.symbols._LARGEST_LISTING", 1)
        monkeypatch.setattr("achse.client.session.symbols._HINT_TIME", 0.01)
        async with book_of(peer) as book:
            await book.place("GVL.fValue")
            receive = peer.receive

            def deaf(frame: Any) -> None:
                if frame.data[:4] != struct.pack("<I", 0xF00F):
                    receive(frame)

            if reason == "mute":
                monkeypatch.setattr(peer, "receive", deaf)
            places = await book.places(["GVL.fVlaue", "GVL.fValue"])
            assert str(places[0]).endswith("Symbol not found.")
            assert not isinstance(places[1], Exception)

    run(main())


def test_a_device_without_types_gives_numbers_and_bytes(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF011, 0xF00E, 0xF00F}
        peer.variables["GVL.eMode"] = ["E_Mode", 2, b"\5\0"]
        peer.variables["GVL.stPoint"] = ["ST_Point", 65, bytes(16)]
        async with book_of(peer) as book:
            mode, point = await book.locate(["GVL.eMode", "GVL.stPoint"])
            assert mode.type.decode(b"\5\0") == 5
            assert point.type.decode(bytes(16)) == bytes(16)

    run(main())


def test_of_a_device_without_0xf009_the_table_is_requested(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF009, 0xF00F}
        async with book_of(peer) as book:
            assert (await book.place("gvl.fvalue")).type is LREAL
            with pytest.raises(DeviceError, match=r"GVL\.none"):
                await book.place("GVL.none")
            assert len(peer.requests_of(ReadRequest, 0xF00B)) == 1

    run(main())


def test_parts_of_symbols_of_a_table_are_found_by_its_types(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF009, 0xF003}
        declare(peer, ARRAY(ST_Point, (1, 2)))
        peer.variables["GVL.aPoints"] = ["ARRAY [1..2] OF ST_Point", 65, bytes(32)]
        start = 64 * (len(peer.variables) - 1)
        async with book_of(peer) as book:
            part = await book.place("gvl.aPoints[2].eMode")
            assert part[1:4] == (0x4040, start + 16 + 8, 2)
            assert part.type.name == "E_Mode"
            counter = 64 * list(peer.variables).index("MAIN.nCounter")
            bit = await book.place("MAIN.nCounter.11")
            assert bit[1:4] == (0x4041, 8 * counter + 11, 1)
            for name in ("GVL.aPoints[3].fX", "GVL.aPoints[1].fZ", "GVL.aPoints^", "GVL.none.x"):
                with pytest.raises(DeviceError, match="symbol GVL"):
                    await book.place(name)
            assert len(peer.requests_of(ReadRequest, 0xF00B)) == 1

    run(main())


def test_a_device_without_handles_is_read_by_address(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF003}
        async with book_of(peer) as book:
            assert (await book.place("GVL.fValue"))[1:4] == (0x4040, 64, 8)
            await book.leave()

    run(main())


def test_an_entry_without_nul_is_understood(run: Run, peer: Any) -> None:
    """pyads' test server puts blanks between the texts and nothing behind the comment."""

    async def main() -> None:
        head = struct.pack("<IIIIIIHHH", 41, 1, 2, 2, 18, 0, 5, 4, 0)
        peer.entry = lambda name: head + b"MAIN. UINT "
        async with book_of(peer) as book:
            assert (await book.place("GVL.fValue")).type.name == "UINT"
            peer.entry = lambda name: head[:20]
            with pytest.raises(DecodeError, match=r"symbol GVL\.sText"):
                await book.place("GVL.sText")
            peer.entry = lambda name: head + b"M"
            with pytest.raises(DecodeError, match=r"symbol MAIN\.nCounter"):
                await book.place("MAIN.nCounter")

    run(main())


def test_a_type_entry_that_is_none_is_a_decode_error(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.types["ST_Point"] = b"\xff\0\0\0nonsense"
        peer.variables["GVL.stPoint"] = ["ST_Point", 65, bytes(16)]
        async with book_of(peer) as book:
            with pytest.raises(DecodeError, match="type entry"):
                await book.place("GVL.stPoint")

    run(main())


def test_the_table_lists_every_symbol(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            entries = await book.entries()
            assert [(entry.name, entry.type_name, entry.size) for entry in entries] == [
                ("MAIN.nCounter", "UDINT", 4),
                ("GVL.fValue", "LREAL", 8),
                ("GVL.sText", "STRING(10)", 11),
            ]
            peer.variables.clear()
            assert await book.entries() == []

    run(main())


def test_a_forgotten_symbol_gets_a_new_handle(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            old = await book.place("GVL.fValue")
            book.forget(old)
            new = await book.place("GVL.fValue")
            assert (old.offset, new.offset) == (101, 102)
            book.forget(old)
            assert book.known("GVL.fValue") is new

    run(main())


def test_a_loss_forgets_everything(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            await book.place("GVL.fValue")
            peer.lose()
            await asyncio.sleep(1)
            assert book.known("GVL.fValue") is None
            assert (await book.place("GVL.fValue")).offset == 102

    run(main())


def test_a_loss_in_the_middle_fails_the_requests(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            peer.mute = True
            task = asyncio.create_task(book.place("GVL.fValue"))
            await asyncio.sleep(0.1)
            peer.lose()
            with pytest.raises(ConnectionLost):
                await task
            peer.mute = False
            assert await book.place("GVL.fValue")

    run(main())


def test_closing_in_the_middle_fails_the_requests(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            peer.mute = True
            task = asyncio.create_task(book.place("GVL.fValue"))
            await asyncio.sleep(0.1)
        with pytest.raises(ConnectionLost):
            await task

    run(main())


def test_parting_releases_the_handles(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer) as book:
            await book.locate(["GVL.fValue", "GVL.sText"])
            await book.leave()
            assert peer.released == [101, 102]

    run(main())


def test_a_change_of_the_symbol_version_forgets_and_releases(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with book_of(peer, watch=True) as book:
            await book.place("GVL.fValue")
            await asyncio.sleep(0.1)
            assert peer.requests_of(AddNotificationRequest) == [(0xF008, 0, 1, 4, 0, 0)]
            peer.variables["GVL.fValue"] = ["UDINT", 19, bytes(4)]
            peer.online_change()
            await asyncio.sleep(0.1)
            assert book.known("GVL.fValue") is None
            assert peer.released == [101]
            assert (await book.place("GVL.fValue")).type is UDINT

    run(main())


def test_a_device_that_has_no_version_is_not_watched(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF008}
        async with book_of(peer, watch=True) as book:
            await book.place("GVL.fValue")
            await asyncio.sleep(10)
            assert len(peer.requests_of(AddNotificationRequest)) == 1

    run(main())
