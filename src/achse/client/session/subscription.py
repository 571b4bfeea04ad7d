"""Subscriptions: samples of one or more variables as an asynchronous iterator.

A subscription outlives links, restarts of the target and online changes: it is set up again as
soon as that is possible, and the first sample afterwards says `gap`. Its queue is bounded: a slow
reader loses the oldest samples, `lost` counts them, and no other reader waits.
"""

import asyncio
import contextlib
from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from datetime import datetime
from typing import Any, NamedTuple, Self

from achse.ams import (
    AdsError,
    AmsAddress,
    ConnectionLost,
    DecodeError,
    DeviceError,
    TransmissionMode,
)
from achse.ams.commands import AddNotificationRequest, DeleteNotificationRequest
from achse.ams.filetime import to_datetime
from achse.client.session.closing import ClosedByBlock
from achse.client.session.raw import STALE, RawTarget
from achse.client.session.session import DEFAULT_BACKOFF, Backoff
from achse.client.session.sums import Outcome
from achse.codes import ReturnCode
from achse.iec import IecDecodeError, IecType

_PASSING = frozenset(
    code.number
    for code in (
        ReturnCode.NOT_READY,
        ReturnCode.BUSY,
        ReturnCode.NOT_INITIALIZED,
        ReturnCode.INVALID_STATE,
        ReturnCode.DEVICE_TIMEOUT,
        ReturnCode.PENDING,
    )
)
"""A device that answers one of these may answer otherwise in a moment."""


LONGEST_TIME = 429.4967295
"""Seconds that fit into the 32 bits of a notification's times."""


class VariableLocation(NamedTuple):
    """Location of a variable, with its length in bytes and its type."""

    name: str
    group: int
    offset: int
    length: int
    type: IecType[Any]

    def value(self, data: bytes) -> Any:
        """Return the value that `data` is; `DecodeError` if it is none of the type."""
        try:
            return self.type.decode(data)
        except IecDecodeError as error:
            raise DecodeError(f"{self.name}: {error}") from error


class Sample(NamedTuple):
    """One value of a subscribed variable.

    `filetime` is the target's time stamp, 100 ns since 1601 UTC. `lost` counts the samples of the
    subscription dropped before this one because the client did not fetch them in time. `gap` is
    True if the subscription was interrupted since the sample before: changes in between are
    unknown.
    """

    name: str
    value: Any
    filetime: int
    lost: int = 0
    gap: bool = False

    @property
    def time(self) -> datetime:
        """`filetime` as an aware UTC datetime."""
        return to_datetime(self.filetime)


class Timing(NamedTuple):
    """Send condition of the target: mode, and cycle time and largest delay in 100 ns."""

    mode: TransmissionMode
    max_delay: int
    cycle_time: int

    @classmethod
    def of(cls, mode: TransmissionMode, max_delay: float, cycle_time: float) -> "Timing":
        """From seconds; ValueError if negative or beyond 429 s, what the field holds."""
        for seconds in (max_delay, cycle_time):
            if not 0 <= seconds <= LONGEST_TIME:
                raise ValueError(f"a notification time is 0..{LONGEST_TIME} s, got {seconds:g}")
        return cls(mode, round(max_delay * 1e7), round(cycle_time * 1e7))


class _Channel:
    """One variable of a subscription, as the session knows it."""

    __slots__ = ("_subscription", "place")

    def __init__(self, subscription: "Subscription", place: VariableLocation) -> None:
        self._subscription = subscription
        self.place = place

    def feed(self, filetime: int, data: bytes) -> None:
        """Note that a sample came."""
        self._subscription.push(self.place, filetime, data)


