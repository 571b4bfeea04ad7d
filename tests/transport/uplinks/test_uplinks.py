"""Uplinks over real loopback sockets: forwarding, limits, losses, NAT, circles, one-way routes."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from itertools import pairwise
from typing import Any

import pytest

from achse.ams import AmsAddress, Frame, NetId
from achse.router import Router
from achse.router.routes import Route
from achse.transport.tcp.listener import TcpListener
from achse.transport.uplinks import uplink as uplink_module
from achse.transport.uplinks.uplinks import Uplinks

NET_IDS = [NetId(f"5.0.0.{number}.1.1") for number in range(1, 5)]
MAX_LENGTH = 1 << 20


async def until(condition: Callable[[], object]) -> None:
    """Give the loop turns until the condition holds."""
    while not condition():  # noqa: ASYNC110 - sockets tell nobody
        await asyncio.sleep(0.001)


class Device:
    """Answers each request with its data; tells the frames it got."""

    def __init__(self, router: Router) -> None:
        self.router = router
        self.frames: asyncio.Queue[Frame] = asyncio.Queue()

    def deliver(self, frame: Frame) -> bool:
        self.frames.put_nowait(frame)
        if not frame.is_response and frame.command != 8:
            self.router.deliver(frame.reply(b"from " + frame.target[:6]))
        return True


class Client:
    """A port on a router that asks and waits for one answer."""

    def __init__(self, router: Router) -> None:
        self.router = router
        self.frames: asyncio.Queue[Frame] = asyncio.Queue()
        self.address = router.register(0, self)

    def deliver(self, frame: Frame) -> bool:
        self.frames.put_nowait(frame)
        return True

    def send(self, net_id: NetId, data: bytes = b"", *, flags: int = 4, invoke_id: int = 1) -> None:
        frame = Frame(
            AmsAddress.of(net_id, 851), self.address, 2, flags, invoke_id=invoke_id, data=data
        )
        frame.origin = self
        self.router.deliver(frame)

    async def ask(self, net_id: NetId, data: bytes = b"") -> Frame:
        self.send(net_id, data)
        return await self.frames.get()


class Host:
    """A router with a listener, a device on port 851 and its uplinks."""

    def __init__(self, net_id: NetId, **settings: Any) -> None:
        self.router = Router(net_id)
        self.device = Device(self.router)
        self.router.register(851, self.device)
        self.listener = TcpListener(self.router, **settings)
        self.uplinks = Uplinks(self.router, local_host="127.0.0.1", max_length=MAX_LENGTH)

    async def start(self) -> None:
        await self.listener.open(port=0)
        self.uplinks.start()

    async def stop(self) -> None:
        await self.uplinks.close()
        await self.listener.close()

    def leads(self, net_id: NetId, to: "Host", **more: Any) -> None:
        self.router.routes.add(
            Route(name=f"to {net_id}", net_id=net_id, host=f"127.0.0.1:{to.listener.port}", **more)
        )


@asynccontextmanager
async def hosts(count: int, **settings: Any) -> AsyncIterator[list[Host]]:
    running = [Host(net_id, **settings) for net_id in NET_IDS[:count]]
    for host in running:
        await host.start()
    try:
        yield running
    finally:
        for host in running:
            await host.stop()


async def test_a_request_goes_over_several_routers_and_its_answer_comes_back() -> None:
    async with hosts(4) as chain:
        for here, there in pairwise(chain):
            here.leads(NET_IDS[3], there)
        client = Client(chain[0].router)
        answer = await client.ask(NET_IDS[3], b"x")
        assert answer.data == b"from " + NET_IDS[3]
        assert (answer.source, answer.error) == (AmsAddress.of(NET_IDS[3], 851), 0)
        # a notification takes the same way
        request = chain[3].device.frames.get_nowait()
        sample = Frame(request.source, request.target, 8, 4, data=b"sample")
        sample.via = request.origin
        chain[3].router.deliver(sample)
        assert (await client.frames.get()).data == b"sample"


async def test_what_no_router_on_the_way_knows_is_answered_0x7() -> None:
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[3], there)
        answer = await Client(here.router).ask(NET_IDS[3])
        assert (answer.error, answer.data) == (0x7, b"")


async def test_requests_that_go_in_circles_end_with_0x7(caplog: pytest.LogCaptureFixture) -> None:
    async with hosts(3) as (one, two, three):
        for here, there in ((one, two), (two, three), (three, one)):
            here.leads(NET_IDS[3], there)
        client = Client(one.router)
        answer = await client.ask(NET_IDS[3])
        assert answer.error == 0x7
        assert "go in circles" in caplog.text
        client.send(NET_IDS[3], flags=6)
        await until(lambda: two.router.lost_frames)
        assert [host.router.lost_frames for host in (one, two, three)] == [0, 1, 0]
        assert client.frames.empty()


async def test_answers_and_samples_that_no_client_requested_do_not_circle_either() -> None:
    """The way to the address was learned from the refusals of a request that went round."""
    async with hosts(3) as ring:
        for here, there in pairwise((*ring, ring[0])):
            here.leads(NET_IDS[3], there)
        assert (await Client(ring[0].router).ask(NET_IDS[3])).error == 0x7
        assert ring[0].router.reaches(AmsAddress.of(NET_IDS[3], 851))
        _, writer = await asyncio.open_connection("127.0.0.1", ring[0].listener.port)
        stranger = AmsAddress("9.9.9.9.1.1:7")
        for command, flags in ((2, 5), (8, 4), (8, 5), (77, 5)):
            stray = Frame(AmsAddress.of(NET_IDS[3], 851), stranger, command, flags)
            writer.write(stray.encode_tcp())
        await until(lambda: ring[0].router.lost_frames == 4)
        assert [host.router.lost_frames for host in ring] == [4, 0, 0]
        writer.close()
        await writer.wait_closed()


async def test_samples_pass_two_routers_to_a_client_that_was_answered() -> None:
    async with hosts(3) as (one, two, three):
        one.leads(NET_IDS[2], two)
        two.leads(NET_IDS[2], three)
        client = Client(one.router)
        await client.ask(NET_IDS[2])
        server = AmsAddress.of(NET_IDS[2], 851)
        three.router.deliver(Frame(client.address, server, 8, 4, data=b"sample"))
        assert (await client.frames.get()).data == b"sample"
        three.router.deliver(Frame(client.address, server, 2, 5, invoke_id=99, data=b"late"))
        assert (await client.frames.get()).data == b"late"


async def test_two_routers_that_name_each_other_bounce_nothing() -> None:
    async with hosts(2) as (one, two):
        one.leads(NET_IDS[3], two)
        two.leads(NET_IDS[3], one)
        assert (await Client(one.router).ask(NET_IDS[3])).error == 0x7
        stray = Frame(AmsAddress.of(NET_IDS[3], 30000), AmsAddress.of(NET_IDS[0], 851), 2, 5)
        one.router.deliver(stray)  # made here: goes out once, and no further
        await until(lambda: two.router.lost_frames)
        assert [host.router.lost_frames for host in (one, two)] == [0, 1]


async def test_a_host_that_is_not_there_is_0x1b_at_once_until_the_next_attempt(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[1], there)
        await there.listener.close()
        client = Client(here.router)
        for _ in range(3):
            assert (await client.ask(NET_IDS[1])).error == 0x1B
        assert caplog.text.count("cannot be reached") == 1


async def test_an_uplink_connects_again_after_a_loss() -> None:
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[1], there)
        client = Client(here.router)
        assert (await client.ask(NET_IDS[1])).error == 0
        [connection] = there.listener.connections
        connection.abort()
        [uplink] = here.uplinks
        await until(lambda: not uplink.connected)
        assert not here.router.reaches(AmsAddress.of(NET_IDS[1], 1))
        await until(lambda: uplink.connected)
        assert here.router.reaches(AmsAddress.of(NET_IDS[1], 1))
        assert (await client.ask(NET_IDS[1])).error == 0


async def test_a_peer_that_does_not_read_fills_the_mailbox(monkeypatch: Any) -> None:
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[1], there)
        client = Client(here.router)
        assert (await client.ask(NET_IDS[1])).error == 0
        [uplink] = here.uplinks
        monkeypatch.setattr(type(uplink._connection), "congested", True)
        assert (await client.ask(NET_IDS[1], bytes(1 << 13))).error == 0x502
        assert (await client.ask(NET_IDS[1])).error == 0  # it waits for nothing else


async def test_packets_beyond_the_largest_fragment_are_refused() -> None:
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[1], there, max_fragment=100)
        client = Client(here.router)
        assert (await client.ask(NET_IDS[1], bytes(68))).error == 0
        assert (await client.ask(NET_IDS[1], bytes(69))).error == 0x1C


async def test_behind_nat_a_router_keeps_its_own_net_id() -> None:
    async with hosts(2) as (here, there):
        virtual = NetId("6.6.6.6.1.1")
        here.leads(virtual, there, nat_net_id=NET_IDS[1])
        client = Client(here.router)
        answer = await client.ask(virtual)
        assert answer.source == AmsAddress.of(virtual, 851)
        request_frame = there.device.frames.get_nowait()
        assert request_frame.target == AmsAddress.of(NET_IDS[1], 851)
        # and asks us by the same connection
        there.router.learn(client.address, next(iter(there.listener.connections)))
        request = Frame(AmsAddress.of(NET_IDS[0], 851), AmsAddress.of(NET_IDS[1], 40000), 2)
        next(iter(there.listener.connections)).deliver(request)
        seen = await here.device.frames.get()
        assert seen.source == AmsAddress.of(virtual, 40000)


async def test_requests_from_the_far_end_of_a_one_way_route_are_refused() -> None:
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[1], there)
        there.leads(NET_IDS[0], here, one_way=True)
        assert (await Client(here.router).ask(NET_IDS[1])).error == 0x723
        assert (await Client(there.router).ask(NET_IDS[0])).error == 0


async def test_where_routes_are_required_a_stranger_learns_how_to_get_one(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with hosts(2, routes_required=True) as (here, there):
        here.leads(NET_IDS[1], there)
        client = Client(here.router)
        assert (await client.ask(NET_IDS[1])).error == 0x1B
        assert "client 5.0.0.1.1.1 from 127.0.0.1 has no route here; add it with" in caplog.text
        there.leads(NET_IDS[0], here)
        [uplink] = here.uplinks
        await until(lambda: not uplink.connected)
        await until(lambda: uplink.connected)
        assert (await client.ask(NET_IDS[1])).error == 0


async def test_our_own_net_id_admits_no_client_from_elsewhere(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with hosts(2, routes_required=True) as (here, there):
        monkeypatch.setattr(there.listener, "serves_ports", lambda host: False)
        here.leads(NET_IDS[1], there)
        spoof = Frame(AmsAddress.of(NET_IDS[1], 851), AmsAddress.of(NET_IDS[1], 40000), 2)
        here.router.deliver(spoof)
        await until(lambda: "no route here" in caplog.text)
        assert there.device.frames.empty()


async def test_routes_that_come_and_go_are_followed() -> None:
    async with hosts(2) as (here, there):
        client = Client(here.router)
        assert (await client.ask(NET_IDS[1])).error == 0x7
        here.leads(NET_IDS[1], there)
        assert (await client.ask(NET_IDS[1])).error == 0
        here.router.routes.remove(f"to {NET_IDS[1]}")
        assert (await client.ask(NET_IDS[1])).error == 0x7
        await until(lambda: not there.listener.connections)


async def test_a_route_that_goes_while_it_is_dialled_leaves_nothing() -> None:
    async with hosts(1) as (here,):
        tasks = len(asyncio.all_tasks())
        route = Route(name="slow", net_id=NET_IDS[1], host="192.0.2.1")
        here.router.routes.add(route)
        client = Client(here.router)
        client.send(NET_IDS[1])
        here.router.routes.remove("slow")
        assert client.frames.get_nowait().error in (0x1B, 0x7)
        await until(lambda: len(asyncio.all_tasks()) == tasks)


async def test_an_idle_uplink_is_not_dialled_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uplink_module, "_IDLE", 0.0)
    monkeypatch.setattr(uplink_module, "_FIRST_PAUSE", 0.0)
    async with hosts(2) as (here, there):
        here.leads(NET_IDS[1], there)
        assert (await Client(here.router).ask(NET_IDS[1])).error == 0
        next(iter(there.listener.connections)).abort()
        [uplink] = here.uplinks
        await until(lambda: not uplink.connected)
        assert uplink._retry is None
        assert (await Client(here.router).ask(NET_IDS[1])).error == 0


def test_a_lost_route_is_a_warning_its_return_is_not(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)

    async def lose() -> None:
        async with hosts(2) as (here, there):
            here.leads(NET_IDS[1], there)
            await Client(here.router).ask(NET_IDS[1])
            next(iter(there.listener.connections)).abort()
            [uplink] = here.uplinks
            await until(lambda: not uplink.connected)

    asyncio.run(lose())
    levels = {record.getMessage().split(": ")[1][:9]: record.levelname for record in caplog.records
              if record.name == "achse.uplink"}  # fmt: skip
    assert levels == {"connected": "INFO", "connectio": "WARNING"}
