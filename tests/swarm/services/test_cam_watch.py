"""The watch over a camshaft controller: exact angles, and a cam that switches late."""

from typing import Any

import pytest

from achse.camshaft import kernel
from achse.motion import commands
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.swarm.services.cam_watch import CamWatch, switched

SHAFT: dict[str, Any] = {
    "name": "Press",
    "axis": "A1",
    "units_per_turn": 50.0,
    "increments": 4096,
    "zero_point": 123,
    "reversed": True,
    "or_mask": 4,
    "cam": [
        {"type": "way", "start": 10, "end": 200, "track": 1},
        {"type": "way", "start": 300, "end": 20, "track": 0},
    ],
}


def watched(axis: dict[str, Any]) -> tuple[list[str], CamWatch]:
    values = {"control_dword": 7, "velocity_override": 1_000_000, "max_velocity": 1000.0}
    table = {"id": 1, "name": "A1", **values, **axis}
    document = {
        "nc": {"cycle": "2ms", "code": "plain"}, "axis": [table], "camshaft": [SHAFT],
    }  # fmt: skip
    station = Station(parse(document, "world"))
    reports: list[str] = []
    watch = CamWatch(station, SHAFT, lambda name, what: reports.append(name))
    station.cycle.add(watch)
    station.cycle.go_to(20_000_000)
    assert station.nc is not None
    assert commands.universal_start(station.nc.axis(1), 1, 220.0, 800.0, 5000.0, 5000.0, 1e6) == 0
    station.cycle.go_to(500_000_000)
    return reports, watch


@pytest.mark.parametrize(
    ("position", "tracks"),
    [(0.0, 0b101), (10.0, 0b110), (2.0, 0b111), (-1.0, 0b101), (360.0, 0b110)],
)
def test_tracks_follow_from_the_angle(position: float, tracks: int) -> None:
    shaft = {**SHAFT, "reversed": False, "zero_point": 0}
    assert switched(shaft, position) == (tracks, 0)
    assert switched({**shaft, "reversed": True}, -position) == (tracks, 0)
    moved = {**shaft, "zero_point": 900}
    assert switched(moved, position - 12.5) == (tracks, 0)


def test_edge_may_switch_either_way() -> None:
    on, at_edge = switched({**SHAFT, "reversed": False, "zero_point": 0}, 50.0 * 200.0 / 360.0)
    assert at_edge == 0b10
    assert on & ~at_edge == 0b100


def test_controller_switches_exactly() -> None:
    reports, watch = watched({})
    assert (reports, watch.looks > 200) == ([], True)


def test_cam_that_switches_late_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def inside(cam: Any) -> bool:
        length = (10.0 * (cam.end - cam.start)) % 3600.0
        return bool((cam.place - 10.0 * cam.start - 5.0) % 3600.0 < length)

    monkeypatch.setattr(kernel, "_inside", inside)
    reports, _ = watched({})
    assert set(reports) == {"cam-switching"}
