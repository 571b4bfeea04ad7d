"""Features: their bits, what sets and clears them, and that the fast path leaves nothing out."""

from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes.axis import BufferMode, StartType
from achse.codes.nc.choices import AxisType, ControllerType, ReferenceMode
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.commands import Compensation
from achse.motion.features import (
    ALL_FEATURES,
    BY_PARAMETERS,
    SWITCHES,
    TRANSIENT,
    Feature,
)
from achse.motion.kernel import STAGES
from achse.motion.record import AXIS_PARTS, LAYOUT, PART_OF
from achse.motion.states import DriveOperationMode, EndPositionType

VALUES = {
    "control_dword": 7.0,
    "velocity_override": 1_000_000.0,
    "controller_following_error_position_monitoring_enable": 0.0,
    "default_acceleration": 10_000.0,
    "default_deceleration": 10_000.0,
    "default_jerk": 1e6,
}


def new_nc(*, compiled: bool | None = None) -> Nc:
    nc = Nc(
        2_000_000,
        [AxisParameters(number, values=VALUES) for number in (1, 2)],
        compiled=compiled,
    )
    nc.cycle(5)
    return nc


def put(**values: float) -> Callable[[Axis], None]:
    """Write values of the axis, of its parts (`drive__delay`) or of its machine."""

    def write(axis: Axis) -> None:
        for name, value in values.items():
            path, _, field = name.rpartition("__")
            setattr(attrgetter(path.replace("__", "."))(axis) if path else axis, field, value)

    return write


def move(axis: Axis) -> None:
    commands.universal_start(axis, StartType.RELATIVE, 300.0, 100.0)


def compensate(axis: Axis) -> None:
    move(axis)
    commands.start_superposition(axis, Compensation(2, 500.0, 500.0, 20.0, 100.0, 5.0, 200.0))


def phase(axis: Axis) -> None:
    commands.couple(axis, 1, 2, 0, 0, 1.0)
    commands.start_phasing(axis, 1, 0, 2, 10.0, 50.0)


def limit_output(axis: Axis) -> None:
    put(drive__output_limit_max=1e-6)(axis)
    move(axis)


def unlock(axis: Axis) -> None:
    commands.release_lock(axis)
    move(axis)


def delay_error(axis: Axis) -> None:
    put(error_reaction_mode=1, error_reaction_delay=0.05)(axis)
    put(controller__following_error_position_monitoring_enable=1)(axis)
    put(controller__following_error_position_max=1e-9)(axis)
    put(controller__following_error_position_filter_time=0.004)(axis)
    move(axis)


def search_pulse(axis: Axis) -> None:
    """Home an axis that is on its cam, close to the end of it."""
    put(machine__cam_end=0.5, encoder__reference_mode=ReferenceMode.HARDWARE_SYNC)(axis)
    commands.home(axis)


def halt_after_a_move(axis: Axis) -> None:
    commands.universal_start(axis, StartType.RELATIVE, 0.5, 100.0)
    commands.universal_start(axis, StartType.HALT, 0.0, 0.0, buffer_mode=BufferMode.BUFFERED)


def change_target_on_the_way(axis: Axis) -> None:
    move(axis)
    commands.new_end_position_and_velocity(
        axis, 11, EndPositionType.RELATIVE, 100.0, 80.0, axis.set_position + 1.0
    )


def push_to_the_velocity_limit(axis: Axis) -> None:
    commands.start_torque_control(axis, 0x3001, 0, 0, 0, 100.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0)


def stop(axis: Axis) -> None:
    commands.stop(axis)


def reset(axis: Axis) -> None:
    put(controller__following_error_position_monitoring_enable=0, error_reaction_mode=0)(axis)
    commands.reset(axis)
    commands.stop(axis)


class Switch(NamedTuple):
    """How a feature is switched on and off."""

    on: Callable[[Axis], object]
    off: Callable[[Axis], object]


