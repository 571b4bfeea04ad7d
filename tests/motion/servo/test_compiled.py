"""The kernels of servos in machine code; that they compute the same is tested beside `Servos`."""

from achse.motion.servo.compiled import SEND, TAKE


def test_no_drives_are_no_work() -> None:
    for kernel in (TAKE, SEND):
        kernel.function(0, 0, 0, 0, 0, 0, 0.002)
