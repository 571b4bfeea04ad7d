"""A project as one module of machine code: its routines, call dispatch, entries and callbacks."""

import marshal
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from achse.native.backend import CallTarget, FunctionBuilder, ModuleBuilder, Operand
from achse.plc.lowering.placement import MissingPlaceError, Placement
from achse.plc.lowering.project import LoweredProject
from achse.plc.machine.fault_places import FaultPlaces
from achse.plc.machine.outside import nodes_outside
from achse.plc.machine.routines import translate_routine, write_callback, write_entry
from achse.plc.machine.signatures import RoutineSignature, signature_of
from achse.plc.machine.support import AREA_ROW, COUNT_WORDS, ENTRIES, Support
from achse.plc.machine.values import NotTranslatedError
from achse.plc.memory import Area
from achse.st.typed.expressions import TypedValue
from achse.st.typed.project import Routine, TypedProject

_POINTER_SIZE = 8


@dataclass(slots=True)
class ModuleNotes:
    """Data of a module for the runtime, beside its code."""

    sites: FaultPlaces
    entries: dict[str, int] = field(default_factory=dict)
    """Translated routines and their places in the table of entries."""
    callbacks: list[tuple[str, str]] = field(default_factory=list)
    """Routines that Python runs: key of the routine whose signature it is, and of the one that
    runs."""
    outside: list[tuple[int, int]] = field(default_factory=list)
    """Nodes that Python does: number of the routine, and of the node in it."""
    texts: list[str] = field(default_factory=list)
    plain_routines: dict[str, str] = field(default_factory=dict)
    """Routines that stay plain, and why."""

    def packed(self) -> bytes:
        """Return all notes for the cache."""
        rows = (self.entries, self.callbacks, self.outside, self.texts, self.plain_routines)
        return marshal.dumps((self.sites.content, *rows))

    @classmethod
    def unpacked(cls, content: bytes) -> "ModuleNotes":
        """Return the notes from the output of `packed`."""
        sites, *rows = marshal.loads(content)
        return cls(FaultPlaces(sites), *rows)


