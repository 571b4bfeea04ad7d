"""The PTP group of each axis over ADS."""

import contextlib
import random
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.motion.groups.states import SafState

P, S, F = 0x3001, 0x3101, 0x3201


def test_a_group_says_what_it_is(bench: Any) -> None:
    assert [bench.get(P, offset, "<I") for offset in (0x01, 0x03, 0x04, 0x05)] == [1, 1, 2000, 2000]
    assert bench.read(P, 0x02, 31) == b"X".ljust(31, b"\0")
    assert bench.read(0x3003, 0x02, 31) == b"C".ljust(31, b"\0")
    tables_channel_place = [bench.get(P, n, "<I") for n in (0x0B, 0x0C, 0x21, 0x23, 0x24)]
    assert tables_channel_place == [0, 8, 1, 1, 1]
    assert bench.read(P, 0x22, 31) == b"Axes".ljust(31, b"\0")
    assert bench.get(0x3003, 0x24, "<I") == 2


@pytest.mark.parametrize(
    ("offset", "form", "only", "error"), [(0x06, "<H", 0, 0x4208), (0x10, "<I", 1, 0x4205)]
)
def test_what_would_change_nothing_is_refused(
    bench: Any, refused: Any, offset: int, form: str, only: int, error: int
) -> None:
    bench.put(P, offset, form, only)
    for value in (0, 1, 2, 33):
        if value != only:
            with refused(error):
                bench.put(P, offset, form, value)
    assert bench.get(P, offset, form) == only


def test_the_states_of_a_group_are_those_of_its_axis(bench: Any) -> None:
    """Commands at random: error, motion and homing state, what waits and what can still wait."""
    source = random.Random(3100)
    seen = set()
    for _ in range(300):
        kind = source.randrange(8)
        if kind < 3:
            target = source.uniform(-90.0, 90.0)
            request = bench.universal(2, target, 100.0, mode=source.choice((0, 1, 1, 1)))
            with contextlib.suppress(DeviceError):
                bench.exchange(0x4201, 0x16, 4, request)
        elif kind == 3:
            bench.write(F, source.choice((0x01, 0x01, 0x02, 0x03)))
        elif kind == 4 and not source.randrange(4):
            bench.put(0x4201, 0x19, "<I", 0x4650)
        elif kind == 5 and not source.randrange(3):
            bench.axis.control_dword = source.choice((0, 7, 7))
        bench.run(source.choice((0.002, 0.02, 0.2)))
        axis = bench.axis
        seen.add(bench.get(S, 0x05, "<I"))
        assert bench.get(S, 0x01, "<i") == axis.error_code
        assert bench.get(S, 0x06, "<I") == bench.get(0x4301, 0xB2, "<I") == axis.motion_state
        assert bench.get(S, 0x08, "<I") == bench.get(0x4301, 0xB4, "<I")
        assert bench.get(S, 0x0C, "<I") == axis.buffer_count
        assert bench.get(S, 0x0F, "<I") == 8 - axis.buffer_count
        assert (bench.get(S, 0x05, "<I") == SafState.ERROR) == bool(axis.error_code)
        assert [bench.get(S, n, "<I") for n in (0x02, 0x03, 0x07, 0x09, 0x0A)] == [1, 0, 0, 0, 0]
    assert seen == set(SafState)


def test_functions_of_a_group_are_those_of_its_axis(bench: Any) -> None:
    bench.start(0.0, 50.0, 3)
    bench.run(0.5)
    bench.write(F, 0x02)
    assert bench.get(S, 0x05, "<I") == SafState.STOPPING
    bench.until_rest()
    assert bench.get(S, 0x05, "<I") == SafState.READY
    for _ in range(3):
        bench.exchange(0x4201, 0x16, 4, bench.universal(2, 50.0, 100.0, mode=1))
    assert bench.get(S, 0x0C, "<I") == 2
    bench.write(F, 0x03)
    assert bench.get(S, 0x0C, "<I") == 0
    bench.put(0x4201, 0x19, "<I", 0x4650)
    bench.run(0.02)
    assert (bench.get(S, 0x01, "<i"), bench.get(S, 0x05, "<I")) == (0x4650, SafState.ERROR)
    bench.write(F, 0x01)
    bench.run(0.02)
    assert bench.get(S, 0x01, "<i") == 0


@pytest.mark.parametrize("group", [0, 2, 4, 255])
def test_an_id_that_no_group_has(bench: Any, refused: Any, group: int) -> None:
    for base in (0x3000, 0x3100):
        with refused(0x4011):
            bench.read(base + group, 0x01, 4)
    with refused(0x4011):
        bench.write(0x3200 + group, 0x01)


def test_the_dead_time_is_of_encoder_groups_alone(bench: Any, refused: Any) -> None:
    """0x606: 0 … 60 s; groups of other axes have none."""
    with refused(0x703):
        bench.get(P, 0x606, "<d")
    with refused(0x703):
        bench.put(P, 0x606, "<d", 0.1)
    bench.axis.axis_type = 5
    assert bench.get(P, 0x03, "<I") == 9
    assert bench.get(P, 0x606, "<d") == 0.0
    bench.put(P, 0x606, "<d", 60.0)
    for value in (-0.001, 60.001, float("nan")):
        with refused(0x42E7):
            bench.put(P, 0x606, "<d", value)
    with refused(0x705):
        bench.write(P, 0x606, bytes(4))
    assert bench.get(P, 0x606, "<d") == 60.0
