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
from achse.client.session.sums import Outcome, Part
from achse.codes import ReservedGroup
from achse.codes.groups import NAMED
from achse.monitor.names import Names
from achse.monitor.parts import outcomes_of, parts_of
from achse.router.tap import Captured
from achse.server import RowFacts

_PENDING = 10_000
"""Requests without an answer that are remembered; the oldest are reported without an answer."""

_AREAS = frozenset(
    (*range(0x4000, 0x4100), *range(ReservedGroup.INPUTS, ReservedGroup.CLEAR_INPUTS))
)
"""Memory and process images, where the offset is an address."""


class _Watched(NamedTuple):
    """Subject of a subscription: the symbol if it is one, else the name of the service."""

    symbol: str
    service: str
    group: int
    layout: str

    @property
    def name(self) -> str:
        return self.symbol or self.service


_NOTHING = _Watched("", "", 0, "")


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
        place = _place(self.group, self.offset) if self.group else ""
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
        """Return numbers and texts."""
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
        self._watched: dict[tuple[bytes, bytes, int], _Watched] = {}
        """By client, device and notification handle."""

    def see(self, capture: Captured) -> Iterator[Exchange]:
        """Yield the exchanges that `capture` completes."""
        try:
            frame = capture.frame
        except DecodeError:
            return
        if frame.command == Command.NOTIFICATION:
            yield self._samples(capture, frame)
        elif frame.is_response:
            key = (frame.target, frame.source, frame.invoke_id, frame.command, capture.peer)
            captured = self._pending.pop(key, None)
            if captured is not None:
                yield self._exchange(captured, captured.frame, capture, frame)
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
        return self._exchange_of(capture, frame, None, 0, items)._replace(answered=False)

    def _exchange(
        self, requested: Captured, request: Frame, answered: Captured, response: Frame
    ) -> Exchange:
        items = self._items(request, response)
        error = response.error or next((item.error for item in items if item.error), 0)
        return self._exchange_of(
            requested, request, answered.time_ns - requested.time_ns, error, items
        )

    def _exchange_of(
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
        """Return a command without a place."""
        verb = _command(request.command)
        if response is None:
            return Item(verb, 0, 0, "", "", 0)
        if response.error:
            return Item(verb, 0, 0, "", "", response.error)
        query, answer = decode_request(request), decode_response(response)
        value = ""
        if isinstance(query, WriteControlRequest):
            value = f"{_state(query.ads_state)}, device state {query.device_state}"
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
            watched = self._watched.pop((request.source, device, part.handle), _NOTHING)
            return Item("unwatch", 0, 0, watched.name or f"notification {part.handle}", "", error)
        group, offset = part.index_group, part.index_offset
        row = self.names.row(AmsAddress(device).port, group, offset)
        symbol = self._symbol(device, part)
        layout = "" if row is None else row.layout
        if data:
            self._learn(request, part, symbol, data)
        match part:
            case ReadRequest():
                verb = "read"
            case WriteRequest():
                verb, data = "write", part.data
            case ReadWriteRequest():
                verb = "ask" if group in NAMED else "read/write"
                layout = "" if row is None else row.response_layout
            case AddNotificationRequest():
                verb = "watch"
                if data:
                    service = _service(row, group, offset) if row else _place(group, offset)
                    key = (request.source, device, int.from_bytes(data, "little"))
                    self._watched[key] = _Watched(symbol, service, group, layout)
                data = b""
        name = symbol
        if row is not None and (not name or group in NAMED):
            name = f"{_service(row, group, offset)} {name}".strip()
        if group == ReservedGroup.RELEASE_SYMBOL_HANDLE and isinstance(part, WriteRequest):
            handle = int.from_bytes(part.data, "little")
            known_name = self.names.symbols(device).handle_name(handle) or f"0x{handle:X}"
            verb, name, data = "release", f"handle of {known_name}", b""
        value = self._value(device, group, symbol, data, layout) if data and not error else ""
        return Item(verb, group, offset, name, value, error)

    def _symbol(self, device: bytes, part: Any) -> str:
        """Return the symbol that a part is about, by handle, by name or by address; "" if none is
        known.

        Of a type (0xF011) its name.
        """
        group, offset = part.index_group, part.index_offset
        known = self.names.symbols(device)
        if group in (ReservedGroup.SYMBOL_VALUE_BY_HANDLE, ReservedGroup.SYMBOL_NOTIFICATION):
            return known.handle_name(offset)
        if group in NAMED:
            return known.text(part.data) if isinstance(part, ReadWriteRequest) else ""
        match part:
            case WriteRequest(data=data):
                return known.at(group, offset, len(data))
            case ReadWriteRequest(read_length=length):
                return known.at(group, offset, length)
        return known.at(group, offset, part.length)

    def _learn(self, request: Frame, part: Part, symbol: str, data: bytes) -> None:
        """Note the symbols of an answer."""
        assert not isinstance(part, DeleteNotificationRequest)
        group, device = part.index_group, request.target
        match group, part:
            case ReservedGroup.SYMBOL_HANDLE_BY_NAME, ReadWriteRequest():
                self.names.learn(device).learn_handle(symbol, data)
            case ReservedGroup.SYMBOL_INFO_BY_NAME, ReadWriteRequest():
                self.names.learn(device).learn_place(symbol, data)
            case ReservedGroup.SYMBOL_VERSION, ReadRequest():
                self.names.learn(device).learn_version(data)
            case ReservedGroup.TABLE_SIZES, ReadRequest():
                self.names.learn(device).learn_info(data)
            case (ReservedGroup.SYMBOL_TABLE | ReservedGroup.TYPE_TABLE, ReadRequest()) | (
                ReservedGroup.SYMBOL_ENTRY_BY_NAME | ReservedGroup.TYPE_ENTRY_BY_NAME,
                ReadWriteRequest(),
            ):
                offset = part.index_offset if isinstance(part, ReadRequest) else 0
                self.names.learn(device).learn_table(request.source, group, offset, data)

    def _value(self, device: bytes, group: int, symbol: str, data: bytes, layout: str) -> str:
        """Return the text for a value that was read, written or sampled."""
        if group == ReservedGroup.SYMBOL_HANDLE_BY_NAME:
            return f"handle 0x{int.from_bytes(data[:4], 'little'):X}"
        if group in (ReservedGroup.SYMBOL_ENTRY_BY_NAME, ReservedGroup.TYPE_ENTRY_BY_NAME):
            type = (
                self.names.symbols(device).type_of(symbol)
                if group == ReservedGroup.SYMBOL_ENTRY_BY_NAME
                else None
            )
            return type.name if type else f"{len(data)} bytes"
        if group in (ReservedGroup.SYMBOL_TABLE, ReservedGroup.TYPE_TABLE):
            return f"{len(data)} bytes"
        if not symbol or group == ReservedGroup.SYMBOL_INFO_BY_NAME:
            return self.names.text_of(data, None, layout)
        # A symbol's value has its type or none; a layout of the same size would be chance.
        return self.names.text_of(data, self.names.symbols(device).type_of(symbol), "")

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
        device = frame.source
        watched = self._watched.get((frame.target, device, handle), _NOTHING)
        if watched.group == ReservedGroup.SYMBOL_VERSION and data:
            self.names.learn(device).learn_version(data)
        value = ""
        if data:
            value = self._value(device, watched.group, watched.symbol, data, watched.layout)
        return Item("sample", 0, 0, watched.name or f"notification {handle}", value or "ended", 0)


def _service(row: RowFacts, group: int, offset: int) -> str:
    """Return the name of a row, with the number of the object if it has several, or the address."""
    if row.last_index_group > row.index_group:
        return f"{row.name}[{(group - row.index_group) & 0xFF}]"
    if row.last_index_offset > row.index_offset and group in _AREAS:
        return f"{row.name} {_place(group, offset)}"
    return row.name


def _place(group: int, offset: int) -> str:
    return f"0x{group:X}:0x{offset:X}"


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
