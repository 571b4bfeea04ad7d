"""Round trips over a veth pair: drives of `achse drive serve` beside a bare reflector of frames.

On one end is a master with a cycle of 1 ms, on the other the drives in machine code, or a process
that sends each frame back as it came. pysoem brings the drives to Op and exchanges; a raw socket
sends the reflector a frame of the same length. A reply after more than a cycle is late.

Runs in a network namespace of its own (Linux, root or user namespaces), in real time where allowed.
Usage: python benchmarks/ethercat_roundtrip.py [SECONDS [COUNT…]]
"""

import contextlib
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pysoem

from achse.station.fieldbus import answer_promptly
from achse.transport.ethernet import EthernetLink

ENDS = ("cable0", "cable1")
CABLE = (
    f"ip link add {ENDS[0]} type veth peer name {ENDS[1]}"
    f" && ip link set {ENDS[0]} up && ip link set {ENDS[1]} up"
)
COUNTS = (1, 8, 32)
CYCLE_S = 0.001
MASTER_PRIORITY = 40
HEAD, PER_DRIVE = 14 + 2 + 12, 15 + 23


@contextlib.contextmanager
def reflector() -> Iterator[None]:
    """A process that sends each frame back as it came."""
    child = os.fork()
    if child == 0:
        link = EthernetLink(ENDS[1])
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
def drives(count: int) -> Iterator[None]:
    """So many drives."""
    command = [sys.executable, "-m", "achse", "drive", "serve", "--interface", ENDS[1]]
    with subprocess.Popen(
        [*command, "--count", str(count), "--control", "none"], stdout=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline().startswith("achse drive ready")
        yield
        run.terminate()


def cycles(exchange: Callable[[], object], seconds: float) -> list[float]:
    """Microseconds of each exchange, one a cycle, ascending."""
    found = []
    begin = time.perf_counter()
    number = 0
    while number * CYCLE_S < seconds:
        number += 1
        wait = begin + number * CYCLE_S - time.perf_counter()
        if wait > 0:
            time.sleep(wait)
        else:
            begin -= wait  # the master itself was held up
        started = time.perf_counter_ns()
        exchange()
        found.append((time.perf_counter_ns() - started) / 1000.0)
    return sorted(found)


def by_socket(size: int, seconds: float) -> list[float]:
    frame = (b"\xff" * 6 + b"\x02\0\0\0\0\0" + b"\x88\xa4").ljust(size, b"\0")
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4)) as master:
        master.bind((ENDS[0], 0x88A4))
        master.settimeout(1.0)

        def exchange() -> None:
            master.send(frame)
            master.recv(2048)

        return cycles(exchange, seconds)


def by_pysoem(count: int, seconds: float) -> tuple[list[float], int]:
    """Round trips, and in how many a drive did not take part."""
    missed = 0
    master = pysoem.Master()
    master.open(ENDS[0])
    try:
        assert master.config_init() == count
        master.config_map()
        assert master.state_check(pysoem.SAFEOP_STATE, 500_000) == pysoem.SAFEOP_STATE
        expected = master.expected_wkc

        def exchange() -> None:
            nonlocal missed
            master.send_processdata()
            missed += master.receive_processdata(20_000) != expected

        exchange()
        master.state = pysoem.OP_STATE
        master.write_state()
        assert master.state_check(pysoem.OP_STATE, 500_000) == pysoem.OP_STATE
        found = cycles(exchange, seconds)
        master.read_state()
        assert all(slave.state == pysoem.OP_STATE for slave in master.slaves)
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
    return found, missed


def measure(seconds: float, counts: list[int]) -> None:
    with contextlib.suppress(OSError):
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(MASTER_PRIORITY))
    print(f"{'drives':>6} {'reflector p50 µs':>17} {'drives p50 µs':>14} {'ratio':>6}", end="")
    print(f" {'99.9 % µs':>10} {'most µs':>8} {'cycles':>7} {'late':>9} {'missed':>6}")
    for count in counts:
        with reflector():
            bare = statistics.median(by_socket(HEAD + count * PER_DRIVE, min(seconds, 5.0)))
        with drives(count):
            trips, missed = by_pysoem(count, seconds)
        median = statistics.median(trips)
        late = sum(trip > 1e6 * CYCLE_S for trip in trips)
        print(f"{count:>6} {bare:>17.1f} {median:>14.1f} {median / bare:>6.2f}", end="")
        print(f" {trips[int(0.999 * len(trips))]:>10.1f} {trips[-1]:>8.1f} {len(trips):>7}", end="")
        print(f" {late:>3} {100 * late / len(trips):.3f}% {missed:>6}", flush=True)


def main() -> None:
    arguments = sys.argv[1:] or ["5"]
    if os.environ.get("ACHSE_IN_NAMESPACE"):
        measure(float(arguments[0]), [int(count) for count in arguments[1:]] or list(COUNTS))
        return
    user = [] if os.geteuid() == 0 else ["--map-root-user"]
    inner = ["sh", "-c", f'{CABLE} && exec "$@"', "sh", sys.executable, __file__, *arguments]
    environment = {**os.environ, "ACHSE_IN_NAMESPACE": "1"}
    sys.exit(subprocess.call(["unshare", *user, "--net", *inner], env=environment))


if __name__ == "__main__":
    main()
