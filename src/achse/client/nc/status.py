"""The status of an axis: one sample of its cyclic structure, with names for what its bits say.

Source: 004 §5.1.1 and 002 §6.4.4.4, 0x4300 + id: 0x80; the PLCopen states are those of 004 §2.2.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from achse.codes.axis import HomingState, MotionState, OperationModeBit, StateBit


class PlcOpenState(Enum):
    """State of an axis as PLCopen names it."""

    DISABLED = "Disabled"
    STANDSTILL = "Standstill"
    HOMING = "Homing"
    DISCRETE_MOTION = "DiscreteMotion"
    CONTINUOUS_MOTION = "ContinuousMotion"
    SYNCHRONIZED_MOTION = "SynchronizedMotion"
    STOPPING = "Stopping"
    ERROR_STOP = "ErrorStop"


STEADY_STATES = (
    (StateBit.ERROR, PlcOpenState.ERROR_STOP),
    (StateBit.MOTION_COMMANDS_LOCKED, PlcOpenState.STOPPING),
    (StateBit.PROTECTED, PlcOpenState.SYNCHRONIZED_MOTION),
    (StateBit.HOMING_BUSY, PlcOpenState.HOMING),
    (StateBit.HAS_JOB | StateBit.CONTINUOUS_MOTION, PlcOpenState.CONTINUOUS_MOTION),
    (StateBit.HAS_JOB, PlcOpenState.DISCRETE_MOTION),
)
"""State by the bits of StateDWord; the first whose bits are all set counts."""


def plc_open_state(state_word: int) -> PlcOpenState:
    """State by the bits of StateDWord."""
    for bits, state in STEADY_STATES:
        if state_word & bits == bits:
            return state
    enabled = state_word & (StateBit.OPERATIONAL | StateBit.CONTROL_LOOP_CLOSED)
    return PlcOpenState.STANDSTILL if enabled else PlcOpenState.DISABLED


def flag_names(state_word: int) -> list[str]:
    """Return the bits of StateDWord that are set, in words."""
    return [bit.name.lower().replace("_", " ") for bit in StateBit if state_word & bit]


@dataclass(frozen=True, slots=True)
class AxisStatus:
    """One sample of an axis. Positions in its unit, velocities per second.

    `time` is seconds of the controller's own time since the first sample of a row of them.
    """

    position: float
    velocity: float
    set_position: float
    set_velocity: float
    set_acceleration: float
    target_position: float
    modulo_position: float
    following_error: float
    error_code: int
    state_word: int
    """StateDWord; `flags` names its bits."""
    operation_mode: int
    """OpModeDWord."""
    motion_number: int
    """AxisState as a number; `motion_state` names it."""
    homing_number: int
    """Step of the homing sequence; `homing_state` names it."""
    coupling_state: int
    command_number: int
    """Number of the active command, or of the last one."""
    waiting: int
    """Commands that wait behind the active one."""
    time: float = 0.0
    lost: int = 0
    """Samples dropped before this one because the client did not fetch them in time."""

    @classmethod
    def of(cls, values: Mapping[str, Any], time: float = 0.0, lost: int = 0) -> "AxisStatus":
        """From the fields of the cyclic structure, that of TwinCAT 2 or 3."""
        mode = values.get("operation_mode_and_cycle")
        return cls(
            position=values["actual_position"],
            velocity=values["actual_velocity"],
            set_position=values["set_position"],
            set_velocity=values["set_velocity"],
            set_acceleration=values["set_acceleration"],
            target_position=values["target_position"],
            modulo_position=values["actual_position_modulo"],
            following_error=values["following_error"],
            error_code=values["error_code"],
            state_word=values["state_dword"],
            operation_mode=values["operation_mode_state_dword"] if mode is None else mode,
            motion_number=values["motion_state"],
            homing_number=values["homing_state"],
            coupling_state=values["coupling_state"],
            command_number=values["set_command_number"],
            waiting=values["buffer_count"],
            time=time,
            lost=lost,
        )

    @property
    def state(self) -> PlcOpenState:
        """The PLCopen state."""
        return plc_open_state(self.state_word)

    @property
    def flags(self) -> frozenset[StateBit]:
        """The bits of StateDWord that are set."""
        return frozenset(bit for bit in StateBit if self.state_word & bit)

    def _repr_html_(self) -> str:
        """Return the status as HTML for a notebook."""
        return self.html("axis", "")

    def html(self, name: str, unit: str) -> str:
        """Return a table of it; `unit` is that of positions."""
        from achse.ams.errors import describe_code
        from achse.plot.markup import facts

        speed = unit and f"{unit}/s"
        rows = [
            ("state", self.state.value),
            ("position", f"{self.position:.6g} {unit}".strip()),
            ("velocity", f"{self.velocity:.6g} {speed}".strip()),
            ("set position", f"{self.set_position:.6g} {unit}".strip()),
            ("following error", f"{self.following_error:.6g} {unit}".strip()),
            ("error", describe_code(self.error_code) if self.error_code else "none"),
            ("flags", ", ".join(flag_names(self.state_word)) or "none"),
        ]
        return facts(name, rows)

    @property
    def motion_state(self) -> MotionState | int:
        """State of the set-point generator; a plain number where no manual names it."""
        try:
            return MotionState(self.motion_number)
        except ValueError:
            return self.motion_number

    @property
    def homing_state(self) -> HomingState | int:
        """The step of the homing sequence."""
        try:
            return HomingState(self.homing_number)
        except ValueError:
            return self.homing_number

    def has(self, bit: StateBit) -> bool:
        """Return True if a bit of StateDWord is set."""
        return bool(self.state_word & bit)

    @property
    def enabled(self) -> bool:
        """Enabled, without error and ready."""
        return self.has(StateBit.OPERATIONAL)

    @property
    def failed(self) -> bool:
        """In error."""
        return self.error_code != 0 or self.has(StateBit.ERROR)

    @property
    def homed(self) -> bool:
        """Its position refers to the machine."""
        return self.has(StateBit.HOMED)

    @property
    def standstill(self) -> bool:
        """The set point does not move."""
        return self.has(StateBit.NOT_MOVING)

    @property
    def has_job(self) -> bool:
        """A command is at work."""
        return self.has(StateBit.HAS_JOB)

    @property
    def in_target(self) -> bool:
        """No command is at work, and the axis is where it should be as far as the NC watches."""
        if self.has_job:
            return False
        if self.operation_mode & OperationModeBit.TARGET_POSITION_MONITORING:
            return self.has(StateBit.IN_TARGET_POSITION)
        if self.operation_mode & OperationModeBit.POSITION_AREA_MONITORING:
            return self.has(StateBit.IN_POSITION_AREA)
        return True

    @property
    def application_request(self) -> bool:
        """True if the NC requests an action of the application, such as homing the axis."""
        return bool(self.operation_mode & OperationModeBit.APPLICATION_REQUEST)
