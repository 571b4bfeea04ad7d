"""Cyclic interface at 0x4300 + ID: control bits and override in, status out."""

import struct
from typing import Any

import pytest

C, F = 0x4301, 0x4201
REAL, FLAG, NUMBER = "<d", "<H", "<I"
PHASING = "<I12xdd72x"


def test_control_bits_make_up_the_control_word(bench: Any) -> None:
    bench.put(C, 0x01, NUMBER, 0)
    for offset, bit in ((0x02, 0), (0x03, 1), (0x04, 2), (0x07, 5)):
        bench.put(C, offset, FLAG, 1)
        assert bench.get(C, 0x01, NUMBER) == 1 << bit
        assert bench.get(C, offset, FLAG) == 1
        bench.put(C, offset, FLAG, 0)
        assert bench.get(C, 0x01, NUMBER) == 0
    bench.put(C, 0x01, NUMBER, 0xFFFF_FFFF)
    bench.put(C, 0x03, FLAG, 0)
    assert bench.get(C, 0x01, NUMBER) == 0xFFFF_FFFD


def test_enabling_makes_the_axis_ready(bench: Any) -> None:
    bench.put(C, 0x02, FLAG, 0)
    bench.run(0.002)
    assert bench.get(C, 0x82, FLAG) == 0
    bench.put(C, 0x02, FLAG, 1)
    bench.run(0.002)
    assert bench.get(C, 0x82, FLAG) == 1


def test_the_override_scales_a_running_move(bench: Any) -> None:
    bench.start(0.0, 200.0, start_type=3)
    bench.run(2.0)
    for override, velocity in ((500_000, 100.0), (0, 0.0), (1_000_000, 200.0)):
        bench.put(C, 0x21, NUMBER, override)
        bench.run(2.0)
        assert bench.get(C, 0xC0, REAL) == pytest.approx(velocity)
        assert bench.get(C, 0x21, NUMBER) == override


def test_an_override_above_full_is_refused(bench: Any, refused: Any) -> None:
    with refused(0x42CE):
        bench.put(C, 0x21, NUMBER, 1_000_001)
    assert bench.get(C, 0x21, NUMBER) == 1_000_000


def test_state_bits_along_a_move(bench: Any) -> None:
    def bits(*offsets: int) -> list[int]:
        return [bench.get(C, offset, FLAG) for offset in offsets]

    job, positive, negative, still, there, constant = 0x9B, 0x8A, 0x8B, 0x8C, 0x8F, 0x90
    assert bits(job, positive, negative, still, there, constant) == [0, 0, 0, 1, 1, 0]
    bench.start(100.0, 50.0)
    bench.run(0.1)
    assert bits(job, positive, negative, still, constant) == [1, 1, 0, 0, 0]
    assert bench.get(C, 0xB2, NUMBER) == 4
    bench.run(1.0)
    assert bits(job, positive, still, there, constant) == [1, 1, 0, 0, 1]
    assert bench.get(C, 0xB2, NUMBER) == 3
    bench.until_rest()
    bench.run(0.5)
    assert bits(job, positive, negative, still, there, constant) == [0, 0, 0, 1, 1, 0]
    bench.start(0.0, 50.0)
    bench.run(0.1)
    assert bits(job, positive, negative) == [1, 0, 1]


def test_the_state_word_its_bytes_and_its_bits_agree(bench: Any) -> None:
    bench.start(100.0, 50.0)
    bench.run(0.1)
    word = bench.get(C, 0x81, NUMBER)
    assert bytes(bench.get(C, 0x71 + byte, "<B") for byte in range(4)) == struct.pack("<I", word)
    for offset, bit in (
        (0x82, 0), (0x83, 1), (0x84, 5), (0x88, 30), (0x89, 31), (0x8A, 9), (0x8B, 10),
        (0x8C, 2), (0x8D, 11), (0x8E, 3), (0x8F, 4), (0x90, 12), (0x9B, 8),
    ):  # fmt: skip
        assert bench.get(C, offset, FLAG) == word >> bit & 1


