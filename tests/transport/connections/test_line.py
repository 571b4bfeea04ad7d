"""What asyncio offers is what a peer needs of its line and of who calls it back."""

import asyncio

from achse.transport.connections.line import Line, Timer, Turns


def test_transports_and_loops_of_asyncio_serve_a_peer() -> None:
    for needed, offered in (
        (Line, asyncio.Transport),
        (Turns, asyncio.AbstractEventLoop),
        (Timer, asyncio.TimerHandle),
    ):
        methods = {name for name in vars(needed) if not name.startswith("_")}
        assert methods
        assert all(callable(getattr(offered, name)) for name in methods)
