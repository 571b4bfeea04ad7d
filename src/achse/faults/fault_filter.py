"""Frame filter in the router while a fault of frames is active."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple

from achse.ams import Command, Frame
from achse.codes.station import SERVICE_PORT
from achse.faults.fault import ActiveFault, Undo
from achse.faults.selection import RequestFault, Selection, port_of
from achse.router import Router

SPARED_PORT = SERVICE_PORT
"""The station's own service: faults never cut off the way to clear them."""

_REMEMBERED = 4096
"""Requests under way whose answers are to be hit; more make no sensible test."""

_HITS = 8
"""Faults that hit one frame, the latest ones; eight that duplicate make 256 of it."""

_DELAYED_BYTES = 16 * 1024 * 1024
"""Frames that wait because of faults, all together; beyond, frames go on at once."""

_FRAME_BYTES = 512
"""Bytes of a buffered frame beside its data."""

Later = Callable[[float, Callable[[], None]], None]
Onward = Callable[[Frame], bool]


class FaultFilter:
    """Filter in the router that all frames pass while a frame fault is active."""

    def __init__(self, router: Router, later: Later, finish: Callable[[ActiveFault], None]) -> None:
        self.router = router
        self.later = later
        self._finish = finish
        self._is_in_router = False
        self._on_requests: list[_Entry] = []
        self._on_samples: list[_Entry] = []
        self._marked: dict[tuple[Any, ...], list[_Hit]] = {}
        self.delayed_frames: dict[int, tuple[Frame, Onward]] = {}
        """Frame that waits until another one overtakes it, by the number of the fault."""
        self._waiting_bytes = 0

    def begin(self, active: ActiveFault, fault: "FrameFault", selection: Selection) -> Undo:
        """Let the fault disturb the frames that are selected."""
        entry = _Entry(active, fault, selection)
        samples = selection.command == Command.NOTIFICATION
        faults = self._on_samples if samples else self._on_requests
        faults.append(entry)
        self._update()

        def undo() -> None:
            faults.remove(entry)
            self._update()

        return undo

    def delay(self, seconds: float, frame: Frame, action: Callable[[], None]) -> bool:
        """Call `action` later for a delayed frame; return False if too many bytes wait."""
        size = len(frame.data) + _FRAME_BYTES
        if self._waiting_bytes + size > _DELAYED_BYTES:
            return False
        self._waiting_bytes += size

        def due() -> None:
            self._waiting_bytes -= size
            action()

        self.later(seconds, due)
        return True

    def _update(self) -> None:
        """Enter the router, or leave it if no fault needs the frames."""
        needed = bool(self._on_requests or self._on_samples or self._marked)
        if needed and not self._is_in_router:
            self.router.set_frame_filter(self._filter)
        elif self._is_in_router and not needed:
            self.router.set_frame_filter(None)
        self._is_in_router = needed

    def _filter(self, frame: Frame, onward: Onward) -> bool:
        if frame.command == Command.NOTIFICATION:
            hits = self._take(self._on_samples, lambda selection: selection.sample(frame))
        elif frame.is_response:
            hits = self._marked.pop(_exchange(frame), [])
            if hits:
                self._update()
        elif port_of(frame.target) == SPARED_PORT:
            return onward(frame)
        else:
            hits = self._take(self._on_requests, lambda selection: selection.request(frame))
            later = [each for each in hits if each.fault.on_answer]
            if later:
                self._marked[_exchange(frame)] = later
                if len(self._marked) > _REMEMBERED:
                    del self._marked[next(iter(self._marked))]
                self._update()
                hits = [each for each in hits if each not in later]
        for hit in hits:
            onward = self._disturbed(hit, onward)
        return onward(frame)

    def _take(self, entries: list["_Entry"], selects: Callable[[Selection], bool]) -> list["_Hit"]:
        """Return the faults that hit this frame, and end those that are used up."""
        matches = [entry for entry in entries if selects(entry.selection)]
        hits = [_Hit(each.active, each.fault) for each in matches if each.active.take()][-_HITS:]
        for hit in hits:
            if hit.active.used_up:
                self._finish(hit.active)
        return hits

    def _disturbed(self, hit: "_Hit", onward: Onward) -> Onward:
        """Return `onward` behind the fault."""
        return lambda frame: hit.fault.disturb(self, hit.active, frame, onward)


class FrameFault(RequestFault):
    """Fault that disturbs frames in the router."""

    @property
    def on_answer(self) -> bool:
        """True if the fault hits the answer to a selected request."""
        return True

    @abstractmethod
    def disturb(
        self, frame_filter: FaultFilter, active: ActiveFault, frame: Frame, onward: Onward
    ) -> bool:
        """Disturb the frame instead of `onward(frame)`; return True if the frame was accepted."""


class _Entry(NamedTuple):
    active: ActiveFault
    fault: FrameFault
    selection: Selection


class _Hit(NamedTuple):
    active: ActiveFault
    fault: FrameFault


def _exchange(frame: Frame) -> tuple[Any, ...]:
    """Return the key that a request and its answer have in common."""
    if frame.is_response:
        return (frame.target, frame.source, frame.command, frame.invoke_id, id(frame.via))
    return (frame.source, frame.target, frame.command, frame.invoke_id, id(frame.origin))
