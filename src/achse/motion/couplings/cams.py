"""Slave types 10, 11 and 13: the slave's position is that of a cam over its master, or of several.

    cam position = (master - master reference - master offset) / master scaling
    slave = base + Σ (slave reference + slave offset + slave scaling · (cam + lift of its cycles))

References are 0 where positions are absolute, else where the axis was when the cam began. A cyclic
cam goes on to both sides; outside a linear one the slave keeps the value of its end. A cam begins
in its basic cycle, without lift.

What is to change (`next_kind`) waits in the layer until its time has come. It counts from the exact
position that was asked for, not from that of the cycle which finds it passed: the cycle time does
not matter. A cam that is taken away leaves what it added in the base. A change by which the slave
would jump (`achse.motion.couplings.guard`) waits on.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import ceil, floor

from achse.codes import NcError
from achse.motion.couplings.guard import why_not_step
from achse.motion.couplings.masters import seen_of_row
from achse.motion.limits import TOLERANCE
from achse.motion.record import AxisFields, CamFields
from achse.motion.rows import NcRows
from achse.motion.states import CamActivation, CamScaling, StateBit
from achse.motion.tables.memory import BEGIN, CYCLIC, PERIOD, STROKE, cam_values

__all__ = [
    "CHANGE_BEGIN",
    "CHANGE_EXCHANGE",
    "CHANGE_NOTHING",
    "CHANGE_POINTS",
    "CHANGE_REMOVE",
    "CHANGE_SCALING",
    "base",
    "carry_out",
    "change",
    "due",
    "jump_of",
    "law_after",
    "law_now",
    "names_of",
    "part_at",
    "planned",
    "seen_master",
    "show_cams",
    "show_waiting",
    "step",
    "why_not_jump",
]

CHANGE_NOTHING = 0
CHANGE_BEGIN = 1
CHANGE_SCALING = 2
CHANGE_EXCHANGE = 3
CHANGE_REMOVE = 4
CHANGE_POINTS = 5
"""`next_kind` of a layer; with other points a motion function keeps its cycles and references."""

_MOST_CYCLES = 1e15
"""Beyond, cycles of a cam cannot be told from each other."""

_RELATIVE = 1e-12
"""Rounding of a position."""


def seen_master(ax: AxisFields, rows: NcRows, layer: CamFields) -> float:
    """Master position of a layer, with the phase shift of the slave."""
    return seen_of_row(ax, rows, layer.master)[0]


def names_of(rows: NcRows, layer: CamFields) -> float:
    """What the master's own positions are larger than those that are seen: it was renamed while
    others followed it."""
    return rows.axes[layer.master].lead_offset


def _cycle_of(rows: NcRows, cam: int, position: float) -> int:
    """Number of the cycle of a cam position; 0 for linear cams."""
    if rows.cams[cam + CYCLIC] == 0.0:
        return 0
    cycles = (position - rows.cams[cam + BEGIN]) / rows.cams[cam + PERIOD]
    return floor(min(max(cycles, -_MOST_CYCLES), _MOST_CYCLES))


def part_at(
    rows: NcRows, layer: CamFields, position: float
) -> tuple[float, float, float, float, float]:
    """What a layer adds to the slave at a cam position, its derivatives by it, the lift so far."""
    cam = layer.cam
    cycle = 0
    within = position
    if layer.once:
        within = position - layer.base_cycle * rows.cams[cam + PERIOD]
    else:
        begin = rows.cams[cam + BEGIN]
        period = rows.cams[cam + PERIOD]
        cycle = layer.cycle
        within = position - cycle * period
        if within < begin or within >= begin + period:
            cycle = _cycle_of(rows, cam, position)
            within = position - cycle * period
            layer.cycle = cycle
        cycle -= layer.base_cycle
    value, slope, bend, third, layer.near = cam_values(rows.cams, cam, layer.near, within)
    strokes = cycle * rows.cams[cam + STROKE]
    layer.cam_position = within
    layer.value = value
    part = layer.slave_reference + layer.slave_offset + layer.slave_scaling * (value + strokes)
    return part, slope, bend, third, strokes


def _values(
    rows: NcRows, cam: int, once: int, base_cycle: int, near: int, position: float
) -> tuple[float, float, float]:
    """Slave position of a cam with its lift, slope and bend, at a cam position with its cycles."""
    cycle = base_cycle if once else _cycle_of(rows, cam, position)
    within = position - cycle * rows.cams[cam + PERIOD]
    value, slope, bend, _, _ = cam_values(rows.cams, cam, near, within)
    return value + (cycle - base_cycle) * rows.cams[cam + STROKE], slope, bend


def _part(rows: NcRows, layer: CamFields, master: float) -> float:
    """Return what a layer adds to the slave at a master position; the layer is unchanged."""
    position = _cam_position(layer, master)
    value = _values(rows, layer.cam, layer.once, layer.base_cycle, layer.near, position)[0]
    return layer.slave_reference + layer.slave_offset + layer.slave_scaling * value


def law_now(ax: AxisFields, rows: NcRows, without: int) -> tuple[float, float, float]:
    """Return position, velocity and acceleration by all layers but one, where masters are now.

    The layers stay as they are. `without` -1 is none.
    """
    s = ax.slave_base
    v = 0.0
    a = 0.0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        if layer.table and n != without:
            seen, velocity, acceleration, _ = seen_of_row(ax, rows, layer.master)
            share = 1.0 / layer.master_scaling
            value, slope, bend = _values(
                rows,
                layer.cam,
                layer.once,
                layer.base_cycle,
                layer.near,
                _cam_position(layer, seen),
            )
            velocity *= share
            acceleration *= share
            factor = layer.slave_scaling
            s += layer.slave_reference + layer.slave_offset + factor * value
            v += factor * slope * velocity
            a += factor * (bend * velocity * velocity + slope * acceleration)
    return s, v, a


def _cam_position(layer: CamFields, master: float) -> float:
    """Position of the cam in which it works, cycles included."""
    return (master - layer.master_reference - layer.master_offset) / layer.master_scaling


def planned(
    ax: AxisFields, rows: NcRows, layer: CamFields, at: float
) -> tuple[float, float, float, int, float, float, float, float]:
    """What the layer is to be after its change at a master position.

    Master reference, offset, scaling, base cycle; slave reference, offset, scaling; what it adds.
    """
    kind = layer.next_kind
    runs = layer.table != 0
    before = _part(rows, layer, at) if runs else 0.0
    cam = layer.cam if kind == CHANGE_SCALING else layer.next_cam
    fresh = kind != CHANGE_SCALING and kind != CHANGE_POINTS
    reference = layer.master_reference
    offset = layer.master_offset
    scaling = layer.master_scaling
    if layer.next_master_type == CamScaling.AUTO_OFFSET:  # of a cam at work only
        place = (_cam_position(layer, at) - rows.cams[layer.cam + BEGIN]) / rows.cams[
            layer.cam + PERIOD
        ]
        position = rows.cams[cam + BEGIN] + place * rows.cams[cam + PERIOD]
        scaling = layer.next_master_scaling
        offset = at - reference - scaling * position
    elif layer.next_master_type != CamScaling.OFF:
        if fresh:
            reference = -names_of(rows, layer) if layer.next_master_absolute else at
        offset = layer.next_master_offset
        scaling = layer.next_master_scaling
    elif not runs:
        reference = -names_of(rows, layer) if layer.next_master_absolute else at
        offset = 0.0
        scaling = 1.0
    position = (at - reference - offset) / scaling
    cycle = _cycle_of(rows, cam, position)
    base_cycle = cycle if fresh else layer.base_cycle
    within = position - cycle * rows.cams[cam + PERIOD]
    value = cam_values(rows.cams, cam, layer.near, within)[0]
    value += (cycle - base_cycle) * rows.cams[cam + STROKE]
    slave_reference = layer.slave_reference
    slave_offset = layer.slave_offset
    slave_scaling = layer.slave_scaling
    if layer.next_slave_type != CamScaling.OFF:
        slave_scaling = layer.next_slave_scaling
        slave_offset = layer.next_slave_offset
    elif not runs:
        slave_scaling = 1.0
        slave_offset = 0.0
    if fresh:
        slave_reference = 0.0
        if layer.next_slave_absolute == 0:
            slave_reference = before - slave_offset - slave_scaling * value
    if layer.next_slave_type == CamScaling.AUTO_OFFSET and (not fresh or layer.next_slave_absolute):
        stays = before
        if _alone(ax):
            stays = ax.set_position
        slave_offset = stays - slave_reference - slave_scaling * value
    part = slave_reference + slave_offset + slave_scaling * value
    return (
        reference,
        offset,
        scaling,
        base_cycle,
        slave_reference,
        slave_offset,
        slave_scaling,
        part,
    )


def _alone(ax: AxisFields) -> bool:
    """Whether no cam is at work yet."""
    tables = 0
    for n in range(ax.cam_count):
        tables += ax.cams[n].table
    return tables == 0


def change(ax: AxisFields, rows: NcRows, layer: CamFields, at: float) -> None:
    """Carry out what the layer waits for, at a master position; what is for one cycle is taken back
    at the next."""
    once = layer.next_when == CamActivation.NEXT_CYCLE_ONCE
    table = layer.table
    cam = layer.cam
    interpolation = layer.interpolation
    slave_absolute = layer.slave_absolute
    master_absolute = layer.master_absolute
    master_offset = layer.master_offset
    master_scaling = layer.master_scaling
    slave_offset = layer.slave_offset
    slave_scaling = layer.slave_scaling
    if layer.next_kind == CHANGE_REMOVE:
        ax.slave_base += part_at(rows, layer, _cam_position(layer, at))[0]
        layer.table = 0
    else:
        after = planned(ax, rows, layer, at)
        if layer.next_slave_absolute and _alone(ax):
            ax.slave_base = 0.0
        if layer.next_kind != CHANGE_SCALING:
            layer.table = layer.next_table
            layer.cam = layer.next_cam
            layer.interpolation = layer.next_interpolation
            layer.slave_absolute = layer.next_slave_absolute
            if layer.next_master_type != CamScaling.AUTO_OFFSET:
                layer.master_absolute = layer.next_master_absolute
        layer.master_reference = after[0]
        layer.master_offset = after[1]
        layer.master_scaling = after[2]
        layer.base_cycle = after[3]
        layer.slave_reference = after[4]
        layer.slave_offset = after[5]
        layer.slave_scaling = after[6]
        layer.cycle = 0  # a linear cam has no other
        layer.part, _, _, _, layer.strokes = part_at(rows, layer, _cam_position(layer, at))
    if once:
        layer.next_when = CamActivation.NEXT_CYCLE
        layer.next_table = 0 if layer.next_kind == CHANGE_SCALING else table
        layer.next_cam = cam
        layer.next_interpolation = interpolation
        layer.next_slave_absolute = slave_absolute
        layer.next_master_absolute = master_absolute
        layer.next_master_type = CamScaling.USER_DEFINED
        layer.next_slave_type = CamScaling.USER_DEFINED
        layer.next_master_offset = master_offset
        layer.next_master_scaling = master_scaling
        layer.next_slave_offset = slave_offset
        layer.next_slave_scaling = slave_scaling
        layer.next_returns = 1
        return
    layer.next_kind = CHANGE_NOTHING
    layer.next_table = 0


def _passed(low: float, high: float, place: float) -> bool:
    """Whether a way from one position to the other leads over a place, the begin included."""
    return low <= place <= high or high <= place <= low


def _next_crossing(before: float, now: float, place: float, period: float) -> float:
    """The first of the places, a period apart, behind `before` on the way to `now`."""
    ways = min(max((before - place) / period, -_MOST_CYCLES), _MOST_CYCLES)
    if now >= before:
        return place + (floor(ways) + 1) * period
    return place + (ceil(ways) - 1) * period


def due(rows: NcRows, layer: CamFields, before: float, now: float) -> tuple[int, float]:
    """Return 1 if the time has come for what a layer waits for, and the master position then.

    The master has come from `before` to `now`.
    """
    when = layer.next_when
    place = layer.next_position
    by_axis = place - names_of(rows, layer)
    begins = layer.next_kind == CHANGE_BEGIN
    if when in (CamActivation.INSTANTANEOUS, CamActivation.AS_SOON_AS_POSSIBLE):
        return 1, before
    if when == CamActivation.MASTER_AXIS_POSITION:
        return (1 if _passed(before, now, by_axis) else 0), by_axis
    if when == CamActivation.MASTER_AXIS_POSITION_POSITIVE:
        return (1 if before <= by_axis <= now and before < now else 0), by_axis
    if when == CamActivation.MASTER_AXIS_POSITION_NEGATIVE:
        return (1 if now <= by_axis <= before and now < before else 0), by_axis
    if when == CamActivation.OFF:
        return 0, before
    # at a place of the cam: one of its own, or its begin
    cam = layer.next_cam if begins else layer.cam
    offset = layer.master_reference + layer.master_offset
    scaling = layer.master_scaling
    if begins:
        offset = layer.next_master_offset
        scaling = layer.next_master_scaling
        if layer.next_master_type == CamScaling.OFF:
            offset = 0.0
            scaling = 1.0
        offset -= names_of(rows, layer)
    start = (before - offset) / scaling
    end = (now - offset) / scaling
    begin = rows.cams[cam + BEGIN]
    period = rows.cams[cam + PERIOD]
    next_cycle = when != CamActivation.MASTER_CAM_POSITION
    if next_cycle:
        place = begin
    if rows.cams[cam + CYCLIC]:
        crossing = _next_crossing(start, end, place, period)
        if begins and floor((start - place) / period) * period + place == start:
            crossing = start
        return (1 if _passed(start, end, crossing) else 0), offset + scaling * crossing
    if not next_cycle:
        return (1 if _passed(start, end, place) else 0), offset + scaling * place
    if start < begin or start > begin + period:
        return 1, before
    if end > begin + period:
        return 1, offset + scaling * (begin + period)
    return (1 if end < begin else 0), offset + scaling * begin


def jump_of(ax: AxisFields, rows: NcRows, layer: CamFields, at: float) -> float:
    """Return how far the slave jumps by what a layer waits for, at a master position."""
    if layer.next_kind == CHANGE_REMOVE:
        return 0.0
    after = planned(ax, rows, layer, at)[7]
    if layer.table:
        return after - _part(rows, layer, at)
    if layer.next_slave_absolute and _alone(ax):
        return after - ax.set_position
    return after


def law_after(
    ax: AxisFields, rows: NcRows, number: int, layer: CamFields, at: float
) -> tuple[float, float, float]:
    """Return position, velocity and acceleration of all layers after a change of one.

    The layer changes at a master position; the values are those where the masters are now. Its
    number is -1 as long as the slave does not have it.
    """
    s, v, a = law_now(ax, rows, number)
    if layer.next_kind == CHANGE_REMOVE:
        return s + _part(rows, layer, at), v, a
    if _alone(ax):
        s = 0.0 if layer.next_slave_absolute else ax.set_position
    after = planned(ax, rows, layer, at)
    cam = layer.cam if layer.next_kind == CHANGE_SCALING else layer.next_cam
    seen, velocity, acceleration, _ = seen_of_row(ax, rows, layer.master)
    position = (seen - after[0] - after[1]) / after[2]
    value, slope, bend = _values(rows, cam, layer.once, after[3], layer.near, position)
    share = 1.0 / after[2]
    velocity *= share
    acceleration *= share
    s += after[4] + after[5] + after[6] * value
    v += after[6] * slope * velocity
    a += after[6] * (bend * velocity * velocity + slope * acceleration)
    return s, v, a


def why_not_jump(ax: AxisFields, jump: float) -> int:
    """Return the code that refuses a jump of the slave, which is one beyond its position window."""
    most = ax.position_range_window + TOLERANCE + _RELATIVE * abs(ax.set_position)
    return 0 if abs(jump) <= most else NcError.TABLE_SLAVE_RANGE


def _carry_out_one(ax: AxisFields, rows: NcRows, number: int, layer: CamFields, dt: float) -> None:
    """Carry out what a layer waits for if it is time and the slave can follow; else it waits on."""
    is_due, at = due(rows, layer, layer.seen, seen_master(ax, rows, layer))
    if is_due == 0 or why_not_jump(ax, jump_of(ax, rows, layer, at)):
        return
    s, v, a = law_after(ax, rows, number, layer, at)
    if why_not_step(ax, s - ax.set_position, s + ax.coupled_offset, v, a, dt):
        return
    change(ax, rows, layer, at)
    show_waiting(ax)


def carry_out(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Carry out the changes whose time has come; the others wait on."""
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        if layer.next_kind:
            _carry_out_one(ax, rows, n, layer, dt)


