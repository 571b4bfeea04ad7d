"""`achse record`, `achse replay` and `achse diff`: a target's answers kept, served and compared."""

import asyncio
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.monitor import Host, TcpPort, Via, run_until_ended, watching
from achse.cli.run import fail

if TYPE_CHECKING:
    from achse.monitor.recording import Recording

__all__ = ["register"]

Capture = Annotated[Path, typer.Argument(help="A capture: pcapng or pcap.")]


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    app.command()(record)
    app.command()(replay)
    app.command()(diff)


def record(
    file: Annotated[Path, typer.Argument(help="Where to write the capture (pcapng).")],
    via: Via = None,
    duration: Annotated[
        float | None, typer.Option("--for", metavar="SECONDS", min=0, help="End after that time.")
    ] = None,
    host: Host = "127.0.0.1",
    tcp_port: TcpPort = 48898,
) -> None:
    """Keep what passes, until Ctrl-C: on a station of ours, or --via in front of any target."""
    run_until_ended(_record(file, via, duration, host, tcp_port))


async def _record(
    file: Path, via: str | None, duration: float | None, host: str, tcp_port: int
) -> None:
    from achse.monitor.capture import CaptureWriter

    with CaptureWriter(file) as write:
        try:
            async with watching(host, tcp_port, via, write):
                await asyncio.sleep(1e9 if duration is None else duration)
        finally:
            print(f"{file}: {write.count} packets")


def replay(
    file: Capture,
    host: Annotated[str, typer.Option(envvar="ACHSE_HOST", help="Where to listen.")] = "127.0.0.1",
    tcp_port: TcpPort = 48898,
) -> None:
    """Serve a recording as the target it was taken from, until Ctrl-C."""
    run_until_ended(_replay(_recording(file), host, tcp_port))


async def _replay(recording: "Recording", host: str, tcp_port: int) -> None:
    from achse.monitor.replay import Replay
    from achse.transport.reason import reason

    target = Replay(recording)
    try:
        async with target.serving(host, tcp_port) as listener:
            print(
                f"achse ready net_id={recording.net_id} tcp={listener.host}:{listener.port}"
                f" ports={','.join(map(str, target.router.ports))}",
                flush=True,
            )
            with contextlib.suppress(asyncio.CancelledError):
                await asyncio.get_running_loop().create_future()
    except OSError as failure:
        fail(f"cannot listen on {host}:{tcp_port}: {reason(failure)} (another address: --host)")


def diff(first: Capture, second: Capture) -> None:
    """Compare what two targets answered.

    Exit code 1 if it differs, 2 if a capture cannot be read.
    """
    from achse.monitor.names import rows_of
    from achse.monitor.recording import differences
    from achse.station import Station

    recordings = _recording(first, 2), _recording(second, 2)
    found = list(differences(*recordings, rows_of(Station.demo().devices)))
    if found:
        print("\n".join(found))
        sys.exit(1)


def _recording(file: Path, trouble: int = 1) -> "Recording":
    """The recording in a file; without one, the exit code is `trouble`."""
    from achse.monitor.capture import CaptureError, read_capture
    from achse.monitor.recording import Recording

    try:
        recording = Recording(read_capture(file))
    except CaptureError as failure:
        fail(str(failure), trouble)
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", trouble)
    if not recording.devices:
        fail(f"{file}: no AMS packets to or from port 48898", trouble)
    return recording
