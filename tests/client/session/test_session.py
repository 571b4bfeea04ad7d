"""A session: time-outs, cancellation, loss and reconnection, closing."""

import asyncio
import socket
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import AmsAddress, ConnectionLost, Frame, RequestTimeout
from achse.client import blocking
from achse.client.session.session import Backoff, Session
from achse.client.session.subscription import Subscription
from achse.client.target import Target

Run = Callable[[Any], Any]
PLC = AmsAddress("5.4.3.2.1.1:851")
READ = b"\x20\x40\0\0\0\0\0\0\4\0\0\0"


def now() -> float:
    return asyncio.get_running_loop().time()


async def opened(peer: Any, **options: Any) -> Session:
    session = Session(peer, **options)
    await session.open()
    return session


def test_the_pauses_grow_up_to_a_limit() -> None:
    pauses = Backoff(0.1, 1.0, 2.0).pauses()
    assert [round(next(pauses), 3) for _ in range(6)] == [0.1, 0.2, 0.4, 0.8, 1.0, 1.0]


def test_no_answer_is_a_time_out_at_the_deadline(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        peer.mute = True
        slow = asyncio.create_task(session.exchange(PLC, 2, READ, 3.0))
        await asyncio.sleep(0.5)
        with pytest.raises(RequestTimeout) as caught:
            await session.exchange(PLC, 2, READ, 0.25)
        assert now() == pytest.approx(0.75)
        assert caught.value.code == 0x745
        assert "read 4 bytes at 0x4020:0x0 of 5.4.3.2.1.1:851" in str(caught.value)
        with pytest.raises(RequestTimeout):
            await slow
        assert now() == pytest.approx(3.0)
        peer.mute = False
        await session.exchange(PLC, 2, READ, 1.0)
        await session.close()

    run(main())


def test_a_late_answer_disturbs_no_other(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        frames: list[Frame] = []
        reply = peer.reply
        peer.reply = frames.append
        with pytest.raises(RequestTimeout):
            await session.exchange(PLC, 2, READ, 0.1)
        peer.reply = reply
        reply(frames[0])
        assert session.requests.unasked == 1
        assert (await session.exchange(PLC, 2, READ, 1.0)).data[8:] == b"\1\2\3\4"
        await session.close()

    run(main())


def test_a_cancelled_request_leaves_nothing_behind(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        peer.mute = True
        task = asyncio.create_task(session.exchange(PLC, 2, READ, 1.0))
        await asyncio.sleep(0.1)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        await asyncio.sleep(1.0)
        assert len(session.requests) == 0
        await session.close()

    run(main())


def test_a_loss_fails_what_is_under_way_and_dials_again(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer, backoff=Backoff(0.5, 10.0))
        peer.mute = True
        task = asyncio.create_task(session.exchange(PLC, 2, READ, 5.0))
        await asyncio.sleep(0.1)
        peer.refuse_dials = 2
        peer.lose()
        with pytest.raises(ConnectionLost, match=r"read 4 bytes .* lost: cut"):
            await task
        peer.mute = False
        response = await session.exchange(PLC, 2, READ, 5.0)
        assert response.data[8:] == b"\1\2\3\4"
        assert now() == pytest.approx(0.1 + 0.5 + 1.0 + 2.0)
        assert (peer.dials, session.losses) == (4, 1)
        assert AmsAddress(response.target).port == 40004
        await session.close()

    run(main())


def test_a_request_waits_for_the_next_link_only_so_long(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        peer.refuse_dials = 100
        peer.lose()
        await asyncio.sleep(0)
        with pytest.raises(ConnectionLost, match=r"within 2 s: .*nobody there"):
            await session.exchange(PLC, 2, READ, 2.0)
        assert now() == pytest.approx(2.0)
        await session.close()

    run(main())


def test_without_reconnection_a_loss_is_final(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer, backoff=None)
        peer.lose()
        await asyncio.sleep(1)
        assert session.closed
        with pytest.raises(ConnectionLost, match="over: cut"):
            await session.exchange(PLC, 2, READ, 2.0)
        assert peer.dials == 1

    run(main())


def test_a_peer_that_refuses_the_first_dial_is_an_error(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.refuse_dials = 1
        with pytest.raises(ConnectionLost, match="cannot connect to peer: nobody there"):
            await opened(peer)

    run(main())


def test_a_peer_that_never_answers_the_dial_is_an_error(run: Run, peer: Any) -> None:
    async def main() -> None:
        async def forever(user: Any) -> Any:
            await asyncio.sleep(3600)

        peer.open = forever
        with pytest.raises(ConnectionLost, match="did not answer within 2 s"):
            await opened(peer, timeout=2.0)
        assert now() == pytest.approx(2.0)

    run(main())


def test_closing_fails_requests_and_is_final(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        peer.mute = True
        task = asyncio.create_task(session.exchange(PLC, 2, READ, 5.0))
        await asyncio.sleep(0.1)
        await session.close()
        await session.close()
        with pytest.raises(ConnectionLost, match="closed"):
            await task
        with pytest.raises(ConnectionLost, match="over: closed"):
            await session.exchange(PLC, 2, READ, 5.0)
        assert peer.link is None

    run(main())


def test_closing_while_dialling_again_ends_that_too(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        peer.refuse_dials = 100
        peer.lose()
        await asyncio.sleep(1)
        await session.close()
        dials = peer.dials
        await asyncio.sleep(100)
        assert peer.dials == dials

    run(main())


def test_a_full_link_holds_requests_back(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        session.buffer_changed(peer.link, True)
        with pytest.raises(RequestTimeout, match="takes no more"):
            await session.exchange(PLC, 2, READ, 1.0)
        task = asyncio.create_task(session.exchange(PLC, 2, READ, 1.0))
        await asyncio.sleep(0.5)
        assert peer.requests == []
        session.buffer_changed(peer.link, False)
        await task
        await session.close()

    run(main())


class Heard:
    """A listener and renewable that writes down what happens to it."""

    target = PLC

    def __init__(self) -> None:
        self.log: list[Any] = []

    def feed(self, filetime: int, data: bytes) -> None:
        self.log.append(data)

    def interrupt(self) -> None:
        self.log.append("interrupt")

    def renew(self) -> None:
        self.log.append("renew")

    def symbols_changed(self) -> None:
        self.log.append("symbols")

    async def leave(self) -> None:
        self.log.append("part")

    def end(self, error: Exception | None) -> None:
        self.log.append(error)


def test_samples_go_to_their_listeners(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        one, two = Heard(), Heard()
        session.listen(PLC, 1, one)
        session.listen(PLC, 2, two)
        peer.push((1, b"a"), (2, b"b"), (1, b"c"))
        assert (one.log, two.log) == ([b"a", b"c"], [b"b"])
        await session.close()

    run(main())


def test_samples_no_client_listens_to_are_ended_once(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        for _ in range(3):
            peer.push((9, b"stale"))
        await asyncio.sleep(1)
        assert [request.handle for request in peer.requests] == [9]
        await session.close()

    run(main())


def test_samples_that_come_as_a_response_are_samples(run: Run, peer: Any) -> None:
    class Listener:
        heard: list[bytes] = []  # noqa: RUF012

        def feed(self, filetime: int, data: bytes) -> None:
            self.heard.append(data)

    async def main() -> None:
        session = await opened(peer)
        session.listen(bytes(PLC), 9, Listener())
        peer.push((9, b"a"), flags=0x0005)
        peer.push((9, b"b"), flags=0x0004)
        assert Listener.heard == [b"a", b"b"]
        assert session.requests.unasked == 0
        await session.close()

    run(main())


@pytest.mark.parametrize(("command", "flags"), [(2, 5), (2, 4), (9, 0)])
def test_what_no_client_waits_for_is_dropped_and_reported_once(
    run: Run, peer: Any, caplog: pytest.LogCaptureFixture, command: int, flags: int
) -> None:
    async def main() -> None:
        session = await opened(peer)
        for _ in range(3):
            session.received(Frame(bytes(8), PLC, command, flags, invoke_id=77))
        await session.exchange(PLC, 2, READ, 1.0)
        await session.close()

    with caplog.at_level("INFO", "achse.client"):
        run(main())
    assert sum("dropping" in record.getMessage() for record in caplog.records) == 1


def test_a_notification_that_is_none_is_dropped(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer)
        session.received(Frame(bytes(8), PLC, 8, 4, data=b"\1\2\3"))
        await session.exchange(PLC, 2, READ, 1.0)
        await session.close()

    run(main())


def test_renewables_hear_of_loss_return_and_end(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer, keep_alive=None)
        heard, dropped = Heard(), Heard()
        session.keep(heard)
        session.keep(dropped)
        session.drop(dropped)
        peer.lose()
        await asyncio.sleep(1)
        assert heard.log == ["interrupt", "renew"]
        await session.leave()
        await session.close()
        assert heard.log == ["interrupt", "renew", "part", None]
        assert dropped.log == []

    run(main())


def test_a_silent_target_with_subscriptions_is_dialled_again(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer, keep_alive=10.0, timeout=2.0)
        heard = Heard()
        session.keep(heard)
        await asyncio.sleep(25)
        assert len(peer.requests) == 2
        peer.mute = True
        await asyncio.sleep(8)
        peer.mute = False
        assert heard.log == ["interrupt", "renew"]
        assert session.losses == 1
        session.drop(heard)
        count = len(peer.requests)
        await asyncio.sleep(100)
        assert len(peer.requests) == count
        await session.close()

    run(main())


def test_a_target_that_left_is_renewed_without_dialling(run: Run, peer: Any) -> None:
    async def main() -> None:
        session = await opened(peer, keep_alive=10.0)
        heard = Heard()
        session.keep(heard)
        peer.error = 6
        await asyncio.sleep(11)
        assert heard.log == ["interrupt", "renew"]
        assert peer.dials == 1
        await session.close()

    run(main())


def test_where_no_client_listens_it_says_what_to_do() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        free = server.getsockname()[1]
    with pytest.raises(ConnectionLost, match="start a station with `achse run --detach`"):
        blocking.connect(f"127.0.0.1:{free}").__enter__()


def test_session_of_another_event_loop_is_refused(run: Run, peer: Any) -> None:
    async def set_up() -> tuple[Target, Subscription]:
        target = Target(await opened(peer, keep_alive=None), PLC, 5.0, {})
        samples = await target.subscribe_as(0x4020, 0, 4).__aenter__()
        await anext(samples)
        return target, samples

    target, samples = run(set_up())

    async def elsewhere() -> None:
        for job in (
            target.state(),
            target.read("MAIN.nCounter"),
            target.read_many(["MAIN.nCounter"]),
            target.subscribe_as(0x4020, 0, 4).__aenter__(),
            anext(samples),
        ):
            with pytest.raises(RuntimeError, match="another event loop"):
                await job

    asyncio.run(elsewhere())
    run(target.session.close())
