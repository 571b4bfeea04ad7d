"""The typed form as text: one line per statement, for tests, for `achse check`, for the curious.

`nTotal := CUT.INT(ADD.DINT(EXTEND.DINT(nTotal), 1));`: what is computed, at which type.
"""

from collections.abc import Iterator

from achse.st.typed.expressions import (
    AddressOf,
    Composed,
    Computed,
    Converted,
    Created,
    Deleted,
    DirectTarget,
    EnumName,
    Invocation,
    Known,
    Latched,
    Queried,
    Read,
    Shortcut,
    Stored,
    TypedValue,
)
from achse.st.typed.places import (
    CalleeBase,
    FrameBase,
    ImageBase,
    InstanceBase,
    PointerBase,
    StaticBase,
    Storage,
    TemporaryBase,
    UnitBase,
)
from achse.st.typed.statements import (
    CaseSelection,
    Conditional,
    ConditionLoop,
    CountedLoop,
    Do,
    JumpMark,
    JumpTo,
    LifeStep,
    LoopExit,
    LoopNext,
    Protected,
    RoutineExit,
    TypedStatement,
    TypedStatements,
)


def text_of(value: TypedValue) -> str:
    """Return a value in one line."""
    match value:
        case Known(known, type):
            return repr(known) if isinstance(known, bytes) else f"{known}"
        case Read(storage):
            return storage_text(storage)
        case AddressOf(storage):
            return f"ADR({storage_text(storage)})"
        case Converted(operand, type, rule):
            return f"{rule.value}.{type.name}({text_of(operand)})"
        case Computed(operator, operands, type):
            return f"{operator.value}.{type.name}({', '.join(map(text_of, operands))})"
        case Shortcut(is_and, left, right):
            word = "AND_THEN" if is_and else "OR_ELSE"
            return f"{word}({text_of(left)}, {text_of(right)})"
        case Stored(storage, stored):
            return f"{storage_text(storage)} := {text_of(stored)}"
        case Latched(storage, latched, sets):
            return f"{storage_text(storage)} {'S=' if sets else 'R='} {text_of(latched)}"
        case Invocation():
            return _invocation(value)
        case Composed(_, parts, type):
            inside = ", ".join(f"+{offset} := {text_of(part)}" for offset, part in parts)
            return f"{type.name}({inside})"
        case EnumName(operand):
            return f"NAME({text_of(operand)})"
        case Created(of, count):
            times = "" if count is None else f", {text_of(count)}"
            return f"NEW({of.name}{times}{_list(value.arguments, ', ')})"
        case Deleted(pointer):
            return f"DELETE({storage_text(pointer)})"
        case Queried(source, target, interface):
            return f"QUERY({text_of(source)}, {storage_text(target)}, {interface or 'POINTER'})"


def _invocation(call: Invocation) -> str:
    target = call.target
    if isinstance(target, DirectTarget):
        name = target.routine
    else:
        name = f"[{target.name}]"
    instance = "" if call.instance is None else f"{text_of(call.instance)}->"
    outputs = "".join(f" => {text_of(item)}" for item in call.outputs)
    return f"{instance}{name}({_list(call.inputs, '')}{outputs})"


def _list(stored: tuple[Stored, ...], before: str) -> str:
    text = ", ".join(map(text_of, stored))
    return f"{before}{text}" if text else ""


def storage_text(storage: Storage) -> str:
    """Return a storage by the name it was written with, and what is computed of its place."""
    match storage.base:
        case PointerBase(address):
            head = f"{text_of(address)}^"
        case TemporaryBase(variable, value):
            head = f"<{variable.name} := {text_of(value)}>"
        case CalleeBase():
            head = f"callee.{storage.name}"
        case InstanceBase() if not storage.name:
            head = "THIS^"
        case _:
            head = storage.name
    if isinstance(storage.base, PointerBase | TemporaryBase) and storage.offset:
        head += f"+{storage.offset}"
    for step in storage.steps:
        head += f"[{text_of(step.index)}]"
    return head


def place_of(storage: Storage) -> str:
    """Return the place of a storage: `MAIN.nCount`, `this+8`, `frame+4.1`, without its index
    steps."""
    match storage.base:
        case UnitBase(unit, variable):
            head = f"{unit}.{variable.name}"
        case StaticBase(owner, variable):
            head = f"static {owner}.{variable.name}"
        case InstanceBase():
            head = "this"
        case FrameBase():
            head = "frame"
        case CalleeBase():
            head = "callee"
        case PointerBase():
            head = "pointer"
        case TemporaryBase(variable):
            head = f"frame {variable.name}"
        case ImageBase(area):
            head = f"%{area}"
    offset = f"+{storage.offset}" if storage.offset else ""
    return head + offset + ("" if storage.bit is None else f".{storage.bit}")


def lines_of(statements: TypedStatements, indent: str = "") -> Iterator[str]:
    """Statements, line by line."""
    for statement in statements:
        yield from _lines(statement, indent)


def _lines(statement: TypedStatement, indent: str) -> Iterator[str]:
    inner = f"{indent}    "
    match statement:
        case Do(value):
            yield f"{indent}{text_of(value)};"
        case Conditional(branches, otherwise):
            word = "IF"
            for branch in branches:
                yield f"{indent}{word} {text_of(branch.condition)}"
                yield from lines_of(branch.body, inner)
                word = "ELSIF"
            if otherwise:
                yield f"{indent}ELSE"
                yield from lines_of(otherwise, inner)
        case CaseSelection(selector, choices, otherwise):
            yield f"{indent}CASE {text_of(selector)}"
            for choice in choices:
                labels = (
                    f"{low}" if low == high else f"{low}..{high}" for low, high in choice.labels
                )
                yield f"{indent}{', '.join(labels)}:"
                yield from lines_of(choice.body, inner)
            if otherwise:
                yield f"{indent}ELSE"
                yield from lines_of(otherwise, inner)
        case CountedLoop(start, beyond, advance, body):
            yield f"{indent}FOR {text_of(start)}; UNTIL {text_of(beyond)}; {text_of(advance)}"
            yield from lines_of(body, inner)
        case ConditionLoop(condition, body, before):
            yield f"{indent}{'WHILE' if before else 'REPEAT WHILE'} {text_of(condition)}"
            yield from lines_of(body, inner)
        case Protected():
            yield f"{indent}TRY"
            yield from lines_of(statement.body, inner)
            if statement.has_handler:
                code = "" if statement.code is None else f" {storage_text(statement.code)}"
                yield f"{indent}CATCH{code}"
                yield from lines_of(statement.handler, inner)
            if statement.final:
                yield f"{indent}FINALLY"
                yield from lines_of(statement.final, inner)
        case LoopExit():
            yield f"{indent}EXIT;"
        case LoopNext():
            yield f"{indent}CONTINUE;"
        case RoutineExit():
            yield f"{indent}RETURN;"
        case JumpTo(label):
            yield f"{indent}JMP {label};"
        case JumpMark(label):
            yield f"{indent}{label}:"
        case LifeStep(event, storage, of, count):
            times = "" if count == 1 else f" * {count}"
            arguments = _list(statement.arguments, ": ")
            yield f"{indent}{event.value} {storage_text(storage)} : {of.name}{times}{arguments}"
            yield from lines_of(statement.values, inner)
