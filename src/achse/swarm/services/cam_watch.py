"""The watch over a camshaft controller: each track is on exactly within the angles of its cams."""

from collections.abc import Callable, Mapping
from typing import Any

from achse.devices.camshaft import CamshaftDevice
from achse.station import Station
from achse.station.clocks.cycle import Phase, PhasePlace

_ALL = 0xFFFF_FFFF
_EDGE = 1e-7
"""Angle in degrees next to which a cam may switch either way: rounding of the position."""


def switched(config: Mapping[str, Any], position: float) -> tuple[int, int]:
    """Return the tracks that are on at a position of the axis, and those at an edge there."""
    angle = 360.0 * position / config["units_per_turn"] + 0.1 * config["zero_point"]
    angle = (-angle if config["reversed"] else angle) % 360.0
    edge = _EDGE + 1e-13 * abs(360.0 * position / config["units_per_turn"])
    on = at_edge = 0
    for cam in config["cam"]:
        start, end = cam["start"], cam["end"]
        inside = start <= angle < end if start <= end else angle >= start or angle < end
        near = min(abs((angle - each + 180.0) % 360.0 - 180.0) for each in (start, end)) <= edge
        on |= inside << cam["track"]
        at_edge |= near << cam["track"]
    return on | config["or_mask"], at_edge


class CamWatch(Phase):
    """Phase that compares tracks with the angle, in each cycle of the controller."""

    place, name = PhasePlace.SCOPE, "swarm cams"
    due_ns: float = 0

    def __init__(
        self, station: Station, config: Mapping[str, Any], report: Callable[[str, str], None]
    ) -> None:
        self._station = station
        self._config = config
        self._report = report
        self._nc: Any = None
        self._controller: Any = None
        self._axis: Any = None
        self._last: tuple[float, int] | None = None
        self.looks = 0
        """Cycles in which the tracks were compared."""

    def begin(self, earliest_ns: int) -> None:
        """Look from the first cycle on."""
        self.due_ns = earliest_ns

    def step(self, now_ns: int) -> None:
        """Look at the tracks after a cycle of the controller."""
        nc = self._station.nc
        if nc is None:
            self.due_ns = now_ns + 1_000_000
            self._nc = None
            return
        if now_ns % nc.cycle_ns:
            self.due_ns = now_ns - now_ns % nc.cycle_ns + nc.cycle_ns
            return
        self.due_ns = now_ns + nc.cycle_ns
        if nc is not self._nc:
            self._nc = nc
            self._axis = next(each for each in nc if each.name == self._config["axis"])
            device = next(
                each for each in self._station.devices if isinstance(each, CamshaftDevice)
            )
            self._controller = device.camshafts[0]
        self.looks += 1
        position = self._axis.actual_position
        outputs = self._controller.controller.record.outputs
        if (position, outputs) == self._last:
            return
        self._last = position, outputs
        expected, at_edge = switched(self._config, position)
        if (outputs ^ expected) & ~at_edge & _ALL:
            self._report(
                "cam-switching",
                f"{self._config['axis']} at {position} {now_ns / 1e9:.6f} s: tracks {outputs:#x},"
                f" expected {expected:#x}",
            )
