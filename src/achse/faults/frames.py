"""Faults of frames: what goes wrong between a client and a device."""

from typing import Annotated, Literal

from achse.ams import Command, Frame
from achse.ams.commands import ERROR_PADDING, RESULT
from achse.codes import ReservedGroup
from achse.faults.fault import ActiveFault, FieldUnit, Moment, Undo, number
from achse.faults.fault_filter import FaultFilter, FrameFault, Onward
from achse.faults.refusals import Refusal
from achse.faults.selection import (
    Code,
    Selection,
    Sided,
    client_test,
    devices_at,
    host_of,
)
from achse.faults.site import Site, StationFault

_ALONE_S = 0.1
"""Delay of a frame that waits to be overtaken and is not, s."""


class _FrameKind(FrameFault, StationFault):
    def check(self, site: Site) -> None:
        client_test(self.client)
        if self.symbol:
            self.resolve_symbol(site.target)

    def begin(self, site: Site, active: ActiveFault) -> Undo:
        return site.fault_filter.begin(active, self, self.selection(site.target))


class _SidedKind(_FrameKind, Sided):
    @property
    def on_answer(self) -> bool:
        return self.side == "answer"


class Drop(_SidedKind):
    """Frames vanish: the answer never comes."""

    kind: Literal["drop"] = "drop"

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        return True


class Delay(_SidedKind):
    """Frames arrive `by` seconds late."""

    kind: Literal["delay"] = "delay"
    by: Moment
    """Delay of the frames, s."""

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        def arrive() -> None:
            onward(frame)

        return fault_filter.delay(self.by, frame, arrive) or onward(frame)


class Duplicate(_SidedKind):
    """Frames arrive twice."""

    kind: Literal["duplicate"] = "duplicate"

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        second = Frame(
            frame.target, frame.source, frame.command, frame.flags, frame.error,
            frame.invoke_id, frame.data,
        )  # fmt: skip
        second.origin, second.via = frame.origin, frame.via
        return onward(frame) and onward(second)


class Reorder(_SidedKind):
    """Of two frames in a row the second arrives first; one that stays alone arrives `by` seconds
    late (0.1)."""

    kind: Literal["reorder"] = "reorder"
    by: Moment | None = None
    """Delay of a frame without a second one, s; empty: 0.1."""

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        first = fault_filter.delayed_frames.pop(active.number, None)
        if first is not None:
            return onward(frame) and first[1](first[0])
        entry = (frame, onward)

        def give_up() -> None:
            if fault_filter.delayed_frames.get(active.number) is entry:
                del fault_filter.delayed_frames[active.number]
                onward(frame)

        if not fault_filter.delay(_ALONE_S if self.by is None else self.by, frame, give_up):
            return onward(frame)
        fault_filter.delayed_frames[active.number] = entry
        return True


class Cut(_FrameKind):
    """Half of the answer is sent, then the connection ends (TCP only)."""

    kind: Literal["cut"] = "cut"

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        break_off = getattr(frame.via, "break_off", None)
        if break_off is not None:
            break_off(frame)
        return True


class Truncate(_SidedKind):
    """The data of a frame lack their last `size` bytes (1); the header is right."""

    kind: Literal["truncate"] = "truncate"
    size: Annotated[int, number(int, 1), FieldUnit("bytes")] | None = None
    """Bytes that are missing; empty: 1."""

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        frame.data = frame.data[: -(self.size or 1)]
        return onward(frame)


class WrongInvokeId(_FrameKind):
    """The answer has an invoke id of no request."""

    kind: Literal["wrong_invoke_id"] = "wrong_invoke_id"

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        frame.invoke_id ^= 0x8000_0000
        return onward(frame)


class Error(_FrameKind):
    """The request is refused with `code` in the result; on a symbol or service also inside sums."""

    kind: Literal["error"] = "error"
    code: Code
    """Number of the error in the result: 0x706."""

    @property
    def on_answer(self) -> bool:
        return False

    def begin(self, site: Site, active: ActiveFault) -> Undo:
        if self.group is None and not self.symbol:
            return super().begin(site, active)
        selection: Selection = self.selection(site.target)
        if self.symbol:
            device, symbol = self.resolve_symbol(site.target)
            places = [
                (device, group)
                for group in (
                    ReservedGroup.SYMBOL_VALUE_BY_NAME,
                    ReservedGroup.SYMBOL_VALUE_BY_HANDLE,
                    symbol.index_group,
                )
            ]
        else:
            assert self.group is not None
            places = [(device, self.group) for device in devices_at(self.port, site.target)]

        def host(client: bytes) -> str:
            return host_of(site.target.router.way_to(client))

        refusal = Refusal(active, self.code, selection, host, site.finish)
        return site.refusals.add(refusal, places)

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        try:
            padding = ERROR_PADDING[Command(frame.command)]
        except (KeyError, ValueError):
            return onward(frame)  # the device says that there is no such command
        return fault_filter.router.deliver(frame.reply(RESULT.pack(self.code) + padding))


class RouterRefusal(_FrameKind):
    """The request is refused with `code` in the AMS header, as a router does."""

    kind: Literal["router_error"] = "router_error"
    code: Code
    """Number of the error in the AMS header: 0x7."""

    @property
    def on_answer(self) -> bool:
        return False

    def disturb(
        self, fault_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        return fault_filter.router.deliver(frame.reply(error=self.code))
