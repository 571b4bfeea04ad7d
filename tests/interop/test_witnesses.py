"""In CI every witness is there; elsewhere this file tells which one is missing."""

from collections.abc import Callable

import pytest


@pytest.mark.parametrize(
    "name",
    [
        *("pyads", "ads-client", "ads-async", "pytmc", "pytcs", "tshark", "pysoem", "kickcat"),
        *("ophyd", "caproto", "pyyaml", "socat", "rs274"),
        *("pymodbus", "node", "axe-core", "playwright", "chromium"),
    ],
)
def test_the_witness_is_installed(name: str, witness: Callable[[str], None]) -> None:
    witness(name)
