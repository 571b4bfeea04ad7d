"""A router without devices: programs reach targets through it, and it tells how they are."""

import json
import subprocess
import sys
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import AmsAddress, RouterError
from achse.codes.ports import ROUTER_PORT
from achse.gateway.choices import RESUBSCRIBE
from achse.gateway.target import TargetState
from achse.router.access import hash_password
from achse.transport.udp import scan
from tests.gateway.stations import NET_ID, OWN, gateway, running_target, target_at, until


def test_import_loads_no_devices_of_a_station() -> None:
    report = "import achse.gateway.gateway, json, sys; print(json.dumps(sorted(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True)
    rooms = {name.split(".")[1] for name in json.loads(run.stdout) if name.startswith("achse.")}
    absent = {"motion", "plc", "st", "gcode", "drive", "ethercat", "camshaft", "libraries", "scope"}
    assert rooms & (absent | {"faults", "monitor", "web", "cli"}) == set()
    loaded = {name for name in json.loads(run.stdout) if name.startswith("achse.devices.")}
    assert loaded & {"achse.devices.nc", "achse.devices.plc", "achse.devices.scope"} == set()


async def test_clients_reach_a_target_found_by_search_over_one_connection() -> None:
    async with (
        running_target() as target,
        gateway(target_at(target)).running("127.0.0.1", 0, udp_port=0) as router,
    ):
        [link] = router.targets
        assert (link.state, str(link.net_id)) == (TargetState.READY, NET_ID)
        where = f"127.0.0.1:{router.network.listener.port}"
        for source in ("127.0.0.1.1.1:30000", "192.168.0.9.1.1:30000", None):
            async with achse.connect(
                where, net_id=NET_ID, port=10_000, source=source, reconnect=False
            ) as client:
                assert (await client.state()).ads_state == 5
        [peer] = target.listener.connections
        assert {bytes(each[:6]) for each in peer.senders} == {bytes(router.router.net_id)}


async def test_router_answers_searches_and_its_own_state() -> None:
    async with gateway(name="linux").running("127.0.0.1", 0, udp_port=0) as router:
        discovery = router.network.discovery
        assert discovery is not None
        [(info, _)] = await scan(["127.0.0.1"], port=discovery.port, all_of_them=False)
        assert (str(info.net_id), info.host_name) == (OWN, "linux")
        where = f"127.0.0.1:{router.network.listener.port}"
        async with achse.connect(where, net_id=OWN, port=10_000, reconnect=False) as client:
            assert (await client.state()).ads_state == 5


async def test_rights_hold_for_requests_to_a_target() -> None:
    async with (
        running_target() as target,
        gateway(target_at(target), router={"rights": ["read"]}).running(
            "127.0.0.1", 0, udp_port=0
        ) as router,
    ):
        where = f"127.0.0.1:{router.network.listener.port}"
        async with achse.connect(
            where, net_id=NET_ID, port=10_000, source="192.0.2.9.1.1:30000", reconnect=False
        ) as client:
            assert (await client.state()).ads_state == 5
            with pytest.raises(RouterError, match="0x723"):
                await client.write_raw(500, 0, b"x")


async def test_unknown_target_is_searched_for_while_clients_get_an_answer(
    caplog: pytest.LogCaptureFixture,
) -> None:
    lost = {"host": "127.0.0.1:9", "udp_port": 9, "name": "mill"}
    async with gateway(lost).running("127.0.0.1", 0, udp_port=0) as router:
        [link] = router.targets
        assert link.state is TargetState.SEARCHING
        assert "--to 127.0.0.1:9=NETID" in caplog.text
        where = f"127.0.0.1:{router.network.listener.port}"
        async with achse.connect(
            where, net_id=NET_ID, port=851, source="192.0.2.9.1.1:1", reconnect=False
        ) as client:
            with pytest.raises(RouterError, match="0x7"):
                await client.state()


async def test_unreachable_target_is_answered_for_at_once() -> None:
    dead = {"host": "127.0.0.1:9", "net_id": NET_ID}
    async with gateway(dead).running("127.0.0.1", 0, udp_port=0) as router:
        [link] = router.targets
        assert link.state is TargetState.UNREACHABLE
        where = f"127.0.0.1:{router.network.listener.port}"
        async with achse.connect(
            where, net_id=NET_ID, port=851, source="192.0.2.9.1.1:1", reconnect=False
        ) as client:
            with pytest.raises(RouterError, match="0x1B"):
                await client.state()


