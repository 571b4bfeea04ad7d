"""One cycle of our EtherCAT master, beside SOEM's: 32 csp drives in Op, frames with their counters.

In memory: µs of `transmit` and `receive` for a cycle, and of writing and reading the set and actual
positions of all drives; replies are made beforehand by the drives' segment and do not count. Then
the cycle of a station: NC with so many moving csp axes, master and frames, without the slaves.

With `cable` also over a veth pair, in a network namespace of its own (Linux, root or user
namespaces): SOEM (through pysoem) and our master exchange the same process data with the same
drives of `achse drive serve`, one after the other. Both print the round trip and the processor time
of the calls; SOEM asks the socket again and again while it waits.

Usage: python benchmarks/bus_cycle.py [DRIVES [CYCLES [cable]]]
"""

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

from achse.codes import AlState
from achse.codes.axis import StartType
from achse.drive import Drive
from achse.ethercat import Segment, Slave, describe
from achse.ethercat.master import (
    BusConfiguration,
    Master,
    Ring,
    SlaveConfiguration,
    from_description,
)
from achse.motion import commands
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.configuration.station_file import parse
from achse.station.station import Station

NEAR, FAR = "cable0", "cable1"
CABLE = (
    f"ip link add {NEAR} type veth peer name {FAR} && ip link set {NEAR} up && ip link set {FAR} up"
)
CYCLE_NS = 1_000_000
PATIENCE_US = 20_000


def configured(count: int) -> tuple[SlaveConfiguration, ...]:
    """So many drives with their default process data."""
    return tuple(from_description(describe(Drive()), f"Drive {n + 1}") for n in range(count))


def report(name: str, times: list[int], note: str = "") -> None:
    ordered = sorted(times)
    print(
        f"{name:<34} p50 {statistics.median(ordered) / 1000:8.1f} µs"
        f"  p99 {ordered[len(ordered) * 99 // 100] / 1000:8.1f} µs  {note}".rstrip(),
        flush=True,
    )


def in_memory(count: int, cycles: int) -> None:
    line = [Drive() for _ in range(count)]
    segment = Segment(Slave(each) for each in line)
    master = Master(BusConfiguration(configured(count), cycle_ns=CYCLE_NS))
    ring = Ring(master, segment, rounds=50)
    master.request(AlState.OP)
    while not master.operational:
        ring.exchange(master.now_ns + CYCLE_NS)
    targets = [
        (each.outputs[2:6], each.inputs[2:6]) for each in master.slaves
    ]  # 607A behind 6040, 6064 behind 6041
    exchange: list[int] = []
    positions: list[int] = []
    clock = time.perf_counter_ns
    for _ in range(cycles):
        now = master.now_ns + CYCLE_NS
        segment.advance(now)
        begin = clock()
        frames = master.transmit(now)
        sent = clock()
        replies = [reply for frame in frames if (reply := segment.process(frame)) is not None]
        came = clock()
        for reply in replies:
            master.receive(reply, now)
        end = clock()
        for target, actual in targets:
            target[:] = actual
        exchange.append(sent - begin + end - came)
        positions.append(clock() - end)
    assert master.operational
    report(f"achse, in memory, {count} drives", exchange, f"{len(frames)} frame(s)")
    report("positions of all, in and out", positions)


class Slaves:
    """A segment whose own time is counted."""

    def __init__(self, segment: Segment) -> None:
        self._segment = segment
        self.ns = 0

    def process(self, frame: bytes) -> bytes | None:
        begin = time.perf_counter_ns()
        reply = self._segment.process(frame)
        self.ns += time.perf_counter_ns() - begin
        return reply

    def advance(self, now_ns: int) -> None:
        begin = time.perf_counter_ns()
        self._segment.advance(now_ns)
        self.ns += time.perf_counter_ns() - begin