def show_waiting(ax: AxisFields) -> None:
    """Show in the status what still waits; called by all that lets a change wait or ends that."""
    ax.cam_changes = 0
    ax.cam_status = 0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        if layer.next_kind == CHANGE_SCALING:
            ax.cam_status |= StateBit.CAM_SCALING_PENDING
        elif layer.next_kind == CHANGE_POINTS:
            ax.cam_status |= StateBit.CAM_DATA_QUEUED
        elif layer.next_kind:
            ax.cam_status |= StateBit.CAM_TABLE_QUEUED
        if layer.next_kind:
            ax.cam_changes = 1


def base(ax: AxisFields, rows: NcRows) -> None:
    """Count from where the slave is: cams stay where they are, the slave does not jump."""
    total = 0.0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        layer.seen = seen_master(ax, rows, layer)
        if layer.table:
            total += part_at(rows, layer, _cam_position(layer, layer.seen))[0]
    ax.slave_base = ax.set_position - total


def show_cams(ax: AxisFields, rows: NcRows) -> None:
    """Show the gear ratio, the places in the cams and what waits, after a change between cycles."""
    slopes = 0.0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        if layer.table:
            place = _cam_position(layer, seen_master(ax, rows, layer))
            layer.part, slope, _, _, layer.strokes = part_at(rows, layer, place)
            layer.slope = layer.slave_scaling / layer.master_scaling * slope
            slopes += layer.slope
    ax.set_gear_ratio = slopes
    show_waiting(ax)


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """One cycle: all cams added up."""
    if ax.cam_changes:
        carry_out(ax, rows, dt)
    s = ax.slave_base
    v = 0.0
    a = 0.0
    j = 0.0
    slopes = 0.0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        if layer.table or layer.next_kind:
            seen, velocity, acceleration, jerk = seen_of_row(ax, rows, layer.master)
            layer.seen = seen
            if layer.table:
                part, slope, bend, third, layer.strokes = part_at(
                    rows, layer, _cam_position(layer, seen)
                )
                share = 1.0 / layer.master_scaling
                velocity *= share
                acceleration *= share
                jerk *= share
                factor = layer.slave_scaling
                s += part
                v += factor * slope * velocity
                a += factor * (bend * velocity * velocity + slope * acceleration)
                j += factor * (
                    third * velocity * velocity * velocity
                    + 3.0 * bend * velocity * acceleration
                    + slope * jerk
                )
                layer.part = part
                layer.slope = factor * share * slope
                slopes += layer.slope
    ax.set_position = s
    ax.set_velocity = v
    ax.set_acceleration = a
    ax.set_jerk = j
    ax.set_gear_ratio = slopes
