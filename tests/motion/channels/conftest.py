"""A channel with an interpreter, a folder of programs, and three axes in its 3D group."""

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import pytest

from achse.gcode.canon import Handshake
from achse.gcode.state.mfunctions import MRule
from achse.motion import AxisParameters, Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState
from achse.motion.channels.store import ProgramStore
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import GroupType

ENABLED = {"control_dword": 7, "velocity_override": 1_000_000, "default_jerk": 20_000.0}
RULES = {
    40: MRule(handshake=Handshake.BEFORE_MOVE),
    41: MRule(handshake=Handshake.AFTER_MOVE),
    7: MRule(fast=Handshake.BEFORE_MOVE),
    8: MRule(fast=Handshake.AFTER_MOVE, auto_reset=True),
    9: MRule(clears=(7,)),
}


def drawn_dynamics(draw: Random) -> dict[str, float]:
    """Accelerations and jerk of axes over decades."""
    return {
        "default_acceleration": 10 ** draw.uniform(2.5, 4),
        "default_deceleration": 10 ** draw.uniform(2.5, 4),
        "max_acceleration": 2e4,
        "max_deceleration": 2e4,
        "default_jerk": 10 ** draw.uniform(4, 7),
    }


class ProgramRig:
    """`run(text)` loads and starts a program; `finish()` goes on to its end."""

    def __init__(self, folder: Path, **values: float) -> None:
        self.folder = folder
        self.nc = Nc(
            2_000_000,
            [AxisParameters(n, values=ENABLED | values) for n in (1, 2, 3, 4)],
            groups=[GroupParameters(11, GroupType.THREE_D, 1, axes=(1, 2, 3))],
            channels=[
                ChannelParameters(1, m_rules=RULES, store=ProgramStore(folder, folder / "data"))
            ],
        )
        channel, group = self.nc.channels.channel(1), self.nc.groups.group(11)
        assert isinstance(channel, ProgramChannel)
        assert isinstance(group, PathGroup)
        self.channel, self.group = channel, group
        self.cycle(3)

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            self.nc.cycle()

    def write(self, text: str, name: str = "part.nc") -> None:
        (self.folder / name).write_text(text, encoding="latin-1")

    def run(self, text: str) -> int:
        self.write(text)
        code = self.channel.load("part.nc")
        assert code == 0, hex(code)
        return self.channel.start()

    def until(self, condition: Callable[[], Any], seconds: float = 30.0) -> int:
        for n in range(round(seconds * 500)):
            if condition():
                return n
            self.nc.cycle()
        raise AssertionError(f"not within {seconds} s: {self.channel.state!r} at {self.at()}")

    def until_state(self, state: InterpreterState, seconds: float = 30.0) -> int:
        return self.until(lambda: self.channel.state is state, seconds)

    def finish(self) -> None:
        self.until_state(InterpreterState.READY)
        assert self.channel.error_code == 0

    def at(self) -> list[float]:
        """Set positions of X, Y and Z."""
        return [round(self.nc.axis(n).set_position, 6) for n in (1, 2, 3)]


@pytest.fixture
def program(tmp_path: Path) -> ProgramRig:
    return ProgramRig(tmp_path)


@pytest.fixture
def make_program(tmp_path: Path) -> Callable[..., ProgramRig]:
    return lambda **values: ProgramRig(tmp_path, **values)
