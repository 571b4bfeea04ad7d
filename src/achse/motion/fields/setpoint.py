"""Fields of the set-point generator: set values, table."""

from math import inf

from achse.motion.fields.declare import InternalFields, States, flag, floats, real, whole

COMMAND_BUFFER = 8
"""Commands that can wait behind the active one; one more is refused with 0x4292."""

SEGMENTS = 13
"""Room of the set-point table: the planner's MAX_SEGMENTS behind a release."""


class SetPoint(States):
    """Set values of one moment."""

    position: float = real(0.0, "mm", "set position")
    velocity: float = real(0.0, "mm/s", "set velocity")
    acceleration: float = real(0.0, "mm/s²", "set acceleration")
    jerk: float = real(0.0, "mm/s³", "set jerk")


class SetpointState(States):
    """Set values and commands (002 §6.4.4.2)."""

    set_cycle_counter: int = whole(0, "1", "cycles of this axis")
    set_motion_phase: int = whole(0, "MotionPhase", "what makes the set point, 0 = nothing")
    target_position: float = real(0.0, "mm", "position where the axis will stop")
    remaining_time: float = real(0.0, "s", "until the set point arrives")
    remaining_distance: float = real(0.0, "mm", "until the set point arrives")
    last_positioning_time: float = real(0.0, "s", "last job, from start to target window")
    set_command_number: int = whole(0, "1", "number of the active command, 16 bits")
    set_command_state: int = whole(0, "CommandState", "state of the active command")
    command_counter: int = whole(0, "1", "number given to the last accepted command, 16 bits")
    motion_locked: int = flag(0, "a stop holds the axis until the lock is released")
    has_been_stopped: int = flag(0, "a stop was given since the last start")
    got_new_target: int = flag(0, "the target was changed during motion")


class BufferLevel(States):
    """Number of the commands that wait."""

    count: int = whole(0, "1", "jobs that wait")


class BufferRing(InternalFields):
    """Place of the commands that wait in their ring."""

    first: int = whole(0, "1", "oldest of the jobs that wait")


class CommandBuffer(BufferLevel, BufferRing):
    """Commands that wait behind the active one."""


class SoftLimits(InternalFields):
    """Soft limits in force."""

    recheck: int = flag(0, "limits or positions changed: the profile must be checked again")
    active: int = flag(0, "a soft limit is in force")
    low: float = real(-inf, "mm", "lower soft limit")
    high: float = real(inf, "mm", "upper soft limit")
    reached: int = whole(0, "1", "soft limit that ends the motion: 1 upper, -1 lower")


class VelocitySwitch(InternalFields):
    """Change of velocity, and of the target, at a position on the way."""

    armed: int = whole(0, "1", "change at the switch position: 1 velocity, 2 target too")
    from_below: int = flag(0, "the switch position is in positive direction")
    position: float = real(0.0, "mm", "switch position")
    target: float = real(0.0, "mm", "target from there on")
    velocity: float = real(0.0, "mm/s", "velocity from there on")


class Border(InternalFields):
    """Point where the next command takes over, or the target."""

    position: float = real(0.0, "mm", "position of the border")
    velocity: float = real(0.0, "mm/s", "velocity there at 100 % override")
    time: float = real(-1.0, "s", "until a profile that goes on passes it; -1 = it does not")


class TargetLoop(InternalFields):
    """Approach of each target from one side, if need be by way of a point beyond it."""

    undecided: int = flag(1, "the next plan decides whether the target is passed first")
    outward: int = flag(0, "the axis moves beyond the target first")
    target: float = real(0.0, "mm", "target of this decision")


class MotionProfile(InternalFields):
    """Segments of constant jerk that the set point moves along."""

    replan: int = flag(0, "the segments must be computed again")
    override: int = whole(0, "1e-6", "override they were computed for")
    count: int = whole(0, "1", "segments")
    index: int = whole(0, "1", "active segment")
    elapsed: float = real(0.0, "s", "time since the start of the active segment")
    position: float = real(0.0, "mm", "position at its start")
    velocity: float = real(0.0, "mm/s", "velocity at its start")
    acceleration: float = real(0.0, "mm/s²", "acceleration at its start")
    end: int = whole(0, "1", "what follows the last one: 0 rest, 1 target, 2 constant velocity")
    end_velocity: float = real(0.0, "mm/s", "velocity at the end of the last one")
    deceleration: float = real(0.0, "mm/s²", "deceleration they were made with")
    jerk_limit: float = real(0.0, "mm/s³", "jerk they were made with, but for the release")
    begins_with_release: int = flag(
        0, "the first segment takes the acceleration away with the running jerk"
    )
    running_jerk: float = real(0.0, "mm/s³", "jerk that takes the present acceleration away")
    plan_position: float = real(0.0, "mm", "position behind the release")
    plan_velocity: float = real(0.0, "mm/s", "velocity there")
    plan_acceleration: float = real(0.0, "mm/s²", "acceleration there")
    abrupt: int = flag(0, "the axis moves without a jerk limit, so a stop before a soft limit may")
    fastest: float = real(0.0, "mm/s", "largest velocity they were made for")
    time: list[float] = floats(SEGMENTS, "s", "duration of each segment")
    jerk: list[float] = floats(SEGMENTS, "mm/s³", "jerk of each segment")
