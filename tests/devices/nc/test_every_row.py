"""Every row of the NC, asked at random: lengths, values, in whatever state the axis is."""

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import DeviceError
from achse.codes import NcError
from achse.server import READ, READ_WRITE, WRITE, Service

OF_THE_PLC_LIBRARY = range(0x4B00, 0x4C00)

ONE_AXIS = 1


def rows(bench: Any) -> list[tuple[int, Service]]:
    """Index group for axis 1 and row, of all groups with rows."""
    found = []
    for group in bench.device.services:
        for row in getattr(group, "rows", ()):
            base = getattr(group, "base", None)
            found.append((group.index_group if base is None else base + ONE_AXIS, row))
    return found


def forms(row: Service) -> tuple[Any, ...]:
    return row.codec if isinstance(row.codec, tuple) else (row.codec,)


def request(source: random.Random, size: int | None) -> bytes:
    """Data of this size: zeros, small whole numbers, or anything."""
    size = source.randrange(0, 40) if size is None else size
    kind = source.randrange(3)
    if kind == 0:
        return bytes(size)
    if kind == 1:
        return bytes(source.randrange(4) if n % 4 == 0 else 0 for n in range(size))
    return source.randbytes(size)


STATES: dict[str, dict[str, float]] = {
    "enabled": {},
    "not_enabled": {"control_dword": 0},
    "override_0": {"velocity_override": 0},
    "two_speeds": {"axis_type": 2, "drive_type": 7, "controller_type": 7},
    "stepper": {"axis_type": 3, "drive_type": 8, "controller_type": 8},
    "encoder_axis": {"axis_type": 5},
    "absolute": {"encoder_is_absolute": 1, "encoder_reference_system": 1},
}


@pytest.mark.parametrize("state", STATES)
def test_the_nc_answers_no_code_of_the_plc_library(make_bench: Any, state: str) -> None:
    """0x4Bnn are made by PLC blocks, never by the NC (nc-choices, 0x4257)."""
    source = random.Random(f"codes {state}")
    answered: Counter[int] = Counter()
    for _ in range(3):
        bench = make_bench(**STATES[state])
        for _ in range(2):
            every = rows(bench)
            source.shuffle(every)
            for group, row in every:
                data = request(source, source.choice(forms(row)).size)
                try:
                    if WRITE in row.access:
                        bench.write(group, row.offset, data)
                    elif READ_WRITE in row.access:
                        bench.exchange(group, row.offset, 64, data)
                except DeviceError as refusal:
                    answered[refusal.code] += 1
                if source.randrange(4) == 0:
                    bench.run(0.002)
    assert len(answered) > 30
    assert [hex(code) for code in answered if code in OF_THE_PLC_LIBRARY] == []


def test_no_source_of_the_nc_names_a_code_of_the_plc_library() -> None:
    names = [error.name for error in NcError if error.number in OF_THE_PLC_LIBRARY]
    assert len(names) > 20
    package = Path(achse.__file__).parent
    for room in ("motion", "devices/nc"):
        for file in (package / room).rglob("*.py"):
            text = file.read_text(encoding="utf-8")
            assert [name for name in names if name in text] == [], file


def test_forms_told_by_length_take_these_lengths_alone(bench: Any, refused: Any) -> None:
    """What is as long as no form is 0x705, and changes nothing: latches and all others."""
    source = random.Random(705)
    checked = 0
    for group, row in rows(bench):
        sizes = {form.size for form in forms(row)}
        if READ_WRITE in row.access or WRITE not in row.access or None in sizes:
            assert len(sizes) == 1 or None not in sizes, f"{row.name}: a form of any length"
            continue
        if row.guard is not None:
            continue
        lengths = {source.randrange(0, 200) for _ in range(5)} | {s + 1 for s in sizes} - sizes
        before = bench.nc.digest()
        for length in lengths - sizes:
            with refused(0x705):
                bench.write(group, row.offset, bytes(length))
        assert bench.nc.digest() == before, row.name
        checked += 1
    assert checked > 200


@pytest.mark.parametrize(
    ("offset", "lengths"), [(0x201, {0, 16}), (0x202, {0, 16}), (0x205, {0, 16, 24})]
)
def test_latches_check_their_lengths(
    bench: Any, refused: Any, offset: int, lengths: set[int]
) -> None:
    for length in range(40):
        data = bytes([1] * (length == 24) + [0] * (length - (length == 24)))  # of touch probe 1
        if length in lengths:
            bench.write(0x5201, offset, data)
            bench.write(0x5201, 0x205)
        else:
            with refused(0x705):
                bench.write(0x5201, offset, data)


def test_a_short_read_gets_the_first_bytes_of_the_value(bench: Any) -> None:
    """As nc-choices says: of the form with that length, else of the longest one."""
    source = random.Random(9)
    bench.start(100.0, 50.0)
    bench.run(0.1)
    checked = 0
    for group, row in rows(bench):
        if READ not in row.access or group >= 0xA000:  # tables: there is none
            continue
        whole = bench.read(group, row.offset, 1 << 16)
        sizes = {form.size for form in forms(row)}
        for length in {0, 1, 3, *(source.randrange(len(whole) + 9) for _ in range(3))} - sizes:
            assert bench.read(group, row.offset, length) == whole[:length], row.name
        checked += 1
    assert checked > 500
