"""Syntax trees as text: what `parse` reads back as the same tree."""

import re
from collections.abc import Iterable

from achse.st.syntax.expressions import BINDING, UNARY_BINDING
from achse.st.syntax.tree import (
    NO_NOTE,
    Argument,
    ArrayInitial,
    ArrayOf,
    Assign,
    Binary,
    Call,
    Case,
    Continue,
    Declaration,
    Dereference,
    DirectAddress,
    EnumOf,
    Exit,
    Expression,
    For,
    GlobalName,
    If,
    Index,
    Initial,
    Jump,
    Label,
    Let,
    Literal,
    Member,
    MemberInitial,
    Name,
    NamedType,
    Note,
    PartOf,
    PointerTo,
    Range,
    ReferenceTo,
    RepeatUntil,
    Repetition,
    Return,
    Statement,
    StringOf,
    StructInitial,
    StructOf,
    Subrange,
    Super,
    This,
    Try,
    TypeOperand,
    TypeSpec,
    Unary,
    UnionOf,
    VarBlock,
    While,
)
from achse.st.syntax.units import (
    Accessor,
    Action,
    Body,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Namespace,
    Part,
    Program,
    Property,
    TypeDeclaration,
    Unit,
)

_STEP = "    "
_ATOM = UNARY_BINDING + 1


def print_units(units: Iterable[Unit]) -> str:
    """Units as a source. Comments on VAR blocks and names of lists have no place in one."""
    return "\n".join(line for unit in units for line in (*_unit(unit), ""))


def print_statements(statements: Iterable[Statement]) -> str:
    """Statements, one a line."""
    return "\n".join(line for statement in statements for line in _statement(statement))


# Expressions --------------------------------------------------------------------------------


def print_expression(tree: Expression) -> str:
    """Print an expression with the necessary brackets only."""
    return _expression(tree, 0)


def _expression(tree: Expression, power: int) -> str:
    """Return the text of a tree where only operators that bind stronger than `power` may stand
    bare."""
    # Long sums lean to the left: that side is walked, not descended.
    tail: list[str] = []
    closing = 0
    while isinstance(tree, Binary):
        binding = BINDING[tree.operator]
        bracket = binding <= power
        closing += bracket
        tail.append(")" if bracket else "")
        tail.append(f" {tree.operator} {_expression(tree.right, binding)}")
        tree, power = tree.left, binding - 1
    return "(" * closing + _operand(tree, power) + "".join(reversed(tail))


def _operand(tree: Expression, power: int) -> str:
    match tree:
        case Assign():
            text = f"{print_expression(tree.target)} := {print_expression(tree.value)}"
            return text if power == 0 else f"({text})"
        case Unary():
            space = " " if tree.operator == "NOT" else ""
            inner = _expression(tree.operand, UNARY_BINDING)
            text = f"{tree.operator}{space}{inner}"
            return text if power < UNARY_BINDING else f"({text})"
        case Literal(_, text):
            return text
        case Name(name):
            return name
        case GlobalName(name):
            return f".{name}"
        case This():
            return "THIS"
        case Super():
            return "SUPER"
        case Member(of, name):
            return f"{_path(of)}.{name}"
        case PartOf(of, width, number):
            # `a.1.2` would read as a real number.
            bit = width == "X" and number < 100 and not isinstance(of, PartOf)
            return f"{_path(of)}.{number}" if bit else f"{_path(of)}.%{width}{number}"
        case Index(of, indices):
            return f"{_path(of)}[{', '.join(map(print_expression, indices))}]"
        case Dereference(of):
            return f"{_path(of)}^"
        case Call(of, arguments):
            return f"{_path(of)}{_arguments(arguments)}"
        case DirectAddress(text):
            return text
        case TypeOperand(type):
            return print_type(type)
        case Binary():
            raise AssertionError("walked above")


def _path(tree: Expression) -> str:
    text = _expression(tree, _ATOM)
    return f"({text})" if isinstance(tree, Literal | TypeOperand) else text


def _arguments(arguments: Iterable[Argument]) -> str:
    return f"({', '.join(map(_argument, arguments))})"


def _argument(argument: Argument) -> str:
    value = "" if argument.value is None else print_expression(argument.value)
    if not argument.name:
        return value
    return f"{argument.name} {'=>' if argument.is_output else ':='} {value}"


def print_initial(tree: Initial | Repetition) -> str:
    """Print an initial value."""
    match tree:
        case ArrayInitial(values):
            return f"[{', '.join(map(print_initial, values))}]"
        case StructInitial(members):
            return f"({', '.join(map(_member_initial, members))})"
        case Repetition(count, values):
            times = print_expression(count)
            if not isinstance(count, Literal | Name | Member):
                times = f"({times})"
            return f"{times}({', '.join(map(print_initial, values))})"
        case _:
            return print_expression(tree)


def _member_initial(item: MemberInitial) -> str:
    sign = f"{item.name} {'REF=' if item.is_reference else ':='} " if item.name else ""
    return f"{sign}{print_initial(item.value)}"


# Statements ---------------------------------------------------------------------------------


