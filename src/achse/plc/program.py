"""Programs and variable lists in PLC memory: where their variables lie, and how they start."""

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from achse.iec import (
    ArrayType,
    DeclarationError,
    IecType,
    Place,
    RecordKind,
    StructType,
    Variable,
    bind,
    resolved,
)
from achse.iec.describe import types_within
from achse.iec.elementary import BoolType
from achse.iec.structs import StaticRecord
from achse.plc.memory import DEFAULT_SIZES, SPARSE, Area, AreaFullError, Memory

_AREAS = {
    "I": Area.INPUT,
    "Q": Area.OUTPUT,
    "M": Area.FLAG,
    "R": Area.RETAIN,
    "D": Area.DATA,
}
"""Areas by the letter of an `Address`."""

_HEADROOM = 1024
_REST = 1 << 20
"""Bytes behind the last variable at an address, for those without; an area that far does not
grow."""


class PlacedVariable(NamedTuple):
    """A declared variable and its memory: a symbol of the PLC.

    `bit` is set for `AT %IX1.2` and the like, and for BIT members of the unit.
    """

    name: str
    """`MAIN.nCounter`."""
    variable: Variable[Any, Any]
    area: Area
    offset: int
    bit: int | None


class PlacedUnit:
    """The instance of one program or variable list in a PLC.

    `instance` stays the same object for ever; `start` puts it into the state of a first start.
    """

    __slots__ = ("_memory", "_places", "_remanent", "base", "instance", "name", "variables")

    def __init__(self, declared: type[StaticRecord], memory: Memory) -> None:
        self.instance: StaticRecord = declared.__new__(declared)
        self.name = declared.__iec__.name
        self.variables: list[PlacedVariable] = []
        self._memory = memory
        self.base = 0
        """Offset of its memory in the data area."""
        self._places: dict[str, Place] = {}
        self._remanent: dict[IecType[Any], list[tuple[int, int]]] = {}
        """The retain and persistent parts of each type met, while memory is found."""

    def place_fixed(self) -> None:
        """Take the memory of the variables at complete addresses. Raises DeclarationError."""
        for variable in self.instance.__iec__.members:
            address = variable.address
            if variable.apart and address is not None and address.byte is not None:
                if address.bit is not None and not isinstance(resolved(variable.type), BoolType):
                    raise DeclarationError(
                        f"{self.name}.{variable.name} AT {address}: a bit address takes BOOL,"
                        f" got {variable.type.name}"
                    )
                size = 1 if address.bit is not None else variable.type.size
                region = self._memory[_AREAS[address.area]]
                try:
                    region.place(address.byte, size)
                except AreaFullError as failure:
                    raise self._refusal(variable, failure) from None
                self._set_apart(variable, region.area, address.byte, address.bit)

    def place_free(self) -> None:
        """Find memory for all other variables. Raises DeclarationError if an area is full."""
        iec = self.instance.__iec__
        data = self._memory[Area.DATA]
        self.base = data.allocate(iec.size, iec.alignment)
        for variable in iec.members:
            if not variable.in_memory or variable.name in self._places:
                continue
            if variable.apart:
                address = variable.address
                area = Area.RETAIN if address is None else _AREAS[address.area]
                try:
                    offset = self._memory[area].allocate(
                        variable.type.size, variable.type.alignment
                    )
                except AreaFullError as failure:
                    raise self._refusal(variable, failure) from None
                self._set_apart(variable, area, offset, None)
            else:
                self._note(variable, Area.DATA, self.base + variable.offset, variable.bit)
        self.variables.sort(key=lambda placed: placed.name.lower())
        self._remanent.clear()

    def _set_apart(
        self, variable: Variable[Any, Any], area: Area, offset: int, bit: int | None
    ) -> None:
        self._places[variable.name] = Place(self._memory[area].data, offset, bit)
        self._note(variable, area, offset, bit)

    def _note(self, variable: Variable[Any, Any], area: Area, offset: int, bit: int | None) -> None:
        name = f"{self.name}.{variable.name}"
        self.variables.append(PlacedVariable(name, variable, area, offset, bit))
        region = self._memory[area]
        if bit is None:
            region.put_initial(offset, variable)
        else:
            region.write_bits(offset * 8 + bit, variable.initial_bytes())
        type = variable.type
        if _is_spared(variable):
            region.keep(offset, type.size)
        elif type.is_view:
            if type not in self._remanent:
                self._remanent[type] = list(_remanent_parts(type))
            for start, size in self._remanent[type]:
                region.keep(offset + start, size)

    def _refusal(self, variable: Variable[Any, Any], failure: Exception) -> DeclarationError:
        at = f" AT {variable.address}" if variable.address else ""
        return DeclarationError(f"{self.name}.{variable.name}{at}: {failure}")

    def start(self, partners: Mapping[object, object]) -> None:
        """Bind the instance to its memory, hand it its partners, run its `__init__`.

        Python attributes of an earlier run are gone. `partners` are found by the annotations of
        the class: `gvl: GVL` is the GVL of the same PLC, `task: Task` the calling task.
        """
        unit = self.instance
        unit.__dict__.clear()
        bind(unit, self._memory[Area.DATA].data, self.base, self._places)
        for name, wanted in _annotations(type(unit)):
            if wanted in partners:
                setattr(unit, name, partners[wanted])
            elif isinstance(wanted, type) and issubclass(wanted, StaticRecord):
                raise DeclarationError(
                    f"{self.name}.{name}: {wanted.__name__} is not declared in this PLC"
                )
        unit.__init__()  # type: ignore[misc]


