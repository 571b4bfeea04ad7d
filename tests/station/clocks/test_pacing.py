import asyncio

import pytest

from achse.motion import AxisParameters, Nc
from achse.station.clocks.pacing import REBASE_NS, NcTask, Pace, Pacer, run_unpaced

MS = 1_000_000


def due_ticks(pace: Pace, now: int) -> int:
    count = 0
    while pace.take(now):
        count += 1
    return count


def test_no_tick_is_due_before_its_moment() -> None:
    pace = Pace(2 * MS, 1.0, now=0)
    assert not pace.take(2 * MS - 1)
    assert pace.take(2 * MS)
    assert not pace.take(2 * MS)


def test_late_ticks_are_caught_up_and_counted() -> None:
    pace = Pace(2 * MS, 1.0, now=0)
    assert due_ticks(pace, 21 * MS) == 10
    assert pace.late_ticks == 9 - 1 + 1  # those due at 2..18 ms are more than one tick late


@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_pace_keeps_the_lateness_of_the_latest_tick(speed: float) -> None:
    pace = Pace(2 * MS, speed, now=0)
    for late in (3_000, 500_000, 7_000):
        assert pace.take(pace.due + late)
        if late == 500_000:
            assert pace.latest_ns == late
    assert (pace.behind_ns, pace.latest_ns) == (7_000 * speed, 500_000)
    assert pace.tick_ns == 2 * MS / speed


@pytest.mark.parametrize(("speed", "ticks"), [(0.5, 250), (1.0, 500), (20.0, 10_000)])
def test_speed_scales_the_wall_clock(speed: float, ticks: int) -> None:
    pace = Pace(2 * MS, speed, now=0)
    assert due_ticks(pace, 1000 * MS) == ticks


@pytest.mark.parametrize("by_ns", [-5_000, 0, 7_000, -MS])
def test_a_shift_moves_what_is_to_come_and_never_below_half_a_tick(by_ns: int) -> None:
    pace = Pace(MS, 1.0, now=0)
    before = pace.due
    for _ in range(1000):
        assert pace.take(pace.due)
        due = pace.due
        pace.shift(by_ns)
        assert pace.due - before >= MS // 2
        assert pace.due == due + max(by_ns, -MS // 2)
        before = pace.due
    assert pace.due == 1001 * MS + 1000 * max(by_ns, -MS // 2)
    assert pace.late_ticks == 0


def test_shifts_before_one_tick_count_together() -> None:
    pace = Pace(MS, 1.0, now=0)
    assert pace.take(MS)
    for by_ns in (-400_000, 100_000, -400_000, -400_000):
        pace.shift(by_ns)
    assert pace.due == 2 * MS - MS // 2


def test_rounding_does_not_accumulate() -> None:
    pace = Pace(MS, 3.0, now=0)
    assert sum(due_ticks(pace, now * MS) for now in range(1, 1001)) == 3000


def test_a_pace_too_far_behind_starts_again() -> None:
    pace = Pace(2 * MS, 1.0, now=0)
    late = 2 * MS + REBASE_NS + 1
    assert not pace.take(late)
    assert pace.rebases == 1
    assert pace.due == late + 2 * MS


def test_a_speed_must_be_positive() -> None:
    with pytest.raises(ValueError, match="above 0, got 0"):
        Pace(MS, 0, now=0)


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_late_cycles_of_the_nc_are_counted(speed: float) -> None:
    """Ticks of 1 ms, cycles of 2 ms: late is what begins more than 2 ms of station time late."""
    nc = Nc(2 * MS, [AxisParameters(1)])
    pace = Pace(MS, speed, now=0)
    task = NcTask(nc, lambda: pace)
    for due, began in ((2, 2.0), (4, 5.9), (6, 8.1), (8, 10.1), (10, 11.0)):
        while pace.due < round(due * MS / speed):
            pace.take(pace.due)
        assert pace.take(round(began * MS / speed))
        task.run(due * MS)
    assert (nc.cycle_count, nc.late_cycles, nc.late_io_cycles) == (5, 2, 2)


def test_the_computing_time_of_the_nc_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    nc = Nc(2 * MS, [AxisParameters(1)])
    times = iter((1_000_000, 1_123_456))
    monkeypatch.setattr("achse.station.clocks.pacing.time.perf_counter_ns", lambda: next(times))
    NcTask(nc, lambda: Pace(MS, 1.0, now=0)).run(0)
    assert nc.computing_time_us == 123


def test_in_virtual_time_nothing_is_late_or_takes_time() -> None:
    nc = Nc(2 * MS, [AxisParameters(1)])
    NcTask(nc, lambda: None).run(2 * MS)
    assert (nc.cycle_count, nc.late_cycles, nc.late_io_cycles, nc.computing_time_us) == (1, 0, 0, 0)


async def first_of(pacer: Pacer, done: asyncio.Event) -> None:
    async with pacer:
        await done.wait()


def test_the_pacer_calls_the_step_from_the_loop() -> None:
    async def main() -> None:
        done = asyncio.Event()
        calls: list[asyncio.AbstractEventLoop] = []

        def step() -> None:
            calls.append(asyncio.get_running_loop())
            if len(calls) == 5:
                done.set()

        await first_of(Pacer(step, MS), done)
        assert set(calls) == {asyncio.get_running_loop()}

    asyncio.run(main())


def test_a_step_that_raises_ends_the_pacing() -> None:
    async def main() -> None:
        def step() -> None:
            raise ArithmeticError("broken cycle")

        async with Pacer(step, MS) as pacer:
            with pytest.raises(ArithmeticError, match="broken cycle"):
                await pacer.failed()

    asyncio.run(main())


def test_unpaced_running_stops_at_the_very_step() -> None:
    steps: list[int] = []
    asyncio.run(run_unpaced(lambda: steps.append(1), lambda: len(steps) == 12_345))
    assert len(steps) == 12_345
