"""One process of a fleet: some of its stations in one loop, and its messages about them."""

import asyncio
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack
from typing import Any

from achse.fleet.plan import FleetPlan
from achse.station import RunningStation, Station
from achse.station.station import DEFAULT_EPOCH_NS

Send = Callable[[dict[str, Any]], None]


def pin(core: int | None) -> bool:
    """Keep this process on a core; False where the system cannot, or has no such core."""
    if core is None or sys.platform != "linux":
        return False
    try:
        os.sched_setaffinity(0, {core})
    except OSError:
        return False
    return True


def memory_bytes() -> int | None:
    """Return the memory of this process, bytes (Linux); None elsewhere."""
    try:
        with open("/proc/self/statm", encoding="ascii") as figures:
            return int(figures.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, AttributeError):
        return None


async def until_stdin_ends() -> None:
    """Wait until the process at the other end of stdin is gone."""
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()

    def read() -> None:
        try:
            while os.read(0, 4096):
                pass
        except OSError:
            pass
        try:
            loop.call_soon_threadsafe(ended.set)
        except RuntimeError:  # the loop is closed
            return

    threading.Thread(target=read, name="achse-stdin", daemon=True).start()
    await ended.wait()


async def serve(
    plan: FleetPlan,
    numbers: Sequence[int],
    stop: asyncio.Event,
    send: Send,
    *,
    alone: bool = False,
    host: str | None = None,
    tcp_port: int | None = None,
    let_everybody_in: bool | None = None,
    every_s: float = 1.0,
) -> None:
    """Run these stations until `stop`, or until one of them ends.

    `send` gets `{"event": "ready", …}` of each station, then figures of each every `every_s`
    seconds. Raises ConfigError, OSError.
    """
    served: list[tuple[int, Station, RunningStation]] = []
    async with AsyncExitStack() as stack:
        for number in numbers:
            speed = plan.station(number).speed
            epoch_ns = time.time_ns() if speed == 1.0 else DEFAULT_EPOCH_NS
            config = plan.station_config(number, alone=alone)
            station = Station(config, base=plan.base, epoch_ns=epoch_ns)
            running = await stack.enter_async_context(
                station.running(host, tcp_port, speed=speed, let_everybody_in=let_everybody_in)
            )
            served.append((number, station, running))
            where = f"{running.host}:{running.tcp_port}" if running.tcp_port else ""
            send({"event": "ready", "station": number, "address": where})
        ends = [asyncio.create_task(running.finished()) for _, _, running in served]
        telling = asyncio.create_task(_send_figures(served, send, every_s))
        stopped = asyncio.create_task(stop.wait())
        try:
            done, _ = await asyncio.wait(
                (*ends, telling, stopped), return_when=asyncio.FIRST_COMPLETED
            )
            for end in done:
                end.result()
        finally:
            for task in (*ends, telling, stopped):
                task.cancel()
            await asyncio.gather(*ends, telling, stopped, return_exceptions=True)


async def _send_figures(
    served: Sequence[tuple[int, Station, RunningStation]], send: Send, every_s: float
) -> None:
    while True:
        for number, station, running in served:
            send({"event": "figures", "station": number} | _figures(station, running))
        await asyncio.sleep(every_s)


def _figures(station: Station, running: RunningStation) -> dict[str, Any]:
    figures = station.statistics()
    pace = station.pace
    cycles = 0 if pace is None else sum(pace.steps)
    networks = [routes.network for routes in running.network.mqtt]
    return {
        "state": station.state.name,
        "time_s": figures["time"],
        "tick_s": figures["tick"],
        "cycles": cycles,
        "computed_s": 0.0 if pace is None else pace.computed_ns / 1e9,
        "late": figures["late_ticks"],
        "axes": figures["axes"],
        "moving": figures["axes_moving"],
        "errors": figures["axes_in_error"],
        "requests": sum(device["requests"] for device in figures["devices"]),
        "online": any(network.online for network in networks),
        "partners": sum(len(network.partners) for network in networks),
        "memory_bytes": memory_bytes(),
    }
