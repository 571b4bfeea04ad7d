"""Rings of couplings over ADS: whoever would follow itself, by way of others or not, is refused."""

import random
import struct
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.codes import NcError
from achse.motion.states import SlaveType

AXES = (1, 2, 3, 4)
FUNCTION = 0x4200
CAM = 77
SLAVES = 2, 3
"""Coupling states of a slave that leads others, or none."""


def _codes(action: Any, *arguments: Any) -> int:
    try:
        action(*arguments)
    except DeviceError as refused:
        return int(refused.code)
    return 0


def _linear(bench: Any, slave: int, masters: list[int]) -> int:
    data = struct.pack("<4I4d", SlaveType.LINEAR, masters[0], 0, 0, 2.0, 0.0, 0.0, 0.0)
    return _codes(bench.write, FUNCTION + slave, 0x40, data)


def _several(bench: Any, slave: int, masters: list[int]) -> int:
    ids = masters + [0] * (4 - len(masters))
    words = SlaveType.MULTI_MASTER, ids[0], 0, 0, *ids[1:], 0, 0, 0, 0, 0
    data = struct.pack("<12Id2I", *words, 1000.0, 0, 0)
    return _codes(bench.write, FUNCTION + slave, 0x40, data)


def _by_cam(bench: Any, slave: int, masters: list[int]) -> int:
    solo = SlaveType.TABULAR, masters[0], 0, 0, CAM, 0, 0.0, 0.0, 1.0, 1.0, 0, 0, 0, 0.0, 0, 0
    return _codes(bench.write, FUNCTION + slave, 0x4A, struct.pack("<6I4d3I4xd2I", *solo))


def _reaches(follows: dict[int, list[int]], begin: int, end: int) -> bool:
    return begin == end or any(_reaches(follows, each, end) for each in follows.get(begin, ()))


def _shown(bench: Any) -> list[object]:
    """What all axes show of couplings, and where they are."""
    return [
        (axis.coupling.law, axis.coupling_state, list(axis.coupling.masters), axis.set_position)
        for axis in map(bench.nc.axis, AXES)
    ]


@pytest.mark.parametrize("seed", range(30))
def test_any_couplings_of_four_axes(groups: Any, seed: int) -> None:
    """A coupling is taken if it closes no ring, else refused, and then nothing has changed."""
    dice = random.Random(seed)
    groups.write(0xA200 + CAM, 0x10000, struct.pack("<3I", 3, 3, 2))
    groups.write(0xA000 + CAM, 0x0100_0000, struct.pack("<6d", 0.0, 0.0, 9.0, 1.0, 18.0, 0.0))
    follows: dict[int, list[int]] = {}
    refused = 0
    for _ in range(60):
        slave = dice.choice(AXES)
        if slave in follows:
            assert _codes(groups.write, FUNCTION + slave, 0x41, b"") == 0
            del follows[slave]
            groups.run(0.01)
            continue
        couple = dice.choice((_linear, _several, _by_cam))
        masters = dice.sample(AXES, dice.randint(2, 3) if couple is _several else 1)
        ring = any(_reaches(follows, each, slave) for each in masters)
        before = _shown(groups)
        code = couple(groups, slave, masters)
        if ring:
            assert code != 0
            assert _shown(groups) == before
            refused += code == NcError.MASTER_NOT_INSERTED.number
        else:
            assert code == 0, hex(code)
            follows[slave] = masters
        groups.run(0.004)
        for axis in AXES:
            state = groups.get(0x4100 + axis, 0x20, "<I")
            assert (state in SLAVES) == (axis in follows), axis
    assert refused
