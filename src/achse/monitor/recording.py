"""Recordings: what a target answered, taken from a capture, by what was asked for.

Symbol handles differ from session to session; here they are replaced by the names they stand for,
so that recordings can be compared, and replayed to a client that asks in another order.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from achse.ams import AdsError, AmsAddress, Command, NetId
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ReadWriteRequest,
    WriteRequest,
    decode_response,
)
from achse.ams.notification import NotificationStream
from achse.client.session.sums import Outcome, Part
from achse.codes import ReservedGroup
from achse.codes.groups import NAMED
from achse.monitor.decode import Decoder, Exchange
from achse.monitor.names import Names
from achse.monitor.parts import outcomes_of, parts_of
from achse.router.tap import Captured
from achse.server import RowFacts


class Key(NamedTuple):
    """Identity of a part: `name` replaces a handle, or is the data of a ReadWrite."""

    command: Command
    group: int
    offset: int
    name: bytes


class RecordedDevice:
    """Recorded answers of one AMS port."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.info: ReadDeviceInfoResponse | None = None
        self.state: ReadStateResponse | None = None
        self.answers: dict[Key, list[Outcome]] = {}
        """The outcomes of each part in the order they came."""
        self.samples: dict[Key, list[tuple[int, bytes]]] = {}
        """Of each watched value: ns since the subscription, and the bytes."""
        self.handles: dict[bytes, int] = {}
        """By symbol name: the handle first given out for it."""
        self.names: dict[int, bytes] = {}
        """By handle: the symbol."""

    def key(self, part: Part) -> Key:
        """Return the key of `part`."""
        if isinstance(part, DeleteNotificationRequest):
            return Key(Command.DELETE_NOTIFICATION, 0, 0, b"")
        group, offset = part.index_group, part.index_offset
        name = b""
        if group in (ReservedGroup.SYMBOL_VALUE_BY_HANDLE, ReservedGroup.SYMBOL_NOTIFICATION):
            name, offset = self.names.get(offset, b""), 0
        match part:
            case ReadRequest():
                return Key(Command.READ, group, offset, name)
            case WriteRequest(data=data):
                if group == ReservedGroup.RELEASE_SYMBOL_HANDLE:
                    data = self.names.get(int.from_bytes(data, "little"), b"")
                    return Key(Command.WRITE, group, 0, data)
                return Key(Command.WRITE, group, offset, name)
            case ReadWriteRequest(data=data):
                query = symbol_name(data) if group in NAMED else name + data
                return Key(Command.READ_WRITE, group, offset, query)
            case AddNotificationRequest():
                return Key(Command.ADD_NOTIFICATION, group, offset, name)


def symbol_name(data: bytes) -> bytes:
    """Return a name as it is compared: without NUL and case."""
    return data.split(b"\0", 1)[0].lower()


