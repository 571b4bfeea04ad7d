"""Samplers: rows of values as they come, from a station's scope or by notifications.

One sampler serves all pages with the same wish. It hands rows on as columns of float64 and keeps
the last of them for exports.
"""

import asyncio
import logging
import struct
import time
from array import array
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack
from typing import Any, NamedTuple, Protocol

from achse.ams import AdsError
from achse.ams.filetime import to_unix_ns
from achse.client import Client
from achse.client.scope import block_of, defined, scope_of
from achse.scope.channel import ScopeChannel
from achse.scope.data import ScopeData
from achse.scope.trigger import ScopeTrigger, TriggerEvent
from achse.scope.types import SCOPE_TYPES, WORD, ScopeType, type_of_words

log = logging.getLogger("achse.web")

RING = 10.0
"""Seconds that the station keeps samples until they are fetched."""

POLL = 0.04
"""Seconds between fetches: 25 blocks a second."""

KEPT_BYTES = 16 << 20
"""Bytes of samples that each sampler keeps for exports."""

_REAL = SCOPE_TYPES["REAL64"]


class SampleRows(NamedTuple):
    """Rows that follow each other: words of 8 bytes, row by row, as scopes have them."""

    begin_ns: int
    """Unix time of the first."""
    size: int
    """Number of rows."""
    rows: bytes
    gap: bool
    """True if rows are missing before these."""


class SampleTaker(Protocol):
    """Receiver of the rows of a sampler."""

    def take(self, sampler: "SharedSampling", rows: SampleRows) -> None:
        """Accept new rows."""
        ...

    def end(self, failure: Exception | None) -> None:
        """End: no more rows come."""
        ...


