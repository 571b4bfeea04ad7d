"""Every row of the NC, asked at random: lengths, values, in whatever state the axis is."""

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.unserved import OF_CHANNELS_AND_GROUPS
from achse.devices.nc import channels, groups
from achse.server import READ, READ_WRITE, WRITE, Service

OF_THE_PLC_LIBRARY = range(0x4B00, 0x4C00)

ONE_AXIS = 1

OF_ONE_KIND = {row.name for row in (*groups.OF_ONE_KIND, *channels.OF_INTERPRETERS)}
"""Rows of groups and channels that others answer with 0x703."""


def rows(bench: Any) -> list[tuple[int, Service]]:
    """Index group for axis 1 and row, of all groups with rows."""
    results = []
    for group in bench.device.services:
        for row in getattr(group, "rows", ()):
            base = getattr(group, "base", None)
            results.append((group.index_group if base is None else base + ONE_AXIS, row))
    return results


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
def test_the_nc_answers_no_code_of_the_plc_library(
    make_bench: Any, state: str, many: Callable[[int], int]
) -> None:
    """0x4Bnn are made by PLC blocks, never by the NC (nc-choices, 0x4257)."""
    source = random.Random(f"codes {state}")
    answered: Counter[int] = Counter()
    for _ in range(many(2)):
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


def test_forms_distinguished_by_length_take_these_lengths_alone(bench: Any, refused: Any) -> None:
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


def test_a_write_without_data_is_a_wrong_length(bench: Any, groups: Any) -> None:
    """Every row of axes, groups, channels and their parts that takes a value."""
    codes: Counter[int] = Counter()
    for at in (bench, groups):
        for group in at.device.services:
            for index in list(group.index_groups())[:16]:
                for row in getattr(group, "rows", ()):
                    if WRITE in row.access and _needs_data(row):
                        with pytest.raises(DeviceError) as refusal:
                            at.write(index, row.offset, b"")
                        codes[refusal.value.code] += 1
    assert codes[ReturnCode.INVALID_SIZE.number] > 1000
    assert set(codes) == {ReturnCode.INVALID_SIZE.number, *ABSENT}


ABSENT = range(0x4010, 0x4016)
"""Codes of an object that is not there."""


def _needs_data(row: Service) -> bool:
    """True unless the row is a function without data, or a text, which may be empty."""
    return not any(form.size == 0 or form.name in ("VOID", "STRING[n]") for form in forms(row))


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
        if 0x2000 <= group < 0x4000 and row.name in OF_ONE_KIND:
            continue
        whole = bench.read(group, row.offset, 1 << 16)
        sizes = {form.size for form in forms(row)}
        for length in {0, 1, 3, *(source.randrange(len(whole) + 9) for _ in range(3))} - sizes:
            assert bench.read(group, row.offset, length) == whole[:length], row.name
        checked += 1
    assert checked > 500


OBJECTS = {0x2000: (1, 2, 3, 4), 0x3000: (1, 11, 12, 13)}
"""A channel and a group of each kind."""


def test_every_row_of_channels_and_groups_answers_each_object(groups: Any) -> None:
    """Access and length: a value or the code of a table, never an internal error."""
    source = random.Random("channels and groups")
    seen: Counter[str] = Counter()
    for group in groups.device.services:
        base = getattr(group, "base", 0)
        if not 0x2000 <= base < 0x4000:
            continue
        for row in group.rows:
            for id in OBJECTS[base & 0xF000]:
                sizes = {form.size for form in forms(row)}
                for length in (*(size or 16 for size in sizes), 0, 3, 200):
                    data = request(source, length)
                    for ask in (
                        lambda g, o, d: groups.read(g, o, len(d)),
                        groups.write,
                        lambda g, o, d: groups.exchange(g, o, 64, d),
                    ):
                        try:
                            answer = ask(base + id, row.offset, data)
                            assert answer is None or len(answer) <= max(length, 64)
                            seen["answered"] += 1
                        except DeviceError as refusal:
                            seen[hex(refusal.code)] += 1
                if source.randrange(8) == 0:
                    groups.run(0.004)
    assert seen["answered"] > 500
    assert hex(ReturnCode.INTERNAL_ERROR.number) not in seen
    assert {"0x703", "0x704", "0x705"} <= seen.keys()


SERVICES = Path(__file__).parents[2] / "data" / "nc_services.tsv"
OWNERS = {0x2: (1, 2, 3, 4), 0x3: (11, 12, 13, 1)}
"""Ids of channels (with an interpreter, FIFO, kinematics, standard) and groups (3D, FIFO,
kinematic, PTP)."""


def listed(*objects: str) -> list[tuple[int, int, str, str]]:
    """Services of the manual: index group, offset of the first element, access, name."""
    results = []
    for line in SERVICES.read_text(encoding="utf-8").splitlines()[1:]:
        kind, _, group, offset, access, name = line.split("\t")
        if kind in objects:
            results.append((int(group, 16), int(offset.replace("n", "0"), 16), access, name))
    return results


def test_every_service_of_channels_and_groups_is_walked(programs: Any, make_bench: Any) -> None:
    """What is served answers for one kind of channel or group at least: reads give their bytes,
    what is read may be written again, functions answer 0 or an error of the NC. What is reserved
    or internal is 0x703 for all of them."""
    unserved = {each[:3] for services in OF_CHANNELS_AND_GROUPS.values() for each in services}
    walked: Counter[str] = Counter()
    others = [make_bench(**STATES[state]) for state in ("encoder_axis", "two_speeds")]
    for group, offset, access, name in listed("channel", "group"):
        answers = [_ask(programs, group + owner, offset, access) for owner in OWNERS[group >> 12]]
        answers += [_ask(each, group + 1, offset, access) for each in others]
        reserved = (group, offset, access) in unserved
        if reserved:
            assert set(answers) == {0x703}, (hex(group), hex(offset), name, answers)
        else:
            best = min(answers, key=lambda code: (code != 0, code < 0x4000))
            assert best == 0 or best in NC_CODES, (hex(group), hex(offset), name, answers)
        walked["reserved" if reserved else "served"] += 1
    assert sum(walked.values()) == 221
    assert walked["reserved"] == len(unserved)


NC_CODES = {code.number for code in NcError}


def _ask(bench: Any, group: int, offset: int, access: str) -> int:
    """0, or the refusal of a request of any size that is taken."""
    worst = 0x703
    for size in SIZES:
        try:
            if access == "R&W":
                bench.exchange(group, offset, 300, bytes(size))
            elif "R" in access:
                data = bench.read(group, offset, 300 if size == 0 else size)
                if "W" in access:
                    bench.write(group, offset, data)
            else:
                bench.write(group, offset, bytes(size))
            return 0
        except DeviceError as refusal:
            worst = refusal.code if refusal.code != 0x705 else worst
            if refusal.code not in (0x705, 0x703):
                return worst
            if refusal.code == 0x703:
                return 0x703
    return worst


SIZES = (0, 1, 2, 4, 8, 12, 16, 20, 24, 32, 36, 40, 48, 56, 64, 72, 80, 128, 150, 160, 268)
