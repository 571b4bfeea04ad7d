"""A check that is kept: findings by their cause, so that a changed body alone is checked again.

Each routine, record and unit is a node. It has its own findings and names the nodes that it needs;
findings count while their node is needed, in the end by something that the project declares.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from achse.iec.structs import StaticRecord, StructType
from achse.st.check.body import RoutineBody
from achse.st.check.checking import Checking, NameUse
from achse.st.check.contracts import Contracts
from achse.st.check.reached import FAULTY
from achse.st.check.signatures import Signature
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed
from achse.st.lexis.codes import Code
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.cursor import Unexpected
from achse.st.typed.statements import LifeEvent, TypedStatement

__all__ = ["CheckNode", "WarmChecking"]

_ROOT = ""


class CheckNode:
    """Findings of one routine, record or unit, and the nodes that it needs."""

    __slots__ = ("faults", "needs", "warnings")

    def __init__(self) -> None:
        self.faults: dict[Diagnostic, None] = {}
        self.warnings: dict[Diagnostic, None] = {}
        self.needs: set[str] = set()


class WarmChecking(Checking):
    """Checks a project once, and then bodies that change.

    `is_exact` is False if declarations were reported at fault only because a body asked for
    them: then only a whole check gives all findings.
    """

    def __init__(
        self,
        names: Resolver,
        given: Iterable[type[StaticRecord]] = (),
        *,
        check_bounds: bool = True,
    ) -> None:
        super().__init__(names, given, check_bounds=check_bounds)
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
        own = [entry for entry in self.names.scopes.entries.values() if not entry.is_library]
        for entry in own:
            self._guarded(entry, self._begin)
        self._work()
        self._interfaces()
        self._late_faults = list(self.names.scopes.faults)[self._known_faults :]
        self.is_exact = not self._late_faults
        contracts = Contracts(self.names, self.blocks, self.routines, self.fault)
        for entry in own:
            contracts.check(entry)
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
            yield RoutineBody(self, routine)
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
            found, waiting = {_ROOT}, [_ROOT]
            while waiting:
                node = self.nodes.get(waiting.pop())
                fresh = set() if node is None else node.needs - found
                found |= fresh
                waiting += fresh
            self._needed = found
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
        self._checked.clear()  # no typed form is made
        self._statics.clear()
