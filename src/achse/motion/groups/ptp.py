"""PTP groups: each axis has one of its own, with the axis' id; its functions are those of the axis.

An encoder axis is alone in an encoder group in the same way. Source: 002 §6.4.3.
"""

from typing import NamedTuple

from achse.codes.axis import BufferMode, StartType, StateBit
from achse.codes.nc.choices import AxisType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.channels.channel import NcChannel
from achse.motion.checks import OK
from achse.motion.commands.starts import universal_start
from achse.motion.commands.stops import clear, emergency_stop, parameterized_stop, stop
from achse.motion.commands.switches import reset
from achse.motion.fields.setpoint import COMMAND_BUFFER
from achse.motion.groups.states import GroupType, SafState


class _Move(NamedTuple):
    """A command as `universal_start` takes it."""

    start_type: int
    position: float
    velocity: float
    acceleration: float
    deceleration: float
    jerk: float


class PtpGroup:
    """The group of one axis."""

    saf_sub_state = 0
    svb_state = SafState.READY
    svb_table_size = 0
    svb_entry_count = 0
    svb_free_entry_count = 0
    saf_table_size = COMMAND_BUFFER
    saf_divisor = 1
    single_block_mode = 0

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        self.emergency_stop_active = 0
        self._interrupted: list[_Move] = []

    @property
    def group_id(self) -> int:
        """Id of the axis."""
        return self.axis.axis_id

    @property
    def cycle_ns(self) -> int:
        """Cycle of the axis."""
        return self.axis.cycle_ns

    @property
    def name(self) -> str:
        """Name of the axis."""
        return self.axis.name

    @property
    def type(self) -> GroupType:
        """PTP, or encoder."""
        is_encoder = self.axis.axis_type == AxisType.ENCODER
        return GroupType.ENCODER if is_encoder else GroupType.PTP

    @property
    def channel(self) -> NcChannel:
        return self.axis.home_channel

    @property
    def index_in_channel(self) -> int:
        """Place in the channel, from 1 on."""
        return self.channel.group_ids.index(self.group_id) + 1

    @property
    def error_code(self) -> int:
        """Error of the axis."""
        return self.axis.error_code

    @property
    def saf_state(self) -> SafState:
        """State in the set-point task."""
        axis = self.axis
        if axis.error_code:
            return SafState.ERROR
        if axis.set_motion_phase == MotionPhase.STOPPING:
            return SafState.STOPPING
        if axis.set_motion_phase != MotionPhase.NONE:
            return SafState.RUNNING
        return SafState.READY if axis.state_dword & StateBit.OPERATIONAL else SafState.IDLE

    @property
    def saf_entry_count(self) -> int:
        """Commands that wait."""
        return self.axis.buffer.count

    @property
    def saf_free_entry_count(self) -> int:
        """Commands that can still wait."""
        return COMMAND_BUFFER - self.axis.buffer.count

    def reset(self) -> int:
        """Reset errors (0x01); what an emergency stop interrupted is forgotten."""
        self._forget()
        return reset(self.axis)

    def stop(self) -> int:
        """Stop with the running deceleration (0x02)."""
        code = stop(self.axis)
        if code == OK:
            self._forget()
        return code

    def clear(self) -> int:
        """Take the job and all waiting commands away (0x03)."""
        code = clear(self.axis)
        if code == OK:
            self._forget()
        return code

    def parameterized_stop(self, deceleration: float, jerk: float) -> int:
        """Stop with this ramp (0x05)."""
        code = parameterized_stop(self.axis, deceleration, jerk)
        if code == OK:
            self._forget()
        return code

    def emergency_stop(self, deceleration: float, jerk: float) -> int:
        """Stop with a ramp not weaker than now (0x04); `step_on` goes on with what was commanded.

        Moves to a target and endless ones go on, and absolute moves that waited.
        """
        moves = self._commanded()
        code = emergency_stop(self.axis, deceleration, jerk)
        if code == OK and not self.emergency_stop_active:
            self.emergency_stop_active = 1
            self._interrupted = moves
        return code

    def step_on(self) -> int:
        """Go on after an emergency stop (0x06), from where the axis came to rest."""
        if not self.emergency_stop_active:
            return OK
        mode = BufferMode.ABORTING
        for move in self._interrupted:
            code = universal_start(self.axis, *move, buffer_mode=mode)
            if code:
                return code
            mode = BufferMode.BUFFERED
        self._forget()
        return OK

    def _forget(self) -> None:
        self.emergency_stop_active = 0
        self._interrupted = []

    def _commanded(self) -> list[_Move]:
        axis = self.axis
        job = axis.job
        ramps = job.acceleration, job.deceleration, job.jerk
        if axis.set_motion_phase == MotionPhase.POSITIONING:
            now = _Move(StartType.ABSOLUTE, axis.target_position, job.velocity, *ramps)
        elif axis.set_motion_phase == MotionPhase.ENDLESS:
            forward = job.direction > 0.0
            kind = StartType.ENDLESS_POSITIVE if forward else StartType.ENDLESS_NEGATIVE
            now = _Move(kind, 0.0, job.velocity, *ramps)
        else:
            return []
        waiting = []
        for n in range(axis.buffer.count):
            each = axis.waiting[(axis.buffer.first + n) % COMMAND_BUFFER]
            if each.start_type == StartType.ABSOLUTE:
                ramps = each.acceleration, each.deceleration, each.jerk
                waiting.append(_Move(StartType.ABSOLUTE, each.position, each.velocity, *ramps))
        return [now, *waiting]
