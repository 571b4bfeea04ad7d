"""`achse drive`: served over UDP until told to end; ESI and object dictionary; complaints."""

import json
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.drive.objects import ROWS

SERVE = [sys.executable, "-m", "achse", "drive", "serve", "--interpreted"]


def _achse(*arguments: str, exit_code: int = 0) -> Result:
    result = CliRunner().invoke(app, ["drive", *arguments])
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


@pytest.fixture
def serving() -> Iterator[Callable[..., tuple[subprocess.Popen[str], dict[str, str]]]]:
    """`serving(options…)` starts the command: the process, and what its ready line says."""
    started = []

    def start(*options: str) -> tuple[subprocess.Popen[str], dict[str, str]]:
        run = subprocess.Popen(
            [*SERVE, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        started.append(run)
        assert run.stdout is not None
        words = run.stdout.readline().split()
        assert words[:3] == ["achse", "drive", "ready"]
        return run, dict(word.split("=") for word in words[3:])

    yield start
    for run in started:
        run.kill()
        run.communicate()


def test_masters_find_as_many_drives_over_udp_as_asked_for(serving: Callable[..., Any]) -> None:
    _, told = serving("--udp", "127.0.0.1:0", "--count", "3", "--type", "linear")
    assert (told["drives"], told["type"]) == ("3", "linear")
    host, _, port = told["udp"].rpartition(":")
    brd_type = struct.pack("<BBHHHH", 7, 1, 0, 0, 1, 0) + bytes(3)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as master:
        master.settimeout(10)
        master.sendto(struct.pack("<H", 0x1000 | len(brd_type)) + brd_type, (host, int(port)))
        reply = master.recv(2048)
    assert int.from_bytes(reply[13:15], "little") == 3  # each drive counted


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_with_0(serving: Callable[..., Any], number: signal.Signals) -> None:
    run, _ = serving("--udp", "127.0.0.1:0")
    run.send_signal(number)
    rest, errors = run.communicate(timeout=10)
    assert (run.returncode, rest, errors) == (0, "", "")


def test_it_ends_by_itself_after_the_time_given(serving: Callable[..., Any]) -> None:
    run, _ = serving("--udp", "127.0.0.1:0", "--for", "0.05")
    assert run.wait(timeout=10) == 0


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ((), "say where"),
        (("--interface", "lo", "--udp", "127.0.0.1:0"), "say where"),
        (("--udp", "127.0.0.1:x"), "HOST:PORT"),
        (("--udp", "127.0.0.1:70000"), "HOST:PORT"),
        (("--udp", "127.0.0.1:0", "--count", "0"), "--count"),
        (("--udp", "127.0.0.1:0", "--type", "steam"), "--type"),
    ],
)
def test_options_that_make_no_sense(options: tuple[str, ...], complaint: str) -> None:
    assert complaint in _achse("serve", *options, exit_code=2).stderr


def test_a_missing_privilege_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(socket, "AF_PACKET", 17, raising=False)
    monkeypatch.setattr("achse.transport.ethernet.socket.socket", refuse)
    [line] = _achse("serve", "--interface", "lo", exit_code=1).stderr.splitlines()
    assert "lo needs CAP_NET_RAW" in line


def test_a_port_that_is_taken_is_told() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        where = f"127.0.0.1:{taken.getsockname()[1]}"
        [line] = _achse("serve", "--udp", where, exit_code=1).stderr.splitlines()
    assert where in line


@pytest.mark.parametrize("kind", ["linear", "direct", "ac"])
def test_the_esi_file_names_maker_and_product(kind: str) -> None:
    root = ElementTree.fromstring(_achse("esi", "--type", kind).stdout)
    device = root.find("Descriptions/Devices/Device/Type")
    assert device is not None
    assert (root.findtext("Vendor/Id"), device.get("ProductCode")) == ("#x0000AAAA", "#x00000005")


def test_the_list_has_a_line_for_every_entry() -> None:
    heading, *lines = _achse("list").stdout.splitlines()
    assert heading.split() == ["index", "type", "access", "pdo", "default", "unit", "name"]
    assert [line.split()[0] for line in lines] == [
        f"{row.index:04X}:{row.subindex:02X}" for row in ROWS
    ]


def test_the_list_can_be_narrowed_and_printed_as_json() -> None:
    facts = json.loads(_achse("list", "0x607", "--json").stdout)
    assert {fact["index"][:5] for fact in facts} == {"0x607"}
    [target] = [fact for fact in facts if fact["index"] == "0x607A"]
    assert (target["name"], target["type"], target["pdo"]) == (
        "Target position",
        "I32",
        ["Rx", "Tx"],
    )


def test_one_entry_is_shown_with_all_that_is_known() -> None:
    shown = dict(line.split(None, 1) for line in _achse("show", "1C32:02").stdout.splitlines())
    assert (shown["index"], shown["subindex"], shown["unit"]) == ("0x1C32", "2", "ns")
    assert "minimum" in shown


def test_an_object_is_shown_with_its_entries() -> None:
    facts = json.loads(_achse("show", "1018h", "--json").stdout)
    assert [fact["default"] for fact in facts[:3]] == [4, 0xAAAA, 5]


@pytest.mark.parametrize("arguments", [("show", "5FFF"), ("show", "6041:7"), ("list", "F")])
def test_what_the_drive_does_not_have(arguments: tuple[str, ...]) -> None:
    assert "achse drive list" in _achse(*arguments, exit_code=1).stderr


@pytest.mark.parametrize("entry", ["speed", "", "12345", "6041:", "6041:100"])
def test_an_entry_that_is_no_number(entry: str) -> None:
    assert "hexadecimal" in _achse("show", entry, exit_code=2).stderr