def test_the_structure_has_the_form_of_its_length(bench: Any) -> None:
    bench.start(100.0, 50.0)
    bench.run(0.5)
    packed, aligned = bench.read(C, 0x80, 128), bench.read(C, 0x80, 256)
    actual = bench.get(C, 0xBA, REAL)
    assert (
        struct.unpack_from("<d", packed, 44) == struct.unpack_from("<d", aligned, 40) == (actual,)
    )
    for data in (packed, aligned):
        assert struct.unpack_from("<IIII", data, 0) == (bench.get(C, 0x81, NUMBER), 0, 3, 0)
        axis_id, mode = struct.unpack_from("<II", data, 32)
        assert (axis_id, mode & 0xFF_FFFF) == (1, bench.get(C, 0xB9, NUMBER))
        assert struct.unpack_from("<ddddddd", data, 64) == (
            bench.get(C, 0xBD, REAL),
            bench.get(C, 0xBE, REAL),
            bench.get(C, 0xBF, REAL),
            bench.get(C, 0xC0, REAL),
            bench.get(C, 0xC1, REAL),
            100.0,
            bench.get(0x4101, 0x0B, REAL),
        )
        assert struct.unpack_from("<HH", data, 124) == (1, 1)


def test_the_mode_word_of_twincat_3_counts_the_cycles(bench: Any) -> None:
    def count() -> int:
        mode: int = struct.unpack_from("<I", bench.read(C, 0x80, 256), 36)[0]
        return mode >> 24

    first = count()
    bench.run(0.006)
    assert (count() - first) % 256 == 3
    bench.run(256 * 0.002)
    assert (count() - first) % 256 == 3
    assert struct.unpack_from("<I", bench.read(C, 0x80, 128), 36)[0] >> 24 == 0


def test_the_touch_probe_words_show_what_waits_and_what_was_latched(make_bench: Any) -> None:
    bench = make_bench(simulation_mark_input=2, simulation_mark_begin=10, simulation_mark_end=20)

    def words() -> tuple[int, ...]:
        return struct.unpack_from("<IIII", bench.read(C, 0x80, 256), 152)

    def drive_to(position: float) -> None:
        bench.start(position, 100.0)
        bench.until_rest()
        bench.run(0.1)

    assert words() == (0, 0, 0, 0)
    for edge in (0, 1):
        bench.put(0x5201, 0x200, "<4I8x", 2, edge, 2, 2)  # probe 2, on and on, input 2
    assert words() == (0, 0, 0x0100, 0)
    drive_to(15.0)
    assert words() == (0, 0b10, 0x8300, 0x0100)
    drive_to(30.0)
    assert words() == (0, 0, 0x0700, 0x0200)
    drive_to(0.0)
    assert words() == (0, 0, 0x0700, 0x0400)
    for edge in (0, 1):
        bench.put(0x5201, 0x205, "<2I16x", 2, edge)
    assert words() == (0, 0, 0, 0x0400)


def test_a_blocked_drive_is_left_where_the_plc_accepts_it(make_bench: Any, refused: Any) -> None:
    """ControlDWord bit 8 (004 §4.2.5): off a limit switch though the drive is not ready."""
    bench = make_bench(simulation_limit_max=20.0)

    def ready() -> int:
        return int(bench.read(0x7301, 0x80, 40)[8]) & 1

    assert ready() == 1
    bench.start(0.0, 100.0, start_type=3)
    bench.until(lambda: bench.axis.error_code)
    assert bench.get(C, 0xB1, NUMBER) == 0x4650
    reset(bench)
    assert (bench.get(C, 0x82, FLAG), ready()) == (0, 0)
    with refused(0x4225):
        bench.start(0.0, 100.0)
    enable(bench, 7 | 1 << 8)
    assert bench.get(C, 0x82, FLAG) == 1
    with refused(0x4225):
        bench.start(100.0, 100.0)
    bench.start(0.0, 100.0)
    bench.until_rest()
    enable(bench, 7)
    assert (bench.get(C, 0x82, FLAG), bench.get(C, 0xB1, NUMBER), ready()) == (1, 0, 1)


def test_monitoring_is_shown(bench: Any) -> None:
    assert bench.get(C, 0xB9, NUMBER) == 1 << 0 | 1 << 1 | 1 << 8 | 1 << 16
    assert bench.get(0x4303, 0xB9, NUMBER) & 1 << 7  # modulo axis


def test_single_values(bench: Any) -> None:
    bench.start(400.0, 300.0, axis=3)
    axis = bench.nc.axis(3)
    bench.until(lambda: not axis.set_motion_phase)
    bench.run(0.5)
    assert bench.get(0x4303, 0xB8, NUMBER) == 3
    assert bench.get(0x4303, 0xBC, "<i") == 1
    assert bench.get(0x4303, 0xBB, REAL) == pytest.approx(40.0, abs=0.001)
    for offset in (0xB1, 0xB4, 0xB5, 0xB7):
        assert bench.get(0x4303, offset, NUMBER) == 0


