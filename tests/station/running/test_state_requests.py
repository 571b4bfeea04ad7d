"""Changes of state that clients request, through the system service, in virtual time."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AdsState, AmsAddress, Command, Frame
from achse.ams.commands import WriteControlRequest
from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.station_file import parse
from achse.station.running.state_requests import LONGEST_RUN_NS, MAX_WAITING

MS = 1_000_000
RESET = (AdsState.RESET, 1, b"")
CONFIG = (AdsState.RECONFIG, 0, b"")


class Watched:
    """A station without tasks, its state after each millisecond, and a client of port 10000."""

    def __init__(self, restart_ms: int = 500) -> None:
        self.station = Station(parse({"system": {"restart_time": f"{restart_ms}ms"}}, ""))
        self.station.cycle.add(CyclicPhase(PhasePlace.UPKEEP, "watch", MS, self._look))
        self.states: list[AdsState] = []
        self.answers: list[tuple[int, int, AdsState]] = []
        """Error, result and the state of the station when each answer came."""
        self.router = self.station.router
        self.address = self.router.register(0, self)
        self.system = AmsAddress.of(self.router.net_id, 10_000)

    def _look(self, _: int) -> None:
        self.states.append(self.station.state)

    def deliver(self, frame: Frame) -> bool:
        result = int.from_bytes(frame.data[:4], "little")
        self.answers.append((frame.error, result, self.station.state))
        return True

    def ask(self, state: AdsState, device_state: int = 1, data: bytes = b"") -> None:
        request = WriteControlRequest(state, device_state, data).encode()
        self.router.deliver(Frame(self.system, self.address, Command.WRITE_CONTROL, data=request))

    def advance(self, ms: int) -> None:
        self.station.cycle.go_to(self.station.time_ns + ms * MS)

    @property
    def index(self) -> int:
        """Restarts so far."""
        return self.station._states.system.restart_index

    def phases(self) -> list[tuple[AdsState, int]]:
        """States with the milliseconds that each lasted, in order."""
        phases: list[tuple[AdsState, int]] = []
        for state in self.states:
            last, length = phases.pop() if phases and phases[-1][0] is state else (state, 0)
            phases.append((last, length + 1))
        return phases


def test_resets_faster_than_a_restart_do_not_keep_the_station_out_of_run() -> None:
    watched = Watched()
    for _ in range(40):
        watched.ask(*RESET)
        watched.advance(350)
    assert watched.index == 14
    assert watched.states.count(AdsState.RUN) >= len(watched.states) // 2
    assert {answer[:2] for answer in watched.answers} == {(0, 0)}


def test_a_reset_during_a_restart_is_answered_at_once_and_merged() -> None:
    watched = Watched()
    for _ in range(3):
        watched.ask(*RESET)
        watched.advance(100)
    assert watched.answers == [(0, 0, AdsState.STOP)] * 3
    watched.advance(205)
    assert (watched.station.state, watched.index) == (AdsState.RUN, 1)


def test_a_reset_soon_after_a_restart_is_answered_when_it_begins() -> None:
    watched = Watched()
    watched.ask(*RESET)
    watched.advance(600)
    watched.ask(*RESET)
    watched.ask(*RESET)
    watched.advance(395)
    assert (len(watched.answers), watched.station.state) == (1, AdsState.RUN)
    watched.advance(10)
    assert watched.answers[1:] == [(0, 0, AdsState.STOP)] * 2
    watched.advance(600)
    assert (watched.station.state, watched.index) == (AdsState.RUN, 2)


def test_a_station_is_kept_in_run_for_a_second_at_most() -> None:
    watched = Watched(restart_ms=30_000)
    watched.ask(*RESET)
    watched.advance(30_100)
    watched.ask(*RESET)
    watched.advance(LONGEST_RUN_NS // MS)
    assert watched.station.state is AdsState.STOP


def test_requests_that_wait_have_a_limit() -> None:
    watched = Watched()
    watched.ask(*RESET)
    watched.advance(600)
    for _ in range(MAX_WAITING + 2):
        watched.ask(*RESET)
    assert watched.answers[1:] == [(0, 0x708, AdsState.RUN)] * 2
    watched.advance(500)
    assert len(watched.answers) == MAX_WAITING + 3
    assert watched.index == 1


def test_the_last_of_the_requests_that_wait_decides() -> None:
    watched = Watched()
    watched.ask(*RESET)
    watched.advance(600)
    watched.ask(*RESET)
    watched.ask(*CONFIG)
    watched.advance(1000)
    assert watched.station.state is AdsState.CONFIG


def test_planned_restarts_are_merged_into_the_earliest() -> None:
    watched = Watched()
    for seconds in (5, 2, 9):
        watched.ask(AdsState.SHUTDOWN, 1, seconds.to_bytes(4, "little"))
    assert len(watched.station._states._changes.plans) == 1
    watched.advance(12_000)
    assert (watched.station.state, watched.index) == (AdsState.RUN, 1)


ORDERS: list[Any] = [RESET, CONFIG, (AdsState.SHUTDOWN, 1, bytes(4))]
STEPS = st.lists(st.tuples(st.sampled_from(ORDERS), st.integers(0, 60)), min_size=1, max_size=12)


@given(mixed=st.booleans(), restart_ms=st.integers(0, 40), steps=STEPS)
def test_whatever_is_requested_each_run_lasts_and_each_request_is_answered(
    mixed: bool, restart_ms: int, steps: list[tuple[Any, int]]
) -> None:
    watched = Watched(restart_ms)
    for order, pause in steps:
        watched.ask(*(order if mixed else RESET))
        watched.advance(pause)
    watched.advance(4 * restart_ms + 5)
    assert len(watched.answers) == len(steps)
    assert {answer[:2] for answer in watched.answers} == {(0, 0)}
    parts = watched.phases()
    runs = [length for state, length in parts[1:-1] if state is AdsState.RUN]
    stops = [length for state, length in parts if state is AdsState.STOP]
    assert all(length >= restart_ms for length in runs)
    assert all(length <= restart_ms + 1 for length in stops)
    if not mixed:
        assert watched.station.state is AdsState.RUN
