"""What each phase has to do, and when it is due."""

import math
from types import SimpleNamespace
from typing import Any

from achse.motion import AxisParameters, Nc
from achse.plc import PlcRuntime, Task
from achse.server import SampleBudget
from achse.station.clocks.cycle import PhasePlace
from achse.station.clocks.pacing import Pace
from achse.station.clocks.phases import ChangePhase, NcPhase, NotificationPhase, PlcPhase, upkeep

MS = 1_000_000


def test_changes_happen_at_their_time_in_their_order() -> None:
    told: list[str] = []
    changes = ChangePhase()
    assert changes.due_ns == math.inf
    changes.plan((20, lambda: told.append("b")), (10, lambda: told.append("a")))
    changes.plan(*changes.plans, (20, lambda: told.append("c")))
    assert changes.due_ns == 10
    changes.step(15)
    assert (told, changes.due_ns) == (["a"], 20)
    changes.step(20)
    assert (told, changes.due_ns, changes.plans) == (["a", "b", "c"], math.inf, ())


def test_a_change_may_plan_another() -> None:
    changes = ChangePhase()
    changes.plan((10, lambda: changes.plan((5, lambda: None))))
    changes.step(10)
    assert changes.due_ns == 5


def test_the_nc_does_all_cycles_up_to_now() -> None:
    nc = Nc(2 * MS, [AxisParameters(1)])
    phase = NcPhase(nc, lambda: None)
    phase.begin(1)
    assert phase.due_ns == 2 * MS
    phase.step(2 * MS)
    phase.step(13 * MS)
    assert (nc.cycle_count, phase.due_ns) == (6, 14 * MS)


def test_late_cycles_are_those_of_the_pace() -> None:
    nc = Nc(2 * MS, [AxisParameters(1)])
    pace = Pace(2 * MS, 1.0, now=0)
    phase = NcPhase(nc, lambda: pace)
    phase.begin(1)
    assert pace.take(2 * MS + 1)
    phase.step(2 * MS)
    assert nc.late_cycles == 0
    assert pace.take(7 * MS)
    phase.step(4 * MS)
    assert nc.late_cycles == 1


def test_a_plc_is_due_with_its_next_task() -> None:
    plc = PlcRuntime([Task("Fast", 3 * MS), Task("Slow", 5 * MS)])
    phase = PlcPhase(plc)
    assert (phase.place, phase.name, phase.due_ns) == (PhasePlace.PLC, "plc 851", 3 * MS)
    phase.begin(1)
    phase.step(3 * MS)
    assert phase.due_ns == 5 * MS
    plc.stop()
    phase.step(5 * MS)
    assert phase.due_ns == 6 * MS


def _device(due_ns: float, told: list[Any]) -> Any:
    notifications = SimpleNamespace(due_ns=due_ns, tick=lambda now: told.append((due_ns, now)))
    return SimpleNamespace(
        notifications=notifications, sweep=lambda now: told.append(("sweep", now))
    )


def test_notifications_are_due_with_the_first_sample_of_any_device() -> None:
    budget = SampleBudget(1000)
    told: list[Any] = []
    phase = NotificationPhase([_device(due, told) for due in (130.0, math.inf, 120.0)], budget)
    assert phase.due_ns == 120
    phase.step(120)
    assert told == [(120.0, 120)]
    assert NotificationPhase([], budget).due_ns == math.inf


def test_upkeep_is_once_a_second_in_whole_ticks() -> None:
    told: list[Any] = []
    phase = upkeep([_device(0, told)], 300 * MS, lambda: 7)
    phase.begin(1)
    assert phase.due_ns == 1200 * MS
    phase.step(1200 * MS)
    assert told == [("sweep", 7)]
