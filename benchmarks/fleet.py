"""A fleet on this machine over one mosquitto: what a station, an axis, a message cost.

Starts STATIONS stations with AXES axes each at SPEED, PER_PROCESS to a process; waits until each
sees all others; measures memory and processor time at rest, with all axes moving, and while clients
read over the broker; at last the broker is restarted while clients write: no acknowledged write may
be lost. Beside it a bare exchange of messages of about that length over the same broker.

It ends with code 1 if a station does not see all others, or an acknowledged write is lost.
Usage: python benchmarks/fleet.py [STATIONS] [AXES] [SPEED] [PER_PROCESS] [SECONDS]
(default: 3 stations, 10 axes, speed 0.1, 1 to a process, 2 s for each measurement). Linux only.
"""

import asyncio
import contextlib
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import aiomqtt

import achse
from achse.ams import AdsError
from achse.fleet.orders import give_order

TICKS = os.sysconf("SC_CLK_TCK")
CLIENTS = 4
PATIENCE = 600.0
Row = dict[str, Any]


class Broker:
    """mosquitto at a free port of 127.0.0.1."""

    def __init__(self, folder: Path) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        user = "user root\n" if os.getuid() == 0 else ""
        self._file = folder / "mosquitto.conf"
        self._file.write_text(
            f"listener {self.port} 127.0.0.1\nallow_anonymous true\nmax_queued_messages 0\n{user}"
        )
        self.process: subprocess.Popen[bytes]
        self.start()

    def start(self) -> None:
        quiet = subprocess.DEVNULL
        command = ("mosquitto", "-c", str(self._file))
        self.process = subprocess.Popen(command, stdout=quiet, stderr=quiet)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.02)
        raise SystemExit("mosquitto did not start")

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait()


class Fleet:
    """A fleet that is up, and what its processes use."""

    def __init__(self, folder: Path, broker: Broker, stations: int, axes: int, more: str) -> None:
        self._environment = os.environ | {"ACHSE_RUNTIME_DIR": str(folder / "run")}
        self.count = stations
        self.network = f"mqtt://127.0.0.1:{broker.port}/plant"
        text = '[[plc]]\nglobals = ["achse.station.demo:GVL"]\n'
        for number in range(1, axes + 1):
            text += f'[[axis]]\nid = {number}\nname = "A{number}"\n'
        (folder / "station.toml").write_text(text)
        (folder / "fleet.toml").write_text(
            f'name = "bench"\ntemplate = "station.toml"\ncount = {stations}\n{more}\n'
            f'net_id = "5.20.0.1.1.1"\n[mqtt]\nbroker = "127.0.0.1"\nport = {broker.port}\n'
            'topic = "plant"\nkeep_alive = 60\n'
        )
        self._command("up", str(folder / "fleet.toml"), "--detach", f"--timeout={PATIENCE}")
        record = json.loads((folder / "run" / "fleet-bench.json").read_text())
        self._supervisor = record["port"], record["key"]
        self.supervisor = record["pid"]

    def _command(self, *words: str) -> None:
        command = (sys.executable, "-m", "achse", "fleet", *words)
        subprocess.run(command, env=self._environment, check=True, stdout=subprocess.DEVNULL)

    def down(self) -> None:
        self._command("down", "--timeout=300")

    async def rows(self) -> list[Row]:
        rows: list[Row] = await give_order(*self._supervisor, "status")
        return rows

    async def all_see_all(self) -> list[Row]:
        end = time.monotonic() + PATIENCE
        while True:
            rows = await self.rows()
            seen = [row["partners"] or 0 for row in rows]
            if min(seen) >= self.count - 1 and all(row["state"] == "RUN" for row in rows):
                return rows
            if time.monotonic() > end:
                raise SystemExit(f"after {PATIENCE} s a station sees {min(seen)} others")
            await asyncio.sleep(0.2)


def processor_s(pid: int) -> float:
    """Processor time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def share_mb(pid: int) -> float:
    """Memory of a process; of pages that several have its share."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024


