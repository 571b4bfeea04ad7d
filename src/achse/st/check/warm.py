"""A check that is kept: findings by their cause, so that a changed body alone is checked again.

Each routine, record and unit is a node. It has its own findings and names the nodes that it needs;
findings count while their node is needed, in the end by something that the project declares.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

from achse.iec.structs import StaticRecord, StructType
from achse.st.check.blocks import Blocks
from achse.st.check.body import RoutineBody
from achse.st.check.checking import Checking, NameUse
from achse.st.check.contracts import Contracts
from achse.st.check.reached import FAULTY
from achse.st.check.signatures import Signature
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed, is_instance_of_any
from achse.st.lexis.codes import Code
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.units import Part, Property
from achse.st.typed.project import RoutineKind
from achse.st.typed.statements import LifeEvent, TypedStatement

Inspection: TypeAlias = Callable[[object], Iterable[tuple[Code, int, str]]]
"""Function that finds something in the typed statements of a body without faults: code, offset and
message."""

_ROOT = ""
_INTERFACES = "interfaces"
_KINDS = ("declared", "unit", "record")
"""First words in the keys of nodes that are not routines."""


class CheckNode:
    """Findings of one routine, record or unit, and the nodes that it needs."""

    __slots__ = ("faults", "needs", "remarks", "warnings")

    def __init__(self) -> None:
        self.faults: dict[Diagnostic, None] = {}
        self.warnings: dict[Diagnostic, None] = {}
        self.remarks: dict[Diagnostic, None] = {}
        """Findings of the inspection of a body."""
        self.needs: set[str] = set()


class WarmChecking(Checking):
    """Checks a project once, and then bodies that change.

    `is_exact` is False if declarations were reported at fault only because a body asked for
    them: then only a whole check gives all findings.
    """

    def __init__(
        self,
        names: Resolver,
        predefined: Iterable[type[StaticRecord]] = (),
        *,
        check_bounds: bool = True,
        inspect: Inspection | None = None,
    ) -> None:
        super().__init__(names, predefined, check_bounds=check_bounds)
        self._inspect = inspect
        self.nodes: dict[str, CheckNode] = {_ROOT: CheckNode()}
        self.is_exact = True
        self._key = _ROOT
        self._node = self.nodes[_ROOT]
        self._needed: set[str] | None = None
        self._late_faults: list[Diagnostic] = []

    @contextmanager
    def _inside(self, key: str) -> Iterator[None]:
        """Let findings and needs belong to this node meanwhile."""
        outside = self._key, self._node
        self._key, self._node = key, self.nodes.setdefault(key, CheckNode())
        try:
            yield
        finally:
            self._key, self._node = outside

    # all at once -----------------------------------------------------------------------------

    @collection_paused()
    def start(self) -> None:
        """Check everything that the project declares, and what it needs of libraries."""
        self._check_units(
            entry for entry in self.names.scopes.entries.values() if not entry.is_library
        )

    def _check_units(self, units: Iterable[DeclaredUnit]) -> None:
        """Check units of the project, and what they need."""
        own = list(units)
        for entry in own:
            with self._inside(_unit_node(entry.name)):
                self._guarded(entry, self._begin)
            self.nodes[_ROOT].needs.add(_unit_node(entry.name))
        self._work()
        self.nodes.pop(_INTERFACES, None)
        self.nodes[_ROOT].needs.add(_INTERFACES)
        with self._inside(_INTERFACES):
            self._interfaces()
        self._late_faults = list(self.names.scopes.faults)[self._known_faults :]
        self.is_exact = not self._late_faults
        with self.names.scopes.without_new_faults() as failed:
            contracts = Contracts(self.names, self.blocks, self.routines, self.fault)
            for entry in own:
                with self._inside(_unit_node(entry.name)):
                    contracts.check(entry)
        self.routines.forget(lambda entry: entry in failed)
        self._known_faults = len(self.names.scopes.faults)

    @collection_paused()
    def check_again(self, routines: Iterable[Signature]) -> None:
        """Check routines whose bodies changed, and what they need now."""
        for known in routines:
            earlier = self.nodes.pop(known.key)
            self._left_out.pop(known.key, None)
            try:
                self._check_routine(self.routines.made_again(known))
            except (Failed, Unexpected):  # its declaration was in order
                self.is_exact = False
                return
            if self.nodes[known.key].needs != earlier.needs:
                self._needed = None
        self._work()
        self.is_exact &= len(self.names.scopes.faults) == self._known_faults

    @collection_paused()
    def check_touched(
        self,
        units: Collection[str],
        words: Collection[str],
        routines: Iterable[Signature],
        unchanged: Iterable[Signature] = (),
    ) -> None:
        """Check units that were declared again, keys in lower case, with all that they need, and
        routines of others. `words` are the names of these units and of their contents; `unchanged`
        are routines of these units with the same findings."""
        dropped = self._forget(units, words, list(unchanged))
        self._needed = None
        for known in routines:
            self.nodes.pop(known.key)
            self._left_out.pop(known.key, None)
            try:
                self._check_routine(self.routines.made_again(known))
            except (Failed, Unexpected):  # its declaration was in order
                self.is_exact = False
                return
        entries = self.names.scopes.entries.items()
        self._check_units(entry for key, entry in entries if key in units and not entry.is_library)
        lost = dropped - self.nodes.keys()
        self.is_exact &= lost.isdisjoint(self._reachable())

    def _forget(
        self, units: Collection[str], words: Collection[str], unchanged: Collection[Signature]
    ) -> set[str]:
        """Forget all about units but some routines; return the nodes that are gone."""
        self._known_faults = len(self.names.scopes.faults)
        remaining = {routine.key for routine in unchanged}
        dropped = {
            key for key in self.nodes if is_instance_of_any(self._owner_of(key), units)
        } - remaining
        for key in dropped:
            del self.nodes[key]
            self._pending_names.discard(key)
            self._left_out.pop(key, None)
            self._notes.pop(key, None)
        for key in units:
            self._left_out.pop(key, None)
        self.nodes[_ROOT].needs -= dropped
        tables: tuple[dict[str, Any], ...] = (self._units, self._records, self._blocks)
        for table in tables:
            for key in [key for key in table if is_instance_of_any(key, units)]:
                del table[key]
        self._requested_records = {
            key for key in self._requested_records if not is_instance_of_any(key, units)
        }
        self._functions = {
            k: function for k, function in self._functions.items() if _last(k) not in words
        }
        self.plain_names = {
            key: name for key, name in self.plain_names.items() if _last(key[1]) not in words
        }
        self._pointers.clear()
        self.blocks = Blocks(self.names)
        self.routines.forget(lambda entry: is_instance_of_any(entry.name.lower(), units))
        self.routines.outdate(unchanged)
        self.life.forget(lambda key: is_instance_of_any(key.rpartition(".")[0], units))
        return dropped

    def _owner_of(self, key: str) -> str:
        """Return the key of the block, program, list or function that a node belongs to."""
        kind, blank, name = key.partition(" ")
        if blank and kind in _KINDS:
            return name
        entry = self.routines.entry(key)
        return key.rpartition(".")[0] if entry is None else entry.name.lower()

    def unit_of(self, key: str) -> str:
        """Return the key of the unit that a node belongs to."""
        return self._owner_of(key).partition("<")[0]

    def uses_of(self, routine: Signature) -> list[NameUse]:
        """Return the meanings of the names in a routine; its findings stay the same."""
        self.uses = []
        try:
            self.check_again([routine])
            return self.uses
        finally:
            self.uses = None

    @contextmanager
    def probing(self, routine: Signature) -> Iterator[RoutineBody]:
        """Look names up as a routine sees them; what is found meanwhile is forgotten."""
        outside = self._key, self._node
        self._key, self._node = "?", CheckNode()
        try:
            yield RoutineBody(self, self.routines.known(routine.key) or routine)
        finally:
            self._key, self._node = outside

    def checked(self, key: str) -> Signature | None:
        """Return the signature of a routine that was checked; None if nothing needs it."""
        return self.routines.known(key) if key in self.nodes else None

    # findings --------------------------------------------------------------------------------

    @property
    def faults(self) -> list[Diagnostic]:
        """Faults of the nodes that are needed."""
        return [*self._late_faults, *(one for node in self._live_nodes() for one in node.faults)]

    @property
    def warnings(self) -> list[Diagnostic]:
        """Warnings of the nodes that are needed."""
        return [one for node in self._live_nodes() for one in node.warnings]

    def remarks(self, gone: Collection[str]) -> list[Diagnostic]:
        """Findings of the inspection in bodies that are needed, but for those of some units."""
        needed = self._reachable()
        return [
            one
            for key, node in self.nodes.items()
            if node.remarks and key in needed and self.unit_of(key) not in gone
            for one in node.remarks
        ]

    @property
    def faulty_routines(self) -> dict[str, str]:
        """Routines with faults that are needed, as the typed form leaves them out."""
        needed = self._reachable()
        return {key: why for key, why in self._left_out.items() if why == FAULTY and key in needed}

    def _live_nodes(self) -> list[CheckNode]:
        needed = self._reachable()
        return [node for key, node in self.nodes.items() if key in needed]

    def _reachable(self) -> set[str]:
        if self._needed is None:
            reachable, waiting = {_ROOT}, [_ROOT]
            while waiting:
                node = self.nodes.get(waiting.pop())
                fresh = set() if node is None else node.needs - reachable
                reachable |= fresh
                waiting += fresh
            self._needed = reachable
        return self._needed

    # which node it is for --------------------------------------------------------------------

    def warn(self, source: Source, at: int, message: str, code: Code) -> None:
        self._node.warnings.setdefault(source.fault(at, message, code))

    def fault(self, source: Source, at: int, message: str, code: Code) -> None:
        self._node.faults.setdefault(source.fault(at, message, code))

    def unit(self, entry: DeclaredUnit, at: int) -> StructType[Any]:
        self._node.needs.add(f"unit {entry.name.lower()}")
        return super().unit(entry, at)

    def require(self, signature: Signature) -> None:
        self._node.needs.add(signature.key)
        super().require(signature)

    def _require_part(self, entry: DeclaredUnit, part: Part) -> None:
        keys = _keys_of(entry, part)
        if all(map(self.routines.is_outdated, keys)):
            self._node.needs.update(keys)
        else:
            super()._require_part(entry, part)

    def require_record(self, type: StructType[Any]) -> None:
        self._node.needs.add(f"record {type.name.lower()}")
        super().require_record(type)

    def _guarded(self, entry: DeclaredUnit, work: Callable[[DeclaredUnit], None]) -> None:
        is_record = work == self._record
        with self._inside(f"record {entry.name.lower()}" if is_record else self._key):
            super()._guarded(entry, work)

    def _unit(self, entry: DeclaredUnit) -> None:
        with self._inside(f"unit {entry.name.lower()}"):
            super()._unit(entry)

    def _life_of(self, type: StructType[Any]) -> tuple[str, str, str]:
        keys = super()._life_of(type)
        self._node.needs.update(filter(None, keys))
        return keys

    def _live(self, type: StructType[Any], event: LifeEvent) -> None:
        with self._inside(self.life.signature(type, event).key):
            super()._live(type, event)

    def _check_routine(self, signature: Signature) -> None:
        with self._inside(signature.key):
            super()._check_routine(signature)

    def _finish(
        self,
        body: Any,
        opening: tuple[TypedStatement, ...],
        statements: tuple[TypedStatement, ...] | None,
        builtin: bool,
    ) -> None:
        super()._finish(body, opening, statements, builtin)
        if self._inspect is not None and body.signature.kind is not RoutineKind.LIFE:
            source = body.signature.source
            for checked in self._checked:
                for code, at, message in self._inspect(checked.statements):
                    self._node.remarks.setdefault(source.fault(at, message, code))
        self._checked.clear()  # no typed form is made
        self._statics.clear()


def _unit_node(name: str) -> str:
    """Return the key of the node for what a unit declares itself."""
    return f"declared {name.lower()}"


def _keys_of(entry: DeclaredUnit, part: Part) -> list[str]:
    """Return the keys of the routines that a part of a unit is."""
    if not isinstance(part, Property):
        return [f"{entry.name}.{part.name}".lower()]
    kinds = [kind for kind, one in (("get", part.get), ("set", part.set)) if one is not None]
    return [f"{entry.name}.__{kind}{part.name}".lower() for kind in kinds]


def _last(key: str) -> str:
    """Return a name without the name space in front."""
    return key.rpartition(".")[2]
