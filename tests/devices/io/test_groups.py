"""Groups: numbers that clients have compiled in."""

from achse.devices.io.groups import IoGroup, MasterGroup, SlaveGroup


def test_numbers_clients_know() -> None:
    assert IoGroup.DEVICES == 0x5000
    assert (MasterGroup.SLAVE_STATES, MasterGroup.IDENTITY, MasterGroup.TOPOLOGY) == (9, 0x11, 0x22)
    assert (SlaveGroup.SDO, SlaveGroup.OBJECT_LIST) == (0xF302, 0xF3FC)
