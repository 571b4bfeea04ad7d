"""All devices of a bus: each at its port, under its name."""

from typing import Any

from achse.ams import Command


def test_every_port_answers_with_its_name(io: Any) -> None:
    for port, name in ((300, b"TwinCAT IO"), (0xFFFF, b"EtherCAT Master"), (1002, b"Box 2")):
        assert io.ask(port, Command.READ_DEVICE_INFO, b"")[4:].rstrip(b"\0") == name


def test_the_buses_share_what_clients_hold(io: Any) -> None:
    assert len(io.attached.devices) == 6
