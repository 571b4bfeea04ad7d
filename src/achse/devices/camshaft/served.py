"""A camshaft controller as it is served: with its names and its wake-up."""

from collections.abc import Callable, Mapping
from typing import Any

from achse.ams import DeviceError
from achse.camshaft import CAMS, CamController, CamParameter
from achse.camshaft.image import INPUTS, OUTPUTS
from achse.camshaft.parameters import CamParameterError
from achse.codes import ReturnCode


class ServedCamshaft:
    """A controller behind the services. `wake()` is called before each access: a controller
    that does nothing need not calculate."""

    def __init__(
        self,
        controller: CamController,
        name: str = "",
        cam_names: Mapping[int, str] | None = None,
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        self.name = name or f"Camshaft {controller.number}"
        self.cam_names = dict(cam_names or {})
        self.wake = wake
        self._controller = controller
        self._cams = [ServedCam(self, number) for number in range(1, CAMS + 1)]

    @property
    def number(self) -> int:
        """1..4, in order of the index groups."""
        return self._controller.number

    @property
    def controller(self) -> CamController:
        """The controller, awake."""
        self.wake()
        return self._controller

    def cam(self, number: int) -> "ServedCam":
        """Cam 1..128. Raises DeviceError 0x702 for another: each cam has an index group."""
        if not 1 <= number <= CAMS:
            raise DeviceError(ReturnCode.INVALID_GROUP, f"cam {number}, expected 1..{CAMS}")
        return self._cams[number - 1]

    def set_value(self, parameter: CamParameter, value: int) -> None:
        """Set a parameter of controller or encoder. Raises DeviceError 0x70B."""
        with _Checked():
            self.controller.set_value(parameter, value)

    def write_encoder_set(self, data: bytes) -> None:
        """Take the encoder's complete set. Raises DeviceError 0x70B."""
        with _Checked():
            self.controller.write_encoder_set(data)

    def write_controller_set(self, data: bytes) -> None:
        """Take the controller's complete set. Raises DeviceError 0x70B."""
        with _Checked():
            self.controller.write_controller_set(data)

    def read_inputs(self, offset: int, length: int) -> bytes:
        """Return bytes of the process image's inputs. Raises DeviceError 0x703 outside."""
        return _part(self.controller.inputs(), INPUTS.size, offset, length)

    def write_inputs(self, offset: int, data: bytes) -> None:
        """Write inputs. Raises DeviceError 0x703 outside, 0x705 for too many bytes."""
        if offset >= INPUTS.size:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{offset:X}")
        if not data or offset + len(data) > INPUTS.size:
            raise DeviceError(
                ReturnCode.INVALID_SIZE,
                f"1..{INPUTS.size - offset} bytes from 0x{offset:X}, got {len(data)}",
            )
        self.controller.write_inputs(offset, data)

    def read_outputs(self, offset: int, length: int) -> bytes:
        """Return bytes of the process image's outputs. Raises DeviceError 0x703 outside."""
        return _part(self.controller.outputs(), OUTPUTS.size, offset, length)

    def read_output_bits(self, number: int, count: int) -> bytes:
        """Bits of the outputs from `number` (byte * 8 + bit) on, a byte 0 or 1 for each. Raises
        DeviceError 0x703 outside."""
        bits = 8 * OUTPUTS.size
        if number >= bits:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{number:X}, there are {bits} bits")
        image = self.controller.outputs()
        wanted = range(number, min(number + count, bits))
        return bytes(image[bit >> 3] >> (bit & 7) & 1 for bit in wanted)


def _part(image: bytes, size: int, offset: int, length: int) -> bytes:
    if offset >= size:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{offset:X}, the image has {size} bytes")
    return image[offset : offset + length]


class ServedCam:
    """One cam of a controller."""

    __slots__ = ("_of", "number")

    def __init__(self, of: ServedCamshaft, number: int) -> None:
        self._of = of
        self.number = number

    @property
    def record(self) -> Any:
        """The cam's fields."""
        return self._of.controller.cams[self.number - 1]

    def set_value(self, parameter: CamParameter, value: int) -> None:
        """Set a parameter. Raises DeviceError 0x70B."""
        with _Checked():
            self._of.controller.set_cam(self.number, {parameter.name: value})

    def set(self) -> bytes:
        """Return the complete set."""
        return self._of.controller.cam_set(self.number)

    def write_set(self, data: bytes) -> None:
        """Take the complete set, with the type. Raises DeviceError 0x70B; nothing is set then."""
        with _Checked():
            self._of.controller.write_cam_set(self.number, data)


class _Checked:
    """Context manager that refuses values outside their range with 0x70B."""

    def __enter__(self) -> None:
        return

    def __exit__(self, kind: object, failure: object, trace: object) -> None:
        if isinstance(failure, CamParameterError):
            raise DeviceError(ReturnCode.INVALID_PARAMETER, str(failure)) from None
