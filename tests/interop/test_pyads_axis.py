"""pyads moves axis 1 of the demo station through the NC's services and watches every limit.

The axis is built for 2000 mm/s, 1500 mm/s² and 2250 mm/s³.
"""

import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, NamedTuple

import pytest

from tests.interop.waiting import until

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

ACCELERATION, JERK = 1500.0, 2250.0
TOLERANCE = 1 + 1e-6
CYCLE = 0.002
"""Seconds; the NC's, and of the traces."""

STATE, FUNCTION, CYCLIC = 0x4100, 0x4200, 0x4300
ABSOLUTE, ENDLESS_POSITIVE = 1, 3

ENABLED, NOT_MOVING, IN_TARGET, HAS_JOB = 1 << 0, 1 << 2, 1 << 4, 1 << 8
HOMED, HOMING, LATCHED = 1 << 1, 1 << 11, 1 << 16


class Online(NamedTuple):
    """The online structure, TC3 form (256 bytes), as far as it is documented."""

    error: int
    actual_position: float
    actual_modulo: float
    set_position: float
    set_modulo: float
    actual_velocity: float
    set_velocity: float
    override: int
    lag: float
    lag_minimum: float
    lag_maximum: float
    controller_output: float
    total_output: float
    status: int
    control: int
    coupling: int
    loop: int
    actual_acceleration: float
    set_acceleration: float
    set_jerk: float


TC3 = struct.Struct("<i4x6dI4x5d4I3d112x")
TC2 = struct.Struct("<i6dI5d4I")


class Axis:
    """One axis as pyads reaches it: numbers from the manual, nothing of ours."""

    def __init__(self, connection: Any, number: int) -> None:
        self._nc = connection
        self.number = number

    def read(self, length: int) -> bytes:
        return bytes(self._nc.read(STATE + self.number, 0, pyads.PLCTYPE_BYTE * length))

    def online(self) -> Online:
        return Online(*TC3.unpack(self.read(256)))

    def call(self, offset: int, data: bytes = b"") -> None:
        kind = pyads.PLCTYPE_BYTE * len(data) if data else None
        self._nc.write(FUNCTION + self.number, offset, list(data), kind)

    def enable(self) -> None:
        self._nc.write(CYCLIC + self.number, 0x01, 0b111, pyads.PLCTYPE_UDINT)
        self.override(100)

    def disable(self) -> None:
        self._nc.write(CYCLIC + self.number, 0x01, 0, pyads.PLCTYPE_UDINT)

    def override(self, percent: int) -> None:
        self._nc.write(CYCLIC + self.number, 0x21, percent * 10_000, pyads.PLCTYPE_UDINT)

    def start(self, kind: int, target: float, velocity: float) -> None:
        self.call(0x20, struct.pack("<IIdd", kind, 0, target, velocity))

    def stop(self) -> None:
        self.call(0x02)

    def reset(self) -> None:
        self.call(0x01)

    @contextmanager
    def trace(self) -> Iterator[list[Online]]:
        """Every cycle while the block runs, without a gap, by a cyclic notification."""
        samples: list[Online] = []
        times: list[int] = []

        def note(notification: Any, _: Any) -> None:
            _, time_stamp, data = self._nc.parse_notification(notification, None, True)
            times.append(time_stamp)
            samples.append(Online(*TC3.unpack(data)))

        attributes = pyads.NotificationAttrib(
            256, pyads.ADSTRANS_SERVERCYCLE, max_delay=0, cycle_time=CYCLE * 1e3
        )
        place = (STATE + self.number, 0)
        handles = self._nc.add_device_notification(place, attributes, note)
        try:
            yield samples
            seen = threading.Event()  # pyads hands on in order, but late if it hardly gets to it
            last = self._nc.add_device_notification(place, attributes, lambda *_: seen.set())
            seen.wait()
            self._nc.del_device_notification(*last)
        finally:
            self._nc.del_device_notification(*handles)
        assert {b - a for a, b in pairwise(times[1:])} == {round(CYCLE * 1e7)}

    def watch(self, done: Callable[[Online], object]) -> list[Online]:
        """Samples until `done`."""
        samples = [self.online()]

        def is_done() -> bool:
            if not done(samples[-1]):
                samples.append(self.online())
                return False
            return True

        until(is_done)
        return samples

    def at_rest(self, sample: Online) -> bool:
        return bool(sample.status & NOT_MOVING) and not sample.status & HAS_JOB


