"""Signals of the machine: its cam, mark, index pulses and inputs, and the latches of their edges.

An edge happens at a place on the way of the motor within a cycle, so what is latched does not
depend on the cycle. An input switched by hand changes when the cycle sees it.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import ceil, floor, inf

from achse.motion.machine.record import Machine, Sensor
from achse.motion.port import LATCH_DRIVE_DEFINED, LATCH_INDEX
from achse.motion.states import SignalSource

NOWHERE = inf
"""The place of an edge that did not happen."""

INPUTS = 8
"""Digital inputs of a drive."""


def _inside(place: float, begin: float, end: float, period: float) -> bool:
    """Return True if a place is on a stretch of the machine."""
    if period > 0.0:
        place -= floor((place - begin) / period) * period
    return begin <= place <= end


def cam_closed(machine: Machine) -> bool:
    """Return True if the machine is on the reference cam."""
    return _inside(machine.position, machine.cam_begin, machine.cam_end, machine.period)


def _mark_seen(machine: Machine) -> bool:
    """Return True if the machine is on the probe mark."""
    return _inside(machine.position, machine.mark_begin, machine.mark_end, machine.period)


def outward(machine: Machine, velocity: float) -> bool:
    """Return True if the motor would run farther beyond the limit switch that the machine is on."""
    return velocity * machine.limit_switch > 0.0


def drive_inputs(machine: Machine) -> int:
    """Digital inputs 1..8 of the drive: those switched by hand, cam and mark where wired."""
    inputs = machine.drive_inputs
    wire = machine.cam_input
    if wire > 0 and cam_closed(machine):
        inputs |= 1 << (wire - 1)
    wire = machine.mark_input
    if wire > 0 and _mark_seen(machine):
        inputs |= 1 << (wire - 1)
    return inputs


def _pulse(before: float, now: float, period: float, first: float) -> float:
    """Return the first place of those every `period` that is passed on the way."""
    if now > before:
        place = (floor((before - first) / period) + 1) * period + first
        return place if place <= now else NOWHERE
    place = (ceil((before - first) / period) - 1) * period + first
    return place if place >= now else NOWHERE


def _boundary(
    begin: float, end: float, period: float, falling: int, before: float, now: float
) -> float:
    """Return the place where the machine enters a stretch, or leaves it if `falling`."""
    forward = now > before
    place = begin if forward != (falling == 1) else end
    if period > 0.0:
        return _pulse(before, now, period, place)
    if forward:
        passed = before <= place < now if falling else before < place <= now
    else:
        passed = now < place <= before if falling else now <= place < before
    return place if passed else NOWHERE


def _nearer(place: float, other: float, before: float) -> float:
    return place if abs(place - before) <= abs(other - before) else other


def _input_edge(s: Sensor, number: int, falling: int) -> float:
    """Place at which digital input `number` rises or falls on the way of this cycle."""
    if number < 1 or number > INPUTS:
        return NOWHERE
    m = s.machine
    bit = 1 << (number - 1)
    was = s.inputs_before & bit
    level = drive_inputs(m) & bit
    if m.drive_inputs & bit == 0:
        before = s.before
        now = m.position
        period = m.period
        cam = NOWHERE
        mark = NOWHERE
        if m.cam_input == number:
            cam = _boundary(m.cam_begin, m.cam_end, period, falling, before, now)
        if m.mark_input == number:
            mark = _boundary(m.mark_begin, m.mark_end, period, falling, before, now)
            if m.cam_input == number:  # one may hold what the other lets go
                if cam != NOWHERE and _inside(cam, m.mark_begin, m.mark_end, period):
                    cam = NOWHERE
                if mark != NOWHERE and _inside(mark, m.cam_begin, m.cam_end, period):
                    mark = NOWHERE
        place = _nearer(cam, mark, before)
        if place != NOWHERE:
            return place
    if falling:
        return m.position if was and level == 0 else NOWHERE
    return m.position if was == 0 and level else NOWHERE


def edge(s: Sensor, source: int, falling: int) -> float:
    """Place at which a signal has this edge on the way of this cycle, else NOWHERE."""
    if source == LATCH_DRIVE_DEFINED:
        source = s.machine.latch_source
        if source == SignalSource.ZERO_PULSE:
            source = LATCH_INDEX
        elif source > INPUTS:
            return NOWHERE
    if source == LATCH_INDEX:
        way = s.encoder_resolution
        if s.encoder_inverted:
            way = -way
        first = s.index_position * way
        return _pulse(s.before, s.machine.position, s.turn * s.encoder_resolution, first)
    return _input_edge(s, source, falling)
