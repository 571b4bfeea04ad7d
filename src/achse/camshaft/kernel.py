"""One cycle of a camshaft controller: encoder, monitoring, counters, cams, masks.

The same functions run as plain Python and as machine code. Angles are in 0.1 degree; positions of
the encoder in increments, so that those of an integer encoder stay whole numbers.
"""

import math
from collections.abc import Sequence

from achse.camshaft.image import CamInput
from achse.camshaft.parameters import HIGHEST_RATE, CamType
from achse.camshaft.record import CAM, CONTROLLER, CamControllerFields, CamStateFields
from achse.native.compiled import Kernel

_TURN = 3600.0
_DWORD = 0xFFFF_FFFF
_TENTH_MS = 100_000
_MS = 1_000_000
_SLIP = 1e-3
"""Largest difference that counts as rounding, with ample margin, 0.1 degree."""


def run_controller(
    controllers: Sequence[CamControllerFields], cams: Sequence[CamStateFields]
) -> int:
    """Do one cycle of the first of `controllers` with all `cams`; the bits of the tracks."""
    c = controllers[0]
    _take_inputs(c)
    _follow_encoder(c)
    _watch_shaft(c)
    _count_strokes(c)
    bits = 0
    used = 0
    for n in range(len(cams)):
        cam = cams[n]
        if cam.type == CamType.NONE:
            continue
        used += 1
        cam.brake_enabled = (c.inputs[CamInput.BRAKE_ENABLE] >> cam.track) & 1
        if c.active:
            cam.on = _turn_cam(c, cam)
            bits = bits | (cam.on << cam.track)
        else:
            cam.known = 0
            cam.latched = 0
            cam.remaining_ns = 0
            cam.on = 0
    c.configured_cams = used
    allowed = c.inputs[CamInput.AND_MASK]
    if allowed == 0 and not c.and_mask_linked:
        allowed = _DWORD
    c.outputs = (bits & c.and_mask & allowed) | c.or_mask | c.inputs[CamInput.OR_MASK]
    return c.outputs


def _take_inputs(c: CamControllerFields) -> None:
    """Apply resets at their rising edge and values when they change: else the written ones stay."""
    if _rises(c, CamInput.RESET_IO_ERROR):
        c.io_errors = 0
    if _rises(c, CamInput.RESET_ENCODER_ERROR):
        c.encoder_error = 0
    if _rises(c, CamInput.RESET_SHAFT_ERROR):
        c.shaft_error = 0
        c.still_ns = 0
    if _rises(c, CamInput.RESET_RATE_ERROR):
        c.rate_error = 0
        c.deviating_ns = 0
    if c.inputs[CamInput.SET_RATE] != c.seen[CamInput.SET_RATE]:
        c.set_rate = min(c.inputs[CamInput.SET_RATE], HIGHEST_RATE)
    if c.inputs[CamInput.RATE_TOLERANCE] != c.seen[CamInput.RATE_TOLERANCE]:
        c.rate_tolerance = min(c.inputs[CamInput.RATE_TOLERANCE], HIGHEST_RATE)
    for n in range(len(c.counters)):
        if c.inputs[CamInput.COUNTER_1 + n] != c.seen[CamInput.COUNTER_1 + n]:
            c.counters[n] = c.inputs[CamInput.COUNTER_1 + n]
    for n in range(len(c.inputs)):
        c.seen[n] = c.inputs[n]


def _rises(c: CamControllerFields, word: int) -> bool:
    return c.inputs[word] != 0 and c.seen[word] == 0


