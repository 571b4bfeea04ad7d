"""Process data inside the kernel: the same bytes as outside it."""

from typing import Any, cast

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState, AlStatus, DataType
from achse.drive import VirtualDrive
from achse.drive.compiled import Bank, CompiledRecord
from achse.drive.exchange import exchange, pack_inputs, unpack_outputs
from achse.drive.mapping import ProcessData
from achse.drive.objects import ROWS
from achse.drive.record import FIELDS, LAYOUT, DriveFields, DriveSlots

WHOLE = [row for row in ROWS if row.pdo and row.type is not DataType.F32]
RECEIVABLE = [row for row in WHOLE if row.receivable]


class WordsRecord:
    """A record over a plain list of words, as the compiled one is over an array."""

    words: list[int]
    outputs: list[int]
    inputs: list[int]
    fresh_outputs: int

    def __init__(self) -> None:
        object.__setattr__(self, "words", [0] * LAYOUT.words)

    def __getattr__(self, name: str) -> Any:
        at, size = FIELDS[name].offset, FIELDS[name].length
        return self.words[at : at + size] if size else self.words[at]

    def __setattr__(self, name: str, value: Any) -> None:
        at = FIELDS[name].offset
        if isinstance(value, list):
            self.words[at : at + len(value)] = value
        else:
            self.words[at] = value


def _map(record: WordsRecord, kind: str, data: ProcessData) -> None:
    places = data.places if kind == "received" else data.fields
    signed = -1 if kind == "received" else 1
    sizes = [row.type.bits // 8 * (signed if row.type.least < 0 else 1) for row in data.rows]
    rest = [0] * (8 - len(sizes))
    setattr(record, f"{kind}_count", len(sizes))
    setattr(record, f"{kind}_word", [FIELDS[place].offset for place in places] + rest)
    setattr(record, f"{kind}_at", [*data.offsets, *rest])
    setattr(record, f"{kind}_size", sizes + rest)


def _signed_words(data: bytes) -> list[int]:
    padded = data.ljust(32, b"\0")
    return [int.from_bytes(padded[n : n + 8], "little", signed=True) for n in range(0, 32, 8)]


@given(st.lists(st.sampled_from(RECEIVABLE), max_size=8, unique=True), st.binary(min_size=32))
def test_outputs_are_unpacked_as_struct_does(rows: list[Any], noise: bytes) -> None:
    data = ProcessData(tuple(rows))
    record = WordsRecord()
    _map(record, "received", data)
    record.outputs = _signed_words(noise[: data.size])
    unpack_outputs(cast(DriveFields, record), record.words, 0)
    expected = data.layout.unpack(noise[: data.size])
    assert tuple(record.words[FIELDS[place].offset] for place in data.places) == expected
    assert record.fresh_outputs == 1


@given(st.lists(st.sampled_from(WHOLE), max_size=8, unique=True), st.data())
def test_inputs_are_packed_as_struct_does(rows: list[Any], draw: st.DataObject) -> None:
    data = ProcessData(tuple(rows))
    record = WordsRecord()
    _map(record, "sent", data)
    values = [draw.draw(st.integers(int(row.type.least), int(row.type.most))) for row in rows]
    for row, value in zip(rows, values, strict=True):
        record.words[FIELDS[row.field].offset] = value
    pack_inputs(cast(DriveFields, record), record.words, 0)
    assert record.inputs == _signed_words(data.layout.pack(*values))


def test_cycles_run_between_outputs_and_inputs() -> None:
    record = VirtualDrive().record
    assert isinstance(record, DriveSlots)
    words = [0] * LAYOUT.words
    record.service_request = 1
    assert exchange([record], words) == 0
    record.postponed, record.postponed_cycles, record.postponed_time = 1, 3, 1e-3
    assert exchange([record], words) == 1
    assert record.step_time == 1e-3
    assert exchange([record], words) == 0


@settings(max_examples=10, deadline=None)
@given(
    st.lists(st.sampled_from([row for row in ROWS if row.receivable]), max_size=8, unique=True),
    st.lists(st.sampled_from([row for row in ROWS if row.pdo]), max_size=8, unique=True),
    st.data(),
)
def test_both_kernels_exchange_the_same_bytes(
    received: list[Any], sent: list[Any], draw: st.DataObject
) -> None:
    """Whatever is mapped, floating-point objects included."""
    values = [
        row.type.least if row.type is DataType.F32 else draw.draw(st.integers(0, 1))
        for row in received
    ]
    outputs = b"".join(row.type.pack(v) for row, v in zip(received, values, strict=True))
    answers = []
    for compiled in (False, True):
        drive = VirtualDrive(compiled=compiled)
        drive.bring_up(AlState.PREOP)
        for index, assignment, rows in ((0x1600, 0x1C12, received), (0x1A00, 0x1C13, sent)):
            drive.set(assignment, 0)
            drive.set(index, 0)
            for n, row in enumerate(rows, 1):
                drive.set(index, row.key << 8 | row.type.bits, n)
            drive.set(index, len(rows))
            drive.set(assignment, 1)
        drive.enter(AlState.SAFEOP, 0, AlStatus.NO_ERROR)
        drive.enter(AlState.OP, 0, AlStatus.NO_ERROR)
        seen = []
        for _ in range(4):
            drive.write_outputs(outputs)
            drive.step(1_000_000)
            seen.append(drive.read_inputs())
        answers.append(seen)
    assert answers[0] == answers[1]


def test_floating_point_objects_go_around() -> None:
    record = CompiledRecord(Bank(1), lambda: None)
    real = next(row for row in ROWS if row.type is DataType.F32)
    record.map(ProcessData(()), ProcessData((real,)))
    assert not record.mapped
    record.map(ProcessData(()), ProcessData(()))
    assert record.mapped