@pytest.fixture
def axis(station: Any, pyads_connection: Callable[..., Any]) -> Iterator[Axis]:
    """Axis 1, enabled, at rest, without error; stopped and disabled afterwards."""
    axis = Axis(pyads_connection(station, 501), 1)
    axis.reset()
    axis.enable()
    axis.watch(lambda sample: sample.status & ENABLED)
    yield axis
    axis.stop()
    axis.watch(axis.at_rest)
    axis.disable()


def assert_within_limits(trace: list[Online], velocity: float) -> None:
    """What the NC says of itself and what follows from sample to sample."""
    for sample in trace:
        assert abs(sample.set_velocity) <= velocity * TOLERANCE
        assert abs(sample.set_acceleration) <= ACCELERATION * TOLERANCE
        assert abs(sample.set_jerk) <= JERK * TOLERANCE
    for one, next_one in pairwise(trace):
        step = next_one.set_position - one.set_position
        assert abs(step) <= velocity * CYCLE * TOLERANCE
        change = next_one.set_velocity - one.set_velocity
        assert abs(change) <= ACCELERATION * CYCLE * TOLERANCE
        bend = next_one.set_acceleration - one.set_acceleration
        assert abs(bend) <= JERK * CYCLE * TOLERANCE


def test_a_move_reaches_its_target_within_every_limit(axis: Axis) -> None:
    axis.start(ABSOLUTE, 0.0, 2000.0)
    axis.watch(lambda sample: axis.at_rest(sample) and sample.set_position == 0.0)

    with axis.trace() as trace:
        axis.start(ABSOLUTE, 100.0, 200.0)
        axis.watch(lambda sample: sample.status & IN_TARGET and axis.at_rest(sample))
        settled = axis.watch(lambda now: abs(now.actual_position - 100.0) <= 0.01)

    assert_within_limits(trace, 200.0)
    positions = [sample.set_position for sample in trace]
    assert positions == sorted(positions)
    assert (positions[0], positions[-1]) == (0.0, 100.0)
    # without a jerk limit on the way to it 200 mm/s would be reached; with it v³ = (s/2)² j
    assert max(sample.set_velocity for sample in trace) == pytest.approx(
        (50.0**2 * JERK) ** (1 / 3), rel=1e-3
    )
    assert settled[-1].error == 0


def test_half_override_halves_the_velocity_without_a_jump(
    axis: Axis, pass_station_time: Callable[[float], None]
) -> None:
    with axis.trace() as trace:
        axis.start(ENDLESS_POSITIVE, 0.0, 200.0)
        axis.watch(lambda sample: sample.set_velocity == pytest.approx(200.0, abs=1e-9))
        axis.override(50)
        axis.watch(lambda sample: sample.set_velocity == pytest.approx(100.0, abs=1e-9))
    assert_within_limits(trace, 200.0)
    pass_station_time(0.05)
    after = axis.online()
    assert after.override == 500_000
    assert after.set_velocity == pytest.approx(100.0, abs=1e-9)
    assert after.set_acceleration == pytest.approx(0.0, abs=1e-9)


def test_a_stop_comes_to_rest_with_the_configured_deceleration(axis: Axis) -> None:
    axis.start(ENDLESS_POSITIVE, 0.0, 1500.0)
    axis.watch(lambda sample: sample.set_velocity == pytest.approx(1500.0, abs=1e-6))
    with axis.trace() as trace:
        axis.stop()
        axis.watch(axis.at_rest)
    assert_within_limits(trace, 1500.0)
    braking = [sample for sample in trace if sample.set_velocity < 1500.0]
    assert min(sample.set_acceleration for sample in braking) == pytest.approx(-ACCELERATION)
    # ramp of equal jerk up and down around constant deceleration: t = v/a + a/j, s = v t / 2
    duration = 1500.0 / ACCELERATION + ACCELERATION / JERK
    assert (len([s for s in braking if s.set_velocity > 0.0]) + 1) * CYCLE == pytest.approx(
        duration, abs=2 * CYCLE
    )
    way = trace[-1].set_position - trace[0].set_position
    steady = len(trace) - len(braking)
    assert way == pytest.approx(
        1500.0 * duration / 2 + 1500.0 * CYCLE * (steady - 1), abs=1500.0 * CYCLE
    )
    assert trace[-1].set_velocity == 0.0
    assert trace[-1].error == 0


