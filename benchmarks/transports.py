"""The transports to a station, side by side: TCP, Secure ADS (TLS), MQTT; each beside a bare echo.

One station is reached by all three. On each transport: reads of 4 bytes one after the other (median
and 99th percentile of a round trip), and 64 under way at once (answers per second). The bare peers
send back what comes and no more, in a process of their own like the station: asyncio over TCP,
asyncio over TLS with the same certificate, and two paho clients over the same broker. Transports
whose parts are missing (mosquitto, the extras mqtt and secure) are left out, with the reason.
Usage: python benchmarks/transports.py [READS]
"""

import asyncio
import contextlib
import shutil
import socket
import ssl
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

from processes import running

import achse
from achse.transport.secure.own_certificate import OwnCertificate

WINDOW = 64
REQUEST, ANSWER = bytes(50), bytes(54)
"""As long as a Read and its response of 4 bytes."""

CLIENT = "192.0.2.78.1.1"
Exchange = Callable[[], Awaitable[object]]


# peers ----------------------------------------------------------------------------------------


class Echo(asyncio.Protocol):
    """For each request one answer; all that have come get theirs in one write."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport
        self.came = 0

    def data_received(self, data: bytes) -> None:
        requests, self.came = divmod(self.came + len(data), len(REQUEST))
        self.transport.write(ANSWER * requests)  # type: ignore[attr-defined]


async def serve(folder: str) -> None:
    loop = asyncio.get_running_loop()
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    if folder:
        own = OwnCertificate.ensure(Path(folder), "station")
        tls.load_cert_chain(own.certificate, own.key)
    plain = await loop.create_server(Echo, "127.0.0.1", 0)
    safe = await loop.create_server(Echo, "127.0.0.1", 0, ssl=tls if folder else None)
    ports = (server.sockets[0].getsockname()[1] for server in (plain, safe))
    print("peer ready", *ports, flush=True)
    await asyncio.gather(plain.serve_forever(), safe.serve_forever())


def serve_paho(port: int) -> None:
    """A paho client that answers each message."""
    from paho.mqtt.client import Client
    from paho.mqtt.enums import CallbackAPIVersion

    client = Client(CallbackAPIVersion.VERSION2)

    def answer(it: Client, _: object, message: object) -> None:
        it.publish("bare/answer", ANSWER)

    client.on_message = answer
    client.on_subscribe = lambda *_: print("peer ready", flush=True)
    client.connect("127.0.0.1", port)
    client.subscribe("bare/request")
    client.loop_forever()


class Bare(asyncio.Protocol):
    """Asks an `Echo`; each answer goes to the oldest request."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport
        self.came = 0
        self.waiting: list[asyncio.Future[None]] = []

    def data_received(self, data: bytes) -> None:
        answers, self.came = divmod(self.came + len(data), len(ANSWER))
        for future in self.waiting[:answers]:
            future.set_result(None)
        del self.waiting[:answers]

    def ask(self) -> asyncio.Future[None]:
        self.waiting.append(asyncio.get_running_loop().create_future())
        self.transport.write(REQUEST)  # type: ignore[attr-defined]
        return self.waiting[-1]


# transports
# ----------------------------------------------------------------------------------------


@contextlib.asynccontextmanager
async def to_station(target: Any) -> Any:
    async with achse.connect(
        target, net_id="5.6.7.8.1.1", port=501, watch_symbols=False, keep_alive=None,
        source=f"{CLIENT}:40000",
    ) as nc:  # fmt: skip
        yield lambda: nc.read_raw(0x4101, 1, 4)


@contextlib.asynccontextmanager
async def to_echo(port: int, tls: ssl.SSLContext | None) -> Any:
    loop = asyncio.get_running_loop()
    transport, bare = await loop.create_connection(Bare, "127.0.0.1", port, ssl=tls)
    yield bare.ask
    transport.close()


@contextlib.asynccontextmanager
async def to_paho(port: int) -> Any:
    from paho.mqtt.client import Client
    from paho.mqtt.enums import CallbackAPIVersion

    loop = asyncio.get_running_loop()
    waiting: list[asyncio.Future[None]] = []
    ready = asyncio.Event()
    client = Client(CallbackAPIVersion.VERSION2)

    def subscribed(*_: object) -> None:
        loop.call_soon_threadsafe(ready.set)

    def answered(*_: object) -> None:
        loop.call_soon_threadsafe(lambda: waiting.pop(0).set_result(None))

    client.on_subscribe, client.on_message = subscribed, answered
    client.connect("127.0.0.1", port)
    client.subscribe("bare/answer")
    client.loop_start()
    await ready.wait()

    def ask() -> asyncio.Future[None]:
        waiting.append(loop.create_future())
        client.publish("bare/request", REQUEST)
        return waiting[-1]

    yield ask
    client.loop_stop()


