"""A device as a client sees it: values by name and place, many at once, subscriptions."""

import asyncio
import struct
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from achse.ams import AmsAddress, DecodeError, DeviceError, RequestTimeout, TransmissionMode
from achse.ams.commands import AddNotificationRequest, ReadRequest, ReadWriteRequest, WriteRequest
from achse.client.session.session import Session
from achse.client.target import Target
from achse.iec import ARRAY, INT, LREAL, UDINT, UINT, IecValueError

Run = Callable[[Any], Any]


@asynccontextmanager
async def target_of(peer: Any, watch: bool = False, **options: Any) -> AsyncIterator[Target]:
    session = Session(peer, **{"keep_alive": None, **options})
    await session.open()
    try:
        yield Target(session, AmsAddress("5.4.3.2.1.1:851"), 5.0, {}, watch)
    finally:
        await session.close()


def test_values_are_read_and_written_by_name(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            assert await plc.read("MAIN.nCounter") == 7
            assert await plc.read("gvl.stext") == "hello"
            await plc.write("GVL.fValue", 2.5)
            assert await plc.read("GVL.fValue") == 2.5
            assert (await plc.type_of("GVL.fValue")).name == "LREAL"

    run(main())


def test_a_second_read_is_one_request(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            await plc.read("MAIN.nCounter")
            count = len(peer.requests)
            await plc.read("MAIN.nCounter")
            assert len(peer.requests) == count + 1

    run(main())


def test_a_value_of_another_type_is_refused_here(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            with pytest.raises(IecValueError) as caught:
                await plc.write("MAIN.nCounter", "text")
            assert caught.value.__notes__ == ["symbol MAIN.nCounter"]
            assert peer.requests_of(WriteRequest) == []

    run(main())


def test_what_is_not_a_name_is_reported(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            number: Any = 5
            with pytest.raises(TypeError, match="the name of a symbol is text, got 5"):
                await plc.read(number)
            with pytest.raises(TypeError, match=r"a list of names expected, got the text 'GVL\.a'"):
                await plc.read_many("GVL.a")

    run(main())


def test_a_refusal_names_the_symbol(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            with pytest.raises(DeviceError) as caught:
                await plc.read("GVL.none")
            assert (caught.value.code, caught.value.context) == (0x710, "symbol GVL.none")
            await plc.read("GVL.fValue")

            def refuse(group: int, offset: int, data: bytes) -> None:
                raise DeviceError(0x704)

            peer.write = refuse
            with pytest.raises(DeviceError) as caught:
                await plc.write("GVL.fValue", 1.0)
            assert (caught.value.code, caught.value.context) == (0x704, "write GVL.fValue")

    run(main())


def test_a_stale_handle_is_fetched_again_once(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            await plc.read("MAIN.nCounter")
            peer.handles.clear()
            peer.variables["MAIN.nCounter"] = ["UINT", 18, b"\x09\0"]
            assert await plc.read("MAIN.nCounter") == 9
            assert await plc.type_of("MAIN.nCounter") is UINT
            peer.handles.clear()
            await plc.write("MAIN.nCounter", 10)
            assert await plc.read("MAIN.nCounter") == 10
            del peer.variables["MAIN.nCounter"]
            peer.handles.clear()
            with pytest.raises(DeviceError) as caught:
                await plc.read("MAIN.nCounter")
            assert caught.value.code == 0x710

    run(main())


def test_many_values_travel_in_one_sum(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            names = ["MAIN.nCounter", "GVL.sText", "MAIN.nCounter"]
            assert await plc.read_many(names) == {"MAIN.nCounter": 7, "GVL.sText": "hello"}
            peer.requests.clear()
            assert await plc.write_many({"MAIN.nCounter": 1, "GVL.sText": "new"}) == {}
            assert await plc.read_many(names) == {"MAIN.nCounter": 1, "GVL.sText": "new"}
            assert [r.index_group for r in peer.requests] == [0xF081, 0xF080]
            assert await plc.read_many([]) == {}

    run(main())


def test_of_many_one_may_fail(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            names = ["MAIN.nCounter", "GVL.none"]
            with pytest.raises(DeviceError, match=r"symbol GVL\.none"):
                await plc.read_many(names)
            values = await plc.read_many(names, strict=False)
            assert values["MAIN.nCounter"] == 7
            assert isinstance(values["GVL.none"], DeviceError)
            with pytest.raises(DeviceError, match=r"symbol GVL\.none"):
                await plc.write_many({"GVL.none": 1, "MAIN.nCounter": 8})
            errors = await plc.write_many({"GVL.none": 1, "GVL.fValue": 8.0}, strict=False)
            assert list(errors) == ["GVL.none"]
            assert await plc.read_many(["MAIN.nCounter", "GVL.fValue"]) == {
                "MAIN.nCounter": 8,
                "GVL.fValue": 8.0,
            }

    run(main())


def test_stale_handles_among_many_are_fetched_again(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            names = ["MAIN.nCounter", "GVL.fValue", "GVL.sText"]
            values = await plc.read_many(names)
            del peer.handles[101], peer.handles[103]
            assert await plc.read_many(names) == values
            peer.handles.clear()
            assert await plc.write_many({"MAIN.nCounter": 3, "GVL.fValue": 3.0}) == {}
            assert await plc.read_many(names[:2]) == {"MAIN.nCounter": 3, "GVL.fValue": 3.0}

    run(main())


def test_without_sums_many_are_read_one_by_one(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF080, 0xF081, 0xF082}
        async with target_of(peer) as plc:
            names = ["MAIN.nCounter", "GVL.fValue"]
            assert await plc.read_many(names) == {"MAIN.nCounter": 7, "GVL.fValue": 1.5}
            await plc.write_many({"MAIN.nCounter": 8, "GVL.fValue": 2.5})
            assert await plc.read_many(names) == {"MAIN.nCounter": 8, "GVL.fValue": 2.5}
            assert len(peer.requests_of(ReadWriteRequest, 0xF080)) == 1
            assert len(peer.requests_of(ReadRequest, 0xF005)) == 4

    run(main())


def test_any_place_can_be_read_as_a_type(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            assert await plc.read_as(0x4020, 0, UDINT) == 0x0403_0201
            assert await plc.read_as(0x4020, 0, ARRAY(INT, (0, 1))) == [0x0201, 0x0403]
            await plc.write_as(0x4020, 0, UDINT, 5)
            assert peer.raw[0x4020, 0] == b"\5\0\0\0"

    run(main())


def test_fewer_bytes_than_the_type_has_are_a_decode_error(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            with pytest.raises(DecodeError, match="0x4020:0x0: LREAL has 8 bytes, got 4"):
                await plc.read_as(0x4020, 0, LREAL)
            await plc.read("GVL.fValue")
            peer.variables["GVL.fValue"][2] = b"123"
            with pytest.raises(DecodeError, match=r"GVL\.fValue: LREAL"):
                await plc.read("GVL.fValue")

    run(main())


def test_another_port_shares_the_connection_but_not_the_symbols(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            nc = plc.at_port(501)
            assert (nc.session, str(nc.address)) == (plc.session, "5.4.3.2.1.1:501")
            assert str(plc.at_port(10000, "1.1.1.1.1.1").address) == "1.1.1.1.1.1:10000"
            await plc.read("MAIN.nCounter")
            await nc.read("MAIN.nCounter")
            assert len(peer.requests_of(ReadWriteRequest, 0xF003)) == 2
            assert plc.at_port(851)._book is plc._book

    run(main())


def test_within_sets_the_time_limit_of_its_requests(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            await plc.read("MAIN.nCounter")
            peer.mute = True
            start = asyncio.get_running_loop().time()
            with pytest.raises(RequestTimeout):
                await plc.within(0.25).read("MAIN.nCounter")
            assert asyncio.get_running_loop().time() - start == pytest.approx(0.25)
            with pytest.raises(RequestTimeout, match="look symbols up"):
                await plc.within(0.25).read("GVL.fValue")
            assert asyncio.get_running_loop().time() - start == pytest.approx(0.5)

    run(main())


def test_a_subscription_by_name_gives_typed_samples(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with (
            target_of(peer) as plc,
            plc.subscribe("GVL.sText", cycle_time=0.01, max_delay=0.5, mode="cycle") as samples,
        ):
            (request,) = peer.requests_of(AddNotificationRequest)
            assert request[0] == 0xF005
            assert request[2:] == (11, TransmissionMode.SERVER_CYCLE, 5_000_000, 100_000)
            peer.change("GVL.sText", b"world".ljust(11, b"\0"))
            assert [(await anext(samples)).value for _ in range(2)] == ["hello", "world"]

    run(main())


def test_names_in_any_case_come_back_as_requested(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            await plc.read("main.ncounter")
            assert await plc.read_many(["MAIN.nCounter"]) == {"MAIN.nCounter": 7}
            assert await plc.write_many({"MAIN.NCOUNTER": 8}) == {}
            async with plc.subscribe("Main.nCounter") as samples:
                assert (await anext(samples))[:2] == ("Main.nCounter", 8)

    run(main())


def test_a_subscription_to_nothing_is_refused(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            with pytest.raises(ValueError, match="at least one"):
                plc.subscribe([])

    run(main())


def test_many_names_make_one_subscription(run: Run, peer: Any) -> None:
    async def main() -> None:
        names = ["MAIN.nCounter", "GVL.fValue", "GVL.sText"]
        async with target_of(peer) as plc, plc.subscribe(names) as samples:
            got = {(await anext(samples)).name for _ in names}
            assert got == set(names)
            assert len(peer.requests_of(ReadWriteRequest, 0xF085)) == 1

    run(main())


def test_a_place_can_be_subscribed_as_a_type_or_as_bytes(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with (
            target_of(peer) as plc,
            plc.subscribe_as(0x4020, 0, UINT, mode=TransmissionMode.CLIENT_CYCLE) as numbers,
            plc.subscribe_as(0x4020, 0, 3) as raw,
        ):
            first, second = await anext(numbers), await anext(raw)
            assert (first.name, first.value) == ("0x4020:0x0", 0x0201)
            assert second.value == b"\1\2\3"
            assert peer.requests_of(AddNotificationRequest)[0].mode == 1

    run(main())


def test_subscriptions_follow_an_online_change(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer, watch=True) as plc, plc.subscribe("GVL.fValue") as samples:
            assert (await anext(samples)).value == 1.5
            await asyncio.sleep(0.1)
            peer.variables["GVL.fValue"] = ["UINT", 18, b"\7\0"]
            peer.online_change()
            sample = await anext(samples)
            assert (sample.value, sample.gap) == (7, True)
            await asyncio.sleep(0.1)
            assert len(peer.notifications) == 2  # the symbol version is one

    run(main())


def test_subscriptions_and_reads_survive_a_restart(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer, watch=True) as plc, plc.subscribe("GVL.fValue") as samples:
            await anext(samples)
            peer.variables["GVL.fValue"][2] = struct.pack("<d", 4.5)
            peer.lose()
            sample = await anext(samples)
            assert (sample.value, sample.gap) == (4.5, True)
            assert await plc.read("GVL.fValue") == 4.5
            peer.change("GVL.fValue", struct.pack("<d", 5.5))
            sample = await anext(samples)
            assert (sample.value, sample.gap, samples.interruptions) == (5.5, False, 1)

    run(main())


def test_a_subscription_with_a_stale_handle_fetches_it_again(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            await plc.read_many(["GVL.fValue", "MAIN.nCounter"])
            peer.handles.clear()
            async with plc.subscribe(["GVL.fValue", "MAIN.nCounter"]) as samples:
                assert {(await anext(samples)).value for _ in range(2)} == {1.5, 7}

    run(main())


def test_value_of_another_type_among_many_keeps_all_from_being_written(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            before = await plc.read("MAIN.nCounter")
            for strict in (True, False):
                with pytest.raises(IecValueError):
                    await plc.write_many(
                        {"MAIN.nCounter": before + 1, "GVL.fValue": "text"}, strict=strict
                    )
            assert await plc.read("MAIN.nCounter") == before

    run(main())


def test_arguments_of_many_are_named(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as plc:
            not_text: Any = ["MAIN.nCounter", 5]
            nothing: Any = None
            with pytest.raises(TypeError, match="the name of a symbol is text, got 5"):
                await plc.read_many(not_text)
            with pytest.raises(TypeError, match="a list of names expected, got None"):
                await plc.read_many(nothing)
            with pytest.raises(TypeError, match="a mapping of names to values expected"):
                await plc.write_many(not_text)
            with pytest.raises(ValueError, match="mode: expected 'change' or 'cycle', got 'x'"):
                plc.subscribe("MAIN.nCounter", mode="x")  # type: ignore[arg-type]
            with pytest.raises(ValueError, match=r"an AMS port is a number 0\.\.65535, got '851'"):
                plc.at_port("851")  # type: ignore[arg-type]

    run(main())
