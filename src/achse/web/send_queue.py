"""Send queue of one page: bounded, even if the page does not read.

Answers wait in order; of a state only the newest value is kept. Of lines and blocks of samples the
oldest are dropped first, and their number is reported to the page.
"""

import asyncio
import struct
from collections import deque

from achse.web.messages import dumped

MOST_LINES = 2000
"""Lines of one watch that wait."""

MOST_BLOCK_BYTES = 4 << 20
"""Bytes of samples that wait, of all scopes together."""

_LINES_AT_ONCE = 200

MOST_ANSWERS = 64
"""Answers that wait; a page that reads none gets no more calls done."""

BLOCK_HEADER = struct.Struct("<BBHIII")
"""Kind (1), flags, number of the scope, columns, rows, blocks dropped so far."""

_SAMPLES = 1


class BlockFlag:
    """Bits in the flags of a block."""

    GAP = 1
    """Samples are missing before this block."""
    TRIGGER = 2
    """The trigger is in this block."""
    END = 4
    """No more blocks come."""


class _WaitingLines:
    """Lines of one watch that wait."""

    def __init__(self) -> None:
        self.waiting: deque[str] = deque(maxlen=MOST_LINES)
        self.lost_lines = 0

    def add(self, lines: list[str]) -> None:
        over = len(self.waiting) + len(lines) - MOST_LINES
        self.lost_lines += max(over, 0)
        self.waiting.extend(lines)


class _Block:
    """A block of samples that waits."""

    __slots__ = ("columns", "flags", "payload", "rows", "scope")

    def __init__(self, scope: int, flags: int, columns: int, rows: int, payload: bytes) -> None:
        self.scope, self.flags, self.columns, self.rows = scope, flags, columns, rows
        self.payload = payload


class PageSendQueue:
    """Messages for one page. `put…` never waits, `take` waits for the next message."""

    def __init__(self) -> None:
        self._answers: deque[str] = deque()
        self._states: dict[int, str] = {}
        self._skipped: dict[int, int] = {}
        self._lines: dict[int, _WaitingLines] = {}
        self._blocks: deque[_Block] = deque()
        self._block_bytes = 0
        self._dropped: dict[int, int] = {}
        self._gaps: set[int] = set()
        self._some = asyncio.Event()
        self._room = asyncio.Event()
        self._room.set()
        self._lighter = asyncio.Event()

    @property
    def buffered_bytes(self) -> int:
        """Bytes of samples that wait."""
        return self._block_bytes

    def put(self, text: str) -> None:
        """Queue an answer or an event, which nothing replaces. The caller limits their number."""
        self._answers.append(text)
        if len(self._answers) >= MOST_ANSWERS:
            self._room.clear()
        self._some.set()

    async def room(self) -> None:
        """Wait until fewer answers wait than may."""
        await self._room.wait()

    def put_state(self, watch: int, fields: str) -> None:
        """Queue the newest value of a watch, `"value":…`; it replaces one that still waits."""
        if watch in self._states:
            self._skipped[watch] = self._skipped.get(watch, 0) + 1
        self._states[watch] = fields
        self._some.set()

    def put_lines(self, watch: int, lines: list[str]) -> None:
        """Queue lines of a watch, each as JSON."""
        self._lines.setdefault(watch, _WaitingLines()).add(lines)
        self._some.set()

    def put_block(
        self, scope: int, payload: bytes, columns: int, rows: int, flags: int = 0
    ) -> None:
        """Queue a block of samples: columns of float64, the first of them times."""
        if scope in self._gaps:
            flags |= BlockFlag.GAP
            self._gaps.discard(scope)
        self._blocks.append(_Block(scope, flags, columns, rows, payload))
        self._block_bytes += len(payload)
        while self._block_bytes > MOST_BLOCK_BYTES and len(self._blocks) > 1:
            self._drop(self._blocks.popleft())
        self._some.set()

    def _drop(self, oldest: _Block) -> None:
        """Leave a block out; what it said goes to the next of its scope."""
        self._block_bytes -= len(oldest.payload)
        self._dropped[oldest.scope] = self._dropped.get(oldest.scope, 0) + 1
        following = next((each for each in self._blocks if each.scope == oldest.scope), None)
        if following is None:
            self._gaps.add(oldest.scope)
        else:
            following.flags |= BlockFlag.GAP | (oldest.flags & (BlockFlag.END | BlockFlag.TRIGGER))

    async def drained_to(self, size: int) -> None:
        """Wait until no more than so many bytes of samples wait."""
        while self._block_bytes > size:
            self._lighter.clear()
            await self._lighter.wait()

    def forget_watch(self, watch: int) -> None:
        """Drop the queued values of a watch."""
        self._states.pop(watch, None)
        self._skipped.pop(watch, None)
        self._lines.pop(watch, None)

    def forget_scope(self, scope: int) -> None:
        """Drop the queued blocks of a scope."""
        self._blocks = deque(each for each in self._blocks if each.scope != scope)
        self._block_bytes = sum(len(each.payload) for each in self._blocks)
        self._lighter.set()
        self._dropped.pop(scope, None)
        self._gaps.discard(scope)

    async def take(self) -> str | bytes:
        """Return the next message: answers first, then states, lines, and a block."""
        while True:
            message = self._next()
            if message is not None:
                return message
            self._some.clear()
            await self._some.wait()

    def _next(self) -> str | bytes | None:
        if self._answers:
            self._room.set()
            return self._answers.popleft()
        if self._states:
            watch = next(iter(self._states))
            fields, lost = self._states.pop(watch), self._skipped.pop(watch, 0)
            return f'{{"event":"data","watch":{watch},"lost":{lost},{fields}}}'
        for watch, lines in self._lines.items():
            if lines.waiting or lines.lost_lines:
                del self._lines[watch]  # the next watch is first next time
                return self._some_lines(watch, lines)
        if self._blocks:
            block = self._blocks.popleft()
            self._block_bytes -= len(block.payload)
            self._lighter.set()
            dropped = self._dropped.get(block.scope, 0)
            head = BLOCK_HEADER.pack(
                _SAMPLES, block.flags, block.scope, block.columns, block.rows, dropped
            )
            return head + block.payload
        return None

    def _some_lines(self, watch: int, lines: _WaitingLines) -> str:
        count = min(len(lines.waiting), _LINES_AT_ONCE)
        chosen = ",".join(lines.waiting.popleft() for _ in range(count))
        lost, lines.lost_lines = lines.lost_lines, 0
        if lines.waiting:
            self._lines[watch] = lines
        return f'{{"event":"data","watch":{watch},"lost":{lost},"value":[{chosen}]}}'

    def put_event(self, **fields: object) -> None:
        """Queue an event with these fields."""
        self.put(dumped(fields))
