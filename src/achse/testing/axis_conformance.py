"""Conformance rules for an axis of an NC, checked by any ADS client: ours, or a controller's.

Sources: 002 §6.4.4.1 to §6.4.4.4; bits of the status double word 004 §5.1.1.
"""

import math
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Protocol

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.axis import BufferMode, StartType, StateBit
from achse.devices.nc.device import AXIS_GROUPS
from achse.server import READ, Codec, Service
from achse.testing.conformance import ConformanceError

_ENABLED = 7
"""Control double word: controller, feed forward and backward."""

_FULL_OVERRIDE = 1_000_000
_NOWHERE = 0x0FFF
"""An index offset at which no row of an axis is."""

_SAMPLE_S = 0.01
_PATIENCE_S = 10.0
"""Longer than expected, until something counts as not happening."""

_ROUNDING = 1 + 1e-6


class AxisReach(Protocol):
    """The NC's port 500 or 501, as `achse.blocking` gives it: `client.at_port(501)`."""

    def read_raw(self, group: int, offset: int, length: int) -> bytes:
        """Read bytes. Raises DeviceError."""
        ...

    def write_raw(self, group: int, offset: int, data: bytes) -> None:
        """Write bytes. Raises DeviceError."""
        ...

    def read_write_raw(self, group: int, offset: int, read_length: int, data: bytes) -> bytes:
        """Write bytes, and return the answer. Raises DeviceError."""
        ...


def check_axis(
    client: AxisReach,
    axis: int,
    *,
    motion: bool = True,
    distance: float = 10.0,
    velocity: float = 20.0,
    tolerance: float = 0.1,
    wait: Callable[[float], object] = time.sleep,
) -> None:
    """Demand what the manuals say of axis number `axis`; raises ConformanceError with all faults.

    - each parameter, state and cyclic value that is a number is there with its size;
    - an axis, an offset and a size that do not exist are refused, and starts that cannot be;
    - an axis that is not enabled does not move;
    - with `motion`: two relative moves over `distance` and back (the axis' unit), not faster than
      `velocity`, without a turn on the way, that end within `tolerance`, with the status bits that
      belong to it; a stop brings the axis to rest before its target; at half the override it has
      half the velocity.

    The axis must be at rest, without error, and free to move by twice `distance` in positive
    direction; it ends as it was, enables and override too. `wait(seconds)` lets time pass: for a
    station in virtual time its `advance`.
    """
    check = _Check(client, axis, wait)
    faults = [*check.rows(), *check.refusals()]
    if faults or not motion:
        _raise_faults(faults)
        return
    before = check.read("control_dword"), check.read("velocity_override")
    try:
        faults += check.disabled(distance, velocity)
        check.enable()
        faults += check.movement(distance, velocity, tolerance)
    finally:
        check.call("stop")
        check.settle()
        check.write("control_dword", before[0])
        check.write("velocity_override", before[1])
    _raise_faults(faults)


def _raise_faults(faults: list[str]) -> None:
    if faults:
        raise ConformanceError("\n".join(faults))


