"""Groups find the row and object of a request, or say what is wrong with it."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.server import (
    BYTES,
    READ,
    READ_WRITE,
    VOID,
    WRITE,
    AreaGroup,
    Group,
    IndexGroup,
    Layout,
    ObjectGroup,
    RawGroup,
    Service,
    ServiceTable,
)

ME = b"client"


class Axis:
    set_position: float
    encoders: "list[Axis]"

    def __init__(self, position: float = 0.0) -> None:
        self.set_position = position
        self.encoders = []
        self.calls: list[Any] = []


def refused(call: Callable[[], Any]) -> int:
    with pytest.raises(DeviceError) as failure:
        call()
    return failure.value.code


@pytest.fixture
def axis() -> Axis:
    return Axis(1.25)


@pytest.fixture
def group(axis: Axis) -> Group:
    return Group(
        0x4100,
        (
            Service(0xA, "position", READ, Layout("<d"), field="set_position"),
            Service(
                0x1,
                "call",
                WRITE,
                Layout("<I"),
                write=lambda target, value: target.calls.append(value),
            ),
            Service(
                0x18,
                "stop",
                READ_WRITE,
                Layout("<d"),
                response=Layout("<dd"),
                exchange=lambda target, value: (value, target.set_position),
            ),
            Service(0x100, "id", READ, Layout("<I"), read=lambda target, i: i * 10, count=16),
            Service(0x200, "pair", READ, Layout("<I"), read=lambda target, i: i, count=2),
        ),
        axis,
    )


def test_a_read_gives_the_value_of_the_target(group: Group) -> None:
    assert group.read(0x4100, 0xA, 8, ME) == struct.pack("<d", 1.25)


def test_reads_are_cut_and_never_longer_than_the_value(group: Group) -> None:
    assert group.read(0x4100, 0xA, 3, ME) == struct.pack("<d", 1.25)[:3]
    assert group.read(0x4100, 0xA, 0, ME) == b""
    assert len(group.read(0x4100, 0xA, 0xFFFF_FFFF, ME)) == 8


def test_a_write_reaches_the_function(group: Group, axis: Axis) -> None:
    group.write(0x4100, 0x1, b"\7\0\0\0", ME)
    assert axis.calls == [7]


def test_an_exchange_answers_from_the_request(group: Group) -> None:
    request = struct.pack("<d", 2.0)
    assert group.read_write(0x4100, 0x18, 16, request, ME) == struct.pack("<dd", 2.0, 1.25)
    assert group.read_write(0x4100, 0x18, 8, request, ME) == request


def test_a_range_of_offsets_passes_the_index(group: Group) -> None:
    assert group.read(0x4100, 0x100, 4, ME) == struct.pack("<I", 0)
    assert group.read(0x4100, 0x10F, 4, ME) == struct.pack("<I", 150)
    assert group.reader(0x4100, 0x103, 4, ME)() == struct.pack("<I", 30)
    assert group.reader(0x4100, 0x201, 4, ME)() == struct.pack("<I", 1)
    assert group.read(0x4100, 0x201, 4, ME) == struct.pack("<I", 1)
    assert refused(lambda: group.read(0x4100, 0x110, 4, ME)) == 0x703
    assert refused(lambda: group.write(0x4100, 0x103, b"", ME)) == 0x704


@pytest.mark.parametrize(("offset", "code"), [(0xA, 0x704), (0x18, 0x704), (0xB, 0x703)])
def test_a_write_where_none_is(group: Group, offset: int, code: int) -> None:
    assert refused(lambda: group.write(0x4100, offset, bytes(8), ME)) == code


@pytest.mark.parametrize(("offset", "code"), [(0x1, 0x704), (0x18, 0x704), (0xB, 0x703)])
def test_a_read_where_none_is(group: Group, offset: int, code: int) -> None:
    assert refused(lambda: group.read(0x4100, offset, 8, ME)) == code
    assert refused(lambda: group.reader(0x4100, offset, 8, ME)) == code


@pytest.mark.parametrize(("offset", "code"), [(0x1, 0x704), (0xA, 0x704), (0xB, 0x703)])
def test_an_exchange_where_none_is(group: Group, offset: int, code: int) -> None:
    assert refused(lambda: group.read_write(0x4100, offset, 8, bytes(8), ME)) == code


def test_a_reader_follows_the_value(group: Group, axis: Axis) -> None:
    read = group.reader(0x4100, 0xA, 8, ME)
    axis.set_position = 7.0
    assert read() == struct.pack("<d", 7.0)


def test_a_row_may_know_a_quicker_way_to_take_samples(axis: Axis) -> None:
    reads = []

    def sample(target: Axis, length: int) -> Callable[[], bytes] | None:
        reads.append((target, length))
        return None if length == 4 else lambda: b"quick"

    row = Service(0xA, "set_position", READ, Layout("<d"), field="set_position", sample=sample)
    group = Group(0x4100, [row], axis)
    assert group.reader(0x4100, 0xA, 8, ME)() == b"quick"
    assert group.reader(0x4100, 0xA, 4, ME)() == struct.pack("<d", 1.25)[:4]
    assert reads == [(axis, 8), (axis, 4)]


def test_rows_share_an_offset_if_their_access_differs() -> None:
    rows = (
        Service(1, "mode", READ, Layout("<B"), read=lambda target: 1),
        Service(1, "go online", WRITE, VOID, write=lambda target, value: None),
    )
    group = Group(0x1000, rows)
    assert group.read(0x1000, 1, 1, ME) == b"\1"
    group.write(0x1000, 1, b"", ME)
    with pytest.raises(ValueError, match="both answer R at offset 0x1"):
        Group(0x1000, (*rows, rows[0], Service(1, "x", READ, BYTES, read=lambda target: b"")))


def test_a_field_that_the_target_lacks_is_rejected(axis: Axis) -> None:
    row = Service(1, "jerk", READ, Layout("<d"), field="set_jerk")
    with pytest.raises(ValueError, match="'jerk' refers to nothing"):
        Group(0x4100, (row,), axis)
    with pytest.raises(ValueError, match="Axis has no 'set_jerk'"):
        ObjectGroup(0x4100, 255, lambda id: axis, (row,), kind=Axis)


@pytest.mark.parametrize(
    ("last_id", "last"), [(1, 0x4101), (255, 0x41FF), (256, 0x1_4100), (0xFFF, 0xF_41FF)]
)
def test_ids_have_an_index_group_each(last_id: int, last: int) -> None:
    ids = list[int]()
    group = ObjectGroup(0x4100, last_id, ids.append, ())
    numbers = list(group.index_groups())
    assert (numbers[0], numbers[-1]) == (0x4100, last)
    for number in numbers:
        group.target(number)
    assert ids == list(range(last_id + 1))
    table = ServiceTable((group,))
    assert [table.get(number) for number in numbers] == [group] * len(numbers)
    after = (last_id + 1 >> 8 << 16 | 0x4100) + (last_id + 1 & 0xFF)
    for number in (0x40FF, 0x4200, after, 0x1_4200, 0x1_40FF, 0x10_4100, 0):
        assert table.get(number) is None
        with pytest.raises(DeviceError):
            table.find(number)


def test_index_group_on_a_page_is_replaced_and_restored() -> None:
    pages = ObjectGroup(0x4100, 0x3FF, str, ())
    other = RawGroup(0x2_4110, "other", write=lambda *_: None)
    table = ServiceTable((pages,))
    before = table.by_index.copy()
    table.put(0x2_4110, other)
    assert table.find(0x2_4110) is other
    assert table.find(0x2_4111) is pages
    table.put(0x2_4110, pages)
    assert table.find(0x2_4110) is pages
    assert table.by_index == before


def test_index_groups_of_further_pages_are_not_listed() -> None:
    table = ServiceTable([ObjectGroup(0x4100, 0xFFF, str, ())])
    assert len(table.by_index) == 0x100
    assert table.get(0x1_4100) is table.get(0x4100)


def test_pages_of_a_group_of_objects_belong_to_it_alone() -> None:
    pages = ObjectGroup(0x4100, 0x3FF, str, ())
    other = RawGroup(0x2_4110, "other", write=lambda *_: None)
    for groups in ((pages, other), (other, pages)):
        with pytest.raises(ValueError, match="two groups serve index group 0x24110"):
            ServiceTable(groups)
    with pytest.raises(ValueError, match="two groups serve index group 0x24110"):
        ServiceTable((other,), ServiceTable((pages,)))


def test_base_of_a_group_of_objects_may_be_any_index_group() -> None:
    ids = list[int]()
    group = ObjectGroup(0x4010, 0x102, ids.append, ())
    for number in (0x4010, 0x4012, 0x1_4011):
        assert number in group.index_groups()
        group.target(number)
    assert ids == [0, 2, 0x101]


class Declared:
    """Fields that a class declares: by annotation, in a base, as a property."""

    position: float

    @property
    def state(self) -> int:
        return 1


class Inherited(Declared):
    encoder: Axis


@pytest.mark.parametrize(
    ("field", "has_element", "is_served"),
    [
        ("position", False, True),
        ("state", False, True),
        ("encoder.set_position", False, True),
        ("", False, True),
        ("missing", False, False),
        ("set_position", False, False),
        ("set_position", True, True),
    ],
)
def test_field_of_a_row_is_declared_by_the_class_of_its_objects(
    field: str, has_element: bool, is_served: bool
) -> None:
    functions: dict[str, Any] = {} if field else {"read": lambda target: 0.0}
    if has_element:
        functions["element"] = lambda target, n: target.encoder
    row = Service(1, "row", READ, Layout("<d"), field=field, **functions)
    if is_served:
        ObjectGroup(0x4100, 255, Axis, (row,), kind=Inherited)
    else:
        with pytest.raises(ValueError, match="'row' refers to nothing: Inherited has no"):
            ObjectGroup(0x4100, 255, Axis, (row,), kind=Inherited)


def test_a_table_goes_on_from_another_one() -> None:
    first, second = (ObjectGroup(base, 2, Axis, ()) for base in (0x4100, 0x4200))
    single = ServiceTable((first,))
    both = ServiceTable((second,), single)
    assert list(both) == [first, second]
    assert (both.find(0x4102), both.find(0x4202)) == (first, second)
    assert set(single.by_index) == {0x4100, 0x4101, 0x4102}
    with pytest.raises(ValueError, match="two groups serve index group 0x4102"):
        ServiceTable((Group(0x4102, ()),), single)


def test_a_guard_stands_before_writes_and_exchanges() -> None:
    def enabled(target: Any) -> None:
        raise DeviceError(0x4B42)

    group = Group(
        0x4000,
        (
            Service(1, "x", WRITE, VOID, write=lambda target, value: None, guard=enabled),
            Service(2, "y", READ_WRITE, VOID, exchange=lambda target, value: None, guard=enabled),
        ),
    )
    assert refused(lambda: group.write(0x4000, 1, b"", ME)) == 0x4B42
    assert refused(lambda: group.read_write(0x4000, 2, 0, b"", ME)) == 0x4B42


# objects ---------------------------------------------------------------------------------------


@pytest.fixture
def axes() -> dict[int, Axis]:
    axes = {1: Axis(1.0), 255: Axis(255.0), 0x301: Axis(769.0)}
    axes[1].encoders = [Axis(10.0), Axis(11.0)]
    return axes


@pytest.fixture
def objects(axes: dict[int, Axis]) -> ObjectGroup:
    def find(id: int) -> Axis:
        if id not in axes:
            raise DeviceError(0x4012)
        return axes[id]

    def encoder(axis: Axis, n: int) -> Axis:
        if n >= len(axis.encoders):
            raise DeviceError(0x4014)
        return axis.encoders[n]

    return ObjectGroup(
        0x4100,
        0xFFF,
        find,
        (
            Service(0xA, "position", READ | WRITE, Layout("<d"), field="set_position"),
            Service(
                0x1_000A,
                "encoder_position",
                READ | WRITE,
                Layout("<d"),
                field="set_position",
                element=encoder,
            ),
        ),
        kind=Axis,
    )


@pytest.mark.parametrize(("index_group", "position"), [(0x4101, 1), (0x41FF, 255), (0x34101, 769)])
def test_the_index_group_names_the_object(
    objects: ObjectGroup, index_group: int, position: float
) -> None:
    table = ServiceTable((objects,))
    row = table.find(index_group)
    assert row.read(index_group, 0xA, 8, ME) == struct.pack("<d", position)


@pytest.mark.parametrize("last", [0, 0x1000])
def test_group_of_objects_has_one_to_4095(last: int) -> None:
    with pytest.raises(ValueError, match=r"the last id is 1\.\.4095"):
        ObjectGroup(0x4100, last, lambda id: None, ())
    assert list(ObjectGroup(0x4100, 1, lambda id: None, ()).index_groups()) == [0x4100, 0x4101]


@pytest.mark.parametrize("offset", [0xA, 0xB])
def test_an_unknown_object_has_the_code_of_its_kind(objects: ObjectGroup, offset: int) -> None:
    for index_group in (0x4100, 0x4102, 0x14101):
        assert index_group in objects.index_groups()
        with pytest.raises(DeviceError) as failure:
            objects.read(index_group, offset, 8, ME)
        assert failure.value.code == 0x4012


def test_the_sub_element_stands_in_the_offset(objects: ObjectGroup, axes: dict[int, Axis]) -> None:
    assert objects.read(0x4101, 0x01_000A, 8, ME) == struct.pack("<d", 10.0)
    assert objects.read(0x4101, 0x11_000A, 8, ME) == struct.pack("<d", 11.0)
    assert objects.reader(0x4101, 0x01_000A, 8, ME)() == struct.pack("<d", 10.0)
    assert objects.reader(0x4101, 0x11_000A, 8, ME)() == struct.pack("<d", 11.0)
    objects.write(0x4101, 0x11_000A, struct.pack("<d", 12.0), ME)
    assert axes[1].encoders[1].set_position == 12.0
    assert refused(lambda: objects.read(0x4101, 0x21_000A, 8, ME)) == 0x4014
    assert refused(lambda: objects.reader(0x4101, 0x21_000A, 8, ME)) == 0x4014
    assert refused(lambda: objects.read(0x4101, 0x10_000A, 8, ME)) == 0x703
    assert refused(lambda: objects.read_write(0x4101, 0x11_000A, 8, b"", ME)) == 0x704


def test_a_reader_notices_that_its_object_is_gone(
    objects: ObjectGroup, axes: dict[int, Axis]
) -> None:
    read = objects.reader(0x4101, 0xA, 8, ME)
    del axes[1]
    assert refused(read) == 0x4012


# areas and raw services ------------------------------------------------------------------------


def test_an_area_passes_offset_and_length() -> None:
    memory = bytearray(b"0123456789")

    def write(offset: int, data: bytes) -> None:
        memory[offset : offset + len(data)] = data

    area = AreaGroup(0x4020, lambda offset, length: bytes(memory[offset : offset + length]), write)
    assert area.read(0x4020, 3, 4, ME) == b"3456"
    area.write(0x4020, 0, b"ab", ME)
    assert area.reader(0x4020, 0, 3, ME)() == b"ab2"
    assert refused(lambda: area.read_write(0x4020, 0, 1, b"", ME)) == 0x704


def test_an_area_without_a_direction_refuses_it() -> None:
    read_only = AreaGroup(0xF020, lambda offset, length: b"")
    assert refused(lambda: read_only.write(0xF020, 0, b"", ME)) == 0x704
    write_only = AreaGroup(0xF040, None, lambda offset, data: None)
    assert refused(lambda: write_only.read(0xF040, 0, 1, ME)) == 0x704
    assert refused(lambda: write_only.reader(0xF040, 0, 1, ME)) == 0x704
    with pytest.raises(ValueError, match="refers to nothing"):
        AreaGroup(0xF020)


def test_raw_services_see_the_request_and_the_client() -> None:
    seen: list[Any] = []

    def exchange(offset: int, length: int, data: bytes, client: bytes) -> bytes:
        seen.append((offset, length, data, client))
        return b"abcdef"

    raw = RawGroup(133, "find", read_write=exchange, last_offset=9)
    assert raw.read_write(133, 9, 4, b"*", ME) == b"abcd"
    assert seen == [(9, 4, b"*", ME)]
    assert refused(lambda: raw.read(133, 0, 4, ME)) == 0x704
    assert refused(lambda: raw.watch(133, 0, 4, ME)) == 0x704
    assert refused(lambda: raw.write(133, 0, b"", ME)) == 0x704
    with pytest.raises(ValueError, match="'nothing' refers to nothing"):
        RawGroup(1, "nothing")
    single = RawGroup(133, "read", read=lambda offset, length, client: b"abc")
    assert refused(lambda: single.read_write(133, 0, 4, b"", ME)) == 0x704
    assert single.context(133, 5, ME) == 0
    tasks = RawGroup(
        *(133, "watch"),
        watch=lambda offset, length, client: lambda: b"",
        context=lambda offset, client: offset + len(client),
    )
    assert tasks.context(133, 5, ME) == 11


# the table -------------------------------------------------------------------------------------


def test_the_table_finds_groups_and_names_none_twice(group: Group, objects: ObjectGroup) -> None:
    assert ServiceTable((group,)).find(0x4100) is group
    assert refused(lambda: ServiceTable((group,)).find(0x4101)) == 0x702
    with pytest.raises(ValueError, match="two groups serve index group 0x4100"):
        ServiceTable((group, objects))


def test_the_table_lists_every_row(group: Group) -> None:
    table = ServiceTable((group, AreaGroup(0x4020, lambda offset, length: b"", name="memory")))
    names = [facts.name for facts in table.describe()]
    assert names == ["call", "position", "stop", "id", "pair", "memory"]
    by_name = {facts.name: facts for facts in table.describe()}
    assert str(by_name["stop"].access) == "R&W"
    assert by_name["stop"].response_layout == "{REAL64; REAL64}"
    assert by_name["id"].last_index_offset == 0x10F
    assert by_name["memory"].index_offset == 0
    assert by_name["memory"].access == READ
    [facts] = AreaGroup(0x4021, None, lambda offset, data: None).describe()
    assert facts.access == WRITE
    assert by_name["memory"].last_index_offset == 0xFFFF_FFFF
    assert [each.index_groups() for each in table] == [(0x4100,), (0x4020,)]


def test_a_bare_group_refuses_everything() -> None:
    group = IndexGroup()
    assert group.context(1, 2, ME) == 0
    assert refused(lambda: group.read(1, 2, 3, ME)) == 0x704
    assert refused(lambda: group.write(1, 2, b"", ME)) == 0x704
    assert refused(lambda: group.read_write(1, 2, 3, b"", ME)) == 0x704
