"""`achse monitor` shows live what passes between clients and devices, with names."""

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable, Coroutine, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.options import Count, Duration
from achse.cli.output import print_event, print_json, visible
from achse.cli.target import STATION_PORT, Json, endpoint, fail_to_connect

if TYPE_CHECKING:
    from achse.ams import AmsAddress
    from achse.client.target import Target
    from achse.monitor.decode import Decoder, Exchange
    from achse.router.tap import Captured

PLC_PORT = 851
FETCH_EVERY = 0.05
FETCH_BYTES = 1 << 23
OVERDUE = 5.0
"""Seconds after which a request counts as unanswered."""

Host = Annotated[
    str, typer.Option(envvar="ACHSE_HOST", help="Where the station listens, or the tap does.")
]
TcpPort = Annotated[
    int, typer.Option(envvar="ACHSE_TCP_PORT", min=0, max=65535, help="Its TCP port.")
]
Via = Annotated[
    str | None,
    typer.Option(
        metavar="HOST[:PORT]",
        help="Tap in front of this target: clients dial --host instead of it.",
        show_default=False,
    ),
]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(monitor)


def monitor(
    via: Via = None,
    ask: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NETID[:PORT]",
            help="With --via: fetch symbols and types of this device (port 851 unless given)"
            " before clients come in, over a connection of our own. Without it the tap asks the"
            " target nothing and learns from what clients ask.",
            show_default=False,
        ),
    ] = None,
    write: Annotated[
        Path | None, typer.Option(help="Write a packet capture (pcapng).", show_default=False)
    ] = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="With --write: record without showing anything.")
    ] = False,
    client: Annotated[
        str, typer.Option(help="Only clients whose address is like this, as 10.0.0.*.")
    ] = "*",
    device: Annotated[
        list[int] | None, typer.Option(help="Only these AMS ports.", show_default=False)
    ] = None,
    name: Annotated[str, typer.Option(help="Only symbols or services like this.")] = "*",
    errors: Annotated[bool, typer.Option("--errors", help="Only what failed.")] = False,
    slower: Annotated[
        float, typer.Option(min=0, metavar="MS", help="Only what took longer, ms.")
    ] = 0.0,
    samples: Annotated[
        bool, typer.Option("--samples/--no-samples", help="Notifications as well.")
    ] = True,
    count: Count = None,
    duration: Duration = None,
    in_json: Json = False,
    host: Host = "127.0.0.1",
    tcp_port: TcpPort = 48898,
) -> None:
    """Show requests, answers and notifications as they pass, and record them, until Ctrl-C."""
    host, tcp_port = endpoint(host, tcp_port)
    if quiet:
        if write is None:
            raise typer.BadParameter("expected --write FILE", param_hint="--quiet")
        run_until_ended(_record(write, via, duration, host, tcp_port, in_json), host, tcp_port)
        return
    wanted = _Filter(client, frozenset(device or ()), name, errors, slower, samples)
    if ask and via is None:
        raise typer.BadParameter("a station of ours is asked anyway", param_hint="--ask")
    devices = [_device(text) for text in ask or ()]
    run_until_ended(
        _monitor(host, tcp_port, via, devices, write, wanted, count, duration, in_json),
        host,
        tcp_port,
    )


class _Filter:
    """Filter of the exchanges to show."""

    def __init__(
        self,
        client: str,
        devices: frozenset[int],
        name: str,
        errors: bool,
        slower_ms: float,
        samples: bool,
    ) -> None:
        self._client = client
        self._devices = devices
        self._name = name.lower().replace("[", "[[]")
        self._errors = errors
        self._slower_ns = slower_ms * 1e6
        self._samples = samples

    def __call__(self, exchange: "Exchange") -> bool:
        return (
            (not self._devices or exchange.device.port in self._devices)
            and (self._samples or exchange.command != "notification")
            and (not self._errors or bool(exchange.error) or not exchange.answered)
            and (not self._slower_ns or (exchange.duration_ns or 0) > self._slower_ns)
            and any(
                fnmatchcase(text, self._client) for text in (exchange.peer, str(exchange.client))
            )
            and (
                self._name == "*"
                or any(fnmatchcase(item.name.lower(), self._name) for item in exchange.items)
            )
        )