ACTIONS = {
    Feature.PARAMETERS: Switch(put(max_velocity=1500.0), put(max_velocity=2000.0)),
    Feature.KIND: Switch(put(axis_type=AxisType.ENCODER), put(axis_type=AxisType.CONTINUOUS_SERVO)),
    Feature.OPERATION_MODE: Switch(
        lambda axis: commands.set_drive_operation_mode(axis, DriveOperationMode.POSITION_FEEDBACK1),
        lambda axis: commands.set_drive_operation_mode(axis, 0),
    ),
    Feature.GENERATOR: Switch(
        lambda axis: commands.start_velocity_steps(axis, 1, 50.0, -50.0, 0.02, 0.01, 3), stop
    ),
    Feature.EXTERNAL_SETPOINT: Switch(
        lambda axis: commands.start_external_setpoint(axis, 1, 0.0),
        commands.stop_external_setpoint,
    ),
    Feature.SUPERPOSITION: Switch(compensate, stop),
    Feature.REVERSING: Switch(
        lambda axis: commands.start_reversing(axis, 1, 5.0, -5.0, 100.0, 0.01), stop
    ),
    Feature.PHASING: Switch(phase, commands.decouple),
    Feature.HOMING: Switch(search_pulse, stop),
    Feature.LATCH: Switch(
        lambda axis: commands.activate_touch_probe(axis, 1, 0, 1, 128),
        lambda axis: commands.deactivate_touch_probe(axis, 1, 0),
    ),
    Feature.SOFT_LIMITS: Switch(
        put(encoder__soft_limit_max=40.0, encoder__soft_limit_max_enable=1),
        put(encoder__soft_limit_max_enable=0),
    ),
    Feature.FAST_STOP: Switch(
        put(fast_axis_stop_signal_type=3, machine__fast_stop_signal=1),
        put(fast_axis_stop_signal_type=0, machine__fast_stop_signal=0),
    ),
    Feature.IO_INVALID: Switch(put(machine__io_invalid=1), put(machine__io_invalid=0)),
    Feature.LIMIT_SWITCH: Switch(put(machine__limit_max=-1e6), put(machine__limit_max=1e6)),
    Feature.OUTPUT_LIMIT: Switch(
        limit_output,
        put(drive__output_limit_max=1.0),
    ),
    Feature.STATUS: Switch(
        lambda axis: commands.universal_start(
            axis, StartType.STOP_AND_LOCK, 0.0, 0.0, deceleration=900.0, jerk=9000.0
        ),
        unlock,
    ),
    Feature.DELAYED_ERROR: Switch(delay_error, reset),
    Feature.ERROR: Switch(lambda axis: commands.set_external_error(axis, 0x4650), reset),
    Feature.EXTERNAL_ERROR: Switch(lambda axis: commands.set_external_error(axis, 0x4651), reset),
    Feature.DISABLED: Switch(commands.disable, commands.enable),
    Feature.GROUPED: Switch(commands.join_group, commands.leave_group),
    Feature.POSITION_DELAY: Switch(
        put(setpoint_velocity_position_delay=0.004), put(setpoint_velocity_position_delay=0.0)
    ),
    Feature.TORQUE_OFFSET: Switch(put(set_torque_offset=5.0), put(set_torque_offset=0.0)),
    Feature.DRIVE: Switch(
        put(drive__velocity_output_delay=0.006), put(drive__velocity_output_delay=0.0)
    ),
    Feature.CONTROLLER: Switch(
        put(controller__type=ControllerType.PID_POSITION),
        put(controller__type=ControllerType.P_POSITION),
    ),
}


LATER = [
    (Feature.OUTPUT_LIMIT, Switch(push_to_the_velocity_limit, stop)),
    (Feature.STATUS, Switch(halt_after_a_move, move)),
    (Feature.STATUS, Switch(change_target_on_the_way, move)),
    (Feature.LATCH, Switch(search_pulse, stop)),
]
"""Features that the cycle itself switches on."""

SWITCHED = [*ACTIONS.items(), *LATER]


def test_each_feature_has_a_bit_a_switch_and_a_test() -> None:
    assert [feature.bit_count() for feature in Feature] == [1] * len(Feature)
    assert sum(Feature) == ALL_FEATURES == BY_PARAMETERS | TRANSIENT | Feature.PARAMETERS
    assert BY_PARAMETERS & TRANSIENT == 0
    assert sum(SWITCHES) == TRANSIENT
    assert ACTIONS.keys() == set(Feature)


@pytest.mark.parametrize(
    ("feature", "path"), [(feature, path) for feature, paths in SWITCHES.items() for path in paths]
)
def test_value_written_from_outside_sets_the_bit_of_its_feature(
    rig: Any, set_features: Callable[[Any, int], None], feature: Feature, path: str
) -> None:
    axis = rig.axis
    part, _, name = path.rpartition(".")
    owner = getattr(axis, part) if part else axis
    set_features(axis, 0)
    setattr(owner, name, 1)
    assert axis.features == feature