def columns_of(rows: SampleRows, step_ns: int, zero_ns: int, types: Sequence[ScopeType]) -> bytes:
    """Times in seconds since `zero_ns`, then each channel, column by column as float64."""
    width = len(types)
    begin = rows.begin_ns - zero_ns
    parts = [array("d", [(begin + n * step_ns) / 1e9 for n in range(rows.size)]).tobytes()]
    words = memoryview(rows.rows).cast("q")
    for number, type in enumerate(types):
        column = words[number::width].tobytes()
        if type.code != "d":
            values = memoryview(column).cast(type.code)[:: WORD // type.size]  # type: ignore[call-overload]
            column = array("d", values.tolist()).tobytes()
        parts.append(column)
    return b"".join(parts)


class TriggerWatch:
    """Finds the row in which a trigger fires, across blocks."""

    def __init__(self, trigger: ScopeTrigger, number: int, type: ScopeType) -> None:
        self._band = trigger.band(type)
        self._number = number
        self._type = type
        self._before: bool | None = None

    def first(self, rows: SampleRows, width: int) -> int | None:
        """Return the first row that fires it; None without one."""
        band, first_row = self._band, None
        words = memoryview(rows.rows).cast("q")
        for row, word in enumerate(words[self._number :: width].tolist()):
            holds = (band.low <= self._type.key(word & self._type.mask) <= band.high) != (
                band.inverted
            )
            fires = {
                TriggerEvent.HOLDS: holds,
                TriggerEvent.BEGINS: holds and self._before is False,
                TriggerEvent.CHANGES: self._before is not None and holds != self._before,
            }[band.event]
            self._before = holds
            if fires and first_row is None:
                first_row = row
        return first_row


class SharedSampling:
    """Samples channels for all pages that request the same channels at the same cycle."""

    def __init__(
        self, channels: Sequence[ScopeChannel], cycle: float, *, zero_ns: Callable[[int], int]
    ) -> None:
        self.channels = tuple(channels)
        self.types: tuple[ScopeType, ...] = ()
        self.step_ns = round(cycle * 1e9)
        self.takers: dict[SampleTaker, None] = {}
        self.users = 0
        """Scopes of pages that are there or being opened."""
        self.poll = POLL
        self._zero_ns = zero_ns
        self._rows: deque[SampleRows] = deque()
        self._kept_bytes = 0
        self._encoded: tuple[SampleRows | None, int, bytes] = (None, 0, b"")
        self._ready: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._task: asyncio.Task[None] | None = None
        self._closed = False

    async def open(self, source: "Callable[[SharedSampling], AsyncIterator[SampleRows]]") -> None:
        """Begin; returns when types are known. Raises what the target refuses."""
        if self._task is None:
            self._task = asyncio.create_task(self._run(source))
        await asyncio.shield(self._ready)

    def known(self, types: Sequence[ScopeType], step_ns: int, begin_ns: int) -> None:
        """Note that the source has started: types and sample time of the channels, and about
        when."""
        self._zero_ns(begin_ns)
        self.types, self.step_ns = tuple(types), step_ns
        if not self._ready.done():
            self._ready.set_result(None)

    def columns(self, rows: SampleRows, zero_ns: int) -> bytes:
        """`columns_of` these rows; those that many pages get are encoded once."""
        if self._encoded[0] is not rows or self._encoded[1] != zero_ns:
            payload = columns_of(rows, self.step_ns, zero_ns, self.types)
            self._encoded = (rows, zero_ns, payload)
        return self._encoded[2]

    async def close(self) -> None:
        """End."""
        self._closed = True
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    @property
    def over(self) -> bool:
        """True once it has ended, or was closed; False before it begins."""
        return self._closed or (self._task is not None and self._task.done())

    async def _run(self, source: "Callable[[SharedSampling], AsyncIterator[SampleRows]]") -> None:
        failure: Exception | None = None
        try:
            async for rows in source(self):
                self._keep(rows)
                await self._hand_out(rows)
                self._encoded = (None, 0, b"")
        except (AdsError, ValueError) as refusal:
            failure = refusal
        except Exception as fault:
            log.exception("sampling")
            failure = fault
        if not self._ready.done():
            self._ready.set_exception(failure or ValueError("the recording ended at once"))
            self._ready.exception()  # a waiting page gets it, if there is one
        for taker in list(self.takers):
            taker.end(failure)

    async def _hand_out(self, rows: SampleRows) -> None:
        """Send to one page in each turn of the loop: all at once would delay a cycle."""
        for number, taker in enumerate(list(self.takers)):
            if number:
                await asyncio.sleep(0)
            if taker in self.takers:
                taker.take(self, rows)

    def _keep(self, rows: SampleRows) -> None:
        if rows.gap:
            self._rows.clear()
            self._kept_bytes = 0
        self._rows.append(rows)
        self._kept_bytes += len(rows.rows)
        while self._kept_bytes > KEPT_BYTES:
            self._kept_bytes -= len(self._rows.popleft().rows)

    def data(self, name: str) -> ScopeData:
        """Return the buffered rows since the last gap as a recording with this name."""
        if not self._rows:
            return ScopeData(name, ())
        rows = b"".join(each.rows for each in self._rows)
        count = sum(each.size for each in self._rows)
        group = {
            "begin_ns": self._rows[0].begin_ns,
            "step_ns": self.step_ns,
            "channels": [
                {**channel.document(), "type": type.name, "length": count}
                for channel, type in zip(self.channels, self.types, strict=True)
            ],
        }
        return ScopeData(name, (block_of(group, 0, rows),))


Source = Callable[[SharedSampling], AsyncIterator[SampleRows]]


def from_scope(
    connected: Callable[[AsyncExitStack], Awaitable[Client]],
) -> Source:
    """Rows of a scope of the station, sampled in its cycle."""

    async def source(sampler: SharedSampling) -> AsyncIterator[SampleRows]:
        async with AsyncExitStack() as stack:
            client = await connected(stack)
            definition = defined(
                sampler.channels, port=client.address.port, length=RING, name="browser"
            )
            remote = await stack.enter_async_context(scope_of(client, definition))
            [group] = (await remote.facts())["channel_groups"]
            types = [SCOPE_TYPES[each["type"]] for each in group["channels"]]
            step: int = group["step_ns"]
            sampler.known(types, step, group["begin_ns"])
            async for rows in remote.follow(sampler.poll):
                begin = group["begin_ns"] + rows.first * step
                yield SampleRows(begin, rows.size, rows.rows, rows.lost > 0)

    return source


def from_notifications(client: Client) -> Source:
    """Rows of a target without such a scope: notifications with one time stamp make a row.

    Of channels at several devices the first one's rows count; others keep their last value.
    """

    async def source(sampler: SharedSampling) -> AsyncIterator[SampleRows]:
        places = {(each.port, each.symbol): n for n, each in enumerate(sampler.channels)}
        latest = [0.0] * len(places)
        ports = list(dict.fromkeys(each.port for each in sampler.channels))
        ready: deque[SampleRows] = deque()
        some = asyncio.Event()
        for each in sampler.channels:
            type = await client.at_port(each.port).type_of(each.symbol)
            if type_of_words(type.name) is None:
                raise ValueError(f"{each.name}: expected a number, it is a {type.name}")
        sampler.known([_REAL] * len(places), sampler.step_ns, time.time_ns())
        pack = struct.Struct(f"<{len(places)}d").pack

        async def follow(port: int, leads: bool) -> None:
            names = [each.symbol for each in sampler.channels if each.port == port]
            stamp: int | None = None
            lost = False
            async with client.at_port(port).subscribe(
                names, cycle_time=sampler.step_ns / 1e9, max_delay=sampler.poll, mode="cycle"
            ) as samples:
                async for sample in samples:
                    if leads and stamp is not None and sample.filetime != stamp:
                        ready.append(SampleRows(to_unix_ns(stamp), 1, pack(*latest), lost))
                        some.set()
                        lost = False
                    stamp = sample.filetime
                    lost = lost or sample.lost > 0 or sample.gap
                    if not sample.gap or sample.value is not None:
                        latest[places[port, sample.name]] = float(sample.value)

        tasks = [asyncio.create_task(follow(port, not n)) for n, port in enumerate(ports)]
        try:
            while True:
                while not ready:
                    some.clear()
                    waiting = asyncio.create_task(some.wait())
                    done, _ = await asyncio.wait(
                        (waiting, *tasks), return_when=asyncio.FIRST_COMPLETED
                    )
                    waiting.cancel()
                    for task in tasks:
                        if task in done:
                            await task
                            return
                yield _joined(ready, sampler.step_ns)
                await asyncio.sleep(sampler.poll)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    return source


def _joined(ready: deque[SampleRows], step_ns: int) -> SampleRows:
    """Rows in a row, up to the next gap in time."""
    first = ready.popleft()
    parts = [first.rows]
    while ready and not ready[0].gap:
        expected = first.begin_ns + len(parts) * step_ns
        if abs(ready[0].begin_ns - expected) > step_ns // 2:
            ready[0] = ready[0]._replace(gap=True)
            break
        parts.append(ready.popleft().rows)
    return SampleRows(first.begin_ns, len(parts), b"".join(parts), first.gap)


def described(channel: ScopeChannel, type: ScopeType) -> dict[str, Any]:
    """Return a channel as pages know it."""
    return {"name": channel.name, "unit": channel.unit, "type": type.name}
