"""`achse bus serve|channel`: slaves of ESI files over UDP, their channels by name, complaints."""

import json
import socket
import struct
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from tests.ethercat.virtual.esi_text import ANALOG, DIGITAL_IN, esi
from tests.warm_commands import WarmCommands

Achse = Callable[..., Result]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("esi")
    (place / "boxes.xml").write_text(esi(DIGITAL_IN, ANALOG))
    return place


@pytest.fixture(scope="module")
def served(folder: Path, warm_commands: WarmCommands) -> Iterator[dict[str, str]]:
    """Where the slaves and their control listen."""
    command = ("bus", "serve", "DI8*2", "AIO", "--esi", str(folder), "--ordinary")
    where = ("--udp", "127.0.0.1:0", "--control", "127.0.0.1:0")
    with warm_commands.popen(*command, *where, stdout=subprocess.PIPE) as run:
        assert run.stdout is not None
        words = run.stdout.readline().split()
        assert words[:3] == ["achse", "bus", "ready"]
        yield dict(word.split("=") for word in words[3:])
        run.terminate()
        assert run.wait() == 0


@pytest.fixture
def achse(served: dict[str, str]) -> Achse:
    def call(*arguments: str, exit_code: int = 0) -> Result:
        port = served["control"].rpartition(":")[2]
        environment = {"ACHSE_CONTROL_PORT": port, "COLUMNS": "120"}
        result = CliRunner().invoke(app, ["bus", *arguments], env=environment)
        assert result.exit_code == exit_code, (result.output, result.exception)
        return result

    return call


def test_each_slave_answers(served: dict[str, str]) -> None:
    assert served["slaves"] == "3"
    host, _, port = served["udp"].rpartition(":")
    brd_type = struct.pack("<BBHHHH", 7, 1, 0, 0, 1, 0) + bytes(3)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as master:
        master.sendto(struct.pack("<H", 0x1000 | len(brd_type)) + brd_type, (host, int(port)))
        reply = master.recv(2048)
    assert int.from_bytes(reply[13:15], "little") == 3


def test_channels_are_set_read_and_listed(achse: Achse) -> None:
    assert achse("channel", "PDO 1A02.Input", "1", "--slave", "2").stdout.endswith("= true\n")
    assert achse("channel", "Level", "2.5", "-s", "3").stdout == "Level = 2.5\n"
    assert json.loads(achse("channel", "Valve", "-s", "3", "--json").stdout)["value"] == 0
    rows = [each.split() for each in achse("channel").stdout.splitlines()]
    assert rows[0] == ["slave", "type", "state", "channel", "direction", "value"]
    assert ["2", "DI8", "INIT", "PDO", "1A02.Input", "input", "true"] in rows
    assert len(json.loads(achse("channel", "--json").stdout)) == 21


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("channel", "Valve", "1", "-s", "3"), 1, "is an output of AIO"),
        (("channel", "Nothing"), 1, "no channel 'Nothing'"),
        (("channel", "Level", "much", "-s", "3"), 2, "a number, true or false"),
    ],
)
def test_channel_that_cannot_be_is_reported(
    achse: Achse, arguments: tuple[str, ...], code: int, message: str
) -> None:
    assert message in achse(*arguments, exit_code=code).stderr


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (("DI9",), 1, "no device 'DI9' in the ESI files; there are: DI8"),
        (("DI8", "--behaviour", "1=x"), 1, "expected loop-back"),
        (("DI8", "--alias", "65535", "DI8"), 1, "0..65535 for each slave"),
        (("DI8", "--control", "127.0.0.1:x"), 2, "--control"),
        (("DI8",), 2, "say where"),
    ],
)
def test_line_that_cannot_be_is_reported(
    folder: Path, options: tuple[str, ...], code: int, message: str
) -> None:
    command = ["bus", "serve", *options, "--esi", str(folder), "--control", "none"]
    if "--control" in options:
        command = command[:-2]
    result = CliRunner().invoke(app, command)
    assert (result.exit_code, message in result.stderr) == (code, True), result.stderr
