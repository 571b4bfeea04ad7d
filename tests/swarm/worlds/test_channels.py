"""Channels of worlds: all that they draw is there, and programs are read by the interpreter."""

import pytest

from achse.codes.nc.table import named_rows
from achse.gcode.text.program import PartProgram
from achse.swarm.clients import encode_service
from achse.swarm.worlds.channels import draw_channel, draw_channel_acts
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import World

DRAWN = [seed for seed in range(60) if draw_channel(Stream(seed, "channel")) is not None]


def test_some_worlds_have_a_channel() -> None:
    assert 10 < len(DRAWN) < 40


@pytest.mark.parametrize("seed", DRAWN[:8])
def test_requests_to_a_channel_are_services_of_the_nc(seed: int) -> None:
    channel = draw_channel(Stream(seed, "channel"))
    assert channel is not None
    for text in channel.programs:
        assert PartProgram(text, "part").name == "part"
    acts = draw_channel_acts(Stream(seed, "acts"), channel, 3, 2, range(0, 10_000, 100))
    assert acts == draw_channel_acts(Stream(seed, "acts"), channel, 3, 2, range(0, 10_000, 100))
    assert {act.kind for act in acts} == {"channel", "nc"}
    for act in acts:
        if act.kind == "channel":
            group, _, name, value = act.values
            assert name in named_rows(group)
            encode_service(group, name, value)
        else:
            assert act.values[2] in range(3, 3 + len(channel.axes))
    world = World(seed, 1, 1, acts=acts, channel=channel)
    assert World.decode(world.encode()) == World.decode(World.decode(world.encode()).encode())
    assert World.decode(world.encode()).channel == channel
