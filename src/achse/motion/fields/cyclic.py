"""Fields of the cyclic interface from the PLC."""

from achse.motion.fields.declare import Inputs, whole

__all__ = ["CyclicInput"]


class CyclicInput(Inputs):
    """What the PLC writes each of its cycles (002 §6.4.4.4, 0x4300 + ID)."""

    control_dword: int = whole(0, "bits", "bit 0 enable, 1 feed enable plus, 2 minus, 5 homing cam")
    velocity_override: int = whole(0, "1e-6", "velocity override, 1000000 = 100 %")
