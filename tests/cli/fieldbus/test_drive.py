"""`achse drive`: served over UDP until told to end; ESI and object dictionary; complaints."""

import json
import signal
import socket
import struct
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.drive.identity import PRODUCT, VENDOR
from tests.warm_commands import PIPES, WarmCommands

SERVE = ["drive", "serve", "--code", "plain", "--ordinary", "--control", "127.0.0.1:0"]


def _achse(*arguments: str, exit_code: int = 0) -> Result:
    result = CliRunner().invoke(app, ["drive", *arguments])
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


@pytest.fixture
def serving(
    warm_commands: WarmCommands,
) -> Iterator[Callable[..., tuple[subprocess.Popen[str], dict[str, str]]]]:
    """`serving(options…)` starts the command: the process, and what its ready line says."""
    started = []

    def start(*options: str, real: bool = False) -> tuple[subprocess.Popen[str], dict[str, str]]:
        run = warm_commands.popen(*SERVE, *options, real=real, **PIPES)
        started.append(run)
        assert run.stdout is not None
        words = run.stdout.readline().split()
        assert words[:3] == ["achse", "drive", "ready"]
        return run, dict(word.split("=") for word in words[3:])

    yield start
    for run in started:
        run.kill()
        run.communicate()


def test_masters_find_as_many_drives_over_udp_as_requested(serving: Callable[..., Any]) -> None:
    _, facts = serving("--udp", "127.0.0.1:0", "--count", "3", "--type", "linear")
    assert (facts["drives"], facts["type"]) == ("3", "linear")
    host, _, port = facts["udp"].rpartition(":")
    brd_type = struct.pack("<BBHHHH", 7, 1, 0, 0, 1, 0) + bytes(3)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as master:
        master.sendto(struct.pack("<H", 0x1000 | len(brd_type)) + brd_type, (host, int(port)))
        reply = master.recv(2048)
    assert int.from_bytes(reply[13:15], "little") == 3  # each drive counted


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_with_0(serving: Callable[..., Any], number: signal.Signals) -> None:
    run, _ = serving("--udp", "127.0.0.1:0", real=number == signal.SIGTERM)
    run.send_signal(number)
    rest, errors = run.communicate()
    assert (run.returncode, rest, errors) == (0, "", "")


def test_it_ends_by_itself_after_the_time_given(serving: Callable[..., Any]) -> None:
    run, _ = serving("--udp", "127.0.0.1:0", "--for", "0.05")
    assert run.wait() == 0


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ((), "say where"),
        (("lo",), "--interface lo"),
        (("127.0.0.1:34980",), "--udp"),
        (("--interface", "lo", "--udp", "127.0.0.1:0"), "say where"),
        (("--interface", "lo", "--interface", "lo"), "one interface, or two"),
        (("--interface=a", "--interface=b", "--interface=c"), "one interface, or two"),
        (("--udp", "127.0.0.1:x"), "HOST:PORT"),
        (("--udp", "127.0.0.1:70000"), "HOST:PORT"),
        (("--udp", "127.0.0.1:0", "--count", "0"), "--count"),
        (("--udp", "127.0.0.1:0", "--type", "steam"), "'steam'"),
        (("--udp", "127.0.0.1:0", "--type", "ac,linear", "--count", "3"), "--type"),
        (("--udp", "127.0.0.1:0", "--alias", "65535", "--count", "2"), "0..65535"),
        (("--udp", "127.0.0.1:0", "--control", "127.0.0.1:x"), "--control"),
    ],
)
def test_options_that_make_no_sense(options: tuple[str, ...], complaint: str) -> None:
    assert complaint in _achse("serve", *options, exit_code=2).stderr


def test_a_missing_privilege_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(socket, "AF_PACKET", 17, raising=False)
    monkeypatch.setattr("achse.transport.ethernet.socket.socket", refuse)
    [line] = _achse("serve", "--interface", "lo", exit_code=1).stderr.splitlines()
    assert "lo needs CAP_NET_RAW" in line


def test_a_port_that_is_taken_is_reported() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        where = f"127.0.0.1:{taken.getsockname()[1]}"
        [line] = _achse("serve", "--udp", where, exit_code=1).stderr.splitlines()
    assert where in line


@pytest.mark.parametrize(
    ("option", "text", "complaint"),
    [
        ("--faults", "fault = 1", "[[fault]]"),
        ("--faults", "[[fault]]\nkind = 'melt'", "kind: expected one of"),
        ("--faults", "[[fault]]\nkind = 'sto'\ndrive = 2", "there are 1, got 2"),
        ("--faults", "[[fault", "fault.file"),
        ("--store", "[]", "expected a table"),
        ("--store", '{"1": {"6085:00": -1}}', "6085:00: -1"),
    ],
)
def test_files_that_cannot_be_used(tmp_path: Path, option: str, text: str, complaint: str) -> None:
    file = tmp_path / "fault.file"
    file.write_text(text)
    refusal = _achse("serve", "--udp", "127.0.0.1:0", option, str(file), exit_code=1)
    assert complaint in refusal.stderr


