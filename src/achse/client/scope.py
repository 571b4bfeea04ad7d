"""Scopes of a station from afar: made, started, triggered, and what they record.

    async with client.scope(["MAIN.fLevel", "500:Axes.X.ActPos"], length=2.0) as scope:
        await scope.wait()
        data = await scope.data()

It needs an achse station: other targets have no such service behind port 14000.
"""

import asyncio
import json
from collections.abc import AsyncIterator, Iterable
from dataclasses import replace
from inspect import isawaitable
from typing import Any, NamedTuple, Self

from achse.ams import AmsAddress
from achse.client.session.closing import ClosedByBlock
from achse.client.session.raw import RawTarget
from achse.scope.binary import CHUNK, chunks_in
from achse.scope.channel import ScopeChannel, channel_of
from achse.scope.data import ScopeBlock, ScopeData
from achse.scope.definition import DEFAULT_LENGTH, ScopeDefinition, definition_of
from achse.scope.service import SAMPLES_REQUEST, SCOPE_PORT, ScopeCommand, ScopeGroup
from achse.scope.trigger import ScopeTrigger
from achse.scope.types import SCOPE_TYPES, ScopeError

_LONGEST_TEXT = 1 << 23
_LONGEST_CHUNK = 1 << 20
"""Bytes asked for at once."""

_PAUSE = 0.05
"""Seconds between looks whether a recording is done."""

Channels = str | ScopeChannel | Iterable[str | ScopeChannel | dict[str, Any]]
Triggers = str | ScopeTrigger | Iterable[str | ScopeTrigger]


class ScopeRows(NamedTuple):
    """Rows of one channel group, as `RemoteScope.follow` yields them."""

    group: int
    size: int
    """Number of rows."""
    first: int
    """Number of the first since the start."""
    rows: bytes
    lost: int
    """Rows before these that were gone already: the ring is too short for this client."""


def defined(
    channels: Channels,
    *,
    port: int,
    length: float = DEFAULT_LENGTH,
    triggers: Triggers = (),
    pretrigger: float = 0.0,
    combine: str = "any",
    name: str = "client",
) -> ScopeDefinition:
    """Return a definition whose channels without port mean `port`. Raises ScopeError."""
    listed = [channels] if isinstance(channels, str | ScopeChannel) else list(channels)
    each = [channel_of(one, f"channels[{number}]") for number, one in enumerate(listed, 1)]
    if port != SCOPE_PORT:
        each = [one if one.port else replace(one, port=port) for one in each]
    return definition_of(
        {
            "name": name,
            "channels": each,
            "record_length": length,
            "triggers": [triggers] if isinstance(triggers, str | ScopeTrigger) else list(triggers),
            "pretrigger": pretrigger,
            "combine": combine,
        }
    )


def scope_of(target: RawTarget, definition: ScopeDefinition) -> "RemoteScope":
    """Return a scope of one's own at the station behind `target`; `async with` makes and starts
    it."""
    return RemoteScope(_server(target), definition=definition)


async def scopes_of(target: RawTarget) -> list[dict[str, Any]]:
    """Return all scopes of a station: number, name, state, channels, own. Raises AdsError."""
    answer = await _server(target).read_raw(ScopeGroup.SCOPES, 0, _LONGEST_TEXT)
    listed: list[dict[str, Any]] = json.loads(answer)
    return listed


def _server(target: RawTarget) -> RawTarget:
    if target.address.port == SCOPE_PORT:
        return target
    address = AmsAddress.of(target.address.net_id, SCOPE_PORT)
    return RawTarget(target.session, address, target.timeout)


