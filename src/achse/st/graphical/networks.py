"""Trees of network lists: bodies in ladder diagram, function block diagram, instruction list.

The three share one form: a ladder has no contacts in its file, but an expression tree. Contacts
in series are the inputs of an AND box, contacts in parallel those of an OR box.

Source: LD, FBD and IL bodies of public TwinCAT 3 projects.
"""

from collections.abc import Iterable, Sequence
from enum import IntFlag
from typing import TypeAlias, TypeVar

from achse.st.graphical.archive import ArchiveObject, read_archive
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import node, place

_T = TypeVar("_T")


class Modifier(IntFlag):
    """Modifiers of an operand, pin, box result or target."""

    NEGATED = 1
    SET = 2
    """Set of a target; with NEGATED a reset."""
    JUMP = 4
    """Jump of a target, whose text is a label."""
    RETURN = 8
    """Return of a target."""
    RISING = 16
    FALLING = 32


_EDGES = Modifier.RISING | Modifier.FALLING
_KNOWN = sum(Modifier)


@node
class NetworkOperand:
    """A variable, literal or expression, as Structured Text; a target, a label."""

    text: str
    """Empty for a pin that is not wired, `???` for one that was never filled in."""
    modifiers: int
    """Bits of `Modifier`."""
    id: int
    at: int = place()


@node
class Unconnected:
    """The left end of a branch: the power that arrives there."""

    at: int = place()


@node
class NetworkWire:
    """A value with a number: defined where it has an input, else read."""

    number: int
    input: "NetworkNode | None"
    at: int = place()


@node
class Parallel:
    """A closed parallel branch of a ladder."""

    input: "NetworkNode | None"
    branches: "tuple[NetworkNode, ...]"
    is_sequential: bool
    """False for the form whose branches with boxes are bridged by those without."""
    at: int = place()


@node
class BoxInput:
    """An input of a box: its pin and what leads to it."""

    name: str
    """Empty for operators."""
    type: str
    """Type as resolved by the editor; may be empty or out of date."""
    node: "NetworkNode"
    modifiers: int


@node
class BoxOutput:
    """An output of a box."""

    name: str
    target: NetworkOperand | None
    """None for an output that is not assigned."""
    is_read: bool
    """True for the output that the node around the box reads."""
    type: str = ""
    """Its type as text, if the drawing has it."""


@node
class Box:
    """A call or an operator."""

    type: str
    """Name of the operator, function, block, program, action or method."""
    instance: str
    """Path of the instance; empty without one."""
    call: str
    """Kind of call: `FunctionBlock`, `Function`, `Program`, `Action`, `Method`, `None`, or the
    operator: `And`, `Move`."""
    inputs: tuple[BoxInput, ...]
    """Without EN."""
    outputs: tuple[BoxOutput, ...]
    """Without ENO."""
    enable: BoxInput | None
    """EN, if it is shown."""
    enable_output: BoxOutput | None
    """ENO, if it is shown."""
    text: str | None
    """Statements of an Execute box."""
    modifiers: int
    id: int
    at: int = place()

    @property
    def is_call(self) -> bool:
        """True for what is executed; False for an operator."""
        return self.call in _CALLS


_CALLS = frozenset(("FunctionBlock", "Function", "Program", "Action", "Method", "None"))


@node
class Assignment:
    """A value that is written to targets, coils, jumps."""

    targets: tuple[NetworkOperand, ...]
    value: "NetworkNode | None"
    at: int = place()


NetworkNode: TypeAlias = NetworkOperand | Unconnected | NetworkWire | Parallel | Box | Assignment


@node
class Instruction:
    """A line of an instruction list."""

    prefix: str
    operator: str
    operand: NetworkOperand
    postfix: str
    at: int = place()


@node
class DrawnNetwork:
    """A network: its trees, or the lines of its instruction list."""

    number: int
    """From 1, as the editor counts."""
    title: str
    label: str
    is_disabled: bool
    """True if it is commented out."""
    items: tuple[NetworkNode, ...]
    lines: tuple[Instruction, ...]
    """Lines of a network shown as instruction list; `items` is not used then."""
    at: int = place()

    @property
    def target(self) -> str:
        """The label that jumps can name; empty for a remark in its field."""
        return self.label if self.label.isidentifier() else ""


@node
class NetworkList:
    """A body of networks."""

    view: str
    """Editor that shows it: `Ld`, `Fbd` or `Il`."""
    networks: tuple[DrawnNetwork, ...]


def read_networks(text: str) -> NetworkList:
    """Return the networks of a body. Raises `Unexpected` for what the format does not have."""
    root = read_archive(text)
    if root.type != "NWLImplementationObject":
        raise Unexpected(
            root.at,
            f"expected an NWLImplementationObject, got '{root.type[:80]}'",
            Code.BAD_DRAWING,
        )
    numbered = enumerate(root.objects("NetworkList"), 1)
    networks = tuple(_network(item, number) for number, item in numbered)
    return NetworkList(root.text("DefaultViewMode", "Ld"), networks)


def _network(source: ArchiveObject, number: int) -> DrawnNetwork:
    is_disabled = source.flag("OutCommented")
    is_list = source.flag("ILActive")
    items: Iterable[ArchiveObject] = (
        () if is_disabled or is_list else source.objects("NetworkItems")
    )
    lines = source.objects("ILLines") if is_list and not is_disabled else ()
    return DrawnNetwork(
        number,
        source.text("Title"),
        source.text("Label"),
        is_disabled,
        tuple(_node(item) for item in items),
        tuple(_instruction(item) for item in lines),
        source.at,
    )


