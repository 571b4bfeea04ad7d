"""Drives that leave out options of CiA 402: they move, and what is missing is named."""

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes.axis import StartType
from achse.drive.alarms import Alarm
from achse.motion import commands
from achse.motion.servo import ServoMode
from achse.motion.servo.optional import (
    ALL_PARTS,
    FOLLOWING_BIT,
    MODE_DISPLAY,
    OPTIONAL_PARTS,
    REMOTE_BIT,
    VOLTAGE_BIT,
    DriveParts,
)
from achse.station.configuration.bus import DriveConfig

BITS = [each for each in OPTIONAL_PARTS if each.bit is not None]
DISPLAY = MODE_DISPLAY.index
NOT_READY = 0x4650
INPUTS = (0x6041, 0x6061, 0x6064, 0x6077, 0x60FD)


def parts_without(keys: set[str]) -> DriveParts:
    return replace(ALL_PARTS, **dict.fromkeys(keys, False))


def bench_without(make_bench: Any, keys: set[str], in_table: bool = True, **options: Any) -> Any:
    """A drive without these parts; `in_table`: its table says so."""
    cleared = sum(each.mask for each in BITS if each.key in keys)
    inputs = [each for each in INPUTS if each != DISPLAY or MODE_DISPLAY.key not in keys]
    parts = parts_without(keys) if in_table else ALL_PARTS
    return make_bench(inputs=inputs, cleared=cleared, parts=parts, **options)


def test_table_and_keys_of_a_drive_agree() -> None:
    keys = {each.key: each.default for each in OPTIONAL_PARTS}
    config = DriveConfig(axis=1)
    assert {key: getattr(config, key) for key in keys} == keys
    assert DriveParts.of(config) == ALL_PARTS
    for key, default in keys.items():
        changed = DriveParts.of(DriveConfig.model_validate({"axis": 1, key: not default}))
        assert changed == replace(ALL_PARTS, **{key: not default})


missing_keys = st.sets(st.sampled_from([each.key for each in OPTIONAL_PARTS]))


@settings(max_examples=12)
@given(
    keys=missing_keys,
    mode=st.sampled_from([ServoMode.CSP, ServoMode.CSV, ServoMode.CST]),
    inverted=st.booleans(),
    cycle_ns=st.sampled_from([1_000_000, 2_000_000, 4_000_000]),
    target=st.floats(-8.0, 8.0).filter(lambda value: abs(value) > 0.5),
    velocity=st.floats(50.0, 300.0),
    acceleration=st.floats(1000.0, 4000.0),
    fault_after=st.none() | st.floats(0.0, 0.02),
)
def test_drive_without_options_moves_and_recovers(
    make_bench: Any,
    keys: set[str],
    mode: ServoMode,
    inverted: bool,
    cycle_ns: int,
    target: float,
    velocity: float,
    acceleration: float,
    fault_after: float | None,
) -> None:
    bench = bench_without(
        make_bench,
        keys,
        mode=mode,
        inverted=inverted,
        cycle_ns=cycle_ns,
        default_acceleration=acceleration,
    )
    bench.ready()
    axis = bench.axis
    assert commands.start(axis, StartType.ABSOLUTE, target, velocity) == 0
    if fault_after is not None:
        bench.run(fault_after)
        bench.drive.faults.alarm(Alarm.CONTINUOUS_OVERLOAD)
        bench.until(lambda axis: axis.error_code, 1.0)
        assert axis.error_code == NOT_READY
        assert 'in "fault' in bench.servos.servos[0].missing_condition
        bench.drive.faults.clear()
        commands.reset(axis)
        bench.until(lambda axis: axis.error_code == 0 and axis.loop_closed, 3.0)
        assert commands.start(axis, StartType.ABSOLUTE, target, velocity) == 0
    before = axis.actual_position
    for _ in range(round(3e9 / cycle_ns)):
        bench.nc.cycle(1)
        assert abs(axis.actual_position - before) <= 2.0 * velocity * cycle_ns * 1e-9 + 0.05
        before = axis.actual_position
        if axis.set_motion_phase == 0:
            break
    bench.run(0.5)
    assert axis.error_code == 0
    assert axis.actual_position == pytest.approx(target, abs=0.1)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        (FOLLOWING_BIT.key, "bit 12 of 6041h is 0 (the drive follows its set values)"),
        (MODE_DISPLAY.key, "expected 8 in 6061h, got 0"),
    ],
)
def test_missing_condition_names_the_key_of_the_drive(
    make_bench: Any, key: str, words: str
) -> None:
    bench = make_bench(cleared=FOLLOWING_BIT.mask if key == FOLLOWING_BIT.key else 0)
    if key == MODE_DISPLAY.key:  # the object is there and shows nothing
        collect = bench._collect

        def without_display() -> None:
            collect()
            bench.servos.inputs[2] = 0

        bench._collect = without_display
    bench.run(0.5)
    assert not bench.axis.loop_closed
    message = bench.servos.servos[0].missing_condition
    assert words in message
    assert f"{key} = false" in message


@pytest.mark.parametrize("voltage_bit", [False, True])
def test_missing_condition_names_power_and_local_control(
    make_bench: Any, voltage_bit: bool
) -> None:
    parts = replace(ALL_PARTS, voltage_bit=voltage_bit)
    bench = make_bench(parts=parts, cleared=REMOTE_BIT.mask | VOLTAGE_BIT.mask)
    bench.drive.faults.main_power(False)
    bench.run(0.5)
    message = bench.servos.servos[0].missing_condition
    assert "bit 9 of 6041h is 0 (the drive obeys 6040h)" in message
    assert ("bit 4 of 6041h is 0 (main power is on)" in message) is voltage_bit


def test_no_condition_is_missing_when_the_axis_is_ready(make_bench: Any) -> None:
    bench = make_bench()
    bench.ready()
    assert bench.servos.servos[0].missing_condition == ""


@pytest.mark.parametrize("keys", [{"reached_bit"}, {"mode_display", "reached_bit"}])
def test_homing_by_the_drive_ends_without_bit_10_and_mode_display(
    make_bench: Any, keys: set[str]
) -> None:
    bench = bench_without(make_bench, keys, homing_method=33, home_offset=1000)
    bench.ready()
    axis = bench.axis
    assert commands.home(axis) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0, 60.0)
    bench.run(0.3)
    assert (axis.homed, axis.error_code) == (True, 0)
    assert bench.drive.record.position_actual == pytest.approx(1000, abs=50)
    here = axis.actual_position
    assert commands.start(axis, StartType.ABSOLUTE, here + 6.0, 100.0) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0, 3.0)
    bench.run(0.3)
    assert axis.actual_position == pytest.approx(here + 6.0, abs=0.1)


def test_mode_that_is_not_shown_is_active_after_its_time(make_bench: Any) -> None:
    bench = bench_without(make_bench, {MODE_DISPLAY.key}, homing_method=33)
    bench.ready()
    servo = bench.servos.servos[0]
    assert commands.home(bench.axis) == 0
    bench.until(lambda _: servo.mode == ServoMode.HM, 1.0)
    assert bench.until(lambda _: servo.mode_is_active, 1.0) == pytest.approx(0.05, abs=0.003)