async def test_target_that_comes_later_is_reached() -> None:
    async with running_target() as target:
        table = target_at(target, net_id=NET_ID)
    async with gateway(table).running("127.0.0.1", 0, udp_port=0) as router:
        [link] = router.targets
        assert link.state is TargetState.UNREACHABLE
        async with running_target(tcp_port=link.config.endpoint[1]):
            await until(lambda: link.state is TargetState.READY)


async def test_target_that_refuses_is_registered_at_with_a_password() -> None:
    users = {"Administrator": str(hash_password("1"))}
    async with running_target(router={"strict": True, "users": users}) as target:
        table = target_at(target, user="Administrator", password="1")
        async with gateway(table, name="linux").running("127.0.0.1", 0, udp_port=0) as router:
            [link] = router.targets
            await until(lambda: link.state is TargetState.READY)
            [route] = target.network._router.routes
            assert (route.name, str(route.net_id), route.host) == ("linux", OWN, "127.0.0.1")


@pytest.mark.parametrize(
    ("keys", "advice"),
    [
        ({}, f"achse ads route add --host 127.0.0.1 --net-id {OWN}"),
        ({"user": "Administrator", "password": "2"}, "wrong user 'Administrator' or password"),
    ],
)
async def test_refusal_of_the_target_is_reported(
    keys: dict[str, str], advice: str, caplog: pytest.LogCaptureFixture
) -> None:
    users = {"Administrator": str(hash_password("1"))}
    async with (
        running_target(router={"strict": True, "users": users}) as target,
        gateway(target_at(target, **keys)).running("127.0.0.1", 0, udp_port=0) as router,
    ):
        [link] = router.targets
        await until(lambda: link.state is TargetState.REFUSED)
        assert advice in link.advice
        assert advice in caplog.text


async def test_files_of_a_program_that_vanished_are_closed(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("a")
    (tmp_path / "b.txt").write_text("b")
    async with (
        running_target(system={"root": str(tmp_path)}) as target,
        gateway(target_at(target)).running("127.0.0.1", 0, udp_port=0) as router,
    ):
        where = f"127.0.0.1:{router.network.listener.port}"
        system: Any = target.listener.router.local_endpoint(AmsAddress(f"{NET_ID}:10000"))
        files = system.files
        async with achse.connect(where, net_id=NET_ID, port=10_000, reconnect=False) as client:
            opened = [await client.read_write_raw(120, 0x1_0011, 4, b"a.txt\0") for _ in range(3)]
            await client.read_write_raw(121, int.from_bytes(opened[0], "little"), 0, b"")
            await client.read_write_raw(133, 0x1_0001, 324, b"*\0")
            assert len(files) == 3
        await until(lambda: not len(files))


@pytest.mark.parametrize(
    ("key", "rules", "request_"),
    [
        (True, [], None),
        (False, [], None),
        (False, [{"host": "127.0.0.1"}], None),
        (False, [], True),
    ],
)
async def test_symbol_handles_survive_a_restart_of_the_target_on_request(
    key: bool, rules: list[dict[str, Any]], request_: bool | None
) -> None:
    resubscribe = key or bool(rules) or bool(request_)
    plc: dict[str, Any] = {"plc": [{"globals": ["achse.station.demo:GVL"]}]}
    async with AsyncExitStack() as stack:
        async with running_target(**plc) as target:
            port = target.tcp_port
            keys = {"resubscribe": key, "net_id": NET_ID, "keep_alive": "0.05s"}
            clients = [{"resubscribe": True, **rule} for rule in rules]
            gateway_ = gateway(target_at(target, **keys), client=clients)
            router = await stack.enter_async_context(gateway_.running("127.0.0.1", 0, udp_port=0))
            where = f"127.0.0.1:{router.network.listener.port}"
            client = await stack.enter_async_context(
                achse.connect(where, net_id=NET_ID, port=851, reconnect=False, watch_symbols=False)
            )
            if request_ is not None:
                own = client.at_port(ROUTER_PORT, OWN)
                await own.read_write_raw(RESUBSCRIBE, 0, 1, bytes([request_]))
            data = await client.read_write_raw(0xF003, 0, 4, b"GVL.nInt\0")
            handle = int.from_bytes(data, "little")
            value = await client.read_raw(0xF005, handle, 2)
        async with running_target(port, **plc) as target:
            if not resubscribe:
                await until(lambda: not router.network.listener.connections)
                return
            again = b""
            while not again:  # refused until all is made again
                with suppress(RouterError):
                    again = await client.read_raw(0xF005, handle, 2)
            assert again == value
