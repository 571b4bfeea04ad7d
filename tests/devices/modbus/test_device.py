"""The device at port 10500: whom it asks, and what it answers when that fails."""

import errno
import socket
import struct
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future

import pytest

from achse.ams import DeviceError
from achse.devices.modbus import ModbusDevice
from achse.testing import ManualClock
from achse.transport.modbus import ModbusPeer
from tests.transport.modbus_devices import free_port, tcp_device, udp_device

ANYWHERE = "127.0.0.1"


def find(address: str, port: int) -> tuple[str, int] | None:
    return (address, port) if address.startswith("127.") else None


@pytest.fixture
def device() -> Iterator[ModbusDevice]:
    result = ModbusDevice(find, clock=ManualClock())
    yield result
    result.client.close()


def request(
    port: int,
    function: int,
    *numbers: int,
    data: bytes = b"",
    host: str = ANYWHERE,
    timeout: int = 60_000,
) -> bytes:
    filled = (*numbers, 0, 0, 0, 0)[:4]
    head = struct.pack("<16sHBBI4HI", host.encode(), port, 9, function, timeout, *filled, len(data))
    return head + data


def code_of(device: ModbusDevice, data: bytes, room: int = 512, offset: int = 0) -> int:
    with pytest.raises(DeviceError) as refusal:
        device.read_write(1, offset, room, data)
    return refusal.value.code


def test_registers_come_with_the_low_byte_first(device: ModbusDevice) -> None:
    with tcp_device(lambda unit, pdu: bytes((3, 4, unit, pdu[2], 0x12, 0x34))) as there:
        assert device.read_write(1, 0, 4, request(there.port, 3, 5, 2)) == b"\x05\x09\x34\x12"
        assert there.requests == [b"\x03\0\5\0\2"]


def test_over_udp(device: ModbusDevice) -> None:
    with udp_device(lambda unit, pdu: b"\x01\x01\xff") as port:
        assert device.read_write(1, 1, 1, request(port, 1, 0, 3)) == b"\x07"


def test_a_write_answers_nothing(device: ModbusDevice) -> None:
    with tcp_device(lambda unit, pdu: pdu[:5]) as there:
        assert device.read_write(1, 0, 0, request(there.port, 16, 7, 1, data=b"\1\2")) == b""
        assert there.requests == [b"\x10\0\7\0\1\2\2\1"]


@pytest.mark.parametrize("code", [1, 2, 3, 4, 6, 11])
def test_exceptions(device: ModbusDevice, code: int) -> None:
    with tcp_device(lambda unit, pdu: bytes((pdu[0] | 0x80, code))) as there:
        assert code_of(device, request(there.port, 3, 0, 1)) == 0x8000 + code


def test_what_does_not_fit(device: ModbusDevice) -> None:
    with tcp_device() as there:
        assert code_of(device, request(there.port, 3, 0, 1)) == 0x8004
    with tcp_device(sends=lambda number, whole: b"SSH-2.0-x") as there:
        assert code_of(device, request(there.port, 3, 0, 1)) == 0x8004


def test_an_invalid_request_is_not_sent(device: ModbusDevice) -> None:
    with tcp_device() as there:
        assert code_of(device, request(there.port, 3, 0, 0)) == 0x8003
        assert code_of(device, request(there.port, 3, 0, 2), room=3) == 0x8002
        assert code_of(device, request(there.port, 99)) == 0x8001
        assert there.requests == []


@pytest.mark.parametrize(
    ("data", "offset", "code"),
    [
        (b"", 0, 0x705),
        (request(1, 3, 0, 1)[:-1], 0, 0x705),
        (request(1, 3, 0, 1) + b"\0", 0, 0x705),
        (request(1, 3, 0, 1), 2, 0x703),
    ],
)
def test_requests_that_are_not_ones(
    device: ModbusDevice, data: bytes, offset: int, code: int
) -> None:
    assert code_of(device, data, offset=offset) == code


def test_only_devices_that_are_named_are_queried(device: ModbusDevice) -> None:
    assert code_of(device, request(502, 3, 0, 1, host="192.168.1.50")) == 0x8007_271D


@pytest.mark.parametrize("host", ["", "plc", "1.2.3", "300.1.1.1", "\xff"])
def test_what_is_not_an_address(device: ModbusDevice, host: str) -> None:
    assert code_of(device, request(502, 3, 0, 1, host=host)) == 0x8007_2741


def test_a_missing_device(device: ModbusDevice) -> None:
    assert code_of(device, request(free_port(), 3, 0, 1)) == 0x8007_274D


def test_no_answer_in_time(device: ModbusDevice) -> None:
    with tcp_device(lambda unit, pdu: None) as there:
        assert code_of(device, request(there.port, 3, 0, 1, timeout=30)) == 0x745


def test_a_device_that_hangs_up(device: ModbusDevice) -> None:
    with tcp_device(lambda unit, pdu: None) as there:
        there.hang_up.set()
        assert code_of(device, request(there.port, 3, 0, 1)) == 0x8007_2746


def test_an_unknown_name() -> None:
    device = ModbusDevice(lambda address, port: ("x" * 64, port), clock=ManualClock())
    try:
        assert code_of(device, request(502, 3, 0, 1)) == 0x8007_2AF9
    finally:
        device.client.close()


@pytest.mark.parametrize(
    ("failure", "code"),
    [
        (socket.gaierror(socket.EAI_NONAME, "Name or service not known"), 0x8007_2AF9),
        (OSError(errno.EHOSTUNREACH, "No route to host"), 0x8007_2751),
        (OSError(errno.ETIMEDOUT, "Connection timed out"), 0x8007_274C),
        (OSError(errno.EPERM, "Operation not permitted"), 0x8007_2746),
        (CancelledError(), 0x756),
    ],
)
def test_what_else_may_go_wrong(
    device: ModbusDevice, monkeypatch: pytest.MonkeyPatch, failure: Exception, code: int
) -> None:
    requested: Future[bytes] = Future()
    requested.set_exception(failure)
    monkeypatch.setattr(device.client, "request", lambda *_: requested)
    assert code_of(device, request(502, 3, 0, 1)) == code


def test_too_many_requests_are_busy(device: ModbusDevice) -> None:
    with tcp_device(lambda unit, pdu: None) as there:
        for _ in range(64):
            device.client.request(ModbusPeer(ANYWHERE, there.port), 1, b"\1\0\0\0\1", 60)
        assert code_of(device, request(there.port, 3, 0, 1)) == 0x708
