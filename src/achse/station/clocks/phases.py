"""The phases of a station's cycle: what each of them has to do, and when."""

import math
from collections.abc import Callable, Sequence
from typing import Protocol

from achse.motion import Nc
from achse.plc import PlcRuntime
from achse.server import Device, SampleBudget
from achse.server.ahead import SamplesAhead
from achse.station.clocks.cycle import CyclicPhase, Phase, PhasePlace
from achse.station.clocks.pacing import NcTask, Pace

_SWEEP_NS = 1_000_000_000
"""Approximate interval at which devices look for clients that are gone: a whole number of ticks."""

Plan = tuple[int, Callable[[], None]]
"""Station time in ns, and what happens then."""


class ChangePhase(Phase):
    """Changes of the station's state, each at its time."""

    place, name = PhasePlace.CHANGES, "changes"
    due_ns = math.inf

    def __init__(self) -> None:
        self.plans: Sequence[Plan] = ()
        """Pending plans; plans of one moment run in this order."""

    def plan(self, *plans: Plan) -> None:
        """Plan these and nothing else."""
        self.plans = plans
        self.due_ns = min((due_ns for due_ns, _ in plans), default=math.inf)

    def step(self, now_ns: int) -> None:
        """Do what is planned up to now."""
        due = [change for due_ns, change in self.plans if due_ns <= now_ns]
        self.plan(*(plan for plan in self.plans if plan[0] > now_ns))
        for change in due:
            change()


class NcPhase(Phase):
    """The SAF task of the NC. Its cycles can be done in one go: no phase reads between them."""

    place, name = PhasePlace.NC, "nc"
    catches_up = True
    due_ns = 0

    def __init__(self, nc: Nc, pace: Callable[[], Pace | None]) -> None:
        """`pace()` is how the station follows the wall clock, None in virtual time."""
        self._nc = nc
        self._task = NcTask(nc, pace)
        self._cycle_ns = nc.cycle_ns

    def begin(self, earliest_ns: int) -> None:
        """Begin at the first multiple of the cycle time from `earliest_ns` on."""
        self.due_ns = -(-earliest_ns // self._cycle_ns) * self._cycle_ns

    def step(self, now_ns: int) -> None:
        """Run all cycles up to now."""
        count = (now_ns - self.due_ns) // self._cycle_ns + 1
        self.due_ns += count * self._cycle_ns
        if count == 1:
            self._task.run(now_ns)
        else:
            self._nc.cycle(count)

    def cycles_ahead(self, first_ns: int, cycle_ns: int) -> Callable[[int], None] | None:
        """Return machine code that does the cycles before each moment, from `first_ns` on each
        `cycle_ns`; None if there is none.
        """
        count, rest = divmod(cycle_ns, self._cycle_ns)
        if rest or self.due_ns + (count - 1) * self._cycle_ns != first_ns:
            return None
        return self._nc.cycles_by_machine_code(count)

    def pass_over(self, elapsed_ns: int) -> None:
        """Count the cycles of a time that `cycles_ahead` has done."""
        self._nc.cycle_count += elapsed_ns // self._cycle_ns
        self.due_ns += elapsed_ns


class PlcLinks(Protocol):
    """Link between variables of a PLC and other parts: axes, channels."""

    def show(self) -> None:
        """Fill its inputs, before its tasks run."""

    def take(self) -> None:
        """Take its outputs, after its tasks ran."""


class PlcPhase(Phase):
    """The tasks of one PLC, each at its own cycle; before and after them, what is linked to it."""

    place = PhasePlace.PLC

    def __init__(self, plc: PlcRuntime, links: Sequence[PlcLinks] = ()) -> None:
        self.name = f"plc {plc.port}"
        self._plc = plc
        self._links = tuple(links)

    @property
    def due_ns(self) -> float:
        """Station time at which the next cycle of any task is due."""
        return self._plc.next_due_ns

    def step(self, now_ns: int) -> None:
        """Run every task that is due."""
        links = self._links
        if not links or self._plc.is_halted:
            self._plc.run_due(now_ns)
            return
        for each in links:
            each.show()
        self._plc.run_due(now_ns)
        for each in links:
            each.take()


class NotificationPhase(Phase):
    """Phase that sends the devices' notifications to their clients."""

    place, name = PhasePlace.NOTIFICATIONS, "notifications"

    def __init__(
        self,
        devices: Sequence[Device],
        budget: SampleBudget,
        pace: Callable[[], Pace | None] = lambda: None,
        nc: NcPhase | None = None,
        epoch: Callable[[], int] = int,
    ) -> None:
        """`budget` is that which the devices share, ticked in station time; `pace()` is how the
        station follows the wall clock, None in virtual time; `nc` may do its cycles together with
        the samples; `epoch()` is the Unix time at station time 0."""
        self._nc = nc
        self._epoch = epoch
        self.runs_ahead = nc is not None
        self._budget = budget
        self.watch(devices)
        self._pace = pace

    def watch(self, devices: Sequence[Device]) -> None:
        """Send the notifications of these devices, and of no others."""
        self._notifications = [device.notifications for device in devices]
        self._ahead = SamplesAhead(self._notifications)
        self._look_ahead()

    def _look_ahead(self) -> None:
        """Find the time of the first sample; earlier ones report to the budget."""
        due = math.inf
        for notifications in self._notifications:  # half the time of min()
            if notifications.due_ns < due:
                due = notifications.due_ns
        self._budget.first_due_ns = due

    @property
    def due_ns(self) -> float:
        """Station time at which the first sample of any device is due, or one that was deleted."""
        return self._budget.first_due_ns

    def step(self, now_ns: int) -> None:
        """Send the samples that are due."""
        for notifications in self._notifications:
            if notifications.due_ns <= now_ns:
                notifications.tick(now_ns)
        if self._budget.waiting:
            self._budget.serve(now_ns)
        self._look_ahead()
        pace = self._pace()
        if pace is not None:
            self._budget.press(pace.behind_ns)

    def run_ahead(self, now_ns: int, latest_ns: int) -> int:
        """Take the samples of several moments by machine code, with the cycles of the NC."""
        if self._nc is None or self._pace() is not None:
            return 0
        samples = self._ahead.next_samples(latest_ns)
        if samples is None:
            return 0
        source, due_ns, cycle_ns = samples
        if not now_ns < due_ns <= latest_ns:
            return 0
        cycles = self._nc.cycles_ahead(due_ns, cycle_ns)
        if cycles is None:
            return 0
        most = (latest_ns - due_ns) // cycle_ns + 1
        elapsed_ns = self._ahead.run(source, self._epoch() + due_ns, most, cycles) * cycle_ns
        if not elapsed_ns:
            return 0
        self._nc.pass_over(elapsed_ns)
        self._look_ahead()
        return due_ns + elapsed_ns - cycle_ns


def upkeep(devices: Sequence[Device], tick_ns: int, clock: Callable[[], int]) -> CyclicPhase:
    """Now and then devices look whether their clients are still there."""

    def sweep(_: int) -> None:
        now = clock()
        for device in devices:
            device.sweep(now)

    return CyclicPhase(PhasePlace.UPKEEP, "sweep", -(-_SWEEP_NS // tick_ns) * tick_ns, sweep)
