"""Paths: members, bits, and targets of pointers."""

from typing import TYPE_CHECKING, Any

from achse.iec.derived import InterfaceType, PointerType, ReferenceType, resolved
from achse.iec.elementary import BOOL, BYTE, DINT, DWORD, LWORD, WORD, BoolType, IntegerType
from achse.iec.enums import EnumType
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section
from achse.st.check.conversions import converted
from achse.st.check.meanings import (
    BaseInstance,
    Meaning,
    PropertyUse,
    SpaceName,
    TypeName,
    UnitName,
)
from achse.st.check.names import replaced
from achse.st.check.operands import TypedOperand, address_of, constant_operand, known, read
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Dereference, Member, PartOf, Super, This
from achse.st.syntax.units import Program
from achse.st.typed.expressions import (
    Computed,
    Known,
    Operator,
    Read,
    TypedValue,
)
from achse.st.typed.places import (
    InstanceBase,
    PointerBase,
    Storage,
    TemporaryBase,
    flat,
)
from achse.st.values.values import Constant

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_PARTS: dict[str, IecType[Any]] = {"X": BOOL, "B": BYTE, "W": WORD, "D": DWORD, "L": LWORD}


class Paths:
    """Follows the steps of paths in one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    # storages --------------------------------------------------------------------------------

    def storage(self, operand: TypedOperand, at: int) -> Storage:
        """Return the storage of an operand; a value is put into a temporary."""
        if operand.storage is not None:
            return operand.storage
        variable = self._body.frame.temporary(operand.flat)
        base = TemporaryBase(variable, operand.value)
        return Storage(base, 0, operand.flat, name=variable.name, at=at)

    def address(self, operand: TypedOperand, type: IecType[Any], at: int) -> TypedValue:
        """Return the address of an operand."""
        storage = self.storage(operand, at)
        if storage.bit is not None:
            raise Unexpected(at, f"a bit has no address: {storage.name}", Code.NO_ADDRESS)
        self._body.mark_addressed(storage)
        return address_of(storage, type, at)

    def is_exact(self, storage: Storage) -> bool:
        """Return True if an instance is of the declared block itself, not of a derived block."""
        is_this = isinstance(storage.base, InstanceBase) and storage.type is self._body.this
        return not isinstance(storage.base, PointerBase) and not is_this

    # members ---------------------------------------------------------------------------------

    def member(self, tree: Member) -> Meaning:
        """`of.name`."""
        whole = self._body.expressions.meaning(tree.of)
        at = tree.at
        match whole:
            case TypedOperand():
                return self.member_of(whole, tree.name, at)
            case TypeName():
                return self._of_type(whole, tree.name, at)
            case UnitName():
                return self._of_unit(whole, tree.name, at)
            case SpaceName():
                return self._of_space(whole, tree.name, at)
            case PropertyUse():
                return self.member_of(self._body.calls.read_property(whole), tree.name, at)
            case BaseInstance():
                return self._of_base(whole, tree.name, at)
            case _:
                callee = self._body.expressions.called_without_arguments(whole, at)
                return self.member_of(callee, tree.name, at)

    def member_of(self, whole: TypedOperand, name: str, at: int) -> Meaning:
        """Return a member, method, property or action of an operand."""
        type = whole.flat
        key = name.lower()
        if whole.bits_of is not None and whole.bits_of.has_member(key):
            return self._variable_of(whole, whole.bits_of, key, at)
        if isinstance(type, StructType):
            if type.has_member(key):
                return self._variable_of(whole, type, key, at)
            part = self._part_of(whole, type, key, at)
            if part is not None:
                return part
            raise Unexpected(at, f"{type.name} has no member '{name[:80]}'", Code.UNKNOWN_MEMBER)
        if isinstance(type, InterfaceType):
            return self._of_interface(whole, type, key, name, at)
        enum = resolved(whole.type)
        if isinstance(enum, EnumType):
            # The variable has the name of its type, or stands for it.
            for value, number in enum.numbers.items():
                if value.lower() == key:
                    return constant_operand(Constant(number, enum), at)
        if isinstance(type, IntegerType):
            return self._named_bit(whole, name, at)
        if isinstance(type, PointerType):
            target = type.target.name
            raise Unexpected(
                at,
                f"a POINTER TO {target} has no members; write ^ before the dot",
                Code.UNKNOWN_MEMBER,
            )
        raise Unexpected(
            at, f"a {whole.type.name} has no members, asked for '{name[:80]}'", Code.UNKNOWN_MEMBER
        )

    def _variable_of(
        self, whole: TypedOperand, type: StructType[Any], key: str, at: int
    ) -> TypedOperand:
        member = type.member(key)
        names = self._body.names
        entry = self._body.checking.names.entry_of(type)
        constant = None
        if member.constant and entry is not None:
            scope = self._body.checking.names.scopes.scope(entry)
            own = self._body.checking.names.scopes.own(key, scope)
            if own is not None:
                constant = names.constant(own[0], own[1], key, at)
        if not member.in_memory:
            base = names.static_of(type, member)
            storage = Storage(base, 0, flat(member.type), name=member.name, at=at)
        else:
            outer = self.storage(whole, at)
            prefix = f"{outer.name}." if outer.name else ""
            storage = replaced(
                outer,
                offset=outer.offset + member.offset,
                type=flat(member.type),
                bit=member.bit,
                is_constant=outer.is_constant or member.constant,
                name=f"{prefix}{member.name}",
                at=at,
            )
        operand = read(storage, member.type, at)
        is_own = isinstance(storage.base, InstanceBase) and whole.flat is self._body.this
        is_input = member.section in (Section.INPUT, Section.IN_OUT)
        if type.kind is RecordKind.FUNCTION_BLOCK and not is_own and not is_input:
            operand.outside = f"{type.name}.{member.name}"
        if isinstance(resolved(member.type), ReferenceType) and whole.storage is not None:
            names.add_bounds(operand, whole.storage, type, member, at)
        if constant is not None:
            value = constant_operand(constant, at)
            if value.text is None:
                value.type = operand.type
            value.storage = storage
            return value
        return operand

    def _part_of(
        self, whole: TypedOperand, type: StructType[Any], key: str, at: int
    ) -> Meaning | None:
        """Return a method, property or action of an instance."""
        if type.kind is not RecordKind.FUNCTION_BLOCK:
            return None
        entry = self._body.checking.names.entry_of(type)
        if entry is None:
            raise Unexpected(
                at,
                f"no source of {type.name} is here: '{key[:80]}' is not known",
                Code.SOURCE_MISSING,
            )
        storage = self.storage(whole, at)
        is_exact = self.is_exact(storage)
        pointer = self._body.checking.pointer_to(type)
        address = self.address(whole, pointer, at)
        part = self._body.names.of_part(entry, key, address, is_exact, at)
        if isinstance(part, TypedOperand | TypeName):
            return None
        return part

    def _of_interface(
        self, whole: TypedOperand, type: InterfaceType, key: str, name: str, at: int
    ) -> Meaning:
        entry = self._body.checking.names.entry_of(type)
        if entry is not None:
            part = self._body.names.of_part(entry, key, whole.value, False, at)
            if part is not None:
                return part
        raise Unexpected(
            at, f"{type.name} has no method or property '{name[:80]}'", Code.UNKNOWN_MEMBER
        )

    def _of_base(self, base: BaseInstance, name: str, at: int) -> Meaning:
        body = self._body
        key = name.lower()
        address = body.names.this_address(at)
        part = body.names.of_part(base.entry, key, address, True, at)
        if part is not None:
            return part
        if body.this is not None and body.this.has_member(key):
            return body.names.member_of_instance(body.this.member(key), at)
        raise Unexpected(at, f"{base.entry.name} has no member '{name[:80]}'", Code.UNKNOWN_MEMBER)

    def _of_type(self, whole: TypeName, name: str, at: int) -> Meaning:
        key = name.lower()
        real = resolved(whole.type)
        if isinstance(real, EnumType):
            for value, number in real.numbers.items():
                if value.lower() == key:
                    return constant_operand(Constant(number, real), at)
            raise Unexpected(at, f"{real.name} has no value '{name[:80]}'", Code.UNKNOWN_ENUM_VALUE)
        names = self._body.checking.names
        if whole.entry is not None and isinstance(real, StructType) and real.has_member(key):
            member = real.member(key)
            scope = names.scopes.scope(whole.entry)
            own = names.scopes.own(key, scope)
            if own is not None:
                constant = self._body.names.constant(own[0], own[1], key, at)
                if constant is not None:
                    return constant_operand(constant, at)
            if not member.in_memory:
                base = self._body.names.static_of(real, member)
                storage = Storage(base, 0, flat(member.type), name=member.name, at=at)
                return read(storage, member.type, at)
        space = f"{whole.name}.{name}"
        entry = names.scopes.find(space)
        if entry is not None:
            return self._body.names.of_entry(entry, at)
        raise Unexpected(
            at,
            f"{whole.name} is a type; it has no '{name[:80]}' without a variable",
            Code.UNKNOWN_MEMBER,
        )

    def _of_unit(self, whole: UnitName, name: str, at: int) -> Meaning:
        key = name.lower()
        body = self._body
        if whole.entry is None:
            assert whole.type is not None
            return body.names.of_predefined(whole.type, key, at)
        names = body.checking.names
        scope = names.scopes.scope(whole.entry)
        if key in scope.variables:
            declared = scope.variables[key]
            if declared[0].section not in ("VAR_EXTERNAL", "VAR_CONFIG", "VAR_TEMP"):
                return body.names.of_list(scope, declared, key, at)
        part = body.names.of_part(whole.entry, key, None, True, at)
        if part is not None:
            return part
        if key in scope.values:
            return constant_operand(scope.values[key], at)
        inner = names.scopes.find(f"{whole.name}.{name}")
        if inner is not None and inner is not whole.entry:
            return body.names.of_entry(inner, at)
        raise Unexpected(at, f"{whole.name} has no variable '{name[:80]}'", Code.UNKNOWN_MEMBER)

    def _of_space(self, whole: SpaceName, name: str, at: int) -> Meaning:
        """Return the meaning of a name in a library, else its meaning without the library."""
        body = self._body
        scopes = body.checking.names.scopes
        path = f"{whole.name}.{name}"
        library = scopes.library_named(whole.name)
        if not library:
            entry = scopes.find(path, body.scope.space)
            if entry is not None:
                return body.names.of_entry(entry, at)
        meaning = body.names.outer(name, at, library)
        return SpaceName(path, whole.at) if meaning is None else meaning

    # bits ------------------------------------------------------------------------------------

    def _named_bit(self, whole: TypedOperand, name: str, at: int) -> TypedOperand:
        """`x.cBit`: a constant names the bit."""
        meaning = self._body.names.find(name, at)
        if isinstance(meaning, TypedOperand) and isinstance(meaning.constant, int):
            return self.part(whole, "X", meaning.constant, at)
        raise Unexpected(
            at,
            f"a {whole.type.name} has no members, and no constant is '{name[:80]}'",
            Code.UNKNOWN_MEMBER,
        )

    def part_of(self, tree: PartOf) -> TypedOperand:
        """`of.3`, `of.%B1`."""
        whole = self._body.expressions.operand(tree.of)
        return self.part(whole, tree.width, tree.number, tree.at)

    def part(self, whole: TypedOperand, width: str, number: int, at: int) -> TypedOperand:
        """Return a bit, byte, word … of an integer."""
        type = whole.flat
        if not isinstance(type, IntegerType):
            raise Unexpected(at, f"a bit of a whole number, got a {whole.type.name}", Code.BAD_PART)
        part = _PARTS[width]
        count = 8 * type.size if width == "X" else type.size // part.size
        if not 0 <= number < count:
            raise Unexpected(
                at, f"a {whole.type.name} has parts 0..{count - 1}, got {number}", Code.BAD_PART
            )
        if whole.is_constant or whole.storage is None:
            return self._computed_part(whole, part, number, at)
        storage = whole.storage
        self._body.mark_addressed(storage)
        if width == "X":
            place = replaced(
                storage,
                offset=storage.offset + number // 8,
                bit=number % 8,
                type=BOOL,
                name=f"{storage.name}.{number}",
                at=at,
            )
        else:
            place = replaced(
                storage,
                offset=storage.offset + number * part.size,
                type=part,
                name=f"{storage.name}.%{width}{number}",
                at=at,
            )
        return TypedOperand(Read(place, part, at), part, place)

    def _computed_part(
        self, whole: TypedOperand, part: IecType[Any], number: int, at: int
    ) -> TypedOperand:
        bits = 1 if isinstance(part, BoolType) else 8 * part.size
        value = whole.constant
        if isinstance(value, int):
            part_of_value = value >> bits * number & (1 << bits) - 1
            return (
                known(bool(part_of_value), BOOL, at)
                if bits == 1
                else known(part_of_value, part, at)
            )
        wide: IecType[Any] = LWORD
        shifted = Computed(
            Operator.SHR,
            (converted(whole.value, wide, at), Known(bits * number, DINT, at)),
            wide,
            at,
        )
        if bits > 1:
            return TypedOperand(converted(shifted, part, at), part)
        one = Computed(Operator.AND, (shifted, Known(1, wide, at)), wide, at)
        return TypedOperand(converted(one, BOOL, at), BOOL)

    # pointers --------------------------------------------------------------------------------

    def dereference(self, tree: Dereference) -> Meaning:
        """`of^`."""
        body = self._body
        at = tree.at
        if isinstance(tree.of, This):
            this = body.names.this_operand(at)
            if this is not None:
                return this
            entry = body.signature.entry
            if isinstance(entry.tree, Program):
                return UnitName(entry.name, entry, None, at)
            raise Unexpected(
                at,
                "THIS is in the methods and bodies of blocks and programs only",
                Code.NO_THIS_OR_SUPER,
            )
        if isinstance(tree.of, Super):
            return self.base_instance(at)
        pointer = body.expressions.operand(tree.of)
        type = pointer.flat
        if not isinstance(type, PointerType) or isinstance(type, InterfaceType):
            raise Unexpected(
                at, f"{pointer.type.name} is not a pointer: ^ has no target", Code.NOT_A_POINTER
            )
        checked = body.checks.pointer(pointer.value, type, at)
        name = pointer.storage.name if pointer.storage is not None else ""
        storage = Storage(PointerBase(checked), 0, flat(type.target), name=f"{name}^", at=at)
        return read(storage, type.target, at)

    def base_instance(self, at: int) -> BaseInstance:
        """`SUPER^`."""
        body = self._body
        base = body.checking.blocks.base(body.signature.entry)
        if base is None or body.this is None:
            raise Unexpected(
                at,
                f"{body.signature.entry.name} extends no block: SUPER is nothing",
                Code.NO_THIS_OR_SUPER,
            )
        return BaseInstance(base, at)
