"""Stations whose axes are on the drives of a bus."""

from typing import Any

from achse.station.configuration.station_file import parse
from achse.station.station import Station

__all__ = ["AXIS", "drive_station", "enable_axes"]

AXIS = {"max_velocity": 400.0, "default_acceleration": 2000.0, "default_deceleration": 2000.0,
        "default_jerk": 20_000.0}  # fmt: skip


def drive_station(*drives: dict[str, Any], **more: Any) -> Station:
    """Return a station with an axis on each drive."""
    document = {
        "bus": [{}],
        "axis": [{"id": n, "name": f"A{n}", **AXIS} for n in range(1, len(drives) + 1)],
        "drive": [{"axis": n} | drive for n, drive in enumerate(drives, 1)],
    }
    return Station(parse(document | more, "test"))


def enable_axes(station: Station) -> None:
    """Enable all axes, and let the station bring up their drives."""
    assert station.nc is not None
    for axis in station.nc:
        axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(1.5)
    assert [axis.loop_closed for axis in station.nc] == [1] * len(station.nc)
