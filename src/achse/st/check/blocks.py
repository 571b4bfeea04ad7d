"""Blocks: the methods, properties and actions of a unit with its bases, and its interfaces."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from achse.iec.derived import InterfaceType
from achse.iec.structs import StructType
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit
from achse.st.syntax.tree import NamedType
from achse.st.syntax.units import FunctionBlock, GlobalList, Interface, Part, Program, Property

_WITH_PARTS = (FunctionBlock, Program, Interface, GlobalList)


class FoundPart(NamedTuple):
    """A part, and the unit that declares it."""

    entry: DeclaredUnit
    part: Part


class Blocks:
    """Finds parts by name, each block looked through once."""

    def __init__(self, names: Resolver) -> None:
        self._names = names
        self._own: dict[int, dict[str, Part]] = {}
        self._parts: dict[int, dict[str, FoundPart]] = {}
        self._interfaces: dict[int, frozenset[str]] = {}

    def base(self, entry: DeclaredUnit) -> DeclaredUnit | None:
        """Return the block that a block extends, if a source declares it."""
        tree = entry.tree
        if not isinstance(tree, FunctionBlock) or tree.extends is None:
            return None
        base = self._names.scopes.find(tree.extends.name, entry.space)
        type = entry.type
        if isinstance(type, StructType) and type.base is not None:
            base = self._names.entry_of(type.base) or base
        if base is not None and isinstance(base.tree, FunctionBlock) and base is not entry:
            return base
        return None

    def chain(self, entry: DeclaredUnit) -> list[DeclaredUnit]:
        """Return the block and its bases, the most derived first."""
        chain: list[DeclaredUnit] = []
        here: DeclaredUnit | None = entry
        while here is not None and here not in chain:
            chain.append(here)
            here = self.base(here)
        return chain

    def bases_of_interface(self, entry: DeclaredUnit) -> Iterator[DeclaredUnit]:
        """Return the interfaces that an interface extends, all of them."""
        seen: set[int] = {id(entry)}
        waiting = [entry]
        while waiting:
            here = waiting.pop()
            tree = here.tree
            if not isinstance(tree, Interface):
                continue
            for named in tree.extends:
                base = self._interface(named, here)
                if base is not None and id(base) not in seen:
                    seen.add(id(base))
                    waiting.append(base)
                    yield base

    def _interface(self, named: NamedType, where: DeclaredUnit) -> DeclaredUnit | None:
        unit = self._names.scopes.find(named.name, where.space)
        return unit if unit is not None and isinstance(unit.tree, Interface) else None

    def own_parts(self, entry: DeclaredUnit) -> dict[str, Part]:
        """Return the parts that a unit declares itself, by name in lower case."""
        own = self._own.get(id(entry))
        if own is None:
            tree = entry.tree
            parts = tree.parts if isinstance(tree, _WITH_PARTS) else ()
            own = self._own[id(entry)] = {part.name.lower(): part for part in parts}
        return own

    def part(self, entry: DeclaredUnit, key: str) -> FoundPart | None:
        """Return the part of that name, in lower case: the unit's own, or of the nearest base."""
        parts = self._parts.get(id(entry))
        return (self._all_parts(entry) if parts is None else parts).get(key)

    def _all_parts(self, entry: DeclaredUnit) -> dict[str, FoundPart]:
        """Return the parts of a unit and its bases by name, kept once the types of the blocks are
        known."""
        units = self.chain(entry)
        is_final = all(
            here.type is not None or here.tree.__class__ is not FunctionBlock for here in units
        )
        if isinstance(entry.tree, Interface):
            units += self.bases_of_interface(entry)
        all_parts: dict[str, FoundPart] = {}
        for here in units:
            for key, part in self.own_parts(here).items():
                all_parts.setdefault(key, FoundPart(here, part))
        if is_final:
            self._parts[id(entry)] = all_parts
        return all_parts

    def accessor(
        self, entry: DeclaredUnit, tree: Property, *, get: bool
    ) -> tuple[DeclaredUnit, Property]:
        """Return the property whose GET or SET is called: its own, or the nearest base's with
        one."""
        units = self.chain(entry)
        if isinstance(entry.tree, Interface):
            units += self.bases_of_interface(entry)
        key = tree.name.lower()
        for here in units:
            part = self.own_parts(here).get(key)
            if isinstance(part, Property) and (part.get if get else part.set) is not None:
                return here, part
        return entry, tree

    def interfaces(self, entry: DeclaredUnit) -> frozenset[str]:
        """Return the keys of all interfaces that a block (or interface) has, its bases'
        included."""
        interfaces = self._interfaces.get(id(entry))
        if interfaces is None:
            self._interfaces[id(entry)] = frozenset()
            keys: set[str] = set()
            for here in self.chain(entry):
                for named in getattr(here.tree, "implements", ()):
                    one = self._interface(named, here)
                    if one is not None:
                        keys.add(one.name.lower())
                        keys |= {base.name.lower() for base in self.bases_of_interface(one)}
                    else:
                        keys |= self._predefined_interfaces(named.name)
            if isinstance(entry.tree, Interface):
                keys |= {base.name.lower() for base in self.bases_of_interface(entry)}
            interfaces = self._interfaces[id(entry)] = frozenset(keys)
        return interfaces

    def _predefined_interfaces(self, name: str) -> set[str]:
        """Return the keys of an interface of a symbol file and of its bases there."""
        names: set[str] = set()
        while name and name.lower() not in names:
            names.add(name.lower())
            signature = self._names.predefined.signature(name)
            name = "" if signature is None else signature.extends
        return names

    def implements(self, type: StructType[Any], interface: InterfaceType) -> bool | None:
        """Return True if a function block has an interface, None if its declaration is not
        known."""
        entry = self._names.entry_of(type)
        if entry is None:
            return None
        wanted = interface.name.lower()
        here = self.interfaces(entry)
        # A symbol file has the library in front of the name.
        if wanted in here or wanted.rpartition(".")[2] in here:
            return True
        # Every block has the interface from which the vendor's own come; and a base without
        # sources may have any.
        if wanted in ("iqueryinterface", "__system.iqueryinterface"):
            return True
        return None if self.has_unknown_base(entry) else False

    def has_unknown_base(self, entry: DeclaredUnit) -> bool:
        """Return True if a base of a block has no source: it may have any part and interface."""
        last = self.chain(entry)[-1].tree
        return isinstance(last, FunctionBlock) and (
            last.extends is not None or "stub" in dict(last.note.attributes)
        )
