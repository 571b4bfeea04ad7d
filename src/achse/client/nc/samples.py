"""Samples of an axis: sent by the NC, or fetched while a test lets virtual time pass.

Either way a row of samples ends with a typed error when the connection is lost: it is unknown what
the axis did meanwhile.
"""

import asyncio
import inspect
from collections.abc import AsyncGenerator, Awaitable, Callable, Sequence
from dataclasses import replace
from typing import Protocol

from achse.ams import ConnectionLost, DeviceError, RequestTimeout
from achse.ams.states import TransmissionMode
from achse.client.nc.services import CYCLIC, NcLayout, NcService, named
from achse.client.nc.status import AxisStatus
from achse.client.session.closing import ClosedByBlock
from achse.client.session.raw import RawTarget
from achse.client.session.session import Advance
from achse.client.session.subscription import Subscription, Timing, VariableLocation
from achse.codes import ReturnCode
from achse.iec.derived import OpaqueType

TICKS_PER_SECOND = 10_000_000
"""A time stamp counts 100 ns."""

LEAST_PATIENCE = 1.0
"""Seconds without a sample before an NC that should send one counts as silent, at least."""

_ROUNDING = 1 + 1e-9
"""A sample at the end of a duration still counts, whatever its sum of seconds was rounded to."""


class _UntilLoss(Subscription):
    """A subscription that ends with the connection, instead of being set up again."""

    def interrupt(self) -> None:
        what = "the connection or the device was lost; an axis that moves goes on"
        self.end(ConnectionLost(f"samples of {self.target}: {what}"))

    def renew(self) -> None:
        """Do nothing: the subscription has ended."""


class StatusReader:
    """Reads and decodes the cyclic structure of one axis, in the layout of TwinCAT 3 or 2."""

    def __init__(self, nc: RawTarget) -> None:
        self._nc = nc
        self.service: NcService = named((CYCLIC,), "nc_to_plc_structure")
        self._layouts: list[NcLayout] = list(reversed(self.service.layouts))

    @property
    def layout(self) -> NcLayout:
        """The layout that this NC understands, as far as known."""
        return self._layouts[0]

    def older(self, refusal: DeviceError) -> bool:
        """Go over to the shorter layout, if the refusal says that the longer one is not known."""
        if refusal.code != ReturnCode.INVALID_SIZE.number or len(self._layouts) == 1:
            return False
        del self._layouts[0]
        return True

    async def read(self, axis_id: int) -> AxisStatus:
        """Return the status now."""
        place = self.service.place(axis_id)
        while True:
            try:
                return self.status(await self._nc.read_raw(*place, self.layout.size))
            except DeviceError as refusal:
                if not self.older(refusal):
                    raise

    def status(self, data: bytes, time: float = 0.0, lost: int = 0) -> AxisStatus:
        """Return the status in `data`."""
        layout = next((each for each in self._layouts if each.size == len(data)), self.layout)
        return AxisStatus.of(layout.decode(data), time, lost)


class _Source(Protocol):
    """Source of samples."""

    async def open(self) -> None: ...

    async def next(self) -> AxisStatus: ...

    async def close(self) -> None: ...


class _Sent:
    """The NC sends a sample each `sample_time` seconds."""

    def __init__(
        self, nc: RawTarget, reader: StatusReader, axis_id: int, sample_time: float
    ) -> None:
        self._nc = nc
        self._reader = reader
        self._axis_id = axis_id
        self._timing = Timing.of(TransmissionMode.SERVER_CYCLE, 0.0, sample_time)
        self._patience = max(nc.timeout, LEAST_PATIENCE, 4 * sample_time)
        self._begin: int | None = None
        self._samples: Subscription | None = None

    async def open(self) -> None:
        while True:
            samples = _UntilLoss(self._nc, self._locate, self._timing)
            try:
                await samples.__aenter__()
            except DeviceError as refusal:
                if not self._reader.older(refusal):
                    raise
            else:
                self._samples = samples
                return

    async def _locate(self) -> Sequence[VariableLocation]:
        group, offset = self._reader.service.place(self._axis_id)
        size = self._reader.layout.size
        type: OpaqueType = OpaqueType("axis", size, 1, 0)
        return [VariableLocation("axis", group, offset, size, type)]

    async def next(self) -> AxisStatus:
        assert self._samples is not None
        try:
            async with asyncio.timeout(self._patience):
                sample = await anext(self._samples)
        except StopAsyncIteration:
            raise ConnectionLost("samples of the axis: the session was closed") from None
        except TimeoutError:
            raise RequestTimeout(
                f"no sample of the axis for {self._patience:g} s; does the NC's time stand still?"
            ) from None
        if self._begin is None:
            self._begin = sample.filetime
        time = (sample.filetime - self._begin) / TICKS_PER_SECOND
        return self._reader.status(sample.value, time, sample.lost)

    async def close(self) -> None:
        if self._samples is not None:
            await self._samples.close()