@pytest.mark.parametrize("offset", [0x80, 0x81, 0x82, 0xB1, 0xBA])
def test_states_are_not_written(bench: Any, refused: Any, offset: int) -> None:
    with refused(0x704):
        bench.write(C, offset, bytes(4))


def test_flags_are_0_or_1(bench: Any, refused: Any) -> None:
    with refused(0x706):
        bench.put(C, 0x02, FLAG, 2)
    with refused(0x705):
        bench.put(C, 0x02, "<B", 1)


def test_there_is_one_interface(bench: Any, refused: Any) -> None:
    with refused(0x4012):
        bench.get(C, 0x0010_0081, NUMBER)


FROM_PLC = "<IIIIdddddi4xddddd8xd8x"


def test_the_structure_from_the_plc_is_taken_whole(bench: Any, refused: Any) -> None:
    values = (3, 500_000, 1, 2, 1.5, 2.5, 3.5, 4.5, 5.5, -1, 6.5, 7.5, 8.5, 9.5, 10.5, 11.5)
    bench.put(0x4301, 0x00, FROM_PLC, *values)
    axis = bench.axis
    assert (axis.control_dword, axis.velocity_override) == (3, 500_000)
    assert (axis.actual_position_correction, axis.external_set_direction) == (2.5, -1)
    assert bench.get(0x4301, 0x00, FROM_PLC) == values
    assert bench.get(0x4301, 0x27, "<ddddi12x") == (3.5, 4.5, 5.5, 11.5, -1)
    for wrong in (
        (7, 1_000_001, *values[2:]),
        (7, *values[1:9], 2, *values[10:]),
        (7, *values[1:4], float("nan"), *values[5:]),
    ):
        with refused(0x42CE if wrong[1] > 1_000_000 else 0x4003):
            bench.put(0x4301, 0x00, FROM_PLC, *wrong)
        assert axis.control_dword == 3  # all of it or nothing


def test_the_external_set_point_in_both_forms(bench: Any, refused: Any) -> None:
    bench.put(0x4301, 0x27, "<ddddi12x", 1.0, 2.0, 3.0, 40.0, 1)
    assert bench.get(0x4301, 0x27, "<ddddi12x") == (1.0, 2.0, 3.0, 40.0, 1)
    bench.put(0x4301, 0x27, "<dddi", 5.0, 6.0, 7.0, -1)
    assert bench.get(0x4301, 0x27, "<ddddi12x") == (5.0, 6.0, 7.0, 40.0, -1)
    assert bench.get(0x4301, 0x27, "<dddi") == (5.0, 6.0, 7.0, -1)
    with refused(0x4003):
        bench.put(0x4301, 0x27, "<dddi", 5.0, 6.0, 7.0, 2)


def test_the_operation_mode_is_busy_until_the_next_cycle(bench: Any) -> None:
    bench.put(0x4301, 0x22, "<I", 5)
    assert bench.get(0x4301, 0x9A, "<H") == 1
    bench.run(0.002)
    assert bench.get(0x4301, 0x9A, "<H") == 0
    assert bench.get(0x4301, 0xB3, "<I") == 5


def test_corrections_from_the_plc_act(bench: Any) -> None:
    bench.put(0x5001, 0x16, "<H", 1)
    bench.put(0x4301, 0x25, "<d", 0.5)
    bench.run(1.0)
    assert bench.get(0x5101, 0x0A, "<d") == 0.5
    assert bench.get(0x5101, 0x0B, "<d") == pytest.approx(-0.5, abs=1e-3)
    bench.put(0x4301, 0x26, "<d", 4.0)
    bench.run(2.0)
    assert bench.get(0x6101, 0x0F, "<d") == pytest.approx(-4.0 / 20.0, abs=1e-3)


def test_there_are_no_preparation_entries(bench: Any) -> None:
    assert bench.get(0x4301, 0xB6, "<I") == 0


def enable(bench: Any, control: int) -> Any:
    bench.put(C, 0x01, NUMBER, control)
    bench.run(0.01)


def move(bench: Any, kind: int, position: float = 0.0, velocity: float = 100.0) -> Any:
    bench.start(position, velocity, start_type=kind)
    bench.run(0.5)


def stop(bench: Any) -> Any:
    bench.write(F, 0x02)
    bench.until_rest()
    bench.run(0.1)


def fail(bench: Any) -> None:
    bench.put(F, 0x19, NUMBER, 0x4466)
    bench.run(0.01)


