"""Servos: the drives on a bus that the axes of an NC have, and the images of their process data."""

import ctypes
import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from achse.motion.axis import Axis
from achse.motion.fields.encoder import PROBE_EDGES, TOUCH_PROBES
from achse.motion.nc import Nc
from achse.motion.servo.compiled import SEND, TAKE
from achse.motion.servo.kernel import send, take
from achse.motion.servo.objects import (
    INPUT_OBJECTS,
    OUTPUT_OBJECTS,
    ProcessEntry,
    ServoError,
    ServoMode,
    ServoObject,
)
from achse.motion.servo.optional import ALL_PARTS, DriveParts, missing_condition
from achse.motion.servo.record import ENTRIES, SERVO, Servo, servo_record
from achse.motion.views import Store, View

if TYPE_CHECKING:

    class _Servo(View, Servo): ...

else:
    _Servo = View

_CODES = {1: "b", 2: "h", 4: "i"}


@dataclass(frozen=True, slots=True)
class ServoOptions:
    """Use of a drive by its axis.

    `interface` is what it sends. `home_offset` is 607Ch in increments. `dead_time` in seconds is
    from the set value to the actual value that shows it, None lets it be measured in csp. `parts`
    are the optional parts of the profile that the drive has. The rest is the velocity loop of cst,
    in thousandths of the rated torque and increments: gain in ‰ per INC/s, reset time in seconds,
    feed-forward in ‰ per INC/s², limit in ‰.
    """

    interface: ServoMode = ServoMode.CSP
    home_offset: int = 0
    dead_time: float | None = None
    velocity_gain: float = 0.0
    velocity_reset_time: float = 0.0
    torque_per_acceleration: float = 0.0
    torque_limit: float = 3000.0
    parts: DriveParts = ALL_PARTS


@dataclass(frozen=True, slots=True)
class ServoLink:
    """An axis and its drive; the entries say where the objects are in the images."""

    axis_id: int
    inputs: Sequence[ProcessEntry]
    outputs: Sequence[ProcessEntry]
    options: ServoOptions = field(default_factory=ServoOptions)


class ServoView(_Servo):
    """One servo from outside."""

    axis: Axis
    has_begun: bool
    """Its axis has begun with a position of the drive."""
    parts: DriveParts
    """The optional parts of the profile that its drive has."""

    @property
    def missing_condition(self) -> str:
        """Condition that keeps its axis from being ready, or an empty text; for valid data only."""
        return missing_condition(self, self.parts)


