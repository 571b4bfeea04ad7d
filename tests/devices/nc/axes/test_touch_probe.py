"""Touch probe states: none at first, then what was latched, for one probe or four."""

import struct
from typing import Any

E = 0x5101


def state(bench: Any, probe: int) -> tuple[float, ...]:
    answer = bench.exchange(E, 0x200, 64, struct.pack("<I20x", probe))
    assert len(answer) == 64
    return struct.unpack("<IIdI4xIIdI20x", answer)


def test_nothing_is_latched_at_first(bench: Any) -> None:
    for probe in (1, 2, 3, 4):
        assert state(bench, probe) == (0,) * 8
    assert bench.get(E, 0x201, "<H") == 0
    assert bench.get(E, 0x202, "<H") == 0
    assert bench.get(E, 0x101, "<d") == 0.0
    assert bench.get(E, 0x203, "<I") == bench.get(E, 0x204, "<Q") == 0


def test_each_probe_shows_its_edges(bench: Any) -> None:
    axis = bench.axis
    axis.encoder.probe_active[0] = 1
    axis.encoder.probe_valid[1] = 1
    axis.encoder.probe_position[1] = 12.5
    axis.encoder.probe_counter[1] = 3
    axis.encoder.probe_valid[4 + 2] = 1
    axis.encoder.probe_position[4 + 2] = -7.5
    axis.encoder.probe_active[4 + 3] = 1
    assert state(bench, 1) == (1, 0, 0, 0, 0, 0, 0, 0)
    assert state(bench, 2) == (0, 1, 12.5, 3, 0, 0, 0, 0)
    assert state(bench, 3) == (0, 0, 0, 0, 0, 1, -7.5, 0)
    assert bench.get(E, 0x201, "<4I") == (1, 0, 0, 1)
    assert bench.get(E, 0x201, "<H") == 1
    assert bench.get(E, 0x202, "<4I") == (0, 1, 1, 0)
    assert bench.get(E, 0x205, "<4d") == (0.0, 12.5, -7.5, 0.0)
    assert bench.get(E, 0x210, "<4H") == (1, 0, 0, 0)
    assert bench.get(E, 0x211, "<4H") == (0, 0, 0, 1)


def test_the_single_latch(bench: Any) -> None:
    axis = bench.axis
    axis.encoder.latch_position = 3.25
    axis.encoder.latch_hardware_increments = 32_500
    axis.encoder.latch_software_increments = 2**40
    axis.encoder.latch_position_difference = 0.25
    assert bench.get(E, 0x205, "<d") == 3.25
    assert bench.get(E, 0x203, "<I") == 32_500
    assert bench.get(E, 0x204, "<Q") == 2**40
    assert bench.get(E, 0x208, "<d") == 0.25


def test_inputs_of_the_probes_are_those_of_the_drive(bench: Any) -> None:
    for inputs in range(4):
        bench.axis.simulation_drive_inputs = inputs
        bench.run(0.002)
        assert bench.get(E, 0x212, "<H") == inputs & 1
        assert bench.get(E, 0x213, "<H") == inputs >> 1


def test_a_probe_that_is_not_there(bench: Any, refused: Any) -> None:
    for probe in (0, 5):
        with refused(0x4003):
            state(bench, probe)
