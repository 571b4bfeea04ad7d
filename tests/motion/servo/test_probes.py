"""Touch probes and sync pulses: where the drive latched is where the axis says it was."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.codes.axis import StartType
from achse.codes.nc.choices import ReferenceMode
from achse.drive.machine import Switches
from achse.motion import commands
from achse.motion.fields.encoder import TOUCH_PROBES
from achse.motion.states import SignalSource
from tests.motion.servo.conftest import INPUTS, Bench

COUNTS = 13_107.2
"""Increments of a millimetre."""
MARK = Switches(probe=(20.0 * COUNTS, 25.0 * COUNTS))


def sweep(bench: Any, target: float) -> None:
    assert commands.start(bench.axis, StartType.ABSOLUTE, target, 100.0) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0)
    bench.run(0.1)


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize(("edge", "place"), [(0, 20.0), (TOUCH_PROBES, 25.0)])
def test_an_edge_is_where_it_was(make_bench: Any, edge: int, place: float, inverted: bool) -> None:
    mark = Switches(probe=(-25.0 * COUNTS, -20.0 * COUNTS)) if inverted else MARK
    bench = make_bench(switches=mark, inverted=inverted)
    bench.ready()
    encoder = bench.axis.encoder
    encoder.probe_active[edge] = 1
    encoder.probe_source[edge] = SignalSource.INPUT_1
    encoder.latch_active = 1
    bench.axis.wake()
    sweep(bench, 50.0)
    assert encoder.probe_valid[edge] == 1
    assert encoder.probe_counter[edge] == 1
    assert encoder.probe_position[edge] == pytest.approx(place, abs=1e-3)
    assert not encoder.latch_active
    assert bench.drive.record.probe_function == 0


def test_both_edges_and_again(make_bench: Any) -> None:
    bench = make_bench(switches=MARK)
    bench.ready()
    encoder = bench.axis.encoder
    for edge in (0, TOUCH_PROBES):
        encoder.probe_active[edge] = encoder.probe_continuous[edge] = 1
        encoder.probe_source[edge] = SignalSource.INPUT_1
    encoder.latch_active = 1
    bench.axis.wake()
    for count, target in enumerate((50.0, 0.0, 50.0), 1):
        sweep(bench, target)
        assert (encoder.probe_counter[0], encoder.probe_counter[TOUCH_PROBES]) == (count, count)
    assert encoder.probe_position[0] == pytest.approx(20.0, abs=1e-3)
    assert encoder.probe_position[TOUCH_PROBES] == pytest.approx(25.0, abs=1e-3)


def test_the_zero_pulse(make_bench: Any) -> None:
    bench = make_bench()
    bench.ready()
    sweep(bench, 3.0)
    encoder = bench.axis.encoder
    encoder.probe_active[0] = 1
    encoder.probe_source[0] = SignalSource.ZERO_PULSE
    encoder.latch_active = 1
    bench.axis.wake()
    sweep(bench, 15.0)
    assert encoder.probe_position[0] == pytest.approx(10.0, abs=1e-3)


@pytest.mark.parametrize(
    ("mode", "where"),
    [(ReferenceMode.HARDWARE_SYNC, 10.0), (ReferenceMode.HARDWARE_LATCH_1_RISING, 20.0),
     (ReferenceMode.HARDWARE_LATCH_1_FALLING, 25.0), (ReferenceMode.HOMING_SENSOR_ONLY, 5.0)],
)  # fmt: skip
def test_the_nc_homes_with_cam_and_sync_pulse_of_the_drive(
    make_bench: Any, mode: ReferenceMode, where: float
) -> None:
    switches = Switches(home=(-1e9, 5.0 * COUNTS), probe=MARK.probe)
    bench = make_bench(
        switches=switches,
        encoder_reference_mode=mode,
        encoder_external_sync_pulse=0,
        encoder_homing_cam_search_inverse=1,
        encoder_reference_position=100.0,
        homing_velocity_towards_cam=30.0,
        homing_velocity_off_cam=10.0,
    )
    bench.ready()
    sweep(bench, 8.0)
    assert commands.home(bench.axis) == 0
    bench.until(lambda axis: axis.set_motion_phase == 0, 60.0)
    assert bench.axis.homed
    place = bench.drive.record.position_actual / COUNTS
    assert bench.axis.actual_position - 100.0 == pytest.approx(place - where, abs=0.15)
    if mode is not ReferenceMode.HOMING_SENSOR_ONLY:
        assert bench.axis.actual_position - 100.0 == pytest.approx(place - where, abs=1e-3)


OBJECTS = (0x60B8, 0x60B9, 0x60BA, 0x60BB, 0x60BC, 0x60BD)


@settings(max_examples=20, deadline=None)
@given(
    st.sets(st.sampled_from(OBJECTS)),
    st.integers(1, TOUCH_PROBES),
    st.integers(0, 1),
    st.integers(1, 2),
    st.sampled_from([0, 1, 2, 3, 4, 128, 129]),
)
def test_a_probe_that_the_drive_cannot_latch_is_refused(
    mapped: set[int], unit: int, edge: int, mode: int, source: int
) -> None:
    """All parameters drawn. Units 3 and 4 have no bits in 60B8h."""
    bench = Bench(
        compiled=False,
        outputs=[0x6040, 0x6060, 0x607A, *({0x60B8} & mapped)],
        inputs=[0x6041, 0x6061, 0x6064, *sorted(mapped - {0x60B8})],
    )
    latched = ((0x60BA, 0x60BB), (0x60BC, 0x60BD))
    needed = {0x60B8, 0x60B9, *(latched[unit - 1][edge : edge + 1] if unit <= 2 else ())}
    possible = unit <= 2 and needed <= mapped
    expected = 0 if possible else NcError.ENCODER_EXTERNAL_LATCH
    assert commands.activate_touch_probe(bench.axis, unit, edge, mode, source) == expected
    flags = [int(number == unit) for number in range(1, TOUCH_PROBES + 1)]
    before = commands.deactivate_latch(bench.axis, *flags)
    assert before == 0
    assert commands.activate_latch(bench.axis, *flags, falling=bool(edge)) == expected


@pytest.mark.parametrize(
    ("mode", "missing"),
    [
        (ReferenceMode.HARDWARE_SYNC, 0x60BA),
        (ReferenceMode.HARDWARE_LATCH_1_RISING, 0x60B9),
        (ReferenceMode.HARDWARE_LATCH_1_FALLING, 0x60BB),
        (ReferenceMode.HARDWARE_LATCH_1_FALLING_DRIVE, 0x60BB),
    ],
)
def test_a_homing_whose_edge_is_not_mapped_is_refused(
    make_bench: Any, mode: ReferenceMode, missing: int
) -> None:
    bench = make_bench(inputs=[each for each in INPUTS if each != missing])
    bench.ready()
    bench.axis.encoder.reference_mode = mode
    assert commands.home(bench.axis) == NcError.ENCODER_HARDWARE_LATCH
    bench.axis.encoder.reference_mode = ReferenceMode.HOMING_SENSOR_ONLY
    assert commands.home(bench.axis) == 0
