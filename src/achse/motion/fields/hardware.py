"""Fields that lead to the hardware: the I/O structures of encoder and drive."""

from achse.motion.fields.declare import Field, Memory
from achse.motion.port import DRIVE_IO, ENCODER_IO, DriveIo, EncoderIo
from achse.native.declare import reference

__all__ = ["HardwareLinks"]


class HardwareLinks(Memory):
    """The structures that the axis works with."""

    encoder_io: EncoderIo = reference(ENCODER_IO, Field)
    drive_io: DriveIo = reference(DRIVE_IO, Field)
