"""Fields of the cyclic interface from the PLC."""

from achse.motion.fields.declare import Inputs, real, whole


class CyclicInput(Inputs):
    """Values that the PLC writes each of its cycles (002 §6.4.4.4, 0x4300 + ID; 004 §5.1.2)."""

    control_dword: int = whole(0, "bits", "bit 0 enable, 1 feed enable plus, 2 minus, 5 homing cam")
    velocity_override: int = whole(0, "1e-6", "velocity override, 1000000 = 100 %")
    operation_mode: int = whole(0, "1", "requested operation mode")
    operation_mode_dword: int = whole(0, "1", "further data of the operation mode")
    operation_mode_value: float = real(
        0.0, "1", "further data of the operation mode; gear ratio of slave type 15"
    )
    actual_position_correction: float = real(0.0, "mm", "to be added to the actual position")
    external_controller_component: float = real(
        0.0, "mm/s", "output of an external position controller, added"
    )
    gear_ratio_1: float = real(0.0, "1", "gear ratio to master 1")
    gear_ratio_2: float = real(0.0, "1", "gear ratio to master 2")
    gear_ratio_3: float = real(0.0, "1", "gear ratio to master 3")
    gear_ratio_4: float = real(0.0, "1", "gear ratio to master 4")


class ExternalSetPoint(Inputs):
    """Set point of the external generator, from the PLC."""

    position: float = real(0.0, "mm", "set position of the external generator")
    velocity: float = real(0.0, "mm/s", "set velocity of the external generator")
    acceleration: float = real(0.0, "mm/s²", "set acceleration of the external generator")
    direction: int = whole(0, "1", "direction of the external generator", -1, 1)
    torque: float = real(0.0, "1000 = 100 %", "set torque of the external generator")
    jerk: float = real(0.0, "mm/s³", "set jerk of the external generator")
    torque_derivative: float = real(0.0, "1000 = 100 %/s", "change of its set torque")
