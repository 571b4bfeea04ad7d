"""`achse bus scan|eeprom`: slaves at an interface, without a station."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.ethercat import Loopback, Segment, Slave, build_sii, describe
from achse.ethercat.esi import build_esi
from achse.ethercat.master.eni import read_eni
from achse.transport import ethernet

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


class CableToSegment:
    """An interface with a segment at its other end."""

    slaves: Segment

    def __init__(self, interface: str) -> None:
        if interface != "cable0":
            raise ethernet.LinkError(f"no interface {interface}")
        self.replies: list[bytes] = []

    def send(self, frame: bytes) -> bool:
        reply = self.slaves.process(frame)
        if reply is not None:
            self.replies.append(reply)
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        return self.replies.pop(0) if self.replies else None

    def close(self) -> None: ...


@pytest.fixture
def interface(monkeypatch: pytest.MonkeyPatch) -> Segment:
    CableToSegment.slaves = Segment(Slave(Loopback(serial_number=number)) for number in range(2))
    monkeypatch.setattr(ethernet, "EthernetLink", CableToSegment)
    return CableToSegment.slaves


def test_an_interface_is_scanned(
    lines: Lines, cli: Cli, interface: Segment, tmp_path: Path
) -> None:
    file = tmp_path / "bus.eni"
    shown = lines("bus", "scan", "--interface", "cable0", "--eni", str(file))
    assert shown[1].split()[0] == "1001"
    assert [each.station for each in read_eni(file.read_bytes()).slaves] == [1001, 1002]
    esi = tmp_path / "box.xml"
    esi.write_text(build_esi(describe(Loopback()), vendor="nobody"))
    lines("bus", "scan", "--interface", "cable0", "--eni", str(file), "--esi", str(esi))
    assert read_eni(file.read_bytes()).slaves[0].clock is None  # FreeRun is its first mode
    esi.write_text("<a/>")
    stderr = cli("bus", "scan", "--interface", "cable0", "--esi", str(esi), exit_code=1).stderr
    assert "expected EtherCATInfo, the root is a" in stderr
    document = json.loads(cli("bus", "scan", "--interface", "cable0", "--json").stdout)
    assert [each["output_bits"] for each in document] == [32, 32]
    assert "no interface eth9" in cli("bus", "scan", "--interface", "eth9", exit_code=1).stderr


def test_an_eeprom_is_shown_saved_and_written(
    lines: Lines, cli: Cli, interface: Segment, tmp_path: Path
) -> None:
    image = tmp_path / "image.bin"
    shown = lines("bus", "eeprom", "--interface", "cable0", "1", "--output", str(image))
    assert ["name", "loopback"] in [line.split() for line in shown]
    other = tmp_path / "other.bin"
    other.write_bytes(build_sii(describe(Loopback(2, "another")))[:512])
    shown = lines("bus", "eeprom", "--interface", "cable0", "1", "--write", str(other))
    assert ["name", "another"] in [line.split() for line in shown]
    other.write_bytes(bytes(200))
    wrong = cli("bus", "eeprom", "--interface", "cable0", "1", "--write", str(other), exit_code=1)
    assert "checksum" in wrong.stderr
    none = cli("bus", "eeprom", "--interface", "cable0", "7", exit_code=1)
    assert "there are 2 slaves" in none.stderr
