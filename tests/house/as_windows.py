"""Runs achse in this interpreter without what Windows lacks.

    python -m tests.house.as_windows [--all]

Modules and names that Windows does not have are taken away, and `sys.platform` says win32, before
the first module of achse is imported. Then a station runs on a loop that watches no descriptors,
and a client moves an axis over TCP; with --all, all modules are imported before. The names are
those that the standard library's documentation marks as "Availability: Unix" or Linux.
"""

import asyncio
import ctypes
import importlib
import mmap
import os
import pkgutil
import signal
import socket
import subprocess
import sys
import tempfile
from types import ModuleType, SimpleNamespace
from typing import TYPE_CHECKING, Any

MODULES = (
    "fcntl",
    "grp",
    "pty",
    "pwd",
    "readline",
    "resource",
    "syslog",
    "termios",
    "tty",
    "uvloop",
)
NAMES: dict[Any, tuple[str, ...]] = {
    os: (
        "fchmod", "fchown", "fork", "getpgid", "getuid", "geteuid", "getgid", "getloadavg",
        "killpg", "mkfifo", "nice", "pread", "pwrite", "sched_getaffinity", "sched_setaffinity",
        "sched_setscheduler", "sendfile", "setsid", "statvfs", "uname", "wait", "wait4",
    ),
    signal: ("SIGALRM", "SIGCHLD", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGQUIT", "SIGUSR1", "SIGUSR2"),
    socket: ("AF_NETLINK", "AF_PACKET", "AF_UNIX", "SO_BINDTODEVICE", "SO_REUSEPORT",
             "TCP_QUICKACK"),
    mmap: ("MAP_ANONYMOUS", "MAP_PRIVATE", "PROT_EXEC", "PROT_READ", "PROT_WRITE"),
}  # fmt: skip
NEEDED = (
    "typer", "rich.console", "pydantic.main", "zoneinfo", "logging.handlers", "selectors",
    "asyncio.subprocess",
)  # fmt: skip
OF_OTHERS = (
    *NEEDED, "click", "rich.table", "starlette.applications", "uvicorn",
    "wsproto", "aiomqtt", "OpenSSL", "pygls", "mcp", "llvmlite.binding", "prometheus_client",
    "numpy", "pandas", "polars", "dask", "distributed", "fmpy", "serial_asyncio_fast",
    "pytest", "_pytest", "concurrent.futures.process", "multiprocessing", "webbrowser",
    "tomllib", "sqlite3", "zipfile", "email.message", "http.client",
)  # fmt: skip
"""Loaded before, as they would look for modules of the real Windows."""


class WithoutDescriptors(asyncio.selector_events.BaseSelectorEventLoop):
    """The loop of Windows does I/O by completion: it watches no descriptors, handles no signals."""

    def _refuse(self, *_: Any) -> None:
        raise NotImplementedError

    if not TYPE_CHECKING:
        add_reader = add_writer = add_signal_handler = _refuse


def pretend() -> None:
    """Take away what Windows lacks; modules of achse come after."""
    for name in OF_OTHERS if "--all" in sys.argv else NEEDED:
        try:
            importlib.import_module(name)
        except ImportError:  # an extra that is not here
            continue
    for name in MODULES:
        sys.modules[name] = None  # type: ignore[assignment]  # ImportError for who asks
    locks = ModuleType("msvcrt")
    locks.LK_NBLCK, locks.locking = 2, lambda *_: None  # type: ignore[attr-defined]
    sys.modules["msvcrt"] = locks
    for module, names in NAMES.items():
        for name in names:
            if hasattr(module, name):
                delattr(module, name)
    subprocess.CREATE_NEW_PROCESS_GROUP, subprocess.DETACHED_PROCESS = 0x200, 8  # type: ignore[attr-defined]
    socket.socketpair = _pair  # type: ignore[assignment]
    ctypes.WinDLL = _kernel  # type: ignore[attr-defined]
    sys.platform = "win32"


def _pair(*_: object) -> tuple[socket.socket, socket.socket]:
    """Return two connected sockets, as Windows pairs them: over TCP."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        ours = socket.create_connection(listening.getsockname())
        return ours, listening.accept()[0]


def _kernel(_: str) -> Any:
    def limits(low: Any, high: Any) -> None:
        low._obj.value, high._obj.value = 1, sys.maxsize

    return SimpleNamespace(GetCurrentThreadStackLimits=limits)


def imported() -> tuple[int, list[str]]:
    """Import each module of achse; return their number and what failed."""
    import achse

    count, failed = 0, []
    for each in pkgutil.walk_packages(achse.__path__, "achse."):
        if each.name.endswith("__main__"):
            continue
        count += 1
        try:
            importlib.import_module(each.name)
        except ImportError as failure:
            failed.append(f"{each.name}: {failure}")
    return count, failed


async def moved() -> float:
    """Return the position after a move over TCP at a station that is paced by the wall clock."""
    import achse
    from achse.station import Station
    from achse.transport.tcp import listener

    vars(listener)["os"] = SimpleNamespace(name="nt")
    async with (
        Station.demo().running("127.0.0.1", 0) as running,
        achse.connect(f"127.0.0.1:{running.tcp_port}") as client,
    ):
        x = client.nc.axis("X")
        await x.enable()
        await x.move_to(1, velocity=200)
        return await x.position()


def branches() -> None:
    """Run the branches that only say win32. Raises AssertionError."""
    from achse.cli.process import loop_factory, raise_file_limit
    from achse.cli.start.detached import own_session, runtime_folder
    from achse.native.backend.thread_stack import bounds_of_this_thread
    from achse.transport.file_lock import lock_file

    raise_file_limit()
    assert loop_factory() is None
    assert "creationflags" in own_session()
    assert bounds_of_this_thread(2).low == 1
    with tempfile.TemporaryFile("w+") as file:
        assert lock_file(file)
    assert runtime_folder().is_dir()


def main() -> None:
    """Print how far it got; exit code 1 if a module cannot be imported."""
    pretend()
    failed: list[str] = []
    if "--all" in sys.argv:
        count, failed = imported()
        print(*failed, f"{count} modules", sep="\n")
    branches()
    with asyncio.Runner(loop_factory=WithoutDescriptors) as runner:
        print(f"{runner.run(moved()):.0f} mm")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
