"""Kinematic groups over ADS."""

import struct
from typing import Any

import pytest

P, S, F = 0x300D, 0x310D, 0x320D


def assign(bench: Any, mcs: tuple[int, ...], acs: tuple[int, ...], mode: int = 0) -> None:
    words = [*mcs, *(0,) * (8 - len(mcs)), *acs, *(0,) * (8 - len(acs)), mode, 0]
    bench.put(F, 0x54, "<18I", *words)


def transform(bench: Any, offset: int, *values: float) -> tuple[float, ...]:
    request = struct.pack("<8d2I", *values, *(0.0,) * (8 - len(values)), 0, 0)
    result: tuple[float, ...] = struct.unpack("<8d2I", bench.exchange(P, offset, 72, request))
    return result


def test_transformations_need_no_motion(groups: Any, refused: Any) -> None:
    places = transform(groups, 0x801, 30.0, 60.0)
    assert places[:2] == pytest.approx((259.807621135, 350.0))
    axes = transform(groups, 0x802, *places[:2])
    assert axes[:2] == pytest.approx((30.0, 60.0))
    with refused(0x4234):
        transform(groups, 0x802, 1000.0, 0.0)
    with refused(0x705):
        groups.exchange(P, 0x801, 72, bytes(64))


def test_the_tool_is_moved_and_the_axes_follow(groups: Any, refused: Any) -> None:
    assign(groups, (1, 2), (3, 4))
    words = struct.unpack("<18I", groups.read(S, 0x553, 72))
    assert words[:3] == (1, 2, 0)
    assert words[8:11] == (3, 4, 0)
    assert groups.axes(1, 2) == pytest.approx([500.0, 0.0], abs=1e-3)
    with refused(0x4257):
        groups.start(5.0, 10.0, axis=3)
    groups.start(400.0, 100.0, axis=1)
    groups.start(100.0, 100.0, axis=2)
    groups.run(0.1)
    assert groups.get(S, 0x05, "<I") == 2
    with refused(0x4220):
        groups.write(F, 0x53)
    groups.until(lambda: not groups.nc.groups.group(13).moving and groups.axes(2) == [100.0])
    places = transform(groups, 0x801, *groups.axes(3, 4))
    assert places[:2] == pytest.approx((400.0, 100.0), abs=1e-6)
    groups.write(F, 0x53)
    groups.start(5.0, 10.0, axis=3)


def test_the_axes_lead_if_the_first_reserved_word_says_so(groups: Any) -> None:
    assign(groups, (1, 2), (3, 4), 1)
    groups.start(30.0, 50.0, axis=3)
    groups.start(60.0, 50.0, axis=4)
    groups.until(lambda: groups.axes(3, 4) == [30.0, 60.0])
    groups.run(0.01)
    assert groups.axes(1, 2) == pytest.approx([259.807621135, 350.0])


@pytest.mark.parametrize(
    ("mcs", "acs", "error"),
    [
        ((1, 2), (3,), 0x42E0),
        ((), (), 0x42E0),
        ((1, 2), (2, 3), 0x42E0),
        ((1, 9), (3, 4), 0x4012),
    ],
)
def test_lists_that_do_not_match(
    groups: Any, refused: Any, mcs: tuple[int, ...], acs: tuple[int, ...], error: int
) -> None:
    with refused(error):
        assign(groups, mcs, acs)


def test_a_place_out_of_reach_stops_everything(groups: Any) -> None:
    """Behind the arms' length the kinematics has no solution: the group errs, all axes brake."""
    assign(groups, (1, 2), (3, 4))
    groups.start(400.0, 100.0, axis=1)
    groups.until(lambda: groups.axes(1) == [400.0])
    groups.start(600.0, 100.0, axis=1)
    groups.until(lambda: groups.get(S, 0x01, "<i"))
    assert groups.get(S, 0x01, "<i") in (0x4234, 0x4359)
    groups.until(lambda: not any(axis.set_velocity for axis in groups.nc))
    groups.write(F, 0x01)
    groups.run(0.02)
    assert groups.get(S, 0x01, "<i") == 0
    places = transform(groups, 0x801, *groups.axes(3, 4))
    assert places[:2] == pytest.approx(groups.axes(1, 2), abs=1e-3)
