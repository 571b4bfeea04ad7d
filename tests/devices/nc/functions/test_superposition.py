"""Section compensation and phasing over ADS: forms, answers, warnings."""

import struct
from typing import Any

import pytest

F = 0x4201
FORMS = pytest.mark.parametrize(
    ("requested", "answered"), [("<I6d", "<I6dI"), ("<I4x6d", "<I4x6dI4x")], ids=["TC2", "TC3"]
)
ENOUGH = (1, 400.0, 200.0, 50.0, 100.0, 10.0, 200.0)
TOO_SHORT = (1, 400.0, 200.0, 50.0, 100.0, 10.0, 20.0)


@pytest.fixture
def moving(bench: Any) -> Any:
    bench.start(0.0, 100.0, start_type=3)
    bench.until(lambda: bench.axis.set_velocity == 100.0)
    return bench


@FORMS
def test_start(moving: Any, requested: str, answered: str) -> None:
    moving.put(F, 0x30, requested, *ENOUGH)
    assert moving.get(0x4301, 0x81, "<I") >> 13 & 1 == 0
    moving.run(0.002)
    assert moving.get(0x4301, 0x81, "<I") >> 13 & 1
    moving.until(lambda: not moving.axis.compensating)
    assert moving.axis.superposed.position == pytest.approx(10.0)


@FORMS
def test_the_warning_is_the_result_of_a_write(
    moving: Any, refused: Any, requested: str, answered: str
) -> None:
    with refused(0x4243):
        moving.put(F, 0x30, requested, *TOO_SHORT)
    assert moving.axis.compensating == 1
    with refused(0x4245):
        moving.put(F, 0x30, requested, *TOO_SHORT)


@FORMS
def test_the_answer_is_what_is_carried_out(moving: Any, requested: str, answered: str) -> None:
    size = struct.calcsize(answered)
    data = moving.exchange(F, 0x30, size, struct.pack(answered, *TOO_SHORT, 0))
    done = struct.unpack(answered, data)
    # in 0.2 s the triangle with both ramps: top T / C, way T² / 2C, C = 1/400 + 1/200
    c = 1.0 / 400.0 + 1.0 / 200.0
    top = 0.2 / c
    assert done[:3] == (1, 400.0, 200.0)
    assert done[3] == pytest.approx(top)
    assert done[4] == 100.0
    assert done[5] == pytest.approx(0.5 * top * 0.2)
    assert done[6:] == (pytest.approx(20.0), 0x4243)


@FORMS
def test_stop(moving: Any, refused: Any, requested: str, answered: str) -> None:
    with refused(0x4246):
        moving.write(F, 0x31)
    moving.put(F, 0x30, requested, *ENOUGH)
    moving.run(0.5)
    moving.write(F, 0x31)
    with refused(0x4258):
        moving.write(F, 0x31)
    moving.until(lambda: not moving.axis.compensating)
    assert moving.axis.set_velocity == 100.0


def test_at_rest_it_is_refused(bench: Any, refused: Any) -> None:
    with refused(0x4245):
        bench.put(F, 0x30, "<I4x6d", *ENOUGH)
    with refused(0x4245):
        bench.exchange(F, 0x30, 64, struct.pack("<I4x6dI4x", *ENOUGH, 0))


PHASING = "<IIIIddddd4dIId"


def phasing(kind: int, shift: float, velocity: float = 50.0, mode: int = 0) -> bytes:
    return struct.pack(
        PHASING, kind, 0, 0, 0, shift, velocity, 0.0, 0.0, 0.0, *[0.0] * 4, 0, mode, 0.0
    )


def test_phasing(bench: Any, refused: Any) -> None:
    assert struct.calcsize(PHASING) == 104
    bench.write(F, 0x34, phasing(1, 12.5))
    bench.run(0.002)
    assert bench.get(0x4301, 0x81, "<I") >> 15 & 1
    bench.until(lambda: not bench.axis.phasing_active)
    bench.run(0.002)
    assert bench.get(0x4301, 0x81, "<I") >> 15 & 1 == 0
    structure = bench.read(0x4301, 0x80, 256)
    assert struct.unpack_from("<d", structure, 208) == (12.5,)
    with refused(0x4251):
        bench.write(F, 0x34, phasing(1, 12.5, mode=1))
    with refused(0x4221):
        bench.write(F, 0x34, phasing(2, 12.5, 0.0))
    with refused(0x705):
        bench.write(F, 0x34, bytes(100))
