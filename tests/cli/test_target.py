"""Client commands: where they connect, and how they end."""

import os
import signal
import socket
from collections.abc import Callable
from typing import Any

import pytest

from achse.cli.target import endpoint
from tests.warm_commands import PIPES, WarmCommands


def test_no_client_listens(cli: Callable[..., Any]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        free = server.getsockname()[1]
    result = cli("ads", "state", "--tcp-port", str(free), exit_code=1)
    assert result.stdout == ""
    assert f"cannot connect to 127.0.0.1:{free}" in result.stderr
    assert result.stderr.count("\n") == 1
    assert result.stderr.count("achse run --detach") == 1


def test_what_can_be_no_host_name_is_reported(cli: Callable[..., Any]) -> None:
    result = cli("ads", "state", "--host", "a..b", exit_code=1)
    assert result.stderr.startswith("cannot connect to a..b:")
    assert result.stderr.count("\n") == 1


def test_host_has_its_tcp_port_behind_a_colon(
    cli: Callable[..., Any], environment: dict[str, str]
) -> None:
    where = f"127.0.0.1:{environment['ACHSE_TCP_PORT']}"
    for words in (("ads", "state"), ("wait",)):
        assert cli(*words, "--host", where, "--tcp-port", "1").stdout
    refusal = cli("ads", "state", "--host", "127.0.0.1:70000", exit_code=2).stderr
    assert "a TCP port is 1..65535, got '127.0.0.1:70000'" in refusal


@pytest.mark.parametrize(
    ("host", "tcp_port", "where"),
    [
        ("127.0.0.2", 0, ("127.0.0.2", 0)),
        ("127.0.0.2:5000", None, ("127.0.0.2", 5000)),
        ("127.0.0.2:5000", 1, ("127.0.0.2", 5000)),
        ("::1", None, ("::1", None)),
        ("[::1]", 7, ("::1", 7)),
        ("[::1]:5000", None, ("::1", 5000)),
    ],
)
def test_address_to_listen_on_may_have_its_port(
    host: str, tcp_port: int | None, where: tuple[str, int | None]
) -> None:
    assert endpoint(host, tcp_port) == where


def test_a_port_without_device_is_reported_by_code_and_name(cli: Callable[..., Any]) -> None:
    result = cli("ads", "state", "--port", "852", exit_code=1)
    assert "127.0.0.1.1.1:852" in result.stderr
    assert "0x6 TARGET_PORT_NOT_FOUND" in result.stderr


def test_a_net_id_that_is_none_is_bad_usage(cli: Callable[..., Any]) -> None:
    result = cli("ads", "state", "--net-id", "1.2.3", exit_code=2)
    assert "six numbers" in result.stderr


def test_the_net_id_of_the_station_can_be_named(cli: Callable[..., Any]) -> None:
    assert cli("ads", "state", "--net-id", "127.0.0.1.1.1").stdout.startswith("RUN")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("command", ["ads read --watch MAIN.nCounter", "axis show X --watch"])
def test_a_watch_ends_cleanly_by_signal(
    warm_commands: WarmCommands, environment: dict[str, str], number: signal.Signals, command: str
) -> None:
    watch = warm_commands.popen(*command.split(), env=os.environ | environment, **PIPES)
    assert watch.stdout is not None
    assert watch.stdout.readline()
    watch.send_signal(number)
    _, errors = watch.communicate()
    assert (watch.returncode, errors) == (0, "")


@pytest.mark.parametrize(
    "words",
    [
        ("state", "--port", "852"),
        ("read", "852:foo"),
        ("read", "GVL.nInt", "852:foo"),
        ("write", "852:foo", "3"),
        ("read", "--watch", "852:foo"),
    ],
    ids=" ".join,
)
def test_ports_that_answer_are_reported_where_one_is_not_there(
    cli: Callable[..., Any], words: tuple[str, ...]
) -> None:
    refusal = cli("ads", *words, exit_code=1).stderr
    ports = refusal.partition("ports that answer: ")[2].strip().split(", ")
    assert {"500", "851", "10000", "26000"} <= set(ports)
    assert "852" not in ports


def test_a_station_without_a_bus_is_reported(cli: Callable[..., Any]) -> None:
    refusal = cli("bus", "state", exit_code=1).stderr
    assert "this station has no bus; ports that answer: " in refusal
