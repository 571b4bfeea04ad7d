"""The services of encoder, controller and cams (000 §5.5.2), made from the parameters.

The manual's `UINT8[n]` without n: the numbers of the encoder are INT32 (INT16 is taken too), sets
have the layouts of decision 0048. A length that is none of these is 0x705, a value outside 0x70B.
"""

import struct
from collections.abc import Callable

from achse.camshaft.parameters import (
    CAM_PARAMETERS,
    CAM_SET,
    CONTROLLER_PARAMETERS,
    CONTROLLER_SET,
    ENCODER_PARAMETERS,
    ENCODER_SET,
    CamParameter,
    CamSet,
)
from achse.codes import ReturnCode
from achse.devices.camshaft.served import ServedCam, ServedCamshaft
from achse.server import READ, WRITE, Layout, Service
from achse.server.rows import Codecs

_SOURCE = "000 §5.5.2"


def codec_of(parameter: CamParameter) -> Codecs:
    """Return the codecs of a parameter's value: a DINT is also accepted as an INT."""
    codec = Layout("<" + parameter.code)
    return (codec, Layout("<h")) if parameter.code == "i" else codec


def _row(parameter: CamParameter) -> Service:
    """Return a value of a controller or its encoder."""

    def read(served: ServedCamshaft) -> int:
        return served.controller.value(parameter)

    def write(served: ServedCamshaft, value: int) -> None:
        served.set_value(parameter, value)

    return _service(parameter, read, write)


def _cam_row(parameter: CamParameter) -> Service:
    """Return a value of a cam."""
    name = parameter.name

    def read(cam: ServedCam) -> int:
        return int(getattr(cam.record, name))

    def write(cam: ServedCam, value: int) -> None:
        cam.set_value(parameter, value)

    return _service(parameter, read, write)


def _service(
    parameter: CamParameter, read: Callable[..., int], write: Callable[..., None]
) -> Service:
    limits = 2 ** (8 * struct.calcsize(parameter.code))
    return Service(
        parameter.offset,
        parameter.name,
        READ | WRITE if parameter.writable else READ,
        codec_of(parameter),
        parameter.text,
        parameter.unit,
        read=read,
        write=write if parameter.writable else None,
        minimum=parameter.least if parameter.writable else None,
        maximum=parameter.most if parameter.writable and parameter.most < limits - 1 else None,
        code=ReturnCode.INVALID_PARAMETER,
        source=_SOURCE,
    )


def _set_row(
    offset: int,
    layout: CamSet,
    text: str,
    read: Callable[..., bytes],
    write: Callable[..., None],
) -> Service:
    return Service(
        *(offset, "complete_set", READ | WRITE, Layout(f"<{layout.size}s"), text),
        read=read,
        write=write,
        source=_SOURCE,
    )


ENCODER_ROWS = (
    _set_row(
        *(0x200, ENCODER_SET, "Zero point, offset, box address, 3 unused"),
        lambda served: served.controller.encoder_set(),
        ServedCamshaft.write_encoder_set,
    ),
    *map(_row, ENCODER_PARAMETERS),
)

CONTROLLER_ROWS = (
    _set_row(
        *(0x0, CONTROLLER_SET, "All values below, in this order; error flags are reset"),
        lambda served: served.controller.controller_set(),
        ServedCamshaft.write_controller_set,
    ),
    *map(_row, CONTROLLER_PARAMETERS),
)

CAM_ROWS = (
    _set_row(
        *(0x0, CAM_SET, "Type, seven flags, nine numbers; the way to set the type"),
        ServedCam.set,
        ServedCam.write_set,
    ),
    *map(_cam_row, CAM_PARAMETERS),
)
