"""The scope server's ADS device: the vendor's services (000 §5.2) and a modern face.

The vendor's services operate the one view, id 1, which is scope number 1 of the modern face. There
any client makes scopes of its own, which end with it.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from achse.ams import DeviceError, Endpoint, Frame
from achse.codes import ReturnCode
from achse.devices.scope.files import ScopeFiles
from achse.devices.scope.scopes import NumberedScope, ScopeServer
from achse.devices.system.file_worker import FileWorker
from achse.router.rate import Rates
from achse.scope import ScopeError, ScopeState, parse_definition
from achse.scope.binary import CHUNK, encode_chunk
from achse.scope.definition import LONGEST_RECORD
from achse.scope.service import SAMPLES_REQUEST, ScopeCommand, ScopeGroup
from achse.server import BYTES, READ, VOID, WRITE, Device, Group, Layout, RawGroup, Service

VIEW_ID = 1
"""The only view that the vendor's services know (000 §5.2)."""

_CHANNELS_AT_ONCE, _PER_SECOND, _AT_ONCE = 64, 32, 256
"""Opening and starting: channels that count as one, and how many of these a client may have in a
second and after a pause; all clients three times as many. A channel takes about 50 µs."""

_LARGEST_CHUNK = 4 * 1024 * 1024
"""Bytes of one answer with samples: copying them takes time that others need."""

_LARGEST_REQUEST = 4 * 1024 * 1024
"""Bytes of a definition that a client sends."""