async def measure(name: str, transport: Any, reads: int) -> None:
    async with transport as ask:
        for _ in range(20):
            await ask()
        spans = []
        for _ in range(reads):
            start = time.perf_counter()
            await ask()
            spans.append(time.perf_counter() - start)

        async def go_on() -> None:
            for _ in range(max(reads // WINDOW, 1)):
                await ask()

        start = time.perf_counter()
        await asyncio.gather(*(go_on() for _ in range(WINDOW)))
        rate = max(reads // WINDOW, 1) * WINDOW / (time.perf_counter() - start)
    median, late = statistics.median(spans), statistics.quantiles(spans, n=100)[98]
    print(f"{name:<28} {median * 1e6:9,.0f} {late * 1e6:9,.0f} µs {rate:11,.0f} answers/s")


@contextlib.contextmanager
def broker(folder: Path) -> Iterator[tuple[int, int]]:
    """Its port and its process."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    file = folder / "mosquitto.conf"
    file.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    with subprocess.Popen(
        ["mosquitto", "-c", str(file)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            yield port, process.pid
        finally:
            process.terminate()


def certificates(folder: Path) -> str:
    """Ours and the station's are made; the lines of the station's file."""
    OwnCertificate.ensure(folder / "station", "station")
    own = OwnCertificate.ensure(folder / "client", "client")
    return (
        f'[secure]\nfolder = "{folder / "station"}"\nport = 0\n[[route]]\nname = "client"\n'
        f'net_id = "{CLIENT}"\nhost = "127.0.0.1"\ntls = {{ fingerprint = "{own.fingerprint}" }}\n'
    )


def secure_target(folder: Path, port: int) -> str:
    there = OwnCertificate.ensure(folder / "station", "station").fingerprint
    return f"secure://127.0.0.1:{port}?fingerprint={there}&certificates={folder / 'client'}"


def missing(program: str, extra: str, module: str) -> str:
    try:
        __import__(module)
    except ImportError:
        return f"needs the extra {extra}"
    return "" if not program or shutil.which(program) else f"{program} is not installed"


async def transports(folder: Path, reads: int, without_tls: str, mqtt: int | None) -> None:
    """Start the station and its bare peers, and measure each transport."""
    text = '[router]\nnet_id = "5.6.7.8.1.1"\ntcp_port = 0\n'
    text += "" if without_tls else 'listen = "both"\n'
    text += '[[axis]]\nid = 1\nname = "X"\n'
    if mqtt is not None:
        text += f'[[mqtt]]\nbroker = "127.0.0.1"\nport = {mqtt}\ntopic = "transports"\n'
    text += "" if without_tls else certificates(folder)
    file = folder / "station.toml"
    file.write_text(text)
    tls = None if without_tls else ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    if tls is not None:
        tls.check_hostname, tls.verify_mode = False, ssl.CERT_NONE
    own = "" if tls is None else str(folder / "station")
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(running("-m", "achse", "run", str(file), ready="achse ready"))
        words = dict(word.split("=", 1) for word in line.split() if "=" in word)
        peer = stack.enter_context(running(__file__, "--serve", own, ready="peer ready"))
        plain, safe = map(int, peer.split()[2:])
        if mqtt is not None:
            stack.enter_context(running(__file__, "--serve-paho", str(mqtt), ready="peer ready"))
        print(f"{'':<28} {'median':>9} {'99 %':>9}    {WINDOW} at once")
        await measure("TCP, achse", to_station(words["tcp"].replace("0.0.0.0", "127.0.0.1")), reads)
        await measure("TCP, bare asyncio", to_echo(plain, None), reads)
        if tls is not None:
            target = secure_target(folder, int(words["secure"].rpartition(":")[2]))
            await measure("TLS, achse", to_station(target), reads)
            await measure("TLS, bare asyncio", to_echo(safe, tls), reads)
        if mqtt is not None:
            await measure("MQTT, achse", to_station(f"mqtt://127.0.0.1:{mqtt}/transports"), reads)
            await measure("MQTT, bare paho", to_paho(mqtt), reads)


def main(reads: int) -> None:
    without_tls = missing("", "secure", "OpenSSL")
    without_mqtt = missing("mosquitto", "mqtt", "aiomqtt")
    for transport, reason in (("TLS", without_tls), ("MQTT", without_mqtt)):
        if reason:
            print(f"{transport:<28} left out: {reason}")
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        port = None if without_mqtt else stack.enter_context(broker(folder))[0]
        asyncio.run(transports(folder, reads, without_tls, port))


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--serve", own]:
            asyncio.run(serve(own))
        case ["--serve-paho", number]:
            serve_paho(int(number))
        case arguments:
            main(*map(int, arguments or ["2000"]))
