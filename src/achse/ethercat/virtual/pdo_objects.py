"""Mapping and assignment of PDOs as objects (16xxh, 1Axxh, 1C10h + SyncManager) of an ESI device.

A list is changed in PreOp as the standard has it: count 0, the entries, then the count, which is
when the list is checked.

Source: ETG.1000.6 §5.6.7.4; ETG.2000, CoE PdoAssign and PdoConfig, Fixed and Exclude of PDOs.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

from achse.codes import AbortCode, DataType, SdoAbort
from achse.ethercat.application import ObjectAccess, ObjectCode
from achse.ethercat.description import Pdo, PdoEntry
from achse.ethercat.dictionary import DictionaryEntry, DictionaryObject
from achse.ethercat.master.esi_reader import EsiDevice, EsiPdo

ASSIGNMENT = 0x1C10
"""Object of SyncManager 0; those of the others follow."""

MOST_BITS = 8 * 0xFFFF
"""Process data of a SyncManager, whose length has 16 bits."""
_MOST = 0xFE
_ROOM = 32
"""Entries that a list has room for at least, if a master may change it."""
_PREOP = int(ObjectAccess.READ | ObjectAccess.WRITE_PREOP)
_READ = int(ObjectAccess.READ)


class _List:
    """A list object: numbers of `bits` bits, count in subindex 0."""

    def __init__(self, values: Sequence[int], bits: int, *, writable: bool, name: str) -> None:
        self.initial = tuple(values[:_MOST])
        self.values = list(self.initial)
        self.count = len(self.values)
        self.bits = bits
        self.writable = writable
        self.name = name
        self.room = max(self.count, min(_ROOM, _MOST)) if writable else self.count

    @property
    def active(self) -> tuple[int, ...]:
        return tuple(self.values[: self.count])

    def described(self, index: int) -> DictionaryObject:
        kind = DataType.U16 if self.bits == 16 else DataType.U32
        access = _PREOP if self.writable else _READ
        first = DictionaryEntry(
            0, "SubIndex 000", DataType.U8, 8, access, bytes((len(self.initial),))
        )
        size = self.bits >> 3
        rest = (
            DictionaryEntry(
                *(n, f"SubIndex {n:03d}", kind, self.bits, access),
                (self.initial[n - 1] if n <= len(self.initial) else 0).to_bytes(size, "little"),
            )
            for n in range(1, self.room + 1)
        )
        mapping = self.bits == 32
        return DictionaryObject(
            *(index, self.name),
            ObjectCode.RECORD if mapping else ObjectCode.ARRAY,
            DataType.PDO_MAPPING if mapping else kind,
            (first, *rest),
        )


class PdoObjects:
    """The lists of a device. `default` are the PDOs that it assigns by itself, by SyncManager.

    `entry_of(index, subindex)` gives an entry of the dictionary; it raises `SdoAbort` for what does
    not exist.
    """

    def __init__(
        self,
        device: EsiDevice,
        default: Mapping[int, Sequence[int]],
        managers: Mapping[int, bool],
        entry_of: Callable[[int, int], DictionaryEntry],
    ) -> None:
        """`managers`: for each SyncManager of process data, True if it is one of outputs."""
        self._entry_of = entry_of
        self._pdos = {each.pdo.index: each for each in (*device.outputs, *device.inputs)}
        self._outputs = {each.pdo.index for each in device.outputs}
        self._managers = managers
        self._lists: dict[int, _List] = {}
        for index, each in self._pdos.items():
            writable = device.pdo_configure and not each.pdo.fixed
            values = [_mapping(entry) for entry in each.pdo.entries]
            self._lists[index] = _List(values, 32, writable=writable, name=each.pdo.name)
        for number in managers:
            self._lists[ASSIGNMENT + number] = _List(
                default.get(number, ()), 16,
                writable=device.pdo_assign, name=f"SyncManager {number} assignment",
            )  # fmt: skip

    def objects(self) -> list[DictionaryObject]:
        """Return the objects, by index."""
        return [self._lists[index].described(index) for index in sorted(self._lists)]

    def __contains__(self, index: int) -> bool:
        return index in self._lists

    def assigned(self, manager: int) -> list[Pdo]:
        """Return the PDOs of a SyncManager with their entries of now."""
        indices = self._lists[ASSIGNMENT + manager].active
        return [self.pdo(index) for index in indices if index in self._pdos]

    def pdo(self, index: int) -> Pdo:
        """Return a PDO with its entries of now."""
        pdo, mapped = self._pdos[index].pdo, self._lists[index]
        if mapped.active == mapped.initial:
            return pdo  # entries of more than 255 bits have their length here alone
        entries = tuple(self._entry(value) for value in mapped.active)
        return Pdo(pdo.index, pdo.name, pdo.sync_manager, pdo.fixed, entries)

    def _entry(self, value: int) -> PdoEntry:
        index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & 0xFF
        if not index:
            return PdoEntry(0, 0, bits, "", 0)
        entry = self._entry_of(index, subindex)
        return PdoEntry(index, subindex, bits, entry.name, entry.data_type)

    def read(self, index: int, subindex: int) -> bytes:
        """Return a number of a list."""
        pdo_list = self._lists[index]
        if subindex == 0:
            return bytes((pdo_list.count,))
        if subindex > pdo_list.room:
            raise SdoAbort(AbortCode.NO_SUBINDEX)
        value = pdo_list.values[subindex - 1] if subindex <= len(pdo_list.values) else 0
        return value.to_bytes(pdo_list.bits >> 3, "little")

    def write(self, index: int, subindex: int, data: bytes) -> None:
        """Change a list; raises `SdoAbort`."""
        pdo_list = self._lists[index]
        value = int.from_bytes(data, "little")
        if subindex > pdo_list.room:
            raise SdoAbort(AbortCode.NO_SUBINDEX)
        if len(data) != (pdo_list.bits >> 3 if subindex else 1):
            raise SdoAbort(AbortCode.LENGTH)
        if subindex == 0:
            if value > pdo_list.room:
                raise SdoAbort(AbortCode.VALUE_RANGE)
            pdo_list.values += [0] * (value - len(pdo_list.values))
            if value:
                self._check(index, pdo_list.values[:value])
            pdo_list.count = value
            return
        if pdo_list.count and subindex <= pdo_list.count and pdo_list.values[subindex - 1] == value:
            return  # some masters write what is there already
        if pdo_list.count:
            raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS, "the count has to be 0 first")
        pdo_list.values += [0] * (subindex - len(pdo_list.values))
        pdo_list.values[subindex - 1] = value

    def _check(self, index: int, values: Sequence[int]) -> None:
        """Raise `SdoAbort` for a list that cannot be."""
        output = self._managers.get(index - ASSIGNMENT)
        if output is None:  # the list of a PDO, whose index the file may place anywhere
            for value in values:
                self._check_entry(index, value)
            return
        for value in values:
            if value not in self._pdos or (value in self._outputs) != output:
                raise SdoAbort(AbortCode.NOT_MAPPABLE, f"no PDO {value:04X} in this direction")
            against = _excluded(self._pdos[value]).intersection(values)
            if against:
                names = ", ".join(f"{each:04X}" for each in sorted(against))
                raise SdoAbort(AbortCode.NOT_MAPPABLE, f"PDO {value:04X} excludes {names}")
        bits = bits_of(self.pdo(value) for value in values)
        if bits > MOST_BITS:
            raise SdoAbort(AbortCode.PDO_LENGTH, f"{bits} bits, {MOST_BITS} at most")

    def _check_entry(self, pdo: int, value: int) -> None:
        index, subindex, bits = value >> 16, value >> 8 & 0xFF, value & 0xFF
        if not index:
            return
        entry = self._entry_of(index, subindex)
        wanted = ObjectAccess.RX_PDO if pdo in self._outputs else ObjectAccess.TX_PDO
        if not entry.access & wanted or bits != entry.bits & 0xFF:
            raise SdoAbort(AbortCode.NOT_MAPPABLE, f"{index:04X}:{subindex:02X}, {bits} bits")


def bits_of(pdos: Iterable[Pdo]) -> int:
    """Bits of PDOs one behind the other."""
    return sum(entry.bits for pdo in pdos for entry in pdo.entries)


def _excluded(pdo: EsiPdo) -> set[int]:
    return set(pdo.excludes) - {pdo.pdo.index}


def _mapping(entry: PdoEntry) -> int:
    return entry.index << 16 | entry.subindex << 8 | entry.bits & 0xFF
