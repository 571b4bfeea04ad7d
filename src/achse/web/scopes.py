"""The scope in the browser: live blocks with triggers, recordings, and exports."""

import asyncio
import secrets
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from achse.ams import AdsError
from achse.client import Client, connect
from achse.client.links.link import RouterDialer
from achse.client.scope import RemoteScope, scopes_of
from achse.scope.channel import ScopeChannel, channel_of
from achse.scope.csv_form import csv_text
from achse.scope.data import ScopeBlock, ScopeData
from achse.scope.trigger import trigger_of
from achse.scope.types import ScopeError, type_of_words
from achse.web.arguments import Arguments
from achse.web.messages import CallError, dumped
from achse.web.mixed_times import channels_of, rows_of
from achse.web.sampling import (
    POLL,
    SampleRows,
    SharedSampling,
    TriggerWatch,
    described,
    from_notifications,
    from_scope,
)
from achse.web.send_queue import BlockFlag, PageSendQueue
from achse.web.symbols import SymbolHandlers
from achse.web.watched import NC_PORT, PLC_PORT, SCOPE_PORT, WatchedTarget

if TYPE_CHECKING:
    from achse.web.viewer import PageEnd

MOST_CHANNELS = 128
"""Of one scope of a page."""

MOST_SCOPES = 8
"""Of one page."""

MOST_SAMPLERS = 64
"""Of all pages: pages with the same channels at the same cycle share one."""

_MOST_RECORDINGS, _MOST_DOWNLOADS = 8, 8
_ROWS_AT_ONCE = 2000
"""Rows of a recording in one block."""

_WAITING = 1 << 20
"""Bytes that may wait at a page while a recording is sent."""

_UNITS = (
    ("PosDiff", ""), ("PosModulo", ""), ("Pos", ""), ("Velo", "/s"), ("Acc", "/s²"), ("Jerk", "/s³")
)  # fmt: skip
"""Units of an axis' symbols by what their names contain, behind the unit of positions."""


class PageScope:
    """One scope of one page: rows of a sampler, as blocks in its send queue."""

    def __init__(
        self, number: int, send_queue: PageSendQueue, zero_ns: int, trigger: TriggerWatch | None
    ) -> None:
        self.number = number
        self._send_queue = send_queue
        self._zero_ns = zero_ns
        self._trigger = trigger

    def take(self, sampler: SharedSampling, rows: SampleRows) -> None:
        """Accept new rows; the one that fires the trigger is the first of a block."""
        width = len(sampler.channels)
        fired = None if self._trigger is None else self._trigger.first(rows, width)
        parts = [(rows, BlockFlag.GAP if rows.gap else 0)]
        if fired is not None:
            cut, size = fired, 8 * width
            before = rows._replace(size=cut, rows=rows.rows[: cut * size])
            after = SampleRows(
                rows.begin_ns + cut * sampler.step_ns,
                rows.size - cut, rows.rows[cut * size :], False,
            )  # fmt: skip
            gap = BlockFlag.GAP if rows.gap and not cut else 0
            parts = [(before, parts[0][1])] * bool(cut) + [(after, BlockFlag.TRIGGER | gap)]
        for part, flags in parts:
            payload = sampler.columns(part, self._zero_ns)
            self._send_queue.put_block(self.number, payload, width + 1, part.size, flags)

    def end(self, failure: Exception | None) -> None:
        """Note that the sampler has ended."""
        if failure is not None:
            self._send_queue.put_event(event="scope", scope=self.number, text=str(failure))
        self._send_queue.put_block(self.number, b"", 0, 0, BlockFlag.END)