async def _record(
    file: Path,
    via: str | None,
    duration: float | None,
    host: str,
    tcp_port: int,
    in_json: bool,
) -> None:
    """Write a capture without looking into the packets."""
    from achse.monitor.capture import CaptureWriter

    with CaptureWriter(file) as write:
        try:
            async with _watching(host, tcp_port, via, write):
                await asyncio.sleep(1e9 if duration is None else duration)
        finally:
            if in_json:
                print_json({"event": "done", "file": str(file), "packets": write.count})
            else:
                print(f"{file}: {write.count} packets")


async def _monitor(
    host: str,
    tcp_port: int,
    via: str | None,
    devices: "Sequence[AmsAddress]",
    write: Path | None,
    wanted: _Filter,
    count: int | None,
    duration: float | None,
    in_json: bool,
) -> None:
    from achse.monitor.capture import CaptureWriter
    from achse.monitor.decode import Decoder
    from achse.monitor.names import Names, rows_of
    from achse.station import Station

    decoder = Decoder(Names(rows_of(Station.demo().devices)))
    done = asyncio.Event()
    left = count

    def shown(exchange: "Exchange") -> None:
        nonlocal left
        if done.is_set() or not wanted(exchange):
            return
        if in_json:
            print_json(exchange.as_json())
        else:
            print("\n".join(lines_of(exchange)), flush=True)
        if left is not None:
            left -= 1
            if left == 0:
                done.set()

    with contextlib.ExitStack() as stack:
        keep = stack.enter_context(CaptureWriter(write)) if write is not None else None

        def see(capture: "Captured") -> None:
            if keep is not None:
                keep(capture)
            for exchange in decoder.see(capture):
                shown(exchange)

        async with _watching(host, tcp_port, via, see, decoder, devices):
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(duration):
                    while not done.is_set():
                        with contextlib.suppress(TimeoutError):
                            await asyncio.wait_for(done.wait(), 1.0)
                        for exchange in decoder.overdue(time.time_ns() - int(OVERDUE * 1e9)):
                            shown(exchange)


def lines_of(exchange: "Exchange") -> list[str]:
    """One line per thing asked for; the first has time, client, device and duration."""
    seconds, rest = divmod(exchange.time_ns, 1_000_000_000)
    clock = f"{time.strftime('%H:%M:%S', time.localtime(seconds))}.{rest // 1_000_000:03}"
    way = "←" if exchange.command == "notification" else "→"
    head = f"{clock}  {exchange.peer} {way} {exchange.device.port}"
    tail = ""
    if exchange.duration_ns is not None:
        tail = f"  ({exchange.duration_ns / 1e6:.2f} ms)"
    elif not exchange.answered:
        tail = "  ✗ no answer"
    first, *others = exchange.items or (None,)
    text = exchange.command if first is None else first.text
    if others:
        text = f"{len(exchange.items)} at once: {text}"
    lines = [
        f"{head}  {text}{tail}",
        *(f"{' ' * len(head)}  {item.text}" for item in others if item),
    ]
    return [visible(line) for line in lines]


# where captures come from -------------------------------------------------------------------------


@contextlib.asynccontextmanager
async def _watching(
    host: str,
    tcp_port: int,
    via: str | None,
    see: Callable[["Captured"], None],
    decoder: "Decoder | None" = None,
    devices: "Sequence[AmsAddress]" = (),
) -> AsyncIterator[None]:
    """Call `see` with all that passes: the station's own tap, or a relay in front of `via`.

    The symbols of `devices` behind it are read first.
    """
    if via is None:
        async with _station_tap(host, tcp_port, see, decoder):
            yield
    else:
        where = _endpoint(via)
        if decoder is not None:
            await _request(where, devices, decoder)
        async with _relay(host, tcp_port, where, see):
            yield


def _endpoint(via: str) -> tuple[str, int]:
    """Return host and TCP port of `HOST[:PORT]`."""
    from achse.ams.host_port import host_and_port

    try:
        return host_and_port(via, 48898)
    except ValueError:
        raise typer.BadParameter(f"expected HOST[:PORT], got {via!r}", param_hint="--via") from None


def _device(text: str) -> "AmsAddress":
    """Return the AMS address of `NETID[:PORT]`."""
    from achse.ams import AmsAddress

    try:
        return AmsAddress(text if ":" in text else f"{text}:{PLC_PORT}")
    except ValueError as fault:
        raise typer.BadParameter(str(fault), param_hint="--ask") from None


