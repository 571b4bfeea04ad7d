"""The clock of the computer may jump, by hours and backwards: nothing that goes on looks at it.

What lasts is measured by clocks that only go forward (`time.monotonic`, a loop's `time`). The time
of day is read where a person is told it, or once at the start.
"""

import time
from pathlib import Path

import paho.mqtt.client

from tests.house.sources import Module, Texts

MAY: dict[str, str] = {
    "src/achse/cli/start/detached.py": "how old the log of a station is that has ended",
    "src/achse/cli/record/monitor.py": "beside times of captures, which are times of day",
    "src/achse/cli/start/run.py": "stamps of a station until its pace starts",
    "src/achse/fleet/worker.py": "stamps of a station until its pace starts",
    "src/achse/gateway/gateway.py": "once at the start, for stamps of the router's own devices",
    "src/achse/monitor/replay.py": "where the time of a recording that is played begins",
    "src/achse/station/buses/frame_link.py": "beside the kernel's note; never more than went by",
    "src/achse/station/clocks/clock.py": "stamps where the pace starts, and their lag, for people",
    "src/achse/station/station.py": "when a packet passed a tap, as people read it",
    "src/achse/monitor/relay.py": "when a packet passed, as people read it",
    "src/achse/transport/ethernet.py": "beside the kernel's note of when a frame arrived",
    "src/achse/transport/secure/own_certificate.py": "from when a certificate is valid",
    "src/achse/web/sampling.py": "when a recording begins, as people read it",
}
"""Modules that read the time of day, and what for."""

MASTERS = "tests/interop/ethercat/masters"

SLEEPERS: dict[str, str] = {
    "tests/cli/test_interrupts.py": "Ctrl-C comes at any moment; the outcome holds at each",
    "tests/interop/test_examples.py": "a user's script, in station time of high speed",
    "tests/interop/test_hostile_load.py": "a good client's pauses between requests, in its process",
    "tests/interop/waiting.py": "between two looks at a condition, without a limit",
    f"{MASTERS}/achse_master.py": "the bus cycle of a master",
    f"{MASTERS}/achse_objects.py": "the bus cycle of a master",
    f"{MASTERS}/attack.py": "the slaves take what comes, a queue takes less",
    f"{MASTERS}/kickcat_esi.py": "the bus cycle of a master",
    f"{MASTERS}/kickcat_loopback.py": "the bus cycle of a master",
    f"{MASTERS}/pysoem_bus.py": "the bus cycle of a master",
    f"{MASTERS}/pysoem_drives.py": "longer than the watchdog of a slave: a busy machine waits more",
    f"{MASTERS}/pysoem_esi.py": "the bus cycle of a master",
    f"{MASTERS}/pysoem_loopback.py": "longer than the watchdog of a slave",
}
"""Tests and programs of tests that sleep, and what for; no result depends on how long."""

SLEEP = "time." + "sleep("
PRECISE = "perf" + "_counter("

_READS = {
    ("time", "time"),
    ("time", "time_ns"),
    ("datetime", "now"),
    ("datetime", "utcnow"),
    ("datetime", "today"),
    ("date", "today"),
}


def test_nothing_that_goes_on_looks_at_the_time_of_day(parsed: dict[Path, Module]) -> None:
    modules = {
        path.as_posix()
        for path, module in parsed.items()
        if not _READS.isdisjoint(module.attributes) or not _READS.isdisjoint(module.imported)
    }
    assert modules == MAY.keys()


def test_the_keep_alive_of_mqtt_goes_by_a_clock_that_does_not_jump() -> None:
    assert paho.mqtt.client.time_func is time.monotonic


def test_no_test_sleeps_without_a_reason(tracked: list[Path], texts: Texts) -> None:
    tests = [path for path in tracked if path.parts[0] == "tests" and path.suffix == ".py"]
    assert {path.as_posix() for path in tests if SLEEP in texts[path]} == SLEEPERS.keys()
    assert [path for path in tests if PRECISE in texts[path]] == []
