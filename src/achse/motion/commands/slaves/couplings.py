"""Couplings: let an axis follow others, change how, and let it go again.

Services that couple by a law of their own use `check_slave` and `begin_coupling`.
"""

from collections.abc import Callable, Sequence
from math import isfinite

from achse.codes import NcError
from achse.codes.axis import CommandState, StartType
from achse.codes.nc.choices import AxisType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK, SLOWEST, check_dynamics, check_velocity
from achse.motion.commands.queue import busy, dynamics, next_number
from achse.motion.commands.starts import universal_start
from achse.motion.commands.stops import oriented_stop
from achse.motion.couplings.multi_master import apply_ratios
from achse.motion.couplings.table import Coupling, count_from_here, law_of
from achse.motion.fields.coupling import COUPLING_PARAMETERS
from achse.motion.order import CouplingRing
from achse.motion.rounding import JUST_BELOW
from achse.motion.setpoints.jobs import set_request
from achse.motion.setpoints.setpoint import absorb, begin_job, begin_stop, drop_job, end_homing
from achse.motion.states import DecouplingType, SlaveType

LARGEST_PARAMETER = 1e6
"""Parameters of couplings are up to this, either sign (002 §6.4.4.3)."""


def couple(
    slave: Axis,
    slave_type: int,
    master_id: int,
    master_subindex: int = 0,
    slave_subindex: int = 0,
    *parameters: float,
) -> int:
    """Let an axis follow another one (0x40); positions do not jump.

    Four parameters, what is not given is 0; what they mean is said by the law. Both axes are at
    standstill, unless the law couples in motion.
    """
    coupling_parameters = (*parameters, 0.0, 0.0, 0.0, 0.0)[:COUPLING_PARAMETERS]
    law = law_of(slave_type)
    if law is None or not law.by_parameters:
        return NcError.SLAVE_TYPE
    if master_subindex or slave_subindex:  # of table and group places, which no such type has
        return NcError.SLAVE_COUPLING_PARAMETER
    code = check_slave(slave)
    if code:
        return code
    return begin_coupling(
        slave,
        slave_type,
        (master_id, *law.others(coupling_parameters)),
        coupling_parameters,
        moving=law.moving,
        check=lambda masters: _check_parameters(slave, masters, law, coupling_parameters),
    )


def couple_to_several(
    slave: Axis,
    slave_type: int,
    master_ids: Sequence[int],
    acceleration: float,
    deceleration: float = 0.0,
    jerk: float = 0.0,
    velocity: float = 0.0,
) -> int:
    """Let an axis follow up to four masters with the ratios of the cyclic interface (0x40).

    Ids of 0 name no master; the first one is there. Dynamics of 0 are the axis defaults, a jerk or
    velocity of 0 does not limit. All may be in motion: the slave reaches v = Σ g · v by its ramp.
    """
    if slave_type not in _OF_SEVERAL:
        return NcError.SLAVE_TYPE
    code = check_slave(slave)
    if code:
        return code
    limits = acceleration, deceleration, jerk, velocity
    if not all(isfinite(each) and each >= 0.0 for each in limits) or not master_ids[0]:
        return NcError.SLAVE_COUPLING_PARAMETER
    places = [place for place, id in enumerate(master_ids) if id]
    ids = [master_ids[place] for place in places]
    if len(set(ids)) < len(ids):
        return NcError.SLAVE_COUPLING_PARAMETER
    ramp = dynamics(slave, acceleration, deceleration or acceleration, jerk)
    code = check_dynamics(slave, *ramp)
    if code:
        return code

    def fill() -> None:
        slave.coupling.acceleration, slave.coupling.deceleration = ramp[:2]
        slave.coupling.jerk, slave.coupling.velocity = jerk, velocity
        for n, place in enumerate(places):
            slave.coupling.ratio_places[n], slave.coupling.ratios[n] = place, 0.0
        apply_ratios(slave)

    return begin_coupling(
        slave,
        SlaveType.MULTI_MASTER,
        ids,
        moving=True,
        slave_moves=True,
        fill=fill,
    )


