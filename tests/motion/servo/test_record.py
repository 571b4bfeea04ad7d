"""The record of a servo."""

from achse.motion.port import DRIVE_IO, ENCODER_IO
from achse.motion.servo.record import ENTRIES, PROBES, SERVO, servo_record


def test_it_refers_to_the_structures_of_an_axis_and_to_nothing_else() -> None:
    links = {name: row.refers for name, row in SERVO.fields.items() if row.refers}
    assert links == {"encoder": ENCODER_IO, "drive": DRIVE_IO}


def test_a_fresh_one_is_not_valid_and_sends_nothing() -> None:
    servo = servo_record()
    assert (servo.valid, servo.controlword, servo.following) == (0, 0, 0)
    assert len(servo.input_at) == len(servo.output_at) == ENTRIES
    assert len(servo.probe_armed) == PROBES
