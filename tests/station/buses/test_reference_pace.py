"""Whatever the clocks do: frames come to their place, time never goes back, nothing runs away."""

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.station.buses.reference_pace import ReferencePace
from achse.station.clocks.pacing import Pace
from tests.station.buses.test_interface_bus import MS, BusRig, Interface, drives

CYCLES = 4000
EPOCH = 800_000_000_000_000_000


class Run:
    """A station in virtual wall time, whose frames pass a reference clock."""

    def __init__(self, cycle_ns: int, ppm: float, offset_ns: int, dice: Random) -> None:
        self.cycle_ns = cycle_ns
        self.rate = 1.0 + ppm * 1e-6
        self.offset_ns = offset_ns
        self.dice = dice
        self.pace = Pace(cycle_ns, 1.0, 5_000_000_000)
        self.controller = ReferencePace(cycle_ns)
        self.reference_ns = 0
        self.places: list[float] = []
        """Of each cycle's due moment in the cycle of the reference, ns from 0."""
        self.periods: list[int] = []
        self.answers: list[int] = []

    def reference(self, wall_ns: float) -> int:
        return EPOCH + self.offset_ns + int((wall_ns - 5_000_000_000) * self.rate)

    def go(self, cycles: int, jitter_ns: int = 0, lost: float = 0.0, gone: bool = False) -> None:
        pace, controller = self.pace, self.controller
        for _ in range(cycles):
            due = pace.due
            late = self.dice.randint(0, jitter_ns) if jitter_ns else 0
            assert pace.take(due + late)
            answer = controller.take(self.reference_ns)
            pace.shift(answer)
            if not gone and self.dice.random() >= lost:
                self.reference_ns = self.reference(due + late)
            place = self.reference(due) % self.cycle_ns
            self.places.append(place - self.cycle_ns if 2 * place > self.cycle_ns else place)
            self.periods.append(pace.due - due)
            self.answers.append(answer)


@settings(max_examples=12, deadline=None)
@given(
    cycle_us=st.sampled_from((250, 500, 1000, 2000, 4000)),
    ppm=st.floats(-200.0, 200.0) | st.floats(-900.0, 900.0),
    offset=st.floats(0.0, 1.0),
    jitter=st.floats(0.0, 0.1),
    lost=st.sampled_from((0.0, 0.01, 0.2)),
    restart=st.floats(0.0, 1.0),
    seed=st.integers(0, 2**32),
)
def test_frames_come_to_their_place_and_keep_it(
    cycle_us: int, ppm: float, offset: float, jitter: float, lost: float, restart: float, seed: int
) -> None:
    cycle = 1000 * cycle_us
    run = Run(cycle, ppm, round(offset * cycle), Random(seed))
    jitter_ns = round(jitter * cycle)
    for _ in range(2):
        run.go(CYCLES, jitter_ns, lost)
        places = run.places[-1000:]
        mean = sum(places) / len(places)
        # half of the jitter lies before the place, half behind it, and a part of it is clamped
        assert abs(mean + jitter_ns / 2) < cycle / 50 + jitter_ns / 2
        assert max(places) - min(places) < cycle / 50 + jitter_ns / 2
        if jitter_ns < cycle / 64:
            assert run.controller.settled
            assert abs(run.controller.drift_ppm + ppm) < 60.0 + 0.1 * abs(ppm)
        run.offset_ns += round(restart * cycle)  # the bus is started again, at another time
    assert all(abs(each - cycle) <= 0.004 * cycle for each in run.periods), "time goes on"
    assert len(run.periods) == 2 * CYCLES


@settings(max_examples=12, deadline=None)
@given(
    cycle_us=st.sampled_from((250, 1000, 4000)),
    ppm=st.floats(-5000.0, 5000.0),
    jitter=st.floats(0.0, 3.0),
    seed=st.integers(0, 2**32),
)
def test_a_clock_beyond_the_limits_and_one_that_is_gone_change_little(
    cycle_us: int, ppm: float, jitter: float, seed: int
) -> None:
    cycle = 1000 * cycle_us
    run = Run(cycle, ppm, 0, Random(seed))
    run.go(1000, min(round(jitter * cycle), 400_000_000))
    assert all(abs(each) <= 0.003 * cycle + 1 for each in run.answers)
    run.go(2_000_000_000 // cycle, gone=True)
    assert all(abs(each) <= 0.003 * cycle + 1 for each in run.answers)
    assert run.answers[-1] == 0
    assert run.controller.drift_ppm == 0.0
    assert not run.controller.settled
    run.go(10, gone=True)
    assert {abs(each - cycle) <= 1 for each in run.periods[-10:]} == {True}


def test_without_a_reference_nothing_moves() -> None:
    controller = ReferencePace(1_000_000)
    assert {controller.take(0) for _ in range(5000)} == {0}


def test_one_late_frame_moves_next_to_nothing() -> None:
    run = Run(1_000_000, 0.0, 0, Random(1))
    run.go(500)
    run.reference_ns = run.reference(run.pace.due) + 400_000
    before = len(run.answers)
    run.go(1)
    assert abs(run.answers[before]) <= 2_000
    run.go(300)
    assert abs(run.places[-1]) < 100


@pytest.mark.parametrize("leads", [True, False])
@pytest.mark.parametrize("ppm", [-180, 90])
def test_frames_keep_their_place_in_the_cycle_of_the_first_drive(
    monkeypatch: pytest.MonkeyPatch, leads: bool, ppm: int
) -> None:
    interface = Interface(1 * MS, drives(2))
    rig = BusRig(monkeypatch, interface, 2)
    rig.until(rig.operational)
    interface.segment.slaves[0].esc.clock.drift_ppb = 1000 * ppm

    def steer(by_ns: int) -> None:
        interface.now_ns += by_ns

    if leads:
        rig.bus.steer = steer
    else:
        monkeypatch.setattr(rig.bus, "steer", lambda by_ns: None)
    places = []
    for _ in range(300):
        rig.station.advance(0.02)
        places.append(rig.bus.reference.deviation_ns)
    if leads:
        assert rig.bus.reference.settled
        assert rig.bus.reference.drift_ppm == pytest.approx(-ppm, abs=20.0)
        assert max(map(abs, places[-50:])) < 5_000
    else:  # a millisecond in some seconds
        assert max(places) - min(places) > 400_000
        assert not rig.bus.reference.settled
    assert rig.operational()
