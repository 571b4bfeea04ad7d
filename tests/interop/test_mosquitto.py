"""Stations and clients over a real broker: reads, samples, kills, a broker that restarts."""

import asyncio
import json
import os
import signal
import socket
import subprocess
from collections.abc import Callable, Iterator
from contextlib import AsyncExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import AdsError, DeviceError, NetId
from achse.ams.mqtt import RouterNote
from achse.client.links.mqtt_link import routers_of
from achse.station.configuration.station_file import parse
from achse.transport.mqtt.network import MqttNetwork, MqttSettings
from tests.interop.waiting import until, until_async
from tests.transport.certificates import authority, signed
from tests.warm_commands import WarmCommands

FIFTY = 50
SCRIPT = Path(__file__).with_name("aioads_client.py")
PATIENCE = 600.0
"""Seconds of a request, a guard against hanging."""


class Mosquitto:
    """A broker at a port of 127.0.0.1."""

    def __init__(self, folder: Path, *, tls: bool = False) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        lines = [f"listener {self.port} 127.0.0.1", "allow_anonymous true"]
        lines.append("max_inflight_messages 0")  # 2.0.11 forgets what comes behind 20 at QoS 2
        if os.getuid() == 0:
            lines.append("user root")  # else it may not read the key
        if tls:
            own = signed("127.0.0.1", "127.0.0.1")
            lines += [
                f"cafile {authority()}",
                f"certfile {own.certificate}",
                f"keyfile {own.key}",
                "require_certificate true",
            ]
        self._file = folder / f"mosquitto-{self.port}.conf"
        self._file.write_text("\n".join(lines) + "\n")
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._process = subprocess.Popen(
            ("mosquitto", "-c", str(self._file)),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        until(self._listens)

    def _listens(self) -> bool:
        assert self._process is not None
        assert self._process.poll() is None, "the broker did not start"
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self) -> None:
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
            self._process = None

    def network(self, name: str = "plant/hall") -> str:
        return f"mqtt://127.0.0.1:{self.port}/{name}"


@pytest.fixture
def broker(witness: Callable[[str], None], tmp_path: Path) -> Iterator[Mosquitto]:
    witness("mosquitto")
    running = Mosquitto(tmp_path)
    running.start()
    yield running
    running.stop()


def toml(folder: Path, number: int, port: int) -> str:
    file = folder / f"s{number}.toml"
    file.write_text(
        f'name = "s{number}"\n[router]\nnet_id = "5.6.{number // 200}.{number % 200 + 1}.1.1"\n'
        f'tcp_port = 0\n[[mqtt]]\nbroker = "127.0.0.1"\nport = {port}\ntopic = "plant/hall"\n'
        'keep_alive = 2\n[[plc]]\nglobals = ["achse.station.demo:GVL"]\n'
        '[[axis]]\nid = 1\nname = "X"\n'
    )
    return str(file)


