"""Scopes without asyncio: at a station that runs in another thread."""

import asyncio
import inspect
import threading
from collections.abc import Iterator

import pytest

from achse.client import blocking
from achse.client.scope import RemoteScope
from achse.client.scope_blocking import BlockingScope
from achse.station import Station


@pytest.fixture
def address() -> Iterator[str]:
    station, ready, loop = Station.demo(), threading.Event(), asyncio.new_event_loop()
    leave, where = asyncio.Event(), [""]

    async def serve() -> None:
        async with station.running("127.0.0.1", 0, speed=20) as running:
            where[0] = f"127.0.0.1:{running.tcp_port}"
            ready.set()
            await leave.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(serve()))
    thread.start()
    assert ready.wait(60)
    yield where[0]
    loop.call_soon_threadsafe(leave.set)
    thread.join()
    loop.close()


def test_it_does_what_the_other_does(address: str) -> None:
    with blocking.connect(address) as client:
        scope = client.scope("MAIN.nCounter", length=0.2, triggers="MAIN.nCounter above 1")
        with scope:
            assert scope.wait(60)["state"] == "done"
            counts = scope.data()["MAIN.nCounter"].values
            assert counts == list(range(counts[0], counts[0] + 20))
            assert scope.start()["state"] == "recording"
            assert scope.stop()["state"] == "offline"
            assert scope.facts()["number"] == scope.number
        scope = client.scope("MAIN.nCounter")
        scope.open()
        scope.start()
        assert scope.trigger()["state"] == "triggered"
        scope.close()


def test_it_has_the_methods_of_the_other() -> None:
    public = {name for name in dir(RemoteScope) if not name.startswith("_")} - {"of", "follow"}
    assert public | {"number"} == {name for name in dir(BlockingScope) if not name.startswith("_")}
    for name in public:
        theirs = inspect.signature(getattr(RemoteScope, name)).parameters
        assert list(inspect.signature(getattr(BlockingScope, name)).parameters) == list(theirs)
