"""Motion: mode changes, stops with their decelerations, limit switches in every mode."""

from collections.abc import Callable

import pytest

from achse.codes import AlState
from achse.drive import Mechanics, Mode, PowerState, VirtualDrive
from achse.drive.modes import (
    ModeForm,
    cyclic_position,
    cyclic_torque,
    cyclic_velocity,
    homing,
    profile_position,
    profile_torque,
    profile_velocity,
)
from achse.drive.motion import choose_mode, enter_mode, generate, report, switch_off

MODES = [mode for mode in Mode if mode]

FORMS: dict[Mode, ModeForm] = {
    Mode.PROFILE_POSITION: profile_position,
    Mode.PROFILE_VELOCITY: profile_velocity,
    Mode.PROFILE_TORQUE: profile_torque,
    Mode.HOMING: homing,
    Mode.CYCLIC_POSITION: cyclic_position,
    Mode.CYCLIC_VELOCITY: cyclic_velocity,
    Mode.CYCLIC_TORQUE: cyclic_torque,
}


def _moving(mode: Mode) -> VirtualDrive:
    """A drive at about 500,000 inc/s in a mode."""
    drive = VirtualDrive(parameters={0x6085: 2_000_000, 0x6081: 500_000, 0x6087: 10**6})
    drive.enable(mode)
    drive.put(0x60FF, 500_000)
    drive.put(0x6071, 25)
    if mode is Mode.PROFILE_POSITION:
        drive.put(0x607A, 5_000_000)
        drive.control(0x1F, 300)
    elif mode is Mode.HOMING:
        drive.record.index_pitch = 1e12
        drive.record.index_offset = 5e11
        drive.set(0x6098, 34)
        drive.set(0x6099, 500_000, 2)
        drive.control(0x1F, 300)
    elif mode is Mode.CYCLIC_POSITION:
        for n in range(300):
            drive.put(0x607A, 500 * n)
            drive.cycle()
    else:
        drive.run(0.3)
    assert drive.get(0x606C) > 200_000
    return drive


def test_every_mode_is_a_module_of_the_same_form() -> None:
    assert list(FORMS) == MODES
    for form in FORMS.values():
        record = VirtualDrive().record
        form.enter(record)
        form.command(record, 1e-3)
        form.report(record, 1e-3)


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
def test_a_mode_is_taken_over(drive: VirtualDrive, mode: Mode) -> None:
    drive.put(0x6060, mode)
    drive.cycle()
    assert drive.get(0x6061) == mode


@pytest.mark.parametrize("mode", [0, 2, 5, 7])
def test_0_and_unsupported_modes_change_nothing(drive: VirtualDrive, mode: int) -> None:
    drive.put(0x6060, Mode.CYCLIC_VELOCITY)
    drive.cycle()
    drive.put(0x6060, mode)
    drive.cycle()
    assert drive.get(0x6061) == Mode.CYCLIC_VELOCITY


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
def test_quick_stop_decelerates_with_6085h_and_switches_off(mode: Mode) -> None:
    drive = _moving(mode)
    speed = drive.get(0x606C)
    start = drive.time_ns
    drive.control(0x02)
    assert drive.power_state is PowerState.QUICK_STOP_ACTIVE
    assert drive.statusword & 0x20 == 0
    drive.wait(lambda: drive.power_state is PowerState.SWITCH_ON_DISABLED, 10)
    assert (drive.time_ns - start) / 1e9 == pytest.approx(speed / 2_000_000, abs=0.05)
    assert abs(drive.get(0x606C)) < 2_000


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
@pytest.mark.parametrize("option", [0, 2])
def test_the_fault_reaction_coasts_or_decelerates(mode: Mode, option: int) -> None:
    drive = _moving(mode)
    drive.set(0x605E, option)
    speed = drive.get(0x606C)
    start = drive.time_ns
    drive.bring_up(AlState.SAFEOP)
    drive.wait(lambda: drive.power_state is PowerState.FAULT, 10)
    took = (drive.time_ns - start) / 1e9
    if option == 0:
        assert took < 0.01
        assert drive.get(0x606C) > 0.9 * speed
    else:
        assert took == pytest.approx(speed / 2_000_000, abs=0.05)
        assert abs(drive.get(0x606C)) < 2_000


@pytest.mark.parametrize(
    ("word", "state"),
    [
        (0x06, PowerState.READY_TO_SWITCH_ON),
        (0x07, PowerState.SWITCHED_ON),
        (0x00, PowerState.SWITCH_ON_DISABLED),
    ],
)
def test_other_commands_switch_off_at_once(word: int, state: PowerState) -> None:
    drive = _moving(Mode.PROFILE_VELOCITY)
    speed = drive.get(0x606C)
    drive.control(word, 2)
    assert drive.power_state is state
    assert drive.get(0x606C) > 0.95 * speed, "it coasts"
    assert drive.get(0x6074) == 0


