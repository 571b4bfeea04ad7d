"""Each parameter that can be written changes what the axis does, beyond its own value.

The list in tests/data says in which of the scenarios below, by which value, and what proves it. A
row is written over ADS before the scenario begins; then the axis is compared with what it does
without it. Proof is motion: positions, velocities, torques, errors. What changes none of them by
its nature names the one state that it is made for, or the outputs to the drive.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.ams import DeviceError, NetId
from achse.devices.nc import NcDevice
from achse.devices.nc.coverage import CONSTANT, WITHOUT_EFFECT
from achse.devices.nc.device import AXIS_GROUPS
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.nc import configurable
from achse.motion.record import FIELDS
from achse.motion.tables import TableParameters
from achse.router import Router
from achse.server import READ, WRITE, Service

EFFECTS = Path(__file__).parents[3] / "data" / "nc_effects.tsv"

CYCLE = 0.002
LOOK = 5
"""Cycles from one look to the next."""

ELEMENT = {0x4000: "", 0x5000: "encoder_", 0x6000: "controller_", 0x7000: "drive_"}
"""Index group of parameters, and how the names of its rows continue in the record."""

MOTION = (
    "error_code", "delayed_error_code", "set_position", "set_velocity", "set_torque",
    "actual_position", "actual_velocity", "drive_actual_torque",
)  # fmt: skip

OUTPUTS = "outputs"
"""What NC and drive exchange: structures 0x7300:0 and 0x5300:0x80."""


class Scenario(NamedTuple):
    """Values of the axis that it begins with, and what happens: do this, then wait."""

    values: dict[str, float]
    steps: tuple[tuple[Callable[[Axis], Any], float], ...]


def parameters() -> Iterator[tuple[str, int, Service]]:
    """Field, index group and row of each parameter that can be written."""
    for group, rows, _ in AXIS_GROUPS:
        for row in rows:
            if group in ELEMENT and WRITE in row.access:
                for name in (ELEMENT[group] + row.name, row.name):
                    if name in FIELDS or configurable(name):
                        yield name, group + 1, row
                        break


def torque(set_torque: float) -> Callable[[Axis], Any]:
    def start(axis: Axis) -> int:
        return commands.start_torque_control(
            axis, 0x3001, 0, 0, 0, set_torque, 1000.0, 500.0, -500.0, 0.0, 0.0, 0.0
        )

    return start


def to(position: float, velocity: float = 200.0, start_type: int = 1) -> Callable[[Axis], Any]:
    return partial(
        commands.universal_start, start_type=start_type, position=position, velocity=velocity
    )


def put(**values: float) -> Callable[[Axis], None]:
    def write(axis: Axis) -> None:
        for name, value in values.items():
            setattr(axis, name, value)

    return write


VALVE = TableParameters(3, [(-1.0, -1.0), (-0.1, -0.4), (0.0, 0.0), (0.1, 0.5), (1.0, 1.0)])

LOAD = {"simulation_load_torque": 200.0, "simulation_drift": 3.0}
BOTH_WAYS = ((to(60.0), 1.0), (to(-20.0), 1.0))

SCENARIOS = {
    "move": Scenario({}, BOTH_WAYS),
    "slow_drive": Scenario(
        {"simulation_time_constant": 0.2, "controller_following_error_velocity_max": 20.0},
        BOTH_WAYS,
    ),
    "everything_filtered": Scenario(
        {
            "backlash": 0.5,
            "backlash_compensation_enable": 1,
            "encoder_actual_position_correction_enable": 1,
            "actual_position_correction": 1.0,
            "encoder_dead_time_compensation_mode": 2,
            "encoder_dead_time_compensation_shift": 1_000_000,
            "encoder_position_filter_time": 0.01,
        },
        BOTH_WAYS,
    ),
    "jog": Scenario(
        {},
        tuple(
            step
            for start_type in (272, 528, 784, 273, 529, 785, 288, 289)
            for step in ((to(0.0, 100.0, start_type), 0.4), (commands.stop, 1.0))
        ),
    ),
    "loop": Scenario({"loop_enable": 1, "loop_distance": 10.0}, BOTH_WAYS),
    "override": Scenario({}, ((put(velocity_override=300_000), 0.01), *BOTH_WAYS)),
    "homing": Scenario({"simulation_cam_end": -5.0}, ((commands.home, 6.0),)),
    "homing_to_the_position_range": Scenario(
        {
            "simulation_cam_end": -5.0,
            "target_position_monitoring_enable": 0,
            "simulation_time_constant": 0.05,
        },
        ((commands.home, 6.0),),
    ),
    "homing_by_input": Scenario(
        {"simulation_cam_end": -5.0, "simulation_cam_input": 2, "encoder_homing_sensor_source": 2},
        ((commands.home, 6.0),),
    ),
    "soft_limits": Scenario(
        {
            "encoder_soft_limit_min": -10.0,
            "encoder_soft_limit_max": 30.0,
            "encoder_soft_limit_min_enable": 1,
            "encoder_soft_limit_max_enable": 1,
        },
        (
            (to(25.0), 1.0),
            (to(40.0), 0.5),
            (to(-5.0), 1.0),
            (to(-40.0), 0.5),
        ),
    ),
    "blocked": Scenario(
        {
            "simulation_blocked": 1,
            "motion_monitoring_enable": 1,
            "peh_monitoring_enable": 1,
            "peh_monitoring_time": 0.5,
            "controller_following_error_velocity_monitoring_enable": 1,
            "controller_following_error_velocity_max": 100.0,
            "controller_following_error_position_max": 20.0,
        },
        ((to(60.0), 2.0),),
    ),
    "stuck": Scenario(
        {
            "simulation_blocked": 1,
            "motion_monitoring_enable": 1,
            "controller_following_error_position_monitoring_enable": 0,
        },
        ((to(60.0), 2.0),),
    ),
    "never_there": Scenario(
        {
            "peh_monitoring_enable": 1,
            "peh_monitoring_time": 0.3,
            "controller_position_kv": 0.0,
            "controller_following_error_position_monitoring_enable": 0,
            "simulation_drift": 10.0,
        },
        ((to(20.0), 2.0),),
    ),
    "error": Scenario(
        {},
        ((to(400.0), 1.0), (partial(commands.set_external_error, code=0x4650), 2.0)),
    ),
    "delayed_error": Scenario(
        {"error_reaction_mode": 1, "error_reaction_delay": 0.3, "simulation_time_constant": 1.0},
        ((to(400.0), 3.0),),
    ),
    "signal": Scenario(
        {
            "fast_axis_stop_signal_type": 1,
            "fast_axis_stop_deceleration": 5000.0,
            "fast_axis_stop_jerk": 1e5,
        },
        ((to(4000.0, 1000.0), 2.0), (put(simulation_fast_stop_signal=1), 1.0)),
    ),
    "modulo": Scenario(
        {"unit_interpretation": 4, "encoder_modulo_factor": 100.0},
        ((to(30.0), 1.0), (to(29.0, start_type=517), 1.5), (to(31.0, start_type=773), 1.5)),
    ),
    "pp": Scenario({"controller_type": 2, "controller_position_kv_fast": 60.0, **LOAD}, BOTH_WAYS),
    "pid": Scenario(
        {
            "controller_type": 3,
            "controller_position_tn": 0.2,
            "controller_position_tv": 0.05,
            "controller_position_td": 0.01,
            **LOAD,
        },
        BOTH_WAYS,
    ),
    "velocity_pi": Scenario(
        {
            "controller_type": 6,
            "controller_velocity_tn": 0.1,
            "controller_velocity_tv": 0.02,
            "controller_velocity_td": 0.01,
            **LOAD,
        },
        BOTH_WAYS,
    ),
    "observer": Scenario({"controller_type": 6, "controller_observer_mode": 1, **LOAD}, BOTH_WAYS),
    "offset": Scenario(
        {
            "controller_auto_offset_enable": 1,
            "controller_auto_offset_time_constant": 0.2,
            **LOAD,
        },
        ((commands.enable, 1.0), *BOTH_WAYS),
    ),
    "offset_fades": Scenario(
        {
            "controller_auto_offset_enable": 1,
            "controller_auto_offset_hold": 0,
            "controller_auto_offset_fading": 1,
            "controller_auto_offset_time_constant": 0.2,
            **LOAD,
        },
        ((commands.enable, 1.0), *BOTH_WAYS),
    ),
    "curve": Scenario({"drive_type": 6, "drive_output_reference_point": 0.8}, BOTH_WAYS),
    "valve": Scenario({"drive_table_id": VALVE.table_id}, BOTH_WAYS),
    "limits": Scenario(
        {"max_velocity": 3000.0}, ((to(4000.0, 2500.0), 1.0), (to(0.0, 2000.0), 3.0))
    ),
    "position_drive": Scenario(
        {
            "controller_type": 9,
            "drive_output_filter_type": 1,
            "drive_output_filter_time": 0.02,
            "drive_output_filter_order": 2,
            "drive_dead_time_compensation_mode": 2,
            "drive_dead_time_compensation_shift": 2_000_000,
        },
        BOTH_WAYS,
    ),
    "filtered_drive": Scenario(
        {
            "controller_type": 9,
            "drive_output_filter_type": 2,
            "drive_output_filter_time": 0.02,
            "drive_output_filter_order": 2,
        },
        BOTH_WAYS,
    ),
    "late_drive": Scenario(
        {
            "controller_type": 9,
            "drive_dead_time_compensation_mode": 1,
            "drive_dead_time_compensation_shift": 4_000_000,
        },
        BOTH_WAYS,
    ),
    "torque": Scenario(
        {},
        (
            (
                torque(300.0),
                1.0,
            ),
        ),
    ),
    "two_speeds": Scenario(
        {
            "axis_type": 2,
            "drive_type": 7,
            "controller_type": 7,
            "rapid_to_creep_switch_time": 0.02,
            "brake_delay_positive": 0.02,
            "brake_delay_negative": 0.02,
            "brake_release_delay": 0.02,
            "creep_distance_stop": 3.0,
        },
        ((to(60.0), 3.0), (to(-20.0), 3.0), (to(3000.0), 0.3), (commands.stop, 2.0)),
    ),
    "profidrive": Scenario({"drive_type": 12, "drive_dsc_kpc": 20_000}, BOTH_WAYS),
    "digital_drive": Scenario(
        {"drive_type": 10}, ((put(set_torque_offset=50.0), 0.1), *BOTH_WAYS, (torque(300.0), 0.5))
    ),
    "homing_by_sync": Scenario(
        {"simulation_cam_end": -5.0, "encoder_reference_mode": 2, "simulation_turn": 20_000.0},
        ((commands.home, 6.0),),
    ),
    "homing_in_count": Scenario(
        {"simulation_cam_end": -5.0, "encoder_reference_mode": 5, "encoder_sub_mask": 0xFFF},
        ((commands.home, 6.0),),
    ),
    "motor_far_behind": Scenario(
        {
            "motion_monitoring_enable": 1,
            "motion_monitoring_time": 0.3,
            "simulation_time_constant": 10.0,
            "controller_following_error_position_monitoring_enable": 0,
            "controller_position_kv": 0.0,
        },
        ((to(60.0, 20.0), 3.0),),
    ),
    "saturated": Scenario(
        {
            "controller_type": 3,
            "controller_position_tn": 0.05,
            "controller_position_tv": 0.5,
            "controller_position_td": 0.002,
            "simulation_drift": 400.0,
            "controller_following_error_position_monitoring_enable": 0,
        },
        BOTH_WAYS,
    ),
    "velocity_saturated": Scenario(
        {
            "controller_type": 6,
            "controller_velocity_kp": 5.0,
            "controller_velocity_tn": 0.02,
            "controller_velocity_tv": 0.5,
            "controller_velocity_td": 0.002,
            "simulation_drift": 400.0,
            "controller_following_error_position_monitoring_enable": 0,
        },
        BOTH_WAYS,
    ),
    "external": Scenario(
        {},
        (
            (put(external_set_velocity=0.0), 0.1),
            (partial(commands.start_external_setpoint, start_type=1, end_position=10.0), 0.1),
            (to(20.0), 1.0),
        ),
    ),
    "one_two_phase": Scenario(
        {
            "axis_type": 3,
            "drive_type": 8,
            "controller_type": 8,
            "stepper_operation_mode": 2,
            **{f"drive_stepper_mask_cycle{n}": 1 << (n - 1) for n in range(1, 9)},
        },
        ((to(3.0, 4.0), 2.0), (to(0.0, 4.0), 2.0)),
    ),
    "stepper": Scenario(
        {"axis_type": 3, "drive_type": 8, "controller_type": 8, "stepper_min_velocity": 5.0},
        ((to(3.0, 4.0), 2.0), (to(0.0, 4.0), 2.0)),
    ),
    "half_steps": Scenario(
        {"axis_type": 3, "drive_type": 8, "controller_type": 8, "stepper_operation_mode": 3},
        ((to(3.0, 4.0), 2.0), (to(0.0, 4.0), 2.0)),
    ),
}


ROWS: dict[str, list[tuple[int, Service]]] = {}
for _name, _group, _row in parameters():
    ROWS.setdefault(_name, []).append((_group, _row))


class Show:
    """An axis with a scenario's values, in a device of its own."""

    def __init__(self, client_of: Callable[..., Any], scenario: Scenario) -> None:
        values = {"velocity_override": 1_000_000, **scenario.values}
        self.nc = Nc(round(CYCLE * 1e9), [AxisParameters(1, "X", "mm", values)], tables=[VALVE])
        self.steps = scenario.steps
        router = Router(NetId("5.1.2.3.1.1"))
        NcDevice(self.nc, clock=lambda: self.nc.cycle_count * self.nc.cycle_ns).attach(router, 501)
        self.client = client_of(router, 501)

    def play(self, proof: str) -> list[Any]:
        """What of the axis is to prove an effect, until the scenario ends."""
        axis = self.nc.axis(1)
        self.nc.cycle()
        axis.control_dword = 7
        self.nc.cycle(LOOK)
        seen: list[Any] = []
        for action, seconds in self.steps:
            action(axis)
            for _ in range(round(seconds / CYCLE / LOOK)):
                self.nc.cycle(LOOK)
                if proof == OUTPUTS:
                    seen.append(self.client.read(0x7301, 0, 40))
                    seen.append(self.client.read(0x5301, 0x80, 40))
                else:
                    names = MOTION if proof == "motion" else (proof,)
                    seen.append([getattr(axis, name) for name in names])
        return seen


