"""The service manager that started this process, systemd: ready, alive, stopping.

Source: sd_notify(3) and sd_watchdog_enabled(3): datagrams to the socket that NOTIFY_SOCKET names.
"""

import asyncio
import contextlib
import logging
import os
import socket
from collections.abc import AsyncIterator, Awaitable, Callable

log = logging.getLogger("achse.cli")


def notify(state: str) -> bool:
    """Send a state such as READY=1; False without a service manager that waits for it."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address.startswith(("/", "@")) or not hasattr(socket, "AF_UNIX"):
        return False
    name = "\0" + address[1:] if address.startswith("@") else address
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line:
            line.setblocking(False)
            line.sendto(state.encode(), name)
    except OSError as failure:
        log.warning("service manager not notified of %s: %s", state, failure.strerror or failure)
        return False
    return True


def watchdog_interval() -> float | None:
    """Return the seconds between two signs of life, half of what is allowed; None: none wanted."""
    allowed, process = os.environ.get("WATCHDOG_USEC", ""), os.environ.get("WATCHDOG_PID", "")
    if not allowed.isdecimal() or not int(allowed) or process not in ("", str(os.getpid())):
        return None
    return int(allowed) / 2e6


@contextlib.asynccontextmanager
async def announced(
    sleep: Callable[[float], Awaitable[object]] = asyncio.sleep,
) -> AsyncIterator[None]:
    """Notify the service manager: this process is ready, then alive, then ended.

    The signs of life come from the event loop, so a loop that hangs gives none.
    """
    interval = watchdog_interval()
    alive: asyncio.Task[None] | None = None
    if notify("READY=1") and interval is not None:
        alive = asyncio.create_task(_stay_alive(interval, sleep), name="watchdog")
    try:
        yield
    finally:
        if alive is not None:
            alive.cancel()
        notify("STOPPING=1")


async def _stay_alive(interval: float, sleep: Callable[[float], Awaitable[object]]) -> None:
    while True:
        notify("WATCHDOG=1")
        await sleep(interval)
