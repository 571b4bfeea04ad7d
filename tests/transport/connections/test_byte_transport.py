"""Transports and loops of asyncio have all that a peer needs."""

import asyncio

from achse.transport.connections.byte_transport import ByteTransport, Scheduler, Timer


def test_transports_and_loops_of_asyncio_serve_a_peer() -> None:
    for needed, offered in (
        (ByteTransport, asyncio.Transport),
        (Scheduler, asyncio.AbstractEventLoop),
        (Timer, asyncio.TimerHandle),
    ):
        methods = {name for name in vars(needed) if not name.startswith("_")}
        assert methods
        assert all(callable(getattr(offered, name)) for name in methods)