class _Fetched:
    """In virtual time: let `sample_time` seconds pass, and look."""

    def __init__(
        self,
        nc: RawTarget,
        reader: StatusReader,
        axis_id: int,
        sample_time: float,
        advance: Advance,
    ) -> None:
        self._session = nc.session
        self._reader = reader
        self._axis_id = axis_id
        self._sample_time = sample_time
        self._advance = advance
        self._losses = nc.session.losses
        self._count = -1

    async def open(self) -> None:
        self._losses = self._session.losses

    async def next(self) -> AxisStatus:
        self._count += 1
        if self._count:
            passed = self._advance(self._sample_time)
            if inspect.isawaitable(passed):
                await passed
        status = await self._reader.read(self._axis_id)
        if self._session.losses != self._losses:
            raise ConnectionLost(
                "samples of the axis: the connection was lost; an axis that moves goes on"
            )
        return replace(status, time=self._count * self._sample_time)

    async def close(self) -> None:
        pass


class AxisTrace(ClosedByBlock):
    """Samples of one axis as they come: `async for status in axis.trace(0.002)`.

    It begins with the first sample asked for, and ends after `duration` seconds of the controller's
    time, never if that is None. A reader that is too slow loses the oldest samples; `lost` of the
    next one counts them. `async with` ends it at the end of the block; without, a loop that
    is left early is ended with the trace itself. Raises `ConnectionLost` at a loss, and
    `RequestTimeout` when the NC is silent.
    """

    def __init__(
        self,
        nc: RawTarget,
        reader: StatusReader,
        find: Callable[[], Awaitable[int]],
        sample_time: float,
        duration: float | None,
    ) -> None:
        if not sample_time > 0:
            raise ValueError(f"sample_time: expected seconds above 0, got {sample_time!r}")
        if duration is not None and not duration >= 0:
            raise ValueError(f"duration: expected seconds or None, got {duration!r}")
        Timing.of(TransmissionMode.SERVER_CYCLE, 0.0, sample_time)  # its range
        self._nc = nc
        self._reader = reader
        self._find = find
        self._sample_time = sample_time
        self._duration = duration
        self._source: _Source | None = None
        self._is_closed = False

    async def close(self) -> None:
        """End the samples. A second call is not an error."""
        self._is_closed = True
        source, self._source = self._source, None
        if source is not None:
            await source.close()

    def __aiter__(self) -> AsyncGenerator[AxisStatus, None]:
        return self._each()  # a generator: a loop that is left early ends it, and so the samples

    async def _each(self) -> AsyncGenerator[AxisStatus, None]:
        try:
            while (status := await self.next()) is not None:
                yield status
        finally:
            await self.close()

    async def next(self) -> AxisStatus | None:
        """Return the next sample, None after the end. Any error ends the trace."""
        if self._is_closed:
            return None
        try:
            if self._source is None:
                self._source = await self._opened()
            status = await self._source.next()
        except BaseException:
            await self.close()
            raise
        if self._duration is not None and status.time > self._duration * _ROUNDING:
            await self.close()
            return None
        return status

    async def _opened(self) -> _Source:
        axis_id = await self._find()
        common = self._nc, self._reader, axis_id, self._sample_time
        source: _Source
        advance = self._nc.session.advance
        if advance is None:
            source = _Sent(*common)
        else:
            source = _Fetched(*common, advance)
        await source.open()
        return source
