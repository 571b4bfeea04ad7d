"""`connect`: where it dials, what it gives, and how it ends."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

import achse
from achse.ams import AmsAddress, ConnectionLost, NetId, RouterError
from achse.ams.commands import DeleteNotificationRequest
from achse.client import Backoff, Client
from achse.client import client as module
from achse.client.client import connect
from achse.client.links.link import RouterDialer, TcpDialer
from achse.router import Router
from achse.transport.tcp.listener import TcpListener

Run = Callable[[Any], Any]


def dialer_of(*arguments: Any, **options: Any) -> TcpDialer:
    dialer = connect(*arguments, **options)._dialer
    assert isinstance(dialer, TcpDialer)
    return dialer


@pytest.mark.parametrize(
    ("host", "peer"),
    [
        ("plc", "plc:48898"),
        ("10.0.0.1:48899", "10.0.0.1:48899"),
        ("fe80::1", "[fe80::1]:48898"),
        ("[fe80::1]:5000", "[fe80::1]:5000"),
        ("[::1]", "[::1]:48898"),
    ],
)
def test_a_host_may_name_its_tcp_port(host: str, peer: str) -> None:
    assert dialer_of(host).peer == peer


@pytest.mark.parametrize("host", ["plc:", "plc:x", "plc:0", "plc:65536", "plc:\u0665"])
def test_a_tcp_port_that_is_none_is_refused(host: str) -> None:
    with pytest.raises(ValueError, match=r"1\.\.65535"):
        connect(host)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"host": 5}, "host: expected the name of a host, got 5"),
        ({"host": b"plc"}, "host: expected the name of a host, got b'plc'"),
        ({"host": ""}, "host: expected NAME.*got ''"),
        ({"host": "tcp://plc"}, "host: expected NAME, NAME:TCP_PORT, or .* got 'tcp://plc'"),
        ({"host": "plc", "net_id": 5}, "a NetId is text like '5.1.2.3.1.1' or 6 bytes, got 5"),
        ({"host": "plc", "mode": "udp"}, "mode: expected one of 'auto', .* got 'udp'"),
        ({"timeout": None}, "timeout: expected a number of seconds above 0, got None"),
        ({"timeout": "5"}, "timeout: expected .* got '5'"),
        ({"timeout": 0}, "timeout: expected .* got 0"),
        ({"keep_alive": 0}, "keep_alive: expected a number of seconds above 0, got 0"),
        ({"keep_alive": -3}, "keep_alive: expected .* got -3"),
    ],
)
def test_argument_of_another_kind_is_named_at_once(options: dict[str, Any], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        connect(**options)


def test_without_a_host_the_environment_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ACHSE_HOST", raising=False)
    monkeypatch.delenv("ACHSE_TCP_PORT", raising=False)
    assert dialer_of().peer == "127.0.0.1:48898"
    monkeypatch.setenv("ACHSE_HOST", "127.0.9.9")
    monkeypatch.setenv("ACHSE_TCP_PORT", "5000")
    assert dialer_of().peer == "127.0.9.9:5000"
    monkeypatch.setenv("ACHSE_HOST", "127.0.9.9:6000")
    assert dialer_of().peer == "127.0.9.9:6000"
    monkeypatch.setenv("ACHSE_TCP_PORT", "port")
    with pytest.raises(ValueError, match=r"ACHSE_TCP_PORT: a TCP port is 1\.\.65535, got 'port'"):
        connect()


def test_a_source_means_direct_mode() -> None:
    dialer = dialer_of("plc", source="1.2.3.4.1.1:30000")
    assert (dialer.mode, dialer.source) == ("direct", AmsAddress("1.2.3.4.1.1:30000"))


@pytest.mark.parametrize("net_id", [None, "192.0.2.1.1.1"])
def test_net_id_is_queried_unless_named(net_id: str | None) -> None:
    dialer = dialer_of("192.0.2.1", net_id=net_id)
    assert (dialer.needs_net_id, dialer.udp_port) == (net_id is None, 48899)


def test_refusal_of_an_assumed_net_id_names_the_option() -> None:
    """The router behind an address is not found by the NetId derived from it."""

    async def main() -> None:
        listener = TcpListener(Router(NetId("5.4.3.2.1.1")))
        await listener.open(port=0)
        dialer = TcpDialer("127.0.0.1", listener.port, mode="direct")
        dialer.assumed_net_id = dialer.peer_net_id = NetId("127.0.0.2.1.1")
        async with connect(dialer) as client:
            with pytest.raises(RouterError, match=r"0x7 .*; the NetId 127\.0\.0\.2\.1\.1 was"):
                await client.state()
            with pytest.raises(RouterError, match=r"0x7 [^;]*target computer\.$"):
                await client.at_port(851, "9.9.9.9.1.1").state()
            with pytest.raises(RouterError, match=r"0x6 .*not installed\.$"):
                await client.at_port(851, "127.0.0.1.1.1").state()
        await listener.close()

    asyncio.run(main())


def test_a_router_of_this_process_is_dialled_without_sockets() -> None:
    dialer = connect(Router(b"\1\1\1\1\1\1"))._dialer  # type: ignore[arg-type]
    assert isinstance(dialer, RouterDialer)


def test_the_names_at_the_top_are_these() -> None:
    from achse.client import blocking

    assert achse.connect is connect
    assert achse.blocking is blocking
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = achse.nothing


def test_the_device_is_on_the_router_that_answers(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with connect(peer, port=500) as nc:
            assert str(nc.address) == "5.4.3.2.1.1:500"
        async with connect(peer, net_id="7.7.7.7.1.1") as plc:
            assert str(plc.address) == "7.7.7.7.1.1:851"

    run(main())


def test_it_can_be_awaited_too(run: Run, peer: Any) -> None:
    async def main() -> None:
        plc = await connect(peer)
        assert isinstance(plc, Client)
        assert await plc.read("MAIN.nCounter") == 7
        await plc.close()
        await plc.close()
        async with await connect(peer) as plc:
            assert await plc.read("MAIN.nCounter") == 7
        with pytest.raises(ConnectionLost):
            await plc.read("MAIN.nCounter")

    run(main())


def test_a_missing_peer_is_a_lost_connection(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.refuse_dials = 1
        with pytest.raises(ConnectionLost, match="nobody there"):
            async with connect(peer):
                pass

    run(main())


def test_closing_gives_everything_back(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with connect(peer) as plc:
            samples = await plc.subscribe("GVL.fValue").__aenter__()
            await plc.read("MAIN.nCounter")
            await anext(samples)
        assert peer.notifications == {}
        assert len(peer.requests_of(DeleteNotificationRequest)) == 2
        assert sorted(peer.released) == [101, 102]
        assert peer.link is None
        assert [sample async for sample in samples] == []

    run(main())


def test_closing_does_not_wait_for_a_dead_target(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with connect(peer) as plc:
            await plc.read("MAIN.nCounter")
            await asyncio.sleep(0)
            peer.mute = True
            start = asyncio.get_running_loop().time()
        assert asyncio.get_running_loop().time() - start <= module.GOODBYE_TIME

    run(main())


def test_closing_while_there_is_no_link_is_quick(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with connect(peer, reconnect=Backoff(1.0, 1.0)) as plc:
            await plc.read("MAIN.nCounter")
            peer.lose()
            await asyncio.sleep(0.5)

    run(main())


def test_without_reconnect_a_loss_is_final(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with connect(peer, reconnect=False) as plc:
            peer.lose()
            await asyncio.sleep(0)
            with pytest.raises(ConnectionLost):
                await plc.read("MAIN.nCounter")

    run(main())


def test_keep_alive_queries_devices_we_use(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with connect(peer, keep_alive=10.0) as plc:
            await asyncio.sleep(100)
            assert peer.requests == []
            await plc.read("MAIN.nCounter")
            peer.requests.clear()
            await asyncio.sleep(35)
            assert len(peer.requests) == 3

    run(main())


def test_a_client_that_is_not_connected_yet_says_how() -> None:
    connecting: Any = connect("127.0.0.1")
    with pytest.raises(AttributeError, match=r"read: not connected yet: `async with"):
        connecting.read("GVL.nInt")
    with pytest.raises(AttributeError, match="has no attribute 'raed'"):
        connecting.raed("GVL.nInt")
