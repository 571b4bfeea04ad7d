"""Contents of a symbol file: types, variables with their places, tasks; and units made of them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from achse.codes import PlcGroup, ReservedGroup
from achse.iec.arrays import ArrayType
from achse.iec.declare import GlobalVariables, Program
from achse.iec.derived import InterfaceType, PointerType
from achse.iec.names import ELEMENTARY
from achse.iec.strings import StringType
from achse.iec.structs import RecordKind, RecordMeta, StaticRecord, StructType
from achse.iec.symbols import SymbolEntry, SymbolFlag, fold
from achse.iec.types import IecType
from achse.iec.typetable import TypeTable
from achse.iec.variables import Address, Variable
from achse.st.files.tasks import FileTask

MEMORY_GROUPS: Mapping[int, tuple[str, bool]] = {
    PlcGroup.FLAGS: ("M", False),
    PlcGroup.FLAG_BITS: ("M", True),
    PlcGroup.RETAIN: ("R", False),
    PlcGroup.RETAIN_BITS: ("R", True),
    PlcGroup.DATA: ("D", False),
    PlcGroup.DATA_BITS: ("D", True),
    ReservedGroup.INPUTS: ("I", False),
    ReservedGroup.INPUT_BITS: ("I", True),
    ReservedGroup.OUTPUTS: ("Q", False),
    ReservedGroup.OUTPUT_BITS: ("Q", True),
}
"""The area of an `Address` that an index group means, and whether its offsets count bits."""

SYSTEM_LIST = "twincat_systeminfovarlist"
"""Every PLC makes this list for itself, so that its data of the tasks is right."""


@dataclass(frozen=True, slots=True)
class FileVariable:
    """A variable by its whole name; its declaration carries the place as `address`."""

    name: str
    declared: Variable[Any, Any]
    task: int = 0
    """Number of its task in the file, from 0."""
    is_global: bool = False
    """True if the file marks the variable as part of a global variable list."""


@dataclass(frozen=True, slots=True)
class SymbolFile:
    """The content of a `.tmc` or `.tpy`, or what shall be written as one."""

    name: str
    variables: Sequence[FileVariable] = ()
    types: Sequence[IecType[Any]] = ()
    """The derived types; what else variables are made of is found from them."""
    tasks: Sequence[FileTask] = field(default=(FileTask("PlcTask"),))
    port: int = 851
    pointer_size: int = 8

    @classmethod
    def of_target(
        cls,
        name: str,
        symbols: Iterable[SymbolEntry],
        types: TypeTable,
        *,
        port: int = 851,
        pointer_size: int = 8,
    ) -> "SymbolFile":
        """Return the upload of a target (0xF00B, 0xF00E) as a file.

        Symbols outside the memory areas of a PLC are left out. Raises `IecDecodeError` for
        entries that contradict themselves.
        """
        variables = []
        tasks = 1
        for entry in symbols:
            place = MEMORY_GROUPS.get(entry.index_group)
            if place is None:
                continue
            area, in_bits = place
            type = types.symbol_type(entry)
            offset = entry.index_offset if in_bits else 8 * entry.index_offset
            task = max(entry.context - 1, 0)
            tasks = max(tasks, task + 1)
            variables.append(
                FileVariable(
                    entry.name,
                    Variable(
                        type,
                        name=entry.name,
                        at=address_of(area, offset, in_bits or type.is_bit),
                        retain=area == "R",
                        persistent=bool(entry.flags & SymbolFlag.PERSISTENT),
                        constant=bool(entry.flags & SymbolFlag.READ_ONLY),
                        comment=entry.comment,
                        attributes=dict(entry.attributes),
                    ),
                    task,
                )
            )
        named = (types.type(entry.name) for entry in types)
        return cls(
            name,
            variables,
            [type for type in named if is_defined(type)],
            [FileTask(f"Task{number + 1}") for number in range(tasks)],
            port,
            pointer_size,
        )

    def called_tasks(self) -> list[FileTask]:
        """Return the tasks with the programs they call.

        A `.tmc` lacks it; there a program belongs to the task of its first variable.
        """
        if any(task.programs for task in self.tasks):
            return list(self.tasks)
        programs: dict[str, tuple[str, int]] = {}
        for item in self.variables:
            name = item.name.partition(".")[0]
            if not item.is_global and fold(name) != SYSTEM_LIST:
                programs.setdefault(fold(name), (name, item.task))
        lists = {fold(item.name.partition(".")[0]) for item in self.variables if item.is_global}
        return [
            task._replace(
                programs=tuple(
                    name
                    for key, (name, of_task) in programs.items()
                    if of_task == number and key not in lists
                )
            )
            for number, task in enumerate(self.tasks)
        ]

    def units(self) -> list[type[StaticRecord]]:
        """Programs and variable lists that hold exactly these variables at these places."""
        return units_of(self.variables)


def is_defined(type: IecType[Any]) -> bool:
    """Return True if a type has a name of its own, which a symbol file has to define."""
    if type.name.lower() in ELEMENTARY or isinstance(type, ArrayType | StringType):
        return False
    return isinstance(type, InterfaceType) or not isinstance(type, PointerType)


def units_of(variables: Iterable[FileVariable]) -> list[type[StaticRecord]]:
    """One unit for each first part of a name (`GVL` of `GVL.fbValve.bOpen`), in file order.

    A variable of a part of a variable (`AT %Q*` inside a function block) is one of its own.
    The list about the system itself is left out: each PLC has its own.
    """
    grouped: dict[str, list[FileVariable]] = {}
    for item in variables:
        grouped.setdefault(fold(item.name.partition(".")[0]), []).append(item)
    grouped.pop(SYSTEM_LIST, None)
    return [_unit(items) for items in grouped.values()]


def _unit(items: Sequence[FileVariable]) -> type[StaticRecord]:
    name = items[0].name.partition(".")[0]
    members: dict[str, Variable[Any, Any]] = {}
    for item in items:
        member = item.name.partition(".")[2]
        copy = item.declared.copy()
        copy.name = member
        members.setdefault(fold(member), copy)
    kind = GlobalVariables if any(item.is_global for item in items) else Program
    iec: StructType[Any] = StructType(name, list(members.values()), kind=RecordKind.UNIT)
    namespace = {item.name: item for item in iec.members if item.name.isidentifier()}
    return RecordMeta(name or "Globals", (kind,), namespace, iec=iec)  # type: ignore[return-value]


def address_of(area: str, bit_offset: int, is_bit: bool) -> Address:
    """Return the place in an area `bit_offset` bits from its start."""
    byte, bit = divmod(bit_offset, 8)
    return Address(area, "X" if is_bit else "", byte, bit if is_bit else None)
