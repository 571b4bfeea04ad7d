"""PDO mapping: the procedure step by step, every wrong step with its abort code."""

import struct
from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, AlStatus, SdoAbort
from achse.drive import Drive
from achse.drive.mapping import MAX_BYTES, PdoMapping
from achse.drive.objects import ROWS
from achse.drive.objects.communication import CIA402_MAPPINGS
from achse.ethercat import Segment, Slave


@pytest.fixture
def preop() -> Drive:
    drive = Drive()
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    return drive


def _off(drive: Drive) -> None:
    drive.set(0x1C12, 0)
    drive.set(0x1C13, 0)


def _map(drive: Drive, index: int, entries: Iterable[int]) -> None:
    drive.set(index, 0)
    count = 0
    for count, entry in enumerate(entries, 1):
        drive.set(index, entry, count)
    drive.set(index, count)


def test_default_sizes(preop: Drive) -> None:
    sizes = {0x1600: 15, 0x1601: 11, 0x1602: 9, 0x1603: 21}
    for index, size in sizes.items():
        _off(preop)
        preop.set(0x1C12, index, 1)
        preop.set(0x1C12, 1)
        assert preop.output_size == size
    for index, size in {0x1A00: 23, 0x1A01: 19, 0x1A02: 19, 0x1A03: 23}.items():
        _off(preop)
        preop.set(0x1C13, index, 1)
        preop.set(0x1C13, 1)
        assert preop.input_size == size


def test_the_example_of_the_manual(preop: Drive) -> None:
    """607Fh is added to 1600h."""
    preop.set(0x1C12, 0)
    preop.set(0x1600, 0)
    preop.set(0x1600, 0x607F0020, 7)
    preop.set(0x1600, 7)
    preop.set(0x1C12, 0x1600, 1)
    preop.set(0x1C12, 1)
    preop.enter(AlState.SAFEOP, 0, AlStatus.NO_ERROR)
    preop.enter(AlState.OP, 0, AlStatus.NO_ERROR)
    assert preop.output_size == 19
    preop.write_outputs(struct.pack("<HbHiHII", 6, 8, 3000, 0, 0, 0, 4711))
    preop.step(1_000_000)
    assert preop.get(0x607F) == 4711


@pytest.mark.parametrize("state", [AlState.SAFEOP, AlState.OP])
def test_no_change_in_safeop_or_op(preop: Drive, aborts: Any, state: AlState) -> None:
    preop.enter(state, 0, AlStatus.NO_ERROR)
    for index, subindex, value in (
        (0x1C12, 0, 0),
        (0x1C13, 1, 0x1A01),
        (0x1600, 0, 0),
        (0x1A00, 1, 0x60410010),
    ):
        with aborts(AbortCode.READ_ONLY):
            preop.set(index, value, subindex)


def test_the_assignment_comes_off_first(preop: Drive, aborts: Any) -> None:
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        preop.set(0x1600, 0)
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        preop.set(0x1C12, 0x1601, 1)


def test_the_count_goes_to_0_before_entries_change(preop: Drive, aborts: Any) -> None:
    _off(preop)
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        preop.set(0x1600, 0x607F0020, 7)


@pytest.mark.parametrize(
    "entry",
    [
        0x50000010,  # not in the dictionary
        0x607D0020,  # stated as not supported
        0x605A0010,  # not mappable
        0x60400020,  # another length
        0x60410010,  # read-only, in a RxPDO
        0x60400110,  # no such subindex
        0x00000008,  # padding
    ],
)
def test_unsupported_objects(preop: Drive, aborts: Any, entry: int) -> None:
    _off(preop)
    preop.set(0x1600, 0)
    with aborts(AbortCode.NO_OBJECT):
        preop.set(0x1600, entry, 1)


def _map_9(drive: Drive, index: int) -> None:
    """Eight entries, and a count of nine."""
    _map(drive, index, [0x3201 + n << 16 | 0x20 for n in range(8)])
    drive.set(index, 0)
    drive.set(index, 9)


@pytest.mark.parametrize(("assignment", "index"), [(0x1C12, 0x1600), (0x1C13, 0x1A03)])
def test_too_many_objects_are_found_when_the_assignment_comes_on(
    preop: Drive, aborts: Any, assignment: int, index: int
) -> None:
    with aborts(AbortCode.VALUE_RANGE):  # assigned: no step of the procedure
        preop.set(0x1600, 9)
    _off(preop)
    _map_9(preop, index)
    preop.set(assignment, index, 1)
    with aborts(AbortCode.PDO_LENGTH):
        preop.set(assignment, 1)
    assert (preop.get(index), preop.get(assignment)) == (9, 0)
    assert (preop.output_size, preop.input_size) == (0, 0)
    preop.set(index, 8)
    preop.set(assignment, 1)
    assert MAX_BYTES in (preop.output_size, preop.input_size)


