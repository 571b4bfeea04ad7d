"""A stranger commissions an axis: pyads and the manual's numbers, from parameters to an error.

The session runs on the demo station at several times real time, so that it takes seconds.
"""

import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from achse.station.station import DEMO
from tests.interop.waiting import until

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

SPEED = 4.0
AXIS = 1
PARAMETER, STATE, FUNCTION, CYCLIC = 0x4000 + AXIS, 0x4100 + AXIS, 0x4200 + AXIS, 0x4300 + AXIS
ENCODER, CONTROLLER = 0x5000 + AXIS, 0x6000 + AXIS

UINT, UDINT, LREAL = pyads.PLCTYPE_UINT, pyads.PLCTYPE_UDINT, pyads.PLCTYPE_LREAL

OPERATIONAL, HOMED, NOT_MOVING, IN_TARGET = 1 << 0, 1 << 1, 1 << 2, 1 << 4
HAS_JOB, HOMING, CONTINUOUS, BUFFERED, ERROR = 1 << 8, 1 << 11, 1 << 19, 1 << 24, 1 << 31

JOG_SLOW_POSITIVE, PULSE_NEGATIVE = 272, 289
BLENDING_PREVIOUS = 19
FOLLOWING_ERROR = 0x4550


class Session:
    """What the commissioning engineer's tool does with the connection."""

    def __init__(self, connection: Any) -> None:
        self.nc = connection

    def get(self, group: int, offset: int, kind: Any = LREAL) -> Any:
        return self.nc.read(group, offset, kind)

    def put(self, group: int, offset: int, value: Any, kind: Any = LREAL) -> None:
        self.nc.write(group, offset, value, kind)

    def call(self, offset: int, form: str = "", *values: float) -> None:
        data = struct.pack(form, *values)
        kind = pyads.PLCTYPE_BYTE * len(data) if data else None
        self.nc.write(FUNCTION, offset, list(data), kind)

    def exchange(self, offset: int, answer: int, form: str, *values: float) -> bytes:
        data = struct.pack(form, *values)
        kind = pyads.PLCTYPE_BYTE
        sent = kind * len(data)
        return bytes(self.nc.read_write(FUNCTION, offset, kind * answer, list(data), sent))

    def status(self) -> int:
        return int(self.get(CYCLIC, 0x81, UDINT))

    def position(self) -> float:
        return float(self.get(STATE, 0x1_0002))

    def velocity(self) -> float:
        return float(self.get(STATE, 0x0E))

    def error(self) -> int:
        return int(self.get(CYCLIC, 0xB1, UDINT))

    def wait(self, condition: Callable[[], object]) -> None:
        until(condition)

    def rest(self) -> None:
        self.wait(lambda: self.status() & NOT_MOVING and not self.status() & HAS_JOB)

    def universal(
        self, kind: int, position: float, velocity: float, mode: int = 0
    ) -> tuple[int, int]:
        """Universal axis start with the axis' dynamics: command number and state."""
        answer = self.exchange(
            0x16, 4, "<II5dI4x3d", kind, 0, position, velocity, 0, 0, 0, mode, 0, 0, 0
        )
        number, state = struct.unpack("<HH", answer)
        return number, state


@pytest.fixture
def session(
    start_station: Callable[..., AbstractContextManager[Any]],
    pyads_connection: Callable[..., Any],
    tmp_path: Path,
) -> Iterator[Session]:
    # The machine has the spindle that the session tells the NC about.
    spindle = f'name = "X"\nsimulation_encoder_resolution = {5.0 / 4096.0!r}'
    file = tmp_path / "station.toml"
    file.write_text(DEMO.read_text().replace('name = "X"', spindle))
    with start_station(str(file), "--speed", str(SPEED)) as station:
        yield Session(pyads_connection(station, 501))


def read_the_parameters(nc: Session) -> None:
    """The set as one block and as single values, which agree."""
    block = bytes(nc.nc.read(PARAMETER, 0, pyads.PLCTYPE_BYTE * 1024))
    axis_id, _, name = struct.unpack_from("<II31s", block)  # as ST_AxisParameterSet has them
    assert axis_id == nc.get(PARAMETER, 0x01, UDINT) == AXIS
    assert name.split(b"\0")[0] == b"X"
    assert nc.get(PARAMETER, 0x27) == 2000.0
    assert nc.get(PARAMETER, 0x101) == 1500.0
    assert struct.pack("<d", 2000.0) in block
    scaling = nc.get(ENCODER, 0x23) / nc.get(ENCODER, 0x24)
    assert nc.get(ENCODER, 0x06) == pytest.approx(scaling)


def scale_and_limit(nc: Session) -> None:
    """A spindle of 5 mm with 4096 increments; limits; none of it while the axis is enabled."""
    nc.put(CYCLIC, 0x01, 0b001, UDINT)
    nc.wait(lambda: nc.status() & OPERATIONAL)
    with pytest.raises(pyads.ADSError):
        nc.put(ENCODER, 0x23, 5.0)
    nc.put(CYCLIC, 0x01, 0, UDINT)
    nc.wait(lambda: not nc.status() & OPERATIONAL)
    nc.put(ENCODER, 0x23, 5.0)
    nc.put(ENCODER, 0x24, 4096.0)
    assert nc.get(ENCODER, 0x06) == pytest.approx(5.0 / 4096.0)
    nc.put(PARAMETER, 0x27, 500.0)
    nc.put(ENCODER, 0x0D, -300.0)
    nc.put(ENCODER, 0x0E, 300.0)
    for offset in (0x0B, 0x0C):
        nc.put(ENCODER, offset, 1, UINT)
    with pytest.raises(pyads.ADSError):
        nc.put(PARAMETER, 0x27, -1.0)
    assert nc.get(PARAMETER, 0x27) == 500.0


