"""A station with drives on a network interface: lost frames and jitter, beside a bare timer.

A station in real time has eight csp axes, all moving, with a cycle of 1 ms; `achse drive serve`
has the drives at the other end of a veth pair. A process that does nothing but sleep to each
millisecond (as cyclictest does) runs at the same time with the same priority: how late it wakes is
what the machine costs anyone. Lateness is against the grid of the cycle.

Before and after the station SOEM (through pysoem, where that is installed) exchanges with the same
drives in the same cycle: its round trips end when the call returns, those of the station when the
kernel has the frame, since nobody waits for it.

Runs in a network namespace of its own (Linux, root or user namespaces), in real time where allowed.
Usage: python benchmarks/interface_bus.py [--minutes 10] [--seconds 20] [--drives 8]
    [--cycle-us 1000] [--drift 200] [--pace computer]

`--drift`: the clock of the first drive is so many ppm too fast. The place of the frames in its
cycle is how far they are from the multiples of the cycle in its time.
"""

import argparse
import asyncio
import contextlib
import importlib.util
import os
import struct
import subprocess
import sys
import tempfile
import time
from array import array
from collections.abc import Iterator, Sequence

from achse.codes.axis import StartType
from achse.motion import commands
from achse.station.buses.interface_bus import InterfaceBus
from achse.station.clocks.priority import MASTER_PRIORITY, run_first
from achse.station.configuration.station_file import parse
from achse.station.station import Station

NEAR, FAR = "cable0", "cable1"
CABLE = (
    f"ip link add {NEAR} type veth peer name {FAR} && ip link set {NEAR} up"
    f" && ip link set {FAR} up && ip link set lo up"
)
START_S = 60.0
PATIENCE_US = 500_000
OUTPUTS = struct.pack("<HbH", 0, 0, 3000)
"""Control word, mode and torque limit (‰), as drives map them by default."""


def sleeper(cycle_ns: int, done: int, out: int) -> None:
    """Sleep to each cycle until `done` is closed; write how late each was to `out`."""
    run_first(MASTER_PRIORITY)
    os.set_blocking(done, False)
    stamps = array("q")
    due = time.monotonic_ns()
    while True:
        due += cycle_ns
        wait = due - time.monotonic_ns()
        if wait > 0:
            time.sleep(wait / 1e9)
        stamps.append(time.monotonic_ns())
        try:
            if not os.read(done, 1):
                break
        except BlockingIOError:
            pass
    with os.fdopen(out, "wb") as file:
        file.write(stamps.tobytes())


@contextlib.contextmanager
def beside(cycle_ns: int) -> Iterator[array]:  # type: ignore[type-arg]
    """While a sleeper runs; its stamps afterwards."""
    done, end = os.pipe()
    into, out = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(end)
        os.close(into)
        sleeper(cycle_ns, done, out)
        os._exit(0)
    os.close(done)
    os.close(out)
    stamps = array("q")
    try:
        yield stamps
    finally:
        os.close(end)
        with os.fdopen(into, "rb") as file:
            stamps.frombytes(file.read())
        os.waitpid(child, 0)


def lateness(stamps: Sequence[int], cycle_ns: int) -> list[float]:
    """µs behind the grid of the cycle, sorted; the grid begins anew where a second was given up."""
    late: list[float] = []
    part: list[int] = []
    before = stamps[0]
    for stamp in [*stamps, stamps[-1] + 10**10]:
        if stamp - before > 10**9:
            offsets = [each - number * cycle_ns for number, each in enumerate(part)]
            earliest = min(offsets)
            late += [(each - earliest) / 1000.0 for each in offsets]
            part = []
        part.append(stamp)
        before = stamp
    return sorted(late)


def at(ordered: Sequence[float], share: float) -> float:
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]


