"""A log that nobody reads stops nothing; what is missing is told."""

import io
import logging
import os
import re
import select
import signal
import socket
import threading
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.cli import log_writer
from achse.cli.log_writer import LogWriter
from achse.router.rate import Rates
from tests.warm_commands import PIPES, WarmCommands


def log_to(writer: LogWriter) -> logging.Logger:
    logger = logging.Logger("test")
    logger.addHandler(writer)
    return logger


def unlimited(writer: LogWriter) -> LogWriter:
    writer._rates = Rates(1 << 30, 1 << 30)
    return writer


def test_lines_come_in_order_and_are_there_after_a_flush() -> None:
    stream = io.StringIO()
    writer = unlimited(LogWriter(stream))
    log = log_to(writer)
    for number in range(2000):
        log.info("line %d", number)
    writer.flush()
    assert stream.getvalue() == "".join(f"line {number}\n" for number in range(2000))
    assert writer.dropped == 0


def test_a_record_that_cannot_be_shown_or_is_too_long_is_a_line_all_the_same() -> None:
    stream = io.StringIO()
    writer = LogWriter(stream)
    log = log_to(writer)
    log.info("%d axes", "no")
    log.info("x" * 100_000)
    log.info("\udcff")
    writer.flush()
    first, second, third = stream.getvalue().splitlines()
    assert "'%d axes': TypeError" in first
    assert second == "x" * 16384 + " … (100000 characters)"
    assert third == "\\udcff"


def test_of_one_kind_few_are_written_and_the_others_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = io.StringIO()
    writer = LogWriter(stream)
    log = log_to(writer)
    monkeypatch.setattr("time.monotonic_ns", lambda: 1)
    for _ in range(5000):
        log.warning("it happened")
    log.warning("something else")
    writer.flush()
    lines = stream.getvalue().splitlines()
    assert lines.count("it happened") == 200
    assert "something else" in lines
    counts = [int(line.split()[0]) for line in lines if "were left out: too many" in line]
    assert sum(counts) + writer._left_out == 4800 == writer.dropped


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 5000)), max_size=40))
def test_whatever_is_logged_and_read_each_line_is_read_or_counted_and_room_is_bounded(
    steps: list[tuple[bool, int]],
) -> None:
    """The reader is a stream that blocks until it is told to read so many lines."""
    tickets = threading.Semaphore(0)
    written: list[str] = []

    class Reader(io.StringIO):
        def write(self, text: str) -> int:
            tickets.acquire()
            written.extend(text.splitlines())
            return len(text)

    writer = unlimited(LogWriter(Reader()))
    log = log_to(writer)
    lines = 0
    for reads, size in steps:
        if reads:
            tickets.release()
        else:
            log.info("x" * size)
            lines += 1
        assert writer._size <= log_writer._BYTES
    tickets.release(10_000)
    writer.flush()
    writer.close()
    seen = sum(1 for line in written if line.startswith("x"))
    assert seen + writer.dropped == lines


def test_what_no_client_reads_is_dropped_counted_and_reported() -> None:
    receive, send = os.pipe()
    with os.fdopen(receive, "rb", buffering=0) as reader, os.fdopen(send, "w") as stream:
        writer = unlimited(LogWriter(stream))
        log = log_to(writer)
        for number in range(30_000):  # the pipe and the queue hold some 10,000 of them
            log.info("line %05d %s", number, "x" * 40)
        assert writer.dropped > 15_000
        heard, back = b"", 0
        while b"reader of the log stalled" not in heard:
            heard += reader.read(1 << 16)
            log.info("the reader is back")
            back += 1
        lines = heard.decode().splitlines()
        numbers = [int(line[5:10]) for line in lines if line.startswith("line")]
        assert numbers == list(range(len(numbers)))
        (count,) = re.findall(
            r"(\d+) lines were dropped: the reader of the log stalled", heard.decode()
        )
        # What was logged while the reader came back may be among those that were dropped.
        assert int(count) == writer.dropped
        assert 0 <= writer.dropped - (30_000 - len(numbers)) <= back
        writer.flush()
        writer.close()


def test_an_unread_stderr_stops_neither_the_station_nor_its_end(
    free_host: Callable[[], str], warm_commands: WarmCommands
) -> None:
    """1,000 connections of garbage are as many warnings; the pipe holds some hundred of them."""
    host = free_host()
    words = "run", "--host", host, "--log-level", "debug"
    with warm_commands.popen(*words, text=False, bufsize=0, **PIPES) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        _shrink(process.stderr.fileno())
        for _ in range(300):
            with socket.create_connection((host, 48898)) as alien:
                alien.sendall(b"GET / HTTP/1.1\r\n\r\n")
                assert alien.recv(1) == b""
        process.send_signal(signal.SIGTERM)
        code = process.wait()
        assert code == 0
        assert select.select([process.stderr], [], [], 0)[0]


def _shrink(pipe: int) -> None:
    """Make a pipe as small as can be (Linux), so that little fills it."""
    import fcntl

    f_setpipe_sz = getattr(fcntl, "F_SETPIPE_SZ", None)
    if f_setpipe_sz is not None:
        fcntl.fcntl(pipe, f_setpipe_sz, 4096)


def test_the_end_waits_for_a_reader_but_not_long() -> None:
    receive, send = os.pipe()
    with os.fdopen(receive, "rb"), os.fdopen(send, "w") as stream:
        writer = unlimited(LogWriter(stream))
        log = log_to(writer)
        for _ in range(3000):
            log.info("x" * 100)
        writer.flush()
        writer.close()
        assert writer._waiting