def whole_cycle(count: int, cycles: int) -> None:
    """NC, master and frames of so many moving csp axes, each in a sync unit; slaves left out."""
    document = {
        "bus": [{}],
        "axis": [{"id": n, "name": f"A{n}", "max_velocity": 400.0} for n in range(1, count + 1)],
        "drive": [{"axis": n} for n in range(1, count + 1)],
    }
    station = Station(parse(document, "benchmark"))
    nc, axes = station.nc, station.buses[0]
    bus = axes.bus
    assert nc is not None
    assert isinstance(bus, EthercatBus)
    assert axes.shortcut is not None
    for axis in nc:
        axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(2.0)
    axes.shortcut.allowed = False
    for axis in nc:
        assert commands.start(axis, StartType.ABSOLUTE, 1e6, 200.0) == 0
    slaves = Slaves(bus.segment)
    bus._ring.segment = slaves  # type: ignore[assignment]
    times: list[int] = []
    clock = time.perf_counter_ns
    for _ in range(cycles):
        slaves.ns = 0
        begin = clock()
        nc.cycle()
        times.append(clock() - begin - slaves.ns)
    kind = "machine code" if nc.compiled else "plain"
    report(f"NC, master, frame, {count} csp axes", times, kind)


def timed(cycles: int, turn: Callable[[], bool]) -> tuple[list[int], list[int], int]:
    """Wall and processor time of each turn, and how many were not whole."""
    wall, used, missed = [], [], 0
    begin = time.perf_counter_ns()
    for number in range(cycles):
        wait = begin + number * CYCLE_NS - time.perf_counter_ns()
        if wait > 0:
            time.sleep(wait / 1e9)
        else:
            begin -= wait
        processor, started = time.thread_time_ns(), time.perf_counter_ns()
        whole = turn()
        wall.append(time.perf_counter_ns() - started)
        used.append(time.thread_time_ns() - processor)
        missed += not whole
    return wall, used, missed


def beside_soem(count: int, cycles: int) -> None:
    import pysoem

    from achse.station.buses.frame_link import BusLink
    from achse.transport.ethernet import EthernetLink

    command = [sys.executable, "-m", "achse", "drive", "serve", "--interface", FAR]
    with subprocess.Popen(
        [*command, "--count", str(count), "--control", "none"], stdout=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline().startswith("achse drive ready")
        soem = pysoem.Master()
        soem.open(NEAR)
        assert soem.config_init() == count
        soem.config_map()
        soem.state_check(pysoem.SAFEOP_STATE, 500_000)
        soem.send_processdata()
        soem.receive_processdata(PATIENCE_US)
        soem.state = pysoem.OP_STATE
        soem.write_state()
        soem.state_check(pysoem.OP_STATE, 500_000)

        def by_soem() -> bool:
            soem.send_processdata()
            return bool(soem.receive_processdata(PATIENCE_US) == soem.expected_wkc)

        of_soem = timed(cycles, by_soem)
        soem.state = pysoem.INIT_STATE
        soem.write_state()
        soem.close()

        link = EthernetLink(NEAR)
        master = Master(BusConfiguration(configured(count), cycle_ns=CYCLE_NS))
        bus = BusLink(master, link, wait_s=PATIENCE_US / 1e6)
        master.request(AlState.OP)
        begin = time.monotonic_ns()
        while not master.operational and time.monotonic_ns() < begin + 30 * 10**9:
            bus.exchange(time.monotonic_ns() - begin)
            time.sleep(0.001)
        assert master.operational, master.take_events()

        def by_us() -> bool:
            missing = bus.round_trips.missing
            bus.exchange(time.monotonic_ns() - begin)
            return bus.round_trips.missing == missing and master.operational

        ours = timed(cycles, by_us)
        master.request(AlState.INIT)
        for _ in range(50):
            bus.exchange(time.monotonic_ns() - begin)
        link.close()
        run.terminate()
    for name, (wall, used, missed) in (("SOEM", of_soem), ("achse", ours)):
        report(f"{name}, round trip, {count} drives", wall, f"{missed} of {cycles} not whole")
        report(f"{name}, processor time", used)


def main() -> None:
    arguments = sys.argv[1:]
    count = int(arguments[0]) if arguments else 32
    cycles = int(arguments[1]) if len(arguments) > 1 else 2000
    if os.environ.get("ACHSE_IN_NAMESPACE"):
        beside_soem(count, cycles)
        return
    in_memory(count, cycles)
    whole_cycle(count, cycles)
    if "cable" in arguments:
        user = [] if os.geteuid() == 0 else ["--map-root-user"]
        inner = ["sh", "-c", f'{CABLE} && exec "$@"', "sh", sys.executable, __file__, *arguments]
        environment = {**os.environ, "ACHSE_IN_NAMESPACE": "1"}
        sys.exit(subprocess.call(["unshare", *user, "--net", *inner], env=environment))


if __name__ == "__main__":
    main()