@pytest.mark.parametrize(
    "mode", [mode for mode in MODES if mode is not Mode.HOMING], ids=lambda mode: mode.name
)
@pytest.mark.parametrize("direction", [1, -1])
def test_a_limit_switch_stops_and_lets_go_the_other_way(
    machine: Callable[..., Mechanics], mode: Mode, direction: int
) -> None:
    drive = VirtualDrive(
        machine(970_000 * direction), parameters={0x6085: 20_000_000, 0x6087: 10**6}
    )
    drive.enable(mode)

    def push(way: int, cycles: int) -> None:
        drive.put(0x60FF, 300_000 * way)
        drive.put(0x6071, 40 * way)
        if mode is Mode.PROFILE_POSITION:
            drive.put(0x607A, 100_000 * way)
            drive.control(0x6F, 1)
            drive.control(0x7F, cycles)
        else:
            for _ in range(cycles):
                drive.put(0x607A, drive.get(0x6062) + 200 * way)
                drive.cycle()

    push(direction, 400)
    stood = drive.position
    assert drive.power_state is PowerState.OPERATION_ENABLED
    assert abs(drive.get(0x606C)) < 2_000
    assert 30_000 <= stood * direction < 60_000
    assert drive.statusword & 0x0800
    if mode >= Mode.CYCLIC_POSITION:
        assert not drive.statusword & 0x1000, "the target is ignored"
    push(-direction, 400)
    assert drive.position * direction < 30_000
    assert not drive.statusword & 0x0800


@pytest.mark.parametrize("mode", [Mode.PROFILE_TORQUE, Mode.CYCLIC_TORQUE])
@pytest.mark.parametrize("torque", [300, 0])
def test_in_torque_modes_too_a_limit_switch_stops_with_6085h(
    machine: Callable[..., Mechanics], mode: Mode, torque: int
) -> None:
    """However hard the torque pushes, and also an axis that only runs on."""
    rate = 100_000_000
    drive = VirtualDrive(machine(900_000), parameters={0x6085: rate, 0x6087: 10**6})
    drive.enable(mode)
    drive.put(0x6071, 300)
    drive.wait(lambda: int(drive.get(0x60FD)) & 2, 1, "limit switch")
    speed = drive.get(0x606C)
    drive.put(0x6071, torque)
    drive.run(speed / rate + 0.05)
    assert abs(drive.get(0x606C)) < 2_000
    way = speed**2 / (2 * rate)
    assert drive.position == pytest.approx(100_000 + way, abs=0.1 * way)
    drive.put(0x6071, -300)
    drive.run(0.2)
    assert drive.position < 100_000, "away from the switch motion is free"


def test_overtravel_and_the_quick_stop_that_runs() -> None:
    """3062h: the running quick stop takes the 6085h of the moment over, or not."""
    for takes_over in (0, 1):
        drive = _moving(Mode.PROFILE_VELOCITY)
        drive.set(0x3062, takes_over)
        drive.control(0x02, 20)
        drive.set(0x6085, 4_000_000)
        drive.cycle(5)
        before = drive.record.demand_velocity
        drive.cycle()
        assert before - drive.record.demand_velocity == pytest.approx(2_000), "as it began"
        drive.faults.overtravel(positive=True)
        drive.cycle(2)
        before = drive.record.demand_velocity
        drive.cycle()
        assert before - drive.record.demand_velocity == pytest.approx(4_000)
        drive.faults.overtravel(positive=True, on=False)
        drive.cycle(2)
        before = drive.record.demand_velocity
        drive.cycle()
        assert before - drive.record.demand_velocity == pytest.approx(4_000 if takes_over else 2000)


@pytest.mark.parametrize("first", MODES, ids=lambda mode: mode.name)
@pytest.mark.parametrize("second", MODES, ids=lambda mode: mode.name)
def test_modes_change_in_motion_without_a_jump_of_the_axis(first: Mode, second: Mode) -> None:
    drive = _moving(first)
    drive.put(0x607A, drive.position)
    drive.put(0x6060, second)
    drive.run(0.2)
    assert drive.power_state is PowerState.OPERATION_ENABLED
    assert drive.get(0x6061) == second
    assert abs(drive.record.motor_velocity) < 5_000_000


def test_enabled_without_a_mode_the_axis_is_held(drive: VirtualDrive) -> None:
    drive.control(0x06, 2)
    drive.control(0x0F, 3)
    drive.faults.load(300)
    drive.run(0.5)
    assert drive.power_state is PowerState.OPERATION_ENABLED
    assert abs(drive.position) <= 2


def test_the_functions_of_the_cycle_by_themselves(drive: VirtualDrive) -> None:
    record = drive.record
    record.mode_request = Mode.PROFILE_VELOCITY
    choose_mode(record)
    record.power_state = PowerState.OPERATION_ENABLED
    enter_mode(record)
    record.target_velocity = 1_000
    generate(record, 1e-3)
    report(record, 1e-3)
    assert record.demand_velocity == 1_000
    switch_off(record)
    assert record.control == 0
