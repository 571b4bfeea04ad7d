"""Captures to exchanges: each request with its answer, how long it took, and what it was about."""

from collections import OrderedDict
from collections.abc import Iterator
from typing import Any, NamedTuple

from achse.ams import AdsError, AdsState, AmsAddress, Command, DecodeError, Frame
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ReadWriteRequest,
    WriteControlRequest,
    WriteRequest,
    decode_request,
    decode_response,
)
from achse.ams.errors import describe_code
from achse.ams.notification import NotificationStream
from achse.client.sums import Outcome, Part
from achse.monitor.names import Names
from achse.monitor.parts import outcomes_of, parts_of
from achse.router.tap import Captured
from achse.server import RowFacts

__all__ = ["Decoder", "Exchange", "Item"]

_PENDING = 10_000
"""Requests without an answer that are remembered; the oldest are told as unanswered."""

_BY_HANDLE = (0xF005, 0xF006, 0xF010)
_BY_NAME = (0xF003, 0xF004, 0xF007, 0xF009, 0xF011)


class Item(NamedTuple):
    """One thing asked for: `verb` name = value, or the error."""

    verb: str
    group: int
    offset: int
    name: str
    """The symbol or the service, empty if neither is known."""
    value: str
    error: int

    @property
    def text(self) -> str:
        place = f"0x{self.group:X}:0x{self.offset:X}" if self.group else ""
        words = " ".join(word for word in (self.verb, self.name or place) if word)
        if self.error:
            return f"{words} ✗ {describe_code(self.error)}"
        return f"{words} = {self.value}" if self.value else words


class Exchange(NamedTuple):
    """A request with its answer, or a notification."""

    time_ns: int
    """Unix time of the request, or of the notification."""
    peer: str
    client: AmsAddress
    device: AmsAddress
    command: str
    duration_ns: int | None
    """From request to answer; None if there is none."""
    error: int
    """Of the AMS header or of the result; for a sum that of the first part that failed."""
    items: tuple[Item, ...]
    answered: bool = True

    def as_json(self) -> dict[str, Any]:
        """Numbers and texts."""
        return {
            "time_ns": self.time_ns,
            "peer": self.peer,
            "client": str(self.client),
            "device": str(self.device),
            "command": self.command,
            "duration_ns": self.duration_ns,
            "error": self.error,
            "answered": self.answered,
            "items": [item._asdict() for item in self.items],
        }