LISTED = {
    name: (scenario, value, proof)
    for name, scenario, value, proof in (
        line.split("\t") for line in EFFECTS.read_text(encoding="utf-8").splitlines()[1:]
    )
}


@pytest.fixture(scope="module")
def usual(client_of: Callable[..., Any]) -> Callable[[str, str], list[Any]]:
    """What a scenario shows as it is."""
    return cache(lambda name, proof: Show(client_of, SCENARIOS[name]).play(proof))


@pytest.mark.parametrize("name", LISTED)
def test_a_parameter_changes_what_the_axis_does(
    client_of: Callable[..., Any], usual: Callable[[str, str], list[Any]], name: str
) -> None:
    scenario, text, proof = LISTED[name]
    field = FIELDS.get(name) or configurable(name)
    assert field is not None
    value = type(field.default)(text)
    for group, row in ROWS[name]:
        show = Show(client_of, SCENARIOS[scenario])
        assert not isinstance(row.codec, tuple)
        show.client.write(group, row.offset, row.codec.encode(value))
        assert show.play(proof) != usual(scenario, proof), f"0x{group:X}:0x{row.offset:X}"


def test_motion_proves_wherever_it_can() -> None:
    """Other proof is for what by its nature moves nothing: a new one is a decision."""
    others = {name: proof for name, (_, _, proof) in LISTED.items() if proof != "motion"}
    assert len(others) <= 16
    assert set(others.values()) <= {
        "in_position_range", "actual_acceleration", "user_data", "drive_control_byte",
        "drive_actual_torque_derivative", OUTPUTS,
    }  # fmt: skip


