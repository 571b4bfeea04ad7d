"""Actions at a station time; the queue is a phase of the cycle only while it has some."""

from achse.station.clocks.cycle import Cycle
from achse.station.clocks.timer_queue import TimerQueue


def test_actions_happen_in_the_order_of_their_times_then_of_adding() -> None:
    cycle = Cycle(10)
    timer_queue = TimerQueue(cycle)
    calls: list[tuple[int, str]] = []
    for due, name in ((35, "c"), (20, "a"), (20, "b")):
        timer_queue.add(due, lambda name=name: calls.append((cycle.now_ns, name)))  # type: ignore[misc]
    assert timer_queue in cycle.phases
    cycle.go_to(100)
    assert calls == [(20, "a"), (20, "b"), (40, "c")]
    assert cycle.phases == ()


def test_an_action_may_add_another() -> None:
    cycle = Cycle(10)
    timer_queue = TimerQueue(cycle)
    calls: list[int] = []
    timer_queue.add(10, lambda: timer_queue.add(30, lambda: calls.append(cycle.now_ns)))
    cycle.go_to(100)
    assert calls == [30]


def test_what_is_over_happens_with_the_next_tick() -> None:
    cycle = Cycle(10)
    timer_queue = TimerQueue(cycle)
    cycle.go_to(50)
    calls: list[int] = []
    timer_queue.add(20, lambda: calls.append(cycle.now_ns))
    cycle.go_to(100)
    assert calls == [60]


def test_what_is_forgotten_does_not_happen() -> None:
    cycle = Cycle(10)
    timer_queue = TimerQueue(cycle)
    calls: list[str] = []

    def never() -> None:
        calls.append("never")

    timer_queue.add(10, lambda: timer_queue.forget(never))
    timer_queue.add(30, never)
    cycle.go_to(100)
    timer_queue.add(130, never)
    timer_queue.add(120, lambda: calls.append("once"))
    timer_queue.forget(never)
    timer_queue.forget(never)
    cycle.go_to(200)
    assert calls == ["once"]
    assert cycle.phases == ()
