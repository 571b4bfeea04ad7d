"""The guard of browser tests: it ends waits in vain, whether of playwright or of our own."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import pytest

from tests.interop.browser.guard import BrowserGuard
from tests.interop.waiting import until

BUSY = "while True: pass"
QUICK_S = 0.05


def test_wait_for_a_page_fails_with_what_it_waited_for(
    show: Callable[..., AbstractContextManager[Any]], web_station: Any
) -> None:
    guard = BrowserGuard(limit_s=0.3, look_s=QUICK_S)
    closed = re.compile(r"0\.3 s of CPU; .*closed", re.DOTALL)
    with pytest.raises(AssertionError, match=closed), show(web_station.url) as shown, guard.limit():
        wait_in_vain(shown.open("overview"))
    assert guard.is_exceeded
    with show(web_station.url) as shown:  # in another Chromium
        shown.open("overview")


def wait_in_vain(page: Any) -> None:
    page.evaluate("setInterval(() => { for (let n = 0; n < 1e8; n += 1); }, 0), 0")
    page.wait_for_function("() => document.title === 'never'")


def test_wait_of_our_own_fails() -> None:
    guard = BrowserGuard(limit_s=0.1, look_s=QUICK_S)
    with subprocess.Popen([sys.executable, "-Sc", BUSY]) as process:
        try:
            with pytest.raises(AssertionError, match=r"waiting in vain"), guard.limit():
                until(lambda: False)
        finally:
            process.kill()


def test_stations_count_wherever_they_are_forked() -> None:
    guard = BrowserGuard()
    before = guard.used_s()
    with guard.counting(1), guard.counting(os.getpid()):
        assert guard.used_s() >= before


def test_failure_within_the_limit_is_what_it_was() -> None:
    with pytest.raises(ValueError, match="other"), BrowserGuard().limit():
        raise ValueError("other")
