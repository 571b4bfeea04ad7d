"""The watch over a channel: its path and states hold, and each kind of wrong one is reported."""

from collections.abc import Callable
from dataclasses import replace
from math import hypot
from typing import Any

import pytest

from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState
from achse.motion.path import PathParameters
from achse.swarm.channel_watch import ChannelWatch, Contour, reachable_states
from achse.swarm.play import play
from achse.swarm.worlds.channels import draw_channel, program_file
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import Act, DrawnClient, World

SECOND = 1_000_000_000
SEEDS = [seed for seed in range(40) if draw_channel(Stream(seed, "channel")) is not None][:3]


def world(seed: int) -> World:
    calls = [
        (0x2200, "load_program_by_name", program_file(0)),
        (0x2200, "start_interpreter", ()),
        (0x2300, "channel_velocity_override", [400_000]),
    ]
    acts = [Act(0, 0, "dial")] + [
        Act((n + 1) * SECOND // 10, 0, "channel", [group, 1, name, value])
        for n, (group, name, value) in enumerate(calls)
    ]
    channel = draw_channel(Stream(seed, "channel"))
    client = DrawnClient("operate", 0, 0, False)
    return World(2, 2 * SECOND, 2_000_000, clients=[client], acts=acts, channel=channel)


@pytest.mark.parametrize("seed", SEEDS)
def test_program_keeps_its_contour_and_its_states(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: set[InterpreterState] = set()
    look = ChannelWatch.look

    def noted(self: ChannelWatch, when: str, *, requested: bool) -> bool:
        active = look(self, when, requested=requested)
        seen.add(self._state)
        return active

    monkeypatch.setattr(ChannelWatch, "look", noted)
    assert play(world(seed)).violation is None
    assert len(seen) > 2


def rounded() -> World:
    """A world with a program whose corners are rounded."""
    text = "F3000\n#set paramVertexSmoothing(5;1;0.5)#\nN1 G1 X9.0\nN2 G1 Y9.0\nN3 G1 X0.0\nM30\n"
    swarm_world = world(SEEDS[0])
    assert swarm_world.channel is not None
    return replace(
        swarm_world, length_ns=8 * SECOND, channel=replace(swarm_world.channel, programs=[text])
    )


def test_corner_within_its_tolerance_holds() -> None:
    assert play(rounded()).violation is None


def test_path_beside_its_contour_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    violation = _violation(rounded(), monkeypatch, PathParameters, "fill", _rounder)
    assert violation == "path-tolerance"


def test_state_without_a_transition_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def confused(
        original: Callable[..., None], channel: ProgramChannel, *arguments: object
    ) -> None:
        original(channel, *arguments)
        if channel.state is InterpreterState.END:
            channel.state = InterpreterState.FLUSHING

    violation = _violation(rounded(), monkeypatch, ProgramChannel, "step", confused)
    assert violation == "channel-states"


def _rounder(original: Callable[..., None], parameters: PathParameters, state: Any) -> None:
    original(parameters, state)
    state.smoothing_radius *= 20.0


def _violation(
    world: World, patch: pytest.MonkeyPatch, where: type, name: str, wrong: Callable[..., None]
) -> str:
    original = getattr(where, name)
    patch.setattr(where, name, lambda self, *arguments: wrong(original, self, *arguments))
    violation = play(world).violation
    assert violation is not None
    return violation.invariant


def test_contour_has_lines_and_circles() -> None:
    text = "F100\nN1 G1 X3.0 Y4.0\nN2 G2 X5.0 Y4.0 I1.0 J0\nN3 G0 X5.0 Y0.0\nM30\n"
    contour = Contour(text, (0.0, 0.0, 1.0))
    assert contour.distance((1.5, 2.0, 1.0)) < 1e-12
    assert contour.distance((4.0, 5.0, 1.0)) < 1e-12
    assert contour.distance((5.0, 0.0, 3.0)) == 2.0
    assert abs(contour.distance((-1.0, -1.0, 1.0)) - hypot(1.0, 1.0)) < 1e-12


def test_states_of_a_channel_without_a_request() -> None:
    state = InterpreterState
    assert reachable_states(state.IDLE) == {state.IDLE}
    assert state.READY in reachable_states(state.END)
    assert state.IDLE not in reachable_states(state.RUNNING)