async def _request(
    via: tuple[str, int], devices: "Sequence[AmsAddress]", decoder: "Decoder"
) -> None:
    """Read the symbols of devices.

    The connection ends before those of clients begin: real routers have room for one per host.
    """
    from achse.client import connect
    from achse.client.links.link import TcpDialer

    if not devices:
        return
    async with connect(TcpDialer(*via), reconnect=False, watch_symbols=False) as client:
        for device in devices:
            await _upload(client.at_port(device.port, device.net_id), decoder)


@contextlib.asynccontextmanager
async def _relay(
    host: str, tcp_port: int, via: tuple[str, int], see: Callable[["Captured"], None]
) -> AsyncIterator[None]:
    from achse.monitor.relay import Relay
    from achse.transport.reason import reason

    relay = Relay(*via, see)
    try:
        await relay.open(host, tcp_port)
    except OSError as failure:
        fail(f"cannot listen on {host}:{tcp_port}: {reason(failure)} (another address: --host)")
    print_event("ready", tap=f"{relay.host}:{relay.port}", via=f"{via[0]}:{via[1]}")
    try:
        yield
    finally:
        await relay.close()


@contextlib.asynccontextmanager
async def _station_tap(
    host: str,
    tcp_port: int,
    see: Callable[["Captured"], None],
    decoder: "Decoder | None",
) -> AsyncIterator[None]:
    from achse.ams import AdsError, AmsAddress, RouterError
    from achse.client import connect
    from achse.client.links.link import TcpDialer
    from achse.codes import ReturnCode
    from achse.devices.taps import TAPS
    from achse.router import LOOPBACK_NET_ID
    from achse.router.tap import decode_batch

    async with connect(
        TcpDialer(host, tcp_port), port=STATION_PORT, reconnect=False, watch_symbols=False
    ) as client:
        try:
            await client.state()
        except RouterError as refusal:
            if refusal.code != ReturnCode.TARGET_PORT_NOT_FOUND.number:
                raise
            fail(f"{host}:{tcp_port} is not an achse station: tap in front of it with --via")
        plc = client.at_port(PLC_PORT)
        if decoder is not None:
            decoder.names.alias(plc.address, AmsAddress.of(LOOPBACK_NET_ID, PLC_PORT))
            with contextlib.suppress(AdsError):  # it may have no PLC
                await _upload(plc, decoder)
        tap = int.from_bytes(await client.read_write_raw(TAPS, 0, 4, b""), "little")

        ending = asyncio.Event()

        async def fetch() -> None:
            last = False
            while not last:
                last = ending.is_set()  # what has passed until then is still fetched
                batch = await client.read_raw(TAPS, tap, FETCH_BYTES)
                for capture in decode_batch(batch):
                    see(capture)
                if decoder is not None:
                    with contextlib.suppress(AdsError):
                        await _upload(plc, decoder)
                if not batch:
                    with contextlib.suppress(TimeoutError):
                        await asyncio.wait_for(ending.wait(), FETCH_EVERY)

        watcher = asyncio.current_task()
        assert watcher is not None
        fetching = asyncio.create_task(fetch())
        fetching.add_done_callback(lambda _: ending.is_set() or watcher.cancel())
        print_event("ready", tap="station")
        try:
            yield
        except asyncio.CancelledError:
            if fetching.done():
                fetching.result()  # its error is reported
            raise
        finally:
            ending.set()
            await asyncio.gather(fetching, return_exceptions=True)
            with contextlib.suppress(AdsError):
                await client.write_raw(TAPS, tap, b"")


async def _upload(device: "Target", decoder: "Decoder") -> None:
    """Fetch all symbols and types of a device unless they are known, so that values have types."""
    known = decoder.names.learn(device.address)
    if known.is_whole:
        return
    known.is_whole = True
    known.learn_types(await device.types())
    for entry in await device.symbols():
        known.learn_symbol(entry)


def run_until_ended(job: Coroutine[Any, Any, None], host: str, tcp_port: int) -> None:
    """Run until done, Ctrl-C or SIGTERM; an AdsError is one line on stderr."""
    from achse.ams import AdsError
    from achse.cli.interrupts import Interrupted, run

    try:
        run(job)
    except AdsError as refusal:
        fail_to_connect(refusal, host, tcp_port)
    except BrokenPipeError:  # the reader has ended, as `head` does
        raise
    except OSError as failure:
        fail(f"{failure.filename}: {failure.strerror}" if failure.filename else str(failure))
    except Interrupted:
        pass