class RemoteScope(ClosedByBlock):
    """One scope of a station: one's own, or one that is there by its `number`.

    All methods raise AdsError; ScopeError where the station says what does not fit.
    """

    def __init__(
        self,
        server: RawTarget,
        *,
        definition: ScopeDefinition | None = None,
        number: int = 0,
    ) -> None:
        self._server = server
        self._definition = definition
        self.number = number
        """By which all clients know it; 0 as long as it is not made."""

    @classmethod
    def of(cls, target: RawTarget, number: int) -> "RemoteScope":
        """Return a scope that is there, by its number."""
        return cls(_server(target), number=number)

    async def __aenter__(self) -> Self:
        await self.open()
        try:
            await self.start()
        except BaseException:
            await self.close()
            raise
        return self

    async def open(self) -> None:
        """Make it at the station, if it is not there."""
        if not self.number and self._definition is not None:
            text = json.dumps(self._definition.document()).encode()
            self.number = int((await self._request(0, text))["scope"])

    async def close(self) -> None:
        """End it, with what it has recorded, if it is one's own."""
        if self.number and self._definition is not None:
            number, self.number = self.number, 0
            await self._request(number, ScopeCommand.CLOSE.encode())

    async def start(self) -> dict[str, Any]:
        """Record from the next cycle on; the state."""
        return await self._request(self._open_number(), ScopeCommand.START.encode())

    async def stop(self) -> dict[str, Any]:
        """Record no more; what there is stays; the state."""
        return await self._request(self._open_number(), ScopeCommand.STOP.encode())

    async def trigger(self) -> dict[str, Any]:
        """The moment is now; the state."""
        return await self._request(self._open_number(), ScopeCommand.TRIGGER.encode())

    async def facts(self) -> dict[str, Any]:
        """Return the state: `state` is offline, recording, triggered or done; times in Unix ns."""
        answer = await self._server.read_raw(ScopeGroup.SCOPES, self._open_number(), _LONGEST_TEXT)
        facts: dict[str, Any] = json.loads(answer)
        return facts

    async def wait(self, within: float | None = None) -> dict[str, Any]:
        """Wait until the recording is done, so many seconds at most; the state.

        Raises TimeoutError.
        """
        advance = self._server.session.advance
        async with asyncio.timeout(within):
            while True:
                state = (await self._request(self._open_number(), ScopeCommand.PROGRESS.encode()))[
                    "state"
                ]
                if state == "done":
                    return await self.facts()
                if state == "offline":
                    raise ScopeError("expected a recording that goes on, it is offline")
                if advance is not None:
                    passed = advance(_PAUSE)
                    if isawaitable(passed):
                        await passed
                else:
                    await asyncio.sleep(_PAUSE)

    async def data(self) -> ScopeData:
        """Return the samples that are recorded now."""
        facts = await self.facts()
        blocks = []
        for number, group in enumerate(facts["channel_groups"]):
            first, rows = await self._rows(number, group, group["oldest"], group["count"])
            blocks.append(block_of(group, first, rows))
        return ScopeData(facts["name"], tuple(blocks), facts["trigger_ns"])

    async def follow(self, pause: float = _PAUSE) -> AsyncIterator[ScopeRows]:
        """Yield rows as they arrive, one channel group after the other, until the recording
        ends."""
        seen: dict[int, int] = {}
        groups = (await self.facts())["channel_groups"]
        while True:
            progress = await self._request(self._open_number(), ScopeCommand.PROGRESS.encode())
            for number, (group, now) in enumerate(
                zip(groups, progress["channel_groups"], strict=True)
            ):
                wanted = seen.get(number, 0)
                while wanted < now["count"]:
                    chunk = await self._chunk(number, group, wanted)
                    if not chunk.size:
                        break
                    yield chunk
                    wanted = chunk.first + chunk.size
                seen[number] = wanted
            if progress["state"] in ("done", "offline"):
                return
            await asyncio.sleep(pause)

    async def _rows(
        self, number: int, group: dict[str, Any], first: int, end: int
    ) -> tuple[int, bytes]:
        """Rows up to number `end`, and the number of the first; those that go meanwhile are left
        out."""
        parts: list[bytes] = []
        begin = wanted = first
        while wanted < end:
            chunk = await self._chunk(number, group, wanted)
            if not chunk.size:
                break
            if chunk.lost:
                parts.clear()
                begin = chunk.first
            parts.append(chunk.rows)
            wanted = chunk.first + chunk.size
        return begin, b"".join(parts)

    async def _chunk(self, number: int, group: dict[str, Any], first: int) -> ScopeRows:
        width = len(group["channels"])
        length = max(_LONGEST_CHUNK, CHUNK.size + 8 * width)
        request = SAMPLES_REQUEST.pack(number, first)
        answer = await self._server.read_write_raw(
            ScopeGroup.SAMPLES, self._open_number(), length, request
        )
        [chunk] = chunks_in(answer, {number: width})
        return ScopeRows(*chunk, lost=chunk.first - first)

    async def _request(self, number: int, data: bytes) -> dict[str, Any]:
        answer = await self._server.read_write_raw(ScopeGroup.SCOPES, number, _LONGEST_TEXT, data)
        facts: dict[str, Any] = json.loads(answer)
        if "error" in facts:
            raise ScopeError(facts["error"])
        return facts

    def _open_number(self) -> int:
        if not self.number:
            raise ScopeError("expected a scope that is open")
        return self.number


def block_of(group: dict[str, Any], first: int, rows: bytes) -> ScopeBlock:
    """Return a block of a group's rows; `first` is the number of the first row."""
    types = tuple(SCOPE_TYPES[each["type"]] for each in group["channels"])
    channels = tuple(
        channel_of({key: each[key] for key in each if key not in ("lost", "length")})
        for each in group["channels"]
    )
    count = len(rows) // (8 * len(channels))
    return ScopeBlock(
        begin_ns=group["begin_ns"] + first * group["step_ns"],
        step_ns=group["step_ns"],
        channels=channels,
        types=types,
        lengths=tuple(
            count if each["length"] is None else min(max(each["length"] - first, 0), count)
            for each in group["channels"]
        ),
        rows=rows,
    )
