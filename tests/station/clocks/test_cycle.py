"""The cycle goes from due moment to due moment, in the order of the places."""

import math
import random
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station.clocks.cycle import Cycle, CyclicPhase, Phase, PhasePlace

Log = list[tuple[int, str]]


class Once(Phase):
    """A phase with something to do at one moment."""

    def __init__(self, place: PhasePlace, due_ns: float, act: Callable[[int], None]) -> None:
        self.place, self.name, self.act = place, "once", act
        self.due = due_ns

    @property
    def due_ns(self) -> float:
        return self.due

    def step(self, now_ns: int) -> None:
        self.due = math.inf
        self.act(now_ns)


class Counted(Phase):
    """A phase that catches up: how many of its cycles were done at each step."""

    place, name = PhasePlace.NC, "counted"
    catches_up = True
    due_ns = 0

    def __init__(self, cycle_ns: int) -> None:
        self.cycle_ns = cycle_ns
        self.count = 0
        self.steps: list[tuple[int, int]] = []

    def begin(self, earliest_ns: int) -> None:
        self.due_ns = -(-earliest_ns // self.cycle_ns) * self.cycle_ns

    def step(self, now_ns: int) -> None:
        count = (now_ns - self.due_ns) // self.cycle_ns + 1
        self.due_ns += count * self.cycle_ns
        self.count += count
        self.steps.append((now_ns, count))


def logged(log: Log, place: PhasePlace, cycle_ns: int) -> CyclicPhase:
    return CyclicPhase(place, place.name, cycle_ns, lambda now: log.append((now, place.name)))


def test_what_is_due_at_a_moment_goes_by_place_and_then_by_order_of_adding() -> None:
    log: Log = []
    cycle = Cycle(1)
    for place in reversed(PhasePlace):
        cycle.add(logged(log, place, 10))
    cycle.add(CyclicPhase(PhasePlace.NC, "second", 10, lambda now: log.append((now, "second"))))
    cycle.go_to(10)
    names = [place.name for place in PhasePlace]
    names.insert(names.index("NC") + 1, "second")
    assert log == [(10, name) for name in names]


def test_only_due_moments_are_gone_to_and_those_between_ticks_wait() -> None:
    log: Log = []
    cycle = Cycle(4)
    cycle.add(Once(PhasePlace.SCOPE, 9, lambda now: log.append((now, "once"))))
    cycle.add(logged(log, PhasePlace.PLC, 20))
    turns: list[int] = []
    cycle.add(Once(PhasePlace.UPKEEP, math.inf, turns.append))
    cycle.go_to(42)
    assert log == [(12, "once"), (20, "PLC"), (40, "PLC")]
    assert cycle.now_ns == 42


@pytest.mark.parametrize("seed", range(20))
def test_going_on_in_one_go_is_going_on_tick_by_tick(seed: int) -> None:
    """Whatever the cycles, and no matter who comes before or behind the phase that catches up."""
    draw = random.Random(seed)
    tick = draw.choice((1, 5, 7))
    wanted = [(draw.choice(list(PhasePlace)), tick * draw.randint(1, 12)) for _ in range(4)]
    moments = [(draw.choice(list(PhasePlace)), draw.randint(1, 400)) for _ in range(5)]
    follower_cycle = tick * draw.randint(1, 5)
    end = tick * draw.randint(50, 100)
    histories = []
    for by_tick in (True, False):
        cycle = Cycle(tick)
        follower = Counted(follower_cycle)
        log: list[tuple[int, str, int]] = []

        def note(
            name: str, log: list[tuple[int, str, int]] = log, follower: Counted = follower
        ) -> Callable[[int], None]:
            return lambda now: log.append((now, name, follower.count))

        for number, (place, cycle_ns) in enumerate(wanted):
            name = f"{number} {place.name}"
            cycle.add(CyclicPhase(place, name, cycle_ns, note(name)))
        for place, moment in moments:
            cycle.add(Once(place, moment, note("once")))
        cycle.add(follower)
        while by_tick and cycle.now_ns < end:
            cycle.step()
        cycle.go_to(end)
        histories.append((log, follower.count, cycle.now_ns))
    assert histories[0] == histories[1]
    assert histories[0][1] == end // follower_cycle


def test_a_phase_that_catches_up_is_queried_once_for_the_time_between() -> None:
    log: Log = []
    cycle = Cycle(1)
    follower = Counted(2)
    cycle.add(follower)
    cycle.add(logged(log, PhasePlace.PLC, 10))
    cycle.go_to(20)
    assert follower.steps == [(10, 5), (20, 5)]
    cycle.add(Once(PhasePlace.FAULTS, 25, lambda now: log.append((now, "fault"))))
    cycle.go_to(30)
    assert follower.steps[2:] == [(24, 2), (30, 3)]
    assert follower.count == 15


def test_after_a_change_of_state_the_rest_of_the_moment_is_that_of_the_new_phases() -> None:
    log: Log = []
    cycle = Cycle(1)
    old, new = (
        logged(log, PhasePlace.NC, 5),
        CyclicPhase(PhasePlace.NC, "new", 5, lambda now: log.append((now, "new"))),
    )
    cycle.add(old)
    cycle.add(logged(log, PhasePlace.SCOPE, 5))
    cycle.add(Once(PhasePlace.CHANGES, 10, lambda now: cycle.replace((old,), (new,))))
    cycle.go_to(15)
    assert [entry for entry in log if entry[1] != "SCOPE"] == [(5, "NC"), (10, "new"), (15, "new")]
    assert [now for now, name in log if name == "SCOPE"] == [5, 10, 15]


def test_a_phase_added_between_two_moments_begins_with_the_next() -> None:
    log: Log = []
    cycle = Cycle(5)
    cycle.go_to(10)
    late = logged(log, PhasePlace.PLC, 5)
    cycle.add(late)
    cycle.step()
    cycle.remove(late)
    cycle.remove(late)
    cycle.step()
    assert log == [(15, "PLC")]
    assert cycle.phases == ()


def test_halt_ends_the_going_after_the_moment() -> None:
    log: Log = []
    cycle = Cycle(1)
    cycle.add(Once(PhasePlace.NC, 3, lambda now: cycle.halt()))
    cycle.add(logged(log, PhasePlace.SCOPE, 1))
    cycle.go_to(10)
    assert cycle.now_ns == 3
    assert log[-1] == (3, "SCOPE")
    cycle.go_to(10)
    assert cycle.now_ns == 10


def test_a_late_request_is_done_with_the_next_tick() -> None:
    log: Log = []
    cycle = Cycle(5)
    late = Once(PhasePlace.FAULTS, math.inf, lambda now: log.append((now, "late")))
    cycle.add(late)
    cycle.add(Once(PhasePlace.SCOPE, 10, lambda now: setattr(late, "due", 7)))
    cycle.go_to(30)
    assert log == [(15, "late")]


def test_a_cycle_takes_time() -> None:
    with pytest.raises(ValueError, match="phase mine: expected a cycle above 0 ns, got 0"):
        CyclicPhase(PhasePlace.NC, "mine", 0, print)


class Ahead(CyclicPhase):
    """A phase that does several of its steps at once, with those of `counted`."""

    runs_ahead = True

    def __init__(self, cycle_ns: int, counted: Counted, log: Log, most: int) -> None:
        super().__init__(
            PhasePlace.NOTIFICATIONS, "ahead", cycle_ns, lambda now: log.append((now, "ahead"))
        )
        self.counted, self.log, self.most = counted, log, most
        self.runs = 0

    def run_ahead(self, now_ns: int, latest_ns: int) -> int:
        assert now_ns < self.due_ns <= latest_ns
        done = 0
        while self.due_ns <= latest_ns and done < self.most:
            if self.counted.due_ns <= self.due_ns:
                self.counted.step(self.due_ns)
            self.log.append((self.due_ns, "ahead"))
            self.due_ns += self.cycle_ns
            done += 1
        self.runs += done
        return self.due_ns - self.cycle_ns if done else 0


@given(
    st.lists(st.tuples(st.sampled_from(PhasePlace), st.integers(1, 30)), max_size=3),
    st.integers(1, 20),
    st.integers(1, 20),
    st.integers(0, 4),
    st.lists(st.integers(1, 90), min_size=1, max_size=4),
)
def test_a_phase_that_runs_ahead_does_not_pass_the_steps_of_others(
    others: list[tuple[PhasePlace, int]],
    counted_ns: int,
    ahead_ns: int,
    most: int,
    spans: list[int],
) -> None:
    logs: list[tuple[Log, int, int]] = []
    for room in (0, most):
        log: Log = []
        cycle = Cycle(1)
        counted = Counted(counted_ns)
        cycle.add(counted)
        cycle.add(Ahead(ahead_ns, counted, log, room))
        for place, cycle_ns in others:
            cycle.add(logged(log, place, cycle_ns))
        for span in spans:
            cycle.go_to(cycle.now_ns + span)
            log.append((cycle.now_ns, str(counted.count)))
        logs.append((log, counted.count, cycle.now_ns))
    assert logs[0] == logs[1]


def test_a_phase_runs_ahead_up_to_the_end() -> None:
    cycle, counted = Cycle(1), Counted(2)
    log: Log = []
    ahead = Ahead(10, counted, log, 1000)
    cycle.add(counted)
    cycle.add(ahead)
    cycle.go_to(95)
    assert (ahead.runs, counted.count, cycle.now_ns) == (9, 47, 95)
    cycle.go_to(100)
    assert (ahead.runs, counted.count, log[-1]) == (10, 50, (100, "ahead"))
