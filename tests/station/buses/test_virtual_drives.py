"""Virtual drives of a station: machines as the tables say."""

import pytest

from achse.drive.compiled import Bank
from achse.drive.identity import MANUAL_VENDOR, VENDOR
from achse.drive.machine import EncoderKind
from achse.station.buses.virtual_drives import (
    digest_of,
    make_drives,
    torque_per_acceleration,
)
from achse.station.configuration.bus import DriveConfig


@pytest.mark.parametrize("compiled", [False, True])
def test_each_table_is_a_drive(compiled: bool) -> None:
    configs = [DriveConfig(axis=1), DriveConfig(axis=2, resolution=10_000)]
    drives = make_drives(configs, Bank(2) if compiled else None)
    assert [drive.machine.encoder.resolution for drive in drives] == [131_072, 10_000]
    assert len({digest_of(drive) for drive in drives}) == 2


def test_identity_of_a_drive_is_the_one_its_table_names() -> None:
    configs = [DriveConfig(axis=1), DriveConfig(axis=2, identity="manual")]
    vendors = [drive.get(0x1018, 1) for drive in make_drives(configs)]
    assert vendors == [VENDOR, MANUAL_VENDOR]


def test_both_kernels_have_the_same_state() -> None:
    plain, compiled = (
        make_drives([DriveConfig(axis=1)], Bank(1) if compiled else None)[0]
        for compiled in (False, True)
    )
    assert digest_of(plain) == digest_of(compiled)


def test_switches_are_where_the_axis_sees_them() -> None:
    machine = {
        "home": (5.0, 7.0),
        "negative_limit": -10.0,
        "positive_limit": 20.0,
        "encoder": "multi_turn",
    }
    keys = {"axis": 1, "resolution": 1000, "feed": 10.0, "machine": machine}
    straight, turned = make_drives(
        [DriveConfig.model_validate(keys | {"inverted": inverted}) for inverted in (False, True)],
    )
    assert straight.machine.encoder.kind is EncoderKind.MULTI_TURN
    assert straight.machine.switches.home == pytest.approx((500.0, 700.0))
    assert turned.machine.switches.home == pytest.approx((-700.0, -500.0))
    ends = [(each.machine.switches.negative_limit, each.machine.switches.positive_limit)
            for each in (straight, turned)]  # fmt: skip
    assert ends == [(-1000.0, 2000.0), (-2000.0, 1000.0)]


def test_torque_of_an_acceleration_is_that_of_the_machine() -> None:
    drive = make_drives([DriveConfig(axis=1)])[0]
    assert torque_per_acceleration(drive) * drive.record.acceleration_gain == pytest.approx(1.0)
