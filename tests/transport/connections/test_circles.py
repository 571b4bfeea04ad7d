"""The log line of requests that go in circles."""

import logging

import pytest

from achse.ams import AmsAddress, Command, Frame
from achse.transport.connections.circles import CircleWarning


def test_circles_of_one_connection_are_reported_once_in_ten_seconds(
    caplog: pytest.LogCaptureFixture,
) -> None:
    source, target = AmsAddress("1.2.3.4.1.1:32768"), AmsAddress("5.1.2.3.1.1:851")
    request = Frame(target, source, Command.READ)
    warning = CircleWarning()
    with caplog.at_level(logging.WARNING, "achse.tcp"):
        for second in (0, 9, 10, 11, 19, 20):
            warning.report(request, "192.0.2.2:48898", second * 1_000_000_000)
    assert len(caplog.records) == 3
    assert f"{source} to {target} go in circles by way of 192.0.2.2:48898" in caplog.text
