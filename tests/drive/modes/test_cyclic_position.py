"""Cyclic synchronous position: interpolation, targets that are too far, status bits."""

import math
from collections.abc import Callable

import pytest

from achse.codes import AlState, AlStatus
from achse.drive import Drive, Mechanics, Mode, VirtualDrive

FOLLOWS, LIMIT = 0x1000, 0x0800


@pytest.fixture
def csp(drive: VirtualDrive) -> VirtualDrive:
    drive.enable(Mode.CYCLIC_POSITION)
    return drive


def test_enabling_does_not_jump() -> None:
    drive = VirtualDrive(Mechanics(position=123_456), parameters={0x607C: 1_000})
    drive.enable(Mode.CYCLIC_POSITION)
    drive.run(0.1)
    assert drive.position == 1_000
    assert drive.statusword & FOLLOWS


def test_each_target_is_reached_within_its_cycle(csp: VirtualDrive) -> None:
    """A 1 ms target is interpolated over four drive cycles of 250 µs."""
    csp.put(0x607A, 1_000)
    csp.record.fresh_outputs = 1
    seen = []
    for _ in range(4):
        csp.step(250_000)
        seen.append(csp.record.demand)
    assert seen == pytest.approx([250, 500, 750, 1_000])


def test_the_axis_follows_a_sine(csp: VirtualDrive) -> None:
    worst: float = 0
    for n in range(2_000):
        csp.put(0x607A, round(100_000 - 100_000 * math.cos(math.tau * n / 1_000)))
        csp.cycle()
        worst = max(worst, abs(csp.get(0x60F4)))
    assert csp.get(0x6062) == round(100_000 - 100_000 * math.cos(math.tau * 1.999))
    assert worst < 200, "one revolution is 131,072"


def test_the_following_error_is_velocity_over_gain() -> None:
    """Without feed-forward the P loop lags by v / Kp; with it by nothing."""
    for forward, lag in ((0, 200_000 / 50), (50, 100_000 / 50), (100, 0)):
        drive = VirtualDrive(parameters={0x2109: forward, 0x2102: 500})
        drive.enable(Mode.CYCLIC_POSITION)
        for n in range(1_000):
            drive.put(0x607A, 200 * n)
            drive.cycle()
        assert drive.get(0x60F4) == pytest.approx(lag, abs=30)


def test_a_target_too_far_away_is_ignored(csp: VirtualDrive) -> None:
    csp.put(0x607A, 20_000)  # 6000 1/min are 13,107 counts in 1 ms
    csp.cycle()
    assert not csp.statusword & FOLLOWS
    assert csp.statusword & LIMIT
    assert csp.get(0x6062) == 0
    csp.put(0x607A, 1_000)
    csp.cycle()
    assert csp.statusword & FOLLOWS
    assert not csp.statusword & LIMIT
    assert csp.get(0x6062) == 1_000


@pytest.mark.parametrize(("lost", "follows"), [(0, False), (1, True)])
def test_a_lost_frame_gives_the_next_target_more_room(
    csp: VirtualDrive, lost: int, follows: bool
) -> None:
    for _ in range(lost):
        csp.step(1_000_000)
    csp.put(0x607A, 20_000)  # too much for one cycle, not for two
    csp.cycle()
    assert bool(csp.statusword & FOLLOWS) is follows
    assert (csp.get(0x6062) > 0) is follows


@pytest.mark.parametrize("period_ns", [1_000_000, 4_000_000])
def test_stopped_by_a_limit_switch_the_axis_takes_targets_from_where_it_stands(
    machine: Callable[..., Mechanics], period_ns: int
) -> None:
    """A master that went on with its targets begins again at 6064h, without switching off."""
    drive = VirtualDrive(machine(970_000), cycle=period_ns * 1e-9)
    drive.bring_up(AlState.SAFEOP)
    drive.bring_up(sync0_ns=period_ns)
    drive.enable(Mode.CYCLIC_POSITION)
    step = 200 * period_ns // 1_000_000
    for _ in range(1_000):
        drive.put(0x607A, drive.record.target_position + step)
        drive.cycle()
    stood = drive.position
    assert 30_000 <= stood < 40_000
    assert drive.statusword & (FOLLOWS | LIMIT) == LIMIT
    for n in range(200):
        drive.put(0x607A, stood - step * n)
        drive.cycle()
    assert drive.position == pytest.approx(stood - 199 * step, abs=50)
    assert drive.statusword & (FOLLOWS | LIMIT) == FOLLOWS


def test_targets_wrap_with_the_32_bit_counter() -> None:
    drive = VirtualDrive(parameters={0x607C: 2**31 - 500})
    drive.enable(Mode.CYCLIC_POSITION)
    for n in range(20):
        drive.put(0x607A, ((2**31 - 500 + 100 * n) + 2**31) % 2**32 - 2**31)
        drive.cycle()
    drive.run(0.2)
    assert abs(drive.position - (-(2**31) + 1_400)) <= 100
    assert abs(drive.get(0x60F4)) <= 100


def test_an_offset_feeds_the_velocity_forward() -> None:
    drive = VirtualDrive(parameters={0x2109: 0})
    drive.enable(Mode.CYCLIC_POSITION)
    drive.put(0x60B1, 200_000)
    for n in range(1_000):
        drive.put(0x607A, 200 * n)
        drive.cycle()
    assert abs(drive.get(0x60F4)) < 30


def test_following_error_bit(csp: VirtualDrive) -> None:
    csp.set(0x6065, 500)
    csp.faults.jam()
    for n in range(30):
        csp.put(0x607A, 100 * n)
        csp.cycle()
    assert csp.statusword & 0x2000


def test_sync0_sets_the_interpolation_period() -> None:
    drive = Drive()
    for state in (AlState.PREOP, AlState.SAFEOP, AlState.OP):
        assert drive.enter(state, 500_000, AlStatus.NO_ERROR) is AlStatus.NO_ERROR
    assert (drive.get(0x60C2, 1), drive.get(0x60C2, 2)) == (5, -4)
    assert drive.record.communication_cycle == pytest.approx(5e-4)


def test_controlword_bits_of_pp_do_nothing(csp: VirtualDrive) -> None:
    csp.control(0x27F, 5)
    assert csp.get(0x6062) == 0
