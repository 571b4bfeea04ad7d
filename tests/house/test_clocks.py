"""The clock of the computer may jump, by hours and backwards: nothing that goes on looks at it.

What lasts is measured by clocks that only go forward (`time.monotonic`, a loop's `time`). The time
of day is read where a person is told it, or once at the start.
"""

import time
from pathlib import Path

import paho.mqtt.client

from tests.house.sources import Module

MAY: dict[str, str] = {
    "src/achse/cli/detached.py": "how old the log of a station is that has ended",
    "src/achse/cli/monitor.py": "beside times of captures, which are times of day",
    "src/achse/cli/run.py": "stamps of a station until its pace starts",
    "src/achse/fleet/worker.py": "stamps of a station until its pace starts",
    "src/achse/monitor/replay.py": "where the time of a recording that is played begins",
    "src/achse/station/bus_link.py": "beside the kernel's note; never more than went by",
    "src/achse/station/clock.py": "stamps where the pace starts, and their lag, as people read it",
    "src/achse/station/station.py": "when a packet passed a tap, as people read it",
    "src/achse/monitor/relay.py": "when a packet passed, as people read it",
    "src/achse/transport/ethernet.py": "beside the kernel's note of when a frame arrived",
    "src/achse/transport/own_certificate.py": "from when a certificate is valid",
    "src/achse/web/sampling.py": "when a recording begins, as people read it",
}
"""Modules that read the time of day, and what for."""

_READS = {
    ("time", "time"),
    ("time", "time_ns"),
    ("datetime", "now"),
    ("datetime", "utcnow"),
    ("datetime", "today"),
    ("date", "today"),
}


def test_nothing_that_goes_on_looks_at_the_time_of_day(parsed: dict[Path, Module]) -> None:
    found = {
        path.as_posix()
        for path, module in parsed.items()
        if not _READS.isdisjoint(module.attributes) or not _READS.isdisjoint(module.imported)
    }
    assert found == MAY.keys()


def test_the_keep_alive_of_mqtt_goes_by_a_clock_that_does_not_jump() -> None:
    assert paho.mqtt.client.time_func is time.monotonic
