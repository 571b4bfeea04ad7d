"""The kernels of servos in machine code; they need llvmlite."""

from achse.motion.servo.exchange import send_image, take_image
from achse.motion.servo.record import SERVO, Servo
from achse.native.compiled import Kernel

TAKE = Kernel("servo-inputs", take_image, {Servo: SERVO})
SEND = Kernel("servo-outputs", send_image, {Servo: SERVO})
"""Called with address and number of the records, of their words and of the image, and the cycle
time in seconds."""