def _follow_encoder(c: CamControllerFields) -> None:
    """Step, angle and speed of the shaft."""
    sign = 1
    if c.reversed or c.inputs[CamInput.REVERSED]:
        sign = -1
    reference = c.zero_point + c.position_offset
    c.fresh = 0
    if sign != c.sign:
        c.fresh = 1
        c.sign = sign
    if reference != c.reference:
        c.fresh = 1
        c.reference = reference
    position = c.position
    wrong = not c.valid
    step = 0.0
    if not wrong and c.span > 0.0:
        wrong = position < 0.0 or position >= c.span
    if not wrong:
        if c.known:
            step = position - c.last
            if c.span > 0.0:
                if step > 0.5 * c.span:
                    step -= c.span
                elif step < -0.5 * c.span:
                    step += c.span
        else:
            c.known = 1
            c.fresh = 1
        c.last = position
        if abs(step) > c.largest_step:
            wrong = True
            c.fresh = 1
            step = 0.0
    if wrong:
        c.recorded = 0
        c.slot = 0
        if c.encoder_monitoring:
            c.encoder_error = 1
    position = c.last
    c.raw = math.floor(position) & _DWORD
    angle = _within_turn((position % c.increments) * _TURN / c.increments + reference)
    if sign < 0:
        angle = _within_turn(-angle)
    c.angle = angle
    c.travel += step
    c.step = sign * step * _TURN / c.increments
    if c.step > 0.0:
        c.direction = 1
    elif c.step < 0.0:
        c.direction = -1
    _measure_speed(c)


def _within_turn(angle: float) -> float:
    """0 <= angle < a turn; the rest of a tiny negative number is a whole turn."""
    rest = angle % _TURN
    if rest >= _TURN:
        rest = 0.0
    return rest


def _measure_speed(c: CamControllerFields) -> None:
    """Compute the mean speed over the window, as far as there is one."""
    c.speed_before = c.speed
    c.speed = 0.0
    if c.recorded > 0:
        oldest = c.history[0]
        if c.recorded == c.window:
            oldest = c.history[c.slot]
        way = (c.travel - oldest) * _TURN / c.increments
        c.speed = c.sign * way * 1e9 / (c.recorded * c.cycle_ns)
    c.history[c.slot] = c.travel
    c.slot += 1
    if c.slot == c.window:
        c.slot = 0
    if c.recorded < c.window:
        c.recorded += 1
    # 360° in a minute is 60 tenths of a degree per second
    c.actual_rate = min(round(abs(c.speed) / 60.0), _DWORD)


def _watch_shaft(c: CamControllerFields) -> None:
    """Check for shaft break and stroke rate; errors stay until they are reset."""
    engaged = c.coupled or c.inputs[CamInput.ENGAGED] != 0
    # one increment to and fro is a shaft that is still
    if abs(c.travel - c.stopped_at) > 1.0:
        c.stopped_at = c.travel
        c.still_ns = 0
    elif c.shaft_monitoring and engaged and c.set_rate > 0:
        if c.still_ns >= c.shaft_time * _MS:
            c.shaft_error = 1
        else:
            c.still_ns += c.cycle_ns
    else:
        c.still_ns = 0
    if c.rate_monitoring and abs(abs(c.speed) / 60.0 - c.set_rate) > c.rate_tolerance:
        if c.deviating_ns >= c.rate_time * _MS:
            c.rate_error = 1
        else:
            c.deviating_ns += c.cycle_ns
    else:
        c.deviating_ns = 0


def _begin_way(way: float, moved: float) -> float:
    """Return the way since 0° of a shaft that moves for the first time: backwards it is from
    above."""
    if moved < 0.0 and way > 0.0:
        return way - _TURN
    return way


def _near(way: float, place: float) -> float:
    """Return the way that ends at `place`, next to `way`: sums of steps do not drift."""
    return place + _TURN * round((way - place) / _TURN)


def _count_strokes(c: CamControllerFields) -> None:
    """Count a stroke at 0°, if it is a whole turn away from the begin of the last one."""
    c.strokes = 0
    if c.fresh:
        c.way = c.angle
        c.turned = 0
        return
    if not c.turned and c.step != 0.0:
        c.way = _begin_way(c.way, c.step)
        c.turned = 1
    way = _near(c.way + c.step, c.angle)
    turns = int(way / _TURN)
    c.way = way - turns * _TURN
    c.strokes = abs(turns)
    for n in range(len(c.counters)):
        if (c.inputs[CamInput.COUNTER_ENABLE] >> n) & 1:
            c.counters[n] = (c.counters[n] + c.strokes) & _DWORD


