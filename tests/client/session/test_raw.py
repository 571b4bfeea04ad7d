"""Raw access: commands, errors, many at once."""

import asyncio
import struct
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from achse.ams import AdsState, AmsAddress, DecodeError, DeviceError, RouterError
from achse.ams.commands import ReadRequest, ReadWriteRequest, WriteRequest
from achse.client.session.raw import DeviceInfo, RawTarget
from achse.client.session.session import Session
from achse.client.session.sums import Outcome

Run = Callable[[Any], Any]


@asynccontextmanager
async def target_of(peer: Any) -> AsyncIterator[RawTarget]:
    session = Session(peer, keep_alive=None)
    await session.open()
    try:
        yield RawTarget(session, AmsAddress("5.4.3.2.1.1:851"), 5.0)
    finally:
        await session.close()


def test_device_info_state_and_control(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            assert await target.device_info() == DeviceInfo("Scripted", 3, 1, 4024)
            assert await target.state() == (AdsState.RUN, 0)
            await target.write_control(AdsState.STOP)
            state = await target.state()
            assert state.ads_state is AdsState.STOP
            await target.write_control(77, 3)
            assert await target.state() == (77, 3)

    run(main())


def test_a_device_name_that_is_cut_short_is_understood(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:

            def cut(frame: Any, reply: Any = peer.reply) -> None:
                frame.data = frame.data.rstrip(b"\0")
                reply(frame)

            peer.reply = cut
            assert (await target.device_info()).name == "Scripted"

    run(main())


def test_raw_bytes_go_out_and_come_in(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            assert await target.read_raw(0x4020, 0, 2) == b"\1\2"
            await target.write_raw(0x4020, 0, b"new")
            assert await target.read_raw(0x4020, 0, 100) == b"new"
            handle = await target.read_write_raw(0xF003, 0, 4, b"main.ncounter\0")
            assert await target.read_raw(0xF005, int.from_bytes(handle, "little"), 4) == b"\7\0\0\0"

    run(main())


def test_a_refusal_carries_code_and_request(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            with pytest.raises(DeviceError) as caught:
                await target.read_raw(0x1234, 0x10, 4)
            assert caught.value.code == 0x702
            assert "read 0x1234:0x10 of 5.4.3.2.1.1:851" in str(caught.value)
            with pytest.raises(DeviceError, match="write 0x1:0x2"):
                await target.write_raw(1, 2, b"x")
            with pytest.raises(DeviceError, match="read/write 0x1:0x2"):
                await target.read_write_raw(1, 2, 4, b"x")

    run(main())


def test_a_router_error_is_one_of_its_own(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.error = 6
        async with target_of(peer) as target:
            with pytest.raises(RouterError) as caught:
                await target.read_raw(1, 2, 4)
            assert caught.value.code == 6
            assert "read 4 bytes at 0x1:0x2" in str(caught.value)
            with pytest.raises(RouterError):
                await target.send_each([ReadRequest(1, 2, 4)])

    run(main())


@pytest.mark.parametrize("payload", [b"", b"\0\0\0", b"\0\0\0\0", b"\0\0\0\0\5\0\0\0a"])
def test_a_response_that_is_none_is_a_decode_error(run: Run, peer: Any, payload: bytes) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            reply: Any = peer.reply
            peer.reply = lambda frame: reply(
                frame.__class__(
                    frame.target,
                    frame.source,
                    frame.command,
                    frame.flags,
                    0,
                    frame.invoke_id,
                    payload,
                )
            )
            with pytest.raises(DecodeError, match="read 0x4020:0x0"):
                await target.read_raw(0x4020, 0, 4)

    run(main())


def test_an_error_answer_of_four_bytes_is_understood(run: Run, peer: Any) -> None:
    """TwinCAT 2 devices answer the bare result."""

    async def main() -> None:
        async with target_of(peer) as target:

            def cut(frame: Any, reply: Any = peer.reply) -> None:
                frame.data = frame.data[:4]
                reply(frame)

            peer.reply = cut
            with pytest.raises(DeviceError) as caught:
                await target.read_raw(1, 2, 4)
            assert caught.value.code == 0x702

    run(main())


def test_many_requests_run_at_the_same_time(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.raw |= {(1, n): struct.pack("<I", n) for n in range(1000)}
        async with target_of(peer) as target:
            reads = [target.read_raw(1, n, 4) for n in range(1000)]
            answers = await asyncio.gather(*reads)
            assert [struct.unpack("<I", answer)[0] for answer in answers] == list(range(1000))

    run(main())


def test_a_single_part_travels_alone_and_several_in_sums_of_500(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.raw |= {(1, n): bytes([n % 256]) for n in range(501)}
        async with target_of(peer) as target:
            assert await target.send_each([ReadRequest(1, 3, 1)]) == [Outcome(0, b"\3")]
            assert len(peer.requests_of(ReadRequest)) == 1
            parts = [ReadRequest(1, n, 1) for n in range(501)] + [ReadRequest(2, 0, 1)]
            outcomes = await target.send_each(parts)
            assert outcomes == [Outcome(0, bytes([n % 256])) for n in range(501)] + [
                Outcome(0x702, b"")
            ]
            assert [r.index_offset for r in peer.requests_of(ReadWriteRequest, 0xF080)] == [500, 2]
            assert await target.send_each([]) == []

    run(main())


def test_without_sums_parts_go_one_by_one_from_then_on(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.not_offered = {0xF080, 0xF081}
        peer.raw |= {(1, n): bytes([n]) for n in range(3)}
        async with target_of(peer) as target:
            parts = [ReadRequest(1, n, 1) for n in range(3)] + [ReadRequest(2, 0, 1)]
            for _ in range(2):
                outcomes = await target.send_each(parts)
                assert outcomes[:3] == [Outcome(0, bytes([n])) for n in range(3)]
                assert outcomes[3].result == 0x702
            assert len(peer.requests_of(ReadWriteRequest, 0xF080)) == 1
            await target.send_each([WriteRequest(1, n, b"w") for n in range(2)])
            assert peer.raw[1, 1] == b"w"

    run(main())


def test_a_sum_refused_for_another_reason_is_an_error(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:

            def busy(*arguments: Any) -> bytes:
                raise DeviceError(0x708)

            peer.read_write = busy
            with pytest.raises(DeviceError) as caught:
                await target.send_each([ReadRequest(1, 0, 1)] * 2)
            assert caught.value.code == 0x708

    run(main())


def test_numbers_and_data_that_fit_no_request_are_named(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            for job, message in (
                (target.read_raw(0x4020, 0, -1), r"0\.\.0xFFFFFFFF.*length=-1"),
                (target.read_raw(2**32, 0, 1), "index_group=4294967296"),
                (target.write_raw(0x4020, 0, "text"), "data='text'"),  # type: ignore[arg-type]
                (target.read_write_raw(0, 0, 1, 5), "data=5"),  # type: ignore[arg-type]
                (target.write_control("RUN"), r"0\.\.0xFFFF,.*'RUN'"),  # type: ignore[arg-type]
            ):
                with pytest.raises(ValueError, match=message):
                    await job

    run(main())
