"""Actions at a station time; the agenda is part of the cycle only as long as it has some."""

from achse.station.clocks.agenda import Agenda
from achse.station.clocks.cycle import Cycle


def test_actions_happen_in_the_order_of_their_times_then_of_adding() -> None:
    cycle = Cycle(10)
    agenda = Agenda(cycle)
    told: list[tuple[int, str]] = []
    for due, name in ((35, "c"), (20, "a"), (20, "b")):
        agenda.add(due, lambda name=name: told.append((cycle.now_ns, name)))  # type: ignore[misc]
    assert agenda in cycle.phases
    cycle.go_to(100)
    assert told == [(20, "a"), (20, "b"), (40, "c")]
    assert cycle.phases == ()


def test_an_action_may_add_another() -> None:
    cycle = Cycle(10)
    agenda = Agenda(cycle)
    told: list[int] = []
    agenda.add(10, lambda: agenda.add(30, lambda: told.append(cycle.now_ns)))
    cycle.go_to(100)
    assert told == [30]


def test_what_is_over_happens_with_the_next_tick() -> None:
    cycle = Cycle(10)
    agenda = Agenda(cycle)
    cycle.go_to(50)
    told: list[int] = []
    agenda.add(20, lambda: told.append(cycle.now_ns))
    cycle.go_to(100)
    assert told == [60]


def test_what_is_forgotten_does_not_happen() -> None:
    cycle = Cycle(10)
    agenda = Agenda(cycle)
    told: list[str] = []

    def never() -> None:
        told.append("never")

    agenda.add(10, lambda: agenda.forget(never))
    agenda.add(30, never)
    cycle.go_to(100)
    agenda.add(130, never)
    agenda.add(120, lambda: told.append("once"))
    agenda.forget(never)
    agenda.forget(never)
    cycle.go_to(200)
    assert told == ["once"]
    assert cycle.phases == ()
