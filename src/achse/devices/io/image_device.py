"""The process image of a bus as an ADS device: port 27904 + device id, variables by symbol.

Inputs and outputs are read only: the tasks that have them write them in each cycle.
"""

from collections.abc import Callable, Iterator

from achse.ams import DeviceError
from achse.codes import ReservedGroup, ReturnCode
from achse.devices.io.image import INPUT_BASE, OUTPUT_BASE, BusImage, ImageVariable, distinct
from achse.devices.io.served import ServedBus
from achse.iec.datatypes import encode_types
from achse.iec.describe import describe_type, types_within
from achse.iec.symbols import SymbolEntry, SymbolFlag, encode_symbols, fold
from achse.server import AreaGroup, Device, IndexGroup, TableSizes

__all__ = ["IMAGE_PORT", "BusImageDevice", "ImageSymbol", "ImageSymbols"]

IMAGE_PORT = 27904
"""0x6D00; the image of device n answers at this + n."""

_TASK = 1
_GROUPS = (
    (False, ReservedGroup.INPUTS, ReservedGroup.INPUT_BITS, INPUT_BASE, "inputs"),
    (True, ReservedGroup.OUTPUTS, ReservedGroup.OUTPUT_BITS, OUTPUT_BASE, "outputs"),
)


class ImageSymbol:
    """A variable of the image by name."""

    call: Callable[[bytes], bytes] | None = None
    context = _TASK
    read_only = True

    def __init__(self, name: str, variable: ImageVariable) -> None:
        self.name = name
        self.type = variable.type
        self.size = variable.type.size
        self.comment = variable.comment
        self.index_group, self.index_offset = variable.place
        self.read = variable.read

    def write(self, data: bytes) -> None:
        """Refuses: DeviceError 0x704."""
        raise DeviceError(ReturnCode.INVALID_ACCESS, f"{self.name} is read only")

    def entry(self) -> bytes:
        return self.table_entry().encode()

    def table_entry(self) -> SymbolEntry:
        """The symbol as the table shows it."""
        return SymbolEntry.of(
            self.name,
            self.type,
            *(self.index_group, self.index_offset),
            flags=int(SymbolFlag.READ_ONLY),
            context=self.context,
            comment=self.comment,
        )


class ImageSymbols:
    """The symbols of one image."""

    def __init__(self, image: BusImage) -> None:
        self.version = 0
        self.refresh(image)

    def refresh(self, image: BusImage) -> None:
        """Those of another image."""
        self.version = self.version % 255 + 1
        symbols = [ImageSymbol(name, each) for name, each in distinct(image.variables)]
        self._symbols = {fold(symbol.name): symbol for symbol in symbols}
        self._types = {fold(each.name): each for each in types_within([s.type for s in symbols])}
        self._symbol_table = encode_symbols(symbol.table_entry() for symbol in symbols)
        self._type_table = encode_types(map(describe_type, self._types.values()))

    def resolve(self, name: str) -> ImageSymbol | None:
        """A symbol by its name in any case."""
        return self._symbols.get(fold(name.strip()))

    def upload_info(self) -> TableSizes:
        return TableSizes(symbol_count=len(self._symbols), type_count=len(self._types))

    def symbol_table(self) -> bytes:
        return self._symbol_table

    def type_table(self) -> bytes:
        return self._type_table

    def type_entry(self, name: str) -> bytes | None:
        found = self._types.get(fold(name.strip()))
        return None if found is None else describe_type(found).encode()


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
        """Other slaves: other variables, under another version of the table."""
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
                description=f"From 0x{base:X} on; where a variable is, its symbol tells",
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