def _node(source: ArchiveObject) -> NetworkNode:
    match source.type:
        case "BoxTreeOperand":
            operand = source.part("Operand")
            if operand is None:
                raise Unexpected(source.at, "a BoxTreeOperand has no operand", Code.BAD_DRAWING)
            return _operand(operand)
        case "BoxTreeAssign":
            value = source.part("RValue")
            targets = _listed(source)
            return Assignment(
                tuple(_operand(item) for item in targets if isinstance(item, ArchiveObject)),
                None if value is None else _node(value),
                source.at,
            )
        case "BoxTreeBox":
            return _box(source)
        case "BoxTreeDemux":
            return NetworkWire(source.number("VarId"), _optional(source), source.at)
        case "BoxTreeParallel":
            return Parallel(
                _optional(source),
                tuple(_node(item) for item in source.objects("Trees")),
                source.text("Mode") == "Sequential",
                source.at,
            )
        case "BoxTreeTerminator":
            if source.part("Input") is not None:
                raise Unexpected(
                    source.at,
                    "a BoxTreeTerminator with an input is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )
            return Unconnected(source.at)
    raise Unexpected(
        source.at, f"'{source.type[:80]}' is not supported in a network", Code.UNSUPPORTED_DRAWING
    )


def _optional(source: ArchiveObject) -> NetworkNode | None:
    value = source.part("Input")
    return None if value is None else _node(value)


def _listed(source: ArchiveObject) -> list[ArchiveObject | str | None]:
    """Return the `OutputItems` in the object `OutputItems`."""
    outer = source.part("OutputItems")
    inner = None if outer is None else outer.part("OutputItems")
    return [] if inner is None else inner.items


def _operand(source: ArchiveObject) -> NetworkOperand:
    return NetworkOperand(
        source.text("Operand").strip(), _modifiers(source), source.number("Id"), source.at
    )


def _modifiers(source: ArchiveObject) -> int:
    flags = source.part("Flags")
    number = 0 if flags is None else flags.number("Flags")
    if number & ~_KNOWN:
        raise Unexpected(source.at, f"flags {number} are not supported", Code.UNSUPPORTED_DRAWING)
    return number


def _box(source: ArchiveObject) -> Box:
    names, types = _parameters(source, "InputParam")
    flags = [_pin(item) for item in source.objects("InputFlags")]
    items = source.objects("InputItems")
    inputs = [
        BoxInput(_at(names, index, ""), _at(types, index, ""), _node(item), _at(flags, index, 0))
        for index, item in enumerate(items)
    ]
    outputs = _outputs(source)
    has_en = source.flag("EN") or _is_named(source, "EN", names)
    has_eno = source.flag("ENO") or _is_named(source, "ENO", _parameters(source, "OutputParam")[0])
    if (has_en and not inputs) or (has_eno and not outputs):
        raise Unexpected(
            source.at, "a box shows EN or ENO, and its file has none", Code.BAD_DRAWING
        )
    instance = source.part("Instance")
    return Box(
        source.text("BoxType").strip(),
        "" if instance is None else instance.text("Operand").strip(),
        source.text("CallType"),
        tuple(inputs[has_en:]),
        tuple(outputs[has_eno:]),
        inputs[0] if has_en else None,
        outputs[0] if has_eno else None,
        _snippet(source),
        _modifiers(source),
        source.number("Id"),
        source.at,
    )


def _is_named(source: ArchiveObject, key: str, names: Sequence[str]) -> bool:
    """Return True if a box of an older editor, whose flag is null, shows EN or ENO."""
    return source.members.get(key, "") is None and bool(names) and names[0].upper() == key


def _at(list: Sequence[_T], index: int, default: _T) -> _T:
    return list[index] if index < len(list) else default


def _parameters(source: ArchiveObject, name: str) -> tuple[list[str], list[str]]:
    """Return names and types of the pins."""
    list = source.part(name)
    if list is None:
        return [], []
    texts = [
        [item.strip() if isinstance(item, str) else "" for item in (part.items if part else ())]
        for part in (list.part("Names"), list.part("Types"))
    ]
    return texts[0], texts[1]


def _pin(source: ArchiveObject) -> int:
    number = source.number("Flags")
    if number & ~(Modifier.NEGATED | _EDGES):
        raise Unexpected(
            source.at, f"flags {number} are not supported on an input", Code.UNSUPPORTED_DRAWING
        )
    return number


def _outputs(source: ArchiveObject) -> list[BoxOutput]:
    """Return the outputs with a slot; a null slot is the one that the node around reads."""
    names, types = _parameters(source, "OutputParam")
    slots = _listed(source)
    outputs = []
    for number, item in enumerate(slots):
        name = names[number] if number < len(names) else None
        operand = _operand(item) if isinstance(item, ArchiveObject) else None
        if name is None and operand is not None and operand.text in ("", "???"):
            continue  # behind an action or program: left over
        target = operand if operand is not None and operand.text else None
        type = types[number] if number < len(types) else None
        outputs.append(BoxOutput((name or "").strip("'"), target, item is None, type or ""))
    return outputs


def _snippet(source: ArchiveObject) -> str | None:
    if not source.flag("ProvidesSTSnippet"):
        return None
    here: ArchiveObject | None = source
    for name in ("STSnippet", "STSnippet", "TextDocument"):
        here = None if here is None else here.part(name)
    lines = [] if here is None else here.objects("TextLines")
    return "\n".join(line.text("Text") for line in lines)


def _instruction(source: ArchiveObject) -> Instruction:
    operand = source.part("Operand")
    return Instruction(
        source.text("Prefix").strip(),
        source.text("Operator").strip(),
        NetworkOperand("", 0, 0, source.at) if operand is None else _operand(operand),
        source.text("Postfix").strip(),
        source.at,
    )
