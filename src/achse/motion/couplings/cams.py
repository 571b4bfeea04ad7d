"""Slave types 10, 11 and 13: the slave's position is that of a cam over its master, or of several.

    cam position = (master - master reference - master offset) / master scaling
    slave = base + Σ (slave reference + slave offset + slave scaling · (cam + lift of its cycles))

References are 0 where positions are absolute, else where the axis was when the cam began. A cyclic
cam goes on to both sides; outside a linear one the slave keeps the value of its end. A cam begins
in its basic cycle, without lift.

A layer has two laws: `now` is at work, `next` waits with its `change` until the time has come. A
change counts from the exact requested position, not from that of the cycle which finds it
passed: the cycle time does not matter. A cam that is taken away leaves what it added in the base. A
change by which the slave would jump (`achse.motion.couplings.guard`) waits on.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import ceil, floor

from achse.codes import NcError
from achse.codes.axis import StateBit
from achse.motion.couplings.guard import check_step
from achse.motion.couplings.masters import leading_value_of_row
from achse.motion.fields.cams import CamLaw
from achse.motion.record import CAM_LAW, AxisFields, CamFields
from achse.motion.rows import NcRows
from achse.motion.setpoints.limits import TOLERANCE
from achse.motion.states import CamActivation, CamScaling
from achse.motion.tables.memory import BEGIN, CYCLIC, PERIOD, STROKE, cam_values
from achse.native.declare import assign, reset

CHANGE_NOTHING = 0
CHANGE_BEGIN = 1
CHANGE_SCALING = 2
CHANGE_EXCHANGE = 3
CHANGE_REMOVE = 4
CHANGE_POINTS = 5
"""`change.kind` of a layer; with other points a motion function keeps its cycles and references."""

_MOST_CYCLES = 1e15
"""Beyond, cycles of a cam cannot be distinguished."""

_RELATIVE = 1e-12
"""Rounding of a position."""


def master_position_of(ax: AxisFields, rows: NcRows, layer: CamFields) -> float:
    """Master position of a layer, with the phase shift of the slave."""
    return leading_value_of_row(ax, rows, layer.master)[0]


def names_of(rows: NcRows, layer: CamFields) -> float:
    """Return the difference between the master's own positions and those that followers receive:
    the master was renamed while others followed it.
    """
    return rows.axes[layer.master].leading_value.offset


def _cycle_of(rows: NcRows, cam: int, position: float) -> int:
    """Number of the cycle of a cam position; 0 for linear cams."""
    if rows.cams[cam + CYCLIC] == 0.0:
        return 0
    cycles = (position - rows.cams[cam + BEGIN]) / rows.cams[cam + PERIOD]
    return floor(min(max(cycles, -_MOST_CYCLES), _MOST_CYCLES))


def part_at(
    rows: NcRows, layer: CamFields, position: float
) -> tuple[float, float, float, float, float]:
    """Return slave distance, its derivatives by the cam position, and lift so far of a layer."""
    now = layer.now
    cam = now.cam
    cycle = 0
    within = position
    if layer.once:
        within = position - now.base_cycle * rows.cams[cam + PERIOD]
    else:
        begin = rows.cams[cam + BEGIN]
        period = rows.cams[cam + PERIOD]
        cycle = layer.cycle
        within = position - cycle * period
        if within < begin or within >= begin + period:
            cycle = _cycle_of(rows, cam, position)
            within = position - cycle * period
            layer.cycle = cycle
        cycle -= now.base_cycle
    value, slope, bend, third, layer.near = cam_values(rows.cams, cam, layer.near, within)
    strokes = cycle * rows.cams[cam + STROKE]
    layer.cam_position = within
    layer.value = value
    part = now.slave_reference + now.slave_offset + now.slave_scaling * (value + strokes)
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
    position = _cam_position(layer.now, master)
    value = _values(rows, layer.now.cam, layer.once, layer.now.base_cycle, layer.near, position)[0]
    return layer.now.slave_reference + layer.now.slave_offset + layer.now.slave_scaling * value


def law_now(ax: AxisFields, rows: NcRows, without: int) -> tuple[float, float, float]:
    """Return position, velocity and acceleration by all layers but one, where masters are now.

    The layers stay as they are. `without` -1 is none.
    """
    s = ax.coupling.slave_base
    v = 0.0
    a = 0.0
    for n in range(ax.camming.count):
        layer = ax.cams[n]
        if layer.now.table and n != without:
            master_position, velocity, acceleration, _ = leading_value_of_row(
                ax, rows, layer.master
            )
            share = 1.0 / layer.now.master_scaling
            value, slope, bend = _values(
                rows,
                layer.now.cam,
                layer.once,
                layer.now.base_cycle,
                layer.near,
                _cam_position(layer.now, master_position),
            )
            velocity *= share
            acceleration *= share
            factor = layer.now.slave_scaling
            s += layer.now.slave_reference + layer.now.slave_offset + factor * value
            v += factor * slope * velocity
            a += factor * (bend * velocity * velocity + slope * acceleration)
    return s, v, a


def _cam_position(law: CamLaw, master: float) -> float:
    """Position of a cam at a master position, cycles included."""
    return (master - law.master_reference - law.master_offset) / law.master_scaling


def planned(ax: AxisFields, rows: NcRows, layer: CamFields, at: float, after: CamLaw) -> float:
    """Set `after` to the law of the layer after its change at a master position.

    Return what the layer adds to the slave then.
    """
    now = layer.now
    change = layer.change
    kind = change.kind
    runs = now.table != 0
    before = _part(rows, layer, at) if runs else 0.0
    fresh = kind != CHANGE_SCALING and kind != CHANGE_POINTS
    assign(after, now)
    if kind != CHANGE_SCALING:
        after.table = layer.next.table
        after.cam = layer.next.cam
        after.interpolation = layer.next.interpolation
        after.slave_absolute = layer.next.slave_absolute
        if change.master_type != CamScaling.AUTO_OFFSET:
            after.master_absolute = layer.next.master_absolute
    cam = after.cam
    reference = -names_of(rows, layer) if layer.next.master_absolute else at
    if change.master_type == CamScaling.AUTO_OFFSET:  # of a cam at work only
        place = (_cam_position(now, at) - rows.cams[now.cam + BEGIN]) / rows.cams[now.cam + PERIOD]
        position = rows.cams[cam + BEGIN] + place * rows.cams[cam + PERIOD]
        after.master_scaling = layer.next.master_scaling
        after.master_offset = at - after.master_reference - after.master_scaling * position
    elif change.master_type != CamScaling.OFF:
        if fresh:
            after.master_reference = reference
        after.master_offset = layer.next.master_offset
        after.master_scaling = layer.next.master_scaling
    elif not runs:
        after.master_reference = reference
        after.master_offset = 0.0
        after.master_scaling = 1.0
    position = _cam_position(after, at)
    cycle = _cycle_of(rows, cam, position)
    if fresh:
        after.base_cycle = cycle
    within = position - cycle * rows.cams[cam + PERIOD]
    value = cam_values(rows.cams, cam, layer.near, within)[0]
    value += (cycle - after.base_cycle) * rows.cams[cam + STROKE]
    if change.slave_type != CamScaling.OFF:
        after.slave_scaling = layer.next.slave_scaling
        after.slave_offset = layer.next.slave_offset
    elif not runs:
        after.slave_scaling = 1.0
        after.slave_offset = 0.0
    if fresh:
        after.slave_reference = 0.0
        if layer.next.slave_absolute == 0:
            after.slave_reference = before - after.slave_offset - after.slave_scaling * value
    if change.slave_type == CamScaling.AUTO_OFFSET and (not fresh or layer.next.slave_absolute):
        stays = before
        if _alone(ax):
            stays = ax.set.position
        after.slave_offset = stays - after.slave_reference - after.slave_scaling * value
    return after.slave_reference + after.slave_offset + after.slave_scaling * value


def _alone(ax: AxisFields) -> bool:
    """Return True if no cam is in force yet."""
    tables = 0
    for n in range(ax.camming.count):
        tables += ax.cams[n].now.table
    return tables == 0


def change(ax: AxisFields, rows: NcRows, layer: CamFields, at: float) -> None:
    """Carry out what the layer waits for, at a master position; what is for one cycle is taken back
    at the next."""
    kind = layer.change.kind
    once = layer.change.when == CamActivation.NEXT_CYCLE_ONCE
    if kind == CHANGE_REMOVE:
        ax.coupling.slave_base += part_at(rows, layer, _cam_position(layer.now, at))[0]
        layer.now.table = 0
    else:
        after = CAM_LAW.plain()
        planned(ax, rows, layer, at, after)
        if layer.next.slave_absolute and _alone(ax):
            ax.coupling.slave_base = 0.0
        if once:
            assign(layer.next, layer.now)
        assign(layer.now, after)
        layer.cycle = 0  # a linear cam has no other
        layer.part, _, _, _, layer.strokes = part_at(rows, layer, _cam_position(layer.now, at))
    if once:
        if kind == CHANGE_SCALING:
            layer.next.table = 0
        layer.change.when = CamActivation.NEXT_CYCLE
        layer.change.master_type = CamScaling.USER_DEFINED
        layer.change.slave_type = CamScaling.USER_DEFINED
        layer.change.returns = 1
        return
    reset(layer.change)
    reset(layer.next)


def _passed(low: float, high: float, place: float) -> bool:
    """Return True if a move from one position to the other passes a place, the begin included."""
    return low <= place <= high or high <= place <= low


def _next_crossing(before: float, now: float, place: float, period: float) -> float:
    """Return the first of the places, a period apart, behind `before` on the way to `now`."""
    ways = min(max((before - place) / period, -_MOST_CYCLES), _MOST_CYCLES)
    if now >= before:
        return place + (floor(ways) + 1) * period
    return place + (ceil(ways) - 1) * period


def due(rows: NcRows, layer: CamFields, before: float, now: float) -> tuple[int, float]:
    """Return 1 if the time has come for what a layer waits for, and the master position then.

    The master has come from `before` to `now`.
    """
    when = layer.change.when
    place = layer.change.position
    by_axis = place - names_of(rows, layer)
    begins = layer.change.kind == CHANGE_BEGIN
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
    cam = layer.next.cam if begins else layer.now.cam
    offset = layer.now.master_reference + layer.now.master_offset
    scaling = layer.now.master_scaling
    if begins:
        offset = layer.next.master_offset
        scaling = layer.next.master_scaling
        if layer.change.master_type == CamScaling.OFF:
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
    if layer.change.kind == CHANGE_REMOVE:
        return 0.0
    part = planned(ax, rows, layer, at, CAM_LAW.plain())
    if layer.now.table:
        return part - _part(rows, layer, at)
    if layer.next.slave_absolute and _alone(ax):
        return part - ax.set.position
    return part


def law_after(
    ax: AxisFields, rows: NcRows, number: int, layer: CamFields, at: float
) -> tuple[float, float, float]:
    """Return position, velocity and acceleration of all layers after a change of one.

    The layer changes at a master position; the values are those where the masters are now. Its
    number is -1 as long as the slave does not have it.
    """
    s, v, a = law_now(ax, rows, number)
    if layer.change.kind == CHANGE_REMOVE:
        return s + _part(rows, layer, at), v, a
    if _alone(ax):
        s = 0.0 if layer.next.slave_absolute else ax.set.position
    after = CAM_LAW.plain()
    planned(ax, rows, layer, at, after)
    master_position, velocity, acceleration, _ = leading_value_of_row(ax, rows, layer.master)
    value, slope, bend = _values(
        rows,
        after.cam,
        layer.once,
        after.base_cycle,
        layer.near,
        _cam_position(after, master_position),
    )
    share = 1.0 / after.master_scaling
    velocity *= share
    acceleration *= share
    s += after.slave_reference + after.slave_offset + after.slave_scaling * value
    v += after.slave_scaling * slope * velocity
    a += after.slave_scaling * (bend * velocity * velocity + slope * acceleration)
    return s, v, a


def check_jump(ax: AxisFields, jump: float) -> int:
    """Return the code that refuses a jump of the slave, which is one beyond its position window."""
    most = ax.position_range_window + TOLERANCE + _RELATIVE * abs(ax.set.position)
    return 0 if abs(jump) <= most else NcError.TABLE_SLAVE_RANGE


def _carry_out_one(ax: AxisFields, rows: NcRows, number: int, layer: CamFields, dt: float) -> None:
    """Carry out what a layer waits for if it is time and the slave can follow; else it waits on."""
    is_due, at = due(rows, layer, layer.last_master_position, master_position_of(ax, rows, layer))
    if is_due == 0 or check_jump(ax, jump_of(ax, rows, layer, at)):
        return
    s, v, a = law_after(ax, rows, number, layer, at)
    if check_step(ax, s - ax.set.position, s + ax.coupling.offset, v, a, dt):
        return
    change(ax, rows, layer, at)
    show_waiting(ax)


def carry_out(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Carry out the changes whose time has come; the others wait on."""
    for n in range(ax.camming.count):
        layer = ax.cams[n]
        if layer.change.kind:
            _carry_out_one(ax, rows, n, layer, dt)


