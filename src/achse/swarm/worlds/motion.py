"""Worlds of motion alone: axes, cams, perhaps a channel, and commands one after the other."""

from dataclasses import replace

from achse.swarm.worlds.channels import draw_channel, draw_channel_acts
from achse.swarm.worlds.couplings import draw_rare_motion
from achse.swarm.worlds.drawing import draw_axis, draw_cam
from achse.swarm.worlds.draws import Stream, moments
from achse.swarm.worlds.layers import LEAST_PART, draw_layers, layered
from achse.swarm.worlds.operators import draw_motion
from achse.swarm.worlds.world import Act, World

_SECOND = 1_000_000_000
_MOST_ACTS = 2000
_CYCLES_US = (125, 500, 1000, 1000, 2000, 2000, 2000, 4000, 10_000)


def draw_motion_world(seed: int) -> World:
    """Draw the world of motion of a seed."""
    draws = Stream(seed, "motion world")
    axes = [draw_axis(Stream(seed, "axis", n), n) for n in range(draws.randrange(1, 6))]
    if draws.chance(0.5):  # axes alike can follow each other
        axes = [replace(axes[0], name=part.name) for part in axes]
    values = {"allow_slave_motion_commands": draws.randrange(2)}
    axes = [replace(part, values={**part.values, **values}) for part in axes]
    wide = draws.chance(0.5)
    if wide:
        axes = [
            replace(
                part,
                values=layered(Stream(seed, "layers", n), part),
                gentlest=part.gentlest * LEAST_PART,
            )
            for n, part in enumerate(axes)
        ]
    cams = [draw_cam(Stream(seed, "cam", n)) for n in range(draws.randrange(3))]
    rate = draws.decades(0.3, 2.3)
    length_ns = round(min(draws.decades(0.5, 2.0), _MOST_ACTS / rate) * _SECOND)
    acts: list[Act] = []
    stream = Stream(seed, "operators")
    for moment in moments(stream, rate, length_ns):
        acts += draw_motion(stream, moment, 0, axes, len(cams))
    if len(axes) > 1:
        stream = Stream(seed, "rare motion")
        rare = list(moments(stream, rate * draws.decades(-1.5, -0.5), length_ns))
        acts += draw_rare_motion(stream, axes, 1, rare)
    if wide:
        stream = Stream(seed, "layers")
        layers = list(moments(stream, rate * draws.decades(-1.5, 0.0), length_ns))
        acts += draw_layers(stream, axes, len(cams), layers)
    channel = draw_channel(Stream(seed, "channel")) if draws.chance(0.3) else None
    if channel is not None:
        stream = Stream(seed, "channel acts")
        programs = list(moments(stream, stream.decades(-0.5, 0.5), length_ns))
        acts += draw_channel_acts(stream, channel, len(axes) + 1, 1, programs)
    return World(
        *(seed, length_ns, draws.choice(_CYCLES_US) * 1000, axes, cams),
        acts=sorted(acts, key=lambda act: act.at_ns),
        channel=channel,
        motion_only=True,
    )
