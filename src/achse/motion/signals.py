"""Signals of the machine: its cam, mark, index pulses and inputs, and the latches of their edges.

An edge happens at a place on the way of the motor within a cycle, so what is latched does not
depend on the cycle. An input switched by hand changes when the cycle sees it.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import ceil, floor, inf

from achse.motion.record import PROBE_EDGES, TOUCH_PROBES, AxisFields
from achse.motion.states import ControlBit, HomingSensorSource, ReferenceMode, SignalSource

__all__ = [
    "LATCHED",
    "WAITS",
    "begin_watch",
    "drive_inputs",
    "homing_cam",
    "latch_probe",
    "limit_switch",
    "outward",
    "probe_counts",
    "probe_status",
    "watch",
]

NOWHERE = inf
"""The place of an edge that did not happen."""

INPUTS = 8
"""Digital inputs of a drive."""

WAITS = 1
LATCHED = 2
"""States of the latch of a homing sequence."""

_PLC_CAM = ControlBit.HOMING_SENSOR.value
_FIRST_LOW = HomingSensorSource.DIGITAL_INPUT_1_LOW.value

_INDEX = SignalSource.ZERO_PULSE.value
_DRIVE_DEFINED = SignalSource.DRIVE_DEFINED.value

_HARDWARE_SYNC = ReferenceMode.HARDWARE_SYNC.value
_LATCH_RISING = ReferenceMode.HARDWARE_LATCH_1_RISING.value
_LATCH_FALLING = ReferenceMode.HARDWARE_LATCH_1_FALLING.value
_SOFTWARE_SYNC = ReferenceMode.SOFTWARE_SYNC.value
_DRIVE_FALLING = ReferenceMode.HARDWARE_LATCH_1_FALLING_DRIVE.value


def _place(ax: AxisFields, count: float) -> float:
    """Where the machine stands when the motor of encoder `ax` is at `count`."""
    return (count - ax.encoder_machine_zero) * ax.encoder_scale


def _inside(place: float, begin: float, end: float, period: float) -> bool:
    """Whether a place lies on a stretch of the machine."""
    if period > 0.0:
        place -= floor((place - begin) / period) * period
    return begin <= place <= end


def _cam_closed(ax: AxisFields, machine: AxisFields) -> bool:
    """Whether the motor stands on the reference cam."""
    place = _place(ax, ax.plant_position)
    begin, end = machine.simulation_cam_begin, machine.simulation_cam_end
    return _inside(place, begin, end, machine.simulation_period)


def _mark_seen(ax: AxisFields, machine: AxisFields) -> bool:
    """Whether the motor stands on the probe mark."""
    place = _place(ax, ax.plant_position)
    begin, end = machine.simulation_mark_begin, machine.simulation_mark_end
    return _inside(place, begin, end, machine.simulation_period)


def limit_switch(ax: AxisFields) -> int:
    """Which hardware limit switch the axis stands on: -1, 1 or 0 for none."""
    place = _place(ax, ax.plant_position)
    if place >= ax.simulation_limit_max:
        return 1
    return -1 if place <= ax.simulation_limit_min else 0


def outward(ax: AxisFields, velocity: float) -> bool:
    """Whether the motor would run farther beyond the limit switch the axis stands on."""
    if ax.drive_motor_polarity:
        velocity = -velocity
    return velocity * ax.encoder_scale * ax.limit_switch > 0.0


def drive_inputs(ax: AxisFields, machine: AxisFields) -> int:
    """Digital inputs 1..8 of the drive: those switched by hand, cam and mark where wired."""
    inputs = machine.simulation_drive_inputs
    wire = machine.simulation_cam_input
    if wire > 0 and _cam_closed(ax, machine):
        inputs |= 1 << (wire - 1)
    wire = machine.simulation_mark_input
    if wire > 0 and _mark_seen(ax, machine):
        inputs |= 1 << (wire - 1)
    return inputs


def homing_cam(ax: AxisFields) -> int:
    """Whether the reference cam is closed, as the configured source says."""
    source = ax.encoder_homing_sensor_source
    if source == 0:
        closed = ax.control_dword & _PLC_CAM != 0
        if ax.simulation_cam_input == 0 and _cam_closed(ax, ax):
            closed = True
        return 1 if closed else 0
    inputs = drive_inputs(ax, ax)
    if source < _FIRST_LOW:
        return inputs >> (source - 1) & 1
    return 1 - (inputs >> (source - _FIRST_LOW) & 1)


def _pulse(before: float, now: float, period: float, first: float) -> float:
    """The first count of those every `period` that the motor passes on its way."""
    if now > before:
        count = (floor((before - first) / period) + 1) * period + first
        return count if count <= now else NOWHERE
    count = (ceil((before - first) / period) - 1) * period + first
    return count if count >= now else NOWHERE


def _boundary(
    begin: float, end: float, period: float, falling: int, before: float, now: float
) -> float:
    """Where a stretch of the machine is entered, or left if `falling`, on the way to `now`."""
    forward = now > before
    edge = begin if forward != (falling == 1) else end
    if period > 0.0:
        return _pulse(before, now, period, edge)
    if forward:
        passed = before <= edge < now if falling else before < edge <= now
    else:
        passed = now < edge <= before if falling else now <= edge < before
    return edge if passed else NOWHERE


def _nearer(place: float, other: float, before: float) -> float:
    return place if abs(place - before) <= abs(other - before) else other


def _input_edge(ax: AxisFields, machine: AxisFields, number: int, falling: int) -> float:
    """Count at which digital input `number` rises or falls on the way of this cycle."""
    if number < 1 or number > INPUTS:
        return NOWHERE
    bit = 1 << (number - 1)
    was = ax.encoder_signal_inputs & bit
    level = drive_inputs(ax, machine) & bit
    if machine.simulation_drive_inputs & bit == 0:
        before = _place(ax, ax.encoder_signal_position)
        now = _place(ax, ax.plant_position)
        period = machine.simulation_period
        begin, end = machine.simulation_cam_begin, machine.simulation_cam_end
        mark_begin, mark_end = machine.simulation_mark_begin, machine.simulation_mark_end
        cam = NOWHERE
        mark = NOWHERE
        if machine.simulation_cam_input == number:
            cam = _boundary(begin, end, period, falling, before, now)
        if machine.simulation_mark_input == number:
            mark = _boundary(mark_begin, mark_end, period, falling, before, now)
            if machine.simulation_cam_input == number:  # one may hold what the other lets go
                if cam != NOWHERE and _inside(cam, mark_begin, mark_end, period):
                    cam = NOWHERE
                if mark != NOWHERE and _inside(mark, begin, end, period):
                    mark = NOWHERE
        place = _nearer(cam, mark, before)
        if place != NOWHERE:
            return place / ax.encoder_scale + ax.encoder_machine_zero
    if falling:
        return ax.plant_position if was and level == 0 else NOWHERE
    return ax.plant_position if was == 0 and level else NOWHERE


def _edge(ax: AxisFields, machine: AxisFields, source: int, falling: int) -> float:
    """Count at which the signal has this edge on the way of this cycle, else NOWHERE."""
    if source == _DRIVE_DEFINED:
        source = machine.simulation_latch_source
    if source == _INDEX:
        return _pulse(
            ax.encoder_signal_position,
            ax.plant_position,
            machine.simulation_turn,
            machine.simulation_index_position + ax.encoder_machine_zero,
        )
    return _input_edge(ax, machine, source, falling)


def _steps(ax: AxisFields, count: float) -> int:
    """Software increments when the motor was at `count`."""
    way = floor(count + 0.5) - floor(ax.plant_position + 0.5)
    return ax.encoder_software_increments + way


def _position(ax: AxisFields, increments: int) -> float:
    offset = ax.encoder_position_offset + ax.encoder_set_position_offset
    return increments * ax.encoder_scale + offset + ax.encoder_position_correction


def latch_probe(ax: AxisFields, edge: int, increments: int, position: float) -> None:
    """Latch a touch probe: `edge` is its unit, 0 based, or TOUCH_PROBES more for a falling one."""
    ax.encoder_probe_valid[edge] = 1
    ax.encoder_probe_position[edge] = position
    ax.encoder_probe_counter[edge] += 1
    ax.encoder_probe_active[edge] = ax.encoder_probe_continuous[edge]
    ax.encoder_latch_valid = 1
    hardware = ((increments + 0x8000_0000) & 0xFFFF_FFFF) - 0x8000_0000
    ax.encoder_latch_hardware_increment_difference = hardware - ax.encoder_latch_hardware_increments
    ax.encoder_latch_software_increment_difference = (
        increments - ax.encoder_latch_software_increments
    )
    ax.encoder_latch_position_difference = position - ax.encoder_latch_position
    ax.encoder_latch_hardware_increments = hardware
    ax.encoder_latch_software_increments = increments
    ax.encoder_latch_position = position


def probe_status(ax: AxisFields) -> int:
    """States of the touch probes, a byte each as in object 60B9h of a drive.

    Bit 0 waits, bits 1 and 2 a rising and a falling edge are latched, bit 7 turns over with each
    edge of a probe that goes on.
    """
    status = 0
    if ax.encoder_latch_active == 0 and ax.encoder_latch_valid == 0:
        return status
    for rising in range(TOUCH_PROBES):
        falling = rising + TOUCH_PROBES
        state = ax.encoder_probe_active[rising] | ax.encoder_probe_active[falling]
        state |= ax.encoder_probe_valid[rising] << 1 | ax.encoder_probe_valid[falling] << 2
        if ax.encoder_probe_continuous[rising] | ax.encoder_probe_continuous[falling]:
            edges = ax.encoder_probe_counter[rising] + ax.encoder_probe_counter[falling]
            state |= (edges & 1) << 7
        status |= state << 8 * rising
    return status


def probe_counts(ax: AxisFields) -> int:
    """Edges of both kinds that the touch probes latched, a byte each."""
    counts = 0
    for rising in range(TOUCH_PROBES):
        edges = ax.encoder_probe_counter[rising] + ax.encoder_probe_counter[rising + TOUCH_PROBES]
        counts |= (edges & 0xFF) << 8 * rising
    return counts


def _sync_pulse(ax: AxisFields) -> float:
    """Count at which the sync pulse of homing comes on the way of this cycle, else NOWHERE."""
    mode = ax.encoder_reference_mode
    if mode == _SOFTWARE_SYNC:
        turn = ax.encoder_sub_mask + 1.0
        return _pulse(ax.encoder_signal_position, ax.plant_position, turn, 0.0)
    if mode == _HARDWARE_SYNC:
        return _edge(ax, ax, 1 if ax.encoder_external_sync_pulse else _INDEX, 0)
    if mode in (_LATCH_RISING, _LATCH_FALLING):
        return _edge(ax, ax, 1, 1 if mode == _LATCH_FALLING else 0)
    return _edge(ax, ax, _DRIVE_DEFINED, 1 if mode == _DRIVE_FALLING else 0)


def begin_watch(ax: AxisFields, machine: AxisFields) -> None:
    """From here on edges count."""
    ax.encoder_signal_position = ax.plant_position
    ax.encoder_signal_inputs = drive_inputs(ax, machine)


def watch(ax: AxisFields, machine: AxisFields) -> None:
    """Latch what happened on the way of encoder `ax` since the cycle before."""
    if ax.encoder_latch_active:
        active = 0
        for edge in range(PROBE_EDGES):
            if ax.encoder_probe_active[edge]:
                falling = 1 if edge >= TOUCH_PROBES else 0
                count = _edge(ax, machine, ax.encoder_probe_source[edge], falling)
                if count != NOWHERE:
                    increments = _steps(ax, count)
                    latch_probe(ax, edge, increments, _position(ax, increments))
                active |= ax.encoder_probe_active[edge]
        ax.encoder_latch_active = active
    if ax.homing_latch == WAITS:
        count = _sync_pulse(ax)
        if count != NOWHERE:
            ax.homing_latch = LATCHED
            ax.homing_latch_position = _position(ax, _steps(ax, count))
            ax.encoder_latch_activation_difference = (
                ax.homing_latch_position - ax.homing_latch_begin
            )
    begin_watch(ax, machine)
