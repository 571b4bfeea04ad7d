"""Instances: the lifecycle of function blocks, from FB_init to FB_exit, and their online change."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.errors import DeclarationError
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Section
from achse.plc.code.execution import Execution
from achse.plc.lifecycle.instance_moves import InstanceMoves, is_alike, unit_variable
from achse.plc.lifecycle.static_instances import StaticInstances
from achse.plc.lowering.calls import parameters_of
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable
from achse.plc.routines.routine_calls import outside_cycle
from achse.st.check.kinds import known_from
from achse.st.typed.places import flat
from achse.st.typed.project import InitCall, Routine, TypedProject

_RETAINS = _COPYING = True
"""Flags of FB_init and FB_exit, by their names in words."""


class InstanceLifecycle:
    """Begins, copies and ends the instances of a project whose code is linked with a memory."""

    def __init__(
        self,
        project: TypedProject,
        memory: Memory,
        variables: Sequence[PlacedVariable],
        execution: Execution,
    ) -> None:
        self._project = project
        self._memory = memory
        self._variables = variables
        self._execution = execution

    def create(self, moves: InstanceMoves | None = None, known: Collection[str] = ()) -> None:
        """Create all instances: FB_init, start values, call_after_init, in order.

        With `moves`, those that begin in an online change; VAR_STAT that are `known` go on.
        """
        with outside_cycle(self._execution):
            statics = [one for one in self._variables if one.variable.section is Section.STATIC]
            static_instances = StaticInstances(
                self._project, self._memory, self._execution.function
            )
            static_instances.begin([*statics, *self._execution.placement.statics.values()], known)
            for unit in self._project.units.values():
                if moves is None:
                    self._with_flags(unit.create, _RETAINS, False)
                else:
                    self._part(unit.create, moves.again, False, _COPYING)
                    self._part(unit.create, moves.new, _RETAINS, False)
            if moves is None:
                self._call_in_slots(self._project.init_calls)

    def online_changed(self, after: TypedProject) -> None:
        """Call the methods for online changes: of block layouts first, then of any change."""
        before = after.blocks
        changed = {
            key
            for key, block in self._project.blocks.items()
            if key in before and not is_alike(before[key].type, block.type)
        }
        with outside_cycle(self._execution) as run:
            for call in self._project.type_change_calls:
                routine = self._project.routines.get(call.routine)
                if routine is not None and call.types & changed:
                    values = _start_values(routine)
                    for address in self._instances_of(call.block):
                        run.function(call.routine)(*address, *values)
            self._call_in_slots(self._project.online_change_calls)

    def _call_in_slots(self, calls: Iterable[InitCall]) -> None:
        for call in calls:
            if call.routine in self._project.routines:
                for address in self._instances_of(call.block):
                    self._execution.function(call.routine)(*address)

    def _instances_of(self, block: str) -> list[tuple[int, ...]]:
        """Return the call arguments for each instance of a block: its address; without a block one
        call without arguments."""
        if not block:
            return [()]
        wanted = self._project.blocks[block].type.name
        arguments: list[tuple[int, ...]] = []
        for placed in self._variables:
            start = self._memory.address(placed.area, placed.offset)
            arguments += [(start + offset,) for offset in _places_of(wanted, placed.variable.type)]
        return arguments

    def exit(self, moves: InstanceMoves) -> None:
        """Run FB_exit of the instances that an online change ends."""
        with outside_cycle(self._execution):
            for unit in reversed(list(self._project.units.values())):
                self._part(unit.exit, moves.again, _COPYING)
                self._part(unit.exit, moves.gone, False)

    def reinit(self, moves: InstanceMoves) -> None:
        """Run FB_reinit after values were copied."""
        with outside_cycle(self._execution):
            for unit in self._project.units.values():
                self._part(unit.reinit, moves.copied)

    def allocations(self) -> Iterator[tuple[int, IecType[Any]]]:
        """Address and type of each record that `__NEW` made."""
        for address, of, count in self._execution.heap.allocations():
            for number in range(count):
                yield address + number * of.size, of

    def refuse_other_layouts(self, declared: Mapping[str, StructType[Any]]) -> None:
        """Raise `DeclarationError` if what `__NEW` made would have another layout.

        `declared` are the types from now on, by name in lower case. (The vendor's tools take no
        online change then either: such memory does not move.)
        """
        for _, of, _ in self._execution.heap.allocations():
            new = declared.get(of.name.lower())
            if new is None or not is_alike(of, new):
                what = "is gone" if new is None else "has another layout"
                raise DeclarationError(
                    f"{of.name} {what}, but there are instances that __NEW made: this takes"
                    " a reset or a restart, not an online change"
                )

    def _part(self, key: str, names: Collection[str], *flags: bool) -> None:
        """Run the statements of a unit's routine that concern some of its variables."""
        if not key or not names:
            return
        part = self._execution.part(key, lambda statement: unit_variable(statement) in names)
        if part is not None:
            part(*flags[: len(self._project.routines[key].parameters)])

    def _with_flags(self, key: str, *flags: bool) -> None:
        routine = self._project.routines.get(key)
        if routine is not None:
            self._execution.function(key)(*flags[: len(routine.parameters)])


def _start_values(routine: Routine) -> list[Any]:
    """Return the start values of a routine's inputs."""
    return [
        known_from(item.initial_bytes(), flat(item.type)).value for item in parameters_of(routine)
    ]


def _places_of(wanted: str, type: IecType[Any], offset: int = 0) -> Iterator[int]:
    """Offsets of all records of a name inside a type: an online change of bodies only leaves the
    types of variables as they are."""
    type = resolved(type)
    if isinstance(type, StructType):
        base: StructType[Any] | None = type
        while base is not None:
            if base.name == wanted:
                yield offset
                break
            base = base.base
        for member in type.fields:
            yield from _places_of(wanted, member.type, offset + member.offset)
    elif isinstance(type, ArrayType) and any(True for _ in _places_of(wanted, type.element)):
        for index in range(type.count):
            yield from _places_of(wanted, type.element, offset + index * type.element.size)
