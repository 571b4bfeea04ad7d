"""Servos: what they ask of the process data, and that both kernels are equal."""

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes.axis import StartType
from achse.drive.alarms import Alarm
from achse.motion import AxisParameters, Nc, commands
from achse.motion.servo import (
    ProcessEntry,
    ServoError,
    ServoLink,
    ServoMode,
    ServoOptions,
    Servos,
)

STATUS, POSITION = ProcessEntry(0x6041, 0, 2), ProcessEntry(0x6064, 2, 4)
CONTROL, TARGET = ProcessEntry(0x6040, 0, 2), ProcessEntry(0x607A, 2, 4)


def link(inputs: Any, outputs: Any, mode: ServoMode = ServoMode.CSP) -> ServoLink:
    return ServoLink(1, inputs, outputs, ServoOptions(mode))


@pytest.mark.parametrize(
    ("inputs", "outputs", "mode", "message"),
    [
        ([STATUS], [CONTROL, TARGET], ServoMode.CSP, "6064h is not in the inputs"),
        ([POSITION], [CONTROL, TARGET], ServoMode.CSP, "6041h is not in the inputs"),
        ([STATUS, POSITION], [TARGET], ServoMode.CSP, "6040h is not in the outputs"),
        ([STATUS, POSITION], [CONTROL], ServoMode.CSP, "csp needs 607Ah"),
        ([STATUS, POSITION], [CONTROL, TARGET], ServoMode.CSV, "csv needs 60FFh"),
        ([STATUS, POSITION], [CONTROL, TARGET], ServoMode.CST, "cst needs 6071h"),
        ([STATUS, ProcessEntry(0x6064, 2, 2)], [CONTROL, TARGET], ServoMode.CSP, "6064h has 4"),
        ([STATUS, ProcessEntry(0x6064, 3, 4)], [CONTROL, TARGET], ServoMode.CSP, "within 6"),
        ([STATUS, ProcessEntry(0x6064, -1, 4)], [CONTROL, TARGET], ServoMode.CSP, "at -1"),
    ],
)
def test_process_data_that_cannot_work_are_refused(
    inputs: Any, outputs: Any, mode: ServoMode, message: str
) -> None:
    nc = Nc(2_000_000, [AxisParameters(1)], compiled=False)
    with pytest.raises(ServoError, match=message):
        Servos(nc, [link(inputs, outputs, mode)], 6, 6)


def test_objects_that_an_axis_does_not_know_stay_as_they_are() -> None:
    nc = Nc(2_000_000, [AxisParameters(1)], compiled=False)
    servos = Servos(nc, [link([STATUS, POSITION], [CONTROL, TARGET])], 6, 8)
    servos.outputs[6:] = b"\x12\x34"
    servos.take()
    nc.cycle()
    servos.send()
    assert servos.outputs[6:] == b"\x12\x34"


def test_without_drives_there_is_nothing_to_do() -> None:
    for compiled in (False, True):
        nc = Nc(2_000_000, [AxisParameters(1)], compiled=compiled)
        servos = Servos(nc, [], 0, 0)
        servos.take()
        servos.send()
        assert servos.digest() == b""


def test_an_axis_begins_where_its_drive_is(make_bench: Any) -> None:
    bench = make_bench(control_dword=0)
    bench.drive.record.motor_position = 131_072.0 * 3
    bench.drive.step(bench.cycle_ns)
    bench._collect()
    bench.run(0.02)
    assert bench.axis.actual_position == pytest.approx(30.0)
    assert bench.axis.set_position == pytest.approx(30.0)
    assert bench.axis.actual_velocity == 0.0


@settings(max_examples=10)
@given(st.integers(0, 2**32))
def test_both_kernels_are_equal(make_bench: Any, seed: int) -> None:
    draw = random.Random(seed)
    options: dict[str, Any] = {
        "mode": draw.choice(list(ServoMode)[1:]),
        "cycle_ns": draw.choice([1_000_000, 2_000_000, 4_000_000]),
        "resolution": draw.choice([10_000, 131_072, 1 << 20]),
        "feed": draw.choice([1.0, 10.0, 360.0]),
        "inverted": draw.random() < 0.5,
        "home_offset": draw.randrange(-1000, 1000),
        "homing_method": draw.choice([0, 33, 34]),
    }
    benches = [make_bench(2, compiled=compiled, **options) for compiled in (False, True)]
    for bench in benches:
        bench.run(0.1)
    feed = options["feed"]
    for _ in range(4):
        what, axis_id = draw.randrange(6), draw.randrange(1, 3)
        target, velocity = draw.uniform(-5.0, 5.0) * feed, draw.uniform(1.0, 30.0) * feed
        seconds = draw.uniform(0.01, 0.4)
        for bench in benches:
            axis, drive = bench.nc.axis(axis_id), bench.drives[axis_id - 1]
            if what <= 1:
                commands.start(axis, StartType.ABSOLUTE, target, velocity)
            elif what == 2:
                commands.home(axis)
            elif what == 3:
                drive.faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
            elif what == 4:
                commands.reset(axis)
            else:
                bench.cut ^= {axis_id - 1}
            bench.run(seconds)
        one, other = benches
        assert one.servos.digest() == other.servos.digest()
        assert one.nc.digest() == other.nc.digest()


@given(st.binary(min_size=48, max_size=48), st.binary(min_size=48, max_size=48))
def test_no_bytes_of_a_drive_break_anything(make_bench: Any, first: bytes, second: bytes) -> None:
    digests = []
    for compiled in (False, True):
        bench = make_bench(2, compiled=compiled)
        bench.ready()
        for inputs in (first, second, first):
            bench.servos.inputs[:] = inputs[: len(bench.servos.inputs)]
            for _ in range(3):
                bench.servos.take()
                bench.nc._cycles(1)
                bench.servos.send()
        digests.append(bench.servos.digest() + bench.nc.digest())
    assert digests[0] == digests[1]
