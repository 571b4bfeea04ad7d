"""Lines to Modbus devices: answers, faults, turns, ends."""

from collections.abc import Iterator
from concurrent.futures import CancelledError, Future

import pytest

from achse.transport.modbus import (
    ModbusAnswerError,
    ModbusBusyError,
    ModbusClient,
    ModbusPeer,
)
from tests.transport.modbus_devices import echo, free_port, packet, tcp_device, udp_device

LONG = 60.0
"""Seconds that an answer may take, on any machine."""


@pytest.fixture
def client() -> Iterator[ModbusClient]:
    opened = ModbusClient()
    yield opened
    opened.close()


def at(port: int, *, udp: bool = False) -> ModbusPeer:
    return ModbusPeer("127.0.0.1", port, udp)


def test_one_connection_for_all_requests(client: ModbusClient) -> None:
    with tcp_device(lambda unit, pdu: bytes((unit, *pdu))) as device:
        futures = [
            client.request(at(device.port), 7, bytes((number, 1)), LONG) for number in range(50)
        ]
        assert [each.result() for each in futures] == [
            bytes((7, number, 1)) for number in range(50)
        ]
        assert device.connections == 1
        assert device.requests == [bytes((number, 1)) for number in range(50)]


def test_datagrams(client: ModbusClient) -> None:
    with udp_device() as port:
        assert (
            client.request(at(port, udp=True), 1, b"\x03\0\0\0\1", LONG).result() == b"\x03\0\0\0\1"
        )


def test_an_answer_to_another_datagram_is_none(client: ModbusClient) -> None:
    with udp_device(shift=1) as port, pytest.raises(TimeoutError):
        client.request(at(port, udp=True), 1, b"\x03\0\0\0\1", 0.05).result()


def test_a_connection_that_the_device_closed_is_opened_again(client: ModbusClient) -> None:
    with tcp_device() as device:
        device.hang_up.set()
        # The first may find the old connection not closed yet: it is told, and the next one works.
        answers = 0
        for _ in range(6):
            try:
                assert client.request(at(device.port), 1, b"ab", LONG).result() == b"ab"
                answers += 1
            except ConnectionError:
                pass
        assert answers >= 3
        assert device.connections >= 3


def test_a_device_that_hangs_up_without_an_answer(client: ModbusClient) -> None:
    with tcp_device(lambda unit, pdu: None) as device:
        device.hang_up.set()
        with pytest.raises(ConnectionResetError):
            client.request(at(device.port), 1, b"ab", LONG).result()


def test_a_missing_device(client: ModbusClient) -> None:
    port = free_port()
    with pytest.raises(ConnectionRefusedError):
        client.request(at(port), 1, b"ab", LONG).result()


def test_a_late_answer_reaches_no_other_request(client: ModbusClient) -> None:
    answers: list[bytes | None] = [None, b"second"]
    with tcp_device(lambda unit, pdu: answers.pop(0)) as device:
        with pytest.raises(TimeoutError):
            client.request(at(device.port), 1, b"first", 0.05).result()
        assert client.request(at(device.port), 1, b"next", LONG).result() == b"second"
        assert device.connections == 2


def test_answers_with_other_numbers_are_passed_over(client: ModbusClient) -> None:
    def stale(number: int, whole: bytes) -> bytes:
        return packet(number - 1 & 0xFFFF, 1, b"old") + whole

    with tcp_device(echo, stale) as device:
        assert client.request(at(device.port), 1, b"new", LONG).result() == b"new"


@pytest.mark.parametrize(
    "head", [b"\0\1\0\1\0\3\1\0\0", b"\0\1\0\0\0\1\1\0", b"\0\1\0\0\xff\xff\1\0", b"HTTP/1.1 400"]
)
def test_what_is_not_modbus(client: ModbusClient, head: bytes) -> None:
    with (
        tcp_device(echo, lambda number, whole: head) as device,
        pytest.raises(ModbusAnswerError, match="header"),
    ):
        client.request(at(device.port), 1, b"ab", LONG).result()


def test_datagrams_that_are_not_modbus(client: ModbusClient) -> None:
    with udp_device(lambda unit, pdu: b"") as port, pytest.raises(ModbusAnswerError):
        client.request(at(port, udp=True), 1, b"ab", LONG).result()


def test_too_many_requests_for_one_device_are_refused(client: ModbusClient) -> None:
    with tcp_device(lambda unit, pdu: None) as device:
        futures = [client.request(at(device.port), 1, b"ab", LONG) for _ in range(65)]
        with pytest.raises(ModbusBusyError):
            futures[64].result()
        assert not futures[0].done()


def test_least_recently_used_devices_lose_their_connections(client: ModbusClient) -> None:
    with tcp_device() as device:
        for number in range(70):
            peer = ModbusPeer(f"127.0.0.{number % 2 + 1}", device.port if number == 0 else 1, True)
            with pytest.raises((TimeoutError, OSError)):
                client.request(peer._replace(port=number + 1), 1, b"ab", 0.001).result()
        assert len(client._connections) == 64


def test_the_end_cancels_what_is_under_way(client: ModbusClient) -> None:
    with tcp_device(lambda unit, pdu: None) as device:
        future: Future[bytes] = client.request(at(device.port), 1, b"ab", LONG)
        client.close()
        with pytest.raises(CancelledError):
            future.result(LONG)


def test_it_begins_again_after_an_end(client: ModbusClient) -> None:
    client.close()
    with tcp_device() as device:
        assert client.request(at(device.port), 1, b"a", LONG).result() == b"a"
        client.close()
        client.close()
    with tcp_device() as device:
        assert client.request(at(device.port), 1, b"b", LONG).result() == b"b"
