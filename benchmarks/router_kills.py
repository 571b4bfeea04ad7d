"""Kills (SIGKILL) of client, router and station at drawn moments: what remains at the station.

A program fetches symbol handles and subscribes through `achse router`, one request after the other,
until the part of this round is killed, and it as well: a program, the router, or the station. What
was killed is started again, as by systemd; some routers are killed once more while they start. Then
the station, asked directly, must come to hold nothing of any client, abandoned handles (decision
0116) included.

Usage: python benchmarks/router_kills.py [KILLS] [SEED]
"""

import asyncio
import contextlib
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict

import achse
from achse.cli.target import STATION_PORT
from achse.codes import ReservedGroup
from achse.devices.station import STATISTICS
from achse.testing import free_host

PLC = 851
GET_HANDLE = int(ReservedGroup.SYMBOL_HANDLE_BY_NAME)
NAMES = ("GVL.nInt", "GVL.fLreal", "GVL.sString", "MAIN.nCounter")
WITHIN_S = 60.0
PARTS = ("program", "router", "station")


async def program(router: str, net_id: str) -> None:
    """Fetch and subscribe until the process is killed."""
    async with (
        contextlib.AsyncExitStack() as subscriptions,
        achse.connect(router, net_id=net_id, port=PLC) as client,
    ):
        print("ready", flush=True)
        while True:
            for name in NAMES:
                await subscriptions.enter_async_context(client.subscribe(name))
                await client.read_write_raw(GET_HANDLE, 0, 4, name.encode() + b"\0")


def started(*words: str, ready: str) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout is not None
    while not (line := process.stdout.readline()).startswith(ready):
        assert line, f"{words} ended before it was ready"
    return process


def kill(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


async def resources(station: str) -> tuple[int, int, int]:
    """Subscriptions, handles of programs that are there, and abandoned handles."""
    async with achse.connect(station, net_id=f"{station}.1.1", port=STATION_PORT) as client:
        figures = json.loads(bytes(await client.read_raw(STATISTICS, 0, 1 << 20)))
    devices, abandoned = figures["devices"], figures["handles_abandoned"]
    return (
        sum(each["subscriptions"] for each in devices),
        sum(each["handles"] for each in devices) - abandoned,
        abandoned,
    )


def main(kills: str = "50", seed: str = "1") -> None:
    if kills == "program":
        asyncio.run(program(*seed.split("=")))
        return
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ACHSE_STATE_DIR"] = folder
        measure(int(kills), int(seed))


def measure(kills: int, seed: int) -> None:
    """Kill and count."""
    moments = random.Random(seed)
    station, router = free_host(), free_host()
    target = f"{station}={station}.1.1"
    run = ("-m", "achse", "run", "--host", station, "--net-id", f"{station}.1.1")
    route = ("-m", "achse", "router", "--to", target, "--host", router)
    commands = {
        "program": (__file__, "program", f"{router}={station}.1.1"),
        "router": (*route, "--net-id", f"{router}.1.1"),
        "station": run,
    }
    ready = {"program": "ready", "router": "achse ready", "station": "achse ready"}
    there: dict[str, subprocess.Popen[str]] = {}
    times: dict[str, list[float]] = defaultdict(list)
    most: Counter[str] = Counter()
    try:
        for _ in range(kills):
            for part in reversed(PARTS):
                if part not in there:
                    there[part] = started(*commands[part], ready=ready[part])
            part = moments.choice(PARTS)
            time.sleep(moments.uniform(0.0, 0.2))
            begin = time.monotonic()
            kill(there.pop(part))
            if part == "router" and moments.random() < 0.4:
                starting = subprocess.Popen(
                    [sys.executable, *commands[part]], stdout=subprocess.DEVNULL
                )
                time.sleep(moments.uniform(0.1, 1.0))
                starting.kill()
                starting.wait()
                times["router twice"].append(0.0)
            if part != "program":
                there[part] = started(*commands[part], ready=ready[part])
                time.sleep(moments.uniform(0.0, 0.2))
                begin = time.monotonic()
                kill(there.pop("program"))
            while any(left := asyncio.run(resources(station))):
                most["abandoned handles"] = max(most["abandoned handles"], left[2])
                if time.monotonic() > begin + WITHIN_S:
                    raise SystemExit(f"subscriptions, handles, abandoned handles remain: {left}")
            times[part].append(time.monotonic() - begin)
    finally:
        for process in there.values():
            with contextlib.suppress(OSError):
                kill(process)
    print(f"{len(times.pop('router twice', []))} routers were killed again while they started")
    for part, each in sorted(times.items()):
        print(f"{len(each):3} kills of the {part:8} nothing left after {max(each):.2f} s at most")
    print(f"abandoned handles at the station meanwhile: {most['abandoned handles']} at most")


if __name__ == "__main__":
    main(*sys.argv[1:])