class Servos:
    """The servos of an NC; `inputs` and `outputs` are the images, bytes as they are on the bus.

    In each cycle: fill `inputs`, `take`, let the NC work, `send`, send `outputs`. What of the
    outputs no axis writes stays as it is. Raises ServoError.
    """

    def __init__(
        self, nc: Nc, links: Iterable[ServoLink], input_size: int, output_size: int
    ) -> None:
        links = list(links)
        self.inputs, self.outputs = bytearray(input_size), bytearray(output_size)
        self._dt = nc.cycle_seconds
        compiled = nc.compiled
        self._store = Store(ServoView, SERVO, servo_record, len(links), compiled=compiled)
        self.servos: Sequence[ServoView] = self._store.views
        self._waiting: list[ServoView] = []
        for servo, link in zip(self.servos, links, strict=True):
            self._link(servo, nc, link)
        self.take: Callable[[], None]
        """Inputs into the structures of the axes."""
        self.send: Callable[[], None]
        """Outputs of the axes into the image."""
        if compiled:
            self._take_inputs = _bound(TAKE, self._store, self.inputs, self._dt)
            self.send = _bound(SEND, self._store, self.outputs, self._dt)
        else:
            reads = [
                _reader(s, _known_objects(link.inputs, INPUT_OBJECTS), self.inputs)
                for s, link in zip(self._store.arguments[0], links, strict=True)
            ]
            writes = [
                _writer(s, _known_objects(link.outputs, OUTPUT_OBJECTS), self.outputs)
                for s, link in zip(self._store.arguments[0], links, strict=True)
            ]
            self._take_inputs = partial(_take_plain, self._store.arguments[0], reads, self._dt)
            self.send = partial(_send_plain, self._store.arguments[0], writes, self._dt)
        self.take = self._take_inputs

    def _link(self, servo: ServoView, nc: Nc, link: ServoLink) -> None:
        axis = servo.axis = nc.axis(link.axis_id)
        options = link.options
        what = f"axis {link.axis_id}"
        inputs = _checked(link.inputs, INPUT_OBJECTS, len(self.inputs), what)
        outputs = _checked(link.outputs, OUTPUT_OBJECTS, len(self.outputs), what)
        needed = {"inputs": (inputs, (0x6041, 0x6064)), "outputs": (outputs, (0x6040,))}
        for way, (there, objects) in needed.items():
            for index in objects:
                if index not in there:
                    raise ServoError(f"{what}: {index:04X}h is not in the {way} of its drive")
        target = {ServoMode.CSP: 0x607A, ServoMode.CSV: 0x60FF, ServoMode.CST: 0x6071}
        if target[options.interface] not in outputs:
            raise ServoError(
                f"{what}: {options.interface.name.lower()} needs {target[options.interface]:04X}h"
                " in the outputs of its drive"
            )
        axis.encoder.probe_refused = _refused_edges(set(outputs) | set(inputs))
        servo.has_begun = False
        servo.link("encoder", axis.encoder.io)
        servo.link("drive", axis.drive.io)
        servo.interface = servo.mode = options.interface
        servo.inverted = axis.drive.motor_polarity
        servo.home_offset = options.home_offset
        servo.fixed_dead_time = -1.0 if options.dead_time is None else options.dead_time
        servo.velocity_gain = options.velocity_gain
        if options.velocity_reset_time > 0.0:
            servo.velocity_integral = 1.0 / options.velocity_reset_time
        servo.torque_per_acceleration = options.torque_per_acceleration
        servo.torque_limit = options.torque_limit
        servo.switch_cycles = max(10, round(_SWITCH_S / self._dt))
        servo.reset_limit = max(16, round(_RESET_S / self._dt))
        servo.parts = parts = options.parts
        servo.follow_bit, servo.reached_bit = int(parts.following_bit), int(parts.reached_bit)
        sends_mode = 0x6060 in outputs
        servo.has_mode = int(sends_mode and parts.mode_display and 0x6061 in inputs)
        if sends_mode and not servo.has_mode:
            servo.mode_wait = servo.mode_cycles = max(1, round(_MODE_S / self._dt))
        servo.has_velocity = int(0x606C in inputs)
        servo.can_position = int(0x607A in outputs)
        servo.can_velocity = int(0x60FF in outputs)
        servo.can_torque = int(0x6071 in outputs)
        _map(servo, "input", inputs, INPUT_OBJECTS)
        _map(servo, "output", outputs, OUTPUT_OBJECTS)
        axis.go_on_bus()

    def connect(self, servo: ServoView, valid: bool, absent: bool = False) -> None:
        """Note whether the drive's data are fresh and it takes outputs.

        `absent`: the bus has looked for it and has not found it.
        """
        servo.absent = int(absent)
        if bool(servo.valid) == valid:
            return
        servo.valid = int(valid)
        if valid and not servo.has_begun:
            self._waiting.append(servo)
            self.take = self._take_first

    def _take_first(self) -> None:
        """Take inputs, and let axes begin where their drives are for the first time."""
        self._take_inputs()
        for servo in self._waiting:
            servo.has_begun = True
            servo.axis.encoder.reinitialization_state = 1
            servo.axis.wake(adapts=True)
        self._waiting.clear()
        self.take = self._take_inputs

    @property
    def kernel_arguments(self) -> tuple[int, ...]:
        """Arguments of machine code for the records and their words."""
        address, count = self._store.arguments
        return address, count, address, count * SERVO.words

    def digest(self) -> bytes:
        """Return the whole state, for a hash; the images are copies of what is on the bus."""
        return b"".join(servo.pack() for servo in self.servos)