_OF_SEVERAL = (
    SlaveType.CYCLIC_GEAR,
    SlaveType.SEVERAL_CYCLIC_GEARS,
    SlaveType.MULTI_MASTER,
)
"""Slave types of the longer forms, all the same; 002 prints none."""


def check_slave(slave: Axis) -> int:
    """Return the error that forbids this axis to become a slave at all, or 0."""
    if slave.axis_disabled:
        return NcError.AXIS_NOT_READY
    if slave.error_code:
        return slave.error_code
    if slave.grouped:
        return NcError.FUNCTION_NOT_ALLOWED
    if slave.motion_locked:
        return NcError.AXIS_LOCKED_BY_STOP
    if slave.external_setpoint_active:
        return NcError.EXTERNAL_GENERATOR_ACTIVE
    if slave.axis_type in (AxisType.ENCODER, AxisType.DISCRETE_RAPID_CREEP):
        return NcError.AXIS_INCOMPATIBLE
    return NcError.SLAVE_ADDRESS if slave.coupling.law else OK


def _moves(axis: Axis) -> bool:
    """Return True if an axis has a job or moves with its own masters.

    An encoder axis moves if it covers more than an increment in a cycle.
    """
    if axis.axis_type == AxisType.ENCODER:
        return abs(axis.actual_velocity) * axis.cycle_ns > axis.encoder.scaling_factor * 1e9
    own = busy(axis) and axis.set_motion_phase != MotionPhase.COUPLED
    return own or axis.set.velocity != 0.0


def _any(masters: Sequence[Axis]) -> int:
    """Nothing more to demand."""
    return OK


def _nothing() -> None:
    """Do nothing: the law's memory needs no more than its `base`."""


def begin_coupling(
    slave: Axis,
    coupling: int,
    master_ids: Sequence[float],
    parameters: Sequence[float] = (),
    *,
    moving: bool = False,
    slave_moves: bool = False,
    check: Callable[[Sequence[Axis]], int] = _any,
    fill: Callable[[], None] = _nothing,
) -> int:
    """Let an axis that may be a slave (`check_slave`) follow these masters by a law.

    Masters are at standstill unless `moving`, the slave unless `slave_moves`; what it does then
    goes over into the coupling. `check` gets the masters and refuses with a code; a refused
    coupling leaves all axes as they were. `fill` then fills the law's memory, the law's `base`
    comes last.
    """
    masters = [slave.fellows[int(n)] for n in master_ids if n in slave.fellows]
    if len(masters) < len(master_ids):
        return NcError.ADDRESS_MASTER_AXIS
    code = check(masters)
    if code:
        return code
    for master in masters:
        if master.axis_type == AxisType.DISCRETE_RAPID_CREEP:
            return NcError.AXIS_INCOMPATIBLE
        if master.error_code:
            return master.error_code
    standing = (*(() if slave_moves else (slave,)), *(() if moving else masters))
    if any(map(_moves, standing)):
        return NcError.COUPLING_DURING_JOB
    try:
        slave.follow(coupling, masters)
    except CouplingRing:
        return NcError.MASTER_NOT_INSERTED
    for n, value in enumerate(parameters):
        slave.coupling.parameters[n] = value
    fill()
    absorb(slave)
    end_homing(slave)
    slave.buffer.count = slave.switch.armed = 0
    job = slave.job
    job.timing = 0
    job.acceleration, job.deceleration, job.jerk = dynamics(slave, 0.0, 0.0, 0.0)  # of its stops
    if slave.set_command_state == CommandState.ACTIVE:
        slave.set_command_state = CommandState.ABORTED
    if slave.loop_closed:
        slave.set_motion_phase = MotionPhase.COUPLED
    count_from_here(slave, slave.rows)
    slave.show()
    return OK


