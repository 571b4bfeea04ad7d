"""Worlds of motion alone are drawn: equal seeds equally, without what is around a station."""

from achse.swarm.worlds.motion import draw_motion_world
from achse.swarm.worlds.world import World


def test_equal_seeds_are_equal_worlds_that_can_be_written_down() -> None:
    for seed in (0, 1, (1 << 64) - 1):
        world = draw_motion_world(seed)
        assert draw_motion_world(seed) == world
        assert World.decode(world.encode()).encode() == world.encode()


def test_worlds_differ_in_axes_channels_and_rates() -> None:
    worlds = [draw_motion_world(seed) for seed in range(24)]
    assert {len(world.axes) for world in worlds} == {1, 2, 3, 4, 5}
    assert {world.channel is None for world in worlds} == {True, False}
    rates = sorted(len(world.acts) / world.length_ns * 1e9 for world in worlds)
    assert rates[0] < 10 < 100 < rates[-1]
    assert all(not world.clients and not world.programs and world.motion_only for world in worlds)
