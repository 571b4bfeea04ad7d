"""Fields of a slave that follows cams: one record for each cam that is added up."""

from achse.motion.fields.declare import InternalFields, flag, real, whole, wholes

__all__ = ["CAM_LAYERS", "CAM_LIST", "CamChange", "CamMotion", "CamSlave"]

CAM_LAYERS = 4
"""Cams that one slave can follow at the same time (error 0x425E)."""

CAM_LIST = 8
"""Tables that a slave of several cams may name beside its first (002, function 0x45)."""


class CamMotion(InternalFields):
    """A cam at work: where it lies, how its positions become those of axes, and where it is."""

    table: int = whole(0, "1", "id of the table at work, 0 = none yet")
    cam: int = whole(0, "1", "where it begins in memory")
    interpolation: int = whole(0, "CamInterpolation", "how its rows are joined")
    master: int = whole(0, "1", "row of its master")
    master_absolute: int = flag(0, "its master positions are those of the axis")
    slave_absolute: int = flag(0, "its slave positions are those of the axis")
    master_reference: float = real(0.0, "mm", "master position from which it counts")
    slave_reference: float = real(0.0, "mm", "slave position from which it counts")
    master_offset: float = real(0.0, "mm", "where the cam begins, counted from the reference")
    slave_offset: float = real(0.0, "mm", "added to the slave position")
    master_scaling: float = real(1.0, "1", "master axis units for one of the cam")
    slave_scaling: float = real(1.0, "1", "slave axis units for one of the cam")
    base_cycle: int = whole(0, "1", "number of the cycle in which it began", -1e15, 1e15)
    cycle: int = whole(0, "1", "number of the cycle in which it was", -1e15, 1e15)
    once: int = flag(0, "a correction: it runs once and its stroke remains")
    near: int = whole(0, "1", "row at which it was")
    seen: float = real(0.0, "mm", "master position of the last cycle")
    cam_position: float = real(0.0, "mm", "master position within the cam")
    value: float = real(0.0, "mm", "slave position of the cam, without lift")
    strokes: float = real(0.0, "mm", "lift of the cycles so far")
    part: float = real(0.0, "mm", "what it adds to the slave position")
    slope: float = real(0.0, "1", "slave velocity for a master velocity of 1")


class CamChange(InternalFields):
    """What is to happen to a cam, and when."""

    next_kind: int = whole(0, "1", "0 nothing, else what: see achse.motion.couplings.cams")
    next_when: int = whole(0, "CamActivation", "when")
    next_returns: int = flag(0, "other points are for one cycle, and what waits are those before")
    next_position: float = real(0.0, "mm", "at this position")
    next_table: int = whole(0, "1", "id of the table that comes, 0 = it stays")
    next_cam: int = whole(0, "1", "where that begins in memory")
    next_interpolation: int = whole(0, "CamInterpolation", "how its rows are joined")
    next_master_absolute: int = flag(0, "its master positions are those of the axis")
    next_slave_absolute: int = flag(0, "its slave positions are those of the axis")
    next_master_type: int = whole(0, "CamScaling", "where master offset and scaling come from")
    next_slave_type: int = whole(0, "CamScaling", "where slave offset and scaling come from")
    next_master_offset: float = real(0.0, "mm", "as commanded")
    next_slave_offset: float = real(0.0, "mm", "as commanded")
    next_master_scaling: float = real(1.0, "1", "as commanded")
    next_slave_scaling: float = real(1.0, "1", "as commanded")


class CamSlave(InternalFields):
    """What a slave of cams is at."""

    cam_count: int = whole(0, "1", "layers that may be in use")
    cam_changes: int = flag(0, "a layer waits for a change")
    cam_list: list[int] = wholes(
        CAM_LIST, "1", "tables that were named at coupling: its corrections and profiles; 0 = none"
    )
    cam_status: int = whole(0, "StateBit", "bits of StateDWord: what waits")