def _block(body: Body) -> list[str]:
    statements = body if isinstance(body, tuple) else ()  # a drawing has no text
    return [_STEP + line for statement in statements for line in _statement(statement)]


def _statement(tree: Statement) -> list[str]:
    match tree:
        case Assign():
            target, value = print_expression(tree.target), print_expression(tree.value)
            return [f"{target} {tree.operator} {value};"]
        case If():
            lines = []
            word = "IF"
            for branch in tree.branches:
                lines += [f"{word} {print_expression(branch.condition)} THEN"]
                lines += _block(branch.body)
                word = "ELSIF"
            return [*lines, *_else(tree.otherwise), "END_IF"]
        case Case():
            lines = [f"CASE {print_expression(tree.selector)} OF"]
            for choice in tree.choices:
                labels = ", ".join(map(_label, choice.labels))
                lines += [f"{labels}:", *_block(choice.body)]
            otherwise = _else(tree.otherwise) or ["ELSE"] * tree.has_empty_else
            return [*lines, *otherwise, "END_CASE"]
        case For():
            first, last = print_expression(tree.first), print_expression(tree.last)
            step = "" if tree.step is None else f" BY {print_expression(tree.step)}"
            variable = print_expression(tree.variable)
            head = f"FOR {variable} := {first} TO {last}{step} DO"
            return [head, *_block(tree.body), "END_FOR"]
        case While():
            head = f"WHILE {print_expression(tree.condition)} DO"
            return [head, *_block(tree.body), "END_WHILE"]
        case RepeatUntil():
            last = f"UNTIL {print_expression(tree.condition)}"
            return ["REPEAT", *_block(tree.body), last, "END_REPEAT"]
        case Try():
            lines = ["__TRY", *_block(tree.body)]
            exception = tree.exception
            lines.append("__CATCH" + ("" if exception is None else f"({_path(exception)})"))
            lines += [*_block(tree.handler), "__FINALLY", *_block(tree.final)]
            return [*lines, "__ENDTRY"]
        case Let():
            return [f"{tree.name} := {print_expression(tree.value)};"]
        case Exit():
            return ["EXIT;"]
        case Continue():
            return ["CONTINUE;"]
        case Return():
            return ["RETURN;"]
        case Jump(label):
            return [f"JMP {label};"]
        case Label(name):
            return [f"{name}:"]
        case _:
            return [f"{print_expression(tree)};"]


def _else(body: tuple[Statement, ...]) -> list[str]:
    return ["ELSE", *_block(body)] if body else []


def _label(label: Expression | Range) -> str:
    return _range(label) if isinstance(label, Range) else print_expression(label)


def _range(limits: Range) -> str:
    return f"{print_expression(limits.low)}..{print_expression(limits.high)}"


# Types and variables ------------------------------------------------------------------------


def print_type(spec: TypeSpec) -> str:
    """Print a type as written after the colon, in one line."""
    match spec:
        case NamedType():
            return _named(spec)
        case StringOf(family, None):
            return family
        case StringOf(family, length):
            return f"{family}({print_expression(length)})" if length is not None else family
        case ArrayOf(dimensions, element):
            bounds = ("*" if part is None else _range(part) for part in dimensions)
            return f"ARRAY [{', '.join(bounds)}] OF {print_type(element)}"
        case PointerTo(target):
            return f"POINTER TO {print_type(target)}"
        case ReferenceTo(target):
            return f"REFERENCE TO {print_type(target)}"
        case Subrange(base, limits):
            return f"{_named(base)} ({_range(limits)})"
        case EnumOf() | StructOf() | UnionOf():
            return "\n".join(_big_type(spec))


def _named(spec: NamedType) -> str:
    generics = ", ".join(_expression(item, BINDING[">"]) for item in spec.generics)
    return f"{spec.name}<{generics}>" if generics else spec.name


def _big_type(spec: EnumOf | StructOf | UnionOf) -> list[str]:
    if isinstance(spec, EnumOf):
        lines = ["("]
        for index, item in enumerate(spec.values):
            value = "" if item.value is None else f" := {print_expression(item.value)}"
            comma = "," if index + 1 < len(spec.values) else ""
            lines += _indented([*_note(item.note), f"{item.name}{value}{comma}"])
        return [*lines, ")" if spec.base is None else f") {_named(spec.base)}"]
    word = "STRUCT" if isinstance(spec, StructOf) else "UNION"
    members = (line for member in spec.members for line in _declaration(member))
    return [word, *_indented(members), f"END_{word}"]


def _indented(lines: Iterable[str]) -> list[str]:
    return [_STEP + line for line in lines]


def _note(note: Note) -> list[str]:
    lines = []
    for name, value in note.attributes:
        escaped = value.replace("$", "$$").replace("'", "$'")
        lines.append(f"{{attribute '{name}'" + (f" := '{escaped}'}}" if value else "}"))
    if note.comment and _nests(note.comment):
        return [*lines, *f"(*{note.comment}*)".split("\n")]
    return lines + [f"///{line}" for line in note.comment.split("\n") if line]


