"""The process image of a bus as an ADS device: port 27904 + device id, variables by symbol.

Inputs and outputs are read only: the tasks that have them write them in each cycle.
"""

from collections.abc import Callable, Iterator

from achse.ams import DeviceError
from achse.codes import ReservedGroup, ReturnCode
from achse.devices.io.image import INPUT_BASE, OUTPUT_BASE, BusImage, distinct
from achse.devices.io.served import ServedBus
from achse.devices.value_symbols import ValueSymbol, ValueSymbols
from achse.server import AreaGroup, Device, IndexGroup

IMAGE_PORT = 27904
"""0x6D00; the image of device n answers at this + n."""

_GROUPS = (
    (False, ReservedGroup.INPUTS, ReservedGroup.INPUT_BITS, INPUT_BASE, "inputs"),
    (True, ReservedGroup.OUTPUTS, ReservedGroup.OUTPUT_BITS, OUTPUT_BASE, "outputs"),
)


class ImageSymbols(ValueSymbols):
    """The symbols of one image."""

    def __init__(self, image: BusImage) -> None:
        self._image = image

    def refresh(self, image: BusImage) -> None:
        """Replace the image by another one."""
        self._image = image
        self.forget()

    def all_symbols(self) -> Iterator[ValueSymbol]:
        """Yield the variables, those of one name made distinct."""
        for name, each in distinct(self._image.variables):
            yield ValueSymbol(name, each.type, each.place, each.read, comment=each.comment)


class BusImageDevice(Device):
    """Answers for the image of one bus."""

    def __init__(self, bus: ServedBus, *, clock: Callable[[], int]) -> None:
        self.image = BusImage(bus)
        self._bus = bus
        self._of_image = ImageSymbols(self.image)
        super().__init__(
            f"{bus.name} image",
            (3, 1, 0),
            self._own_groups(),
            self._of_image,
            clock=clock,
            task_cycle_ns=bus.master.bus.cycle_ns,
        )
        bus.on_renewal(self._renew)

    def _renew(self) -> None:
        """List the variables of other slaves, under another version of the table."""
        self.image = BusImage(self._bus)
        self._of_image.refresh(self.image)
        self.symbols_changed()

    def _own_groups(self) -> Iterator[IndexGroup]:
        for output, whole, bits, base, name in _GROUPS:

            def read(offset: int, length: int, output: bool = output, base: int = base) -> bytes:
                return _part(self.image.contents(output), offset - base, length)

            def read_bits(
                offset: int, length: int, output: bool = output, base: int = base
            ) -> bytes:
                contents = self.image.contents(output)
                first = offset - 8 * base
                part = _part(contents, first >> 3, (first & 7) + length + 7 >> 3)
                number = int.from_bytes(part, "little") >> (first & 7)
                return bytes(number >> bit & 1 for bit in range(min(length, 8 * len(part))))

            yield AreaGroup(
                whole,
                read,
                name=f"{name} of the bus",
                description=f"From 0x{base:X} on; a variable is at the place of its symbol",
                source="achse",
            )
            yield AreaGroup(
                bits,
                read_bits,
                name=f"bits of the {name}",
                description=f"From 0x{8 * base:X} on; each bit is read as one byte, 0 or 1",
                source="achse",
            )


def _part(contents: bytes, first: int, length: int) -> bytes:
    if not 0 <= first < len(contents):
        raise DeviceError(
            ReturnCode.INVALID_OFFSET, f"the image has {len(contents)} bytes, got byte {first}"
        )
    return contents[first : first + length]
