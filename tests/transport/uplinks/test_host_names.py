"""Host names of routes: looked up beside the loop, again when asked for, never waited for."""

import asyncio
import threading
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import pytest

from achse.ams import NetId
from achse.router.routes import Admission, Route, RouteTable
from achse.transport.uplinks import host_names
from achse.transport.uplinks.host_names import HostNames, addresses_of

FOREVER = 3600.0
"""Seconds: more than the guard of the run gives a test."""

MILL = Route(name="mill", net_id=NetId("5.1.2.4.1.1"), host="mill.local")


class Names:
    """What names mean, and how often it was asked."""

    def __init__(self, **addresses: Sequence[str]) -> None:
        self.addresses = {
            name.replace("_", "."): addresses_ for name, addresses_ in addresses.items()
        }
        self.lookups: list[str] = []
        self.answers = threading.Event()
        self.answers.set()

    def __call__(self, name: str) -> Sequence[str]:
        self.answers.wait(60)
        self.lookups.append(name)
        return self.addresses.get(name, ())


@asynccontextmanager
async def looking_up(routes: RouteTable, names: Names) -> AsyncIterator[HostNames]:
    looked_up = HostNames(routes, names)
    looked_up.start()
    try:
        yield looked_up
    finally:
        looked_up.close()
        names.answers.set()


async def test_names_are_known_from_the_start_and_when_routes_come() -> None:
    routes, names = RouteTable([MILL]), Names(mill_local=["10.0.0.3"], press=["10.0.0.4"])
    async with looking_up(routes, names) as looked_up:
        await looked_up.known(FOREVER)
        assert routes.admission(MILL.net_id, "10.0.0.3") is Admission.ROUTED
        press = Route(name="press", net_id=NetId("5.1.2.5.1.1"), host="Press:48000")
        routes.add(press)
        await looked_up.known(FOREVER)
        assert routes.admission(press.net_id, "10.0.0.4") is Admission.ROUTED
        assert routes.admission(press.net_id, "10.0.0.3") is Admission.UNKNOWN
    assert names.lookups[:2] == ["mill.local", "press"]


async def test_a_name_that_means_something_else_by_now_is_looked_up_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(host_names, "_SOONEST", 0.0)
    routes, names = RouteTable([MILL]), Names(mill_local=["10.0.0.3"])
    async with looking_up(routes, names) as looked_up:
        await looked_up.known(FOREVER)
        names.addresses["mill.local"] = ["10.0.0.9"]
        while routes.admission(MILL.net_id, "10.0.0.9") is Admission.UNKNOWN:  # noqa: ASYNC110
            await asyncio.sleep(0.001)
        assert routes.admission(MILL.net_id, "10.0.0.3") is Admission.UNKNOWN


async def test_who_comes_from_elsewhere_makes_few_look_ups() -> None:
    routes, names = RouteTable([MILL]), Names(mill_local=["10.0.0.3"])
    async with looking_up(routes, names) as looked_up:
        await looked_up.known(FOREVER)
        for _ in range(1000):
            routes.admission(MILL.net_id, "10.0.0.9")
        await asyncio.sleep(0)
        assert len(names.lookups) <= 2


async def test_a_look_up_that_hangs_delays_no_other() -> None:
    routes, names = RouteTable([MILL]), Names(mill_local=["10.0.0.3"])
    names.answers.clear()
    async with looking_up(routes, names) as looked_up:
        await looked_up.known(0.001)
        assert routes.admission(MILL.net_id, "10.0.0.3") is Admission.UNKNOWN


async def test_an_unknown_name_is_reported_and_admits_no_client(
    caplog: pytest.LogCaptureFixture,
) -> None:
    routes = RouteTable([MILL])
    async with looking_up(routes, Names()) as looked_up:
        await looked_up.known(FOREVER)
    assert "host mill.local of a route is unknown: its senders are refused" in caplog.text
    assert routes.admission(MILL.net_id, "10.0.0.3") is Admission.UNKNOWN


async def test_a_route_that_is_gone_is_looked_up_no_more() -> None:
    routes, names = RouteTable([MILL]), Names(mill_local=["10.0.0.3"])
    names.answers.clear()
    async with looking_up(routes, names) as looked_up:
        routes.remove("mill")
        names.answers.set()
        await looked_up.known(FOREVER)
        assert routes.host_names == set()
    routes.add(MILL)
    assert routes.admission(MILL.net_id, "10.0.0.3") is Admission.UNKNOWN


def test_names_of_this_computer_have_addresses_others_none() -> None:
    assert "127.0.0.1" in addresses_of("localhost")
    assert addresses_of("no.such.host.invalid") == ()
    assert addresses_of("a" * 300 + ".b") == ()


async def test_names_are_looked_up_again_every_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    assert host_names._AGAIN == 60.0
    monkeypatch.setattr(host_names, "_AGAIN", 0.001)
    routes, names = RouteTable([MILL]), Names(mill_local=["10.0.0.3"])
    async with looking_up(routes, names) as looked_up:
        await looked_up.known(FOREVER)
        names.addresses["mill.local"] = ["10.0.0.9"]
        while len(names.lookups) < 5:  # noqa: ASYNC110
            await asyncio.sleep(0.001)
        await asyncio.sleep(0)
        assert routes.admission(MILL.net_id, "10.0.0.9") is Admission.ROUTED
