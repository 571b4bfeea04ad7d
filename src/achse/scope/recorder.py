"""A scope at work: started, waiting for its trigger, recording what comes after it, done.

It reads no clock: the owner of the time calls `sample` when something is due.
"""

import math
from collections.abc import Callable
from enum import IntEnum
from typing import Any

from achse.scope.channel import ScopeChannel
from achse.scope.data import ScopeBlock, ScopeData
from achse.scope.deck import Deck, DeckChannel, ScopeSource
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
        self.decks: tuple[Deck, ...] = ()
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
        if self._stale or any(each.failure for deck in self.decks for each in deck.channels):
            self._find()
        by_step: dict[int, list[DeckChannel]] = {}
        for channel, source, step_ns in self._selection:
            by_step.setdefault(step_ns, []).append(DeckChannel(channel, source))
        decks = []
        for step_ns, channels in by_step.items():
            names = {each.channel.name for each in channels}
            triggers = [each for each in self.definition.triggers if each.channel in names]
            deck = Deck(
                channels, step_ns, self._capacity(step_ns), triggers, compiled=self.compiled
            )
            deck.start((now_ns // step_ns + 1) * step_ns)
            decks.append(deck)
        self.decks = tuple(decks)
        self.state = ScopeState.RECORDING
        self.trigger_ns, self.begin_ns = None, now_ns
        self._look()

    def stop(self) -> None:
        """Record no more; what there is stays until the next start."""
        self.state = ScopeState.OFFLINE
        self.due_ns = math.inf

    def trigger(self, now_ns: int) -> None:
        """The moment that the recording is about is now. Raises ScopeError unless it waits."""
        if self.state is not ScopeState.RECORDING:
            raise ScopeError(f"expected a scope that records, it is {self.state.name}")
        self._fire(now_ns, 1)

    def sample(self, now_ns: int) -> None:
        """Take all samples that are due."""
        fired, step_ns = 0, 1
        for deck in self.decks:
            if deck.due_ns <= now_ns and not deck.done:
                hits = deck.sample()
                if hits:
                    fired += hits
                    step_ns = max(step_ns, deck.step_ns)
        if fired and self.state is ScopeState.RECORDING:
            wanted = len(self.definition.triggers) if self.definition.combine == "all" else 1
            if fired >= wanted:
                self._fire(now_ns, step_ns)
        self._look()

    def _fire(self, now_ns: int, step_ns: int) -> None:
        """Let each deck end after the rest of the length, from its first sample at it on."""
        length = self.definition.length_ns
        rest = max(length - round(length * self.definition.pretrigger), step_ns)
        self.trigger_ns = now_ns
        self.state = ScopeState.TRIGGERED
        for deck in self.decks:
            first = max(-(-(now_ns - deck.begin_ns) // deck.step_ns), 0)
            deck.end_count = first + -(-rest // deck.step_ns)
        self._look()

    def _look(self) -> None:
        due: float = math.inf
        for deck in self.decks:
            if not deck.done and deck.due_ns < due:
                due = deck.due_ns
        self.due_ns = due
        if due == math.inf and self.state is ScopeState.TRIGGERED:
            self.state = ScopeState.DONE

    def find_again(self) -> None:
        """Symbols may be elsewhere, or gone: channels go on where they are, or end."""
        self._stale = True
        if not self.online or self.state is ScopeState.DONE:
            return
        for deck in self.decks:
            for number, each in enumerate(deck.channels):
                if each.failure:
                    continue
                try:
                    source = self._bind(each.channel)
                except ScopeError as gone:
                    deck.lose(number, str(gone))
                    continue
                if source.type != each.type:
                    deck.lose(number, f"is a {source.type.name} now, was {each.type.name}")
                else:
                    each.read = source.read
            deck.bind()

    # what there is -----------------------------------------------------------------------------

    def data(self, epoch_ns: int = 0) -> ScopeData:
        """A copy of all samples that are there; `epoch_ns` is the Unix time of time 0."""
        return self.taking(epoch_ns)()

    def taking(self, epoch_ns: int = 0) -> Callable[[], ScopeData]:
        """The same to be copied later, in small pieces, by another thread if need be.

        What is recorded meanwhile is not in it; the oldest samples that go meanwhile, too.
        """
        trigger = None if self.trigger_ns is None else epoch_ns + self.trigger_ns
        name = self.definition.name
        ends = [(deck, deck.oldest, deck.count) for deck in self.decks]
        return lambda: ScopeData(
            name, tuple(_block(deck, first, end, epoch_ns) for deck, first, end in ends), trigger
        )

    @property
    def newest_ns(self) -> int:
        """Time of the newest sample, ns; without samples the start, 0 before it."""
        taken = [deck.due_ns - deck.step_ns for deck in self.decks if deck.count]
        return max(taken, default=self.begin_ns or 0)

    def progress(self) -> dict[str, Any]:
        """State and counts, for those who ask again and again."""
        return {
            "state": self.state.name.lower(),
            "decks": [{"count": deck.count, "oldest": deck.oldest} for deck in self.decks],
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
            "decks": [
                {
                    "step_ns": deck.step_ns,
                    "begin_ns": deck.begin_ns,
                    "capacity": deck.capacity,
                    "count": deck.count,
                    "end_count": deck.end_count,
                    "oldest": deck.oldest,
                    "channels": [
                        {
                            **each.channel.document(),
                            "type": each.type.name,
                            "lost": each.failure,
                            "length": each.length,
                        }
                        for each in deck.channels
                    ],
                }
                for deck in self.decks
            ],
            "channels": [channel.name for channel, _, _ in self._selection],
        }


def _block(deck: Deck, first: int, end: int, epoch_ns: int) -> ScopeBlock:
    """A copy of rows of a deck."""
    first, rows = deck.copy(first, end)
    count = len(rows) // deck.row_bytes
    return ScopeBlock(
        begin_ns=epoch_ns + deck.begin_ns + first * deck.step_ns,
        step_ns=deck.step_ns,
        channels=tuple(each.channel for each in deck.channels),
        types=tuple(each.type for each in deck.channels),
        lengths=tuple(
            count if each.length is None else min(max(each.length - first, 0), count)
            for each in deck.channels
        ),
        rows=rows,
    )
