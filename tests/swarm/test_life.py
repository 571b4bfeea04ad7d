"""A life of a station: its configuration, its acts, and its end."""

from pathlib import Path

import pytest

from achse.ams import AdsState
from achse.swarm.disk import MemoryDisk
from achse.swarm.life import StationLife, configuration
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.world import World

WORLD = draw_world(6)


@pytest.fixture
def life(tmp_path: Path) -> StationLife:
    return StationLife(WORLD, tmp_path, MemoryDisk(), 5_000_000_000, "plain", (), print)


@pytest.mark.parametrize("seed", range(10))
def test_configuration_has_what_was_drawn(seed: int) -> None:
    world: World = draw_world(seed)
    config = configuration(world, "plain")
    assert [axis.name for axis in config.axis] == [part.name for part in world.all_axes]
    assert len(config.table) == len(world.cams)
    assert config.nc.cycle == world.cycle_ns


def test_time_of_a_life_begins_where_the_last_one_ended(life: StationLife) -> None:
    assert life.now_ns() == 5_000_000_000
    life.advance_to(5_100_000_000)
    assert life.now_ns() == 5_100_000_000
    assert life.station.time_ns == 100_000_000


def test_faults_and_changes_excuse_for_a_while(life: StationLife) -> None:
    life.advance_to(5_100_000_000)
    assert life.frames_ns() < 0
    life.act("fault", [{"kind": "drop", "lasting": 0.5}])
    life.advance_to(5_800_000_000)
    assert life.frames_ns() > life.now_ns()
    life.advance_to(8_000_000_000)
    assert life.frames_ns() < life.now_ns()
    life.act("restart", [])
    assert life.samples_ns() > life.now_ns() > life.frames_ns()
    life.act("fault", [{"kind": "no such fault"}])


def test_fault_of_requests_does_not_excuse_samples(life: StationLife) -> None:
    life.advance_to(5_100_000_000)
    life.act("fault", [{"kind": "drop", "lasting": 0.5, "command": "read"}])
    life.advance_to(5_200_000_000)
    assert life.frames_ns() > life.now_ns() > life.sample_frames_ns()
    assert life.samples_ns() < life.now_ns()
    life.act("fault", [{"kind": "drop", "lasting": 0.5, "command": "notification"}])
    assert life.sample_frames_ns() > life.now_ns()


def test_acts_change_the_station(life: StationLife) -> None:
    life.advance_to(5_010_000_000)
    life.act("inject", [1, "simulation_not_ready", 1])
    assert life.station.nc is not None
    assert life.station.nc.axis(1).machine.not_ready == 1
    life.act("full_disk", [True])
    assert life.disk.full
    life.act("online_change", [1])
    assert life.saved() == 0
    life.act("configure", [])
    life.advance_to(6_000_000_000)
    assert life.station.state is AdsState.CONFIG
    assert life.saved() is None
    life.end()
