"""Index groups and the table of all services that a device offers.

Every kind of group answers the same four questions (read, write, read_write, watch) and lists its
rows; the `ServiceTable` finds the group of a request in one dictionary.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server.rows import READ, READ_WRITE, WRITE, Access, RowFacts, Service

Reader = Callable[[], bytes]
"""Takes one sample; never longer than was asked for when it was made."""


_ELEMENTS = 0x00F0_0000
"""Bits of an offset that contain the number of a sub-element."""


class IndexGroup:
    """Base of all groups: refuses every access with 0x704; subclasses serve some.

    `client` is the AMS address of the asking client (8 bytes, or empty inside this process).
    All methods raise DeviceError. No answer is longer than asked, and none is built by the asked
    length.
    """

    def index_groups(self) -> Iterable[int]:
        """Return every index group that this serves."""
        raise NotImplementedError

    def describe(self) -> Iterator[RowFacts]:
        """Return the rows, in order of their offsets."""
        raise NotImplementedError

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        """Return a function that reads up to `length` bytes, again and again."""
        raise DeviceError(ReturnCode.INVALID_ACCESS, f"0x{group:X}:0x{offset:X} cannot be read")

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        """Return up to `length` bytes now."""
        return self.reader(group, offset, length, client)()

    def watch(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        """Return the reader for a notification."""
        return self.reader(group, offset, length, client)

    def context(self, group: int, offset: int, client: bytes) -> int:
        """Return the context (task) number whose cycle a notification in context follows."""
        return 0

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        raise DeviceError(ReturnCode.INVALID_ACCESS, f"0x{group:X}:0x{offset:X} cannot be written")

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        raise DeviceError(ReturnCode.INVALID_ACCESS, f"0x{group:X}:0x{offset:X} takes no ReadWrite")


class _RowIndex(NamedTuple):
    """Rows by offset."""

    rows: tuple[Service, ...]
    by_access: Mapping[Access, Mapping[int, Service]]
    ranges: Sequence[Service]


def _index_rows(rows: Iterable[Service], kind: type[Any] | None = None) -> _RowIndex:
    """Index the rows; reject two that answer the same, and fields that `kind` does not have."""
    by_access: dict[Access, dict[int, Service]] = {READ: {}, WRITE: {}, READ_WRITE: {}}
    ranges: list[Service] = []
    in_order = tuple(sorted(rows, key=lambda row: row.offset))
    for row in in_order:
        if kind is not None:
            _check_field(row, kind)
        if row.count > 1:
            ranges.append(row)
            continue
        for access, rows_of_access in by_access.items():
            if access in row.access and rows_of_access.setdefault(row.offset, row) is not row:
                raise ValueError(
                    f"rows {rows_of_access[row.offset].name!r} and {row.name!r} both answer"
                    f" {access} at offset 0x{row.offset:X}"
                )
    return _RowIndex(in_order, by_access, ranges)


_shared_index = lru_cache(maxsize=256)(_index_rows)
"""The index of rows that many devices serve: tables of modules, which refer to no device."""


class _RowGroup(IndexGroup):
    """Service rows over a target object found by the index group.

    `permanent`: an object that was found is there as long as the group.
    """

    permanent = False

    def __init__(self, index: _RowIndex) -> None:
        self.rows, self._by_access, self._ranges = index
        self._readable = self._by_access[READ]

    def target(self, group: int) -> Any:
        """Return the object behind an index group; raises DeviceError if there is none."""
        raise NotImplementedError

    def _find(self, group: int, offset: int, access: Access) -> tuple[Service, int]:
        """Return the row for `offset`, with the number of the sub-element or the index it means."""
        rows = self._by_access[access]
        row = rows.get(offset)
        if row is not None:
            return row, 0
        base = offset & ~_ELEMENTS
        row = rows.get(base)
        if row is not None and row.element is not None:
            return row, (offset & _ELEMENTS) >> 20
        known = False
        for row in self._ranges:
            if row.offset <= offset < row.offset + row.count:
                if access in row.access:
                    return row, offset - row.offset
                known = True
        self.target(group)  # an object that is not there is the better answer
        if known or any(
            row.offset == offset or (row.offset == base and row.element is not None)
            for row in self.rows
        ):
            raise DeviceError(
                ReturnCode.INVALID_ACCESS, f"0x{group:X}:0x{offset:X} does not answer {access}"
            )
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{group:X}:0x{offset:X}")

    def _arguments(self, row: Service, group: int, number: int) -> tuple[Any, ...]:
        """Return the arguments for the functions of `row`."""
        target = self.target(group)
        if row.element is not None:
            return (row.element(target, number),)
        return (target,) if row.count == 1 else (target, number)

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        row = self._readable.get(offset)
        if row is None:
            row, number = self._find(group, offset, READ)
            data = row.encoder(length)(row.get(*self._arguments(row, group, number)))
        elif row.element is None:
            data = row.encoder(length)(row.get(self.target(group)))
        else:
            data = row.encoder(length)(row.get(row.element(self.target(group), 0)))
        return data if len(data) <= length else data[:length]

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        row, number = self._find(group, offset, READ)
        arguments = self._arguments(row, group, number)
        if row.sample is not None and (sample := row.sample(arguments[0], length)) is not None:
            return sample
        encode, get, target, element = row.encoder(length), row.get, self.target, row.element
        if self.permanent:
            argument = arguments[0]
            if row.count > 1:
                return lambda: encode(get(argument, number))[:length]
            return lambda: encode(get(argument))[:length]
        # the target is looked up for each sample: objects come and go
        if element is not None:
            return lambda: encode(get(element(target(group), number)))[:length]
        if row.count > 1:
            return lambda: encode(get(target(group), number))[:length]
        return lambda: encode(get(target(group)))[:length]

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        row, number = self._find(group, offset, WRITE)
        arguments = self._arguments(row, group, number)
        value = row.decode(data)
        if row.guard is not None:
            row.guard(arguments[0])
        row.set(*arguments, value)

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        row, number = self._find(group, offset, READ_WRITE)
        arguments = self._arguments(row, group, number)
        request = row.decode(data)
        if row.guard is not None:
            row.guard(arguments[0])
        assert row.exchange is not None
        return row.encoder(read_length)(row.exchange(*arguments, request))[:read_length]


class Group(_RowGroup):
    """Rows at one index group over one object."""

    def __init__(self, index_group: int, rows: Iterable[Service], target: Any = None) -> None:
        self.index_group = index_group
        self._target = target
        super().__init__(_index_rows(rows))
        for row in self.rows:
            if row.field:
                try:
                    row.get(target)
                except AttributeError as failure:
                    raise ValueError(f"row {row.name!r} refers to nothing: {failure}") from None

    def index_groups(self) -> Iterable[int]:
        return (self.index_group,)

    def describe(self) -> Iterator[RowFacts]:
        for row in self.rows:
            yield row.facts(self.index_group, self.index_group)

    def target(self, group: int) -> Any:
        return self._target


class ObjectGroup(_RowGroup):
    """Rows over numbered objects: index group = `base` + id, id 0 … `last_id`.

    Ids above 255 are `base` + low byte on page n = id // 256, at 0x000n_0000 (002, table ids).
    `find(id)` gives the object or raises DeviceError, such as NC 0x4012 for an unknown axis.
    `kind`: the class of the objects; with it, a row whose `field` the class does not have is
    rejected here.
    """

    def __init__(
        self,
        base: int,
        last_id: int,
        find: Callable[[int], Any],
        rows: Iterable[Service],
        *,
        kind: type[Any] | None = None,
        permanent: bool = False,
    ) -> None:
        if not 0 < last_id <= 0xFFF:
            raise ValueError(f"the last id is 1..4095, got {last_id}")
        self.base = base
        self.last_id = last_id
        self._find_object = find
        self.permanent = permanent
        super().__init__(_shared_index(tuple(rows), kind))  # type: ignore[arg-type]  # mypy: a class has no hash

    def index_groups(self) -> Iterable[int]:
        return _groups_of_objects(self.base, self.last_id)

    @property
    def has_pages(self) -> bool:
        """True if ids are on several pages, which a table does not list one by one."""
        return self.last_id > 0xFF and self.base <= 0xFF00

    def first_page(self) -> Iterable[int]:
        """Return the index groups of the ids 0 … 255."""
        return _groups_of_objects(self.base, min(self.last_id, 0xFF))

    def is_on_a_page(self, group: int) -> bool:
        """Return True if an index group is that of an id, on any page."""
        distance = group - self.base
        return not distance & 0xFF00 and distance >= 0 and self._id_at(group) <= self.last_id

    def _id_at(self, group: int) -> int:
        return group - self.base & 0xFF | group >> 16 << 8

    def describe(self) -> Iterator[RowFacts]:
        last = self.base + min(self.last_id, 0xFF)
        for row in self.rows:
            yield row.facts(self.base, last)

    def target(self, group: int) -> Any:
        return self._find_object(self._id_at(group))


@lru_cache(maxsize=256)
def _groups_of_objects(base: int, last_id: int) -> tuple[int, ...]:
    """Index groups of the ids 0 … `last_id`."""
    return tuple((id >> 8 << 16 | base) + (id & 0xFF) for id in range(last_id + 1))


class AreaGroup(IndexGroup):
    """An address range such as a memory area: offset and length go straight to functions.

    `read(offset, length)` gives at most `length` bytes (lengths up to 0xFFFF_FFFF come),
    `write(offset, data)` takes all of `data`; both raise DeviceError beyond the area. A write of
    no bytes to a place of the area changes nothing, as AdsLibTest of the vendor expects.
    `watch(offset, length)` makes the reader of a notification; without it each sample is a read.
    """

    def __init__(
        self,
        index_group: int,
        read: Callable[[int, int], bytes] | None = None,
        write: Callable[[int, bytes], None] | None = None,
        *,
        watch: Callable[[int, int], Reader] | None = None,
        name: str = "",
        description: str = "",
        source: str = "",
    ) -> None:
        if read is None and write is None:
            raise ValueError(f"area 0x{index_group:X} refers to nothing")
        self.index_group = index_group
        self.name = name
        self.description = description
        self.source = source
        self._read = read
        self._write = write
        self._watch = watch

    def index_groups(self) -> Iterable[int]:
        return (self.index_group,)

    def describe(self) -> Iterator[RowFacts]:
        access = Access(0)
        if self._read is not None:
            access |= READ
        if self._write is not None:
            access |= WRITE
        yield RowFacts(
            index_group=self.index_group,
            last_index_group=self.index_group,
            index_offset=0,
            last_index_offset=0xFFFF_FFFF,
            access=access,
            name=self.name,
            layout="BYTE[n]",
            description=self.description,
            source=self.source,
        )

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        if self._read is None:
            return super().read(group, offset, length, client)
        return self._read(offset, length)

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        read = self._read
        if read is None:
            return super().reader(group, offset, length, client)
        read(offset, length)  # refuses now what could never be read
        if self._watch is not None:
            return self._watch(offset, length)
        return lambda: read(offset, length)

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        if self._write is None:
            super().write(group, offset, data, client)
        else:
            self._write(offset, data)


class RawGroup(IndexGroup):
    """One index group whose functions see the request as it came: services that are not values.

    `read(offset, length, client)`, `write(offset, data, client)` and
    `read_write(offset, read_length, data, client)`; answers are cut to the asked length here.
    `watch(offset, length, client)` makes the reader of a notification; without it every sample
    calls `read`.
    """

    def __init__(
        self,
        index_group: int,
        name: str,
        *,
        read: Callable[[int, int, bytes], bytes] | None = None,
        write: Callable[[int, bytes, bytes], None] | None = None,
        read_write: Callable[[int, int, bytes, bytes], bytes] | None = None,
        watch: Callable[[int, int, bytes], Reader] | None = None,
        context: Callable[[int, bytes], int] | None = None,
        last_offset: int = 0,
        request: str = "",
        response: str = "",
        description: str = "",
        source: str = "",
    ) -> None:
        if not (read or write or read_write or watch):
            raise ValueError(f"service {name!r} refers to nothing")
        self.index_group = index_group
        self.name = name
        self.last_offset = last_offset
        self.request = request
        self.response = response
        self.description = description
        self.source = source
        self._read = read
        self._write = write
        self._read_write = read_write
        self._watch = watch
        self._context = context

    def index_groups(self) -> Iterable[int]:
        return (self.index_group,)

    def describe(self) -> Iterator[RowFacts]:
        access = Access(0)
        for offered, flag in (
            (self._read, READ),
            (self._write, WRITE),
            (self._read_write, READ_WRITE),
        ):
            if offered is not None:
                access |= flag
        yield RowFacts(
            index_group=self.index_group,
            last_index_group=self.index_group,
            index_offset=0,
            last_index_offset=self.last_offset,
            access=access,
            name=self.name,
            layout=self.request,
            response_layout=self.response,
            description=self.description,
            source=self.source,
        )

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        if self._read is None:
            return super().reader(group, offset, length, client)()
        data = self._read(offset, length, client)
        return data if len(data) <= length else data[:length]

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        self.read(group, offset, length, client)  # refuses now what could never be read
        return lambda: self.read(group, offset, length, client)

    def watch(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        if self._watch is None:
            return self.reader(group, offset, length, client)
        return self._watch(offset, length, client)

    def context(self, group: int, offset: int, client: bytes) -> int:
        return 0 if self._context is None else self._context(offset, client)

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        if self._write is None:
            super().write(group, offset, data, client)
        else:
            self._write(offset, data, client)

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        if self._read_write is None:
            return super().read_write(group, offset, read_length, data, client)
        return self._read_write(offset, read_length, data, client)[:read_length]


class ServiceTable:
    """All index groups of a device, found by number; iterable. It begins with those of `base`."""

    def __init__(
        self, groups: Iterable[IndexGroup] = (), base: "ServiceTable | None" = None
    ) -> None:
        added = tuple(groups)
        self.groups: Sequence[IndexGroup] = added if base is None else (*base.groups, *added)
        self.by_index: dict[int, IndexGroup] = {} if base is None else base.by_index.copy()
        """Groups by number; of those with pages only the first page: `get` knows all."""
        self._paged: list[ObjectGroup] = [] if base is None else base._paged.copy()
        for group in added:
            paged = group if isinstance(group, ObjectGroup) and group.has_pages else None
            own = dict.fromkeys(paged.first_page() if paged else group.index_groups(), group)
            count = len(self.by_index) + len(own)
            self.by_index.update(own)
            if len(self.by_index) != count:
                index = next(i for other in self.groups for i in other.index_groups() if i in own)
                raise ValueError(f"two groups serve index group 0x{index:X}")
            if paged:
                self._paged.append(paged)
        for index in self.by_index if self._paged else ():
            if index > 0xFFFF and self._page_of(index) is not None:
                raise ValueError(f"two groups serve index group 0x{index:X}")

    def __iter__(self) -> Iterator[IndexGroup]:
        return iter(self.groups)

    def describe(self) -> Iterator[RowFacts]:
        """Yield every row of every group, in order of the groups."""
        for group in self.groups:
            yield from group.describe()

    def find(self, group: int) -> IndexGroup:
        """Return the group that serves index group `group`; raises DeviceError 0x702."""
        entry = self.get(group)
        if entry is None:
            raise DeviceError(ReturnCode.INVALID_GROUP, f"0x{group:X}")
        return entry

    def get(self, group: int) -> IndexGroup | None:
        """Return the group that serves index group `group`; None if there is none."""
        return self.by_index.get(group) or self._page_of(group)

    def put(self, index: int, group: IndexGroup | None) -> None:
        """Let a group alone serve an index group from now on; None: none, or the one with pages."""
        if group is None or group is self._page_of(index):
            self.by_index.pop(index, None)
        else:
            self.by_index[index] = group

    def _page_of(self, group: int) -> ObjectGroup | None:
        return next((each for each in self._paged if each.is_on_a_page(group)), None)


def _check_field(row: Service, kind: type[Any]) -> None:
    """Reject a row whose field the class of its objects does not declare."""
    if not row.field or row.element is not None:
        return
    name = row.field.partition(".")[0]
    if not any(
        hasattr(base, name) or name in getattr(base, "__annotations__", ()) for base in kind.__mro__
    ):
        raise ValueError(f"row {row.name!r} refers to nothing: {kind.__name__} has no {name!r}")
