"""`achse demo` shows a move, a recording and a fault at a station, by commands you could type."""

import contextlib
import json
import os
import shlex
import subprocess
import sys
import tempfile
import webbrowser
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from achse.cli.failure import fail
from achse.cli.interrupts import INTERRUPTED, ending
from achse.cli.output import on_terminal
from achse.extras import needs_extra


class DemoStep(NamedTuple):
    """Something to see: what it is, the commands that do it, and its page in the browser."""

    text: str
    commands: tuple[str, ...]
    page: str
    refused: str = ""
    """The command whose refusal is meant."""


STEPS = (
    DemoStep(
        "An axis gets its enables and moves: a jerk-limited profile, a simulated drive behind it.",
        ("axis enable X", "axis move X --to 100 --velocity 200"),
        "axes",
    ),
    DemoStep(
        "While it moves on, the scope records it in the station's cycle: no sample is lost.",
        (
            "axis move X --to 350 --velocity 25 --no-wait",
            "scope record move.scope 500:Axes.X.ActPos 500:Axes.X.ActVelo --for 2",
            "scope show move.scope",
        ),
        "axes",
    ),
    DemoStep(
        "Faults on demand: reads of one variable are refused until the fault is cleared.",
        (
            "fault add error symbol=GVL.nInt code=0x706",
            "ads read GVL.nInt",
            "fault clear",
            "ads read GVL.nInt",
        ),
        "faults",
        refused="ads read GVL.nInt",
    ),
)

_PATIENCE_S = 60.0
"""For a station that was asked to end."""


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(demo)


def demo(
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="Go on without waiting for Enter.")
    ] = False,
    show: Annotated[bool, typer.Option("--open", help="Open its page in the browser.")] = False,
) -> None:
    """Walk through a move, a recording and a fault on a station of its own, at a free port.

    Each command is shown before it runs; type the same at a station of yours. With the extra `web`
    all of it is to be seen in the browser too. Without a terminal it does not wait.
    """
    waits = not yes and on_terminal() and sys.stdin.isatty()
    with tempfile.TemporaryDirectory(prefix="achse-demo-") as folder, _station() as (env, page):
        if page:
            print(f"In the browser: {page}")
            if show:
                webbrowser.open(page)
        elif show:
            fail(needs_extra("the page", "web"), name="CONFIGURATION")
        for number, step in enumerate(STEPS, 1):
            print(f"\n{number}. {step.text}" + (f" ({page}#{step.page})" if page else ""))
            if waits and not _enter("Enter shows it, q ends: "):
                return
            _show(step, Path(folder), env)
        if waits:
            print()
            _enter("That was it. Enter ends the station. ")
    print("\nnext:  achse run               a station that stays")
    print("       achse new cell          a station of your own, with a test")
    print("       achse --help            everything else")


def _enter(text: str) -> bool:
    """Wait for Enter; False if it is to end."""
    try:
        return input(text).strip().casefold() not in ("q", "quit", "n", "no")
    except EOFError:
        return False


def _show(step: DemoStep, folder: Path, env: dict[str, str]) -> None:
    """Run the commands of a step; one that fails, and is not meant to, ends the demo."""
    refused = step.refused
    for command in step.commands:
        print(f"$ achse {command}", flush=True)
        words = [sys.executable, "-m", "achse", *shlex.split(command)]
        code = subprocess.run(words, cwd=folder, env=env, stdin=subprocess.DEVNULL).returncode
        meant = 1 if command == refused else 0
        if command == refused:
            refused = ""  # once
        if code != meant:
            fail(f"`achse {command}` ended with exit code {code}", name="FAILED")


@contextlib.contextmanager
def _station() -> Iterator[tuple[dict[str, str], str]]:
    """A station in a process of its own: the environment of its clients, and its page or ""."""
    words = [sys.executable, "-m", "achse", "run", "--json"]
    words += ["--host", "127.0.0.1", "--tcp-port", "0"]
    with_page = all(find_spec(name) for name in ("starlette", "uvicorn", "wsproto"))
    words += ["--web", "--web-host", "127.0.0.1", "--web-port", "0"] if with_page else []
    with subprocess.Popen(
        words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, encoding="utf-8"
    ) as process:

        def leave(_: int) -> None:
            process.terminate()
            os._exit(INTERRUPTED)

        with ending(leave):
            assert process.stdout is not None
            try:
                facts = [json.loads(process.stdout.readline()) for _ in range(1 + with_page)]
            except ValueError:  # it has reported the reason
                raise typer.Exit(process.wait() or 1) from None
            tcp_port = facts[0]["tcp"].rpartition(":")[2]
            env = os.environ | {"ACHSE_HOST": "127.0.0.1", "ACHSE_TCP_PORT": tcp_port}
            try:
                yield env, facts[1]["url"] if with_page else ""
            finally:
                process.terminate()
                process.wait(_PATIENCE_S)
