"""What an encoder counts, and what its latches take."""

from typing import Any

import pytest

from achse.motion.port import CAM_CLOSED, LATCH_INDEX

MARK = {"mark_begin": 1.0, "mark_end": 2.0, "mark_input": 2}


@pytest.mark.parametrize("inverted", [0, 1])
@pytest.mark.parametrize("resolution", [1e-4, 0.01, 2.5])
def test_it_counts_whole_increments(
    make_machine: Any, place: Any, inverted: int, resolution: float
) -> None:
    bench = make_machine(encoder_resolution=resolution, encoder_inverted=inverted)
    place(bench, 100.3 * resolution)
    assert bench.encoder.data_in1 == (-100 if inverted else 100)
    assert bench.encoder.has_changed == 1


def test_it_begins_at_0_again_after_its_largest_count(make_machine: Any, place: Any) -> None:
    bench = make_machine(encoder_mask=999, encoder_resolution=1.0)
    place(bench, 1003.0)
    assert bench.encoder.data_in1 == 3
    place(bench, -1.0)
    assert bench.encoder.data_in1 == 999
    bench = make_machine(encoder_resolution=1.0)
    place(bench, 2.0**31 + 5)
    assert bench.encoder.data_in1 == -(2**31) + 5
    place(bench, 1e300)
    assert bench.sensor.count == pytest.approx(4e18)


def test_without_valid_data_nothing_new_is_shown(make_machine: Any, place: Any) -> None:
    bench = make_machine(encoder_resolution=1.0)
    place(bench, 5.0)
    bench.machine.io_invalid = 1
    place(bench, 7.0)
    assert (bench.encoder.data_in1, bench.encoder.state4) == (5, 1)
    bench.machine.io_invalid = 0
    bench.run()
    assert (bench.encoder.data_in1, bench.encoder.state4) == (7, 0)


def test_the_cam_that_is_wired_to_the_encoder(make_machine: Any, place: Any) -> None:
    bench = make_machine(cam_begin=1.0, cam_end=2.0)
    place(bench, 1.5)
    assert bench.encoder.state2 == CAM_CLOSED
    bench.machine.period = 10.0
    place(bench, 21.5)
    assert bench.encoder.state2 == CAM_CLOSED
    bench.machine.cam_input = 1
    bench.run()
    assert bench.encoder.state2 == 0
    assert bench.drive.state8 == 1


def test_the_noise_is_within_its_amplitude(make_machine: Any) -> None:
    bench = make_machine(noise=20.0, encoder_resolution=1.0, noise_state=7)
    seen = set()
    for _ in range(300):
        bench.run()
        seen.add(bench.encoder.data_in1)
    assert len(seen) > 20
    assert max(map(abs, seen)) <= 20


def test_a_probe_takes_the_counts_of_both_edges_in_one_cycle(make_machine: Any, place: Any) -> None:
    bench = make_machine(encoder_resolution=0.01, **MARK)
    bench.encoder.ctrl5 = 2 | 2 << 4
    bench.run()
    place(bench, 3.0)
    assert bench.encoder.state5 == 0b110
    assert bench.encoder.data_in3 & 0xFFFF_FFFF == 100
    assert bench.encoder.data_in3 >> 32 == 200
    place(bench, 0.0)  # back: the edges change places
    assert bench.encoder.state5 == 0
    assert bench.encoder.data_in3 & 0xFFFF_FFFF == 200
    assert bench.encoder.data_in3 >> 32 == 100


def test_each_probe_has_its_data(make_machine: Any, place: Any) -> None:
    bench = make_machine(encoder_resolution=0.01, encoder_inverted=1, **MARK)
    io = bench.encoder
    for n in range(4):
        setattr(io, f"ctrl{5 + n}", 2 << (4 * (n % 2)))
    bench.run()
    place(bench, 3.0)
    assert [io.state5, io.state6, io.state7, io.state8] == [0b10, 0b100, 0b10, 0b100]
    counts = [io.data_in3, io.data_in4 >> 32, io.data_in5, io.data_in6 >> 32]
    assert [((count + 2**31) % 2**32) - 2**31 for count in counts] == [-100, -200, -100, -200]


def test_the_homing_latch_waits_for_the_index(make_machine: Any, place: Any) -> None:
    bench = make_machine(encoder_resolution=0.01, turn=100.0, index_position=30.0)
    bench.encoder.ctrl1 = LATCH_INDEX
    bench.run(2)
    assert bench.encoder.state1 == 0b01
    place(bench, 0.5)
    assert (bench.encoder.state1, bench.encoder.data_in2) == (0b11, 30)
    bench.encoder.ctrl1 = 0
    bench.run()
    place(bench, 5.0)
    assert (bench.encoder.state1, bench.encoder.data_in2) == (0b10, 30)
    assert bench.sensor.watching == 0