class Meter:
    """Processor time of stations, broker and supervisor between two moments."""

    def __init__(self, pids: list[int], broker: int, supervisor: int) -> None:
        self._pids, self._broker, self._supervisor = pids, broker, supervisor
        self._began = self._look()

    def _look(self) -> tuple[float, float, float, float]:
        stations = sum(map(processor_s, self._pids), 0.0)
        broker, supervisor = processor_s(self._broker), processor_s(self._supervisor)
        return time.monotonic(), stations, broker, supervisor

    def shares(self) -> tuple[float, float, float, float]:
        """Seconds, and of one core: stations, broker, supervisor."""
        wall, stations, broker, supervisor = (
            now - then for now, then in zip(self._look(), self._began, strict=True)
        )
        return wall, stations / wall, broker / wall, supervisor / wall


@contextlib.asynccontextmanager
async def clients(fleet: Fleet, rows: list[Row]) -> Any:
    """Clients in the network; each asks stations of its own."""
    async with contextlib.AsyncExitStack() as stack:
        yield [
            await stack.enter_async_context(
                achse.connect(
                    fleet.network,
                    net_id=rows[place % len(rows)]["net_id"],
                    watch_symbols=False,
                    timeout=30.0,
                )
            )
            for place in range(CLIENTS)
        ]


async def reads(fleet: Fleet, rows: list[Row], seconds: float) -> int:
    """How many reads of a variable are answered over the broker in this time."""
    count = 0

    async def ask(client: Any, end: float) -> None:
        nonlocal count
        while time.monotonic() < end:
            await client.read("GVL.nInt")
            count += 1

    async with clients(fleet, rows) as asking:
        for client in asking:
            await client.read("GVL.nInt")
        end = time.monotonic() + seconds
        await asyncio.gather(*(ask(client, end) for client in asking))
    return count


async def bare(port: int, seconds: float) -> int:
    """Messages of 48 bytes and their answers, by two bare clients, one after the other."""
    there, back, count = "bare/there", "bare/back", 0
    async with aiomqtt.Client("127.0.0.1", port) as one, aiomqtt.Client("127.0.0.1", port) as other:
        await one.subscribe(back)
        await other.subscribe(there)

        async def answer() -> None:
            async for message in other.messages:
                await other.publish(back, message.payload)

        answering = asyncio.create_task(answer())
        answers = aiter(one.messages)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            await one.publish(there, bytes(48))
            await anext(answers)
            count += 1
        answering.cancel()
    return count


async def move_all(rows: list[Row], axes: int) -> None:
    """All axes go forward for good."""

    async def move(client: Any, number: int) -> None:
        axis = client.nc.axis(f"A{number}")
        await axis.enable(within=PATIENCE)
        await axis.move_velocity(1.0, wait=False)

    async def move_station(row: Row) -> None:
        async with achse.connect(row["address"], watch_symbols=False, timeout=PATIENCE) as client:
            await asyncio.gather(*(move(client, number) for number in range(1, axes + 1)))

    for begin in range(0, len(rows), 20):
        await asyncio.gather(*map(move_station, rows[begin : begin + 20]))


