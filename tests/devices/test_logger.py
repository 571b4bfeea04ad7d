"""Logger and event logger: what is written is shown, and told to those who subscribed."""

import logging
import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame, NetId
from achse.devices.logger import EventLoggerDevice, LoggerDevice, LogMessage, MessageType
from achse.router import Router
from achse.server import ClientLimits

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


def test_equal_messages_at_different_times_are_both_reported(
    logger: LoggerDevice, client: Any
) -> None:
    client.subscribe(1, 65535, 64)
    client.samples()
    for time in (1, 2):
        logger.post(MESSAGE._replace(filetime=time))
        logger.notifications.tick(time * TICK)
    assert len(client.samples()) == 2


def test_a_subscriber_that_is_far_behind_misses_the_oldest(
    logger: LoggerDevice, client: Any
) -> None:
    client.subscribe(1, 65535, 64)
    client.samples()
    for number in range(1500):
        logger.post(MESSAGE._replace(filetime=number))
    for tick in range(1, 1100):
        logger.notifications.tick(tick * TICK)
    heard = [int.from_bytes(data[:8], "little") for _, data in client.samples()]
    assert heard == list(range(1500 - 1024, 1500))


@given(
    st.lists(
        st.tuples(st.integers(0, 5), st.integers(0, 300_000_000), st.integers(1, 60)), max_size=40
    ),
    st.integers(1, 20),
    st.integers(1, 40),
)
def test_any_client_that_writes_the_log_gets_so_many_lines_a_second_and_no_more(
    steps: list[tuple[int, int, int]], each: int, everybody: int
) -> None:
    """Hosts with many addresses each, at random times; what is left out is counted."""
    now = 0
    records: list[tuple[int, str]] = []

    class Keep(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            records.append((now, record.getMessage()))

    router, keep = Router(NetId("5.1.2.3.1.1")), Keep()
    devices = [LoggerDevice(clock=lambda: now), EventLoggerDevice(clock=lambda: now)]
    for device, port in zip(devices, (100, 110), strict=True):
        device.limit(ClientLimits(log_lines=each, all_log_lines=everybody))
        device.attach(router, port)
    hosts = [Host(f"10.0.0.{number}") for number in range(6)]
    target = logging.getLogger("achse.logger")
    target.addHandler(keep)
    level, target.level = target.level, logging.INFO
    written = 0
    try:
        for number, pause, count in steps:
            now += pause
            for line in range(count):
                source = AmsAddress(f"10.0.{number}.{line}.1.1:30000")
                for port, offset in ((100, 1), (110, 7)):
                    data = struct.pack("<III", 1, offset, 4) + b"line"
                    frame = Frame(AmsAddress.of(router.net_id, port), source, 3, 4, 0, 1, data)
                    frame.origin = hosts[number]
                    router.deliver(frame)
            written += 2 * count
        for device in devices:
            device.sweep(now)
    finally:
        target.removeHandler(keep)
        target.level = level
    assert {host.answers for host in hosts} <= {bytes(4), b""}
    reports = [int(text.split()[2]) for _, text in records if "left out" in text]
    lines = [time for time, text in records if "left out" not in text]
    assert len(lines) + sum(reports) == written
    assert len(lines) <= 2 * (2 * everybody + now * everybody // 1_000_000_000 + 1)


class Host:
    """The far end of a connection; remembers the last answer."""

    def __init__(self, name: str) -> None:
        self.peer_host = name
        self.answers = b""

    def deliver(self, frame: Frame) -> bool:
        self.answers = frame.data
        return True


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


def test_the_event_logger_reports_nothing(
    router: Router, client_of: Callable[..., Any], refused: Any
) -> None:
    EventLoggerDevice(clock=lambda: 0).attach(router, 110)
    client = client_of(router, 110)
    with refused(0x704):
        client.read(0x1234, 5, 4)
    assert client.get(0xF100, 0, "<H") == 5
