"""The NetId of a bus: ports beside those of the station, refusals in the header."""

from typing import Any

import pytest

from achse.ams import Command, NetId, RouterError
from achse.codes import ReturnCode


def test_a_port_that_no_device_has(io: Any) -> None:
    code = io.code(lambda: io.ask(1099, Command.READ_STATE, b""))
    assert code == ReturnCode.TARGET_PORT_NOT_FOUND.number
    other = NetId("10.1.2.3.9.1")
    code = io.code(lambda: io.ask(1001, Command.READ_STATE, b"", other))
    assert code == ReturnCode.TARGET_MACHINE_NOT_FOUND.number


def test_ports_of_station_and_bus_are_apart(io: Any) -> None:
    assert io.ask(300, Command.READ_STATE, b"")[:2] == b"\x05\x00"
    with pytest.raises(RouterError):
        io.attached._buses[0]._net.register(1001, io)


def test_closed_it_is_gone(io: Any) -> None:
    io.attached.close()
    code = io.code(lambda: io.ask(1001, Command.READ_STATE, b""))
    assert code == ReturnCode.TARGET_MACHINE_NOT_FOUND.number
    code = io.code(lambda: io.ask(300, Command.READ_STATE, b""))
    assert code == ReturnCode.TARGET_PORT_NOT_FOUND.number
