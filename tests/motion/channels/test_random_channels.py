"""Clients at random on one channel: axes never jump, limits hold, documented steps recover.

Part programs, starts, stops, resets, retries, the way back, enables, overrides, homing, couplings
and assignments come at any moment. Then the channel is stopped and reset, axes are reset, and a
program runs to its end, where it must.
"""

from collections.abc import Callable
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes.nc.choices import MotionPhase
from achse.gcode.canon import Handshake
from achse.gcode.state.mfunctions import MRule
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import InterpreterState
from achse.motion.channels.store import ProgramStore
from achse.motion.compiled import KERNEL
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import GroupType

CYCLE_S = 0.002
VELOCITY, ACCELERATION = 300.0, 3000.0
VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": VELOCITY,
    "max_acceleration": ACCELERATION,
    "max_deceleration": ACCELERATION,
    "default_jerk": 20_000.0,
}
RULES = {40: MRule(handshake=Handshake.BEFORE_MOVE), 7: MRule(fast=Handshake.BEFORE_MOVE)}
RESTING = (MotionPhase.NONE, MotionPhase.STOPPING, MotionPhase.GROUPED)
"""A reset is abrupt in other phases (004 §3.1.1)."""
LAST = "N1 G1 X1 Y2 Z3 F3000\nN2 X0 Y0\nM30"


class Clients:
    """A channel, five axes, and what clients may do to them; every cycle is checked."""

    def __init__(self, folder: Path, draw: Random) -> None:
        self.folder, self.draw = folder, draw
        self.nc = Nc(
            2_000_000,
            [AxisParameters(n, values=VALUES) for n in range(1, 6)],
            groups=[GroupParameters(11, GroupType.THREE_D, 1, axes=(1, 2, 3, 4))],
            channels=[ChannelParameters(1, m_rules=RULES, store=ProgramStore(folder))],
            compiled=KERNEL.available,
        )
        channel, group = self.nc.channels.channel(1), self.nc.groups.group(11)
        assert isinstance(channel, ProgramChannel)
        assert isinstance(group, PathGroup)
        self.channel, self.group = channel, group
        self.axes = list(self.nc)
        self.renamed = True
        self.before = [(0.0, 0.0)] * 5
        self.run(3)

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            homed = [axis.set_motion_phase == MotionPhase.HOMING for axis in self.axes]
            self.nc.cycle()
            now = [(axis.set_position, axis.set_velocity) for axis in self.axes]
            if not self.renamed:
                for known, (x0, v0), (x, v) in zip(homed, self.before, now, strict=True):
                    assert known or abs(x - x0) <= 1.01 * VELOCITY * CYCLE_S + 1e-4
                    assert known or abs(v - v0) <= 1.01 * ACCELERATION * CYCLE_S + 0.5
            self.before, self.renamed = now, False

    def load(self, text: str) -> int:
        (self.folder / "part.nc").write_text(text)
        return self.channel.load("part.nc")

    def program(self) -> str:
        draw, lines = self.draw, ["F6000"]
        if draw.random() < 0.4:
            lines.append(f"#set paramVertexSmoothing({draw.randint(2, 5)};1;{draw.random():.3f})#")
        for number in range(1, draw.randint(3, 20)):
            x, y, z, q = (draw.randint(-40, 40) for _ in range(4))
            lines.append(
                draw.choice(
                    (
                        *(f"N{number} G1 X{x} Y{y}", f"N{number} G1 X{x} Z{z} Q1={q}"),
                        *(f"N{number} G0 Y{y}", f"FLIN F{draw.randint(100, 20_000)}", "M40", "M7"),
                        f"N{number} G91\nG3 X{x} Y{y} B{abs(x) + abs(y) + 1}\nG90 G1",
                        *("G4 X0.05", "@714", f"G74 {draw.choice('XYZ')}"),
                        f"DYNOVR={draw.uniform(0.1, 1.0):.2f}",
                    )
                )
            )
        return "\n".join(lines)

    def _set_position(self, axis: Axis) -> None:
        self.renamed = commands.set_actual_position(axis, 1, self.draw.uniform(-5, 5)) == 0

    def _reset(self, axis: Axis) -> None:
        if axis.set_motion_phase in RESTING:
            commands.reset(axis)

    def _couple(self, axis: Axis) -> None:
        if self.draw.random() < 0.5:
            commands.couple(self.axes[4], 1, axis.axis_id, 0, 0, 1.0)
        else:
            commands.decouple(self.axes[4])

    def act(self) -> None:
        """One thing that a client does."""
        draw, channel, group = self.draw, self.channel, self.group
        axis = draw.choice(self.axes[:4])
        moves: list[Callable[[], object]] = [
            *[channel.start] * 3,
            *(channel.stop, channel.reset, channel.retry, channel.skip, group.step_on),
            *(group.stop, group.reset, group.clear, group.dissolve, channel.delete_distance_to_go),
            lambda: self.load(self.program()),
            lambda: group.emergency_stop(10 ** draw.uniform(2, 5), 10 ** draw.uniform(3, 7)),
            lambda: setattr(channel, "retrace_enable", draw.randint(0, 1)),
            lambda: channel.retrace(draw.random() < 0.5),
            lambda: channel.set_operation_mode(draw.choice((0, 1, 0x4000))),
            lambda: group.assign(draw.choice(([1, 2, 3, 4], [1, 2], [2, 1, 3], [1, 2, 3, 5]))),
            lambda: setattr(axis, "control_dword", draw.choice((7, 7, 6, 5, 3, 0))),
            lambda: setattr(axis, "velocity_override", draw.choice((0, 300_000, 1_000_000))),
            lambda: setattr(channel, "override", draw.choice((0, 1_000_000, 400_000))),
            lambda: setattr(channel, "granted", draw.randint(0, 1)),
            lambda: commands.start(axis, 1, draw.uniform(-50, 50), draw.uniform(1, 100)),
            *(lambda: commands.stop(axis), lambda: commands.home(axis)),
            *(lambda: self._set_position(axis), lambda: self._reset(axis)),
            lambda: self._couple(axis),
        ]
        draw.choice(moves)()

    def recover(self) -> None:
        """What the manual asks for after anything; it always helps."""
        for axis in self.axes:
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        channel, group = self.channel, self.group
        channel.override, channel.granted = 1_000_000, 0
        commands.decouple(self.axes[4])
        assert channel.set_operation_mode(0) == 0
        channel.stop()
        for axis in self.axes:
            commands.stop(axis)
        self.run(2000)
        assert channel.reset() == 0
        for axis in self.axes:
            commands.reset(axis)
        self.run(500)
        assert channel.state is InterpreterState.IDLE
        assert group.dissolve() == group.assign([1, 2, 3, 4]) == 0


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_clients_at_random(seed: int) -> None:
    draw = Random(seed)
    with TemporaryDirectory() as folder:
        clients = Clients(Path(folder), draw)
        for _ in range(draw.randint(10, 60)):
            clients.run(draw.choice((1, 1, 2, 5, 20, 100)))
            clients.act()
        clients.recover()
        assert clients.load(LAST) == 0
        assert clients.channel.start() == 0
        for _ in range(5000):
            if clients.channel.state is InterpreterState.READY:
                break
            clients.run(1)
        assert clients.channel.state is InterpreterState.READY
        assert clients.channel.error_code == 0
        assert [round(axis.set_position, 6) for axis in clients.axes[:3]] == [0.0, 0.0, 3.0]
