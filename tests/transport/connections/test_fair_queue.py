"""The fair queue: all work is done, in order, and anyone who asks for little does not wait."""

import random
from collections import deque
from collections.abc import Callable

from achse.transport.connections.fair_queue import SLICE_S, TURN_S, FairQueue


class Loop:
    """A loop whose time passes as work is done: what is due runs in rounds."""

    def __init__(self) -> None:
        self.now = 0.0
        self.due: deque[Callable[[], None]] = deque()

    def time(self) -> float:
        return self.now

    def call_soon(self, function: Callable[[], None]) -> None:
        self.due.append(function)

    def round(self) -> float:
        """One look at the sockets to the next; how long it took."""
        began = self.now
        for _ in range(len(self.due)):
            self.due.popleft()()
        return self.now - began


class Worker:
    """Jobs with their durations; notes when each is done."""

    def __init__(self, loop: Loop, host: str, jobs: list[float]) -> None:
        self.peer_host = host
        self._loop = loop
        self._jobs = deque(enumerate(jobs))
        self.done: list[int] = []

    def work(self, until: float) -> bool:
        while self._jobs:
            number, seconds = self._jobs.popleft()
            self._loop.now += seconds
            self.done.append(number)
            if self._loop.now >= until:
                break
        return not self._jobs


def served(scheduler: FairQueue, worker: Worker, loop: Loop) -> bool:
    return scheduler.serve(worker, loop.call_soon)


def test_little_is_done_at_once() -> None:
    loop = Loop()
    scheduler = FairQueue(loop.time)
    worker = Worker(loop, "a", [SLICE_S / 4] * 3)
    assert served(scheduler, worker, loop)
    assert (len(scheduler), loop.due) == (0, deque())


def test_much_is_done_slice_by_slice_and_never_longer_than_a_turn() -> None:
    loop = Loop()
    scheduler = FairQueue(loop.time)
    worker = Worker(loop, "a", [SLICE_S / 4] * 1000)
    assert not served(scheduler, worker, loop)
    assert loop.now <= 1.25 * SLICE_S
    while scheduler:
        assert loop.round() <= TURN_S + 1.25 * SLICE_S
    assert worker.done == list(range(1000))


def test_a_request_that_takes_long_is_done_all_the_same() -> None:
    loop = Loop()
    scheduler = FairQueue(loop.time)
    worker = Worker(loop, "a", [1.0, 1.0])
    assert not served(scheduler, worker, loop)
    loop.round()
    assert worker.done == [0, 1]
    assert len(scheduler) == 0


def test_a_host_does_not_wait_for_the_many_connections_of_another_one() -> None:
    loop = Loop()
    scheduler = FairQueue(loop.time)
    for _ in range(500):
        served(scheduler, Worker(loop, "many", [SLICE_S / 10] * 200), loop)
    assert loop.now <= 1.2 * SLICE_S, "only the first one of a host begins at once"
    for _ in range(50):
        loop.round()
        good = Worker(loop, "good", [SLICE_S / 10] * 3)
        began = loop.now
        assert served(scheduler, good, loop)
        assert loop.now - began <= SLICE_S


def test_whatever_comes_all_is_done_in_order_and_hosts_wait_for_hosts_alone() -> None:
    source = random.Random(20)
    for _ in range(30):
        loop = Loop()
        scheduler = FairQueue(loop.time)
        hosts = [f"host {number}" for number in range(source.randrange(1, 8))]
        longest = source.choice((0.0001, 0.001, 0.02))
        workers: list[Worker] = []
        jobs: dict[Worker, int] = {}
        for _ in range(200):
            if source.random() < 0.4:
                count = source.randrange(1, 80)
                worker = Worker(
                    loop,
                    source.choice(hosts),
                    [source.uniform(0.0, longest) for _ in range(count)],
                )
                workers.append(worker)
                jobs[worker] = count
                served(scheduler, worker, loop)
            elif loop.due:
                assert loop.round() <= TURN_S + SLICE_S + longest
        while scheduler:
            assert loop.round() <= TURN_S + SLICE_S + longest
        assert all(worker.done == list(range(jobs[worker])) for worker in workers)
        assert loop.due == deque()
