"""Functions of an encoder over ADS: its position, its touch probes in all their forms."""

import struct
from typing import Any

import pytest

E, STATE = 0x5201, 0x5101
MARK = {"simulation_mark_begin": 10.0, "simulation_mark_end": 12.0, "simulation_mark_input": 1}


def probe(bench: Any, unit: int) -> tuple[float, ...]:
    return struct.unpack(
        "<IIdI4xIIdI20x", bench.exchange(STATE, 0x200, 64, unit.to_bytes(24, "little"))
    )


def activate(bench: Any, unit: int, edge: int, mode: int, source: int) -> None:
    bench.put(E, 0x200, "<6I", unit, edge, mode, source, 0, 0)


def test_a_touch_probe_from_activation_to_its_value(make_bench: Any) -> None:
    bench = make_bench(**MARK)
    activate(bench, 1, 0, 1, 1)
    activate(bench, 1, 1, 2, 1)
    assert probe(bench, 1) == (1, 0, 0.0, 0, 1, 0, 0.0, 0)
    assert bench.get(STATE, 0x201, "<4I") == (1, 0, 0, 0)
    assert bench.get(STATE, 0x210, "<H") == bench.get(STATE, 0x211, "<H") == 1
    bench.start(30.0, 100.0)
    bench.until(lambda: bench.get(STATE, 0x212, "<H"))
    bench.run(0.002)
    assert bench.get(0x4301, 0x81, "<I") >> 16 & 1
    bench.until_rest()
    assert probe(bench, 1) == (0, 1, pytest.approx(10.0), 1, 1, 1, pytest.approx(12.0), 1)
    assert bench.get(STATE, 0x202, "<4I") == (1, 0, 0, 0)
    assert bench.get(STATE, 0x205, "<4d")[0] == pytest.approx(10.0)
    assert bench.get(STATE, 0x205, "<d") == pytest.approx(12.0)  # the last of all
    assert bench.get(STATE, 0x203, "<I") == bench.get(STATE, 0x204, "<Q") == 120_000
    assert bench.get(STATE, 0x206, "<I") == bench.get(STATE, 0x207, "<Q") == 20_000
    assert bench.get(STATE, 0x208, "<d") == pytest.approx(2.0)
    bench.put(E, 0x205, "<6I", 1, 1, 0, 0, 0, 0)
    assert probe(bench, 1)[4:6] == (0, 0)
    assert probe(bench, 1)[:2] == (0, 1)


@pytest.mark.parametrize(("offset", "edge"), [(0x201, 0), (0x202, 1)])
def test_one_latch_or_four(bench: Any, offset: int, edge: int) -> None:
    bench.write(E, offset, b"")
    flags = 0x210 + edge
    assert bench.get(STATE, flags, "<4H") == (1, 0, 0, 0)
    bench.write(E, 0x205, b"")
    assert bench.get(STATE, flags, "<4H") == (0, 0, 0, 0)
    bench.put(E, offset, "<4I", 0, 1, 1, 0)
    assert bench.get(STATE, flags, "<4H") == (0, 1, 1, 0)
    bench.put(E, 0x205, "<4I", 0, 1, 0, 0)
    assert bench.get(STATE, flags, "<4H") == (0, 0, 1, 0)


def test_a_latch_event_without_a_signal(bench: Any, refused: Any) -> None:
    with refused(0x4431):
        bench.put(E, 0x210, "<d", 5.0)
    bench.write(E, 0x201, b"")
    bench.put(E, 0x210, "<d", 5.0)
    assert bench.get(STATE, 0x202, "<H") == 1
    assert bench.get(STATE, 0x205, "<d") == 5.0


def test_refusals(bench: Any, refused: Any) -> None:
    with refused(0x4003):
        activate(bench, 5, 0, 1, 1)
    activate(bench, 2, 0, 1, 128)
    with refused(0x4435):
        activate(bench, 2, 0, 1, 128)
    with refused(0x4013):
        bench.write(0x5202, 0x201, b"")


@pytest.mark.parametrize("form", ["<Id", "<I4xd"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_the_position_of_an_encoder(bench: Any, form: str) -> None:
    bench.put(E, 0x1A, form, 1, 77.0)
    bench.run(0.004)
    assert bench.get(STATE, 0x02, "<d") == 77.0
    assert bench.get(0x4301, 0xBF, "<d") == 77.0
    assert bench.get(STATE, 0x17, "<d") == 77.0
    bench.write(E, 0x1B, b"")  # incremental: nothing to take again
    bench.run(0.004)
    assert bench.get(STATE, 0x02, "<d") == 77.0


def test_an_absolute_position_is_taken_again_only_while_disabled(
    make_bench: Any, refused: Any
) -> None:
    bench = make_bench(encoder_reference_system=2)
    bench.put(E, 0x1A, "<Id", 1, 77.0)
    with refused(0x4257):
        bench.write(E, 0x1B, b"")
    bench.put(0x4301, 0x02, "<H", 0)
    bench.run(0.004)
    bench.write(E, 0x1B, b"")
    bench.run(0.004)
    assert bench.get(STATE, 0x02, "<d") == 0.0
