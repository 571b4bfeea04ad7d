"""Images of persistent data: all that is kept of axes and PLCs, from one boundary of the cycle.

Taking an image copies bytes and nothing else, so that the cycle waits for little. Names and types
come from its layout, which is right until the next restart or online change.
"""

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from achse.motion import Nc
from achse.motion.retained import RetainedState
from achse.plc import PlcRuntime
from achse.plc.retention.retained import PointerTarget, RetainedLayout, RetainedVariable
from achse.station.configuration.documents import parse_json

_FARTHEST = 1e15
"""Largest position that is exact."""


@dataclass(frozen=True, slots=True)
class PersistentValues:
    """Retained data: of axes by id, of PLCs by port and variable."""

    axes: Mapping[int, RetainedState] = field(default_factory=dict)
    plcs: Mapping[int, Mapping[str, RetainedVariable]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class PersistentLayout:
    """Layout of the bytes of an image."""

    axes: Sequence[tuple[int, int]]
    """Ids and how many encoders they have; each axis is so many zeros, position, homed flag."""
    plcs: Mapping[int, RetainedLayout]
    """Layouts of PLCs by port, behind the axes."""
    absent: PersistentValues
    """Data of PLCs that the station does not have now. Each image has them, unchanged."""

    @classmethod
    def of(
        cls, nc: Nc | None, plcs: Mapping[int, PlcRuntime], values: PersistentValues
    ) -> "PersistentLayout":
        """Return the layout of a station's NC and PLCs; `values` are the values that are stored so
        far."""
        axes = [] if nc is None else [(axis.axis_id, len(axis.encoders)) for axis in nc]
        layouts = {port: RetainedLayout.of(plc) for port, plc in plcs.items()}
        absent = {port: each for port, each in values.plcs.items() if port not in plcs}
        return cls(axes, layouts, PersistentValues(values.axes if nc is None else {}, absent))

    def image(self, nc: Nc | None, plcs: Mapping[int, PlcRuntime]) -> bytes:
        """Return a copy of what these axes and PLCs have now."""
        numbers: list[float] = []
        for remains in () if nc is None else nc.retained_state().values():
            numbers += remains.zeros
            numbers += (remains.position, remains.homed)
        pieces = [struct.pack(f"<{len(numbers)}d", *numbers)]
        pieces += [layout.image(plcs[port].memory) for port, layout in self.plcs.items()]
        return b"".join(pieces)

    def values(self, image: bytes) -> PersistentValues:
        """Return the values in an image. Raises ValueError if it has another length."""
        count = sum(encoders + 2 for _, encoders in self.axes)
        size = 8 * count + sum(layout.size for layout in self.plcs.values())
        if len(image) != size:
            raise ValueError(f"expected {size} bytes, got {len(image)}")
        numbers = struct.unpack_from(f"<{count}d", image)
        axes = dict(self.absent.axes)
        at = 0
        for axis_id, encoders in self.axes:
            zeros = [number(value) for value in numbers[at : at + encoders]]
            position, homed = numbers[at + encoders : at + encoders + 2]
            axes[axis_id] = RetainedState(zeros, number(position), int(homed))
            at += encoders + 2
        plcs = dict(self.absent.plcs)
        begin = 8 * count
        for port, layout in self.plcs.items():
            plcs[port] = layout.variables(image[begin : begin + layout.size])
            begin += layout.size
        return PersistentValues(axes, plcs)

    def encode(self) -> bytes:
        """Return the layout as JSON."""
        document = {
            "axes": self.axes,
            "plcs": {port: layout.document() for port, layout in self.plcs.items()},
            "absent_axes": {
                axis_id: (list(one.zeros), one.position, one.homed)
                for axis_id, one in self.absent.axes.items()
            },
            "absent_plcs": show_variables(self.absent.plcs),
        }
        return json.dumps(document, separators=(",", ":")).encode()

    @classmethod
    def decode(cls, encoded: bytes) -> "PersistentLayout":
        """Return the layout that `encode` wrote. Raises ValueError, KeyError, TypeError."""
        document = parse_json(encoded)
        absent = {
            int(axis_id): RetainedState(
                [number(zero) for zero in zeros], number(position), int(homed)
            )
            for axis_id, (zeros, position, homed) in document["absent_axes"].items()
        }
        return cls(
            [(int(axis_id), int(encoders)) for axis_id, encoders in document["axes"]],
            {int(port): RetainedLayout.parsed(one) for port, one in document["plcs"].items()},
            PersistentValues(absent, parse_variables(document["absent_plcs"])),
        )


@dataclass(frozen=True, slots=True)
class PersistentImage:
    """All persistent data at one station time."""

    layout: PersistentLayout
    content: bytes
    time_ns: int

    def values(self) -> PersistentValues:
        """Return the values by name."""
        return self.layout.values(self.content)

    def is_like(self, other: "PersistentImage | None") -> bool:
        """Return True if the other image has the same layout and content."""
        return other is not None and self.layout is other.layout and self.content == other.content


def show_variables(
    plcs: Mapping[int, Mapping[str, RetainedVariable]],
) -> dict[str, dict[str, tuple[object, ...]]]:
    """Return variables for JSON: type, bytes in hexadecimal digits, pointers."""
    return {
        str(port): {name: (one.type, one.data.hex(), *one.leads) for name, one in variables.items()}
        for port, variables in plcs.items()
        if variables
    }


def parse_variables(document: Any) -> dict[int, Mapping[str, RetainedVariable]]:
    """Return the variables of a document. Raises ValueError, AttributeError, TypeError."""
    return {
        int(port): {
            str(name): RetainedVariable(str(type), bytes.fromhex(data), tuple(map(_lead, leads)))
            for name, (type, data, *leads) in variables.items()
        }
        for port, variables in document.items()
    }


def _lead(row: Any) -> PointerTarget:
    at, target, type, offset = row
    if not all(isinstance(one, int) and one >= 0 for one in (at, offset)):
        raise ValueError(f"expected offsets from 0, got {row!r:.60}")
    return PointerTarget(at, str(target), str(type), offset)


def number(value: Any) -> float:
    """Return a position or zero of an axis. Raises ValueError for any other value."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= _FARTHEST:
        raise ValueError(f"expected a number up to {_FARTHEST:g}, got {value!r:.40}")
    return float(value)
