"""Motors that are switched: two speeds with a brake, and steppers."""

from typing import Any

import pytest

TWO_SPEEDS, STEPPER = 2, 3
MINUS_HIGH, MINUS_LOW, PLUS_LOW, PLUS_HIGH, BRAKE = 1, 2, 4, 8, 128
MASKS = (1, 4, 2, 8)


@pytest.mark.parametrize(
    ("control", "velocity"),
    [(PLUS_HIGH, 100.0), (PLUS_LOW, 20.0), (MINUS_LOW, -20.0), (MINUS_HIGH, -100.0), (0, 0.0)],
)
def test_two_speeds_in_two_directions(make_machine: Any, control: int, velocity: float) -> None:
    bench = make_machine(
        kind=TWO_SPEEDS, full_velocity=100.0, creep_velocity=0.2, time_constant=0.0
    )
    bench.run(3, ctrl1=control)
    assert bench.machine.velocity == velocity
    bench.amplifier.motor_inverted = 1
    bench.run(3)
    assert bench.machine.velocity == -velocity
    bench.run(1, ctrl1=control | BRAKE)
    assert bench.machine.velocity == 0.0


def stepper(make_machine: Any) -> Any:
    bench = make_machine(kind=STEPPER, step=0.5, mask_count=4, mask_bits=15)
    for n, mask in enumerate(MASKS):
        bench.amplifier.masks[n] = mask
    bench.drive.ctrl1 = MASKS[0]
    return bench


def test_a_stepper_turns_with_its_field(make_machine: Any) -> None:
    bench = stepper(make_machine)
    for n in range(1, 7):
        bench.run(1, ctrl1=MASKS[n % 4])
        assert bench.machine.position == pytest.approx(0.5 * n)
    for n in range(5, -4, -1):
        bench.run(1, ctrl1=MASKS[n % 4] | 16)  # bits beyond the excitation are another matter
        assert bench.machine.position == pytest.approx(0.5 * n)
    bench.run(1, ctrl1=MASKS[(-3 + 2) % 4])  # the field jumps over a pole: where to?
    assert bench.machine.position == pytest.approx(-1.5)


def test_a_stepper_with_a_frequency(make_machine: Any, dt: float) -> None:
    bench = make_machine(kind=STEPPER, step=0.5)
    for n in range(1, 9):
        bench.run(5, ctrl2=(n % 2) | 2)
    assert bench.machine.position == pytest.approx(4.0)
    assert bench.machine.velocity == pytest.approx(0.5 / (5 * dt))
    for n in range(9, 13):
        bench.run(5, ctrl2=n % 2)
    assert bench.machine.position == pytest.approx(2.0)
    bench.run(20)
    assert bench.machine.velocity == 0.0