def test_each_parameter_has_an_effect_or_a_reason() -> None:
    assert LISTED.keys() & WITHOUT_EFFECT.keys() == set()
    assert ROWS.keys() - LISTED.keys() - WITHOUT_EFFECT.keys() == OF_SEVERAL_AXES
    assert WITHOUT_EFFECT.keys() <= ROWS.keys()


OF_SEVERAL_AXES = {
    "couple_slaves_by_actual_values",
    "fading_acceleration",
    "allow_slave_motion_commands",
    "controller_slave_coupling_kcp",
    "controller_following_error_difference_scaling",
    "max_velocity_jump",
}
"""What one axis alone does not show; the tests of couplings and paths do."""

CONFIGURED = {
    "channel_count", "group_count", "axis_count", "encoder_count", "controller_count",
    "drive_count", "table_count", "channel_ids", "group_ids", "axis_ids", "encoder_ids",
    "controller_ids", "drive_ids", "table_ids", "axis_id", "group_id", "group_name",
    "index_in_channel", "saf_cycle_time", "svb_cycle_time",
    "axis_id_of_encoder", "axis_id_of_controller", "axis_id_of_drive",
}  # fmt: skip
"""What configuration says, and the axes of a channel do."""

ASKED_FOR = {
    "saf_cycle_time_error_count", "saf_io_cycle_time_error_count", "saf_computing_time",
    "active_control_loop", "initialize_command_counter", "reset_command_counter",
    "setpoint_correction_counter", "axis_disabled", "encoder_reinitialization_state",
    "control_dword", "controller_enable", "feed_enable_plus", "feed_enable_minus", "homing_cam",
    "operation_mode", "operation_mode_busy", "operation_mode_feedback", "io_data_invalid",
    "external_controller_component", "external_setpoint", "saf_entry_count",
    "coupling_table_index", "saf_free_entry_count", "encoder_output_structure",
    "output_structure", "error_state",
    "latch_active", "latch_valid", "latch_hardware_increments", "latch_software_increments",
    "latch_position", "latch_hardware_increment_difference", "latch_position_difference",
    "latch_software_increment_difference", "latch_rising_edge_active",
    "latch_falling_edge_active", "touch_probe1_input_state", "observer_i_limit_active",
    "controller_position_arw_active", "controller_velocity_arw_active", "position_arw_active",
    "velocity_arw_active", "touch_probe2_input_state", "position_d_limit_active",
    "controller_position_d_limit_active", "slave_axis_count", "coupling_state",
    "coupling_parameters", "gear_ratio", "set_gear_ratio", "protected_mode",
    "fading_position_difference", "fading_relative_velocity", "fading_relative_acceleration",
    "controller_following_error_difference", "following_error_difference",
    "controller_following_error_difference_peak_negative",
    "controller_following_error_difference_peak_positive",
    "following_error_difference_peak_negative", "following_error_difference_peak_positive",
    "sync_profile_characteristic_values", "emergency_stop_active",
    "channel_velocity_override", "spindle_velocity_override",
}  # fmt: skip
"""What no scenario asks for; the tests of these rows show that they change."""


