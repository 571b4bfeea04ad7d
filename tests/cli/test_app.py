"""The command tree is whole, and every command explains itself."""

import re
from collections.abc import Iterator
from typing import Any

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from achse.cli.app import app


def _leaves(
    command: object, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], object]]:
    children = getattr(command, "commands", None)
    if children is None:
        yield path, command
        return
    for name, child in children.items():
        yield from _leaves(child, (*path, name))


COMMANDS = dict(_leaves(get_command(app)))


OVER_UDP = {("ads", "scan"), ("ads", "route", "add")}
"""Commands that search or ask a router before there is a connection."""


def test_these_commands_are_there() -> None:
    ads = ("state", "read", "write", "scan", "raw", "stats")
    axis = ("show", "enable", "disable", "move", "stop", "reset")
    assert set(COMMANDS) >= {
        ("run",),
        ("check",),
        ("docs",),
        ("hash-password",),
        *(("ads", name) for name in ads),
        *(("ads", "route", name) for name in ("add", "list", "remove")),
        *(("axis", name) for name in axis),
        *(("drive", name) for name in ("serve", "export", "objects")),
    }


def test_commands_are_at_most_ninety() -> None:
    """A newcomer finds each by guessing: merge what overlaps (decision 0164)."""
    assert len(COMMANDS) <= 90


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_each_command_has_help(path: tuple[str, ...]) -> None:
    result = CliRunner().invoke(app, [*path, "--help"])
    assert result.exit_code == 0
    assert "Usage:" in result.stdout


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_no_help_has_words_in_brackets_which_the_terminal_would_swallow(
    path: tuple[str, ...],
) -> None:
    command: Any = COMMANDS[path]
    texts = [command.help or "", *(getattr(item, "help", "") or "" for item in command.params)]
    assert not [text for text in texts if re.search(r"(?<!\\)\[[a-z@/]", text)]


@pytest.mark.parametrize(
    "path",
    [path for path in COMMANDS if path[0] in ("ads", "axis") and path not in OVER_UDP],
    ids=" ".join,
)
def test_each_client_command_takes_a_target_and_can_print_json(path: tuple[str, ...]) -> None:
    options = {
        option
        for parameter in COMMANDS[path].params  # type: ignore[attr-defined]
        for option in parameter.opts
    }
    assert {"--host", "--tcp-port", "--net-id", "--port", "--timeout", "--json"} <= options