def reset(bench: Any) -> Any:
    bench.write(F, 0x01)
    bench.run(0.01)


def leave_target(bench: Any) -> None:
    bench.start(100.0, 200.0, start_type=2)
    bench.run(0.6)


def arrive(bench: Any) -> None:
    bench.until_rest()
    bench.run(0.5)


def block(bench: Any) -> None:
    move(bench, 3)
    bench.axis.simulation_blocked = 1
    bench.until(lambda: bench.axis.delayed_error_code)


def expire(bench: Any) -> None:
    bench.until(lambda: bench.axis.error_code)
    bench.axis.simulation_blocked = 0
    bench.run(0.01)
    assert bench.get(C, 0x81, NUMBER) >> 6 & 1 == 0
    reset(bench)


def compensate(bench: Any) -> None:
    bench.run(0.5)
    move(bench, 3)
    bench.put(F, 0x30, "<I4x6d", 1, 0.0, 0.0, 50.0, 100.0, 10.0, 300.0)
    bench.run(0.1)


def end_compensation(bench: Any) -> None:
    bench.write(F, 0x31)
    bench.until(lambda: not bench.axis.compensating)
    stop(bench)


def latch(bench: Any) -> None:
    bench.put(0x5201, 0x200, "<4I8x", 1, 0, 1, 128)  # the index pulse, once
    bench.start(20.0, 100.0, start_type=2)
    bench.until_rest()


def travel_past(bench: Any, limit: int, position: float) -> None:
    bench.put(0x5001, 0x0D + limit, REAL, position)
    bench.put(0x5001, 0x0B + limit, FLAG, 1)
    bench.run(0.01)


def accelerate_beyond_the_limit(bench: Any) -> None:
    bench.put(0x7001, 0x0C, REAL, 0.01)
    bench.start(0.0, 100.0, start_type=3)
    bench.until(lambda: bench.axis.set_velocity > 30.0)


STATUS_BITS: dict[int, tuple[str, dict[str, float], Any, Any]] = {
    0: ("enabled, without error", {}, lambda b: enable(b, 7), lambda b: enable(b, 0)),
    1: (
        "homed flag",
        {},
        lambda b: b.put(F, 0x1B, NUMBER, 1),
        lambda b: b.put(F, 0x1B, NUMBER, 0),
    ),
    2: ("set point at rest", {}, stop, lambda b: move(b, 3)),
    3: ("inside the position window", {}, arrive, leave_target),
    4: ("inside the target window for its time", {}, arrive, leave_target),
    6: ("an error whose reaction waits", {
            "error_reaction_mode": 1, "error_reaction_delay": 0.5,
        }, block, expire),
    7: ("a stop since the last start", {}, stop, lambda b: move(b, 3)),
    8: ("a command at work", {}, lambda b: move(b, 3), stop),
    9: ("set point grows", {}, lambda b: move(b, 3), stop),
    10: ("set point falls", {}, lambda b: move(b, 4), stop),
    11: ("homing", {}, lambda b: b.write(F, 0x10), stop),
    12: ("set velocity constant", {}, lambda b: move(b, 3), stop),
    13: ("section compensation", {}, compensate, end_compensation),
    14: (
        "external set points",
        {},
        lambda b: b.put(F, 0x23, "<I4xd8x", 1, 0.0),
        lambda b: b.write(F, 0x24),
    ),
    15: ("phasing", {}, lambda b: b.put(F, 0x34, PHASING, 1, 500.0, 10.0),
         lambda b: b.put(F, 0x34, PHASING, 4096, 0.0, 0.0)),
    16: ("a latched position", {}, latch,
         lambda b: b.put(0x5201, 0x205, "<2I16x", 1, 0)),
    17: (
        "a new target in motion",
        {},
        lambda b: (stop(b), move(b, 2, 500.0), b.put(F, 0x11, "<I4xd", 2, 600.0)),
        lambda b: (stop(b), move(b, 3)),
    ),
    18: ("output at its limit", {}, accelerate_beyond_the_limit, lambda b: (stop(b), reset(b))),
    19: ("endless motion", {}, lambda b: move(b, 3), stop),
    20: ("control loop closed", {}, lambda b: enable(b, 7), lambda b: enable(b, 0)),
    24: (
        "a waiting command",
        {},
        lambda b: (move(b, 1, 100.0), b.exchange(F, 0x16, 4, b.universal(1, 200.0, 100.0, mode=1))),
        arrive,
    ),
    26: (
        "below the lower software limit",
        {},
        lambda b: travel_past(b, 0, 10.0),
        lambda b: travel_past(b, 0, -10.0),
    ),
    27: (
        "above the upper software limit",
        {},
        lambda b: travel_past(b, 1, -10.0),
        lambda b: travel_past(b, 1, 10.0),
    ),
    28: (
        "the drive reports an error",
        {},
        lambda b: setattr(b.axis, "simulation_not_ready", 1),
        lambda b: setattr(b.axis, "simulation_not_ready", 0),
    ),
    29: (
        "a stop that locks",
        {},
        lambda b: b.exchange(F, 0x16, 4, b.universal(4096)),
        lambda b: b.write(F, 0x18),
    ),
    30: (
        "I/O data invalid",
        {},
        lambda b: setattr(b.axis, "simulation_io_invalid", 1),
        lambda b: setattr(b.axis, "simulation_io_invalid", 0),
    ),
    31: ("an axis error", {}, fail, reset),
}  # fmt: skip
"""Each bit of StateDWord: its cause, parameters for it, what sets it and what clears it."""

