"""The track of a world: the last cycles, of all axes, with the same outcome as without it."""

from dataclasses import replace
from itertools import pairwise

import pytest

from achse.motion import AxisParameters, Nc
from achse.swarm.play import play
from achse.swarm.track import Track
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.motion import draw_motion_world
from achse.swarm.worlds.world import World

SECOND = 1_000_000_000


@pytest.mark.parametrize("motion", [True, False])
def test_each_cycle_is_recorded_and_changes_nothing(motion: bool) -> None:
    drawn = draw_motion_world(3) if motion else draw_world(3)
    world: World = replace(drawn, length_ns=SECOND // 2, clients=drawn.clients[:0], acts=[])
    if motion:
        world = replace(world, acts=[a for a in drawn.acts if a.at_ns < SECOND // 2])
    track = Track()
    outcome = play(world, track=track)
    assert outcome.digest == play(world).digest
    assert track.names == [axis.name for axis in world.all_axes]
    times, *values = track.columns()
    assert len(track) == len(times) >= world.length_ns // world.cycle_ns
    assert {round((b - a) * 1e9) for a, b in pairwise(times)} == {world.cycle_ns}
    assert len(values) == 3 * len(world.all_axes)


def test_only_the_last_cycles_are_kept() -> None:
    nc, track = Nc(2_000_000, [AxisParameters(1)]), Track(5)
    for cycle in range(12):
        track.take(cycle * 2_000_000, nc)
    assert track.columns()[0] == pytest.approx([0.014, 0.016, 0.018, 0.020, 0.022])
