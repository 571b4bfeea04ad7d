"""A timer whose file descriptor is readable when its moment has come."""

import select
import sys
import time

import pytest

from achse.station.clocks.wake_timer import WakeTimer


@pytest.mark.skipif(sys.platform != "linux", reason="timerfd is Linux's")
def test_it_is_readable_from_its_moment_on() -> None:
    timer = WakeTimer()
    assert select.select([timer], [], [], 0)[0] == []
    due = time.monotonic_ns() + 1_000_000
    timer.wake_at(due)
    assert select.select([timer], [], [])[0] == [timer]
    assert time.monotonic_ns() >= due
    timer.clear()
    timer.clear()
    assert select.select([timer], [], [], 0)[0] == []
    timer.wake_at(due)  # over
    assert select.select([timer], [], [])[0] == [timer]
    timer.wake_at(0)
    assert select.select([timer], [], [])[0] == [timer]
    timer.close()


def test_other_systems_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(OSError, match="timerfd"):
        WakeTimer()
