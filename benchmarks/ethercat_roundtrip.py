"""Round trips over veth pairs: drives of `achse drive serve` beside a bare reflector of frames.

pysoem is the master of both: with a cycle of 1 ms it exchanges the same process data with the
drives in machine code, in Op, and with a process that sends each frame back as it came. They take
turns in each cycle, so both meet the same moments of the machine; each has a cable of its own.
Printed are medians and tails of both. A reply after more than a cycle is late.

Runs in a network namespace of its own (Linux, root or user namespaces), in real time where allowed.
Usage: python benchmarks/ethercat_roundtrip.py [SECONDS [COUNT…]]
"""

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator

import pysoem

from achse.station.clocks.priority import answer_promptly
from achse.transport.ethernet import EthernetLink

DRIVES_CABLE, BARE_CABLE = ("cable0", "cable1"), ("cable2", "cable3")
CABLES = " && ".join(
    f"ip link add {near} type veth peer name {far} && ip link set {near} up && ip link set {far} up"
    for near, far in (DRIVES_CABLE, BARE_CABLE)
)
COUNTS = (1, 8, 32)
CYCLE_S = 0.001
MASTER_PRIORITY = 40
PATIENCE_US = 20_000


@contextlib.contextmanager
def reflector() -> Iterator[None]:
    """A process that sends each frame back as it came."""
    child = os.fork()
    if child == 0:
        link = EthernetLink(BARE_CABLE[1])
        answer_promptly()
        while True:
            link.exchange(lambda frame: frame, 1.0)
    try:
        time.sleep(0.5)
        yield
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)


@contextlib.contextmanager
def drives(count: int, end: str) -> Iterator[None]:
    """So many drives at that end of a cable."""
    command = [sys.executable, "-m", "achse", "drive", "serve", "--interface", end]
    with subprocess.Popen(
        [*command, "--count", str(count), "--control", "none"], stdout=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline().startswith("achse drive ready")
        yield
        run.terminate()


@contextlib.contextmanager
def master_at(end: str, count: int) -> Iterator[pysoem.Master]:
    """A master that has found so many drives and laid out their process data."""
    master = pysoem.Master()
    master.open(end)
    try:
        assert master.config_init() == count
        master.config_map()
        assert master.state_check(pysoem.SAFEOP_STATE, 500_000) == pysoem.SAFEOP_STATE
        yield master
    finally:
        master.close()


class Trips:
    """Exchanges of one master: microseconds of each, and in how many a drive did not take part."""

    def __init__(self, master: pysoem.Master) -> None:
        self.master = master
        self.times: list[float] = []
        self.missed = 0

    def exchange(self) -> None:
        started = time.perf_counter_ns()
        self.master.send_processdata()
        counter = self.master.receive_processdata(PATIENCE_US)
        self.times.append((time.perf_counter_ns() - started) / 1000.0)
        self.missed += counter != self.master.expected_wkc

    def at(self, part: float) -> float:
        """The time that such a part of the exchanges did not exceed."""
        ordered = sorted(self.times)
        return ordered[min(int(part * len(ordered)), len(ordered) - 1)]


def alternate(count: int, seconds: float) -> tuple[Trips, Trips]:
    """What the reflector and the drives did in the same cycles."""
    with contextlib.ExitStack() as stack:
        with drives(count, BARE_CABLE[1]):  # for this master to know its process data
            bare = Trips(stack.enter_context(master_at(BARE_CABLE[0], count)))
        stack.enter_context(reflector())
        stack.enter_context(drives(count, DRIVES_CABLE[1]))
        served = Trips(stack.enter_context(master_at(DRIVES_CABLE[0], count)))
        served.exchange()
        served.master.state = pysoem.OP_STATE
        served.master.write_state()
        assert served.master.state_check(pysoem.OP_STATE, 500_000) == pysoem.OP_STATE
        for trips in (bare, served):
            trips.exchange()
            trips.times.clear()
        missed = served.missed
        cycles(bare, served, seconds)
        served.missed -= missed
        served.master.read_state()
        assert all(slave.state == pysoem.OP_STATE for slave in served.master.slaves)
        served.master.state = pysoem.INIT_STATE
        served.master.write_state()
    return bare, served


def cycles(bare: Trips, served: Trips, seconds: float) -> None:
    """Both exchange once a cycle, each as often first."""
    turns = (bare, served), (served, bare)
    begin = time.perf_counter()
    number = 0
    while number * CYCLE_S < seconds:
        number += 1
        wait = begin + number * CYCLE_S - time.perf_counter()
        if wait > 0:
            time.sleep(wait)
        else:
            begin -= wait  # the master itself was held up
        for trips in turns[number % 2]:
            trips.exchange()


def measure(seconds: float, counts: list[int]) -> None:
    with contextlib.suppress(OSError):
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(MASTER_PRIORITY))
    print("µs of a round trip: reflector, then drives, in the same cycles")
    heads = ("p50", "99.9 %", "most")
    print(f"{'drives':>6}" + "".join(f" {head:>8}" for head in heads * 2), end="")
    print(f" {'ratio p50':>10} {'99.9 %':>7} {'cycles':>7} {'late':>11} {'missed':>6}")
    for count in counts:
        bare, served = alternate(count, seconds)
        tails = [[trips.at(part) for part in (0.5, 0.999, 1.0)] for trips in (bare, served)]
        late = ", ".join(
            str(sum(trip > 1e6 * CYCLE_S for trip in trips.times)) for trips in (bare, served)
        )
        print(f"{count:>6}" + "".join(f" {each:>8.1f}" for tail in tails for each in tail), end="")
        print(f" {tails[1][0] / tails[0][0]:>10.2f} {tails[1][1] / tails[0][1]:>7.2f}", end="")
        print(f" {len(served.times):>7} {late:>11} {served.missed:>6}", flush=True)


def main() -> None:
    arguments = sys.argv[1:] or ["5"]
    if os.environ.get("ACHSE_IN_NAMESPACE"):
        measure(float(arguments[0]), [int(count) for count in arguments[1:]] or list(COUNTS))
        return
    user = [] if os.geteuid() == 0 else ["--map-root-user"]
    inner = ["sh", "-c", f'{CABLES} && exec "$@"', "sh", sys.executable, __file__, *arguments]
    environment = {**os.environ, "ACHSE_IN_NAMESPACE": "1"}
    sys.exit(subprocess.call(["unshare", *user, "--net", *inner], env=environment))


if __name__ == "__main__":
    main()
