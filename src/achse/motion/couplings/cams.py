"""Slave types 10, 11 and 13: the slave's position is that of a cam over its master, or of several.

    cam position = (master - master reference - master offset) / master scaling
    slave = base + Σ (slave reference + slave offset + slave scaling · (cam + lift of its cycles))

References are 0 where positions are absolute, else where the axis was when the cam began. A cyclic
cam goes on to both sides; outside a linear one the slave keeps the value of its end. A cam begins
in its basic cycle, without lift.

What is to change (`next_kind`) waits in the layer until its time has come. It counts from the exact
position that was asked for, not from that of the cycle which finds it passed: the cycle time does
not matter. A cam that is taken away leaves what it added in the base.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import ceil, floor

from achse.motion.couplings.masters import seen_of_row
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
    "names_of",
    "part_at",
    "part_now",
    "planned",
    "seen_master",
    "step",
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


def part_now(rows: NcRows, layer: CamFields) -> float:
    """What a layer adds where it saw its master last, by its table as that is now."""
    near, within, value = layer.near, layer.cam_position, layer.value
    part = part_at(rows, layer, _cam_position(layer, layer.seen))[0]
    layer.near, layer.cam_position, layer.value = near, within, value
    return part


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
    before = part_at(rows, layer, _cam_position(layer, at))[0] if runs else 0.0
    cam = layer.cam if kind == CHANGE_SCALING else layer.next_cam
    fresh = kind != CHANGE_SCALING and kind != CHANGE_POINTS
    reference = layer.master_reference
    offset = layer.master_offset
    scaling = layer.master_scaling
    if layer.next_master_type == CamScaling.AUTO_OFFSET and runs:
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
        if not runs and _alone(ax):
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


def _change(ax: AxisFields, rows: NcRows, layer: CamFields, at: float) -> None:
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
        layer.part = 0.0
    else:
        if layer.next_kind == CHANGE_BEGIN and layer.next_slave_absolute and _alone(ax):
            after = planned(ax, rows, layer, at)
            ax.slave_base = 0.0
        else:
            after = planned(ax, rows, layer, at)
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
    layer.next_returns = 0
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


def _try(ax: AxisFields, rows: NcRows, layer: CamFields, before: float, now: float) -> None:
    """Carry out what waits, if it is time: the master has come from `before` to `now`."""
    when = layer.next_when
    place = layer.next_position
    by_axis = place - names_of(rows, layer)
    begins = layer.next_kind == CHANGE_BEGIN
    if when == CamActivation.INSTANTANEOUS:
        _change(ax, rows, layer, before)
    elif when == CamActivation.AS_SOON_AS_POSSIBLE:
        after = planned(ax, rows, layer, before)[7]
        position = ax.slave_base if begins and layer.next_slave_absolute == 0 else 0.0
        if begins and layer.next_slave_absolute and not _alone(ax):
            position = ax.set_position
        jump = position + after - ax.set_position
        if not begins:
            jump = after - part_at(rows, layer, _cam_position(layer, before))[0]
        if layer.next_kind == CHANGE_REMOVE or abs(jump) <= ax.position_range_window:
            _change(ax, rows, layer, before)
    elif when == CamActivation.MASTER_AXIS_POSITION:
        if _passed(before, now, by_axis):
            _change(ax, rows, layer, by_axis)
    elif when == CamActivation.MASTER_AXIS_POSITION_POSITIVE:
        if before <= by_axis <= now and before < now:
            _change(ax, rows, layer, by_axis)
    elif when == CamActivation.MASTER_AXIS_POSITION_NEGATIVE:
        if now <= by_axis <= before and now < before:
            _change(ax, rows, layer, by_axis)
    elif when != CamActivation.OFF:  # at a place of the cam: one of its own, or its begin
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
            if _passed(start, end, crossing):
                _change(ax, rows, layer, offset + scaling * crossing)
        elif next_cycle and (start < begin or start > begin + period):
            _change(ax, rows, layer, before)
        elif next_cycle and end > begin + period:
            _change(ax, rows, layer, offset + scaling * (begin + period))
        elif next_cycle and end < begin:
            _change(ax, rows, layer, offset + scaling * begin)
        elif not next_cycle and _passed(start, end, place):
            _change(ax, rows, layer, offset + scaling * place)


def _carry_out(ax: AxisFields, rows: NcRows) -> None:
    """Changes whose time has come; what still waits shows in the status."""
    ax.cam_changes = 0
    ax.cam_status = 0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        if layer.next_kind:
            _try(ax, rows, layer, layer.seen, seen_master(ax, rows, layer))
        if layer.next_kind == CHANGE_SCALING:
            ax.cam_status |= StateBit.CAM_SCALING_PENDING
        elif layer.next_kind == CHANGE_POINTS:
            ax.cam_status |= StateBit.CAM_DATA_QUEUED
        elif layer.next_kind:
            ax.cam_status |= StateBit.CAM_TABLE_QUEUED
        if layer.next_kind:
            ax.cam_changes = 1


def base(ax: AxisFields, rows: NcRows) -> None:
    """Count from where the slave is: cams stay where they are, the slave does not jump.

    What is to begin at once begins here.
    """
    total = 0.0
    for n in range(ax.cam_count):
        layer = ax.cams[n]
        layer.seen = seen_master(ax, rows, layer)
        if layer.table:
            total += part_at(rows, layer, _cam_position(layer, layer.seen))[0]
    ax.slave_base = ax.set_position - total
    _carry_out(ax, rows)


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """One cycle: all cams added up."""
    if ax.cam_changes:
        _carry_out(ax, rows)
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