class Decoder:
    """Takes captures in order and gives what has become complete."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self._pending: OrderedDict[tuple[bytes, bytes, int, int, str], Captured] = OrderedDict()
        self._watched: dict[tuple[bytes, bytes, int], tuple[str, str, str]] = {}
        """By client, device and notification handle: name, type and layout."""

    def see(self, capture: Captured) -> Iterator[Exchange]:
        """What `capture` completes."""
        try:
            frame = capture.frame
        except DecodeError:
            return
        if frame.command == Command.NOTIFICATION:
            yield self._samples(capture, frame)
        elif frame.is_response:
            key = (frame.target, frame.source, frame.invoke_id, frame.command, capture.peer)
            asked = self._pending.pop(key, None)
            if asked is not None:
                yield self._exchange(asked, asked.frame, capture, frame)
        else:
            key = (frame.source, frame.target, frame.invoke_id, frame.command, capture.peer)
            self._pending[key] = capture
            self._pending.move_to_end(key)
            if len(self._pending) > _PENDING:
                yield self._unanswered(self._pending.popitem(last=False)[1])

    def overdue(self, before_ns: int) -> Iterator[Exchange]:
        """Requests from before that time that have no answer yet."""
        while self._pending:
            key, capture = next(iter(self._pending.items()))
            if capture.time_ns >= before_ns:
                return
            del self._pending[key]
            yield self._unanswered(capture)

    # exchanges -------------------------------------------------------------------------------

    def _unanswered(self, capture: Captured) -> Exchange:
        frame = capture.frame
        items = self._items(frame, None)
        return self._made(capture, frame, None, 0, items)._replace(answered=False)

    def _exchange(
        self, asked: Captured, request: Frame, answered: Captured, response: Frame
    ) -> Exchange:
        items = self._items(request, response)
        error = response.error or next((item.error for item in items if item.error), 0)
        return self._made(asked, request, answered.time_ns - asked.time_ns, error, items)

    def _made(
        self,
        capture: Captured,
        frame: Frame,
        duration: int | None,
        error: int,
        items: tuple[Item, ...],
    ) -> Exchange:
        return Exchange(
            capture.time_ns,
            capture.peer,
            AmsAddress(frame.source),
            AmsAddress(frame.target),
            _command(frame.command),
            duration,
            error,
            items,
        )

    def _items(self, request: Frame, response: Frame | None) -> tuple[Item, ...]:
        try:
            parts = parts_of(request)
            if not parts:
                return (self._plain(request, response),)
            outcomes: list[Outcome | None] = [None] * len(parts)
            if response is not None:
                outcomes = list(outcomes_of(request, parts, response))
            return tuple(
                self._item(request, part, result)
                for part, result in zip(parts, outcomes, strict=True)
            )
        except (AdsError, ValueError) as failure:
            error = 0 if response is None else response.error
            return (Item("cannot be decoded:", 0, 0, str(failure), "", error),)

    def _plain(self, request: Frame, response: Frame | None) -> Item:
        """A command without a place."""
        verb = _command(request.command)
        if response is None:
            return Item(verb, 0, 0, "", "", 0)
        if response.error:
            return Item(verb, 0, 0, "", "", response.error)
        asked, answer = decode_request(request), decode_response(response)
        value = ""
        if isinstance(asked, WriteControlRequest):
            value = f"{_state(asked.ads_state)}, device state {asked.device_state}"
        elif isinstance(answer, ReadStateResponse):
            value = f"{_state(answer.ads_state)}, device state {answer.device_state}"
        elif isinstance(answer, ReadDeviceInfoResponse):
            value = f"{answer.name} {answer.major}.{answer.minor}.{answer.build}"
        return Item(verb, 0, 0, "", "" if answer.result else value, answer.result)

    def _item(self, request: Frame, part: Part, result: Outcome | None) -> Item:
        device = request.target
        error = 0 if result is None else result.result
        data = b"" if result is None or error else result.data
        if isinstance(part, DeleteNotificationRequest):
            watched = self._watched.pop((request.source, device, part.handle), ("", "", ""))
            return Item("unwatch", 0, 0, watched[0] or f"notification {part.handle}", "", error)
        group, offset = part.index_group, part.index_offset
        row = self.names.row(AmsAddress(device).port, group, offset)
        name, type_name = self._name(device, part)
        layout = "" if row is None or type_name else row.layout
        match part:
            case ReadRequest():
                verb = "read"
                if group == 0xF00B and data:
                    self.names.learn_entries(device, data)
                    data = b""
            case WriteRequest():
                verb, data = "write", part.data
            case ReadWriteRequest():
                verb = "ask" if group in _BY_NAME else "read/write"
                layout = row.response_layout if row is not None else ""
                self._learn(device, group, name, data)
                if group == 0xF009 or group == 0xF011:
                    data = b""
                    type_name = self.names.type_of(device, name)
                    name = f"{name}: {type_name}" if type_name else name
            case AddNotificationRequest():
                verb = "watch"
                if data:
                    handle = int.from_bytes(data, "little")
                    self._watched[request.source, device, handle] = (
                        name or (_service(row, group) if row else f"0x{group:X}:0x{offset:X}"),
                        type_name,
                        layout,
                    )
                data = b""
                type_name = ""
        if row is not None and (not name or group in _BY_NAME):
            name = f"{_service(row, group)} {name}".strip()
        if group == 0xF006 and isinstance(part, WriteRequest):
            held = self.names.held(device, int.from_bytes(part.data, "little"))
            name, data = f"{name} {held}".strip(), b"" if held else data
        value = self.names.text_of(data, type_name, layout) if data and not error else ""
        return Item(verb, group, offset, name, value, error)

    def _name(self, device: bytes, part: Any) -> tuple[str, str]:
        """Symbol and type that a part is about, both may be empty."""
        group, offset = part.index_group, part.index_offset
        if group in (0xF005, 0xF010):
            name = self.names.held(device, offset)
        elif group in _BY_NAME and isinstance(part, ReadWriteRequest):
            name = part.data.split(b"\0", 1)[0].decode("cp1252", "replace")
        else:
            name = self.names.at(device, group, offset)
        is_value = group not in _BY_NAME or group == 0xF004
        return name, self.names.type_of(device, name) if name and is_value else ""

    def _learn(self, device: bytes, group: int, name: str, data: bytes) -> None:
        if group == 0xF003 and len(data) >= 4:
            self.names.learn_handle(device, int.from_bytes(data[:4], "little"), name)
        elif group == 0xF009 and data:
            self.names.learn_entries(device, data)

    def _samples(self, capture: Captured, frame: Frame) -> Exchange:
        try:
            stamps = NotificationStream.decode(frame.data).stamps
        except DecodeError as failure:
            items: tuple[Item, ...] = (Item("cannot be decoded:", 0, 0, str(failure), "", 0),)
        else:
            items = tuple(
                self._sample(frame, sample.handle, sample.data)
                for stamp in stamps
                for sample in stamp.samples
            )
        return Exchange(
            capture.time_ns,
            capture.peer,
            AmsAddress(frame.target),
            AmsAddress(frame.source),
            "notification",
            None,
            0,
            items,
        )

    def _sample(self, frame: Frame, handle: int, data: bytes) -> Item:
        name, type_name, layout = self._watched.get(
            (frame.target, frame.source, handle), (f"notification {handle}", "", "")
        )
        value = self.names.text_of(data, type_name, layout) if data else ""
        return Item("sample", 0, 0, name, value or "ended", 0)


def _service(row: RowFacts, group: int) -> str:
    """The name of a row, with the number of the object if it has several."""
    many = row.last_index_group > row.index_group
    return f"{row.name}[{(group - row.index_group) & 0xFF}]" if many else row.name


def _command(number: int) -> str:
    try:
        return Command(number).name.lower().replace("_", " ")
    except ValueError:
        return f"command {number}"


def _state(number: int) -> str:
    try:
        return AdsState(number).name
    except ValueError:
        return f"state {number}"