def test_frames_may_be_the_clock(serving: Callable[..., Any], tmp_path: Path) -> None:
    """A fault after 50 ms waits for five frames of 10 ms each, however long that takes."""
    script = tmp_path / "faults.toml"
    script.write_text("[[fault]]\nkind = 'sto'\nat = 0.05\n")
    _, facts = serving("--udp", "127.0.0.1:0", "--frame-clock", "10", "--faults", str(script))
    environment = {"ACHSE_CONTROL_PORT": facts["control"].rpartition(":")[2]}

    def state() -> str:
        listed = CliRunner().invoke(app, ["fault", "list", "--served", "--json"], env=environment)
        return str(json.loads(listed.stdout)[0]["state"])

    host, _, port = facts["udp"].rpartition(":")
    lrw = struct.pack("<BBIHH", 12, 0, 0, 8, 0) + bytes(10)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as master:
        for _ in range(5):
            assert state() == "waiting"
            master.sendto(struct.pack("<H", 0x1000 | len(lrw)) + lrw, (host, int(port)))
            master.recv(2048)
    while state() != "active":
        pass


def test_a_control_port_that_is_taken_is_reported_and_the_drives_are_served(
    serving: Callable[..., Any],
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        where = f"127.0.0.1:{taken.getsockname()[1]}"
        run, facts = serving("--udp", "127.0.0.1:0", "--control", where)
    assert facts["control"] == "none"
    run.terminate()
    _, errors = run.communicate()
    assert where in errors


def test_each_drive_has_its_type_and_alias(serving: Callable[..., Any]) -> None:
    _, facts = serving("--udp", "127.0.0.1:0", "--type", "linear,ac", "--alias", "16")
    assert (facts["drives"], facts["type"]) == ("2", "linear,ac")


def test_the_sii_image_is_what_the_slave_holds(tmp_path: Path) -> None:
    image = tmp_path / "drive.bin"
    _achse("export", str(image), "--type", "linear", "--alias", "7")
    data = image.read_bytes()
    assert len(data) == 4096
    assert struct.unpack_from("<H", data, 8) == (7,)
    assert struct.unpack_from("<II", data, 16) == (VENDOR, PRODUCT)
    esi = tmp_path / "drive.xml"
    _achse("export", str(esi), "--type", "linear")
    assert _numbers(esi.read_text()) == (VENDOR, PRODUCT)
    assert ".xml or .bin" in _achse("export", str(tmp_path / "drive"), exit_code=2).stderr
    assert "no_such" in _achse("export", str(tmp_path / "no_such" / "x.bin"), exit_code=1).stderr


def _numbers(text: str) -> tuple[int, int]:
    """Vendor id and product code of an ESI file."""
    root = ElementTree.fromstring(text)
    device = root.find("Descriptions/Devices/Device/Type")
    assert device is not None
    vendor, product = root.findtext("Vendor/Id", ""), device.get("ProductCode", "")
    return int(vendor.replace("#x", ""), 16), int(product.replace("#x", ""), 16)


@pytest.mark.parametrize("kind", ["linear", "direct", "ac"])
def test_esi_file_has_an_identity_of_no_maker(kind: str) -> None:
    text = _achse("export", "-", "--type", kind).stdout
    assert _numbers(text) == (VENDOR, PRODUCT)
    assert "AAAA" not in text


def test_identity_of_the_manual_is_on_request(tmp_path: Path, serving: Callable[..., Any]) -> None:
    chosen = ("--identity", "manual")
    assert _numbers(_achse("export", "-", *chosen).stdout) == (0xAAAA, 5)
    image = tmp_path / "drive.bin"
    _achse("export", str(image), *chosen)
    assert struct.unpack_from("<II", image.read_bytes(), 16) == (0xAAAA, 5)
    run, _ = serving("--udp", "127.0.0.1:0", "--for", "0.01", *chosen)
    assert run.wait() == 0


def test_a_machine_file_and_the_preset(serving: Callable[..., Any], tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text("[switches]\nhome = [0, 100]\n")
    run, _ = serving(
        "--udp", "127.0.0.1:0", "--machine", str(file), "--preset", "cia402", "--for", "0.05"
    )
    assert run.wait() == 0


def test_a_machine_file_with_a_fault_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text("[switches]\nhme = [0, 100]\n")
    stderr = _achse("serve", "--udp", "127.0.0.1:0", "--machine", str(file), exit_code=1).stderr
    assert f"{file}: switches.hme: no such key" in stderr
    assert "did you mean 'home'" in stderr


def test_the_description_follows_the_preset() -> None:
    manual, cia402 = (
        _achse("export", "-", "--preset", preset).stdout for preset in ("manual", "cia402")
    )
    assert manual != cia402
    assert "#x60FF" in cia402.partition("<TxPdo")[0].rpartition("<RxPdo")[2]