def shown_by(scenario: Scenario, seen: dict[tuple[int, int, str], set[bytes]]) -> None:
    """Play a scenario and note what the state rows of all objects answer, until it changes."""
    values = {"velocity_override": 1_000_000, **scenario.values}
    nc = Nc(round(CYCLE * 1e9), [AxisParameters(1, "X", "mm", values)], tables=[VALVE])
    services = NcDevice(nc, clock=lambda: 0).services
    rows = [
        (group, answers, base + (base >= 0x2000), row.offset)
        for group in services
        if (base := getattr(group, "base", 0) or getattr(group, "index_group", 0)) < 0xA000
        if base & 0xF00 or 0x2000 <= base < 0x4000
        for row in getattr(group, "rows", ())
        if READ in row.access
        if len(answers := seen.setdefault((base, row.offset, row.name), set())) < 2
    ]
    axis = nc.axis(1)
    nc.cycle()
    axis.control_dword = 7
    for action, seconds in scenario.steps:
        action(axis)
        for _ in range(1 + round(seconds / 0.1)):
            nc.cycle(50)
            for group, answers, index_group, offset in rows:
                if len(answers) < 2:
                    with suppress(DeviceError):  # of other types of axes alone
                        answers.add(bytes(group.read(index_group, offset, 1024, b"")))


def test_what_never_changes_is_called_a_constant() -> None:
    """The coverage page says of each row whether it can answer anything else."""
    seen: dict[tuple[int, int, str], set[bytes]] = {}
    for scenario in SCENARIOS.values():
        shown_by(scenario, seen)
    changing = [key for key, answers in seen.items() if len(answers) > 1]
    assert [key for key in changing if key[:2] in CONSTANT] == []
    silent = [key for key, answers in seen.items() if len(answers) == 1]
    unexplained = [
        f"0x{group:X}:0x{offset:X} {name}"
        for group, offset, name in silent
        if (group, offset) not in CONSTANT and name not in CONFIGURED | ASKED_FOR
    ]
    assert unexplained == []
    assert {(group, offset) for group, offset, _ in silent} >= {
        key for key in CONSTANT if key[0] & 0xF00 or 0x2000 <= key[0] < 0x4000
    }
