"""The watch over axes: it sees each cycle of a move, and sleeps while all axes rest."""

import math

import pytest

from achse.motion import commands
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.swarm.motion.checks import NAMES
from achse.swarm.motion.watch import MotionWatch
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.world import DrawnAxis


def rig(seed: int) -> tuple[Station, MotionWatch, list[str]]:
    part: DrawnAxis = draw_world(seed).axes[0]
    axis = {"id": 1, "name": part.name, **part.values}
    station = Station(parse({"axis": [axis]}, "test"))
    reported: list[str] = []
    watch = MotionWatch(
        station, [part], NAMES, lambda name, what: reported.append(f"{name} {what}")
    )
    station.cycle.add(watch)
    return station, watch, reported


@pytest.mark.parametrize("seed", range(6))
def test_move_is_seen_and_then_the_watch_sleeps(seed: int) -> None:
    station, watch, reported = rig(seed)
    station.advance(1.0)
    assert watch.due_ns == math.inf
    seen = watch.cycles
    assert station.nc is not None
    axis = station.nc.axis(1)
    way = 0.2 * axis.max_velocity
    watch.wake()
    assert commands.universal_start(axis, 2, way, axis.max_velocity) == 0
    station.advance(0.1)
    assert watch.cycles > seen
    assert watch.moves == 1
    station.advance(1000.0)
    assert watch.due_ns == math.inf
    assert reported == []


def test_set_point_that_jumps_is_reported() -> None:
    station, watch, reported = rig(1)
    station.advance(0.1)
    watch.wake()
    assert station.nc is not None
    station.nc.axis(1).set.position += 1.0
    station.advance(0.1)
    assert any(each.startswith("position axis") for each in reported)


def test_axes_of_the_next_nc_are_seen_after_a_restart() -> None:
    station, watch, reported = rig(2)
    station.advance(0.1)
    station.restart()
    watch.wake()
    station.advance(2.0)
    seen = watch.cycles
    watch.wake()
    station.advance(0.1)
    assert watch.cycles > seen
    assert reported == []
