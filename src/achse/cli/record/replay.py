"""`achse replay` and `diff`: recorded answers of targets, served and compared."""

import asyncio
import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_event, print_json
from achse.cli.record.monitor import TcpPort, run_until_ended
from achse.cli.target import Json, endpoint

if TYPE_CHECKING:
    from achse.monitor.recording import Recording

Capture = Annotated[Path, typer.Argument(help="A capture: pcapng or pcap.")]
Compared = Annotated[
    Path,
    typer.Argument(
        help="A capture: .pcapng or .pcap; or symbols: .tmc, .tpy, sources, - for the running PLC."
    ),
]

_ENDINGS = {".pcap", ".pcapng"}
"""Endings of captures."""

_MAGIC = {
    *(bytes.fromhex("0a0d0d0a"), bytes.fromhex("a1b2c3d4"), bytes.fromhex("d4c3b2a1")),
    *(bytes.fromhex("a1b23c4d"), bytes.fromhex("4d3cb2a1")),
}
"""First bytes of captures: pcapng; pcap in either byte order, with µs or ns."""


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    app.command()(replay)
    app.command()(diff)


def replay(
    file: Capture,
    host: Annotated[str, typer.Option(envvar="ACHSE_HOST", help="Where to listen.")] = "127.0.0.1",
    tcp_port: TcpPort = 48898,
    as_json: Json = False,
) -> None:
    """Serve a recording as the target it was taken from, until Ctrl-C."""
    host, tcp_port = endpoint(host, tcp_port)
    run_until_ended(_replay(_recording(file), host, tcp_port), host, tcp_port)


async def _replay(recording: "Recording", host: str, tcp_port: int) -> None:
    from achse.monitor.replay import Replay
    from achse.transport.reason import reason

    target = Replay(recording)
    try:
        async with target.serving(host, tcp_port) as listener:
            print_event(
                "ready",
                net_id=str(recording.net_id),
                tcp=f"{listener.host}:{listener.port}",
                ports=",".join(map(str, target.router.ports)),
            )
            with contextlib.suppress(asyncio.CancelledError):
                await asyncio.get_running_loop().create_future()
    except OSError as failure:
        fail(f"cannot listen on {host}:{tcp_port}: {reason(failure)} (another address: --host)")


def diff(
    first: Compared,
    second: Compared,
    places: Annotated[
        bool, typer.Option("--places", help="Of symbols: compare addresses as well.")
    ] = False,
    port: Annotated[
        int, typer.Option(min=1, max=65535, help="Of symbols: AMS port of the running PLC.")
    ] = 851,
    as_json: Json = False,
) -> None:
    """Compare the answers of two targets, or the types and variables of two PLCs.

    Exit code 1 if they differ, 2 if a capture cannot be read. The running PLC is at ACHSE_HOST and
    ACHSE_TCP_PORT, else on this host.
    """
    if not (_is_capture(first) or _is_capture(second)):
        from achse.cli.plc.symbols import report_differences

        report_differences(first, second, places, port, as_json)
        return
    from achse.monitor.names import rows_of
    from achse.monitor.recording import differences
    from achse.station import Station

    recordings = _recording(first, 2), _recording(second, 2)
    lines = list(differences(*recordings, rows_of(Station.demo().devices)))
    if as_json:
        print_json(lines)
    elif lines:
        print("\n".join(lines))
    if lines:
        raise typer.Exit(1)


def _is_capture(file: Path) -> bool:
    """Return True if a file is a capture by its ending or its first bytes."""
    if file.suffix.lower() in _ENDINGS:
        return True
    try:
        with file.open("rb") as content:
            return content.read(4) in _MAGIC
    except OSError:
        return False


def _recording(file: Path, trouble: int = 1) -> "Recording":
    """Return the recording in a file; without one, the exit code is `trouble`."""
    from achse.monitor.capture import CaptureError, read_capture
    from achse.monitor.recording import Recording

    try:
        recording = Recording(read_capture(file))
    except CaptureError as failure:
        fail(str(failure), trouble, name="CAPTURE")
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", trouble)
    if not recording.devices:
        fail(f"{file}: no AMS packets to or from port 48898", trouble)
    return recording