@pytest.mark.parametrize(
    ("name", "statement"),
    [
        ("max_velocity", "record.features |= 1; record.resting = 0"),
        ("grouped", f"record.features |= {1 << 20}; record.resting = 0"),
        ("target_position", "record.resting = 0"),
        ("resting", "pass"),
        ("features", "pass"),
    ],
)
def test_write_wakes_the_axis_and_sets_bits_in_one_statement(name: str, statement: str) -> None:
    assert Axis.after_change(LAYOUT.fields[name]) == statement


def test_only_switches_set_bits_from_outside() -> None:
    names = {path.replace(".", "_") for paths in SWITCHES.values() for path in paths}
    names -= {"homing_latch", "reversing_number"}
    assert names == {
        *("drive_operation_mode", "set_motion_phase", "external_setpoint_active"),
        *("compensating", "phasing_active", "homing_state"),
        *("encoder_latch_active", "encoder_latch_valid", "encoder_armed", "io_invalid"),
        *("drive_io_time", "limit_switch", "drive_limit_active", "has_been_stopped"),
        *("got_new_target", "motion_locked", "delayed_error_code", "error_code", "output_cut"),
        *("external_error", "axis_disabled", "drive_output_disabled", "grouped"),
        "set_torque_offset",
    }
    assert {name for name, (_, field) in PART_OF.items() if field.feature} == names
    within = {
        f"{part}_{field.name}"
        for part, layout in AXIS_PARTS.items()
        for field in layout.fields.values()
        if field.feature
    }
    assert within == {
        *("delayed_error_code", "homing_latch", "homing_state", "phasing_active"),
        "reversing_number",
    }


def test_fresh_axis_looks_for_all_features_and_finds_none(make_rig: Any) -> None:
    rig = make_rig()
    assert rig.axis.features == 0
    rig.axis.features = TRANSIENT
    rig.run(1)
    assert rig.axis.features == 0


@pytest.mark.parametrize(("feature", "switch"), SWITCHED)
def test_feature_sets_its_bit_and_clears_it(feature: Feature, switch: Switch) -> None:
    nc = new_nc()
    axis = nc.axis(1)
    assert axis.features == 0
    switch.on(axis)
    seen = axis.features
    for _ in range(200):
        nc.cycle()
        seen |= axis.features
    assert seen & feature
    switch.off(axis)
    for _ in range(2000):
        nc.cycle()
        if axis.features & feature == 0:
            break
    assert axis.features & feature == 0


def test_axis_works_with_the_features_of_the_parts_that_it_changes_to() -> None:
    values = VALUES | {"controller_type": 1.0}
    nc = Nc(
        2_000_000,
        [AxisParameters(1, values=values, encoder_ids=(1, 2), controller_ids=(1, 2))],
    )
    axis = nc.axis(1)
    nc.cycle(5)
    commands.activate_touch_probe(axis.encoders[1], 1, 0, 1, 128)
    axis.controllers[1].type = ControllerType.PID_POSITION
    nc.cycle(5)
    assert axis.features == 0
    assert commands.switch_control_loop(axis, 1, 1, 0.0) == 0
    nc.cycle(5)
    assert axis.features == Feature.LATCH | Feature.CONTROLLER


def test_fast_cycle_has_the_order_of_the_full_one() -> None:
    assert [stage.name for stage in STAGES if stage.fast] == [
        *("encoder", "drive inputs", "enables", "set point", "coupling", "controller"),
        *("supervision", "outputs", "status"),
    ]


STEPS = st.lists(
    st.tuples(
        st.sampled_from([switch for _, switch in SWITCHED]), st.booleans(), st.integers(1, 40)
    ),
    min_size=2,
    max_size=6,
)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(STEPS, st.booleans())
def test_fast_cycle_is_the_full_one_whatever_is_switched_on_and_off(
    same_both_ways: Callable[[Nc, Nc, int], list[bool]],
    steps: list[tuple[Switch, bool, int]],
    moving: bool,
) -> None:
    both = new_nc(), new_nc()
    for switch, on, cycles in steps:
        for nc in both:
            if moving:
                move(nc.axis(1))
                move(nc.axis(2))
            (switch.on if on else switch.off)(nc.axis(1))
        same_both_ways(*both, cycles)


@pytest.mark.parametrize("switch", [switch for _, switch in SWITCHED])
def test_fast_cycle_is_the_full_one_until_a_feature_begins_and_ends(
    same_both_ways: Callable[[Nc, Nc, int], list[bool]], switch: Switch
) -> None:
    both = new_nc(), new_nc()
    for change in (switch.on, switch.off):
        for nc in both:
            change(nc.axis(1))
        same_both_ways(*both, 150)