def report(name: str, late: Sequence[float]) -> None:
    shares = " ".join(f"{at(late, share):>9.1f}" for share in (0.5, 0.99, 0.999, 1.0))
    print(f"{name:<28} {shares} {len(late):>9}", flush=True)


def by_soem(seconds: float, drives: int, cycle_ns: int) -> list[float]:
    """µs of each round trip of SOEM with the drives, once a cycle, all in Op; then in Init."""
    import pysoem

    trips: list[float] = []
    run_first(MASTER_PRIORITY)
    master = pysoem.Master()
    master.open(NEAR)
    try:
        assert master.config_init() == drives
        master.config_map()
        for slave in master.slaves:  # a drive keeps the torque limit that its last master sent
            slave.output = OUTPUTS.ljust(len(slave.output), b"\0")
        master.config_dc()  # the time of the reference clock travels with each frame, as ours does
        master.state_check(pysoem.SAFEOP_STATE, PATIENCE_US)
        master.send_processdata()
        master.receive_processdata(PATIENCE_US)
        master.state = pysoem.OP_STATE
        master.write_state()
        assert master.state_check(pysoem.OP_STATE, PATIENCE_US) == pysoem.OP_STATE
        due = end = time.monotonic_ns()
        end += round(seconds * 1e9)
        while due < end:
            due += cycle_ns
            wait = due - time.monotonic_ns()
            if wait > 0:
                time.sleep(wait / 1e9)
            begin = time.monotonic_ns()
            master.send_processdata()
            master.receive_processdata(PATIENCE_US)
            trips.append((time.monotonic_ns() - begin) / 1000.0)
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
        run_first(0)
    return trips


