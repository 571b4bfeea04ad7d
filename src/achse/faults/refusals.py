"""Errors on a service or symbol: index groups of a device that refuse, inside sums too."""

from collections.abc import Callable, Iterable

from achse.ams import Command, DeviceError
from achse.codes import ReturnCode
from achse.faults.fault import ActiveFault, Undo
from achse.faults.selection import Selection
from achse.server import Device, IndexGroup
from achse.server.table import Reader

Place = tuple[Device, int]
"""An index group of a device."""


class Refusals:
    """Refusals that are active, by index group of a device."""

    def __init__(self) -> None:
        self._groups: dict[Place, _RefusingGroup] = {}

    def add(self, refusal: "Refusal", places: Iterable[Place]) -> Undo:
        """Refuse at these places; the groups need not be there."""
        entry = list(places)
        for place in entry:
            self._group(*place).refusals.append(refusal)
        return lambda: self._allow(refusal, entry)

    def _group(self, device: Device, index_group: int) -> "_RefusingGroup":
        group = self._groups.get((device, index_group))
        if group is None:
            group = self._groups[device, index_group] = _RefusingGroup()
            group.behind = device.replace(index_group, group)
        return group

    def _allow(self, refusal: "Refusal", places: Iterable[Place]) -> None:
        for device, index_group in places:
            group = self._groups[device, index_group]
            group.refusals = [each for each in group.refusals if each is not refusal]
            if not group.refusals:
                device.replace(index_group, group.behind)
                del self._groups[device, index_group]


class Refusal:
    """An error on a service or symbol."""

    def __init__(
        self,
        active: ActiveFault,
        code: int,
        selection: Selection,
        host: Callable[[bytes], str],
        finish: Callable[[ActiveFault], None],
    ) -> None:
        self._active = active
        self._code = code
        self._selection = selection
        self._host = host
        self._finish = finish

    def check(
        self, command: Command, group: int, offset: int, length: int, data: bytes, client: bytes
    ) -> None:
        selection, active = self._selection, self._active
        if (
            selection.command in (None, command)
            and selection.is_client(client, self._host(client))
            and selection.place(group, offset, length, data)
            and active.take()
        ):
            if active.used_up:
                self._finish(active)
            raise DeviceError(self._code, f"fault {active.number}")


class _RefusingGroup(IndexGroup):
    """Is before an index group, which may be one that the device does not have."""

    def __init__(self) -> None:
        self.behind: IndexGroup | None = None
        self.refusals: list[Refusal] = []

    def _inner(
        self,
        command: Command,
        group: int,
        offset: int,
        length: int,
        data: bytes,
        client: bytes,
    ) -> IndexGroup:
        for refusal in self.refusals:
            refusal.check(command, group, offset, length, data, client)
        if self.behind is None:
            raise DeviceError(ReturnCode.INVALID_GROUP, f"0x{group:X}")
        return self.behind

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        inner = self._inner(Command.READ, group, offset, length, b"", client)
        return inner.read(group, offset, length, client)

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        inner = self._inner(Command.READ, group, offset, length, b"", client)
        return inner.reader(group, offset, length, client)

    def watch(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        inner = self._inner(Command.ADD_NOTIFICATION, group, offset, length, b"", client)
        return inner.watch(group, offset, length, client)

    def context(self, group: int, offset: int, client: bytes) -> int:
        return 0 if self.behind is None else self.behind.context(group, offset, client)

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        inner = self._inner(Command.WRITE, group, offset, len(data), data, client)
        inner.write(group, offset, data, client)

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        inner = self._inner(Command.READ_WRITE, group, offset, read_length, data, client)
        return inner.read_write(group, offset, read_length, data, client)