def test_an_axis_homes_and_latches_its_index_pulses(axis: Axis) -> None:
    """One index pulse per 65536 increments of 0.0001 mm: every 6.5536 mm from the reference."""
    nc = axis._nc
    for offset in (0x06, 0x07):
        nc.write(0x4000 + axis.number, offset, 200.0, pyads.PLCTYPE_LREAL)
    nc.write(0x5000 + axis.number, 0x103, 30.0, pyads.PLCTYPE_LREAL)
    nc.write(0x5000 + axis.number, 0x107, 2, pyads.PLCTYPE_UDINT)
    axis.call(0x10)
    watched = axis.watch(lambda sample: not sample.status & HOMING)
    assert watched[0].status & HOMING
    assert watched[-1].error == 0
    assert watched[-1].status & HOMED
    brake = 200.0 * (200.0 / JERK) ** 0.5
    assert watched[-1].actual_position == pytest.approx(30.0 + brake, abs=2.0)
    assert max(abs(sample.set_velocity) for sample in watched) == pytest.approx(200.0)

    probe = struct.pack("<6I", 1, 0, 1, 128, 0, 0)
    nc.write(0x5200 + axis.number, 0x200, list(probe), pyads.PLCTYPE_BYTE * 24)
    axis.start(ABSOLUTE, watched[-1].set_position + 20.0, 50.0)
    seen = axis.watch(lambda sample: sample.status & IN_TARGET and axis.at_rest(sample))
    assert seen[-1].status & LATCHED
    state = nc.read_write(
        0x5100 + axis.number, 0x200, pyads.PLCTYPE_BYTE * 64, list(probe), pyads.PLCTYPE_BYTE * 24
    )
    active, valid, position, counter = struct.unpack_from("<IIdI", bytes(state))
    assert (active, valid, counter) == (0, 1, 1)
    turns = (position - 30.0) / 6.5536
    assert turns == pytest.approx(round(turns), abs=1e-6)
    assert watched[-1].actual_position < position < watched[-1].actual_position + 6.6


def test_both_forms_of_the_online_structure_agree(axis: Axis) -> None:
    axis.watch(lambda sample: axis.at_rest(sample) and sample.actual_velocity == 0.0)
    long, short = Online(*TC3.unpack(axis.read(256))), TC2.unpack(axis.read(112))
    at_rest = [name for name in Online._fields[:17] if "lag" not in name and "output" not in name]
    packed = dict(zip(Online._fields, short, strict=False))
    assert {name: packed[name] for name in at_rest} == pytest.approx(
        {name: getattr(long, name) for name in at_rest}, abs=1e-3
    )


@pytest.mark.parametrize(
    ("number", "velocity", "code"),
    [
        pytest.param(1, 0.0, 0x4221, id="no velocity"),
        pytest.param(1, -1.0, 0x4221, id="negative velocity"),
        pytest.param(1, 2001.0, 0x4221, id="above the maximum"),
        pytest.param(200, 10.0, 0x4012, id="unknown axis"),
    ],
)
def test_a_bad_start_is_refused_with_its_code(
    axis: Axis, number: int, velocity: float, code: int
) -> None:
    with pytest.raises(pyads.ADSError) as refusal:
        Axis(axis._nc, number).start(ABSOLUTE, 10.0, velocity)
    assert refusal.value.err_code == code


def test_a_start_without_enable_is_refused(
    station: Any, pyads_connection: Callable[..., Any]
) -> None:
    axis = Axis(pyads_connection(station, 501), 2)
    with pytest.raises(pyads.ADSError) as refusal:
        axis.start(ABSOLUTE, 10.0, 10.0)
    assert refusal.value.err_code in (0x4223, 0x4260)
    assert axis.online().set_velocity == 0.0


def test_axis_values_have_names(station: Any, pyads_connection: Callable[..., Any]) -> None:
    connection = pyads_connection(station, 501)
    names = {symbol.name for symbol in connection.get_all_symbols()}
    axis = next(name.split(".")[1] for name in sorted(names))
    assert {f"Axes.{axis}.{name}" for name in ("SetPos", "ActPos", "PosDiff", "ToPlc")} <= names
    position = connection.read_by_name(f"Axes.{axis}.ActPos", pyads.PLCTYPE_LREAL)
    symbol = connection.get_symbol(f"Axes.{axis}.ActPos")
    assert symbol.read() == pytest.approx(position, abs=1.0)
    status = connection.read_by_name(f"Axes.{axis}.ToPlc.StateDWord", pyads.PLCTYPE_DWORD)
    assert status & NOT_MOVING
