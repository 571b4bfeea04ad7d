"""The ADS device of the camshaft controllers, port 900 (000 §5.5)."""

from collections.abc import Callable, Iterator, Sequence

from achse.ams import DeviceError
from achse.camshaft import CAMS
from achse.codes import ReservedGroup, ReturnCode
from achse.devices.camshaft.rows import CAM_ROWS, CONTROLLER_ROWS, ENCODER_ROWS
from achse.devices.camshaft.served import ServedCamshaft
from achse.devices.camshaft.symbols import CamSymbols
from achse.server import AreaGroup, Device, Group, IndexGroup, ObjectGroup

CAMSHAFT_PORT = 900
"""The AMS port (000 §5.5)."""

_CONTROLLER_STEP = 0x1000
"""Index groups of controller n begin at n times this."""
_ENCODER, _CAM_BASE = 0x1, 0x100

IMAGE_STEP = 0x100
"""In the groups of the process image, controller n begins at (n - 1) times this."""


class CamshaftDevice(Device):
    """Answers for up to four controllers."""

    def __init__(
        self,
        camshafts: Sequence[ServedCamshaft],
        *,
        clock: Callable[[], int],
        task_cycle_ns: int = 1_000_000,
    ) -> None:
        self.camshafts = tuple(camshafts)
        super().__init__(
            "TwinCAT CAM",
            (2, 9, 0),
            self._own_groups(),
            CamSymbols(self.camshafts, _CONTROLLER_STEP, IMAGE_STEP),
            clock=clock,
            task_cycle_ns=task_cycle_ns,
        )

    def _own_groups(self) -> Iterator[IndexGroup]:
        for served in self.camshafts:
            base = served.number * _CONTROLLER_STEP
            yield Group(base, CONTROLLER_ROWS, served)
            yield Group(base + _ENCODER, ENCODER_ROWS, served)
            yield ObjectGroup(base + _CAM_BASE, CAMS, served.cam, CAM_ROWS)
        yield AreaGroup(
            ReservedGroup.INPUTS,
            lambda offset, length: self._at(offset).read_inputs(offset % IMAGE_STEP, length),
            lambda offset, data: self._at(offset).write_inputs(offset % IMAGE_STEP, data),
            name="inputs of the process image",
            description=f"Controller n from (n - 1) * 0x{IMAGE_STEP:X} on (ours; the manual says"
            " the words, 000 §5.5.3)",
        )
        yield AreaGroup(
            ReservedGroup.OUTPUTS,
            lambda offset, length: self._at(offset).read_outputs(offset % IMAGE_STEP, length),
            name="outputs of the process image",
            description="As the inputs; read only",
        )
        yield AreaGroup(
            ReservedGroup.OUTPUT_BITS,
            lambda offset, length: self._at(offset // 8).read_output_bits(
                offset % (8 * IMAGE_STEP), length
            ),
            name="bits of the outputs",
            description="Each bit is read as one byte, 0 or 1; offset = byte * 8 + bit",
        )

    def _at(self, offset: int) -> ServedCamshaft:
        """Return the controller at an offset of the process image."""
        place = offset // IMAGE_STEP
        for served in self.camshafts:
            if served.number == place + 1:
                return served
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{offset:X}: no controller {place + 1}")
