"""Enumerations: named values of an integer type, as Python enum members.

Source: IEC 61131-3 (2013) table 11, no. 1 and 2.
"""

from collections.abc import Mapping
from enum import IntEnum
from functools import cached_property
from typing import Any, ClassVar, Generic, TypeVar

from achse.iec.elementary import INT, IntegerType
from achse.iec.errors import DeclarationError
from achse.iec.types import Buffer, IecType, no_attributes

E = TypeVar("E", bound=IntEnum)


class EnumType(IecType[E | int], Generic[E]):
    """The members of an `IntEnum` in a base type.

    `names` are those of members whose Python names differ: `_` and the like cannot name one.

    Decodes to the member; a number that is not a member stays an int, as a PLC allows any. Takes
    members, numbers in range of the base, and member names (without case).
    """

    def __init__(
        self,
        members: type[E],
        base: IntegerType = INT,
        *,
        name: str = "",
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
        comments: Mapping[str, str] = no_attributes,
        initial: int | None = None,
        names: Mapping[str, str] = no_attributes,
    ) -> None:
        name = name or members.__name__
        # `__members__` keeps aliases: two names of one number are two rows of the type table.
        self.numbers = {
            names.get(member, member): int(value) for member, value in members.__members__.items()
        }
        for member, number in self.numbers.items():
            if not base.low <= number <= base.high:
                raise DeclarationError(f"{name}.{member} = {number} is not a {base.name}")
        super().__init__(
            name, base.size, base.alignment, base.adst, comment=comment, attributes=attributes
        )
        self.members = members
        self.base = base
        self.comments = comments
        """Comment of each member that has one, by name."""
        self._initial = initial
        self._by_number: dict[int, E] = {int(member): member for member in members}
        self._by_name = {member.lower(): number for member, number in self.numbers.items()}

    def describe(self) -> str:
        return f"{self.name} {self.base.name} {self.numbers}"

    @cached_property
    def default(self) -> bytes:
        """The declared initial value, else the first member."""
        first = next(iter(self.numbers.values()), 0)
        return self.base.encode(first if self._initial is None else self._initial)

    def member(self, number: int) -> E | int:
        """Return the member of a number, or the number itself."""
        return self._by_number.get(number, number)

    def encode(self, value: object) -> bytes:
        if isinstance(value, str):
            value = self._by_name.get(value.strip().rpartition(".")[2].lower(), value)
        try:
            return self.base.codec.pack(value)
        except Exception:
            raise self.reject(value) from None

    def decode(self, data: bytes | Buffer) -> E | int:
        number = self.base.decode(data)
        return self._by_number.get(number, number)

    def read(self, buffer: Buffer, offset: int) -> E | int:
        number: int = self.base.codec.unpack_from(buffer, offset)[0]
        return self._by_number.get(number, number)

    @property
    def expected(self) -> str:
        names = list(self.numbers)
        some = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
        return f"one of {some}, or {self.base.expected}"


class Enumeration(IntEnum):
    """Base of enumerations declared in Python: `class E_State(Enumeration, base=UINT): …`.

    Class arguments: `base` (INT), `name` (the class name), `comment`, `attributes`, `initial`.
    """

    __iec__: ClassVar[EnumType[Any]]

    def __init_subclass__(
        cls,
        base: IntegerType = INT,
        *,
        name: str = "",
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
        initial: int | None = None,
    ) -> None:
        super().__init_subclass__()
        cls.__iec__ = EnumType(
            cls, base, name=name, comment=comment, attributes=attributes, initial=initial
        )