def show_waiting(ax: AxisFields) -> None:
    """Show in the status what still waits; called by all that lets a change wait or ends that."""
    ax.camming.changes = 0
    ax.camming.status = 0
    for n in range(ax.camming.count):
        layer = ax.cams[n]
        if layer.change.kind == CHANGE_SCALING:
            ax.camming.status |= StateBit.CAM_SCALING_PENDING
        elif layer.change.kind == CHANGE_POINTS:
            ax.camming.status |= StateBit.CAM_DATA_QUEUED
        elif layer.change.kind:
            ax.camming.status |= StateBit.CAM_TABLE_QUEUED
        if layer.change.kind:
            ax.camming.changes = 1


def base(ax: AxisFields, rows: NcRows) -> None:
    """Count from where the slave is: cams stay where they are, the slave does not jump."""
    total = 0.0
    for n in range(ax.camming.count):
        layer = ax.cams[n]
        layer.last_master_position = master_position_of(ax, rows, layer)
        if layer.now.table:
            total += part_at(rows, layer, _cam_position(layer.now, layer.last_master_position))[0]
    ax.coupling.slave_base = ax.set.position - total


def show_cams(ax: AxisFields, rows: NcRows) -> None:
    """Show the gear ratio, the places in the cams and what waits, after a change between cycles."""
    slopes = 0.0
    for n in range(ax.camming.count):
        layer = ax.cams[n]
        if layer.now.table:
            place = _cam_position(layer.now, master_position_of(ax, rows, layer))
            layer.part, slope, _, _, layer.strokes = part_at(rows, layer, place)
            layer.slope = layer.now.slave_scaling / layer.now.master_scaling * slope
            slopes += layer.slope
    ax.set_gear_ratio = slopes
    show_waiting(ax)


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle: all cams added up."""
    if ax.camming.changes:
        carry_out(ax, rows, dt)
    s = ax.coupling.slave_base
    v = 0.0
    a = 0.0
    j = 0.0
    slopes = 0.0
    for n in range(ax.camming.count):
        layer = ax.cams[n]
        if layer.now.table or layer.change.kind:
            master_position, velocity, acceleration, jerk = leading_value_of_row(
                ax, rows, layer.master
            )
            layer.last_master_position = master_position
            if layer.now.table:
                part, slope, bend, third, layer.strokes = part_at(
                    rows, layer, _cam_position(layer.now, master_position)
                )
                share = 1.0 / layer.now.master_scaling
                velocity *= share
                acceleration *= share
                jerk *= share
                factor = layer.now.slave_scaling
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
    ax.set.position = s
    ax.set.velocity = v
    ax.set.acceleration = a
    ax.set.jerk = j
    ax.set_gear_ratio = slopes
