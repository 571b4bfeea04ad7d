"""Many programs through one `achse router` to one station: samples counted, losses told.

So many pyads processes, and where `.ci/run` has built and installed them a program with the
vendor's AdsLib and two with ads-client.

Each program subscribes to a counter of its own so many times. Meanwhile the station, which lets in
one connection per host, is killed and started again, and the cable between router and station is
pulled. A program counts its samples, the counts that it missed, and samples of other programs. What
is missed is what passed while there was no connection: as often as the cable was pulled, for each
subscription once. What came through the cable is counted there too: at the end it is held, so that
the programs have all that came. A program that is killed must leave nothing at the station.
Usage: python benchmarks/many_programs.py [PROGRAMS] [SUBSCRIPTIONS] [SECONDS]
The full length: python benchmarks/many_programs.py 8 500 3600
"""

import asyncio
import contextlib
import json
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import AsyncIterator
from itertools import chain
from pathlib import Path
from typing import Any

import achse
from achse.ams import Command
from achse.ams.frame import TCP_HEADER

NET_ID, OWN = "5.1.2.3.1.1", "5.7.7.7.1.1"
STATION, ROUTER = "127.0.0.91", "127.0.0.92"
PULSE_MS = 500
"""Time between two counts."""

RESTARTS, PULLS = 2, 3

NOTIFICATION = int(Command.NOTIFICATION)
STREAM_HEAD, STAMP, SAMPLE_HEAD = (struct.Struct(each) for each in ("<II", "<QI", "<II"))

ROOT = Path(__file__).parents[1]
ADSLIB = ROOT / ".foreign" / "pyads-3.6.0" / "many_programs"
ADS_CLIENT = ROOT / "tests" / "interop" / "npm" / "node_modules" / "ads-client"

PROGRAM = """PROGRAM MAIN
VAR nCycle : UDINT; aCount : ARRAY [0..15] OF UDINT; i : INT; END_VAR
nCycle := nCycle + 1;
IF nCycle MOD {cycles} = 0 THEN
    FOR i := 0 TO 15 DO aCount[i] := nCycle / {cycles} * 16 + INT_TO_UDINT(i); END_FOR
END_IF
END_PROGRAM
"""


def program(number: int, subscriptions: int) -> None:
    """One program: it prints what came behind each line of its standard input, and at its end."""
    import pyads

    last: dict[int, int] = {}
    counts = dict.fromkeys(("samples", "missed", "gaps", "restarts", "foreign", "ends"), 0)
    connection = pyads.Connection(NET_ID, 851, ROUTER)
    connection.open()

    def came(notification: Any, name: str) -> None:
        handle = notification.contents.hNotification
        if notification.contents.cbSampleSize < 4:
            counts["ends"] += 1
            return
        *_, value = connection.parse_notification(notification, pyads.PLCTYPE_UDINT)
        count, whose = divmod(value, 16)
        counts["samples"] += 1
        counts["foreign"] += bool(value) and whose != number
        before = last.get(handle, count - 1)
        counts["restarts"] += count < before
        if count > before + 1 and before:
            counts["missed"] += count - before - 1
            counts["gaps"] += 1
        last[handle] = count

    for _ in range(subscriptions):
        connection.add_device_notification(
            f"MAIN.aCount[{number}]", pyads.NotificationAttrib(4), came
        )
    print("ready", flush=True)
    for _ in chain(sys.stdin, [""]):
        counts["subscriptions"] = len(last)
        print(json.dumps(counts), flush=True)
    signal.raise_signal(signal.SIGKILL)


def commands(programs: int, subscriptions: int) -> list[tuple[str, list[str]]]:
    """Kinds of the programs and their command lines."""
    own = [sys.executable, __file__, "program"]
    kinds = [("pyads", own)] * programs
    if ADSLIB.exists():
        kinds.append(("AdsLib", [str(ADSLIB), NET_ID, ROUTER]))
    if ADS_CLIENT.exists() and (node := shutil.which("node")):
        script = str(Path(__file__).with_name("ads_client_program.mjs"))
        kinds += [("ads-client", [node, script, NET_ID, ROUTER])] * 2
    return [
        (kind, [*words, str(number), str(subscriptions)])
        for number, (kind, words) in enumerate(kinds)
    ]