def area_sizes(units: Iterable[type[StaticRecord]]) -> dict[Area, int]:
    """Return the sizes of areas, in bytes, that the variables with an address in them need."""
    sizes = dict(DEFAULT_SIZES)
    for unit in units:
        for member in unit.__iec__.members:
            address = member.address
            if address is not None and address.byte is not None:
                area = _AREAS[address.area]
                end = address.byte + member.type.size
                sizes[area] = max(sizes[area], end + (_REST if end > SPARSE else _HEADROOM))
    return sizes


def place(declared: Iterable[type[StaticRecord]], memory: Memory) -> list[PlacedUnit]:
    """Give each unit its memory with initial values.

    Variables at complete addresses come first, so that no other lands on them by chance. Raises
    DeclarationError if a name is there twice or an area is full.
    """
    units = [PlacedUnit(one, memory) for one in declared]
    _unique([unit.name for unit in units])
    for unit in units:
        unit.place_fixed()
    for unit in units:
        unit.place_free()
    return units


def place_statics(units: Iterable[PlacedUnit], memory: Memory) -> list[PlacedVariable]:
    """Give each VAR_STAT variable of the units and of all types in them its one place."""
    types = [type(unit.instance).__iec__ for unit in units]
    statics = []
    data = memory[Area.DATA]
    for record in types_within(types):
        if not isinstance(record, StructType):
            continue
        for variable in record.members:
            if not variable.in_memory and variable not in memory.statics:
                offset = data.allocate(variable.type.size, variable.type.alignment)
                data.put_initial(offset, variable)
                if _is_spared(variable):
                    data.keep(offset, variable.type.size)
                memory.statics[variable] = Place(data.data, offset)
                name = f"{_owner(record, variable).name}.{variable.name}"
                statics.append(PlacedVariable(name, variable, Area.DATA, offset, None))
    return statics


def _owner(type: StructType[Any], variable: Variable[Any, Any]) -> StructType[Any]:
    """Return the type that declares a member: itself, or a base of it."""
    here: StructType[Any] | None = type
    while here is not None:
        if any(own is variable for own in here.own_members):
            return here
        here = here.base
    return type


def _unique(names: Sequence[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name.lower() in seen:
            raise DeclarationError(f"{name} is declared twice (case does not matter)")
        seen.add(name.lower())


def hand_to_blocks(units: Iterable[PlacedUnit], partners: Mapping[object, object]) -> None:
    """Hand partners to the Python classes of function blocks, as `PlacedUnit.start` does to units.

    All instances of a block share them.
    """
    for block in types_within([type(unit.instance).__iec__ for unit in units]):
        if isinstance(block, StructType) and block.kind is RecordKind.FUNCTION_BLOCK:
            for name, wanted in _annotations(block.record):
                if isinstance(wanted, str) and wanted in partners and not block.has_member(name):
                    setattr(block.record, name, partners[wanted])


def partner_names(cls: type) -> set[str]:
    """Return the attributes that `PlacedUnit.start` may set."""
    return {name for name, _ in _annotations(cls)}


def _annotations(cls: type) -> Iterator[tuple[str, type | str]]:
    """Attributes annotated with a class or, in quotes, its name; those of bases come first."""
    for base in reversed(cls.__mro__):
        if base.__module__ != StaticRecord.__module__:
            for name, wanted in inspect.get_annotations(base).items():
                if isinstance(wanted, str):
                    yield name, wanted.rpartition(".")[2]
                elif isinstance(wanted, type):
                    yield name, wanted


def _is_spared(variable: Variable[Any, Any]) -> bool:
    """Return True if a reset does not touch the variable: RETAIN, PERSISTENT or attribute
    `no_init`."""
    if variable.retain or variable.persistent or not variable.attributes:
        return variable.retain or variable.persistent
    return any(name.lower() in ("no_init", "noinit") for name in variable.attributes)


def _remanent_parts(type: IecType[Any], offset: int = 0) -> Iterator[tuple[int, int]]:
    """Offset and size of the retain and persistent members inside a variable.

    A BIT has neighbours in its byte: `retained_state` restores it.
    """
    type = resolved(type)
    if isinstance(type, StructType):
        for member in type.fields:
            if not _is_spared(member):
                yield from _remanent_parts(member.type, offset + member.offset)
            elif member.bit is None:
                yield offset + member.offset, member.type.size
    elif isinstance(type, ArrayType) and any(_remanent_parts(type.element)):
        for index in range(type.count):
            yield from _remanent_parts(type.element, offset + index * type.element.size)
