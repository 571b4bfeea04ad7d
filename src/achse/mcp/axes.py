"""Axes and buses as tools show them, and what a tool may have an axis do."""

from typing import Literal

from achse.client.nc.axis import RemoteAxis
from achse.codes.ethercat import AlState
from achse.mcp.results import AxisReport, BusReport, DriveReport
from achse.station import Station

AxisAction = Literal[
    "state", "enable", "disable", "reset", "home", "move_to", "move_by", "move_velocity", "halt"
]

_LONGEST_S = 600.0
"""Seconds of station time that a move may take."""


async def command(
    axis: RemoteAxis,
    action: AxisAction,
    *,
    target: float,
    velocity: float,
    acceleration: float,
    wait: bool,
    patience: float,
) -> None:
    """Command an axis, and wait for the end. Raises AdsError, ValueError."""
    match action:
        case "state":
            return
        case "enable":
            await axis.enable()
        case "disable":
            await axis.disable()
        case "reset":
            await axis.reset()
        case "home":
            await axis.home(wait=wait, within=_LONGEST_S, patience=patience)
        case "halt":
            await axis.halt(wait=wait, within=_LONGEST_S, patience=patience)
        case "move_velocity":
            await axis.move_velocity(
                velocity, acceleration=acceleration, wait=wait, within=_LONGEST_S, patience=patience
            )
        case "move_to" | "move_by":
            move = axis.move_to if action == "move_to" else axis.move_by
            await move(
                target,
                velocity=velocity,
                acceleration=acceleration,
                wait=wait,
                within=_LONGEST_S,
                patience=patience,
            )


async def axis_report(axis: RemoteAxis) -> AxisReport:
    """Return the state of an axis. Raises AdsError."""
    status, error = await axis.status(), await axis.error()
    return AxisReport(
        id=await axis.id(),
        name=await axis.name(),
        position=status.position,
        velocity=status.velocity,
        set_position=status.set_position,
        enabled=status.enabled,
        homed=status.homed,
        in_target=status.in_target,
        state=status.state.value,
        error_code=status.error_code,
        error="" if error is None else str(error),
    )


def bus_reports(station: Station) -> list[BusReport]:
    """Return the buses of a station: slaves in the order of the line, drives with their state."""
    reports = []
    for name, bus in station.fieldbuses.items():
        drives = dict(zip(map(id, bus.slaves), getattr(bus, "drives", ()), strict=False))
        slaves = []
        for slave in bus.master.slaves:
            drive = drives.get(id(slave))
            slaves.append(
                DriveReport(
                    station=slave.station,
                    name=slave.name,
                    state=_state(slave.state),
                    al_code=slave.al_code,
                    present=slave.present,
                    power_state="" if drive is None else drive.power_state.name.lower(),
                )
            )
        reports.append(BusReport(name=name, operational=bus.master.operational, slaves=slaves))
    return reports


def _state(number: int) -> str:
    try:
        return AlState(number).name
    except ValueError:
        return "none" if number == 0 else f"{number}"