class SampleCounter:
    """Counts the samples of notifications in a stream of AMS/TCP packets."""

    def __init__(self) -> None:
        self.samples = 0
        self._partial = b""

    def receive(self, data: bytes) -> None:
        data = self._partial + data
        position = 0
        while len(data) - position >= TCP_HEADER.size:
            end = position + TCP_HEADER.size + TCP_HEADER.unpack_from(data, position)[1]
            if end > len(data):
                break
            if int.from_bytes(data[position + 22 : position + 24], "little") == NOTIFICATION:
                self._count(data, position + 38)
            position = end
        self._partial = data[position:]

    def _count(self, data: bytes, position: int) -> None:
        _, stamps = STREAM_HEAD.unpack_from(data, position)
        position += STREAM_HEAD.size
        for _ in range(stamps):
            count = STAMP.unpack_from(data, position)[1]
            position += STAMP.size
            for _ in range(count):
                position += SAMPLE_HEAD.size + SAMPLE_HEAD.unpack_from(data, position)[1]
            self.samples += count


class Cable:
    """A TCP connection through this process, which can be pulled, or held for a while."""

    def __init__(self) -> None:
        self.samples = 0
        """Samples that went to the router."""
        self.flows = asyncio.Event()
        """While it is not set nothing goes to the router."""
        self.flows.set()
        self.port = 0
        self.connections = 0
        self.most_at_once = 0
        self._to_station: set[asyncio.StreamWriter] = set()
        self._counters: set[SampleCounter] = set()

    async def connected(self, here: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        try:
            there, out = await asyncio.open_connection(STATION, 48898)
        except OSError:
            back.close()
            return
        self.connections += 1
        self._to_station.add(out)
        self.most_at_once = max(self.most_at_once, len(self._to_station))
        back.transport.set_write_buffer_limits(high=0)
        counter = SampleCounter()
        await asyncio.gather(self._carry(here, out), self._carry(there, back, counter))
        self.samples += counter.samples
        self._counters.discard(counter)
        self._to_station.discard(out)

    async def _carry(
        self,
        source: asyncio.StreamReader,
        to: asyncio.StreamWriter,
        counter: SampleCounter | None = None,
    ) -> None:
        if counter is not None:
            self._counters.add(counter)
        with contextlib.suppress(OSError):
            while data := await source.read(1 << 16):
                if counter is not None:
                    await self.flows.wait()
                to.write(data)
                await to.drain()
                if counter is not None:
                    counter.receive(data)
        to.close()

    @property
    def passed(self) -> int:
        """Samples that went to the router so far."""
        return self.samples + sum(each.samples for each in self._counters)

    @contextlib.asynccontextmanager
    async def paused(self) -> AsyncIterator[None]:
        """Let nothing go to the router; all that went before is with the programs."""
        self.flows.clear()
        await asyncio.sleep(2.0)
        yield
        self.flows.set()

    def pull(self) -> None:
        """End the connection at the station at once; the router gets what was counted, and the end.

        A reset would throw away what the system keeps for a router that has not read it yet.
        """
        for writer in self._to_station:
            writer.transport.abort()


@contextlib.asynccontextmanager
async def process(*command: str, ready: str) -> AsyncIterator[asyncio.subprocess.Process]:
    pipe = asyncio.subprocess.PIPE
    running = await asyncio.create_subprocess_exec(
        *command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL
    )
    assert running.stdout is not None
    try:
        while not (line := (await running.stdout.readline()).decode()).startswith(ready):
            assert line, f"{command} ended before it was ready"
        yield running
    finally:
        with contextlib.suppress(ProcessLookupError):
            running.kill()
        await running.wait()


async def so_far(running: asyncio.subprocess.Process) -> int:
    """Samples that a program has received."""
    assert running.stdin is not None
    assert running.stdout is not None
    running.stdin.write(b"\n")
    counts: dict[str, int] = json.loads(await running.stdout.readline())
    return counts["samples"] + counts["ends"]


async def status() -> dict[str, Any]:
    async with achse.connect(ROUTER, net_id=OWN, port=1) as client:
        figures: dict[str, Any] = json.loads(bytes(await client.read_raw(2, 0, 1 << 20)))
    return figures


async def measure(programs: int, subscriptions: int, seconds: float, folder: Path) -> None:
    (folder / "MAIN.st").write_text(PROGRAM.format(cycles=PULSE_MS // 10))
    (folder / "station.toml").write_text(
        f'[router]\nnet_id = "{NET_ID}"\nhost = "{STATION}"\n[[plc]]\nport = 851\nsources = "."\n'
    )
    cable = Cable()
    server = await asyncio.start_server(cable.connected, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    (folder / "router.toml").write_text(
        f'[router]\nnet_id = "{OWN}"\nhost = "{ROUTER}"\n[[target]]\nname = "station"\n'
        f'host = "127.0.0.1:{port}"\nnet_id = "{NET_ID}"\nresubscribe = true\n'
    )
    achse_command = (sys.executable, "-m", "achse")
    run = (*achse_command, "run", str(folder / "station.toml"))
    route = (*achse_command, "router", "--config", str(folder / "router.toml"))
    started = commands(programs, subscriptions)
    async with contextlib.AsyncExitStack() as stack:
        there = await stack.enter_async_context(process(*run, ready="achse ready"))
        await stack.enter_async_context(process(*route, ready="achse ready"))
        clients = [
            await stack.enter_async_context(process(*words, ready="ready")) for _, words in started
        ]
        for kind, count in Counter(kind for kind, _ in started).items():
            print(f"{count} {kind} with {subscriptions} subscriptions each", flush=True)
        async with cable.paused():  # a program may drop samples while it subscribes
            early = sum([await so_far(each) for each in clients]) - cable.passed
        pause = seconds / (RESTARTS + PULLS + 1)
        for step in range(RESTARTS + PULLS):
            await asyncio.sleep(pause)
            if step % 2:
                there.kill()
                await there.wait()
                there = await stack.enter_async_context(process(*run, ready="achse ready"))
            else:
                cable.pull()
        await asyncio.sleep(pause)
        total: dict[str, Counter[str]] = {kind: Counter() for kind, _ in started}
        async with cable.paused():
            figures, passed = await status(), cable.passed
            for (kind, _), each in zip(started, clients, strict=True):
                output = (await each.communicate(b""))[0].decode().strip()
                total[kind].update(json.loads(output))
        begin = time.monotonic()
        while True:
            [target] = (await status())["targets"]
            if not target["subscriptions"] + target["handles"]:
                break
            assert time.monotonic() < begin + 60, "something remained at the station"
            await asyncio.sleep(0.1)
        print(f"released {time.monotonic() - begin:.1f} s after the kill of all programs")
    server.close()
    [target] = figures["targets"]
    print(f"{'':14} " + " ".join(f"{kind:>10}" for kind in total))
    for name in next(iter(total.values())):
        print(f"{name:14} " + " ".join(f"{each[name]:10}" for each in total.values()))
    received = sum(each["samples"] + each["ends"] for each in total.values())
    print(f"samples        {passed} through the cable, {received} received:", end=" ")
    print(f"{early:+} while programs subscribed, {received - passed - early:+} later")
    print(f"connections    {cable.connections:9}, at once {cable.most_at_once}")
    print(f"router: losses {target['losses']}, lost frames {figures['lost_frames']},", end=" ")
    print(f"50 % {target['latency_50'] * 1e3:.2f} ms, 99 % {target['latency_99'] * 1e3:.2f} ms")


def main(*words: str) -> None:
    if words and words[0] == "program":
        program(int(words[1]), int(words[2]))
    programs, subscriptions, seconds = (*map(int, words), *(8, 50, 30)[len(words) :])
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(measure(programs, subscriptions, seconds, Path(folder)))


if __name__ == "__main__":
    main(*sys.argv[1:])