ALWAYS = {25: "a single axis is in its own PTP group"}
OF_COUPLINGS = {5: "slave or path axis", 21: "cam table", 22: "cam data", 23: "cam scaling"}


def test_every_status_bit_has_its_cause_or_its_issue() -> None:
    assert sorted([*STATUS_BITS, *ALWAYS, *OF_COUPLINGS]) == list(range(32))


@pytest.mark.parametrize("bit", STATUS_BITS, ids=[f"{b} {r[0]}" for b, r in STATUS_BITS.items()])
def test_status_bit(make_bench: Any, bit: int) -> None:
    _, parameters, cause, end = STATUS_BITS[bit]
    bench = make_bench(**parameters)

    def shown() -> int:
        return int(bench.get(C, 0x81, NUMBER)) >> bit & 1

    for _ in range(2):
        cause(bench)
        bench.run(0.004)
        assert shown() == 1
        end(bench)
        bench.until(lambda: not shown(), 5.0)


def test_bits_without_a_coupling(bench: Any) -> None:
    word = bench.get(C, 0x81, NUMBER)
    assert [bit for bit in OF_COUPLINGS if word >> bit & 1] == []
    assert [bit for bit in ALWAYS if not word >> bit & 1] == []


MODE_BITS = {
    0: (0x4001, 0x0F, FLAG), 1: (0x4001, 0x15, FLAG), 2: (0x4001, 0x13, FLAG),
    3: (0x4001, 0x11, FLAG), 4: (0x4001, 0x29, FLAG), 5: (0x4001, 0x2B, FLAG),
    6: (0x4001, 0x1A, NUMBER), 16: (0x6001, 0x10, FLAG), 17: (0x6001, 0x11, FLAG),
    18: (0x5001, 0x0B, FLAG), 19: (0x5001, 0x0C, FLAG), 20: (0x5001, 0x16, FLAG),
    13: (0x7001, 0x110, NUMBER), 21: (0x4001, 0x20, FLAG), 22: (0x4001, 0x21, FLAG),
}  # fmt: skip
"""Each bit of OpModeDWord that is a parameter, and where that parameter is."""


@pytest.mark.parametrize("bit", MODE_BITS)
def test_operation_mode_bit(make_bench: Any, bit: int) -> None:
    bench = make_bench(control_dword=0, encoder_soft_limit_min=-10.0, encoder_soft_limit_max=10.0)
    group, offset, form = MODE_BITS[bit]
    for value in (1, 0, 1):
        bench.put(group, offset, form, value)
        bench.run(0.002)
        assert bench.get(C, 0xB9, NUMBER) >> bit & 1 == value


def test_operation_mode_bits_that_are_no_switch(bench: Any) -> None:
    """7 follows the units, 8 the type of the encoder, 23 is an application asked to home."""
    bench.put(0x5001, 0x107, NUMBER, 20)
    for units in (4, 0):
        bench.put(0x4001, 0x26, NUMBER, units)
        bench.run(0.002)
        assert bench.get(C, 0xB9, NUMBER) >> 7 & 0b11 == 0b10 | units >> 2
    bench.write(F, 0x10)
    bench.run(0.002)
    assert bench.get(C, 0xB9, NUMBER) >> 23 & 1
    bench.put(F, 0x2C, NUMBER, 0)
    bench.run(0.002)
    assert bench.get(C, 0xB9, NUMBER) & ~(1 << 8) == 1 << 0 | 1 << 1 | 1 << 16
