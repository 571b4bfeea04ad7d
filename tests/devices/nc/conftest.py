"""An NC device on a router: axis 1 `X` in mm, axis 3 `C` in degrees, modulo 360; 2 ms cycle."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.nc import NcDevice
from achse.gcode.canon import Handshake
from achse.gcode.state.mfunctions import MRule
from achse.motion import Axis, AxisParameters, Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.store import ProgramStore
from achse.motion.groups.parameters import GroupParameters, KinematicsParameters
from achse.motion.groups.states import ChannelType, GroupType
from achse.motion.readout.shown import ShownField
from achse.motion.record import FIELDS
from achse.router import Router


@pytest.fixture
def show(monkeypatch: pytest.MonkeyPatch) -> Callable[[Axis, str, float], None]:
    """Lets a value of an axis be this, also one that is computed when it is read."""

    def show(axis: Axis, name: str, value: float) -> None:
        if isinstance(FIELDS[name], ShownField):
            monkeypatch.setattr(type(axis), name, value)
        else:
            setattr(axis, name, value)

    return show


CYCLE_NS = 2_000_000
ENABLED = {"control_dword": 7, "velocity_override": 1_000_000}


class Bench:
    """Both axes are enabled, at rest at 0; `values` are further parameters of axis 1.

    `client` asks at port 501, `axis` is what it asks about.
    """

    def __init__(self, client_of: Callable[..., Any], **values: float) -> None:
        self.nc = Nc(
            CYCLE_NS,
            [
                AxisParameters(1, "X", "mm", ENABLED | values),
                AxisParameters(3, "C", "degree", ENABLED | {"unit_interpretation": 4}),
            ],
            compiled=False,
        )
        self._attach(client_of)

    def _attach(self, client_of: Callable[..., Any]) -> None:
        self.axis: Axis = self.nc.axis(1)
        router = Router(NetId("5.1.2.3.1.1"))
        self.device = NcDevice(self.nc, clock=lambda: self.nc.cycle_count * CYCLE_NS)
        for port in (500, 501):
            self.device.attach(router, port)
        self.client = client_of(router, 501)
        self.get, self.put = self.client.get, self.client.put
        self.read, self.write = self.client.read, self.client.write
        self.exchange = self.client.exchange
        self.run(0.1)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 1e9 / CYCLE_NS)):
            self.nc.cycle()

    def until(self, condition: Callable[[], Any], seconds: float = 60.0) -> float:
        """Run until `condition()`; the time it took. Fails when it never holds."""
        for cycle in range(round(seconds * 1e9 / CYCLE_NS)):
            if condition():
                return cycle * CYCLE_NS / 1e9
            self.nc.cycle()
        raise AssertionError(f"not within {seconds} s: {self.axis!r}")

    def until_rest(self) -> float:
        return self.until(lambda: not self.axis.set_motion_phase and not self.axis.buffer_count)

    def start(self, position: float, velocity: float, start_type: int = 1, axis: int = 1) -> None:
        """Standard start in the form of TwinCAT 3."""
        self.put(0x4200 + axis, 0x20, "<I4xdd", start_type, position, velocity)

    @staticmethod
    def universal(
        kind: int,
        position: float = 0.0,
        velocity: float = 0.0,
        *,
        acceleration: float = 0.0,
        deceleration: float = 0.0,
        jerk: float = 0.0,
        mode: int = 0,
        extras: tuple[float, float, float] = (0.0, 0.0, 0.0),
        form: str = "<IIdddddI4xddd",
    ) -> bytes:
        """The request of the universal axis start, TwinCAT 3 unless another form is given."""
        return struct.pack(
            form, kind, 0, position, velocity, acceleration, deceleration, jerk, mode, *extras
        )


RULES = {
    40: MRule(handshake=Handshake.BEFORE_MOVE),
    7: MRule(fast=Handshake.BEFORE_MOVE),
    9: MRule(clears=(7, 8)),
}


class GroupBench(Bench):
    """Four axes, a 3D group 11, a FIFO 12 and a SCARA 13, with channels 1, 2 and 3."""

    def __init__(
        self, client_of: Callable[..., Any], folder: Path | None = None, **values: float
    ) -> None:
        self.folder = folder
        self.nc = Nc(
            CYCLE_NS,
            [AxisParameters(n, f"A{n}", "mm", ENABLED | values) for n in (1, 2, 3, 4)],
            groups=[
                GroupParameters(11, GroupType.THREE_D, 1, "3D"),
                GroupParameters(12, GroupType.FIFO, 2, dimension=2, length=250, time_delta=0.01),
                GroupParameters(
                    13, GroupType.KINEMATIC, 3, kinematics=KinematicsParameters("scara")
                ),
            ],
            channels=[
                ChannelParameters(1, "Interpolation", m_rules=RULES, store=ProgramStore(folder)),
                ChannelParameters(2, type=ChannelType.FIFO),
                ChannelParameters(3, type=ChannelType.KINEMATIC_TRANSFORMATION),
            ],
            compiled=False,
        )
        self._attach(client_of)

    def axes(self, *numbers: int) -> list[float]:
        """Set positions of these axes."""
        return [self.nc.axis(number).set_position for number in numbers]


@pytest.fixture
def programs(client_of: Callable[..., Any], tmp_path: Path) -> GroupBench:
    """The same, with a folder of programs, and axes 1 … 3 in the 3D group."""
    bench = GroupBench(client_of, tmp_path)
    bench.put(0x320B, 0x50, "<3I", 1, 2, 3)
    return bench


@pytest.fixture
def groups(client_of: Callable[..., Any]) -> GroupBench:
    return GroupBench(client_of)


@pytest.fixture
def bench(client_of: Callable[..., Any]) -> Bench:
    return Bench(client_of)


@pytest.fixture
def make_bench(client_of: Callable[..., Any]) -> Callable[..., Bench]:
    return lambda **values: Bench(client_of, **values)