def _nests(comment: str) -> bool:
    """Return True if every comment inside a comment ends inside it."""
    depth = 0
    for sign in re.findall(r"\(\*|\*\)", f"{comment} "):
        depth += 1 if sign == "(*" else -1
        if depth < 0:
            return False
    return depth == 0 and not comment.startswith(")") and not comment.endswith(("(", "*"))


def _declaration(tree: Declaration) -> list[str]:
    names = ", ".join(name.name for name in tree.names)
    address = "" if tree.address is None else f" AT {tree.address.text}"
    arguments = ""
    if isinstance(tree.arguments, ArrayInitial):
        arguments = print_initial(tree.arguments)
    elif tree.arguments:
        arguments = _arguments(tree.arguments)
    sign = "REF=" if tree.is_reference else ":="
    initial = "" if tree.initial is None else f" {sign} {print_initial(tree.initial)}"
    text = f"{names}{address} : {print_type(tree.type)}{arguments}{initial};"
    return [*_note(tree.note), *text.split("\n")]


def _var_block(block: VarBlock) -> list[str]:
    head = " ".join((block.section, *block.qualifiers))
    variables = (line for item in block.variables for line in _declaration(item))
    return [*_note(block.note), head, *_indented(variables), "END_VAR"]


# Units --------------------------------------------------------------------------------------


def _unit(unit: Unit) -> list[str]:
    match unit:
        case TypeDeclaration():
            extends = "" if unit.extends is None else f" EXTENDS {_named(unit.extends)}"
            initial = "" if unit.initial is None else f" := {print_initial(unit.initial)}"
            head = " ".join((*unit.modifiers, unit.name)) + extends
            lines = f"{head} : {print_type(unit.type)}{initial};".split("\n")
            return [*_note(unit.note), f"TYPE {lines[0]}", *lines[1:], "END_TYPE"]
        case GlobalList():
            lines = [line for block in unit.blocks for line in _var_block(block)]
            return [*_note(unit.note), *lines]
        case Function():
            head = _head("FUNCTION", unit.modifiers, unit.name, unit.returns)
            return _framed(unit.note, head, unit.blocks, _block(unit.body), "END_FUNCTION")
        case FunctionBlock():
            head = _head("FUNCTION_BLOCK", unit.modifiers, unit.name)
            generic = [block for block in unit.blocks if block.section == "VAR_GENERIC"]
            bases = "" if unit.extends is None else f"EXTENDS {_named(unit.extends)}"
            bases = " ".join(filter(None, (bases, _listed("IMPLEMENTS ", unit.implements))))
            frame = [line for block in generic for line in _var_block(block)]
            frame = [head, *frame, bases] if frame else [f"{head} {bases}".rstrip()]
            blocks = unit.blocks[len(generic) :]
            inside = _inside(unit.parts, unit.body)
            lines = _framed(NO_NOTE, "", blocks, inside, "END_FUNCTION_BLOCK")
            return [*_note(unit.note), *frame, *lines[1:]]
        case Program():
            head = _head("PROGRAM", unit.modifiers, unit.name)
            inside = _inside(unit.parts, unit.body)
            return _framed(unit.note, head, unit.blocks, inside, "END_PROGRAM")
        case Interface():
            head = _head("INTERFACE", unit.modifiers, unit.name)
            head += _listed(" EXTENDS ", unit.extends)
            return _framed(unit.note, head, (), _inside(unit.parts, ()), "END_INTERFACE")
        case Namespace():
            inner = (line for part in unit.units for line in _unit(part))
            return [f"NAMESPACE {unit.name}", *_indented(inner), "END_NAMESPACE"]


def _head(word: str, modifiers: Iterable[str], name: str, returns: TypeSpec | None = None) -> str:
    result = "" if returns is None else f" : {print_type(returns)}"
    return " ".join((word, *modifiers, name)) + result


def _listed(word: str, names: tuple[NamedType, ...]) -> str:
    return word + ", ".join(map(_named, names)) if names else ""


def _framed(
    note: Note, head: str, blocks: Iterable[VarBlock], inside: list[str], end: str
) -> list[str]:
    variables = [line for block in blocks for line in _var_block(block)]
    return [*_note(note), head, *variables, *inside, end]


def _inside(parts: Iterable[Part], body: Body) -> list[str]:
    return [line for part in parts for line in _part(part)] + _block(body)


def _part(part: Part) -> list[str]:
    match part:
        case Method():
            head = _head("METHOD", part.modifiers, part.name, part.returns)
            return _framed(part.note, head, part.blocks, _block(part.body), "END_METHOD")
        case Property():
            head = _head("PROPERTY", part.modifiers, part.name, part.type)
            if part.initial is not None:
                head += f" := {print_initial(part.initial)}"
            lines = [*_accessor("GET", part.get), *_accessor("SET", part.set)]
            return [*_note(part.note), head, *lines, "END_PROPERTY"]
        case Action():
            return [*_note(part.note), f"ACTION {part.name}:", *_block(part.body), "END_ACTION"]


def _accessor(word: str, tree: Accessor | None) -> list[str]:
    if tree is None:
        return []
    head = " ".join((word, *tree.modifiers))
    return _framed(tree.note, head, tree.blocks, _block(tree.body), f"END_{word}")
