"""The symbols of camshaft controllers: every value of the services and of the process image.

`Press.set_rate`, `Press.Encoder.zero_point`, `Press.Cam3.start` (or by the cam's own name),
`Press.Inputs.brake_enable`, `Press.Outputs.cams`, `Press.Tracks.0`.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

from achse.camshaft import CAMS, CamInput, CamOutput
from achse.camshaft.parameters import TRACKS
from achse.codes import ReservedGroup
from achse.devices.camshaft.rows import CAM_ROWS, CONTROLLER_ROWS, ENCODER_ROWS
from achse.devices.camshaft.served import ServedCamshaft
from achse.devices.value_symbols import ValueSymbol, ValueSymbols
from achse.iec import BOOL, DINT, UDINT, USINT, IecType
from achse.server import READ, WRITE, Service

_WORD = 4
_TASK = 1


def _type_of(row: Service) -> IecType[Any] | None:
    """Return the type of a row with one number; None for complete sets."""
    codecs = row.codec if isinstance(row.codec, tuple) else (row.codec,)
    words = getattr(codecs[0], "name", "")
    if words == "UINT8":
        return BOOL if row.maximum == 1 else USINT
    return {"UINT32": UDINT, "INT32": DINT}.get(words)


class CamSymbols(ValueSymbols):
    """All symbols of one device. `step` and `image_step`: where controllers have their groups."""

    def __init__(self, camshafts: Sequence[ServedCamshaft], step: int, image_step: int) -> None:
        self._camshafts = camshafts
        self._step = step
        self._image_step = image_step

    def all_symbols(self) -> Iterator[ValueSymbol]:
        """Return the symbols of every controller."""
        return (symbol for served in self._camshafts for symbol in self._of(served))

    def used_types(self) -> Iterable[IecType[Any]]:
        """Always all that a value may have."""
        return BOOL, DINT, UDINT, USINT

    def _of(self, served: ServedCamshaft) -> Iterator[ValueSymbol]:
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
            yield ValueSymbol(
                f"{name}.Inputs.{word.name.lower()}",
                UDINT,
                (ReservedGroup.INPUTS, first + at),
                partial(served.read_inputs, at, _WORD),
                partial(served.write_inputs, at),
            )
        for output in CamOutput:
            at = output * _WORD
            yield ValueSymbol(
                f"{name}.Outputs.{output.name.lower()}",
                UDINT,
                (ReservedGroup.OUTPUTS, first + at),
                partial(served.read_outputs, at, _WORD),
            )
        for track in range(TRACKS):
            at = CamOutput.CAMS * _WORD
            yield ValueSymbol(
                f"{name}.Tracks.{track}",
                BOOL,
                (ReservedGroup.OUTPUT_BITS, (first + at) * 8 + track),
                partial(_track, served, track),
            )


def _track(served: ServedCamshaft, track: int) -> bytes:
    return bytes((served.controller.record.outputs >> track & 1,))


def _of_rows(
    name: str, rows: Sequence[Service], group: int, target: object
) -> Iterator[ValueSymbol]:
    for row in rows:
        type = _type_of(row)
        if type is None or READ not in row.access:
            continue

        def read(row: Service = row, size: int = type.size) -> bytes:
            return row.encoder(size)(row.get(target))

        def write(data: bytes, row: Service = row) -> None:
            row.set(target, row.decode(data))

        yield ValueSymbol(
            *(f"{name}.{row.name}", type, (group, row.offset), read),
            write if WRITE in row.access else None,
            row.description,
        )
