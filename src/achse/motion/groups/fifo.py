"""FIFO groups: rows of positions at equal times, and an override that stretches the time.

The axes are brought exactly to the first row, then the group starts. Behind the last row they keep
where they are until more rows come. Source: 002 §6.4.3, public pages on FIFO axes.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from math import exp, isfinite

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.groups.group import FULL_OVERRIDE, AxisGroup
from achse.motion.groups.interpolation import INTERPOLATIONS
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.states import FifoOverrideType, GroupType

Row = tuple[float, ...]

_TOLERANCE = 1e-9
"""Distance to a row, in rows, at which the row counts as reached."""


class FifoGroup(AxisGroup):
    """A FIFO of at most `length` rows with a position for each of `dimension` axes."""

    type = GroupType.FIFO

    def __init__(self, parameters: GroupParameters, axes: Mapping[int, Axis]) -> None:
        super().__init__(parameters, axes, parameters.dimension)
        self.dimension = parameters.dimension
        self.length = parameters.length
        self.interpolation_type = parameters.interpolation
        self._interpolation = INTERPOLATIONS[parameters.interpolation]
        self.override_type = FifoOverrideType.INSTANTANEOUS
        self.override_time = 0.1
        """T0 of the PT2 element, s."""
        self.time_delta = parameters.time_delta
        """Time between two rows at 100 %, s."""
        self.started = False
        self._rows: deque[Row] = deque()
        self._first = 0
        """Number of the first stored row, from the start on."""
        self._place = 0.0
        """Position of the motion, in rows from the start on."""
        self._pace = 0.0
        """Override as it is now, 1 = 100 %."""
        self._pace_change = 0.0
        """Its change, 1/s."""
        self._velocities: list[float] = [0.0] * parameters.dimension

    # rows

    @property
    def saf_entry_count(self) -> int:
        """Rows that are not yet taken."""
        if not self.started:
            return len(self._rows)
        return self._first + len(self._rows) - 1 - int(self._place + _TOLERANCE)

    @property
    def saf_table_size(self) -> int:
        """Rows of the FIFO."""
        return self.length

    def write(self, values: Sequence[float]) -> int:
        """Append rows (0x710): whole rows that all fit, or none.

        0x42ED for broken rows, 0x4A1E if they do not fit, 0x422C for numbers that are none.
        """
        rows = self._cut(values)
        if isinstance(rows, NcError):
            return rows
        if len(rows) > self.saf_free_entry_count:
            return NcError.TABLE_FIFO_FULL
        self._rows.extend(rows)
        return OK

    def overwrite(self, values: Sequence[float]) -> int:
        """Replace the rows that are not yet taken (0x711); 0x4A22 if more come than fit.

        The interval that the motion is in stays as it is.
        """
        rows = self._cut(values)
        if isinstance(rows, NcError):
            return rows
        retained = 0
        if self.started:
            retained = int(self._place + _TOLERANCE) - self._first + 1
            if self._place - int(self._place + _TOLERANCE) > _TOLERANCE:
                retained += self._interpolation.behind
        retained = min(retained, len(self._rows))
        ahead = self.saf_entry_count - (len(self._rows) - retained)
        if len(rows) > self.length - ahead:
            return NcError.TABLE_FIFO_OVERWRITE
        while len(self._rows) > retained:
            self._rows.pop()
        self._rows.extend(rows)
        return OK

    def _cut(self, values: Sequence[float]) -> list[Row] | NcError:
        if not values or len(values) % self.dimension:
            return NcError.FIFO_DIMENSION
        if not all(map(isfinite, values)):
            return NcError.EXTERNAL_SETPOINT_DATA
        step = self.dimension
        return [tuple(values[n : n + step]) for n in range(0, len(values), step)]

    # motion

    def start(self) -> int:
        """Begin with the first row, where the axes are already (0x701), or go on after a stop.

        0x4A1D without rows, 0x4171 if an axis is elsewhere, 0x42EA without a time between rows.
        """
        if self.moving:
            return NcError.GROUP_BUSY
        code = self.check_move()
        if code:
            return code
        if not self.time_delta > 0.0:
            return NcError.FIFO_TIME_UNIT
        if not self._rows:
            return NcError.TABLE_FIFO_EMPTY
        row = self._at(self._place) if self.started else self._rows[0]
        for axis, position in zip(self.places, row, strict=True):
            if axis is not None and abs(axis.set.position - position) > _reach(axis):
                return NcError.START_NOT_ON_CONTOUR
        if not self.started:
            self.started = True
            self._first, self._place = 0, 0.0
        self._pace = self._pace_change = 0.0
        self._begin_motion()
        return OK

    def stop(self) -> int:
        """Ramp the time to a standstill within the decelerations of the axes (0x02)."""
        self.stopping = self.moving
        return OK

    def clear(self) -> int:
        """Stop, and forget all rows (0x03)."""
        if self.moving:
            self.stopping = self._forgetting = True
        else:
            self._forget()
        return OK

    _forgetting = False

    def assigned(self) -> None:
        """Drop all rows: they are for the axes that were there."""
        self._forget()

    def _forget(self) -> None:
        self._rows.clear()
        self.started = self._forgetting = False
        self._place = 0.0
        self._first = 0

    def step(self, dt: float) -> None:
        """Run one cycle: advance by one cycle of the time between two rows."""
        if self._has_lost_axis():
            self.stopping = True
        if self.stopping and self._pace == 0.0:
            self._end_motion()
            if self._forgetting:
                self._forget()
            return
        way = self._ramp(dt) if self.stopping else self._follow_override(dt)
        last = self._first + len(self._rows) - 1
        place = min(self._place + way / self.time_delta, float(last))
        if abs(place - round(place)) < _TOLERANCE:
            place = float(round(place))
        self._place = place
        row = self._at(place)
        for n, axis in enumerate(self.places):
            if axis is None:
                continue
            velocity = (row[n] - axis.group_set_point.position) / dt
            self._velocities[n] = velocity
            axis.group_set_point.position, axis.group_set_point.velocity = row[n], velocity
        self._drop_taken()

    def _drop_taken(self) -> None:
        """Keep no more rows than the curve takes."""
        keep = int(self._place) - self._interpolation.size
        while self._first < keep:
            self._rows.popleft()
            self._first += 1

    def _at(self, place: float) -> Row:
        """Positions there."""
        rows = self._rows
        number = int(place) - self._first
        share = place - int(place)
        if share == 0.0:
            return rows[number]
        law = self._interpolation
        count = min(law.size, len(rows))
        first = max(0, min(number - law.before, len(rows) - count))
        near = [rows[first + n] for n in range(count)]
        return tuple(law.curve(points, number - first, share) for points in zip(*near, strict=True))

    def _follow_override(self, dt: float) -> float:
        """Time of the rows that goes by in a cycle, s."""
        target = self.override / FULL_OVERRIDE
        if self.override_type == FifoOverrideType.INSTANTANEOUS:
            self._pace, self._pace_change = target, 0.0
            return target * dt
        lag = self.override_time
        away = self._pace - target
        rise = self._pace_change + away / lag
        fade = exp(-dt / lag)
        rest = (away + rise * dt) * fade
        self._pace = target + rest
        self._pace_change = rise * fade - rest / lag
        gone = 1.0 - fade
        return target * dt + away * lag * gone + rise * lag * (lag * gone - dt * fade)

    def _ramp(self, dt: float) -> float:
        """The same while it stops: what the axes bear."""
        before = self._pace
        slower = float("inf")
        for axis, velocity in zip(self.places, self._velocities, strict=True):
            if axis is not None and velocity and before:
                deceleration = min(axis.default_deceleration, axis.max_deceleration)
                slower = min(slower, deceleration * before / abs(velocity))
        self._pace = max(0.0, before - slower * dt)
        self._pace_change = 0.0
        if slower == float("inf"):
            return 0.0
        if self._pace == 0.0:
            return before * before / (2.0 * slower)
        return 0.5 * (before + self._pace) * dt

    def digest(self) -> bytes:
        """Return all that decides what the group does next, as bytes."""
        own = (self.started, list(self._rows), self._place, self._pace, self._pace_change)
        return super().digest() + repr(own).encode()


def _reach(axis: Axis) -> float:
    """Return the largest distance of an axis from the first row: the resolution of its encoder."""
    return max(axis.encoder.scaling_factor, 1e-6)