class Subscription(ClosedByBlock):
    """Samples of variables of one target: `async with` sets it up, `async for` gives samples.

    `locate` finds the places of the variables, again at each set-up. `depth` bounds the queue.
    `forget` is called with a place that is out of date; None if places never change.
    """

    def __init__(
        self,
        target: RawTarget,
        locate: Callable[[], Awaitable[Sequence[VariableLocation]]],
        timing: Timing,
        depth: int = 10_000,
        forget: Callable[[VariableLocation], None] | None = None,
    ) -> None:
        if depth < 1:
            raise ValueError(f"a subscription holds at least 1 sample, got {depth}")
        self.dropped = 0
        """Number of samples dropped because the client did not fetch them in time."""
        self.interruptions = 0
        """Number of times that the subscription had to be set up again."""
        self._target = target
        self._session = target.session
        self._locate = locate
        self._timing = timing
        self._depth = depth
        self._forget = forget
        self._queue: deque[tuple[VariableLocation, int, bytes, int]] = deque()
        self._lost_samples = 0
        self._seen_interruptions = 0
        self._round = 0
        self._handles: list[tuple[bytes, int]] = []
        self._renewal: asyncio.Task[None] | None = None
        self._reader: asyncio.Future[None] | None = None
        self._is_entered = False
        self._is_closed = False
        self._error: AdsError | None = None

    @property
    def pending(self) -> int:
        """Samples that have come and wait to be fetched."""
        return len(self._queue)

    @property
    def target(self) -> AmsAddress:
        """The device that sends."""
        return self._target.address

    # set-up ----------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        self._is_entered = True
        self._session.keep(self)
        try:
            await self._arm()
        except BaseException:
            await self.close()
            raise
        return self

    async def close(self) -> None:
        """End it: the target forgets the handles, the iterator ends."""
        handles = self._handles
        self.end(None)
        self._session.drop(self)
        await self._delete(handles)
        for source, handle in handles:
            self._session.unlisten(source, handle)

    async def _delete(self, handles: Sequence[tuple[bytes, int]]) -> None:
        parts = [DeleteNotificationRequest(handle) for _, handle in handles]
        with contextlib.suppress(AdsError):
            await self._target.send_each(parts)

    async def leave(self) -> None:
        """Note that the session closes: as `close`."""
        await self.close()

    async def _arm(self) -> None:
        try:
            await self._try_to_arm()
        except DeviceError as error:
            if error.code not in STALE or self._forget is None:
                raise
            self._let_go()
            await self._try_to_arm()

    async def _try_to_arm(self) -> None:
        if self._is_closed:
            raise ConnectionLost("the subscription has ended")
        round_ = self._round
        channels = [_Channel(self, place) for place in await self._locate()]

        def look(first: int, source: bytes, outcomes: Sequence[Outcome]) -> None:
            if round_ != self._round or self._is_closed:
                return  # interrupted meanwhile; the session ends unused subscriptions
            for channel, outcome in zip(channels[first:], outcomes, strict=False):
                if outcome.result == 0:
                    handle = int.from_bytes(outcome.data, "little")
                    self._handles.append((source, handle))
                    self._session.listen(source, handle, channel)

        outcomes = await self._target.send_each(
            [AddNotificationRequest(*channel.place[1:4], *self._timing) for channel in channels],
            look,
        )
        refusal: DeviceError | None = None
        for channel, outcome in zip(channels, outcomes, strict=True):
            if outcome.result in STALE and self._forget is not None:
                self._forget(channel.place)
            if outcome.result and refusal is None:
                refusal = DeviceError(outcome.result, f"subscribe to {channel.place.name}")
        if refusal is not None:
            raise refusal

    def _let_go(self) -> None:
        """Listen no more to what is set up, and let the target forget it if it still can."""
        self._round += 1
        handles, self._handles = self._handles, []
        for source, handle in handles:
            self._session.unlisten(source, handle)
        if handles and self._session.link is not None:
            self._session.spawn(self._delete(handles))

    # calls of the session ------------------------------------------------------------------

    def interrupt(self) -> None:
        """Release the handles: the target forgot them, or is about to."""
        self.interruptions += 1
        self._let_go()
        if self._renewal is not None:
            self._renewal.cancel()
            self._renewal = None

    def renew(self) -> None:
        """Set up again in the background."""
        self._renewal = self._session.spawn(self._renew(self._session.backoff or DEFAULT_BACKOFF))

    async def _renew(self, backoff: Backoff) -> None:
        for pause in backoff.pauses():
            try:
                await self._arm()
                return
            except DeviceError as error:
                if error.code not in _PASSING:
                    self.end(error)
                    self._session.drop(self)
                    return
            except AdsError:
                if self._is_closed or self._session.link is None:
                    return
            self._let_go()
            await asyncio.sleep(pause)

    def symbols_changed(self) -> None:
        """Subscribe by name again: the variables may have moved."""
        if self._forget is not None:
            self.interrupt()
            self.renew()

    def end(self, error: AdsError | None) -> None:
        """End the iterator, with `error` if that is why."""
        if self._is_closed:
            return
        self._is_closed = True
        self._error = error
        self._handles = []
        if self._renewal is not None:
            self._renewal.cancel()
        self._wake()

    # samples ---------------------------------------------------------------------------------

    def push(self, place: VariableLocation, filetime: int, data: bytes) -> None:
        """Queue one sample. Data without bytes says that its handle is dead (000 §3.2.3.8)."""
        if not data and place.length:
            self.interrupt()
            self.renew()
            return
        queue = self._queue
        if len(queue) >= self._depth:
            queue.popleft()
            self.dropped += 1
            self._lost_samples += 1
        queue.append((place, filetime, data, self.interruptions))
        if self._reader is not None:
            self._wake()

    def _wake(self) -> None:
        reader, self._reader = self._reader, None
        if reader is not None and not reader.done():
            reader.set_result(None)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Sample:
        """Return the next sample, oldest first. Ends after `close`; raises if the target gave it
        up."""
        queue = self._queue
        while not queue:
            if self._error is not None:
                raise self._error
            if self._is_closed:
                raise StopAsyncIteration
            if not self._is_entered:
                raise RuntimeError(
                    "this subscription is not set up:"
                    " `async with target.subscribe(…) as samples:` (`with` if blocking)"
                )
            self._session.check_loop()
            if self._reader is not None:
                raise RuntimeError("another task waits for the next sample of this subscription")
            self._reader = asyncio.get_running_loop().create_future()
            try:
                await self._reader
            finally:
                self._reader = None
        place, filetime, data, interruptions = queue.popleft()
        lost, self._lost_samples = self._lost_samples, 0
        gap = interruptions != self._seen_interruptions
        self._seen_interruptions = interruptions
        return Sample(place.name, place.value(data), filetime, lost, gap)
