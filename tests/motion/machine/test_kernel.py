"""The cycle of machines: whose drive moves the motor, and what is passed over."""

from achse.motion.machine.hardware import Hardware

VELOCITY = 2


def test_one_drive_moves_the_motor_and_all_encoders_see_it() -> None:
    hardware = Hardware(1, 2, 2, compiled=False)
    machine = hardware.build(2, 2)
    sensors, drives = machine.sensors, machine.amplifiers
    sensors[1].encoder_resolution = 1e-3
    for number, drive in enumerate(drives):
        drive.velocity_weight = 1.0
        drive.time_constant = 0.0
        drive.io.ctrl1, drive.io.ctrl3, drive.io.data_out2 = 1, VELOCITY, 100 * (number + 1)
    machine.driver = 1
    for _ in range(10):
        drives[1].io.fresh = 1
        hardware.step(0.001)
    assert machine.velocity == 200.0
    assert [sensor.io.data_in1 for sensor in sensors] == [20_000, 2_000]
    assert [drive.io.state1 & 2 for drive in drives] == [0, 2]
