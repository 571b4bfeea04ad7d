"""A scope at work: started, waiting for its trigger, recording what comes after it, done.

It reads no clock: the owner of the time calls `sample` when something is due.
"""

import math
from collections.abc import Callable
from enum import IntEnum
from typing import Any

from achse.scope.channel import ScopeChannel
from achse.scope.channel_group import ChannelGroup, GroupChannel, ScopeSource
from achse.scope.data import ScopeBlock, ScopeData
from achse.scope.definition import ScopeDefinition
from achse.scope.types import WORD, ScopeError


class ScopeState(IntEnum):
    """State of a scope."""

    OFFLINE = 0
    RECORDING = 1
    """Online: the rings take samples, the oldest go; no trigger yet."""
    TRIGGERED = 2
    """Online: the rest of the record length is being recorded."""
    DONE = 3
    """Online: the recording is complete and stays as it is."""


Bind = Callable[[ScopeChannel], ScopeSource]


class Recorder:
    """One scope. `bind` finds the values of a channel and raises ScopeError."""

    def __init__(
        self, definition: ScopeDefinition, bind: Bind, *, compiled: bool, tick_ns: int = 1
    ) -> None:
        """`tick_ns`: sample times are multiples of it. Raises ScopeError as `bind` does."""
        self.definition = definition
        self.state = ScopeState.OFFLINE
        self.trigger_ns: int | None = None
        """Time of the trigger, ns; None before it."""
        self.begin_ns: int | None = None
        """Time of the start of the recording, ns; None before it."""
        self.due_ns: float = math.inf
        """Time of the next sample, ns; infinite for never."""
        self._bind = bind
        self.compiled = compiled
        """True if machine code takes the samples."""
        self._tick_ns = tick_ns
        self.groups: tuple[ChannelGroup, ...] = ()
        self._selection: list[tuple[ScopeChannel, ScopeSource, int]] = []
        self._stale = False
        """True if symbols may have moved since the channels were bound."""
        self._find()

    def _find(self) -> None:
        chosen = []
        for channel in self.definition.channels:
            source = self._bind(channel)
            step_ns = channel.sample_time_ns or source.cycle_ns
            if step_ns % self._tick_ns:
                raise ScopeError(
                    f"{channel.name}: expected a sample time in whole ticks of"
                    f" {self._tick_ns / 1e6:g} ms, got {step_ns / 1e6:g} ms"
                )
            chosen.append((channel, source, step_ns))
        steps = {channel.name: step_ns for channel, _, step_ns in chosen}
        watched = {steps[trigger.channel] for trigger in self.definition.triggers}
        if self.definition.combine == "all" and len(watched) > 1:
            raise ScopeError("combine: all triggers need channels of the same sample time")
        self._selection = chosen
        self._stale = False

    # what it will cost -------------------------------------------------------------------------

    def _capacity(self, step_ns: int) -> int:
        return max(-(-self.definition.length_ns // step_ns), 1)

    @property
    def ring_bytes(self) -> int:
        """Memory of all rings, once it is started."""
        return sum(WORD * self._capacity(step_ns) for _, _, step_ns in self._selection)

    def load(self, row_ns: float, in_memory_ns: float, called_ns: float) -> float:
        """Share of the time that sampling takes: by what a row, a value in memory and one that is
        computed take."""
        share = sum(row_ns / step_ns for step_ns in {step_ns for _, _, step_ns in self._selection})
        for _, source, step_ns in self._selection:
            share += (in_memory_ns if source.in_memory else called_ns) / step_ns
        return share

    def resize(self, definition: ScopeDefinition) -> None:
        """Take another record length. Raises ScopeError while it is online."""
        if self.online:
            raise ScopeError("the record length changes only while the scope is offline")
        self.definition = definition

    # operation ---------------------------------------------------------------------------------

    @property
    def online(self) -> bool:
        return self.state is not ScopeState.OFFLINE

    def start(self, now_ns: int) -> None:
        """Record from the next cycle on; what was recorded before is gone. Raises ScopeError."""
        if self._stale or any(each.failure for group in self.groups for each in group.channels):
            self._find()
        by_step: dict[int, list[GroupChannel]] = {}
        for channel, source, step_ns in self._selection:
            by_step.setdefault(step_ns, []).append(GroupChannel(channel, source))
        groups = []
        for step_ns, channels in by_step.items():
            names = {each.channel.name for each in channels}
            triggers = [each for each in self.definition.triggers if each.channel in names]
            group = ChannelGroup(
                channels, step_ns, self._capacity(step_ns), triggers, compiled=self.compiled
            )
            group.start((now_ns // step_ns + 1) * step_ns)
            groups.append(group)
        self.groups = tuple(groups)
        self.state = ScopeState.RECORDING
        self.trigger_ns, self.begin_ns = None, now_ns
        self._look()

    def stop(self) -> None:
        """Record no more; what there is stays until the next start."""
        self.state = ScopeState.OFFLINE
        self.due_ns = math.inf

    def trigger(self, now_ns: int) -> None:
        """Trigger the recording now. Raises ScopeError unless it waits for the trigger."""
        if self.state is not ScopeState.RECORDING:
            raise ScopeError(f"expected a scope that records, it is {self.state.name}")
        self._fire(now_ns, 1)

    def sample(self, now_ns: int) -> None:
        """Take all samples that are due."""
        fired, step_ns = 0, 1
        for group in self.groups:
            if group.due_ns <= now_ns and not group.done:
                hits = group.sample()
                if hits:
                    fired += hits
                    step_ns = max(step_ns, group.step_ns)
        if fired and self.state is ScopeState.RECORDING:
            needed = len(self.definition.triggers) if self.definition.combine == "all" else 1
            if fired >= needed:
                self._fire(now_ns, step_ns)
        self._look()

    def _fire(self, now_ns: int, step_ns: int) -> None:
        """Let each group end after the rest of the length, counted from its first sample there."""
        length = self.definition.length_ns
        rest = max(length - round(length * self.definition.pretrigger), step_ns)
        self.trigger_ns = now_ns
        self.state = ScopeState.TRIGGERED
        for group in self.groups:
            first = max(-(-(now_ns - group.begin_ns) // group.step_ns), 0)
            group.end_count = first + -(-rest // group.step_ns)
        self._look()

    def _look(self) -> None:
        due: float = math.inf
        for group in self.groups:
            if not group.done and group.due_ns < due:
                due = group.due_ns
        self.due_ns = due
        if due == math.inf and self.state is ScopeState.TRIGGERED:
            self.state = ScopeState.DONE

    def find_again(self) -> None:
        """Find the symbols again: channels continue where they are, or end where they are gone."""
        self._stale = True
        if not self.online or self.state is ScopeState.DONE:
            return
        for group in self.groups:
            for number, each in enumerate(group.channels):
                if each.failure:
                    continue
                try:
                    source = self._bind(each.channel)
                except ScopeError as gone:
                    group.lose(number, str(gone))
                    continue
                if source.type != each.type:
                    group.lose(number, f"is a {source.type.name} now, was {each.type.name}")
                else:
                    each.read = source.read
            group.bind()

    # what there is -----------------------------------------------------------------------------

    def data(self, epoch_ns: int = 0) -> ScopeData:
        """Return a copy of all samples that are there; `epoch_ns` is the Unix time of time 0."""
        return self.taking(epoch_ns)()

    def taking(self, epoch_ns: int = 0) -> Callable[[], ScopeData]:
        """Return the same to be copied later, in small pieces, by another thread if need be.

        What is recorded meanwhile is not in it; the oldest samples that go meanwhile, too.
        """
        trigger = None if self.trigger_ns is None else epoch_ns + self.trigger_ns
        name = self.definition.name
        ends = [(group, group.oldest, group.count) for group in self.groups]
        return lambda: ScopeData(
            name, tuple(_block(group, first, end, epoch_ns) for group, first, end in ends), trigger
        )

    @property
    def newest_ns(self) -> int:
        """Time of the newest sample, ns; without samples the start, 0 before it."""
        times = [group.due_ns - group.step_ns for group in self.groups if group.count]
        return max(times, default=self.begin_ns or 0)

    def progress(self) -> dict[str, Any]:
        """Return state and counts, for repeated queries."""
        return {
            "state": self.state.name.lower(),
            "channel_groups": [
                {"count": group.count, "oldest": group.oldest} for group in self.groups
            ],
        }

    def facts(self) -> dict[str, Any]:
        """State and progress as JSON has them; times in ns of the same clock as `sample` gets."""
        return {
            "name": self.definition.name,
            "state": self.state.name.lower(),
            "online": self.online,
            "begin_ns": self.begin_ns,
            "trigger_ns": self.trigger_ns,
            "record_length": self.definition.record_length,
            "pretrigger": self.definition.pretrigger,
            "combine": self.definition.combine,
            "triggers": [str(trigger) for trigger in self.definition.triggers],
            "ring_bytes": self.ring_bytes,
            "channel_groups": [
                {
                    "step_ns": group.step_ns,
                    "begin_ns": group.begin_ns,
                    "capacity": group.capacity,
                    "count": group.count,
                    "end_count": group.end_count,
                    "oldest": group.oldest,
                    "channels": [
                        {
                            **each.channel.document(),
                            "type": each.type.name,
                            "lost": each.failure,
                            "length": each.length,
                        }
                        for each in group.channels
                    ],
                }
                for group in self.groups
            ],
            "channels": [channel.name for channel, _, _ in self._selection],
        }


def _block(group: ChannelGroup, first: int, end: int, epoch_ns: int) -> ScopeBlock:
    """Return a copy of rows of a group."""
    first, rows = group.copy(first, end)
    count = len(rows) // group.row_bytes
    return ScopeBlock(
        begin_ns=epoch_ns + group.begin_ns + first * group.step_ns,
        step_ns=group.step_ns,
        channels=tuple(each.channel for each in group.channels),
        types=tuple(each.type for each in group.channels),
        lengths=tuple(
            count if each.length is None else min(max(each.length - first, 0), count)
            for each in group.channels
        ),
        rows=rows,
    )
