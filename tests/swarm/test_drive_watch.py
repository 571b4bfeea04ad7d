"""The watch over drives: no axis is in control while its drive has no torque and says so."""

from types import SimpleNamespace
from typing import Any

import pytest

from achse.faults.drives import AlarmFault, Hang, Sto
from achse.faults.fault import FaultState
from achse.swarm.drive_watch import DriveWatch

MS = 1_000_000


def rig(*faults: Any, loop_closed: int = 1, error_code: int = 0) -> tuple[DriveWatch, list[str]]:
    """Two axes on drives 1 and 2, with these faults on the bus."""
    axes = [
        SimpleNamespace(name=name, loop_closed=loop_closed, error_code=error_code)
        for name in ("X", "Y")
    ]
    active = [SimpleNamespace(fault=each, state=FaultState.ACTIVE) for each in faults]
    station: Any = SimpleNamespace(nc=axes, drive_faults=[active, None])
    reports: list[str] = []
    return DriveWatch(
        station, ["X", "Y"], lambda name, what: reports.append(f"{name} {what}")
    ), reports


def look(watch: DriveWatch, end_ms: int) -> None:
    for now in range(0, end_ms + 1, 10):
        watch.step(now * MS)


@pytest.mark.parametrize("fault", [Sto(drive=2), AlarmFault(code="AL.510", drive=2)])
def test_axis_that_stays_in_control_is_reported(fault: Any) -> None:
    watch, reports = rig(fault)
    look(watch, 100)
    assert reports == []
    look(watch, 110)
    assert reports
    assert reports[0].startswith("drive-error axis Y at 0.110 s")


@pytest.mark.parametrize(
    ("faults", "values"),
    [
        ((), {}),
        ((Sto(),), {"loop_closed": 0}),
        ((Sto(),), {"error_code": 0x4650}),
        ((Sto(drive=1), Hang(drive=1)), {}),
    ],
)
def test_axis_with_an_error_or_a_drive_that_is_silent_is_not(
    faults: Any, values: dict[str, int]
) -> None:
    watch, reports = rig(*faults, **values)
    look(watch, 500)
    assert reports == []
