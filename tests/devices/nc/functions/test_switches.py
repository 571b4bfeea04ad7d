"""Reset and enables over ADS."""

from typing import Any

F = 0x4201


REAL, FLAG, NUMBER = "<d", "<H", "<I"


def test_reset_clears_an_error_and_is_no_error_without_one(bench: Any, refused: Any) -> None:
    bench.write(F, 0x01)
    bench.put(F, 0x19, NUMBER, 0x4655)
    bench.run(0.01)
    with refused(0x4655):
        bench.start(10.0, 10.0)
    bench.write(F, 0x01)
    bench.run(0.01)
    bench.start(10.0, 10.0)


def test_a_disabled_axis_takes_no_command(bench: Any, refused: Any) -> None:
    bench.write(F, 0x50)
    bench.run(0.01)
    assert bench.get(0x4101, 0x51, FLAG) == 1
    assert bench.get(0x4301, 0x82, FLAG) == 0
    with refused(0x4052):
        bench.start(10.0, 10.0)
    bench.write(F, 0x51)
    bench.run(0.01)
    bench.start(10.0, 10.0)
    with refused(0x4220):
        bench.write(F, 0x50)


def test_without_drive_output_no_start(bench: Any, refused: Any) -> None:
    bench.write(F, 0x60)
    bench.run(0.01)
    assert bench.get(0x4301, 0x81, NUMBER) & 1 << 20 == 0
    with refused(0x4260):
        bench.start(10.0, 10.0)
    bench.write(F, 0x61)
    bench.run(0.01)
    bench.start(10.0, 10.0)


def test_enables_that_are_withdrawn_during_a_move(make_bench: Any) -> None:
    for control, start_type, error in ((6, 3, 0x4260), (5, 3, 0x4358), (3, 4, 0x4357)):
        bench = make_bench()
        bench.start(0.0, 100.0, start_type=start_type)
        bench.run(1.0)
        bench.put(0x4301, 0x01, NUMBER, control)
        bench.until_rest()
        assert bench.get(0x4101, 0x01, NUMBER) == error
