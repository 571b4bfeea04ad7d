"""The device behind a virtual slave: objects and process data of an ESI file, and a behaviour.

Inputs keep what was set, outputs what the master wrote last; outside Op outputs are 0.

Source: ETG.2000 for the description, ETG.1000.6 for the objects.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from functools import partial

from achse.codes import AbortCode, AlState, AlStatus, DataType, FileRefusal, FoeError, SdoAbort
from achse.ethercat.application import ObjectAccess, ObjectCode
from achse.ethercat.description import Pdo
from achse.ethercat.dictionary import (
    DictionaryEntry,
    DictionaryIdentity,
    DictionaryObject,
    number,
    record_object,
    text_object,
)
from achse.ethercat.master.configuration import SlaveConfiguration
from achse.ethercat.master.esi_reader import EsiDevice, EsiError, from_esi
from achse.ethercat.virtual.behaviour import SlaveBehaviour
from achse.ethercat.virtual.channels import (
    PdoChannel,
    Value,
    channels_of,
    decode_value,
    encode_value,
)
from achse.ethercat.virtual.esi_dictionary import read_dictionary
from achse.ethercat.virtual.mailbox_services import MailboxServices
from achse.ethercat.virtual.pdo_objects import MOST_BITS, PdoObjects, bits_of

_IDLE_CYCLE_NS = 10_000_000
"""Local cycle without a behaviour: nothing happens but the watch on the watchdog."""
_READ, _WRITE = int(ObjectAccess.READ), int(ObjectAccess.READ | ObjectAccess.WRITE)
_STATE_BITS = {AlState.PREOP: 0, AlState.SAFEOP: 1, AlState.OP: 2}
_WRITE_SHIFT = 3
_TEXTS = (DataType.VISIBLE_STRING, DataType.OCTET_STRING)
_IDENTITY, _TYPES = 0x1018, 0x1C00
_DEVICE_AREA = 0xF000
_CONFIGURED, _DETECTED = _DEVICE_AREA + 0x30, _DEVICE_AREA + 0x50
"""Idents of the modules in the slots."""
_USES = ("MBoxOut", "MBoxIn", "Outputs", "Inputs")
_LONGEST_FILE = 1 << 24
_MOST_FILES, _MOST_FILE_BYTES = 64, 1 << 25
"""Files that a slave keeps, and the bytes of all of them: a master could write without end."""
_Place = tuple[int, int]


class _Image:
    """The process data of a SyncManager, and the bits of each object in it."""

    def __init__(self, output: bool, pdos: Iterable[Pdo]) -> None:
        self.output = output
        self.places: dict[_Place, tuple[int, int]] = {}
        bit = 0
        for pdo in pdos:
            for entry in pdo.entries:
                if entry.index:
                    self.places.setdefault((entry.index, entry.subindex), (bit, entry.bits))
                bit += entry.bits
        self.size = bit + 7 >> 3
        self.data = bytes(self.size)

    def get(self, place: _Place) -> int:
        """Return the bits of an object."""
        bit, bits = self.places[place]
        return int.from_bytes(self.data, "little") >> bit & (1 << bits) - 1

    def put(self, place: _Place, raw: int) -> None:
        """Change the bits of an object."""
        bit, bits = self.places[place]
        mask = (1 << bits) - 1 << bit
        value = int.from_bytes(self.data, "little") & ~mask | raw << bit & mask
        self.data = value.to_bytes(self.size, "little")


class VirtualDevice:
    """A device of an ESI file. Raises `EsiError` for one that cannot be.

    `configuration` is what a master makes of the same file. `module_idents` are those of the
    modules in its slots, whose objects are `module_objects`.
    """

    def __init__(
        self,
        device: EsiDevice,
        *,
        behaviour: SlaveBehaviour | None = None,
        serial_number: int = 0,
        module_idents: Sequence[int] | None = None,
        module_objects: Iterable[DictionaryObject] = (),
    ) -> None:
        self.esi = device
        self.name = device.type_name
        self.identity = DictionaryIdentity(
            device.vendor_id, device.product_code, device.revision_number, serial_number
        )
        self.configuration: SlaveConfiguration = from_esi(device)
        self.state = AlState.INIT
        self.emergencies: list[bytes] = []
        """Emergency messages of 8 bytes that wait for the master."""
        self._managers = {each.number: each.output for each in self.configuration.sync_managers}
        default = {
            number: [
                each.index
                for each in (*self.configuration.outputs, *self.configuration.inputs)
                if self.configuration.manager_of(each) == number
            ]
            for number in self._managers
        }
        self._entries: dict[int, dict[int, DictionaryEntry]] = {}
        self._lists = PdoObjects(device, default, self._managers, self._entry)
        try:
            self._objects = self._dictionary(module_idents, list(module_objects))
        except ValueError as fault:
            raise EsiError(f"{device.type_name}: {fault}") from None
        self._entries.update(
            (each.index, {entry.subindex: entry for entry in each.entries})
            for each in self._objects
        )
        self._values: dict[_Place, bytes] = self._identity_values()
        self._image_by_manager: dict[int, _Image] = {}
        for each in self._managers:
            bits = bits_of(self._lists.assigned(each))
            if bits > MOST_BITS:
                raise EsiError(
                    f"{device.type_name}: SyncManager {each}: expected"
                    f" {MOST_BITS >> 3} bytes of process data at most, got {bits + 7 >> 3}"
                )
        self._channels = channels_of(
            (each.pdo for each in device.outputs), (each.pdo for each in device.inputs)
        )
        self.behaviour = behaviour
        try:
            self.messages = MailboxServices(self)
        except ValueError as fault:
            raise EsiError(f"{device.type_name}: {fault}") from None
        self.services = self.messages.handlers
        self.take_message = self.messages.take_message
        self.local_cycle_ns = _IDLE_CYCLE_NS if behaviour is None else behaviour.cycle_ns
        if behaviour is not None:
            behaviour.start(self)

    # the dictionary

    def _dictionary(
        self, idents: Sequence[int] | None, modules: Iterable[DictionaryObject]
    ) -> tuple[DictionaryObject, ...]:
        """Return the objects of the file, and those that a device has besides: file first, PDOs
        last."""
        device = self.esi
        profiles = [] if device.element is None else device.element.findall("Profile")
        by_index = {each.index: each for each in self._usual()}
        by_index.update((each.index, each) for each in read_dictionary(iter(profiles)))
        by_index.update((each.index, each) for each in modules)
        if idents is not None:
            listed = [
                number(n, f"SubIndex {n:03d}", 32, ident) for n, ident in enumerate(idents, 1)
            ]
            by_index[_DETECTED] = record_object(_DETECTED, "Detected modules", listed)
            writable = [
                number(n, f"SubIndex {n:03d}", 32, ident, _WRITE)
                for n, ident in enumerate(idents, 1)
            ]
            by_index[_CONFIGURED] = record_object(_CONFIGURED, "Configured modules", writable)
        for index, entries in self._of_pdos().items():
            present = by_index.get(index)
            if present is None:
                by_index[index] = _with_entries(index, entries)
            else:
                by_index[index] = _completed(present, entries)
        by_index.update((each.index, each) for each in self._lists.objects())
        return tuple(by_index[index] for index in sorted(by_index))

    def _usual(self) -> Iterator[DictionaryObject]:
        yield DictionaryObject(
            *(0x1000, "Device type", ObjectCode.VAR, DataType.U32),
            (number(0, "Device type", 32),),
        )
        yield text_object(0x1008, "Device name", self.name.encode("ascii", "replace"))
        names = ("Vendor ID", "Product code", "Revision", "Serial number")
        yield record_object(
            _IDENTITY, "Identity", [number(n, name, 32) for n, name in enumerate(names, 1)]
        )
        uses = [_USES.index(each.use) + 1 for each in self.esi.sync_managers]
        yield record_object(
            *(_TYPES, "SyncManager types"),
            [number(n, f"SubIndex {n:03d}", 8, use) for n, use in enumerate(uses, 1)],
        )

    def _of_pdos(self) -> dict[int, dict[int, DictionaryEntry]]:
        """Entries of objects that PDOs map or start commands write, by index."""
        by_index: dict[int, dict[int, DictionaryEntry]] = {}
        for output, pdos in ((True, self.esi.outputs), (False, self.esi.inputs)):
            access = _WRITE | ObjectAccess.RX_PDO if output else _READ | ObjectAccess.TX_PDO
            for each in pdos:
                for entry in each.pdo.entries:
                    if entry.index:
                        by_index.setdefault(entry.index, {}).setdefault(
                            entry.subindex,
                            DictionaryEntry(
                                *(entry.subindex, entry.name, entry.data_type, entry.bits),
                                int(access),
                            ),
                        )
        for command in self.esi.commands:
            if command.index not in self._lists and not command.complete:
                by_index.setdefault(command.index, {}).setdefault(
                    command.subindex,
                    DictionaryEntry(
                        *(command.subindex, command.comment, DataType.OCTET_STRING),
                        *(8 * len(command.data), _WRITE),
                    ),
                )
        return by_index

    def _identity_values(self) -> dict[_Place, bytes]:
        identity = (
            self.identity.vendor_id,
            self.identity.product_code,
            self.identity.revision_number,
            self.identity.serial_number,
        )
        return {
            (_IDENTITY, n): value.to_bytes(4, "little")
            for n, value in enumerate(identity, 1)
            if n in self._entries.get(_IDENTITY, {})
        }

    def objects(self) -> tuple[DictionaryObject, ...]:
        return self._objects

    def _entry(self, index: int, subindex: int) -> DictionaryEntry:
        entries = self._entries.get(index)
        if entries is None:
            raise SdoAbort(AbortCode.NO_OBJECT)
        if subindex not in entries:
            raise SdoAbort(AbortCode.NO_SUBINDEX)
        return entries[subindex]

    def read_object(self, index: int, subindex: int) -> bytes:
        """Return the value of an entry; raises `SdoAbort`."""
        entry = self._entry(index, subindex)
        if not entry.access & _READ:
            raise SdoAbort(AbortCode.WRITE_ONLY)
        if index in self._lists:
            return self._lists.read(index, subindex)
        place, size = (index, subindex), entry.bits + 7 >> 3
        for image in self._images().values():
            if place in image.places:
                return image.get(place).to_bytes(size, "little")
        value = self._values.get(place, entry.default)
        if value is None:
            return b"" if entry.data_type in _TEXTS else bytes(size)
        return value

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        """Take a value over; raises `SdoAbort`."""
        entry = self._entry(index, subindex)
        if self.behaviour is not None:
            self.behaviour.write(self, index, subindex, data)
        allowed = entry.access >> _WRITE_SHIFT & _READ
        if not allowed:
            raise SdoAbort(AbortCode.READ_ONLY)
        if not allowed >> _STATE_BITS.get(self.state, 0) & 1:
            raise SdoAbort(AbortCode.DEVICE_STATE)
        if index in self._lists:
            self._lists.write(index, subindex, data)
            self._image_by_manager.clear()
            return
        _check_value(entry, data)
        self._store((index, subindex), data)

    def _store(self, place: _Place, data: bytes) -> None:
        self._values[place] = data
        for image in self._images().values():
            if place in image.places:
                image.put(place, int.from_bytes(data, "little"))

    # process data

    def _images(self) -> dict[int, _Image]:
        """Return the image of each SyncManager with the mapping of now, with the values kept."""
        if not self._image_by_manager:
            for manager, output in self._managers.items():
                image = _Image(output, self._lists.assigned(manager))
                for place in () if output else image.places:
                    if place in self._values:
                        image.put(place, int.from_bytes(self._values[place], "little"))
                self._image_by_manager[manager] = image
        return self._image_by_manager

    @property
    def output_size(self) -> int:
        """Bytes of all outputs."""
        return sum(each.size for each in self._images().values() if each.output)

    @property
    def input_size(self) -> int:
        """Bytes of all inputs."""
        return sum(each.size for each in self._images().values() if not each.output)

    def buffer_size(self, number: int) -> int:
        """Return bytes in a SyncManager."""
        return self._images()[number].size

    def buffer_writer(self, number: int) -> Callable[[bytes], object]:
        """Receiver of the outputs of a SyncManager; lines have a thousand slaves, so it is
        short."""
        return partial(setattr, self._images()[number], "data")

    def buffer_reader(self, number: int) -> Callable[[], bytes]:
        """Reader of the inputs of a SyncManager, short as well."""
        return partial(getattr, self._images()[number], "data")

    def all_outputs(self) -> bytes:
        """Return the outputs of all SyncManagers, one behind the other."""
        return b"".join(each.data for each in self._images().values() if each.output)

    def read_inputs(self) -> bytes:
        """Return the inputs of all SyncManagers, one behind the other."""
        return b"".join(each.data for each in self._images().values() if not each.output)

    def write_all_inputs(self, data: bytes) -> None:
        """Set the inputs of all SyncManagers, the first bytes first; 0 where `data` is shorter."""
        at = 0
        for image in self._images().values():
            if not image.output:
                image.data = data[at : at + image.size].ljust(image.size, b"\0")
                at += image.size

    def write_outputs(self, data: bytes) -> None:
        """Take over the outputs of all SyncManagers, one behind the other."""
        at = 0
        for image in self._images().values():
            if image.output:
                image.data = data[at : at + image.size].ljust(image.size, b"\0")
                at += image.size

    # channels

    @property
    def channels(self) -> Mapping[str, PdoChannel]:
        """The entries of all PDOs, by each of their names."""
        return self._channels

    def channel(self, name: str) -> PdoChannel:
        """Return a channel by one of its names; KeyError names close ones."""
        try:
            return self._channels[name]
        except KeyError:
            close = get_close_matches(name, self._channels, 3, 0.4)
            there = ", ".join(close or sorted(self._channels)[:5]) or "none"
            raise KeyError(f"{self.name} has no channel {name!r}; there are: {there}") from None

    def set_input(self, name: str, value: Value) -> None:
        """Set an input; KeyError, ValueError."""
        channel = self.channel(name)
        if channel.output:
            raise ValueError(f"{name} is an output of {self.name}")
        raw = encode_value(channel, value)
        self._store(channel.place, raw.to_bytes(channel.bits + 7 >> 3, "little"))

    def input(self, name: str) -> Value:
        """Return the value of an input; KeyError."""
        return self._value(self.channel(name))

    def output(self, name: str) -> Value:
        """Return the value of an output as the master wrote it last; KeyError."""
        return self._value(self.channel(name))

    def _value(self, channel: PdoChannel) -> Value:
        for image in self._images().values():
            if channel.place in image.places and image.output == channel.output:
                return decode_value(channel, image.get(channel.place))
        return decode_value(channel, int.from_bytes(self._values.get(channel.place, b""), "little"))

    # states and time

    def enter(self, state: AlState, sync0_ns: int, cause: AlStatus) -> AlStatus:
        """Follow the state; outputs are off outside Op."""
        self.state = state
        if state is not AlState.OP:
            for image in self._images().values():
                if image.output:
                    image.data = bytes(image.size)
        if self.behaviour is not None:
            self.behaviour.enter(self, state)
        return AlStatus.NO_ERROR

    def step(self, elapsed_ns: int) -> AlStatus:
        """Return a local cycle: a step of the behaviour."""
        if self.behaviour is not None:
            self.behaviour.step(self, elapsed_ns)
        return AlStatus.NO_ERROR

    def send_frame(self, frame: bytes) -> None:
        """Send an Ethernet frame by EoE; ValueError for a device without, and for its length."""
        if self.messages.network is None:
            raise ValueError(f"{self.name} has no EoE")
        self.messages.network.send(frame)

    @property
    def is_quiet(self) -> bool:
        """True if neither an emergency nor a frame waits for the master."""
        network = self.messages.network
        return not (self.emergencies or (network is not None and network.waiting))

    def take_emergency(self) -> bytes | None:
        """Return the oldest of `emergencies`."""
        return self.emergencies.pop(0) if self.emergencies else None


class VirtualFileDevice(VirtualDevice):
    """A device whose mailbox has FoE: a store for files in memory, `files` by name."""

    longest_file = _LONGEST_FILE
    programming: tuple[int, int] | None = None

    def __init__(self, device: EsiDevice, **options: object) -> None:
        super().__init__(device, **options)  # type: ignore[arg-type]
        self.files: dict[str, bytes] = {}
        self.bootstrap = len(device.bootstrap) >= 8

    def read_file(self, name: str, password: int) -> bytes:
        """Return a file that was written, or put into `files`."""
        if name not in self.files:
            raise FileRefusal(FoeError.NOT_FOUND, name)
        return self.files[name]

    def begin_file(self, name: str, password: int) -> None:
        """Accept any name, as long as there is room and the behaviour agrees."""
        if self.behaviour is not None:
            self.behaviour.begin_file(self, name, password)
        if name not in self.files and len(self.files) >= _MOST_FILES:
            raise FileRefusal(FoeError.DISK_FULL, f"{_MOST_FILES} files at most")

    def write_file(self, name: str, data: bytes) -> None:
        """Keep a file, as long as all of them have room."""
        others = sum(len(each) for other, each in self.files.items() if other != name)
        if others + len(data) > _MOST_FILE_BYTES:
            raise FileRefusal(FoeError.DISK_FULL, f"{_MOST_FILE_BYTES} bytes at most")
        self.files[name] = data


def _with_entries(index: int, entries: Mapping[int, DictionaryEntry]) -> DictionaryObject:
    """Return an object that the file's dictionary does not have."""
    only = entries.get(0)
    if only is not None and len(entries) == 1:
        return DictionaryObject(
            index, only.name or f"{index:04X}", ObjectCode.VAR, only.data_type, (only,)
        )
    rest = [entries[subindex] for subindex in sorted(entries) if subindex]
    return record_object(index, f"Object {index:04X}", rest, max(entries))