def enable(nc: Session) -> None:
    nc.put(CYCLIC, 0x01, 0b111, UDINT)
    nc.put(CYCLIC, 0x21, 1_000_000, UDINT)
    nc.wait(lambda: nc.status() & OPERATIONAL)


def home(nc: Session) -> None:
    """Towards the cam in negative direction, off it again; the place gets the position 10."""
    nc.put(ENCODER, 0x101, 1, UINT)
    nc.put(ENCODER, 0x103, 10.0)
    nc.put(PARAMETER, 0x06, 100.0)
    nc.put(PARAMETER, 0x07, 20.0)
    assert not nc.status() & HOMED
    nc.call(0x10)
    assert nc.status() & HOMING
    steps = set()

    def done() -> bool:
        step = nc.get(CYCLIC, 0xB4, UDINT)
        steps.add(step)
        return step == 0 and bool(nc.status() & HOMED)

    nc.wait(done)
    assert {2, 4} <= steps
    nc.rest()
    # stopped from 20 mm/s after the mark: sqrt(v³ / j) with the jerk of 2250 mm/s³
    assert nc.position() == pytest.approx(10.0 + (20.0**3 / 2250.0) ** 0.5, abs=0.2)


def jog(nc: Session) -> None:
    nc.put(PARAMETER, 0x08, 60.0)
    nc.put(PARAMETER, 0x19, 2.5)
    nc.call(0x20, "<I4xdd", JOG_SLOW_POSITIVE, 0.0, 0.0)
    nc.wait(lambda: nc.velocity() >= 60.0 - 1e-9)
    assert nc.status() & CONTINUOUS
    nc.call(0x02)
    nc.rest()
    before = nc.get(STATE, 0x0A)
    nc.call(0x20, "<I4xdd", PULSE_NEGATIVE, 0.0, 50.0)
    nc.rest()
    assert nc.get(STATE, 0x0A) == pytest.approx(before - 2.5)
    with pytest.raises(pyads.ADSError):
        nc.call(0x20, "<I4xdd", 1, 300.1, 50.0)


def buffered_moves(nc: Session) -> None:
    """Three moves in one go, blended: the velocity never falls to rest in between."""
    nc.universal(1, 0.0, 400.0)
    nc.rest()
    first, _ = nc.universal(1, 60.0, 100.0)
    nc.universal(1, 120.0, 200.0, BLENDING_PREVIOUS)
    last, _ = nc.universal(1, 200.0, 150.0, BLENDING_PREVIOUS)
    assert last == first + 2
    assert nc.status() & BUFFERED
    slowest = 1e9

    def beyond() -> bool:
        nonlocal slowest
        position, velocity = nc.get(STATE, 0x0A), nc.velocity()
        if 40.0 < position < 150.0:
            slowest = min(slowest, velocity)
        return bool(position >= 150.0)

    nc.wait(beyond)
    assert slowest > 90.0
    nc.rest()
    nc.wait(lambda: nc.status() & IN_TARGET)
    assert nc.get(STATE, 0x15, UDINT) == last
    assert nc.position() == pytest.approx(200.0, abs=0.5)


def torque_mode(nc: Session) -> None:
    """A push of 10 % in negative direction, at most 30 mm/s fast; a stop leads back."""
    begin = nc.position()
    torque = (0x3001, 0, 0, 0, -100.0, 0.0, 30.0, -30.0, 0.0, 0.0, 0.0)
    nc.exchange(0x2D, 4, "<4I7d", *torque)
    nc.wait(lambda: nc.position() < begin - 10.0)
    assert nc.get(STATE, 0x11) == pytest.approx(-100.0)
    assert abs(nc.get(STATE, 0x1_0005)) < 35.0
    nc.call(0x02)
    nc.rest()
    assert nc.error() == 0


def provoke_a_following_error(nc: Session) -> None:
    """Without feed-forward and with a weak controller the axis stays v / Kv behind."""
    gain, weight = nc.get(CONTROLLER, 0x102), nc.get(CONTROLLER, 0x0B)
    window = nc.get(CONTROLLER, 0x12)
    nc.put(CONTROLLER, 0x0B, 0.0)
    nc.put(CONTROLLER, 0x102, 2.0)
    assert window < 100.0 / 2.0
    nc.call(0x20, "<I4xdd", 1, 0.0, 100.0)
    nc.wait(lambda: nc.status() & ERROR)
    assert nc.error() == FOLLOWING_ERROR
    assert nc.get(STATE, 0x01, UDINT) == FOLLOWING_ERROR
    assert not nc.status() & OPERATIONAL
    with pytest.raises(pyads.ADSError) as refusal:
        nc.call(0x20, "<I4xdd", 1, 0.0, 100.0)
    assert refusal.value.err_code == FOLLOWING_ERROR
    nc.put(CONTROLLER, 0x0B, weight)
    nc.put(CONTROLLER, 0x102, gain)


def reset_and_move_on(nc: Session) -> None:
    nc.call(0x01)
    nc.wait(lambda: nc.status() & OPERATIONAL)
    assert nc.error() == 0
    assert nc.status() & HOMED
    nc.call(0x20, "<I4xdd", 1, 50.0, 200.0)
    nc.rest()
    nc.wait(lambda: nc.status() & IN_TARGET)
    assert nc.position() == pytest.approx(50.0, abs=0.5)


def test_commissioning(session: Session) -> None:
    for step in (
        read_the_parameters,
        scale_and_limit,
        enable,
        home,
        jog,
        buffered_moves,
        torque_mode,
        provoke_a_following_error,
        reset_and_move_on,
    ):
        step(session)