async def measure(seconds: float, drives: int, cycle_ns: int, pace: str) -> list[float]:
    """Run the station; its report is printed, µs of its round trips come back."""
    dynamics = {"max_velocity": 400.0, "default_acceleration": 2000.0,
                "default_deceleration": 2000.0, "default_jerk": 20_000.0}  # fmt: skip
    document = {
        "nc": {"cycle": f"{cycle_ns // 1000}us"},
        "bus": [{"interface": NEAR, "pace": pace}],
        "axis": [{"id": n, "name": f"A{n}", **dynamics} for n in range(1, drives + 1)],
        "drive": [{"axis": n} for n in range(1, drives + 1)],
    }
    station = Station(parse(document, "benchmark"))
    (bus,) = station.fieldbuses.values()
    assert isinstance(bus, InterfaceBus)
    assert station.nc is not None
    stamps, places = array("q"), array("q")
    trips: list[float] = []
    exchange, take = bus.exchange, bus.take

    def stamped() -> None:
        stamps.append(time.monotonic_ns())
        place = (bus.master.cyclic.reference_ns + cycle_ns // 2) % cycle_ns - cycle_ns // 2
        places.append(place)
        exchange()

    def timed() -> None:
        before = bus.round_trips.count
        take()
        if bus.round_trips.count > before:
            trips.append(bus.round_trips.last_ns / 1000.0)

    bus.exchange, bus.take = stamped, timed  # type: ignore[method-assign]
    async with station.running("127.0.0.1", 0):
        for axis in station.nc:
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        async with asyncio.timeout(START_S):
            while not all(axis.loop_closed for axis in station.nc):
                await asyncio.sleep(0.05)
                for axis in station.nc:
                    if axis.error_code:
                        commands.reset(axis)
        for axis in station.nc:
            commands.start(axis, StartType.ABSOLUTE, 50.0 * (seconds + 10.0), 50.0)
        with beside(cycle_ns) as bare:
            async with asyncio.timeout(START_S):  # what the start cost is caught up
                while station.pace is None or station.pace.behind_ns > cycle_ns:  # noqa: ASYNC110
                    await asyncio.sleep(0.1)
            bus.master.reset_frames()
            bus.round_trips.reset()
            wrong = {slave.station: slave.wrong_cycles for slave in bus.slaves}
            rebases, ticks = station.pace.rebases, station.pace.late_ticks
            stamps, places = array("q"), array("q")
            trips.clear()
            begin = time.monotonic_ns()
            used, began = time.process_time(), time.monotonic()
            await asyncio.sleep(seconds)
            used, passed = time.process_time() - used, time.monotonic() - began
        counters, durations = bus.master.cyclic.counters, list(trips)
        moving = sum(axis.set_velocity != 0.0 for axis in station.nc)
        late = station.pace.late_ticks - ticks if station.pace else 0
        given_up = station.pace.rebases - rebases if station.pace else 0
    end = stamps[-1]
    worst = max(slave.wrong_cycles - wrong[slave.station] for slave in bus.slaves)
    print(f"µs behind a grid of {cycle_ns / 1000:g} µs: p50, p99, 99.9 %, most; cycles")
    report("bare sleeper", lateness([each for each in bare if begin <= each <= end], cycle_ns))
    report(f"achse station, {drives} drives", lateness(stamps, cycle_ns))
    print(
        f"{counters.sent} frames, {counters.lost} lost, {counters.wrong} with a wrong working"
        f" counter, {worst} cycles invalid at the worst slave; {moving} of {drives} axes move;"
        f" {late} late ticks, {given_up} × a second given up"
    )
    at_place = sorted(each / 1000.0 for each in places)
    shares = ", ".join(f"{at(at_place, share):.1f}" for share in (0.001, 0.01, 0.5, 0.99, 0.999))
    print(
        f"place in the cycle of the reference, µs: p0.1, p1, p50, p99, p99.9: {shares};"
        f" pace of the {pace}, drift of its clock learned {bus.reference.drift_ppm:.1f} ppm"
    )
    print(f"the station takes {100 * used / passed:.0f} % of a processor")
    return durations


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=0.0)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--drives", type=int, default=8)
    parser.add_argument("--cycle-us", type=int, default=1000)
    parser.add_argument("--drift", type=float, default=0.0)
    parser.add_argument("--pace", choices=("bus", "computer"), default="bus")
    options = parser.parse_args()
    if not os.environ.get("ACHSE_IN_NAMESPACE"):
        user = [] if os.geteuid() == 0 else ["--map-root-user"]
        inner = ["sh", "-c", f'{CABLE} && exec "$@"', "sh", sys.executable, *sys.argv]
        environment = {**os.environ, "ACHSE_IN_NAMESPACE": "1"}
        sys.exit(subprocess.call(["unshare", *user, "--net", *inner], env=environment))
    command = [sys.executable, "-m", "achse", "drive", "serve", "--interface", FAR]
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as faults:
        if options.drift:
            faults.write(f'[[fault]]\nkind = "clock_drift"\ndrive = 1\nby = {options.drift}\n')
            faults.flush()
            command += ["--faults", faults.name]
        run_with(command, options)


def run_with(command: list[str], options: argparse.Namespace) -> None:
    """Serve the drives, and measure."""
    with subprocess.Popen(
        [*command, "--count", str(options.drives), "--control", "none"],
        stdout=subprocess.PIPE,
        text=True,
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline().startswith("achse drive ready")
        try:
            seconds = 60.0 * options.minutes or options.seconds
            cycle_ns = 1000 * options.cycle_us
            with_soem = importlib.util.find_spec("pysoem") is not None
            soem = by_soem(seconds / 2, options.drives, cycle_ns) if with_soem else []
            ours = asyncio.run(measure(seconds, options.drives, cycle_ns, options.pace))
            if with_soem:
                soem += by_soem(seconds / 2, options.drives, cycle_ns)
            print("µs of a round trip: p50, p99, 99.9 %, most; cycles")
            report(f"achse station, {options.drives} drives", sorted(ours))
            if with_soem:
                report("SOEM, the same drives", sorted(soem))
        finally:
            run.terminate()


if __name__ == "__main__":
    main()
