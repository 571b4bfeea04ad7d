"""Scans: the configuration of a bus as it is brings the same bus up."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.codes import AlState
from achse.drive import Drive
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.master import BusConfiguration, Master, Ring
from achse.ethercat.master.errors import FrameLost
from achse.ethercat.master.scanning import ScannedSlave, scan_bus
from achse.ethercat.master.traffic import AcyclicTraffic


def scan(segment: Segment, **options: Any) -> list[ScannedSlave]:
    """Scan a segment, with traffic of its own."""
    traffic = AcyclicTraffic(5_000_000)
    job = traffic.start(scan_bus(**options))
    now = 0
    while not job.is_done:
        now += 100_000
        segment.advance(now)
        for frame in traffic.frames(now, 1):
            reply = segment.process(frame)
            if reply is not None:
                traffic.receive(reply, now)
    return job.result()


@pytest.mark.parametrize("with_objects", [False, True])
def test_what_a_scan_finds_brings_the_bus_up(with_objects: bool) -> None:
    line: list[Any] = [Drive(), Loopback(3), Loopback(8, "eight")]
    segment = Segment(Slave(each) for each in line)
    seen: list[tuple[int, int]] = []
    slaves = scan(
        segment, with_objects=with_objects, progress=lambda done, all_: seen.append((done, all_))
    )
    assert seen == [(0, 3), (1, 3), (2, 3), (3, 3)]
    assert [each.station for each in slaves] == [1001, 1002, 1003]
    assert [each.trouble for each in slaves] == [""] * 3
    assert slaves[2].configuration.name == "Box 3 (eight)"
    for each, application in zip(slaves, line, strict=True):
        described = describe(application)
        assert sum(len(pdo.entries) for pdo in each.configuration.outputs) == sum(
            len(pdo.entries) for pdo in described.rx_pdos if pdo.sync_manager is not None
        )
    bus = BusConfiguration(tuple(each.configuration for each in slaves), cycle_ns=1_000_000)
    master = Master(bus)
    ring = Ring(master, segment)
    master.request(AlState.OP)
    master.now_ns = segment.time.now_ns
    ring.run(segment.time.now_ns + 500_000_000)
    assert master.operational, master.take_events()


def test_a_changed_mapping_is_found_in_the_objects(bus: Callable[..., Any]) -> None:
    drive = Drive()
    segment = Segment([Slave(drive)])
    drive.mapping._entries[0x1600][0] = 0x60400010
    slaves = scan(segment)
    assert slaves[0].configuration.outputs[0].entries[0].index == 0x6040
    assert bus is not None


def test_a_device_with_a_broken_eeprom_is_found_with_its_trouble() -> None:
    segment = Segment([Slave(Loopback(), sii=bytes(4096)), Slave(Loopback())])
    first, second = scan(segment)
    assert first.configuration.mailbox_out is None
    assert first.trouble or first.content.vendor_id == 0
    assert second.trouble == ""


def test_no_slave_is_an_error() -> None:
    segment = Segment([Slave(Loopback())])
    segment.break_link(segment.slaves[0])
    with pytest.raises(FrameLost):
        scan(segment)


IMAGES = Path(__file__).parents[2] / "data" / "sii"


@pytest.mark.parametrize(
    ("file", "name", "entries"),
    [
        ("ek1100.bin", "EK1100 EtherCAT-Koppler (2A E-Bus)", 0),
        ("el2004.bin", "EL2004 4K. Dig. Ausgang 24V, 0.5A", 4),
        ("akd.bin", "AKD EtherCAT Drive (CoE)", None),
    ],
)
def test_images_of_real_devices_on_our_controller_are_scanned(
    file: str, name: str, entries: int | None
) -> None:
    """The image of another device: registers are ours, EEPROM and so the configuration are its."""
    segment = Segment([Slave(Loopback(), sii=(IMAGES / file).read_bytes())])
    (result,) = scan(segment, with_objects=False)
    assert result.content.valid
    assert name in result.configuration.name
    if entries is not None:
        assert sum(len(pdo.entries) for pdo in result.configuration.outputs) == entries