class ScopeHandlers:
    """Handlers of page calls about scopes."""

    def __init__(self, watched: WatchedTarget, symbols: SymbolHandlers) -> None:
        self._watched = watched
        self._symbols = symbols
        self._samplers: dict[str, SharedSampling] = {}
        self._zero: int | None = None
        self._recordings: dict[str, ScopeData] = {}
        self._downloads: dict[str, tuple[str, bytes]] = {}
        self._last_recording = 0
        self._units: dict[str, str] = {}
        self.poll = POLL
        """Seconds between fetches of samples."""

    @property
    def samplers(self) -> int:
        """Number of samplers that run."""
        return len(self._samplers)

    # what there is -----------------------------------------------------------------------------

    async def search(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `scope.search`: numbers that can be recorded, by words of name or comment."""
        limit = arguments.integer("limit", 50, 1, 500)
        await self._learn_units()
        rows = []
        for each in await self._symbols.search(arguments.text("text", ""), 5000):
            kind = type_of_words(each.type.name)
            if kind is None:
                continue
            rows.append(
                {
                    "name": each.path,
                    "kind": "axis" if each.port == NC_PORT else "symbol",
                    "type": kind.name,
                    "unit": self._unit(each.port, each.name),
                    "meaning": each.comment,
                }
            )
            if len(rows) >= limit:
                break
        return rows

    async def _learn_units(self) -> None:
        if self._units:
            return
        try:
            for axis in await self._watched.device(NC_PORT).nc.axes():
                self._units[str(axis).lower()] = await axis.unit()
        except AdsError:
            pass  # no NC: no units

    def _unit(self, port: int, name: str) -> str:
        parts = name.split(".")
        if port != NC_PORT or len(parts) < 3 or parts[-2].lower() not in self._units:
            return ""
        behind = next((text for word, text in _UNITS if word in parts[-1]), None)
        return "" if behind is None else self._units[parts[-2].lower()] + behind

    # live --------------------------------------------------------------------------------------

    async def start(self, page: "PageEnd", arguments: Arguments) -> dict[str, Any]:
        """Call `scope.start`: blocks of rows until `scope.stop`, or the page goes."""
        if len(page.scopes) >= MOST_SCOPES:
            raise CallError(f"a page has up to {MOST_SCOPES} scopes")
        names = arguments.names("channels", MOST_CHANNELS)
        if not names:
            raise CallError("channels: expected one at least")
        await self._learn_units()
        cycle = await self._cycle(arguments.number("cycle", 0.001, 1e-5, 10.0))
        channels = [self._channel(name, cycle) for name in names]
        wish = dumped([each.document() for each in channels])
        sampler = self._samplers.get(wish)
        if sampler is None or sampler.over:
            if len(self._samplers) >= MOST_SAMPLERS:
                raise CallError(f"all pages together have up to {MOST_SAMPLERS} different scopes")
            sampler = self._samplers[wish] = SharedSampling(channels, cycle, zero_ns=self._zero_at)
            sampler.poll = self.poll
        sampler.users += 1
        try:
            await sampler.open(await self._source())
            scope = self._page_scope(page, sampler, names, arguments)
        except BaseException:
            await self._left(wish, sampler)
            raise
        sampler.takers[scope] = None
        record = arguments.flag("record")

        async def leave() -> None:
            sampler.takers.pop(scope, None)
            if record:
                self._record(sampler.data(f"recording {self._last_recording + 1}"))
            await self._left(wish, sampler)

        page.scopes[scope.number] = (leave, sampler.data)
        return {
            "scope": scope.number,
            "channels": [
                {**described(each, type), "name": name}
                for each, type, name in zip(sampler.channels, sampler.types, names, strict=True)
            ],
            "cycle": sampler.step_ns / 1e9,
            "time_zero": (self._zero or 0) / 1e9,
        }

    def _page_scope(
        self, page: "PageEnd", sampler: SharedSampling, names: list[str], arguments: Arguments
    ) -> PageScope:
        watch = None
        if "trigger" in arguments:
            condition = arguments.value("trigger")
            if not isinstance(condition, dict):
                raise CallError(f"trigger: expected an object, got {condition!r:.60}")
            fields = {key: condition[key] for key in ("channel", "kind", "level", "low", "high")
                      if condition.get(key) is not None}  # fmt: skip
            trigger = trigger_of(fields)
            if trigger.channel not in names:
                raise CallError(f"trigger.channel: expected one of the channels, got "
                                f"{trigger.channel!r:.60}")  # fmt: skip
            number = names.index(trigger.channel)
            watch = TriggerWatch(trigger, number, sampler.types[number])
        return PageScope(page.next_scope(), page.send_queue, self._zero_at(0), watch)

    async def _left(self, wish: str, sampler: SharedSampling) -> None:
        """End a sampler without pages."""
        sampler.users -= 1
        if not sampler.users:
            if self._samplers.get(wish) is sampler:
                del self._samplers[wish]
            await sampler.close()

    async def stop(self, page: "PageEnd", arguments: Arguments) -> dict[str, Any]:
        """Call `scope.stop`."""
        number = arguments.integer("scope", None, 0, 0xFFFF)
        scope = page.scopes.pop(number, None)
        if scope is None:
            raise CallError(f"scope: the page has no scope {number}")
        await scope[0]()
        page.send_queue.forget_scope(number)
        return {}

    def _zero_at(self, time_ns: int) -> int:
        """Return the moment from which all times count: that of the first sample of this server."""
        if self._zero is None and time_ns:
            self._zero = time_ns // 1_000_000_000 * 1_000_000_000
        return self._zero or 0

    def _channel(self, name: str, cycle: float) -> ScopeChannel:
        try:
            channel = channel_of(name, "channels")
        except ScopeError as fault:
            raise CallError(str(fault)) from None
        port = channel.port
        if not port:
            port = NC_PORT if name.lower().startswith("axes.") else PLC_PORT
        return replace(
            channel,
            name=name[:255],
            port=port,
            sample_time_ns=round(cycle * 1e9),
            unit=self._unit(port, channel.symbol),
        )

    async def _cycle(self, requested: float) -> float:
        """Return the cycle in whole ticks of a station."""
        try:
            tick = float((await self._watched.statistics())["tick"])
        except AdsError:
            return requested
        return max(-(-round(requested * 1e9) // round(tick * 1e9)), 1) * tick

    async def _source(self) -> Callable[[SharedSampling], Any]:
        client = self._watched.client
        if not await self._watched.has_scopes():
            return from_notifications(client)

        async def connected(stack: AsyncExitStack) -> Client:
            # of one process each sampler is a client of its own: what a client may is for each
            if not isinstance(client.session.dialer, RouterDialer):
                return client
            router = client.session.dialer.router
            return await stack.enter_async_context(
                connect(router, port=PLC_PORT, keep_alive=None, watch_symbols=False)
            )

        return from_scope(connected)

    # recordings --------------------------------------------------------------------------------

    def _record(self, data: ScopeData) -> None:
        if data.blocks:
            self._last_recording += 1
            self._recordings[data.name] = data
            while len(self._recordings) > _MOST_RECORDINGS:
                del self._recordings[next(iter(self._recordings))]

    async def recordings(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `scope.recordings`: those of this server, and the scopes of the station."""
        rows: list[dict[str, Any]] = [
            {"name": name, "channels": list(data), "state": "done"}
            for name, data in self._recordings.items()
        ]
        if await self._watched.has_scopes():
            for each in await scopes_of(self._watched.device(SCOPE_PORT)):
                if each["channels"] and each["name"] != "browser":
                    name = f"scope {each['number']}: {each['name']}"
                    rows.append({"name": name, "channels": None, "state": each["state"]})
        return rows

    async def _recording(self, name: str) -> ScopeData:
        if name in self._recordings:
            return self._recordings[name]
        head, _, number = name.partition(":")[0].partition(" ")
        is_scope = head == "scope" and number.isdecimal() and int(number[:11]) <= 0xFFFF_FFFF
        if not is_scope or not await self._watched.has_scopes():
            raise CallError(f"name: there is not such a recording: {name!r:.60}")
        return await RemoteScope.of(self._watched.device(SCOPE_PORT), int(number)).data()

    async def load(self, page: "PageEnd", arguments: Arguments) -> dict[str, Any]:
        """Call `scope.load`: all rows of a recording, then an end mark.

        Channels with another `cycle` have NaN where they were not sampled.
        """
        data = await self._recording(arguments.text("name"))
        if not data.blocks:
            raise CallError("name: this recording has no samples")
        number, send_queue = page.next_scope(), page.send_queue
        self._zero_at(min(each.begin_ns for each in data.blocks))
        task = asyncio.create_task(self._send(send_queue, number, data.blocks))

        async def leave() -> None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

        page.scopes[number] = (leave, lambda name: data)
        return {
            "scope": number,
            "channels": [
                {**described(channel, type), "cycle": step_ns / 1e9}
                for channel, type, step_ns in channels_of(data.blocks)
            ],
            "cycle": min(each.step_ns for each in data.blocks) / 1e9,
            "time_zero": (self._zero or 0) / 1e9,
            "trigger": None
            if data.trigger_ns is None
            else (data.trigger_ns - (self._zero or 0)) / 1e9,
        }

    async def _send(
        self, send_queue: PageSendQueue, number: int, blocks: tuple[ScopeBlock, ...]
    ) -> None:
        width = len(channels_of(blocks)) + 1
        parts = rows_of(blocks, self._zero or 0, _ROWS_AT_ONCE)
        while (part := await asyncio.to_thread(next, parts, None)) is not None:
            await send_queue.drained_to(_WAITING)
            send_queue.put_block(number, part.columns, width, part.size)
        send_queue.put_block(number, b"", 0, 0, BlockFlag.END)

    async def export(self, page: "PageEnd", arguments: Arguments) -> str:
        """Call `scope.export`: a path under which the text can be fetched, for a while."""
        arguments.choice("format", ("csv",), "csv")
        if "scope" in arguments:
            number = arguments.integer("scope", None, 0, 0xFFFF)
            scope = page.scopes.get(number)
            if scope is None:
                raise CallError(f"scope: the page has no scope {number}")
            data = scope[1]("scope")
        else:
            data = await self._recording(arguments.text("name"))
        if not data.blocks:
            raise CallError("nothing has been recorded yet")
        text = await asyncio.to_thread(csv_text, data, f"{data.name}.csv")
        key = secrets.token_urlsafe(12)
        named = "".join(sign if sign.isalnum() else "-" for sign in data.name if sign.isascii())
        self._downloads[key] = (f"{named or 'scope'}.csv", text.encode())
        while len(self._downloads) > _MOST_DOWNLOADS:
            del self._downloads[next(iter(self._downloads))]
        return f"/download/{key}"

    def download(self, key: str) -> tuple[str, bytes] | None:
        """File name and contents of an export."""
        return self._downloads.get(key)
