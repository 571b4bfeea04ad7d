"""A station on a loopback port, twenty times as fast as the clock, and commands that talk to it."""

import asyncio
import functools
import json
import logging
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest
import typer.testing
from typer.main import get_command
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.station import Station

SPEED = 20.0

# CliRunner builds the tree of all commands for each call, which takes longer than most commands.
typer.testing._get_command = functools.cache(get_command)  # type: ignore[attr-defined]


@pytest.fixture(autouse=True)
def root_logger() -> Iterator[None]:
    """Commands that run in this process set up logs: others find the root logger as it was."""
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    yield
    root.handlers[:] = handlers
    root.setLevel(level)


@dataclass
class LiveStation:
    """A demo station that runs in a thread of its own."""

    station: Station = field(default_factory=Station.demo)
    tcp_port: int = 0
    hook: Callable[[], None] | None = None
    """Called after each step, in the station's thread."""

    async def serve(self, ready: threading.Event, leave: asyncio.Event) -> None:
        step = self.station.cycle.step

        def hooked() -> None:
            step()
            if self.hook is not None:
                self.hook()

        self.station.cycle.step = hooked  # type: ignore[method-assign]
        async with self.station.running("127.0.0.1", 0, speed=SPEED) as running:
            self.tcp_port = running.tcp_port
            ready.set()
            await leave.wait()


@pytest.fixture
def live() -> Iterator[LiveStation]:
    """Run a station for the test."""
    live = LiveStation()
    ready = threading.Event()
    loop = asyncio.new_event_loop()
    leave = asyncio.Event()
    thread = threading.Thread(
        target=lambda: loop.run_until_complete(live.serve(ready, leave)), daemon=True
    )
    thread.start()
    ready.wait()
    yield live
    loop.call_soon_threadsafe(leave.set)
    thread.join()
    loop.close()


@pytest.fixture
def environment(live: LiveStation) -> dict[str, str]:
    """What makes every client command talk to the live station."""
    return {"ACHSE_HOST": "127.0.0.1", "ACHSE_TCP_PORT": str(live.tcp_port), "COLUMNS": "100"}


Cli = Callable[..., Result]


@pytest.fixture
def cli(environment: dict[str, str]) -> Cli:
    """`cli("ads", "state")` runs the command in this process; `exit_code` says what to expect."""

    def run(*arguments: str, exit_code: int = 0) -> Result:
        result = CliRunner().invoke(app, arguments, env=environment)
        assert result.exit_code == exit_code, (result.output, result.exception)
        return result

    return run


@pytest.fixture
def lines(cli: Cli) -> Callable[..., list[str]]:
    """The lines a command prints on stdout; there must be nothing on stderr."""

    def run(*arguments: str) -> list[str]:
        result = cli(*arguments)
        assert result.stderr == ""
        assert all(line == line.rstrip() for line in result.stdout.splitlines())
        return list(result.stdout.splitlines())

    return run


@pytest.fixture
def document(cli: Cli) -> Callable[..., Any]:
    """What a command prints with --json."""
    return lambda *arguments: json.loads(cli(*arguments, "--json").stdout)