class _Check:
    def __init__(self, client: AxisReach, axis: int, wait: Callable[[float], object]) -> None:
        self._client = client
        self._axis = axis
        self._wait = wait
        self._rows: dict[str, tuple[int, Service]] = {}
        for base, rows, _ in AXIS_GROUPS[:4]:
            for row in rows:
                self._rows.setdefault(row.name, (base, row))

    # access

    def _row(self, name: str) -> tuple[int, Service, Codec]:
        base, row = self._rows[name]
        codec = row.codec[-1] if isinstance(row.codec, tuple) else row.codec
        return base + self._axis, row, codec

    def read(self, name: str) -> Any:
        """Return the value of a row."""
        group, row, codec = self._row(name)
        return codec.decode(self._client.read_raw(group, row.offset, codec.size or 0))

    def write(self, name: str, value: Any) -> None:
        group, row, codec = self._row(name)
        self._client.write_raw(group, row.offset, codec.encode(value))

    def call(self, name: str) -> None:
        """Call a function without arguments."""
        group, row, _ = self._row(name)
        self._client.write_raw(group, row.offset, b"")

    def start(self, *arguments: float) -> None:
        """Start universally: type, position, velocity; the axis' own dynamics."""
        start_type, position, velocity = arguments
        group, row, codec = self._row("universal_axis_start")
        own_dynamics, mode, no_blending = (0.0, 0.0, 0.0), BufferMode.ABORTING, (0.0, 0.0, 0.0)
        data = codec.encode(
            (int(start_type), 0, position, velocity, *own_dynamics, mode, *no_blending)
        )
        self._client.read_write_raw(group, row.offset, 4, data)

    def state(self) -> int:
        return int(self.read("state_dword"))

    # what is there

    def rows(self) -> Iterator[str]:
        """Check that each readable number exists with its size."""
        for base, rows, _ in AXIS_GROUPS[:4]:
            for row in rows:
                if READ not in row.access or isinstance(row.codec, tuple):
                    continue
                size = row.codec.size
                if not size:
                    continue
                where = f"{row.name} (0x{base + self._axis:X}:0x{row.offset:X})"
                try:
                    data = self._client.read_raw(base + self._axis, row.offset, size)
                except DeviceError as refusal:
                    yield f"{where}: cannot be read: {refusal}"
                    continue
                if len(data) != size:
                    yield f"{where}: has {len(data)} bytes, expected {size}"
        if (axis_id := self.read("axis_id")) != self._axis:
            yield f"axis id: expected {self._axis}, got {axis_id}"

    def _refusal(self, action: Callable[[], object]) -> int:
        """Return the code with which something is refused, 0 if it is not."""
        try:
            action()
        except DeviceError as refusal:
            return refusal.code
        return 0

    def refusals(self) -> Iterator[str]:
        """Check the refusals of missing axes and offsets, wrong sizes and read-only rows."""
        client = self._client
        base = AXIS_GROUPS[0][0]
        missing = next(
            (id for id in range(255, 0, -1) if self._refusal(partial(self._id_of, id))), None
        )
        if missing is not None:
            code = self._refusal(partial(self._id_of, missing))
            expected = NcError.AXIS_ID.number
            if code != expected:
                yield f"axis {missing} does not exist: expected 0x{expected:X}, got 0x{code:X}"
        if not self._refusal(lambda: client.read_raw(base + self._axis, _NOWHERE, 4)):
            yield f"offset 0x{_NOWHERE:X}, which does not exist, is answered"
        group, row, codec = self._row("velocity_override")
        size = codec.size or 0
        code = self._refusal(lambda: client.write_raw(group, row.offset, bytes(size - 1)))
        expected = ReturnCode.INVALID_SIZE.number
        if code != expected:
            yield (
                f"a velocity override of {size - 1} bytes: expected 0x{expected:X}, got 0x{code:X}"
            )
        group, row, codec = self._row("set_cycle_counter")
        if not self._refusal(lambda: client.write_raw(group, row.offset, bytes(codec.size or 0))):
            yield f"{row.name}: can be written, its row says read only"

    def _id_of(self, axis: int) -> bytes:
        base, row = self._rows["axis_id"]
        return self._client.read_raw(base + axis, row.offset, 4)

    # motion

    def enable(self) -> None:
        """Let the axis move, and wait until it can."""
        self.write("velocity_override", _FULL_OVERRIDE)
        self.write("control_dword", _ENABLED)
        self.until(lambda: bool(self.state() & StateBit.OPERATIONAL), _PATIENCE_S)

    def until(self, done: Callable[[], bool], seconds: float) -> bool:
        """Wait for `done()`, at most `seconds`; return its last result."""
        for _ in range(math.ceil(seconds / _SAMPLE_S)):
            if done():
                return True
            self._wait(_SAMPLE_S)
        return done()

    def settle(self) -> None:
        """Wait for the end of what the axis does."""
        self.until(lambda: not self.state() & StateBit.HAS_JOB, _PATIENCE_S)

    def disabled(self, distance: float, velocity: float) -> Iterator[str]:
        """Check that nothing moves without enables, and wrong starts are refused."""
        self.write("control_dword", 0)
        self._wait(10 * _SAMPLE_S)
        position = self.read("set_position")
        if not self._refusal(lambda: self.start(StartType.RELATIVE, distance, velocity)):
            self._wait(10 * _SAMPLE_S)
            if self.read("set_position") != position:
                yield "an axis without enables moves"
            self.call("stop")
            self.settle()

    def movement(self, distance: float, velocity: float, tolerance: float) -> Iterator[str]:
        """There, back, stopped on the way, and at half the override."""
        for wrong in ((99, distance, velocity), (2, math.nan, velocity), (2, distance, 0.0),
                      (2, distance, -velocity)):  # fmt: skip
            if not self._refusal(partial(self.start, *wrong)):
                yield f"a start of type {wrong[0]} to {wrong[1]} with {wrong[2]} is not refused"
        for way in (distance, -distance):
            yield from self._move(way, velocity, tolerance)
        yield from self._stopped(2 * distance, velocity)
        yield from self._override(distance, velocity)
        error = self.read("error_code")
        if error:
            yield f"the axis has the error 0x{error:X}"

    def _move(self, way: float, velocity: float, tolerance: float) -> Iterator[str]:
        name = f"a move by {way:g}"
        begin = last = self.read("set_position")
        self.start(StartType.RELATIVE, way, velocity)
        busy = fastest = 0.0
        turned = False

        def done() -> bool:
            nonlocal last, busy, fastest, turned
            state, position = self.state(), self.read("set_position")
            busy = max(busy, float(bool(state & StateBit.HAS_JOB)))
            fastest = max(fastest, abs(self.read("set_velocity")))
            turned = turned or (position - last) * way < -abs(way) * 1e-9
            last = position
            return abs(position - begin - way) <= 1e-6 and not state & StateBit.HAS_JOB

        if not self.until(done, abs(way) / velocity + _PATIENCE_S):
            yield f"{name}: the set position is {last:g}, expected {begin + way:g}"
            return
        if not busy:
            yield f"{name}: the axis never has a job (state double word, bit 8)"
        if fastest > velocity * _ROUNDING:
            yield f"{name}: the set velocity is up to {fastest:g}, expected at most {velocity:g}"
        if turned:
            yield f"{name}: the set position turns on the way"
        self.until(lambda: bool(self.state() & StateBit.NOT_MOVING), _PATIENCE_S)
        actual = self.read("actual_position")
        if abs(actual - begin - way) > tolerance:
            yield f"{name}: the axis is at {actual:g}, expected {begin + way:g} ± {tolerance:g}"
        if not self.state() & StateBit.NOT_MOVING:
            yield f"{name}: the axis does not come to rest (state double word, bit 2)"

    def _stopped(self, way: float, velocity: float) -> Iterator[str]:
        begin = self.read("set_position")
        self.start(StartType.RELATIVE, way, velocity)
        self.until(lambda: self.read("set_position") - begin > way / 8, way / velocity)
        self.call("stop")
        self.settle()
        if not self.until(lambda: self.read("set_velocity") == 0.0, _PATIENCE_S):
            yield "a stop: the set velocity does not become 0"
        end = self.read("set_position")
        if not begin < end < begin + way:
            yield f"a stop on the way from {begin:g} to {begin + way:g} ends at {end:g}"
        self.start(StartType.ABSOLUTE, begin, velocity)
        self.settle()

    def _override(self, way: float, velocity: float) -> Iterator[str]:
        begin = self.read("set_position")
        self.write("velocity_override", _FULL_OVERRIDE // 2)
        self.start(StartType.RELATIVE, way, velocity)
        fastest = 0.0

        def done() -> bool:
            nonlocal fastest
            fastest = max(fastest, abs(self.read("set_velocity")))
            return not self.state() & StateBit.HAS_JOB

        self._wait(_SAMPLE_S)
        self.until(done, 2 * way / velocity + _PATIENCE_S)
        self.write("velocity_override", _FULL_OVERRIDE)
        if fastest > velocity / 2 * _ROUNDING:
            yield f"at half the override the set velocity is {fastest:g}, expected {velocity / 2:g}"
        self.start(StartType.ABSOLUTE, begin, velocity)
        self.settle()
