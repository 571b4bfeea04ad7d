"""Frames: where the parameters, locals and temporaries of a routine are."""

from typing import Any

from achse.iec.elementary import BOOL, BoolType
from achse.iec.layout import LayoutRules, MemberOffset, TypeLayout, align
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable
from achse.st.typed.places import FrameBase, Storage, flat

_FRAME = FrameBase()


class VariableFrame:
    """Variables one after the other, each at its natural alignment."""

    def __init__(self, name: str, rules: LayoutRules) -> None:
        self._name = name
        self._rules = rules
        self.variables: list[Variable[Any, Any]] = []
        self._by_name: dict[str, Variable[Any, Any]] = {}
        self._size = 0
        self._alignment = 1
        self._temporaries = 0
        self.addressed: set[str] = set()

    def add(self, variable: Variable[Any, Any]) -> Variable[Any, Any]:
        """Give a variable its place; a BIT has a byte of its own here."""
        type = variable.type
        if isinstance(type, BoolType) and type.is_bit:
            variable.type = type = BOOL
        needed = min(type.alignment, self._rules.pack)
        offset = align(self._size, needed)
        placed: Variable[Any, Any] = variable.placed(variable.name, offset, None)
        self.variables.append(placed)
        self._by_name[placed.name.lower()] = placed
        self._size = offset + type.size
        self._alignment = max(self._alignment, needed)
        return placed

    def hidden(self, name: str, type: IecType[Any]) -> Variable[Any, Any]:
        """Return a variable of the checker's own."""
        return self.add(Variable(type, name=name, section=Section.LOCAL))

    def temporary(self, type: IecType[Any]) -> Variable[Any, Any]:
        """Return a hidden variable for a value that needs an address."""
        self._temporaries += 1
        variable = self.hidden(f"__t{self._temporaries}", type)
        self.addressed.add(variable.name)
        return variable

    def find(self, key: str) -> Variable[Any, Any] | None:
        """Return the variable of that name, in lower case."""
        return self._by_name.get(key)

    def storage(self, variable: Variable[Any, Any], at: int) -> Storage:
        """Return the storage of a variable of the frame."""
        type = flat(variable.type)
        return Storage(_FRAME, variable.offset, type, None, (), False, variable.name, at)

    def structure(self) -> StructType[Any]:
        """Return the frame as a type: offsets, and the bytes it starts with."""
        spots = tuple(MemberOffset(variable.offset) for variable in self.variables)
        size = align(self._size, self._alignment)
        return StructType(
            self._name,
            self.variables,
            rules=self._rules,
            layout=TypeLayout(size, self._alignment, spots),
        )
