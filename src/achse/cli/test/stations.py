"""Check of a station.toml: its keys, its parts, and the first cycles of its PLCs."""

import sys
from pathlib import Path

import typer

from achse.cli.output import print_json
from achse.cli.start.run import load_station
from achse.cli.test.trial import TrialResult, try_runtime
from achse.devices.plc import PlcDevice
from achse.station import Station


def check_station(file: Path, as_json: bool = False) -> None:
    """Validate a station.toml, and run the first cycles of its PLCs in virtual time.

    Ends with 1 if one of them stops.
    """
    station = load_station(file, None, wall_clock=False)
    verdicts = _verdicts(station)
    runs = all(verdict.runs for verdict in verdicts.values())
    devices, axes = len(station.devices), len(station.config.axis)
    if as_json:
        print_json(
            {
                "file": str(file),
                "devices": devices,
                "axes": axes,
                "warnings": list(station.warnings),
                "would_run": runs,
                "verdicts": {name: str(verdict) for name, verdict in verdicts.items()},
            }
        )
    else:
        for warning in station.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        for name, verdict in verdicts.items():
            if not verdict.runs:
                print(f"{name} {verdict}", file=sys.stderr)
        print(f"{file}: {devices} devices, {axes} axes: {'ok' if runs else 'would not run'}")
    if not runs:
        raise typer.Exit(1)


def _verdicts(station: Station) -> dict[str, TrialResult]:
    """Try the PLCs with Structured Text, without those that run Python classes of the user: these
    may act outside of the PLC."""
    for device in station.devices:
        if isinstance(device, PlcDevice) and device.program_requests is not None:
            device.program_requests.disconnect()  # no file is written, no axis moves
    return {
        plc.name: try_runtime(plc)
        for config, plc in zip(station.config.plc, station.plcs.values(), strict=True)
        if plc.bodies is not None and not config.has_python
    }