async def writes_over_a_restart(fleet: Fleet, broker: Broker, rows: list[Row]) -> tuple[int, int]:
    """Clients count variables up while the broker restarts: acknowledged writes, lost ones."""
    acknowledged: dict[str, int] = {}
    chosen = rows[:: max(1, len(rows) // CLIENTS)][:CLIENTS]
    stop = asyncio.Event()
    counts = []

    async def write(row: Row) -> None:
        count = 0
        async with achse.connect(
            fleet.network, net_id=row["net_id"], watch_symbols=False, timeout=5.0
        ) as client:
            while not stop.is_set():
                count += 1
                try:
                    await client.write("GVL.nInt", count % 30_000)
                    acknowledged[row["net_id"]] = count
                except AdsError:
                    await asyncio.sleep(0.05)
        counts.append(count)

    writing = [asyncio.create_task(write(row)) for row in chosen]
    await asyncio.sleep(1.0)
    await asyncio.to_thread(broker.stop)
    await asyncio.to_thread(broker.start)
    before = dict(acknowledged)
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        done = [acknowledged.get(each["net_id"], 0) - before.get(each["net_id"], 0)
                for each in chosen]  # fmt: skip
        if min(done) > 20:
            break
        await asyncio.sleep(0.05)
    stop.set()
    await asyncio.gather(*writing)
    lost = 0
    for row in chosen:
        async with achse.connect(row["address"], watch_symbols=False, timeout=30.0) as client:
            lost += (await client.read("GVL.nInt")) < acknowledged[row["net_id"]] % 30_000
    return sum(acknowledged.values()), lost


@contextlib.contextmanager
def running(
    folder: Path, stations: int, axes: int, more: str
) -> Iterator[tuple[Broker, Fleet, float]]:
    broker = Broker(folder)
    try:
        began = time.monotonic()
        fleet = Fleet(folder, broker, stations, axes, more)
        try:
            yield broker, fleet, time.monotonic() - began
        finally:
            fleet.down()
    finally:
        broker.stop()


async def measure(broker: Broker, fleet: Fleet, axes: int, seconds: float) -> int:
    rows = await fleet.all_see_all()
    pids = sorted({row["pid"] for row in rows})
    await asyncio.sleep(1.0)
    memory = sum(map(share_mb, pids))
    per_station = memory / len(rows)
    others = share_mb(broker.process.pid), share_mb(fleet.supervisor)
    print(
        f"memory           {memory:9.0f} MB in {len(pids)} processes,"
        f" {per_station:.1f} MB a station;"
        f" broker {others[0]:.0f} MB, supervisor {others[1]:.0f} MB"
    )

    def meter() -> Meter:
        return Meter(pids, broker.process.pid, fleet.supervisor)

    def print_share(what: str, used: Meter, axes_now: int) -> float:
        _, share, of_broker, of_supervisor = used.shares()
        cost = 1e6 * share / len(rows)
        print(
            f"{what:16} {100 * share:9.1f} % of a core, {cost:.0f} µs a station and second"
            f" ({axes_now} axes), broker {100 * of_broker:.1f} %,"
            f" supervisor {100 * of_supervisor:.1f} %"
        )
        return share

    at_rest = meter()
    await asyncio.sleep(seconds)
    print_share("at rest", at_rest, 0)
    began = time.monotonic()
    await move_all(rows, axes)
    print(f"moving all axes took {time.monotonic() - began:.1f} s")
    before = {row["name"]: row for row in await fleet.rows()}
    moving = meter()
    await asyncio.sleep(max(seconds, 2.0))
    share = print_share("all axes moving", moving, axes)
    after = await fleet.rows()
    cycles = sum(row["cycles"] - before[row["name"]]["cycles"] for row in after)
    computed = sum(
        (row["cycle_s"] or 0) * row["cycles"]
        - (before[row["name"]]["cycle_s"] or 0) * before[row["name"]]["cycles"]
        for row in after
    )
    late = sum(row["late"] - before[row["name"]]["late"] for row in after)
    count = sum(row["moving"] for row in after)
    if cycles:
        each = 1e6 * computed / cycles
        print(
            f"a cycle          {each:9.1f} µs with {axes} axes, {count} axes moving,"
            f" {late} of {cycles} cycles late"
        )
    asking = meter()
    answered = await reads(fleet, rows, seconds)
    wall, with_reads, of_broker, _ = asking.shares()
    rate = answered / wall
    print(
        f"reads by MQTT    {rate:9.0f}/s by {CLIENTS} clients;"
        f" each {1e6 * max(0.0, with_reads - share) / rate:.0f} µs of a station,"
        f" {1e6 * of_broker / rate:.0f} µs of the broker"
    )
    print(f"bare exchange    {await bare(broker.port, seconds) / seconds:9.0f}/s by one client")
    acknowledged, lost = await writes_over_a_restart(fleet, broker, rows)
    began = time.monotonic()
    await fleet.all_see_all()
    print(f"broker restarted {acknowledged:9} writes acknowledged, {lost} lost")
    print(f"all see all again after {time.monotonic() - began:.1f} s more")
    return int(lost > 0)


def main(stations: int, axes: int, speed: float, per_process: int, seconds: float) -> int:
    more = f"speed = {speed!r}\nstations_per_process = {per_process}\n"
    with (
        tempfile.TemporaryDirectory() as folder,
        running(Path(folder), stations, axes, more) as (broker, fleet, took),
    ):
        print(
            f"{stations} stations × {axes} axes at speed {speed:g}, {per_process} to a process:"
            f" up in {took:.1f} s"
        )
        return asyncio.run(measure(broker, fleet, axes, seconds))


if __name__ == "__main__":
    arguments = dict(enumerate(sys.argv[1:]))
    sys.exit(
        main(
            int(arguments.get(0, 3)),
            int(arguments.get(1, 10)),
            float(arguments.get(2, 0.1)),
            int(arguments.get(3, 1)),
            float(arguments.get(4, 2.0)),
        )
    )
