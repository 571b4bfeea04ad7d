"""Logger and event logger: what is written is shown, and told to those who subscribed."""

import gc
import logging
import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import NetId
from achse.devices.logger import EventLoggerDevice, LoggerDevice, LogMessage, MessageType
from achse.router import Router

MESSAGE = LogMessage(116_444_736_000_000_000, MessageType.ERROR, 500, "TCNC", "'Axis 1' stopped")
TICK = 10_000_000


@pytest.fixture
def router() -> Router:
    return Router(NetId("5.1.2.3.1.1"))


@pytest.fixture
def logger(router: Router) -> LoggerDevice:
    device = LoggerDevice(clock=lambda: 0)
    device.attach(router, 100)
    return device


@pytest.fixture
def client(logger: LoggerDevice, router: Router, client_of: Callable[..., Any]) -> Any:
    return client_of(router, 100)


def test_a_message_has_the_recorded_layout() -> None:
    data = MESSAGE.encode()
    assert struct.unpack_from("<QII", data) == (116_444_736_000_000_000, 4, 500)
    assert data[16:32] == b"TCNC".ljust(16, b"\0")
    assert struct.unpack_from("<I", data, 32) == (17,)
    assert data[36:] == b"'Axis 1' stopped\0"


@pytest.mark.parametrize(
    ("kind", "level"),
    [(MessageType.HINT, "INFO"), (MessageType.WARNING, "WARNING"), (MessageType.ERROR, "ERROR")],
)
def test_a_whole_message_is_shown(
    client: Any, caplog: pytest.LogCaptureFixture, kind: int, level: str
) -> None:
    caplog.set_level(logging.INFO)
    client.write(1, 0, MESSAGE._replace(kind=kind).encode())
    [record] = caplog.records
    assert (record.levelname, record.getMessage()) == (
        level,
        "TCNC (port 500): 'Axis 1' stopped",
    )


def test_a_text_alone_is_shown_as_what_its_offset_says(
    client: Any, caplog: pytest.LogCaptureFixture
) -> None:
    client.write(1, MessageType.WARNING, b"tank \x07empty\0rest")
    [record] = caplog.records
    assert record.levelname == "WARNING"
    assert record.getMessage() == f"ADS (port {client.address.port}): tank  empty"


def test_who_subscribed_gets_every_message_in_order(logger: LoggerDevice, client: Any) -> None:
    client.subscribe(1, 65535, 255, cycle_s=0.1)
    assert [data for _, data in client.samples()] == [bytes(255)]
    texts = ["one", "two", "two", "three"]
    for text in texts:
        logger.post(MESSAGE._replace(text=text))
    logger.post(MESSAGE._replace(text="x" * 400))
    for tick in range(1, 8):
        logger.notifications.tick(tick * TICK)
    heard = [data for _, data in client.samples()]
    assert [data[36:].rstrip(b"\0").decode() for data in heard] == [
        "one",
        "two",
        "three",
        "x" * 219,
    ]


def test_equal_messages_at_different_times_are_both_told(logger: LoggerDevice, client: Any) -> None:
    client.subscribe(1, 65535, 64)
    client.samples()
    for time in (1, 2):
        logger.post(MESSAGE._replace(filetime=time))
        logger.notifications.tick(time * TICK)
    assert len(client.samples()) == 2


def test_nothing_is_kept_for_subscriptions_that_ended(logger: LoggerDevice, client: Any) -> None:
    for _ in range(5):
        client.subscribe(1, 65535, 64)
    assert len(logger._tails) == 5
    logger.end_client(client.address)
    gc.collect()
    assert len(logger._tails) == 0


def test_what_the_logger_refuses(client: Any, refused: Any) -> None:
    with refused(0x705):
        client.write(1, 0, bytes(4097))
    with refused(0x703):
        client.subscribe(1, 1, 64)
    with refused(0x702):
        client.write(2, 0, b"x")


texts = st.text(st.characters(codec="cp1252", categories=["L", "N"]), max_size=15)


@given(
    st.builds(
        LogMessage,
        st.integers(0, 2**64 - 1),
        st.integers(0, 2**32 - 1),
        st.integers(0, 0xFFFF),
        texts,
        texts,
    )
)
def test_a_message_survives_the_wire(message: LogMessage) -> None:
    assert LogMessage.decode(message.encode()) == message


@given(st.binary(max_size=80))
def test_any_bytes_are_a_message_or_not(data: bytes) -> None:
    assert isinstance(LogMessage.decode(data), LogMessage | None)


@pytest.mark.parametrize(
    ("data", "shown"), [(b"door open\0", "door open"), (b"\1\0\2", "01 00 02"), (b"", "")]
)
def test_the_event_logger_takes_every_write(
    router: Router,
    client_of: Callable[..., Any],
    caplog: pytest.LogCaptureFixture,
    data: bytes,
    shown: str,
) -> None:
    caplog.set_level(logging.INFO)
    EventLoggerDevice(clock=lambda: 0).attach(router, 110)
    client = client_of(router, 110)
    client.write(0x1234, 5, data)
    assert caplog.messages == [f"event 0x1234:0x5 of {client.address}: {shown}"]


def test_the_event_logger_tells_nothing(
    router: Router, client_of: Callable[..., Any], refused: Any
) -> None:
    EventLoggerDevice(clock=lambda: 0).attach(router, 110)
    client = client_of(router, 110)
    with refused(0x704):
        client.read(0x1234, 5, 4)
    assert client.get(0xF100, 0, "<H") == 5