@contextmanager
def doomed(commands: WarmCommands, file: str) -> Iterator[subprocess.Popen[str]]:
    """A station that may be killed."""
    with commands.popen("run", file, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("achse ready")
        try:
            yield process
        finally:
            process.kill()


async def partners(network: str, count: int) -> None:
    """Until so many are online."""
    seen = 0
    while seen != count:
        async with routers_of(MqttSettings.parse(network), 0.3) as there:
            seen = len(there)


async def test_a_killed_station_is_known_at_once_and_its_requests_fail(
    broker: Mosquitto,
    tmp_path: Path,
    start_station: Callable[..., Any],
    warm_commands: WarmCommands,
) -> None:
    with (
        start_station(toml(tmp_path, 0, broker.port)) as first,
        doomed(warm_commands, toml(tmp_path, 1, broker.port)) as second,
    ):
        await partners(broker.network(), 2)
        async with achse.connect(
            f"{first.host}:{first.port}", net_id="5.6.0.2.1.1", timeout=3600
        ) as client:
            assert await client.read("GVL.sString") == "axis"
            async with client.subscribe("GVL.nInt") as samples:
                assert (await anext(aiter(samples))).value == -16
            second.send_signal(signal.SIGSTOP)  # it does not answer
            asking = asyncio.create_task(client.read("GVL.sString"))
            second.kill()
            with pytest.raises(AdsError, match="0x7"):
                await asking  # by what the broker says: the client waits for an hour


async def test_a_broker_that_restarts_loses_no_acknowledged_write(
    broker: Mosquitto, tmp_path: Path, start_station: Callable[..., Any]
) -> None:
    with start_station(toml(tmp_path, 0, broker.port)) as station:
        await partners(broker.network(), 1)
        acknowledged = 0
        async with achse.connect(broker.network(), net_id=station.net_id, timeout=2.0) as client:
            for number in range(1, 200):
                if number in (50, 120):
                    broker.stop()
                    broker.start()
                try:
                    await client.write("GVL.nInt", number)
                    acknowledged = number
                except AdsError:
                    continue
                assert await _read(client) >= acknowledged
            assert acknowledged  # not all: a busy machine may take longer than the time-out
            assert await _read(client) >= acknowledged


async def _read(client: Any) -> int:
    while True:
        try:
            return int(await client.read("GVL.nInt"))
        except AdsError:
            await asyncio.sleep(0.05)  # the client joins again


async def test_certificates_of_the_broker(witness: Callable[[str], None], tmp_path: Path) -> None:
    witness("mosquitto")
    broker = Mosquitto(tmp_path, tls=True)
    broker.start()
    try:
        ours = signed("client")
        files = f"ca={authority()}&certificate={ours.certificate}&key={ours.key}"
        network = f"mqtts://127.0.0.1:{broker.port}/plant?{files}"
        async with routers_of(MqttSettings.parse(network), 0.01) as there:
            assert there == {}
    finally:
        broker.stop()


async def test_fifty_routers_see_and_read_each_other(broker: Mosquitto) -> None:
    """In one process, so that the broker is what is tested."""
    from achse.station import Station
    from achse.station.configuration.station_file import parse

    stations = [
        Station(
            parse(
                {
                    "name": f"s{number}",
                    "router": {"net_id": f"5.6.7.{number + 1}.1.1"},
                    "plc": [{"globals": ["achse.station.demo:GVL"]}],
                    "mqtt": [{"broker": "127.0.0.1", "port": broker.port, "topic": "plant/hall"}],
                },
                "a.toml",
            )
        )
        for number in range(FIFTY)
    ]
    async with AsyncExitStack() as stack:
        running = [
            await stack.enter_async_context(each.running("127.0.0.1", 0, speed=0))
            for each in stations
        ]
        await until_async(
            lambda: all(len(each.network.mqtt[0].partners) == FIFTY - 1 for each in running)
        )

        async def ask(number: int) -> None:
            far = f"5.6.7.{(number * 7 + 3) % FIFTY + 1}.1.1"
            async with achse.connect(
                stations[number].router, net_id=far, watch_symbols=False, timeout=PATIENCE
            ) as client:
                try:
                    assert await client.read("GVL.sString") == "axis"
                except DeviceError as failure:  # pragma: no cover
                    raise AssertionError(far) from failure

        await asyncio.gather(*(ask(number) for number in range(FIFTY)))


async def test_aioads_reads_subscribes_and_moves_an_axis_also_after_the_broker_was_gone(
    broker: Mosquitto, tmp_path: Path, start_station: Callable[..., Any]
) -> None:
    """It needs Python 3.12; `.ci/run` makes a place for it and names its interpreter.

    aioads itself does not join again after a broker that was gone: another one of it does.
    """
    python = os.environ.get("ACHSE_AIOADS")
    if not python:
        pytest.skip("ACHSE_AIOADS does not name a Python (3.12 or later) with aioads[gmqtt]")
    with start_station(toml(tmp_path, 0, broker.port)) as station:
        async with achse.connect(f"{station.host}:{station.port}") as client:
            x = client.nc.axis("X")
            await x.enable()
            for target in (25.0, 40.0):
                command = (python, str(SCRIPT), str(broker.port), station.net_id, str(target))
                process = await asyncio.create_subprocess_exec(*command, stdout=subprocess.PIPE)
                said, _ = await process.communicate()
                report = json.loads(said)
                assert station.net_id in report["remotes"]
                assert (report["state"], report["string"]) == ("RUN", "axis")
                assert (report["samples"], report["move"]) == (True, 0)
                while abs((await x.status()).position - target) > 0.1:
                    pass
                broker.stop()
                broker.start()
                await partners(broker.network(), 1)


class Listener:
    """Keeps the messages that it gets."""

    def __init__(self) -> None:
        self.messages: list[bytes] = []

    def joined(self) -> None: ...

    def parted(self, reason: str) -> None: ...

    def came(self, net_id: NetId, note: RouterNote) -> None: ...

    def left(self, net_id: NetId) -> None: ...

    def received(self, message: bytes) -> None:
        self.messages.append(message)


@pytest.mark.parametrize("qos", [0, 2])
async def test_messages_of_any_length_arrive_once_and_in_order(broker: Mosquitto, qos: int) -> None:
    settings = MqttSettings(host="127.0.0.1", port=broker.port, topic="plant/hall", qos=qos)
    press, panel = NetId("5.6.7.8.1.1"), NetId("10.6.7.8.1.1")
    heard = Listener()
    note = RouterNote(online=True, name="one")
    sender = MqttNetwork(settings, press, note, Listener())
    networks = [sender, MqttNetwork(settings, panel, note, heard)]
    running = [asyncio.create_task(network.run()) for network in networks]
    sent = [
        number.to_bytes(4) + bytes(2_000_000 if number % 60 == 9 else number % 60)
        for number in range(300)
    ]
    try:
        await until_async(lambda: panel in sender.partners)
        for message in sent:
            assert sender.send(panel, message, back=False)
        await until_async(lambda: len(heard.messages) >= len(sent) and not sender.unsent)
    finally:
        for task in running:
            task.cancel()
        await asyncio.gather(*running, return_exceptions=True)
    assert heard.messages == sent


async def test_symbols_are_topics_at_a_broker(broker: Mosquitto, tmp_path: Path) -> None:
    """On change, retained, and back; another program of the broker sees and writes them."""
    import aiomqtt

    (tmp_path / "MAIN.st").write_text("PROGRAM MAIN VAR x, y : DINT; END_VAR x := y; END_PROGRAM")
    bridge = {
        "broker": "127.0.0.1", "port": broker.port, "topic": "press", "cycle": "10ms",
        "symbols": ["MAIN.x"], "writable": ["MAIN.y"],
    }  # fmt: skip
    document = {"plc": [{"port": 851, "sources": "."}], "bridge": [bridge]}
    station = achse.Station(parse(document, "a.toml"), base=tmp_path)
    async with (
        station.running("127.0.0.1", 0),
        aiomqtt.Client("127.0.0.1", broker.port) as other,
        asyncio.timeout(PATIENCE),
    ):
        await other.subscribe("press/#", qos=1)
        seen: list[tuple[bytes, bool]] = []
        async for message in other.messages:
            if message.topic.value == "press/MAIN.y/set":
                continue
            seen.append((bytes(message.payload or b""), message.retain))
            if seen[-1][0] == b"17":
                break
            await other.publish("press/MAIN.y/set", b"17", qos=1)
        assert [value for value, _ in seen] == [b"0", b"17"]
    async with aiomqtt.Client("127.0.0.1", broker.port) as late, asyncio.timeout(PATIENCE):
        await late.subscribe("press/MAIN.x")
        message = await anext(aiter(late.messages))
        assert (message.payload, message.retain) == (b"17", True)
