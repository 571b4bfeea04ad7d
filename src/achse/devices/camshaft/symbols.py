"""The symbols of camshaft controllers: every value of the services and of the process image.

`Press.set_rate`, `Press.Encoder.zero_point`, `Press.Cam3.start` (or by the cam's own name),
`Press.Inputs.brake_enable`, `Press.Outputs.cams`, `Press.Tracks.0`.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from typing import Any

from achse.ams import DeviceError
from achse.camshaft import CAMS, CamInput, CamOutput
from achse.camshaft.parameters import TRACKS
from achse.codes import ReservedGroup, ReturnCode
from achse.devices.camshaft.rows import CAM_ROWS, CONTROLLER_ROWS, ENCODER_ROWS
from achse.devices.camshaft.served import ServedCamshaft
from achse.iec import BOOL, DINT, UDINT, USINT, IecType
from achse.iec.datatypes import encode_types
from achse.iec.describe import describe_type
from achse.iec.symbols import SymbolEntry, SymbolFlag, encode_symbols, fold
from achse.server import READ, WRITE, Service, TableSizes

__all__ = ["CamSymbol", "CamSymbols"]

_WORD = 4
_TASK = 1


class CamSymbol:
    """A value by name."""

    call: Callable[[bytes], bytes] | None = None
    context = _TASK

    def __init__(
        self,
        name: str,
        type: IecType[Any],
        place: tuple[int, int],
        read: Callable[[], bytes],
        write: Callable[[bytes], None] | None = None,
        comment: str = "",
    ) -> None:
        self.name = name
        self.type = type
        self.index_group, self.index_offset = place
        self.size = type.size
        self.read = read
        self.read_only = write is None
        self.write = write or _refuse
        self.comment = comment

    def entry(self) -> bytes:
        return self.table_entry().encode()

    def table_entry(self) -> SymbolEntry:
        """The symbol as the table shows it."""
        return SymbolEntry.of(
            self.name,
            self.type,
            *(self.index_group, self.index_offset),
            flags=int(SymbolFlag.READ_ONLY) if self.read_only else 0,
            context=self.context,
            comment=self.comment,
        )


def _refuse(data: bytes) -> None:
    raise DeviceError(ReturnCode.INVALID_ACCESS, "the symbol is read only")


def _type_of(row: Service) -> IecType[Any] | None:
    """The type of a row with one number; None for complete sets."""
    codecs = row.codec if isinstance(row.codec, tuple) else (row.codec,)
    words = getattr(codecs[0], "name", "")
    if words == "UINT8":
        return BOOL if row.maximum == 1 else USINT
    return {"UINT32": UDINT, "INT32": DINT}.get(words)


class CamSymbols:
    """All symbols of one device. `step` and `image_step`: where controllers have their groups."""

    version = 1

    def __init__(self, camshafts: Sequence[ServedCamshaft], step: int, image_step: int) -> None:
        self._camshafts = camshafts
        self._step = step
        self._image_step = image_step

    def resolve(self, name: str) -> CamSymbol | None:
        """A symbol by its name in any case."""
        return self._symbols.get(fold(name.strip()))

    def upload_info(self) -> TableSizes:
        return TableSizes(symbol_count=len(self._symbols), type_count=len(_TYPES))

    def symbol_table(self) -> bytes:
        return self._symbol_table

    def type_table(self) -> bytes:
        return self._type_table

    def type_entry(self, name: str) -> bytes | None:
        found = _TYPES.get(fold(name.strip()))
        return None if found is None else describe_type(found).encode()

    @cached_property
    def _symbols(self) -> dict[str, CamSymbol]:
        return {
            fold(symbol.name): symbol for served in self._camshafts for symbol in self._of(served)
        }

    @cached_property
    def _symbol_table(self) -> bytes:
        return encode_symbols(symbol.table_entry() for symbol in self._symbols.values())

    @cached_property
    def _type_table(self) -> bytes:
        return encode_types(map(describe_type, _TYPES.values()))

    def _of(self, served: ServedCamshaft) -> Iterator[CamSymbol]:
        name, base = served.name, served.number * self._step
        yield from _of_rows(name, CONTROLLER_ROWS, base, served)
        yield from _of_rows(f"{name}.Encoder", ENCODER_ROWS, base + 1, served)
        for number in range(1, CAMS + 1):
            cam = served.cam(number)
            for own in (f"Cam{number}", served.cam_names.get(number)):
                if own:
                    yield from _of_rows(f"{name}.{own}", CAM_ROWS, base + 0x100 + number, cam)
        first = (served.number - 1) * self._image_step
        for word in CamInput:
            at = word * _WORD
            yield CamSymbol(
                f"{name}.Inputs.{word.name.lower()}",
                UDINT,
                (ReservedGroup.INPUTS, first + at),
                partial(served.read_inputs, at, _WORD),
                partial(served.write_inputs, at),
            )
        for output in CamOutput:
            at = output * _WORD
            yield CamSymbol(
                f"{name}.Outputs.{output.name.lower()}",
                UDINT,
                (ReservedGroup.OUTPUTS, first + at),
                partial(served.read_outputs, at, _WORD),
            )
        for track in range(TRACKS):
            at = CamOutput.CAMS * _WORD
            yield CamSymbol(
                f"{name}.Tracks.{track}",
                BOOL,
                (ReservedGroup.OUTPUT_BITS, (first + at) * 8 + track),
                partial(_track, served, track),
            )


def _track(served: ServedCamshaft, track: int) -> bytes:
    return bytes((served.controller.record.outputs >> track & 1,))


def _of_rows(name: str, rows: Sequence[Service], group: int, target: object) -> Iterator[CamSymbol]:
    for row in rows:
        type = _type_of(row)
        if type is None or READ not in row.access:
            continue

        def read(row: Service = row, size: int = type.size) -> bytes:
            return row.encoder(size)(row.get(target))

        def write(data: bytes, row: Service = row) -> None:
            row.set(target, row.decode(data))

        yield CamSymbol(
            *(f"{name}.{row.name}", type, (group, row.offset), read),
            write if WRITE in row.access else None,
            row.description,
        )


_TYPES: dict[str, IecType[Any]] = {fold(each.name): each for each in (BOOL, DINT, UDINT, USINT)}
