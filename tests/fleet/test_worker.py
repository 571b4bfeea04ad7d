"""One process of a fleet, in this one: no broker is needed to be ready."""

import asyncio
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from achse.fleet.plan import FleetPlan
from achse.fleet.worker import memory_bytes, pin, serve
from achse.station.configuration.types import ConfigError


@pytest.fixture
def plan(tmp_path: Path) -> FleetPlan:
    (tmp_path / "t.toml").write_text('[[axis]]\nid = 1\nname = "X"\n')
    (tmp_path / "fleet.toml").write_text(
        'template = "t.toml"\ncount = 3\nnet_id = "5.1.1.1.1.1"\nspeed = 50.0\n'
        '[mqtt]\nbroker = "127.0.0.1"\nport = 1\ntopic = "t"\n'
    )
    return FleetPlan.load(tmp_path / "fleet.toml")


async def test_stations_report_that_they_are_ready_and_their_figures(plan: FleetPlan) -> None:
    pytest.importorskip("aiomqtt")
    reports: list[dict[str, Any]] = []
    stop = asyncio.Event()

    def report(what: dict[str, Any]) -> None:
        reports.append(what)
        if what["event"] == "figures" and what["station"] == 3 and what["cycles"]:
            stop.set()

    await serve(plan, [2, 3], stop, report, every_s=0.01)
    assert [each["station"] for each in reports[:2]] == [2, 3]
    assert {each["event"] for each in reports[:2]} == {"ready"}
    assert reports[0]["address"] != reports[1]["address"]
    last = reports[-1]
    assert (last["state"], last["axes"], last["errors"]) == ("RUN", 1, 0)
    assert (last["online"], last["partners"]) == (False, 0)
    assert last["computed_s"] > 0.0
    assert last["tick_s"] == 0.002


async def test_a_station_that_cannot_be_is_reported(plan: FleetPlan) -> None:
    with pytest.raises(ConfigError, match="stations 1 … 3, not 4"):
        await serve(plan, [4], asyncio.Event(), print)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells, and pins")
def test_memory_and_cores() -> None:
    assert (memory_bytes() or 0) > 1_000_000
    assert not pin(None)
    assert not pin(9999)
    core = min(os.sched_getaffinity(0))
    program = (
        "import os; from achse.fleet.worker import pin;"
        f"print(pin({core}), os.sched_getaffinity(0) == {{{core}}})"
    )
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, capture_output=True, text=True).stdout == "True True\n"