def _check_parameters(
    slave: Axis, masters: Sequence[Axis], law: Coupling, parameters: Sequence[float]
) -> int:
    if not all(isfinite(each) and abs(each) <= LARGEST_PARAMETER for each in parameters):
        return NcError.SLAVE_COUPLING_PARAMETER
    return law.check(slave, masters, parameters) if law.check else NcError.SLAVE_TYPE


def change_coupling(slave: Axis, *parameters: float) -> int:
    """Change the parameters of a coupling at work (0x42).

    A new ratio of a gear, a bi-linear slave or a flying saw that runs with its master acts at once:
    the velocity jumps, the position does not. 0x425B if the slave may not be that fast, 0x4229 if
    it could not stop before a soft limit.
    """
    law = law_of(slave.coupling.law)
    if law is None or law.check is None:
        return NcError.SLAVE_TYPE
    axes = list(slave.fellows.values())
    masters = [axes[row] for row in slave.followed]
    others = tuple(master.axis_id for master in masters[1:])
    if law.by_parameters and law.others(parameters) != others:
        return NcError.SLAVE_COUPLING_PARAMETER
    code = _check_parameters(slave, masters, law, parameters)
    if not code and law.check_change is not None:
        code = law.check_change(slave, slave.rows, parameters, slave.cycle_ns * 1e-9)
    if code:
        return code
    for n, value in enumerate(parameters):
        slave.coupling.parameters[n] = value
    if law.change is None:
        count_from_here(slave, slave.rows)
    else:
        law.change(slave, slave.rows)
    slave.show()
    return OK


def decouple(slave: Axis) -> int:
    """Let a slave go (0x41): a standing one rests, a moving one keeps its velocity, endlessly."""
    if not slave.coupling.law:
        return NcError.DECOUPLING_NOT_POSSIBLE
    if _rests(slave):
        _free(slave)
        drop_job(slave)
        slave.show()
        return OK
    return decouple_with_follow_up(slave, DecouplingType.ENDLESS)


def decouple_with_follow_up(
    slave: Axis,
    decoupling_type: int,
    position: float = 0.0,
    velocity: float = 0.0,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    jerk: float = 0.0,
) -> int:
    """Let a slave go, and what it does then (0x41): one of `DecouplingType`.

    It goes on from the position, velocity and acceleration that it has. Position and velocity count
    only where the type names them; dynamics of 0 are the axis defaults. The override of the axis,
    which a slave has none of, acts from then on.
    """
    code = _decouple(slave, decoupling_type, position, velocity, acceleration, deceleration, jerk)
    if not code:
        slave.show()
    return code


def _decouple(
    slave: Axis,
    decoupling_type: int,
    position: float,
    velocity: float,
    acceleration: float,
    deceleration: float,
    jerk: float,
) -> int:
    if not slave.coupling.law:
        return NcError.DECOUPLING_NOT_POSSIBLE
    if decoupling_type not in DecouplingType.__members__.values():
        return NcError.DECOUPLING_TYPE
    limits = dynamics(slave, acceleration, deceleration, jerk)
    code = check_dynamics(slave, *limits)
    if code:
        return code
    if decoupling_type in (
        DecouplingType.ENDLESS_NEW_VELOCITY,
        DecouplingType.NEW_POSITION_AND_VELOCITY,
    ) and check_velocity(slave, velocity):
        return NcError.DECOUPLING_VELOCITY
    match decoupling_type:
        case DecouplingType.STOP:
            _stop(slave, limits)
            return OK
        case DecouplingType.INSTANTANEOUS_STOP:
            _free(slave)
            drop_job(slave)
            return OK
        case DecouplingType.ORIENTED_STOP:
            return _stop_oriented(slave, position, limits)
        case DecouplingType.ENDLESS:
            reached = _run_out(slave, limits[2])
            _endless(slave, reached, abs(reached), limits)
            return OK
        case DecouplingType.ENDLESS_NEW_VELOCITY:
            _endless(slave, slave.set.velocity or 1.0, velocity, limits)
            return OK
        case DecouplingType.NEW_POSITION:
            velocity = abs(_run_out(slave, limits[2]))
            if velocity < SLOWEST:  # below the slowest velocity there is none to keep
                return NcError.DECOUPLING_VELOCITY
    return _as_free(slave, universal_start, StartType.ABSOLUTE, position, velocity, *limits)


