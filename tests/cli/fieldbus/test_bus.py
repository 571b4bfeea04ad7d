"""`achse bus`: a bus beside the demo station, and slaves on an interface."""

import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.cli.fieldbus.bus import bus
from achse.codes import AlState
from achse.devices.io import AttachedBuses, ServedBus, default_net_id
from achse.drive import Drive
from achse.drive.firmware import Firmware
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.foe import FoeServer
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master import BusConfiguration, Master, Ring, from_description

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


def segment() -> Segment:
    return Segment(Slave(Loopback(serial_number=number)) for number in range(2))


@pytest.fixture(autouse=True)
def box(live: Any) -> Iterator[Ring]:
    """A bus whose frames go round with each step of the demo station."""
    slaves = tuple(
        from_description(describe(Loopback(serial_number=number)), f"Box {number + 1}")
        for number in range(2)
    )
    ring = Ring(Master(BusConfiguration(slaves)), segment())
    router = live.station.router
    served = ServedBus(1, ring.master, default_net_id(router.net_id, 1))
    attached = AttachedBuses(router, [served], clock=lambda: 0)
    live.hook = lambda: ring.exchange(ring.master.now_ns + 2_000_000)
    ring.master.request(AlState.OP)
    yield ring
    live.hook = None
    attached.close()


def up(lines: Lines) -> list[str]:
    """The states once all are in Op."""
    for _ in range(200):
        shown = lines("bus", "state")
        if shown[0] == "bus: OP; no fault":
            return shown
    raise AssertionError(shown)


def test_states_are_shown_and_requested(lines: Lines, cli: Cli) -> None:
    assert bus.info.help
    assert up(lines)[1:] == ["1001  OP  no fault", "1002  OP  no fault"]
    lines("bus", "state", "1002", "safeop")
    assert lines("bus", "state", "--all", "op")[0].startswith("bus:")
    up(lines)
    document = json.loads(cli("bus", "state", "1001", "--json").stdout)
    assert [each["station"] for each in document["slaves"]] == [1001]
    assert "no slave has the address 1099" in cli("bus", "state", "1099", exit_code=1).stderr
    assert (
        "init, preop, boot, safeop or op" in cli("bus", "state", "1001", "fast", exit_code=2).stderr
    )


def test_slaves_are_listed(lines: Lines, cli: Cli) -> None:
    up(lines)
    _, header, first, second = lines("bus", "state", "--identity")
    assert header.split()[:4] == ["station", "name", "state", "vendor"]
    assert first.split() == [
        "1001",
        "Box",
        "1",
        "OP",
        *("00000000", "0000100B", "00000001", "none"),
    ]
    assert second.split()[0] == "1002"
    assert json.loads(cli("bus", "state", "--json").stdout)["slaves"][1]["serial"] == 1
    assert cli("bus", "state", "--device", "3", exit_code=1).stderr


def test_objects_are_read_and_written(lines: Lines, cli: Cli) -> None:
    up(lines)
    assert lines("bus", "sdo", "1001", "0x1000") == [
        "1000:00 = 0xC0DE0001 3235774465 (-1059192831)"
    ]
    assert lines("bus", "sdo", "1001", "0x2000", "-2", "--size", "1") == ["2000:00 = 0xFE 254 (-2)"]
    report = json.loads(cli("bus", "sdo", "1001", "0x1018:2", "--json").stdout)
    assert (report["value"], report["index"]) == (0x100B, "0x1018")
    assert lines("bus", "sdo", "1001", "0x1018", "--complete")[0].startswith("0000")
    assert cli("bus", "sdo", "1001", "0x5FFF", exit_code=1).stderr
    assert cli("bus", "sdo", "1001", "x", exit_code=2).stderr
    assert cli("bus", "sdo", "1001", "0x7000:1", "300", "--size", "1", exit_code=2)


def test_statistics(lines: Lines, cli: Cli) -> None:
    up(lines)
    shown = lines("bus", "state", "--statistics", "--reset")
    assert shown[0].startswith("cyclic")
    assert shown[-1].split() == ["1002", "0", "0", "0", "0"]
    document = json.loads(cli("bus", "state", "--statistics", "--json").stdout)
    assert (document["cyclic_lost"], len(document["slaves"])) == (0, 2)


def test_changes_are_watched(lines: Lines) -> None:
    up(lines)
    first, second = lines("bus", "state", "--watch", "--count", "2")
    assert first == "1001  Box 1  OP  no fault"
    assert second == "1002  Box 2  OP  no fault"


def test_files_are_read_and_written(
    lines: Lines, cli: Cli, box: Ring, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    up(lines)
    lines("bus", "state", "1001", "preop")
    drive = Drive(firmware=Firmware(content=bytes(range(256)) * 200, password=7))
    files = FoeServer(drive)
    files.reset(256, 256)
    services = box.segment.slaves[0]._mailbox._services
    monkeypatch.setitem(services, MailboxProtocol.FOE, files.answer)
    saved, new = tmp_path / "saved", tmp_path / "new"
    new.write_bytes(b"new")
    output = lines("bus", "file", "1001", "firmware.bin", "-o", str(saved), "--password", "7")
    assert output == ["firmware.bin: 51200 bytes read"]
    assert saved.read_bytes() == drive.firmware.content

    def answer(data: bytes) -> Iterable[bytes] | int:
        drive.step(1_000_000)  # time passes between two messages
        return files.answer(data)

    monkeypatch.setitem(services, MailboxProtocol.FOE, answer)
    document = cli(
        "bus", "file", "1001", "firmware.bin", "--write", str(new), "--password", "7", "--json"
    )
    assert json.loads(document.stdout)["bytes"] == 3
    assert drive.firmware.content == b"new"
    for each in (("-o", str(saved)), ("--write", str(new))):
        refused = cli("bus", "file", "1001", "firmware.bin", *each, exit_code=1)
        assert "0x704" in refused.stderr
    assert "either" in cli("bus", "file", "1001", "x", exit_code=2).stderr
    lines("bus", "state", "1001", "op")