def _refused_edges(objects: set[int]) -> int:
    """Edges of probes that cannot latch: what latches them is not in the process data.

    A drive with this profile has two probes; 60B8h has no bits for those of units 3 and 4.
    """
    latched = 0
    if {0x60B8, 0x60B9} <= objects:
        for edge, index in _LATCHED.items():
            latched |= (index in objects) << edge
    return (1 << PROBE_EDGES) - 1 & ~latched


_LATCHED = {
    0: 0x60BA,
    1: 0x60BC,
    TOUCH_PROBES: 0x60BB,
    TOUCH_PROBES + 1: 0x60BD,
}
"""Objects of the latched positions: rising edges of the probes, then falling ones."""

_SWITCH_S = 0.2
_RESET_S = 1.0
_MODE_S = 0.05
"""Longest time of a change of the mode, a reset, or a change without 6061h, s."""


def _checked(
    entries: Sequence[ProcessEntry], known: dict[int, ServoObject], size: int, what: str
) -> dict[int, ProcessEntry]:
    """Return the entries that an axis knows, by object; each within the image and of its size."""
    known_entries: dict[int, ProcessEntry] = {}
    for entry in entries:
        row = known.get(entry.index)
        if row is None:
            continue
        if entry.size != row.size or not 0 <= entry.offset <= size - entry.size:
            raise ServoError(
                f"{what}: {entry.index:04X}h has {row.size} bytes within {size}, got "
                f"{entry.size} at {entry.offset}"
            )
        known_entries[entry.index] = entry
    if len(known_entries) > ENTRIES:
        raise ServoError(f"{what}: {len(known_entries)} objects, expected at most {ENTRIES}")
    return known_entries


def _known_objects(
    entries: Sequence[ProcessEntry], known: dict[int, ServoObject]
) -> list[tuple[ServoObject, int]]:
    by_index = {entry.index: entry for entry in entries if entry.index in known}
    return [(known[entry.index], entry.offset) for entry in by_index.values()]


def _map(
    servo: ServoView, way: str, entries: dict[int, ProcessEntry], known: dict[int, ServoObject]
) -> None:
    setattr(servo, f"{way}_count", len(entries))
    at, sizes, words = (getattr(servo, f"{way}_{name}") for name in ("at", "size", "word"))
    for n, entry in enumerate(entries.values()):
        row = known[entry.index]
        at[n] = entry.offset
        sizes[n] = -row.size if row.signed and way == "input" else row.size
        words[n] = SERVO.fields[row.field].offset


def _bound(kernel: Any, store: Store, image: bytearray, dt: float) -> Callable[[], None]:
    address, count = store.arguments
    memory = (ctypes.c_char * len(image)).from_buffer(image) if image else None
    place = ctypes.addressof(memory) if memory is not None else 0
    bound = kernel.bind(address, count, address, count * SERVO.words, place, len(image), dt)

    def run() -> None:
        bound()

    run.memory = memory  # type: ignore[attr-defined]  # the image stays where it is
    return run


def _form(row: ServoObject) -> str:
    code = _CODES[row.size]
    return code if row.signed else code.upper()


def _reader(
    servo: Servo, rows: list[tuple[ServoObject, int]], image: bytearray
) -> Callable[[], None]:
    """Return a function that takes the inputs of one drive out of the image."""
    parts = [(struct.Struct("<" + _form(row)).unpack_from, at, row.field) for row, at in rows]

    def read() -> None:
        for unpack, at, name in parts:
            setattr(servo, name, unpack(image, at)[0])

    return read


def _writer(
    servo: Servo, rows: list[tuple[ServoObject, int]], image: bytearray
) -> Callable[[], None]:
    """Return a function that puts the outputs of one drive into the image."""
    parts = [
        (struct.Struct("<" + _form(row)).pack_into, at, attrgetter(row.field)) for row, at in rows
    ]

    def write() -> None:
        for pack, at, value in parts:
            pack(image, at, value(servo))

    return write


def _take_plain(servos: list[Servo], reads: list[Callable[[], None]], dt: float) -> None:
    for servo, read in zip(servos, reads, strict=True):
        if servo.valid:
            read()
        take(servo, dt)


def _send_plain(servos: list[Servo], writes: list[Callable[[], None]], dt: float) -> None:
    for servo, write in zip(servos, writes, strict=True):
        send(servo, dt)
        write()