class Recording:
    """The answers of one target: `Recording(read_capture(path))`.

    Where a capture holds several targets, it is the one that was asked most.
    """

    def __init__(self, captures: Iterable[Captured]) -> None:
        self.captures = list(captures)
        counts = Counter(
            frame.target[:6] for frame in self._frames(self.captures) if not frame.is_response
        )
        most = counts.most_common(1)
        self.net_id = NetId(most[0][0]) if most else NetId("0.0.0.0.0.0")
        self.devices: dict[int, RecordedDevice] = {}
        self._read()

    @staticmethod
    def _frames(captures: Iterable[Captured]) -> Iterator[Any]:
        for capture in captures:
            frame = capture.frame
            if frame.command != Command.NOTIFICATION:
                yield frame

    def device(self, port: int) -> RecordedDevice:
        """Return the device at an AMS port, an empty one if it was never asked."""
        return self.devices.setdefault(port, RecordedDevice(port))

    def _read(self) -> None:
        pending: dict[tuple[bytes, bytes, int, str], Captured] = {}
        watched: dict[tuple[bytes, int, int], tuple[Key, int]] = {}
        for capture in self.captures:
            frame = capture.frame
            if frame.command == Command.NOTIFICATION:
                port = AmsAddress(frame.source).port
                self._take_samples(capture.time_ns, frame, port, watched)
            elif not frame.is_response:
                if frame.target[:6] == self.net_id:
                    pending[frame.source, frame.target, frame.invoke_id, capture.peer] = capture
            else:
                key = (frame.target, frame.source, frame.invoke_id, capture.peer)
                captured = pending.pop(key, None)
                if captured is not None:
                    self._take(captured.frame, frame, capture.time_ns, watched)

    def _take(
        self,
        request: Any,
        response: Any,
        now: int,
        watched: dict[tuple[bytes, int, int], tuple[Key, int]],
    ) -> None:
        device = self.device(AmsAddress(request.target).port)
        try:
            parts = parts_of(request)
            if not parts:
                if not response.error:
                    self._take_plain(device, decode_response(response))
                return
            results = outcomes_of(request, parts, response)
        except AdsError:
            return
        for part, result in zip(parts, results, strict=True):
            key = device.key(part)
            device.answers.setdefault(key, []).append(result)
            if result.result:
                continue
            if key.group == ReservedGroup.SYMBOL_HANDLE_BY_NAME and len(result.data) >= 4:
                handle = int.from_bytes(result.data[:4], "little")
                device.handles.setdefault(key.name, handle)
                device.names[handle] = key.name
            elif isinstance(part, AddNotificationRequest):
                handle = int.from_bytes(result.data, "little")
                watched[request.source, device.port, handle] = (key, now)
                device.samples.setdefault(key, [])

    def _take_plain(self, device: RecordedDevice, answer: Any) -> None:
        if isinstance(answer, ReadDeviceInfoResponse) and not answer.result:
            device.info = answer
        elif isinstance(answer, ReadStateResponse) and not answer.result:
            device.state = answer

    def _take_samples(
        self,
        now: int,
        frame: Any,
        port: int,
        watched: dict[tuple[bytes, int, int], tuple[Key, int]],
    ) -> None:
        try:
            stamps = NotificationStream.decode(frame.data).stamps
        except AdsError:
            return
        for stamp in stamps:
            for sample in stamp.samples:
                key, since = watched.get((frame.target, port, sample.handle), (None, 0))
                if key is not None and sample.data:
                    self.device(port).samples[key].append((now - since, sample.data))


def differences(
    first: Recording, second: Recording, rows: Mapping[int, Sequence[RowFacts]] | None = None
) -> Iterator[str]:
    """Yield the differences between the answers of two targets, a line each.

    Values and errors are compared in their order, by device and by request; the number of
    repetitions of the last one does not count, and neither do times. `rows` provide the names of
    services, see `Names`; a type that only one of the clients requested is used for both.
    """
    one_names, two_names = (_learned(recording, rows or {}) for recording in (first, second))
    for port in {*first.devices, *second.devices}:
        one_knows = one_names.learn(AmsAddress.of(first.net_id, port))
        two_knows = two_names.learn(AmsAddress.of(second.net_id, port))
        one_knows.complete(two_knows)
        two_knows.complete(one_knows)
    before, after = _answers(first, one_names), _answers(second, two_names)
    for what in sorted({*before, *after}):
        one, two = before.get(what), after.get(what)
        if one == two:
            continue
        place = f"{what[0]} {what[1]}"
        if one is None or two is None:
            known = one or two or []
            yield f"{'+' if one is None else '-'} {place}: {_shown(known)}"
        else:
            yield f"! {place}: {_shown(one)} → {_shown(two)}"


_MOST_SHOWN = 5


def _shown(values: list[str]) -> str:
    more = f", … {len(values)} values" if len(values) > _MOST_SHOWN else ""
    return ", ".join(values[:_MOST_SHOWN]) + more


def _learned(recording: Recording, rows: Mapping[int, Sequence[RowFacts]]) -> Names:
    """Return all symbols of the recording, so that they are known from its start."""
    names = Names(rows)
    decoder = Decoder(names)
    for capture in recording.captures:
        for _ in decoder.see(capture):
            pass
    return names


def _answers(recording: Recording, names: Names) -> dict[tuple[int, str], list[str]]:
    """By AMS port and text of what was asked: the distinct values in a row."""
    answers: dict[tuple[int, str], list[str]] = {}
    decoder = Decoder(names)
    for capture in recording.captures:
        for exchange in decoder.see(capture):
            for what, value in _values(exchange):
                values = answers.setdefault((exchange.device.port, what), [])
                if not values or values[-1] != value:
                    values.append(value)
    return answers


def _values(exchange: Exchange) -> Iterator[tuple[str, str]]:
    for item in exchange.items:
        if item.group == ReservedGroup.SYMBOL_HANDLE_BY_NAME or item.verb in ("watch", "unwatch"):
            value = "done"
        else:
            value = item.value or "done"
        name = item.name or (f"0x{item.group:X}:0x{item.offset:X}" if item.group else "")
        error = f"error 0x{item.error:X}"
        yield f"{item.verb} {name}".strip(), error if item.error else value