def test_an_object_twice_is_found_when_the_assignment_comes_on(preop: Drive, aborts: Any) -> None:
    _off(preop)
    preop.set(0x1600, 0)
    preop.set(0x1600, 0x60400010, 2)
    preop.set(0x1600, 2)
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        preop.set(0x1C12, 1)


def test_an_empty_entry_is_found_when_the_assignment_comes_on(preop: Drive, aborts: Any) -> None:
    _off(preop)
    preop.set(0x1600, 0)
    preop.set(0x1600, 7)
    with aborts(AbortCode.NO_OBJECT):
        preop.set(0x1C12, 1)


def test_too_many_bytes_are_found_when_the_assignment_comes_on(preop: Drive, aborts: Any) -> None:
    _off(preop)
    _map(preop, 0x1A00, [0x3201 + n << 16 | 0x20 for n in range(8)])
    preop.set(0x1C13, 1)
    assert preop.input_size == MAX_BYTES
    # eight objects of the dictionary never exceed it, padding entries do
    long = Drive(strict_mapping=False)
    long.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    _off(long)
    _map(long, 0x1A00, (0x60640020, 0x000000F0))
    with aborts(AbortCode.PDO_LENGTH):
        long.set(0x1C13, 1)
    assert (long.get(0x1C13), long.input_size) == (0, 0)


@pytest.mark.parametrize("strict", [True, False])
def test_a_stored_mapping_that_does_not_fit_is_not_assigned(strict: bool) -> None:
    remaining: dict[int, float] = {0x1600_00: 9, 0x1C12_01: 0x1600, 0x1C13_01: 0x1234}
    drive = Drive(store=remaining, strict_mapping=strict)
    drive.power_cycle()
    assert (drive.get(0x1C12), drive.output_size) == (0, 0)
    assert (drive.get(0x1C13), drive.get(0x1C13, 1), drive.input_size) == (1, 0x1A00, 23)


@pytest.mark.parametrize(
    ("index", "subindex", "value"),
    [(0x1C12, 0, 2), (0x1C12, 1, 0x1604), (0x1C13, 1, 0x1600)],
)
def test_ranges(preop: Drive, aborts: Any, index: int, subindex: int, value: int) -> None:
    _off(preop)
    with aborts(AbortCode.VALUE_RANGE):
        preop.set(index, value, subindex)


def test_nothing_assigned_is_nothing_sent(preop: Drive) -> None:
    _off(preop)
    assert (preop.output_size, preop.input_size, preop.read_inputs()) == (0, 0, b"")


def test_a_permissive_mapping_takes_what_masters_send() -> None:
    """Count, entries with padding and count while the assignment is on."""
    drive = Drive(strict_mapping=False)
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    _map(drive, 0x1600, (0x60400010, 0x60600008, 0x00000008, 0x607A0020))
    drive.set(0x1C12, 0)
    drive.set(0x1C12, 0x1600, 1)
    drive.set(0x1C12, 1)
    assert drive.output_size == 8
    drive.enter(AlState.SAFEOP, 0, AlStatus.NO_ERROR)
    drive.enter(AlState.OP, 0, AlStatus.NO_ERROR)
    drive.write_outputs(struct.pack("<Hbxi", 6, 8, -77))
    drive.step(1_000_000)
    assert (drive.get(0x6060), drive.get(0x607A)) == (8, -77)


def test_a_stored_mapping_is_back_after_a_power_cycle() -> None:
    drive = Drive()
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    _off(drive)
    _map(drive, 0x1A01, (0x60410010,))
    drive.set(0x1C13, 0x1A01, 1)
    drive.set(0x1C13, 1)
    drive.set(0x1C12, 1)
    drive.save()
    drive.step(1_000_000_000)
    drive.power_cycle()
    assert (drive.get(0x1C13, 1), drive.get(0x1A01), drive.input_size) == (0x1A01, 1, 2)
    assert drive.read_inputs() == drive.record.statusword.to_bytes(2, "little")


def test_a_stored_mapping_is_there_in_the_next_run_of_the_program() -> None:
    remaining: dict[int, float] = {
        0x1A01_00: 1,
        0x1A01_01: 0x60410010,
        0x1C13_00: 1,
        0x1C13_01: 0x1A01,
    }
    drive = Drive(store=remaining)
    assert (drive.get(0x1C13, 1), drive.get(0x1A01), drive.input_size) == (0x1A01, 1, 2)
    assert drive.read_inputs() == drive.record.statusword.to_bytes(2, "little")


def test_stored_entries_that_no_mapping_has_are_left_out() -> None:
    drive = Drive(store={0x1600_09: 0x60400010, 0x1600_FF: 1})
    assert (drive.get(0x1C12), drive.output_size) == (1, 15)


