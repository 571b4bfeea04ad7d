"""Accepting connections with both loops, with a system that has no descriptors left."""

import asyncio
import errno
import logging
import os
import socket
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from achse.ams import NetId
from achse.router import Router
from achse.transport.tcp import acceptor, idle
from achse.transport.tcp.acceptor import Acceptor
from achse.transport.tcp.listener import TcpListener


class Failing(socket.socket):
    """A listening socket whose first `left` calls of accept fail with `number`."""

    number = errno.EMFILE
    left = 0
    calls = 0

    def accept(self) -> tuple[socket.socket, Any]:
        Failing.calls += 1
        if Failing.left:
            Failing.left -= 1
            raise OSError(Failing.number, "none left")
        return super().accept()


def uvloop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    uvloop = pytest.importorskip("uvloop")
    factory: Callable[[], asyncio.AbstractEventLoop] = uvloop.new_event_loop
    return factory


@pytest.fixture(params=["asyncio", "uvloop"])
def run(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Callable[[Coroutine[Any, Any, None]], None]:
    monkeypatch.setattr(socket, "socket", Failing)
    monkeypatch.setattr(acceptor, "_RETRY", 0.0)
    Failing.calls = Failing.left = 0
    factory = uvloop_factory() if request.param == "uvloop" else asyncio.SelectorEventLoop

    def go(work: Coroutine[Any, Any, None]) -> None:
        with asyncio.Runner(loop_factory=factory) as runner:
            runner.run(work)

    return go


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM])
def test_without_descriptors_the_log_has_one_line_and_connections_wait(
    run: Any, caplog: pytest.LogCaptureFixture, number: int
) -> None:
    caplog.set_level(logging.INFO, "achse.tcp")
    Failing.number = number

    async def main() -> None:
        listener = TcpListener(Router(NetId("5.1.2.3.1.1")))
        await listener.open("127.0.0.1", 0)
        Failing.left = 5
        _, writer = await asyncio.open_connection("127.0.0.1", listener.port)
        connected = asyncio.Event()
        opened = listener.opened

        def note(peer: Any) -> None:
            opened(peer)
            connected.set()

        listener.opened = note  # type: ignore[method-assign]
        await connected.wait()
        assert (Failing.left, len(listener.connections)) == (0, 1)
        Failing.left = 3  # soon after, it is not worth another line
        connected.clear()
        _, other = await asyncio.open_connection("127.0.0.1", listener.port)
        await connected.wait()
        writer.close()
        other.close()
        await listener.close()

    run(main())
    messages = [
        each.getMessage() for each in caplog.records if "connections to" in each.getMessage()
    ]
    assert [text.split(":", 1)[1].split(" ", 1)[1] for text in messages] == [
        f"wait until some have left: {os.strerror(number)} (more: ulimit -n, or LimitNOFILE of"
        " the service)",
        "are accepted again",
    ]
    assert not [each for each in caplog.records if each.name == "asyncio"]


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE, errno.ENOBUFS])
def test_without_descriptors_idle_connections_end_and_those_in_use_stay(
    run: Any, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    """Idle connections kept everyone out until they left by themselves."""
    monkeypatch.setattr(idle, "MUTE_TIME", 0.0)
    monkeypatch.setattr(acceptor, "_SOON", 0.0)
    Failing.number = number

    async def main() -> None:
        listener = TcpListener(Router(NetId("5.1.2.3.1.1")))
        await listener.open("127.0.0.1", 0)
        connected = asyncio.Event()
        opened = listener.opened

        def note(peer: Any) -> None:
            opened(peer)
            if len(listener.connections) == 4:
                connected.set()

        listener.opened = note  # type: ignore[method-assign]
        in_use = await asyncio.open_connection("127.0.0.1", listener.port)
        in_use[1].write(bytes.fromhex("0010 02000000 0000"))  # registers a port
        await in_use[0].readexactly(14)
        mute = [await asyncio.open_connection("127.0.0.1", listener.port) for _ in range(3)]
        await connected.wait()
        Failing.left = 1
        newcomer = await asyncio.open_connection("127.0.0.1", listener.port)
        newcomer[1].write(bytes.fromhex("0210 00000000"))
        await newcomer[0].readexactly(12)
        is_closed = number != errno.ENOBUFS  # that has nothing to do with descriptors
        assert len(listener.connections) == (2 if is_closed else 5)
        for reader, _ in mute if is_closed else []:
            assert await reader.read() == b""
        in_use[1].write(bytes.fromhex("0210 00000000"))
        assert len(await in_use[0].readexactly(12)) == 12
        for _, writer in (in_use, newcomer, *mute):
            writer.close()
        await listener.close()

    run(main())


def test_while_accepting_fails_the_loop_does_not_spin(run: Any) -> None:
    async def main() -> None:
        listener = TcpListener(Router(NetId("5.1.2.3.1.1")))
        acceptor._RETRY = 3600.0  # the fixture puts it back
        await listener.open("127.0.0.1", 0)
        Failing.left = 1000
        _, writer = await asyncio.open_connection("127.0.0.1", listener.port)
        for _ in range(50):
            await asyncio.sleep(0)
        assert Failing.calls == 1
        writer.close()
        await listener.close()

    run(main())


def test_a_socket_that_cannot_listen_closes_the_others(run: Any) -> None:
    async def main() -> None:
        with socket.create_server(("127.0.0.1", 0)) as bound:
            closed = socket.socket()
            closed.close()
            with pytest.raises(OSError, match="Bad file descriptor"):
                Acceptor([bound, closed], asyncio.Protocol, 1, print, print, lambda: False)
            where = bound.getsockname()
        with pytest.raises(ConnectionRefusedError):
            await asyncio.open_connection(*where)

    run(main())
