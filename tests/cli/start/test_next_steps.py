"""What a person reads when a station has started: three lines whose commands are there."""

import os
import re
import shlex
import subprocess
import sys
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.main import get_command

from achse.cli.app import app
from achse.cli.start.next_steps import next_steps
from tests.warm_commands import WarmCommands

TREE: Any = get_command(app)


@pytest.mark.parametrize("page", [None, "http://127.0.0.1:8080/"])
@pytest.mark.parametrize("axes", [[], ["X"], ["Axis 1", "Y"]])
@pytest.mark.parametrize("tcp_port", [0, 48898, 5000])
@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0", "192.0.2.1"])
def test_each_command_is_there(host: str, tcp_port: int, axes: list[str], page: str | None) -> None:
    lines = next_steps(host, tcp_port, axes, page)
    commands = [name for line in lines for name in re.findall(r"achse ([^,(]+)", line)]
    assert len(lines) == 3
    assert commands
    for words in map(shlex.split, commands):
        command = TREE
        while words and hasattr(command, "commands"):
            command = command.commands[words.pop(0)]
        if tcp_port:
            assert ("--tcp-port" in words) == (tcp_port != 48898)
            assert ("--host" in words) == (host == "192.0.2.1")
    if page and tcp_port:
        assert page in lines[-1]


@given(
    host=st.ip_addresses().map(str),
    tcp_port=st.integers(0, 65535),
    axes=st.lists(st.text(min_size=1, max_size=30)),
    page=st.none() | st.text(min_size=1),
)
def test_always_three(host: str, tcp_port: int, axes: list[str], page: str | None) -> None:
    assert len(next_steps(host, tcp_port, axes, page)) == 3


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo terminal")
@pytest.mark.parametrize(("words", "lines"), [((), 5), (("--json",), 2)])
def test_only_a_terminal_gets_them(
    warm_commands: WarmCommands, words: tuple[str, ...], lines: int
) -> None:
    command = ["run", "--tcp-port", "0", "--speed", "max", "--for", "0.1", *words]
    ours, theirs = os.openpty()
    with warm_commands.popen(*command, stdout=theirs, stdin=subprocess.DEVNULL) as run:
        os.close(theirs)
        printed = b""
        try:
            while part := os.read(ours, 4096):
                printed += part
        except OSError:  # how Linux tells that the other side has closed
            pass
        os.close(ours)
    assert run.returncode == 0
    assert len(printed.splitlines()) == lines
    assert (b"\nnext:  achse axis show" in printed) == (not words)
    piped = warm_commands.run(*command).stdout
    assert len(piped.splitlines()) == 2
