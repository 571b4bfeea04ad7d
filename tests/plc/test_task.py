"""A task's grid of cycles and its counters."""

import pytest

from achse.plc.task import Task


def test_a_cycle_makes_the_calls_in_order() -> None:
    calls: list[str] = []
    task = Task()
    task.calls = [lambda: calls.append("A"), lambda: calls.append("B")]
    task.cycle()
    task.cycle()
    assert calls == ["A", "B", "A", "B"]


def test_cycles_lie_on_multiples_of_the_cycle_time() -> None:
    task = Task(cycle_ns=10)
    task.begin()
    assert (task.time_ns, task.due_ns) == (10, 20)
    task.skip(19)
    assert task.due_ns == 20
    task.skip(35)
    assert task.due_ns == 40
    task.skip(40)
    assert task.due_ns == 50


def test_the_first_cycle_flag_is_up_during_the_first_cycle_only() -> None:
    seen: list[bool] = []
    task = Task()
    task.calls = [lambda: seen.append(task.first_cycle)]
    task.cycle()
    task.cycle()
    assert seen == [True, False]


def test_an_error_comes_through_and_ends_the_cycle() -> None:
    seen: list[int] = []
    task = Task()
    task.calls = [lambda: 1 // 0, lambda: seen.append(1)]
    with pytest.raises(ZeroDivisionError):
        task.cycle()
    assert seen == []


def test_a_stopwatch_gives_execution_time_and_exceeded_cycles() -> None:
    times = iter([0, 500, 1000, 2001])
    task = Task(cycle_ns=1000)
    task.cycle(lambda: next(times))
    assert (task.last_exec_ns, task.exceeded, task.exceed_count) == (500, False, 0)
    task.cycle(lambda: next(times))
    assert (task.last_exec_ns, task.exceeded, task.exceed_count) == (1001, True, 1)
    task.clear_counters()
    assert (task.last_exec_ns, task.exceeded, task.exceed_count) == (0, False, 0)


def test_the_cycle_counter_wraps_at_32_bits() -> None:
    task = Task()
    task.cycle_count = 0xFFFF_FFFF
    task.begin()
    assert task.cycle_count == 0


@pytest.mark.parametrize(
    ("options", "complaint"),
    [({"cycle_ns": 0}, "got 0"), ({"cycle_ns": -5}, "got -5"), ({"priority": 256}, "got 256")],
)
def test_a_task_refuses_what_cannot_run(options: dict[str, int], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Task("Fast", **options)  # type: ignore[arg-type]


def test_cycles_in_a_row_that_take_too_long_are_counted() -> None:
    times = iter([0, 20, 20, 40, 40, 45, 50, 70])
    task = Task("T", 10, watchdog_cycles=2)
    counts = []
    for _ in range(4):
        task.begin()
        task.cycle(lambda: next(times))
        counts.append(task.exceeds_in_a_row)
    assert counts == [1, 2, 0, 1]
    assert task.exceed_count == 3
    task.clear_counters()
    assert task.exceeds_in_a_row == 0
