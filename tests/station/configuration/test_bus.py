"""[[bus]] and [[drive]]: what they take, and what they say of what they do not take."""

import pytest
from pydantic import ValidationError

from achse.motion.servo import ServoMode
from achse.station.configuration.bus import BusConfig, DriveConfig


def test_a_drive_is_named_by_its_axis() -> None:
    drive = DriveConfig(axis="X")
    assert (drive.mode, drive.interface) == ("csp", ServoMode.CSP)
    assert drive.scaling == 10.0 / 131_072
    assert BusConfig().name == "EtherCAT"


def test_gear_and_feed_make_the_scaling() -> None:
    drive = DriveConfig(axis=1, resolution=10_000, gear=(5, 2), feed=360.0)
    assert drive.scaling == pytest.approx(360.0 * 2 / 5 / 10_000)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"outputs": [0x6041]}, "outputs: expected some of 0x6040"),
        ({"inputs": [0x6041, 0x6041]}, "inputs: expected each object once"),
        ({"inputs": [0x6041], "own_mapping": True}, "own_mapping"),
        ({"mode": "pp"}, "csp"),
        ({"gear": [0, 1]}, "greater than 0"),
        ({"start": [{"index": 0x60C2, "value": 1, "size": 3}]}, "1, 2 or 4"),
    ],
)
def test_what_cannot_be_is_reported(keys: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        DriveConfig.model_validate({"axis": 1} | keys)


@pytest.mark.parametrize(
    ("keys", "interfaces"),
    [
        ({}, ()),
        ({"redundant": True}, ()),
        ({"interface": "eth1"}, ("eth1",)),
        ({"interface": "eth1", "redundant": False}, ("eth1",)),
        ({"interface": "eth1", "redundant": "eth2"}, ("eth1", "eth2")),
    ],
)
def test_a_bus_has_no_one_or_two_interfaces(
    keys: dict[str, object], interfaces: tuple[str, ...]
) -> None:
    assert BusConfig.model_validate(keys).interfaces == interfaces


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"redundant": "eth2"}, "expected an interface beside the second one, eth2"),
        ({"interface": "eth1", "redundant": True}, "expected the name of the second interface"),
        ({"interface": "eth1", "redundant": "eth1"}, "expected another interface than eth1"),
        ({"interface": "eth1", "redundant": ""}, "at least 1 character"),
        ({"redundant": 3}, "boolean|string"),
    ],
)
def test_what_is_no_ring_is_reported(keys: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        BusConfig.model_validate(keys)
