"""Signals of the machine; what the NC makes of them is tested beside the NC."""

from typing import Any

import pytest

from achse.motion.machine.signals import NOWHERE, cam_closed, drive_inputs, edge, outward
from achse.motion.port import LATCH_DRIVE_DEFINED, LATCH_INDEX


def test_inputs_are_those_of_hand_cam_and_mark(make_machine: Any) -> None:
    machine = make_machine(
        cam_begin=1.0, cam_end=3.0, cam_input=2, mark_begin=2.0, mark_end=4.0, mark_input=8,
        drive_inputs=1,
    ).machine  # fmt: skip
    for position, inputs in ((0.0, 1), (1.0, 0b11), (2.5, 0x83), (3.5, 0x81), (4.1, 1)):
        machine.position = position
        assert drive_inputs(machine) == inputs
        assert cam_closed(machine) == (inputs & 2 != 0)


@pytest.mark.parametrize(
    ("switch", "velocity", "out"),
    [(1, 1.0, True), (1, -1.0, False), (-1, -1.0, True), (0, 1.0, False)],
)
def test_outward_is_farther_beyond_the_switch(
    make_machine: Any, switch: int, velocity: float, out: bool
) -> None:
    machine = make_machine(limit_switch=switch).machine
    assert outward(machine, velocity) == out


def test_what_a_drive_itself_latches_on(make_machine: Any) -> None:
    bench = make_machine(
        turn=1000.0, mark_begin=0.03, mark_end=0.05, mark_input=1, encoder_resolution=1e-4
    )
    bench.sensor.before, bench.machine.position = 0.01, 0.2
    assert edge(bench.sensor, LATCH_INDEX, 0) == pytest.approx(0.1)
    assert edge(bench.sensor, LATCH_DRIVE_DEFINED, 0) == pytest.approx(0.1)
    bench.machine.latch_source = 1
    assert edge(bench.sensor, LATCH_DRIVE_DEFINED, 0) == 0.03
    assert edge(bench.sensor, LATCH_DRIVE_DEFINED, 1) == 0.05
    bench.machine.latch_source = 100
    assert edge(bench.sensor, LATCH_DRIVE_DEFINED, 0) == NOWHERE
    assert edge(bench.sensor, 0, 0) == NOWHERE


def test_an_input_switched_by_hand_has_its_edge_where_the_machine_is(make_machine: Any) -> None:
    bench = make_machine(position=4.0, drive_inputs=0b100)
    assert edge(bench.sensor, 3, 0) == 4.0
    bench.sensor.inputs_before = 0b100
    assert edge(bench.sensor, 3, 0) == NOWHERE
    bench.machine.drive_inputs = 0
    assert edge(bench.sensor, 3, 1) == 4.0