class ProjectTranslator:
    """Translates all routines of a project that can be.

    `by_python` are keys of routines that Python does: built-ins, behaviour classes. `exceptions`
    is the task option "floating point exceptions". `counted` has the number of the first of all
    `counters` for each routine whose statements count.
    """

    def __init__(
        self,
        project: TypedProject,
        placement: Placement,
        by_python: Collection[str],
        *,
        exceptions: bool,
        counted: Mapping[str, int] | None = None,
        counters: int = 0,
        conditions: bool = False,
    ) -> None:
        self.placement = placement
        self.exceptions = exceptions
        self.module = ModuleBuilder()
        self.support = Support(self.module)
        self.notes = ModuleNotes(FaultPlaces())
        self.project = project
        self.lowered = LoweredProject(
            project, placement, exceptions=exceptions, counted=counted, conditions=conditions
        )
        self.counts = self.module.words(COUNT_WORDS, counters) if counters else None
        self._by_python = by_python
        self._numbers = {key: number for number, key in enumerate(project.routines)}
        self._functions: dict[str, CallTarget] = {}
        self._signatures: dict[str, RoutineSignature] = {}
        self._tables: dict[tuple[object, ...], tuple[Operand, int]] = {}
        self._outside: dict[int, dict[int, int]] = {}
        self._outside_numbers: dict[tuple[int, int], int] = {}
        self._sizes = {area: len(placement.memory[area]) & -_POINTER_SIZE for area in Area}
        self.pointer_size = next(
            (block.type.rules.pointer_size for block in project.blocks.values()), _POINTER_SIZE
        )

    @property
    def sites(self) -> FaultPlaces:
        """Sites that can raise faults."""
        return self.notes.sites

    def translated(self) -> ModuleBuilder:
        done: set[str] = set()
        for key, routine in self.project.routines.items():
            reason = self._untranslatable(routine)
            if not reason:
                builder = self.module.write(self.function(key))
                reason = self._translate(routine, builder)
                if reason:
                    self._write_callback(key, builder)
                done.add(key)
            if reason:
                self.notes.plain_routines[key] = reason
        for key in list(self._functions):
            if key not in done:
                self._write_callback(key, self.module.write(self._functions[key]))
        self._write_entries()
        self.module.notes = self.notes.packed()
        return self.module

    def _untranslatable(self, routine: Routine) -> str:
        if routine.key in self._by_python:
            return "Python does it"
        return "it has no Structured Text" if routine.body is None else ""

    def _translate(self, routine: Routine, builder: FunctionBuilder) -> str:
        """Translate a routine; return the reason why it stays plain, empty if it does not."""
        try:
            translate_routine(self, routine, self._numbers[routine.key], builder)
        except NotTranslatedError as reason:
            return str(reason)
        except MissingPlaceError as missing:
            return f"{missing.args[0]} has no memory in this PLC"
        except RecursionError:
            return "it is nested too deep"
        return ""

    def _write_callback(self, key: str, builder: FunctionBuilder) -> None:
        builder.clear()
        signature = self._signatures[key]
        self.notes.callbacks.append((key, key))
        write_callback(self, signature, builder, len(self.notes.callbacks) - 1)

    def _write_entries(self) -> None:
        """Write the table of entries: the functions that Python can call."""
        entries: list[CallTarget] = []
        for key, target in self._functions.items():
            if key in self.notes.plain_routines or key not in self.project.routines:
                continue
            signature = self._signatures[key]
            self.notes.entries[key] = len(entries)
            if signature.is_simple:
                entries.append(target)
            else:
                entries.append(write_entry(self, signature, target, f"in.{key}"))
        self.module.table(ENTRIES, entries)

    # requests of routine translators ---------------------------------------------------------

    def function(self, key: str) -> CallTarget:
        """Return the machine function of a routine."""
        function = self._functions.get(key)
        if function is None:
            signature = signature_of(self.project.routines[key])
            self._signatures[key] = signature
            function = self._functions[key] = self.module.declare(
                f"st.{key}", signature.parameters, signature.results, faults=True
            )
        return function

    def dispatch_table(self, name: str, declared: Routine) -> tuple[Operand, int]:
        """Functions by the numbers of blocks, and how many rows there are."""
        like = signature_of(declared, dispatched=True).like
        table = self._tables.get((name, like))
        if table is not None:
            return table
        blocks = self.project.block_numbered
        rows: list[CallTarget | None] = [None] * (max(blocks, default=0) + 1)
        for number, block in blocks.items():
            key = block.table.get(name, "")
            routine = self.project.routines.get(key)
            if routine is not None:
                rows[number] = (
                    self.function(key)
                    if signature_of(routine, dispatched=True).like == like
                    else self._adapter(declared, key)
                )
        place = len(self._tables)
        table = self._tables[name, like] = (self.module.table(f"methods.{place}", rows), len(rows))
        return table

    def _adapter(self, declared: Routine, key: str) -> CallTarget:
        """A method with other parameters than the one it stands for: Python sorts that out."""
        signature = signature_of(declared, dispatched=True)
        number = len(self.notes.callbacks)
        self.notes.callbacks.append((declared.key, key))
        target = self.module.declare(
            f"as.{number}", signature.parameters, signature.results, faults=True
        )
        write_callback(self, signature, self.module.write(target), number)
        return target

    def text_number(self, text: str) -> int:
        """Return the number of a name, as Python receives it."""
        if text not in self.notes.texts:
            self.notes.texts.append(text)
        return self.notes.texts.index(text)

    def outside(self, routine: int, node: TypedValue) -> int:
        """Return the number of a node that Python does."""
        nodes = self._outside.get(routine)
        if nodes is None:
            of = list(self.project.routines.values())[routine]
            nodes = self._outside[routine] = {
                id(one): place for place, one in enumerate(nodes_outside(of))
            }
        row = (routine, nodes[id(node)])
        number = self._outside_numbers.get(row)
        if number is None:
            number = self._outside_numbers[row] = len(self.notes.outside)
            self.notes.outside.append(row)
        return number

    def room(self, area: Area) -> int:
        """Return bytes of an area that code can reach."""
        return self._sizes[area]

    def address_of(self, area: Area) -> int:
        """Return the value of a pointer to the begin of an area."""
        return self.placement.memory.address(area, 0)

    def area_row(self, area: Area) -> int:
        """Return the offset of an area's row in the table of areas, bytes."""
        return (list(Area).index(area) + 1) * AREA_ROW
