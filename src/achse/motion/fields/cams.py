"""Fields of a slave that follows cams: one record for each cam that is added up."""

from achse.motion.fields.declare import InternalFields, flag, ints, real, whole

CAM_LAYERS = 4
"""Cams that one slave can follow at the same time (error 0x425E)."""

CAM_LIST = 8
"""Tables that a slave of several cams may name beside its first (002, function 0x45)."""


class CamLaw(InternalFields):
    """Cam that a slave follows, and how its positions become those of axes."""

    table: int = whole(0, "1", "id of the table, 0 = none")
    cam: int = whole(0, "1", "where it begins in memory")
    interpolation: int = whole(0, "CamInterpolation", "how its rows are joined")
    master_absolute: int = flag(0, "its master positions are those of the axis")
    slave_absolute: int = flag(0, "its slave positions are those of the axis")
    master_reference: float = real(0.0, "mm", "master position from which it counts")
    slave_reference: float = real(0.0, "mm", "slave position from which it counts")
    master_offset: float = real(0.0, "mm", "where the cam begins, counted from the reference")
    slave_offset: float = real(0.0, "mm", "added to the slave position")
    master_scaling: float = real(1.0, "1", "master axis units for one of the cam")
    slave_scaling: float = real(1.0, "1", "slave axis units for one of the cam")
    base_cycle: int = whole(0, "1", "number of the cycle in which it began", -1e15, 1e15)


class CamChange(InternalFields):
    """Change that a cam waits for."""

    kind: int = whole(0, "1", "0 nothing, else what: see achse.motion.couplings.cams")
    when: int = whole(0, "CamActivation", "when")
    returns: int = flag(0, "other points are for one cycle, and what waits are those before")
    position: float = real(0.0, "mm", "at this position")
    master_type: int = whole(0, "CamScaling", "where master offset and scaling come from")
    slave_type: int = whole(0, "CamScaling", "where slave offset and scaling come from")


class CamMotion(InternalFields):
    """Motion of a cam at work: its master, and where it is."""

    master: int = whole(0, "1", "row of its master")
    once: int = flag(0, "a correction: it runs once and its stroke remains")
    cycle: int = whole(0, "1", "number of the cycle in which it was", -1e15, 1e15)
    near: int = whole(0, "1", "row at which it was")
    last_master_position: float = real(0.0, "mm", "master position of the last cycle")
    cam_position: float = real(0.0, "mm", "master position within the cam")
    value: float = real(0.0, "mm", "slave position of the cam, without lift")
    strokes: float = real(0.0, "mm", "lift of the cycles so far")
    part: float = real(0.0, "mm", "what it adds to the slave position")
    slope: float = real(0.0, "1", "slave velocity for a master velocity of 1")


class CamSlave(InternalFields):
    """Cams of a slave as a whole."""

    count: int = whole(0, "1", "layers that may be in use")
    changes: int = flag(0, "a layer waits for a change")
    tables: list[int] = ints(
        CAM_LIST, "1", "tables named at coupling: its corrections and profiles; 0 = none"
    )
    status: int = whole(0, "StateBit", "bits of StateDWord for pending changes")
