"""Fields of the simulated machine: what stands along the axis, and the inputs it is wired to.

Places are in axis units, in the direction of the axis, from where its encoder counts 0.
"""

from achse.motion.fields.declare import Memory, Parameters, real, whole

__all__ = ["MachineMemory", "MachineParameters"]


class MachineParameters(Parameters):
    """Limit switches, reference cam, probe mark and index pulse; configuration only, no service."""

    simulation_limit_min: float = real(
        -1e15, "mm", "from where on a hardware limit switch blocks the drive, negative direction"
    )
    simulation_limit_max: float = real(
        1e15, "mm", "from where on a hardware limit switch blocks the drive, positive direction"
    )

    simulation_period: float = real(
        0.0,
        "mm",
        "way after which the machine repeats itself, as a rotary table does; 0 = never",
        0.0,
    )
    simulation_cam_begin: float = real(
        -1e6, "mm", "where the reference cam begins; none if that is after its end"
    )
    simulation_cam_end: float = real(-50.0, "mm", "where the reference cam ends")
    simulation_cam_input: int = whole(
        0, "1", "digital input of the drive the cam is wired to, 0 = that of the PLC", 0, 8
    )
    simulation_mark_begin: float = real(100.0, "mm", "where the probe mark begins")
    simulation_mark_end: float = real(110.0, "mm", "where the probe mark ends")
    simulation_mark_input: int = whole(
        0, "1", "digital input of the drive that sees the mark, 0 = none", 0, 8
    )
    simulation_turn: float = real(
        65_536.0, "INC", "increments per motor turn, with one index pulse", 1.0, 1e12
    )
    simulation_index_position: float = real(0.0, "INC", "count at an index pulse")
    simulation_latch_source: int = whole(
        128, "SignalSource", "what the drive itself latches on: input 1..8, 128 index pulse", 1, 128
    )


class MachineMemory(Memory):
    """What the simulated machine derives from its parameters."""

    valve_first: int = whole(0, "1", "first piece of the curve of the valve")
    valve_count: int = whole(0, "1", "its pieces, 0 = it is the inverse of the NC's characteristic")