class ScopeDevice(Device):
    """Answers for all scopes of a station.

    `epoch_at(time_ns)`: Unix time at station time 0, as it counted at a station time.
    """

    def __init__(
        self,
        scopes: ScopeServer,
        *,
        clock: Callable[[], int],
        epoch_at: Callable[[int], int],
        folder: Path | None = None,
    ) -> None:
        self.scopes = scopes
        self.files = ScopeFiles(folder)
        self.worker: Callable[[], FileWorker | None] = lambda: None
        """Return the worker for slow jobs outside the event loop, None while no event loop runs."""
        self._epoch_at = epoch_at
        self._asking = b""
        self._now = clock
        self._rates = Rates(
            _PER_SECOND, 3 * _PER_SECOND, at_once=_AT_ONCE, all_at_once=3 * _AT_ONCE
        )
        super().__init__(
            "TwinCAT Scope",
            (2, 9, 0),
            (
                Group(ScopeGroup.ROOT_STATES, ROOT_STATES, self),
                Group(ScopeGroup.ROOT_FUNCTIONS, ROOT_FUNCTIONS, self),
                Group(ScopeGroup.VIEW, VIEW, self),
                RawGroup(
                    ScopeGroup.SCOPES,
                    "scopes",
                    read=self._read_state,
                    read_write=self._command,
                    last_offset=0xFFFF_FFFF,
                    request="JSON: a definition, or start, stop, trigger, close, progress",
                    response="JSON: the scopes, a scope, or the error",
                    description="Offset 0: Read lists, ReadWrite makes a scope. Offset = number:"
                    " Read returns its state, ReadWrite commands it.",
                    source="achse",
                ),
                RawGroup(
                    ScopeGroup.SAMPLES,
                    "samples",
                    read_write=self._samples,
                    last_offset=0xFFFF_FFFF,
                    request="UINT32 group, UINT64 first row",
                    response="UINT32 group, UINT32 rows, UINT64 first row, 8 bytes per sample",
                    description="Offset = number of the scope: as many rows as the asked length"
                    " has room for; the first is later if older ones are gone.",
                    source="achse",
                ),
            ),
            clock=clock,
        )

    @property
    def view(self) -> NumberedScope:
        """The view with id 1."""
        return self.scopes[VIEW_ID]

    def deliver(self, frame: Frame) -> bool:
        """Answer a request; files are written in the turn of the request."""
        outer, self._asking = self._asking, frame.source
        try:
            return super().deliver(frame)
        finally:
            self._asking = outer

    # the vendor's services -----------------------------------------------------------------------

    def go_online(self) -> None:
        """Record from the next cycle on; a view that records goes on with it."""
        recorder = self.view.recorder
        if not recorder.online or recorder.state is ScopeState.DONE:
            self._start(self.view)

    def _start(self, scope: NumberedScope) -> None:
        try:
            self.scopes.start(scope)
        except ScopeError as fault:
            raise DeviceError(ReturnCode.INVALID_STATE, str(fault)) from None

    def load(self, name: bytes) -> None:
        """Let the view be what a file says; it is offline then."""
        try:
            self.scopes.load(VIEW_ID, self.files.load(name))
        except ScopeError as fault:
            raise DeviceError(ReturnCode.INVALID_DATA, str(fault)) from None

    def set_length(self, seconds: float) -> None:
        """Set another record length, while the view is offline."""
        recorder = self.view.recorder
        try:
            recorder.resize(recorder.definition.with_length(seconds))
        except ScopeError as fault:
            raise DeviceError(ReturnCode.INVALID_STATE, str(fault)) from None

    def epoch_of(self, scope: NumberedScope) -> int:
        """Unix time at time 0 of a recording: its newest sample has the stamp of its cycle."""
        return self._epoch_at(scope.recorder.newest_ns)

    def _facts(self, scope: NumberedScope) -> dict[str, Any]:
        return self.scopes.facts(scope, self.epoch_of(scope))

    def export(self, name: bytes) -> None:
        """Write what was recorded to a file."""
        self.files.path(name)  # refuse before the work
        recorder = self.view.recorder
        if not any(group.count for group in recorder.groups):
            raise DeviceError(ReturnCode.INVALID_STATE, "the view has recorded nothing")
        take = recorder.taking(self.epoch_of(self.view))
        self._beside(lambda: self.files.export(name, take()))

    def export_view(self, name: bytes) -> None:
        """Write the view itself to a file."""
        self.files.export_view(name, self.view.recorder.definition)

    def _beside(self, job: Callable[[], None]) -> None:
        """Do a job, in virtual time now, else beside the loop: raises Deferred then."""

        def done() -> bytes:
            job()
            return b""

        worker = self.worker()
        if worker is None:
            done()
        else:
            raise worker.later(self._asking, 0, done)

    # the modern face -----------------------------------------------------------------------------

    def _read_state(self, number: int, length: int, client: bytes) -> bytes:
        if number:
            return _json(self._facts(self.scopes[number]))
        return _json(
            [
                {
                    "number": each.number,
                    "name": each.recorder.definition.name,
                    "state": each.recorder.state.name.lower(),
                    "channels": len(each.recorder.definition.channels),
                    "own": bool(each.owner) and each.owner == client,
                }
                for each in self.scopes
            ]
        )

    def _command(self, number: int, length: int, data: bytes, client: bytes) -> bytes:
        if len(data) > _LARGEST_REQUEST:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a request of {len(data)} bytes")
        try:
            if not number:
                definition = parse_definition(data)
                self._spend(client, len(definition.channels))
                scope = self.scopes.open(definition, client, self.request_way)
                return _json({"scope": scope.number})
            if _word(data) == ScopeCommand.PROGRESS:
                return _json(self.scopes[number].recorder.progress())
            return _json(self._commanded(self._controlled(number, client), data))
        except ScopeError as fault:
            return _json({"error": str(fault)})

    def _controlled(self, number: int, client: bytes) -> NumberedScope:
        """Return a scope that the client may command: its own, or one of the station's."""
        scope = self.scopes[number]
        if scope.owner not in (b"", client):
            raise DeviceError(
                ReturnCode.DEVICE_ACCESS_DENIED, f"scope {number} is another client's"
            )
        return scope

    def _commanded(self, scope: NumberedScope, data: bytes) -> dict[str, Any]:
        word = _word(data)
        if word == ScopeCommand.START:
            self._spend(self._asking, len(scope.recorder.definition.channels))
            self.scopes.start(scope)
        elif word == ScopeCommand.STOP:
            self.scopes.stop(scope)
        elif word == ScopeCommand.TRIGGER:
            self.scopes.trigger(scope)
        elif word == ScopeCommand.CLOSE:
            if not scope.owner:
                raise ScopeError(f"scope {scope.number} is the station's own and stays")
            self.scopes.close(scope)
        else:
            raise ScopeError(f"expected {', '.join(ScopeCommand)}, got {word!r}")
        return self._facts(scope)

    def _spend(self, client: bytes, channels: int) -> None:
        """Count channels to find, which takes time: so many a second (0x708 beyond)."""
        now = self._now()
        for _ in range(1 + channels // _CHANNELS_AT_ONCE):
            if not self._rates.take(client, now):
                raise DeviceError(ReturnCode.BUSY, "too many scopes are opened and started")

    def _samples(self, number: int, length: int, data: bytes, client: bytes) -> bytes:
        scope = self.scopes[number]
        if len(data) != SAMPLES_REQUEST.size:
            raise DeviceError(
                ReturnCode.INVALID_SIZE, f"{SAMPLES_REQUEST.size} bytes, got {len(data)}"
            )
        place, first = SAMPLES_REQUEST.unpack(data)
        groups = scope.recorder.groups
        if place >= len(groups):
            raise DeviceError(
                ReturnCode.NOT_FOUND, f"channel group {place}, there are {len(groups)}"
            )
        group = groups[place]
        room = max(min(length, _LARGEST_CHUNK) - CHUNK.size, 0)
        first, rows = group.rows(first, room // group.row_bytes)
        return encode_chunk(place, len(rows) // group.row_bytes, first, rows)

    # clients -------------------------------------------------------------------------------------

    def end_client(self, client: bytes) -> None:
        """Close the scopes of a client that is gone."""
        self.scopes.end_client(client)
        super().end_client(client)

    def end_way(self, way: Endpoint) -> None:
        """Close what was made over a connection that is gone."""
        self.scopes.end_way(way)
        super().end_way(way)

    def _clients(self) -> set[bytes]:
        return super()._clients() | self.scopes.clients


def _word(data: bytes) -> str:
    return data[:40].rstrip(b"\0").decode(errors="replace").strip().strip('"').lower()


def _json(document: Any) -> bytes:
    return json.dumps(document).encode()


_SOURCE = "000 §5.2"

ROOT_STATES = (
    Service(
        0x1, "online", READ, Layout("<B"), "0 offline, 1 online",
        read=lambda device: int(device.view.recorder.online), source=_SOURCE,
    ),
    Service(
        0x1, "go_online", WRITE, VOID, "Go online: the rings take samples",
        write=lambda device, _: device.go_online(), source=_SOURCE,
    ),
    Service(
        0x2, "go_offline", WRITE, VOID, "Go offline: what was recorded stays",
        write=lambda device, _: device.scopes.stop(device.view), source=_SOURCE,
    ),
)  # fmt: skip

ROOT_FUNCTIONS = (
    Service(
        0x1, "load", WRITE, BYTES, "Load a file (.scp), by its name",
        write=lambda device, name: device.load(name), source=_SOURCE,
    ),
)  # fmt: skip

VIEW = (
    Service(
        0x100 + VIEW_ID, "trigger", WRITE, VOID, "Manual trigger; only online",
        write=lambda device, _: device.scopes.trigger(device.view), source=_SOURCE,
    ),
    # the manual prints no unit: seconds, and a write only while it is offline
    Service(
        0x200 + VIEW_ID, "record_length", READ | WRITE, Layout("<d"),
        "Duration of the recording", "s",
        read=lambda device: device.view.recorder.definition.record_length,
        write=lambda device, seconds: device.set_length(seconds),
        minimum=1e-9, maximum=LONGEST_RECORD, code=ReturnCode.INVALID_PARAMETER, source=_SOURCE,
    ),
    Service(
        0x1000 + VIEW_ID, "export", WRITE, BYTES, "Export the data as text, to a file of that name",
        write=lambda device, name: device.export(name), source=_SOURCE,
    ),
    Service(
        0x1010 + VIEW_ID, "export_view", WRITE, BYTES,
        "Export the view (a definition) to a file of that name",
        write=lambda device, name: device.export_view(name), source=_SOURCE,
    ),
)  # fmt: skip