def _rests(slave: Axis) -> bool:
    return slave.set.velocity == 0.0 and slave.set.acceleration == 0.0


def _free(slave: Axis) -> None:
    """End all couplings; set values stay what they are.

    The jerk that takes a deceleration away in time is at least that before rest. Before the first
    cycle of a law the deceleration is the slave's own, and so is its jerk.
    """
    slave.release()
    absorb(slave)
    profile = slave.profile
    v, a = slave.set.velocity, slave.set.acceleration
    steep = a * a / abs(v) if a * v < 0.0 else 0.0
    if profile.abrupt or steep * JUST_BELOW > 2.0 * profile.running_jerk:
        profile.running_jerk = steep


def _run_out(slave: Axis, jerk: float) -> float:
    """Velocity once the acceleration is taken away; not across rest."""
    v, a = slave.set.velocity, slave.set.acceleration
    reached = v + a * abs(a) / (2.0 * jerk)
    return 0.0 if reached * v < 0.0 else reached


def _stop(slave: Axis, limits: tuple[float, float, float]) -> None:
    """End all couplings and come to rest; a slave at rest needs no cycle for that."""
    rests = _rests(slave)
    _free(slave)
    slave.job.acceleration = limits[0]
    begin_stop(slave, *limits[1:])
    if rests:
        drop_job(slave)


def _endless(
    slave: Axis, heading: float, velocity: float, limits: tuple[float, float, float]
) -> None:
    """Go on at `velocity`, in the direction of `heading`; without either, come to rest."""
    if velocity == 0.0:
        _stop(slave, limits)
        return
    _free(slave)
    start_type = StartType.ENDLESS_POSITIVE if heading > 0.0 else StartType.ENDLESS_NEGATIVE
    set_request(slave.job, next_number(slave), start_type, 0.0, velocity, *limits, 0.0)
    begin_job(slave)


def _stop_oriented(slave: Axis, position: float, limits: tuple[float, float, float]) -> int:
    """Stop a moving slave at a position within the period; at rest it is refused."""
    if slave.set.velocity == 0.0:
        return NcError.DECOUPLING_VELOCITY
    job = slave.job
    job.acceleration, job.deceleration, job.jerk = limits
    job.velocity = abs(slave.set.velocity)
    phase = slave.set_motion_phase
    slave.set_motion_phase = MotionPhase.ENDLESS
    code = _as_free(slave, oriented_stop, position, *limits[1:])
    if code:
        slave.set_motion_phase = phase
    return code


def _as_free(slave: Axis, command: Callable[..., int], *arguments: float) -> int:
    """Return a command as for an uncoupled axis; refused, the slave stays coupled."""
    coupling, slave.coupling.law = slave.coupling.law, 0
    code = command(slave, *arguments)
    slave.coupling.law = coupling
    if not code:
        slave.release()
    return code


def decouple_and_start(slave: Axis, start_type: int, *arguments: float) -> int:
    """Uncouple a slave and start it (0x17); an axis that is not a slave cannot be uncoupled."""
    if not slave.coupling.law:
        return NcError.DECOUPLING_NOT_POSSIBLE
    code = _as_free(slave, universal_start, start_type, *arguments)
    if not code:
        slave.show()
    return code


def stop_slave(slave: Axis) -> int:
    """Stop a flying saw and uncouple it (0x44); other slaves have no motion of their own."""
    law = law_of(slave.coupling.law)
    if law is not None and law.stops:
        return decouple_with_follow_up(slave, DecouplingType.STOP)
    return NcError.FUNCTION_FOR_SLAVE if slave.coupling.law else NcError.FUNCTION_NOT_AVAILABLE
