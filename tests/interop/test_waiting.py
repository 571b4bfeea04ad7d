"""Waits for what no longer comes."""

import subprocess

import pytest

from tests.interop.waiting import needed, until


def test_wait_ends_with_the_process_it_needs() -> None:
    with (
        subprocess.Popen(["false"]) as process,
        needed(process),
        pytest.raises(AssertionError, match=r"\['false'\] ended with 1"),
    ):
        until(lambda: False)
    until(lambda: True)