def _completed(
    present: DictionaryObject, entries: Mapping[int, DictionaryEntry]
) -> DictionaryObject:
    """Return an object of the file with the entries that PDOs map and it does not list, and their
    use."""
    by_subindex = {each.subindex: each for each in present.entries}
    for subindex, entry in entries.items():
        known = by_subindex.get(subindex)
        if known is None:
            by_subindex[subindex] = entry
        elif entry.access & ~known.access & (ObjectAccess.RX_PDO | ObjectAccess.TX_PDO):
            use = entry.access & (ObjectAccess.RX_PDO | ObjectAccess.TX_PDO)
            by_subindex[subindex] = DictionaryEntry(
                *(known.subindex, known.name, known.data_type, known.bits, known.access | use),
                *(known.default, known.minimum, known.maximum),
            )
    completed = tuple(by_subindex[subindex] for subindex in sorted(by_subindex))
    if len(completed) > 1 and completed[0].subindex == 0:
        last = bytes((completed[-1].subindex,))
        first = completed[0]
        if first.default is None or first.default < last:
            first = number(0, first.name, 8, completed[-1].subindex, first.access)
        completed = (first, *completed[1:])
    code = ObjectCode.RECORD if len(completed) > 1 else present.code
    return DictionaryObject(present.index, present.name, code, present.data_type, completed)


def _check_value(entry: DictionaryEntry, data: bytes) -> None:
    """Raise `SdoAbort` for a value of another length, or beyond its limits."""
    size = entry.bits + 7 >> 3
    if entry.data_type in _TEXTS:
        if len(data) > size:
            raise SdoAbort(AbortCode.TOO_LONG)
        return
    if len(data) != size:
        raise SdoAbort(AbortCode.LENGTH)
    if entry.data_type not in list(DataType) or not DataType(entry.data_type).form:
        return
    kind = DataType(entry.data_type)
    if kind.bits != entry.bits or kind in (DataType.F32, DataType.F64):
        return
    signed = kind.form[1].islower()
    value = int.from_bytes(data, "little", signed=signed)
    for limit, code, above in (
        (entry.minimum, AbortCode.TOO_LOW, False),
        (entry.maximum, AbortCode.TOO_HIGH, True),
    ):
        if limit is not None:
            edge = int.from_bytes(limit, "little", signed=signed)
            if value > edge if above else value < edge:
                raise SdoAbort(code)