def _turn_cam(c: CamControllerFields, cam: CamStateFields) -> int:
    """One cycle of a cam: whether it is on."""
    _see_place(c, cam)
    _see_stroke(cam)
    allowed = cam.backward
    if cam.heading > 0:
        allowed = cam.forward
    if cam.type == CamType.MULTI_CYCLE:
        acts = allowed and cam.stroke >= cam.count
    else:
        acts = allowed and cam.stroke == cam.count - 1
    if cam.type == CamType.WAY or cam.type == CamType.MULTI_CYCLE:
        on = 0
        if acts and _inside(cam):
            on = 1
        return on
    starts = allowed and _passes(cam)
    if cam.type == CamType.TIME:
        if starts:
            cam.remaining_ns = cam.duration * _TENTH_MS
    elif cam.force or (cam.brake_enabled and (starts or cam.latched)):
        cam.latched = 1
        cam.remaining_ns = cam.end_value * _TENTH_MS
        return 1
    else:
        cam.latched = 0
    if cam.remaining_ns <= 0:
        return 0
    cam.remaining_ns -= c.cycle_ns
    return 1


def _see_place(c: CamControllerFields, cam: CamStateFields) -> None:
    """Compute the angle that counts for the cam: behind the hysteresis, ahead by the dead time."""
    if not cam.known or c.fresh:
        cam.back = 0.0
        cam.heading = c.direction
    width = 0.0
    if cam.hysteresis_on:
        width = cam.hysteresis * _TURN / c.increments
    behind = cam.back - c.step * cam.heading
    cam.moved = 0.0
    if behind <= 0.0:
        cam.moved = -behind * cam.heading
        behind = 0.0
    elif behind > width:
        cam.moved = -behind * cam.heading
        cam.heading = -cam.heading
        behind = 0.0
    cam.back = behind
    before = cam.place
    place = c.angle + behind * cam.heading
    if cam.dynamic:
        dead_time = cam.dead_time * 1e-4
        place += c.speed * dead_time
        cam.moved += (c.speed - c.speed_before) * dead_time
    cam.place = _within_turn(place)
    slip = cam.place - before - cam.moved
    if abs(slip - _TURN * round(slip / _TURN)) > _SLIP:
        before = cam.place - cam.moved  # another dead time is not a movement
    cam.before = before
    if not cam.known or c.fresh:
        cam.known = 1
        cam.moved = 0.0
        cam.way = cam.place
        cam.turned = 0


def _see_stroke(cam: CamStateFields) -> None:
    """Update the stroke number of the cam."""
    if not cam.turned and cam.moved != 0.0:
        cam.way = _begin_way(cam.way, cam.moved)
        cam.turned = 1
    way = _near(cam.way + cam.moved, cam.place)
    turns = int(way / _TURN)
    cam.way = way - turns * _TURN
    cam.begun = abs(turns)
    period = cam.count
    if cam.type == CamType.MULTI_CYCLE:
        period = cam.count + cam.cycles_on
    if cam.load:
        cam.load = 0
        cam.stroke = 0
        cam.begun = 0
    else:
        cam.stroke = (cam.stroke + cam.begun) % period


def _inside(cam: CamStateFields) -> bool:
    """Return True from the start on, before the end; never for start = end."""
    start = cam.start * 10.0
    length = (cam.end * 10.0 - start) % _TURN
    return (cam.place - start) % _TURN < length


def _passes(cam: CamStateFields) -> bool:
    """Return True if the cam's start was passed in this cycle, in the running direction of the
    shaft, and in a stroke in which the cam acts.

    The range is from the place of the cycle before to the present place, so that a start that is
    met exactly counts once.
    """
    if cam.moved * cam.heading <= 0.0:
        return False
    way = (cam.place - cam.before) * cam.heading
    way += _TURN * round((cam.moved * cam.heading - way) / _TURN)
    ahead = ((cam.start * 10.0 - cam.before) * cam.heading) % _TURN
    if ahead <= 0.0:
        ahead = _TURN
    zero = (-cam.before * cam.heading) % _TURN
    if zero <= 0.0:
        zero = _TURN
    stroke = cam.stroke
    if ahead < zero and cam.begun > 0:  # reached before the 0° of this cycle
        stroke = (stroke + cam.count - cam.begun % cam.count) % cam.count
    return ahead <= way and stroke == cam.count - 1


KERNEL = Kernel("camshaft", run_controller, {CamControllerFields: CONTROLLER, CamStateFields: CAM})
"""Called with address and number of controllers (1), and address and number of cams."""
