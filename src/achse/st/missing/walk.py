"""Missing names: a walk through a project that notes each use of undeclared names.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

from collections.abc import Iterable
from typing import Any

from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Scope
from achse.st.graphical.body import GraphicalBody
from achse.st.missing.calls import note_method_call, note_standard_call, note_value
from achse.st.missing.joined import join_uses
from achse.st.missing.kinds import is_structure
from achse.st.missing.meanings import Meanings, Sense
from achse.st.missing.required import require_bases
from achse.st.missing.trees import (
    bases_of,
    blocks_and_results,
    children,
    leaves,
    numbers_of,
    parameters_of,
    part_of,
)
from achse.st.missing.type_texts import LOGICAL, expression_text, spec_text
from achse.st.missing.uses import MissingUse
from achse.st.syntax.tree import (
    NO_NOTE,
    Argument,
    ArrayInitial,
    ArrayOf,
    Assign,
    Binary,
    Call,
    Case,
    Declaration,
    EnumOf,
    Expression,
    For,
    If,
    Index,
    Literal,
    Member,
    MemberInitial,
    Name,
    NamedType,
    PointerTo,
    Range,
    ReferenceTo,
    RepeatUntil,
    StructInitial,
    StructOf,
    TypeSpec,
    Unary,
    UnionOf,
    VarBlock,
    While,
)
from achse.st.syntax.unit_parts import blocks_of
from achse.st.syntax.units import (
    Accessor,
    Action,
    FunctionBlock,
    Interface,
    Method,
    Property,
    TypeDeclaration,
)

_NUMBERS = ("+", "-", "*", "/", "MOD")
_COUNTS = ("sint", "usint", "int", "uint", "dint", "udint", "byte", "word", "dword")
_QUERIES = ("__QUERYINTERFACE", "__QUERYPOINTER")
_WALKS = 3
"""Most walks through all units: what one shows of a name is used by the next."""
_NO_BLOCK = VarBlock("VAR", (), (), NO_NOTE)


class MissingNames:
    """Walks all units of a project and of the libraries in its folders once, or those given.

    `meanings` have what is missing; `places` are where missing types are named.
    """

    def __init__(self, names: Resolver, units: Iterable[DeclaredUnit] | None = None) -> None:
        self._scopes, self._predefined = names.scopes, names.predefined
        self.meanings = Meanings(names)
        self.places: list[tuple[Scope, NamedType]] = []
        if units is None:
            units = self._scopes.entries.values()
        own = [entry for entry in units if not entry.is_built_in]
        self.blocks = {
            entry.name.rpartition(".")[2].lower()
            for entry in own
            if isinstance(entry.tree, FunctionBlock)
        }
        """Names of the project's function blocks, in lower case."""
        for entry in own:
            self._in_types(entry)
        for _ in range(_WALKS):
            for entry in own:
                self.meanings.this = entry
                self._in_unit(entry)
            if not join_uses(self.meanings.types.uses, self.meanings.names, self._is_record):
                break
        for entry in own:
            self._overrides(entry)
        uses = self.meanings.names
        for key in [key for key, use in uses.items() if use.is_space and not use.members]:
            del uses[key]
        if own:
            require_bases(self.meanings.types, self._scopes.scope(own[0]))
        types = self.meanings.types.uses
        for key in [key for key, use in types.items() if not use.is_needed]:
            del types[key]

    def _is_record(self, name: str) -> bool:
        """Return True if a source declares a type, or a symbol file a structure of that name."""
        return self.declares(name) or is_structure(self._predefined, name)

    def declares(self, name: str) -> bool:
        """Return True if the project or a library that it references declares a name."""
        return self._scopes.find(name, "") is not None

    # types -----------------------------------------------------------------------------------

    def _in_types(self, entry: DeclaredUnit) -> None:
        """Visit every type that a unit names, so that expressions know the missing ones later."""
        tree = entry.tree
        scope = self._scopes.scope(entry)
        for extended in bases_of(tree):
            if self._noted(extended, scope):
                use = self.meanings.types.use(extended)
                use.is_block |= isinstance(tree, FunctionBlock)
                use.is_structure |= isinstance(tree, TypeDeclaration)
                use.is_interface |= isinstance(tree, Interface)
        for interface in getattr(tree, "implements", ()):
            if self._noted(interface, scope):
                self.meanings.types.use(interface).is_interface = True
        if isinstance(tree, TypeDeclaration):
            self._in_spec(tree.type, scope)
        for block, returns in blocks_and_results(tree):
            if returns is not None:
                self._in_spec(returns, scope)
            for declaration in () if block is None else block.variables:
                self._in_spec(declaration.type, scope)

    def _noted(self, spec: NamedType, scope: Scope) -> bool:
        if not self.meanings.types.is_missing(spec, scope):
            return False
        use = self.meanings.types.use(spec)
        use.generics = max(use.generics, len(spec.generics))
        if use.block is None and not use.is_opaque:
            self.places.append((scope, spec))
        return True

    def _in_spec(self, spec: TypeSpec, scope: Scope) -> None:
        match spec:
            case NamedType():
                self._noted(spec, scope)
            case ArrayOf(_, element):
                self._in_spec(element, scope)
            case PointerTo(target) | ReferenceTo(target):
                self._in_spec(target, scope)
            case StructOf(members) | UnionOf(members):
                for member in members:
                    self._in_spec(member.type, scope)
            case _:
                pass

    # units -----------------------------------------------------------------------------------

    def _in_unit(self, entry: DeclaredUnit) -> None:
        tree = entry.tree
        scope = self._scopes.scope(entry)
        if isinstance(tree, TypeDeclaration):
            self._in_bounds(tree.type, scope)
            if tree.initial is not None:
                self._in_initial(tree.initial, (tree.type, scope), scope)
            if isinstance(tree.type, EnumOf):
                return
        self._in_blocks(blocks_of(tree), scope)
        self._in_statements(getattr(tree, "body", None), scope)
        for part in getattr(tree, "parts", ()):
            if isinstance(part, Property):
                for accessor in (part.get, part.set):
                    if accessor is not None:
                        self._in_part(accessor, part.name, part.type, scope)
            elif isinstance(part, Method):
                self._in_part(part, part.name, part.returns, scope)
            elif isinstance(part, Action):
                self._in_statements(part.body, scope)

    def _overrides(self, entry: DeclaredUnit) -> None:
        """Note methods of a block whose base or interface is missing: calls show less of them."""
        interfaces = list(self.meanings.types.interfaces_of(entry))
        base = self.meanings.types.base_of(entry)
        own = {part.name.lower(): part for part in getattr(entry.tree, "parts", ())}
        for use in [*interfaces, *([base] if base else [])]:
            for name, known in use.members.items():
                part = own.get(name)
                if isinstance(part, Method) and known.is_called:
                    known.override = known.override or part
        for use in interfaces if base is not None else ():
            for name, known in use.members.items():
                if known.is_called and name not in own and base is not None:
                    base.members.setdefault(name, known)  # what the block lacks, its base has

    def _in_part(
        self, tree: Method | Accessor, name: str, returns: TypeSpec | None, scope: Scope
    ) -> None:
        inside = Scope(scope.source, f"{scope.owner}.{name}", scope.space, scope)
        for block in tree.blocks:
            for declaration in block.variables:
                for item in declaration.names:
                    inside.variables.setdefault(item.name.lower(), (block, declaration))
        if returns is not None:
            result = Declaration((Name(name),), None, returns, (), None, NO_NOTE)
            inside.variables.setdefault(name.lower(), (_NO_BLOCK, result))
        self._in_blocks(tree.blocks, inside)
        self._in_statements(tree.body, inside)

    def _in_blocks(self, blocks: Iterable[VarBlock], scope: Scope) -> None:
        for block in blocks:
            for declaration in block.variables:
                self._in_bounds(declaration.type, scope)
                at = (declaration.type, scope)
                self._in_arguments_of(declaration, at, scope)
                if declaration.initial is not None:
                    self._in_initial(declaration.initial, at, scope)
                    if "CONSTANT" in block.qualifiers:
                        self._constant(declaration, scope)

    def _constant(self, declaration: Declaration, scope: Scope) -> None:
        """Mark the names that an integer constant consists of: they may be bounds."""
        tree, spec = declaration.initial, declaration.type
        if not isinstance(spec, NamedType) or spec.name.lower() not in _COUNTS:
            return
        for name in leaves(tree) if isinstance(tree, Expression) else ():
            use = self.meanings.constant(name, scope)
            if isinstance(use, MissingUse) and not use.is_called:
                use.is_bound = True

    def _in_bounds(self, spec: TypeSpec, scope: Scope) -> None:
        """Note names in lengths and bounds: they are whole numbers."""
        for tree, is_low in numbers_of(spec):
            for name in leaves(tree):
                use = self.meanings.constant(name, scope)
                if isinstance(use, MissingUse):
                    use.is_bound = True
                    use.is_low |= is_low
        if isinstance(spec, StructOf | UnionOf):
            self._in_blocks([VarBlock("VAR", (), spec.members, NO_NOTE, spec.at)], scope)

    def _in_arguments_of(
        self, declaration: Declaration, at: tuple[TypeSpec, Scope], scope: Scope
    ) -> None:
        use = self.meanings.types.use_at(at) or self.meanings.types.base_with_init(self._callee(at))
        arguments = declaration.arguments
        if isinstance(arguments, ArrayInitial):
            return
        for number, argument in enumerate(arguments, 1):
            if argument.value is None:
                continue
            self._in_expression(argument.value, scope)
            if use is not None:
                use.is_block = True
                name = argument.name or f"argument{number}"
                one = use.initials.setdefault(name.lower(), MissingUse(name))
                one.note_type(expression_text(self.meanings, argument.value, scope))

    def _in_initial(self, tree: Any, at: tuple[TypeSpec, Scope] | None, scope: Scope) -> None:
        use = None if at is None else self.meanings.types.use_at(at)
        if isinstance(tree, StructInitial):
            for item in tree.members:
                self._in_member(item, use, at, scope)
        elif isinstance(tree, ArrayInitial):
            element = at and self.meanings.element(at)
            if use is not None:
                self._note_elements(use, tree, scope)
            for value in tree.values:
                for inner in getattr(value, "values", (value,)):
                    self._in_initial(inner, element, scope)
        elif isinstance(tree, Expression):
            self._in_expression(tree, scope)
            text = expression_text(self.meanings, tree, scope)
            if use is not None and self._is_block(text):
                use.is_interface = True
            elif use is not None:
                use.note_type(text)
                self._value_of(tree, use, scope)
            elif at is not None:
                self._note_use(self.meanings.of(tree, scope), spec_text(self.meanings, at))

    def _is_block(self, type: str) -> bool:
        """Return True for the name of a function block, declared or missing."""
        use = self.meanings.types.uses.get(type.lower())
        return type.lower() in self.blocks or (use is not None and use.is_block)

    def _in_member(
        self,
        item: MemberInitial,
        use: MissingUse | None,
        at: tuple[TypeSpec, Scope] | None,
        scope: Scope,
    ) -> None:
        if use is not None:
            use.is_structure = True
            member = use.member(item.name)
            member.is_written = True
            if isinstance(item.value, Expression):
                self._note_use(member, expression_text(self.meanings, item.value, scope))
                self._alike(member, item.value, scope)
            elif isinstance(item.value, ArrayInitial):
                self._note_elements(member, item.value, scope)
            self._in_initial(item.value, None, scope)
            return
        sense = None if at is None else self.meanings.member_of(at, item.name)
        if isinstance(sense, MissingUse) and isinstance(item.value, Expression):
            sense.is_written = True  # of a missing base
            sense.note_type(expression_text(self.meanings, item.value, scope))
        self._in_initial(item.value, sense if isinstance(sense, tuple) else None, scope)

    def _note_elements(self, use: MissingUse, tree: ArrayInitial, scope: Scope) -> None:
        """Note how many elements `(aSpeeds := [1.0, 2.0])` shows, and their type."""
        use.element = use.element or MissingUse(use.name)
        use.highest = max(use.highest, len(tree.values) - 1)
        for value in tree.values:
            for one in getattr(value, "values", (value,)):
                if isinstance(one, Expression):
                    use.element.note_type(expression_text(self.meanings, one, scope))

    def _alike(self, use: MissingUse, tree: Expression, scope: Scope) -> None:
        sense = self.meanings.of(tree, scope)
        if isinstance(sense, MissingUse) and sense is not use:
            use.like = use.like or sense
            if not any(peer is sense for peer in use.peers):
                use.peers.append(sense)
                sense.peers.append(use)

    def _value_of(self, tree: Expression, use: MissingUse, scope: Scope) -> None:
        """Note a value of a missing enumeration: `x : E_Mode := E_Mode.Auto` or `:= Auto`."""
        sense = self.meanings.of(tree, scope)
        if isinstance(sense, MissingUse) and not use.type:
            name = tree.name if isinstance(tree, Name | Member) else ""
            if name and not sense.members and not sense.is_called:
                use.values.setdefault(name.lower(), name)

    # statements ------------------------------------------------------------------------------

    def _in_statements(self, statements: Any, scope: Scope) -> None:
        if isinstance(statements, GraphicalBody):
            statements = statements.readable_statements
        for statement in statements or ():
            self._in_statement(statement, scope)

    def _in_statement(self, tree: Any, scope: Scope) -> None:
        if isinstance(tree, Expression):
            self._in_expression(tree, scope)
            return
        if isinstance(tree, If):
            for branch in tree.branches:
                self._note_use(self.meanings.of(branch.condition, scope), "BOOL")
        elif isinstance(tree, While | RepeatUntil):
            self._note_use(self.meanings.of(tree.condition, scope), "BOOL")
        elif isinstance(tree, For):
            self._note_use(
                self.meanings.of(tree.last, scope),
                expression_text(self.meanings, tree.variable, scope),
            )
        elif isinstance(tree, Case):
            labels = [label for choice in tree.choices for label in choice.labels]
            for label in labels:
                if not isinstance(label, Range):
                    self._compared(tree.selector, label, scope)
        for inner in children(tree):
            if isinstance(inner, Range):
                self._in_expression(inner.low, scope)
                self._in_expression(inner.high, scope)
            else:
                self._in_statement(inner, scope)

    def _in_expression(self, tree: Expression, scope: Scope) -> None:
        """Record the facts about missing names in an expression."""
        stack: list[Expression] = [tree]
        while stack:
            tree = stack.pop()
            if isinstance(tree, Assign):
                self._compared(tree.target, tree.value, scope)
                sense = self.meanings.of(tree.target, scope)
                if isinstance(sense, MissingUse):
                    sense.is_written = True
            elif isinstance(tree, Binary):
                self._binary(tree, scope)
            elif isinstance(tree, Unary) and tree.operator == "NOT":
                self._note_use(self.meanings.of(tree.operand, scope), "BOOL")
            elif isinstance(tree, Call):
                self._call(tree, scope)
            elif isinstance(tree, Index):
                self._index(tree, scope)
            else:
                self.meanings.of(tree, scope)
            if not (isinstance(tree, Member) and isinstance(tree.of, Name)):
                stack += [item for item in children(tree) if isinstance(item, Expression)]
            if isinstance(tree, Call):
                stack += [item.value for item in tree.arguments if item.value is not None]

    def _index(self, tree: Index, scope: Scope) -> None:
        """Note the lowest index of an array: values of a missing enumeration count from it."""
        self.meanings.of(tree, scope)
        whole = self.meanings.of(tree.of, scope)
        if not isinstance(whole, tuple) or not isinstance(whole[0], ArrayOf):
            return
        for index, bounds in zip(tree.indices, whole[0].dimensions, strict=False):
            use = self.meanings.enumeration_of(index, scope)
            if use is not None and bounds is not None and isinstance(bounds.low, Literal):
                use.first = int(bounds.low.text) if bounds.low.text.isdecimal() else 0

    def _binary(self, tree: Binary, scope: Scope) -> None:
        if tree.operator.upper() in LOGICAL:
            for side in (tree.left, tree.right):
                sense = self.meanings.of(side, scope)
                other = tree.right if side is tree.left else tree.left
                self._note_use(sense, expression_text(self.meanings, other, scope) or "BOOL")
            return
        self._compared(tree.left, tree.right, scope)
        if tree.operator in _NUMBERS:
            for side in (tree.left, tree.right):
                self._note_use(self.meanings.of(side, scope), "DINT")

    def _compared(self, left: Expression, right: Expression, scope: Scope) -> None:
        """Note that two sides have one type."""
        for one, other in ((left, right), (right, left)):
            sense = self.meanings.of(one, scope)
            if isinstance(sense, tuple):
                note_value(self.meanings, sense, other, scope)
            if not isinstance(sense, MissingUse):
                continue
            sense.note_type(expression_text(self.meanings, other, scope))
            self._alike(sense, other, scope)
            seen = self.meanings.of(other, scope)
            if isinstance(seen, tuple) and (use := self.meanings.types.use_at(seen)) is not None:
                self._value_of(one, use, scope)

    def _call(self, tree: Call, scope: Scope) -> None:
        if isinstance(tree.of, Name) and tree.of.name.upper() in _QUERIES and tree.arguments:
            operand = tree.arguments[0].value
            if operand is not None:
                self._note_use(self.meanings.of(operand, scope), "IQueryInterface")
        if isinstance(tree.of, Name):
            note_standard_call(self.meanings, tree.of.name, tree, scope)
        sense = self.meanings.of(tree.of, scope)
        method = self.meanings.method_of(tree.of, scope)
        if method is not None:
            note_method_call(self.meanings, *method, tree, scope)
            return
        use = self.meanings.types.use_at(sense) if isinstance(sense, tuple) else sense
        if isinstance(use, MissingUse):
            use.is_called = True
            if isinstance(sense, tuple):
                use.is_block = True
            for place, argument in enumerate(tree.arguments):
                self._argument(use, place, argument, scope)
                if use.method is not None and argument.value is not None:
                    text = use.method.type_of(argument.name or place)
                    self._note_use(self.meanings.of(argument.value, scope), text)
                if use.block is not None and argument.value is not None and argument.name:
                    part = part_of(use.block, argument.name)
                    text = "" if part is None else part.type
                    self._note_use(self.meanings.of(argument.value, scope), text)
            return
        callee = self._callee(sense)
        if callee is None:
            return
        inside = self._scopes.scope(callee)
        inputs = parameters_of(callee.tree)
        for place, argument in enumerate(tree.arguments):
            if argument.value is not None and not argument.name and place < len(inputs):
                text = spec_text(self.meanings, (inputs[place], inside))
                self._note_use(self.meanings.of(argument.value, scope), text)
            if argument.value is None or not argument.name:
                continue
            declared = self._scopes.own(argument.name.lower(), inside)
            if declared is not None:
                text = spec_text(self.meanings, (declared[1][1].type, declared[0]))
                self._note_use(self.meanings.of(argument.value, scope), text)
            elif (base := self.meanings.types.base_of(callee)) is not None:
                base.is_block = True
                self._argument(base, 0, argument, scope)

    def _argument(self, use: MissingUse, place: int, argument: Argument, scope: Scope) -> None:
        text = (
            "" if argument.value is None else expression_text(self.meanings, argument.value, scope)
        )
        if argument.name:
            named = use.outputs if argument.is_output else use.inputs
            one = named.setdefault(argument.name.lower(), MissingUse(argument.name))
        else:
            while len(use.arguments) <= place:
                use.arguments.append(MissingUse(f"p{len(use.arguments) + 1}"))
            one = use.arguments[place]
        one.note_type(text)

    def _callee(self, sense: Sense) -> DeclaredUnit | None:
        if isinstance(sense, DeclaredUnit):
            return sense
        if isinstance(sense, tuple) and isinstance(sense[0], NamedType):
            return self._scopes.find(sense[0].name, sense[1].space)
        return None

    @staticmethod
    def _note_use(sense: Sense, text: str) -> None:
        if isinstance(sense, MissingUse):
            sense.note_type(text)
