"""All scopes of one station: numbers, owners, limits, and one sample of each that is due."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from achse.ams import AmsAddress, DeviceError, Endpoint
from achse.codes import ReturnCode
from achse.devices.scope.channels import ScopeChannels
from achse.scope import Recorder, ScopeDefinition, ScopeError
from achse.scope.kernel import KERNEL
from achse.server.usage import host_of, host_share

_ROW_NS, _IN_MEMORY_NS, _PLAIN_NS, _CALLED_NS = 3000.0, 5.0, 300.0, 1500.0
"""Estimated time per sample, ns: a row, a value in memory (by machine code, by Python), a computed
value. The estimates are generous, so that a slow machine keeps to the limit, too."""


@dataclass(frozen=True, slots=True)
class ScopeLimits:
    """Limits of the scopes of a station; the clients of one host may use half of each."""

    memory: int = 256 * 1024 * 1024
    """Bytes of the rings of all scopes together (0x70A beyond)."""
    channels: int = 8192
    """Channels of all scopes together (0x716 beyond)."""
    scopes: int = 64
    """ScopeServer that clients have made, all together (0x716 beyond)."""
    scopes_per_client: int = 8
    """The same of one client."""
    time: float = 0.25
    """Share of the time that sampling may take, as reckoned at the start (0x708 beyond)."""


class NumberedScope:
    """A scope with its number; `owner` is the client that made it, empty if the station did."""

    __slots__ = ("number", "owner", "recorder", "way")

    def __init__(
        self, number: int, recorder: Recorder, owner: bytes = b"", way: Endpoint | None = None
    ) -> None:
        self.number = number
        self.recorder = recorder
        self.owner = owner
        self.way = way


class ScopeServer:
    """The scopes; number 1 is the view that the vendor's services are about."""

    def __init__(
        self,
        channels: ScopeChannels,
        clock: Callable[[], int],
        *,
        limits: ScopeLimits | None = None,
        tick_ns: int = 1,
        compiled: bool = True,
    ) -> None:
        """`clock()` is station time in ns, whose cycles are whole ticks."""
        self.limits = limits or ScopeLimits()
        self.due_ns: float = math.inf
        """Station time of the next sample of any scope, ns."""
        self._channels = channels
        self._clock = clock
        self._tick_ns = tick_ns
        self._compiled = compiled
        self._scopes: dict[int, NumberedScope] = {}
        self._last = 0
        self.add(ScopeDefinition())

    def __iter__(self) -> Iterator[NumberedScope]:
        return iter(self._scopes.values())

    def __getitem__(self, number: int) -> NumberedScope:
        """Return the scope of that number; raises DeviceError 0x70C."""
        scope = self._scopes.get(number)
        if scope is None:
            raise DeviceError(ReturnCode.NOT_FOUND, f"scope {number}")
        return scope

    # making and ending ---------------------------------------------------------------------------

    def make(self, definition: ScopeDefinition) -> Recorder:
        """Return a recorder for a definition. Raises ScopeError."""
        compiled = self._compiled and KERNEL.available
        return Recorder(definition, self._channels.find, compiled=compiled, tick_ns=self._tick_ns)

    def add(self, definition: ScopeDefinition) -> NumberedScope:
        """Return a scope of the station's own. Raises ScopeError."""
        return self._keep(self.make(definition), b"", None)

    def open(
        self, definition: ScopeDefinition, client: bytes, way: Endpoint | None
    ) -> NumberedScope:
        """Return a scope for a client, until it closes it or is gone. Raises ScopeError,
        DeviceError."""
        owners = [each.owner for each in self if each.owner]
        if owners.count(client) >= self.limits.scopes_per_client:
            raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"{owners.count(client)} scopes are open")
        if len(owners) >= self.limits.scopes:
            raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"{len(owners)} scopes are open")
        neighbours = self._of_host(client, way)
        if host_of(way) and len(neighbours) >= host_share(self.limits.scopes):
            raise DeviceError(
                ReturnCode.NO_MORE_HANDLES, f"{len(neighbours)} scopes of the host are open"
            )
        for part, most in (
            (self, self.limits.channels),
            (neighbours, host_share(self.limits.channels)),
        ):
            there = sum(len(each.recorder.definition.channels) for each in part)
            if there + len(definition.channels) > most:
                raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"{there} channels are open")
        return self._keep(self.make(definition), client, way)

    def _keep(self, recorder: Recorder, owner: bytes, way: Endpoint | None) -> NumberedScope:
        self._last += 1
        scope = self._scopes[self._last] = NumberedScope(self._last, recorder, owner, way)
        return scope

    def load(self, number: int, definition: ScopeDefinition) -> None:
        """Let a scope be another; it is offline then. Raises ScopeError, and stays as it is."""
        scope = self[number]
        recorder = self.make(definition)
        scope.recorder.stop()
        scope.recorder = recorder
        self._look()

    def close(self, scope: NumberedScope) -> None:
        """End a scope, with what it has recorded."""
        scope.recorder.stop()
        del self._scopes[scope.number]
        self._look()

    @property
    def clients(self) -> set[bytes]:
        """Clients that have scopes."""
        return {each.owner for each in self if each.owner}

    def end_client(self, client: bytes) -> None:
        """Close the scopes of a client that is gone."""
        for each in list(self):
            if each.owner and each.owner == client:
                self.close(each)

    def end_way(self, way: Endpoint) -> None:
        """Close the scopes that were made over a connection that is gone."""
        for each in list(self):
            if each.owner and each.way is way:
                self.close(each)

    # operation ---------------------------------------------------------------------------------

    def start(self, scope: NumberedScope) -> None:
        """Record from the next cycle on. Raises ScopeError; DeviceError beyond the limits."""
        self._check(scope, list(self), self.limits.memory, self.limits.time)
        if scope.owner:
            neighbours = self._of_host(scope.owner, scope.way)
            memory = host_share(self.limits.memory)
            self._check(scope, neighbours, memory, self.limits.time / 2)
        scope.recorder.start(self._clock())
        self._look()

    def _of_host(self, client: bytes, way: Endpoint | None) -> list[NumberedScope]:
        """Return the scopes that the clients of a host have made; those of the client if it has no
        host.

        A host has as many AMS addresses as it likes.
        """
        host = host_of(way)
        return [
            each
            for each in self
            if each.owner and (each.owner == client or (host and host_of(each.way) == host))
        ]

    def _check(
        self, scope: NumberedScope, among: list[NumberedScope], memory: int, time: float
    ) -> None:
        """Refuse a start that takes more than the others have left."""
        recorder = scope.recorder
        others = [each.recorder for each in among if each is not scope]
        used = sum(each.ring_bytes for each in others if each.groups)
        if used + recorder.ring_bytes > memory:
            raise DeviceError(
                ReturnCode.DEVICE_NO_MEMORY,
                f"rings of {recorder.ring_bytes} bytes, {max(memory - used, 0)} are free",
            )
        online = [each for each in others if each.due_ns < math.inf]
        share = sum(map(self._share, (recorder, *online)))
        if share > time:
            raise DeviceError(
                ReturnCode.BUSY,
                f"sampling would take {share:.0%} of the time, {time:.0%} are allowed",
            )

    def _share(self, recorder: Recorder) -> float:
        in_memory = _IN_MEMORY_NS if recorder.compiled else _PLAIN_NS
        return recorder.load(_ROW_NS, in_memory, _CALLED_NS)

    def stop(self, scope: NumberedScope) -> None:
        """Record no more; what there is stays."""
        scope.recorder.stop()
        self._look()

    def trigger(self, scope: NumberedScope) -> None:
        """Trigger the scope now. Raises DeviceError 0x712 unless it waits for the trigger."""
        try:
            scope.recorder.trigger(self._clock())
        except ScopeError as refusal:
            raise DeviceError(ReturnCode.INVALID_STATE, str(refusal)) from None
        self._look()

    def sample(self, now_ns: int) -> None:
        """Take all samples that are due at station time `now_ns`."""
        due: float = math.inf
        for each in self._scopes.values():
            recorder = each.recorder
            if recorder.due_ns <= now_ns:
                recorder.sample(now_ns)
            if recorder.due_ns < due:
                due = recorder.due_ns
        self.due_ns = due

    def find_again(self) -> None:
        """Find the symbols again, which may be elsewhere after an online change."""
        for each in self:
            each.recorder.find_again()
        self._look()

    def _look(self) -> None:
        self.due_ns = min((each.recorder.due_ns for each in self), default=math.inf)

    def facts(self, scope: NumberedScope, epoch_ns: int) -> dict[str, Any]:
        """Number, owner and state as JSON has them; times in Unix ns."""
        facts = scope.recorder.facts()
        for key in ("begin_ns", "trigger_ns"):
            if facts[key] is not None:
                facts[key] += epoch_ns
        for group in facts["channel_groups"]:
            group["begin_ns"] += epoch_ns
        owner = str(AmsAddress(scope.owner)) if len(scope.owner) == 8 else ""
        return {"number": scope.number, "owner": owner, **facts}
