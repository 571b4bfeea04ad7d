"""Cams with everything drawn, against closed forms."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.camshaft import CamController, CamEncoder, CamInput, CamType
from tests.camshaft.closed_form import closed_form

MS = 1_000_000


@settings(max_examples=75, deadline=None)
@given(st.data())
def test_any_way_cam_at_any_steady_speed(data: st.DataObject) -> None:
    """All parameters drawn, settled, against the closed form."""
    draw = data.draw
    increments = draw(st.sampled_from((360, 1000, 3600, 4096, 65536)), "increments")
    cycle_ns = draw(st.sampled_from((250_000, MS, 2 * MS, 10 * MS)), "cycle")
    controller = CamController(
        cycle_ns=cycle_ns,
        encoder=CamEncoder(increments, window_ns=draw(st.integers(1, 70)) * cycle_ns),
    )
    record = controller.record
    record.zero_point = draw(st.integers(-3599, 3599), "zero")
    record.position_offset = draw(st.integers(-3599, 3599), "offset")
    record.reversed = draw(st.integers(0, 1), "reversed")
    record.and_mask = draw(st.integers(0, 2**32 - 1) | st.just(2**32 - 1), "and")
    record.or_mask = draw(st.integers(0, 2**32 - 1) | st.just(0), "or")
    rate = draw(st.floats(-2000, 2000).filter(lambda rate: abs(rate) > 0.01), "rate")
    begin = draw(st.floats(-1e5, 1e5), "begin")
    cams = []
    for number in draw(st.lists(st.integers(1, 128), min_size=1, max_size=5, unique=True)):
        cam = {
            name: draw(st.integers(least, most), name)
            for name, least, most in (
                *(("start", 0, 359), ("end", 0, 359), ("track", 0, 31), ("dead_time", 0, 2000)),
                *(("hysteresis", 0, 8192), ("hysteresis_on", 0, 1), ("dynamic", 0, 1)),
                *(("forward", 0, 1), ("backward", 0, 1)),
            )
        } | {"type": 1}
        controller.set_cam(number, cam)
        cams.append(cam)
    speed = rate * 60.0 * (-1 if record.reversed else 1)
    settle = record.window + 2
    # a hysteresis is passed once in the direction of the run
    settle += math.ceil(8192 * 3600 / increments / (abs(speed) * cycle_ns / 1e9)) + 1
    if settle > 3000:
        settle = record.window + 2
        for number, cam in enumerate(cams):
            cam["hysteresis_on"] = 0
            assert number >= 0
        for record_of in controller.cams:
            record_of.hysteresis_on = 0
    forward = speed > 0
    for k in range(settle + 300):
        position = begin + rate * increments / 60 * k * cycle_ns / 1e9
        controller.take_position(position)
        outputs = controller.cycle()
        if k < settle:
            continue
        angle = position * 3600 / increments + record.zero_point + record.position_offset
        angle = -angle if record.reversed else angle
        expected, unsure = 0, 0
        for cam in cams:
            place = angle + (speed * cam["dead_time"] * 1e-4 if cam["dynamic"] else 0)
            on = closed_form(cam["start"] * 10, cam["end"] * 10, place)
            if on is None:
                unsure |= 1 << cam["track"]
            elif on and cam["forward" if forward else "backward"]:
                expected |= 1 << cam["track"]
        expected = expected & record.and_mask | record.or_mask
        assert (outputs ^ expected) & ~unsure == 0


@settings(max_examples=75, deadline=None)
@given(st.data())
def test_any_time_or_brake_cam_at_any_steady_speed(data: st.DataObject) -> None:
    """All parameters drawn, settled, against the closed form: on from the cycle in which the start
    is reached in every n-th stroke, a time cam for its duration, a brake cam until the enable
    goes and for its end value.
    """
    draw = data.draw
    increments = draw(st.sampled_from((360, 1000, 3600, 4096, 65536)), "increments")
    cycle_ns = draw(st.sampled_from((250_000, MS, 2 * MS, 10 * MS)), "cycle")
    controller = CamController(cycle_ns=cycle_ns, encoder=CamEncoder(increments))
    record = controller.record
    record.zero_point = draw(st.integers(-3599, 3599), "zero")
    record.position_offset = draw(st.integers(-3599, 3599), "offset")
    record.reversed = draw(st.integers(0, 1), "reversed")
    rate = draw(st.floats(-2000, 2000).filter(lambda rate: abs(rate) > 1), "rate")
    begin = draw(st.floats(-1e5, 1e5), "begin")
    number, start = draw(st.integers(1, 128), "number"), draw(st.integers(0, 359), "start")
    kind, count = draw(st.sampled_from((2, 3)), "type"), draw(st.integers(1, 4), "count")
    track = draw(st.integers(0, 31), "track")
    duration = draw(st.integers(1, 3000), "duration")
    cam = {"type": kind, "start": start, "count": count, "track": track}
    cam |= {"forward": draw(st.integers(0, 1), "f"), "backward": draw(st.integers(0, 1), "b")}
    cam |= {"dynamic": draw(st.integers(0, 1), "dynamic")}
    cam |= {"dead_time": draw(st.integers(0, 2000), "dead")}
    cam |= {"duration": duration, "end_value": duration}
    controller.set_cam(number, cam)
    sign = -1 if record.reversed else 1
    speed = rate * 60.0 * sign
    withdrawn = draw(st.integers(0, 300), "withdrawn")
    settle = record.window + 2
    value = -(-duration * 100_000 // cycle_ns)  # a part of a cycle is a whole one
    latched, left, base = False, 0, None
    heading = 1 if speed > 0 else -1
    for k in range(settle + 300):
        if k == settle:
            controller.set_cam(number, {"load": 1})
        enabled = settle <= k < settle + withdrawn
        controller.set_input(CamInput.BRAKE_ENABLE, enabled << track)
        position = begin + rate * increments / 60 * k * cycle_ns / 1e9
        controller.take_position(position)
        outputs = controller.cycle()
        angle = position * 3600 / increments + record.zero_point + record.position_offset
        place = angle * sign + (speed * cam["dead_time"] * 1e-4 if cam["dynamic"] else 0)
        run = place * heading  # the way of a shaft that runs up
        if k < settle:
            continue
        before, base = run - abs(speed) * cycle_ns / 1e9, base if base is not None else run
        to_start = start * 10 * heading
        turns, turns_before = ((each - to_start) / 3600 for each in (run, before))
        if min(abs(each - round(each)) for each in (turns, turns_before, run / 3600)) < 1e-9:
            return  # at the very edge: rounding says which cycle it is
        passed = math.floor(turns) > math.floor(turns_before)
        met = math.floor(turns) * 3600 + to_start  # where it was reached last
        stroke = max(math.floor(met / 3600) - math.floor(base / 3600), 0)
        allowed = cam["forward" if heading > 0 else "backward"]
        starts = passed and bool(allowed) and stroke % count == count - 1
        if kind == CamType.TIME:
            if k == settle:
                rest = -(-controller.cams[number - 1].remaining_ns // cycle_ns)
                left = rest + 1 if outputs else 0
            elif starts:
                left = value
            on = left > 0
            left -= 1
        else:
            latched = enabled and (latched or starts)
            if latched:
                left = value
            on = latched or left > 0
            left -= not latched
        assert outputs == on << track, (k, run / 3600)