MAPPABLE = {index: [row for row in ROWS if row.pdo] for index in (0x1A00,)} | {
    0x1600: [row for row in ROWS if row.receivable]
}


@given(st.sampled_from([0x1600, 0x1A00]), st.data())
def test_any_legal_mapping_carries_its_values(index: int, data: st.DataObject) -> None:
    rows = data.draw(st.lists(st.sampled_from(MAPPABLE[index]), max_size=8, unique=True))
    drive = Drive()
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    _off(drive)
    _map(drive, index, (row.key << 8 | row.type.bits for row in rows))
    assignment = 0x1C12 if index == 0x1600 else 0x1C13
    drive.set(assignment, index, 1)
    drive.set(assignment, 1)
    size = sum(row.type.bits for row in rows) // 8
    if index == 0x1A00:
        assert drive.input_size == size
        assert drive.read_inputs() == b"".join(
            drive.read_object(row.index, row.subindex) for row in rows
        )
        return
    assert drive.output_size == size
    drive.enter(AlState.SAFEOP, 0, AlStatus.NO_ERROR)
    drive.enter(AlState.OP, 0, AlStatus.NO_ERROR)
    values = [1 if row.type.least < 1 else row.type.least for row in rows]
    drive.write_outputs(
        b"".join(row.type.pack(value) for row, value in zip(rows, values, strict=True))
    )
    drive.step(0)
    assert [getattr(drive.record, row.place) for row in rows] == values


def test_an_unmappable_row_is_refused_for_every_row() -> None:
    for index, mappable in MAPPABLE.items():
        mapping = PdoMapping()
        mapping.open = True
        mapping.write(0x1C12, 0, 0)
        mapping.write(0x1C13, 0, 0)
        mapping.write(index, 0, 0)
        for row in ROWS:
            entry = row.key << 8 | row.type.bits
            if row in mappable:
                mapping.write(index, 1, entry)
                assert mapping.read(index, 1) == entry
            else:
                with pytest.raises(SdoAbort) as refusal:
                    mapping.write(index, 1, entry)
                assert refusal.value.code is AbortCode.NO_OBJECT


@pytest.mark.parametrize(
    ("steps", "reason"),
    [
        ([(0x1600, 0, 0)], "step 1 is missing: write 0 to 1C12:00 first"),
        ([(0x1A00, 1, 0x60410010)], "step 1 is missing: write 0 to 1C13:00 first"),
        ([(0x1C12, 1, 0x1601)], "step 1 is missing"),
        ([(0x1C12, 0, 0), (0x1600, 1, 0x60400010)], "step 2 is missing: write 0 to 1600:00"),
        ([(0x1C12, 0, 0), (0x1600, 0, 0), (0x1600, 1, 0x12340010)], "1234:00 is not an object"),
        ([(0x1C12, 0, 0), (0x1600, 0, 0), (0x1600, 1, 0x607A0010)], "has 32 bits, got 16"),
        ([(0x1C12, 0, 0), (0x1600, 0, 0), (0x1600, 1, 0x60410010)], "cannot be received"),
        ([(0x1C12, 0, 0), (0x1600, 0, 9), (0x1C12, 0, 1)], "step 6: 1600 has 9 entries"),
        (
            [
                *[(0x1C12, 0, 0), (0x1600, 0, 0), (0x1600, 1, 0x60400010)],
                *[(0x1600, 2, 0x60400010), (0x1600, 0, 2), (0x1C12, 0, 1)],
            ],
            "step 6: 1600 maps an object twice",
        ),
    ],
)
def test_a_refusal_says_which_step_failed(
    preop: Drive, steps: list[tuple[int, int, int]], reason: str
) -> None:
    *before, last = steps
    for index, subindex, value in before:
        preop.mapping.write(index, subindex, value)
    with pytest.raises(SdoAbort) as refusal:
        preop.mapping.write(*last)
    assert reason in refusal.value.reason
    assert reason in str(refusal.value)


def test_outside_preop_that_is_the_reason() -> None:
    with pytest.raises(SdoAbort, match="in PreOp only"):
        Drive().mapping.write(0x1C12, 0, 0)


def test_another_mapping_is_there_from_power_on_to_power_on() -> None:
    drive = Drive(mapping=CIA402_MAPPINGS, voltage_bit=1)
    for _ in range(2):
        assert (drive.output_size, drive.input_size) == (13, 19)
        assert drive.get(0x1600, 2) == 0x607A0020
        assert drive.get(0x1A00) == 7
        drive.power_cycle()
    Segment([Slave(drive)]).advance(10_000_000)
    assert int(drive.get(0x6041)) & 1 << 4  # voltage enabled
