"""Trees of continuous function charts (CFC): elements, pins, and the connections between them.

Source: CFC bodies of public TwinCAT 3 projects.
"""

from typing import TypeAlias

from achse.st.graphical.archive import ArchiveObject, read_archive
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import whole_number
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import node, place


@node
class ChartPin:
    """A pin of an element."""

    id: int
    name: str
    """Empty for operators, inputs and outputs."""
    is_negated: bool
    is_in_out: bool = False
    edge: int = 0
    """`Modifier.RISING` or `FALLING`: an edge of the value, negated first."""


@node
class ChartInput:
    """An expression."""

    text: str
    output: ChartPin
    at: int = place()


@node
class ChartOutput:
    """A variable that is written."""

    text: str
    input: ChartPin
    storing: str
    """`None`, `Set` or `Reset`."""
    bounds: tuple[int, int]
    at: int = place()


@node
class ChartBox:
    """A call or an operator."""

    call: str
    """`Operator`, `FunctionBlock`, `Function`, `Method`, `LocalMethod` or `Program`."""
    type: str
    instance: str
    inputs: tuple[ChartPin, ...]
    outputs: tuple[ChartPin, ...]
    starts_feedback: bool
    bounds: tuple[int, int]
    """Left and top on the canvas, in grid units."""
    at: int = place()
    enable: ChartPin | None = None
    """EN, if it is shown."""
    enable_output: ChartPin | None = None
    """ENO, if it is shown."""


@node
class ChartComposer:
    """A structure made of its inputs."""

    type: str
    inputs: tuple[ChartPin, ...]
    output: ChartPin
    bounds: tuple[int, int]
    at: int = place()


@node
class ChartSelector:
    """The components of a structure."""

    type: str
    input: ChartPin
    outputs: tuple[ChartPin, ...]
    bounds: tuple[int, int]
    at: int = place()


@node
class ChartLeave:
    """A jump to a label if its input is TRUE; a return if it has no label."""

    label: str
    input: ChartPin
    bounds: tuple[int, int]
    at: int = place()


@node
class ChartLabel:
    """A place that jumps lead to."""

    name: str
    bounds: tuple[int, int]
    at: int = place()


Ordered: TypeAlias = (
    ChartOutput | ChartBox | ChartComposer | ChartSelector | ChartLeave | ChartLabel
)
"""Elements that have a place in the order of execution."""


@node
class FunctionChart:
    """A whole chart."""

    inputs: tuple[ChartInput, ...]
    ordered: tuple[Ordered, ...]
    """In the order of the file, which is that of execution if the order is explicit."""
    sources: tuple[tuple[int, int], ...]
    """Pins that are connected: `(destination, source)`."""
    knows_feedback: bool
    """True for files of 3.1.4026 and newer, whose order is automatic unless they say otherwise."""


def read_explicit_order(settings: str) -> bool | None:
    """Return `UseExplicitExecutionOrder` from the settings of a POU; None without it."""
    place = settings.find('n="UseExplicitExecutionOrder"')
    if place < 0:
        return None
    return settings[settings.index(">", place) + 1 :].lstrip().startswith("true")


def read_function_chart(text: str) -> FunctionChart:
    """Return the chart of a body. Raises `Unexpected` for what the format does not have."""
    root = read_archive(text)
    if root.type != "CFCImplementationObject":
        raise Unexpected(
            root.at, f"expected a CFCImplementationObject, got '{root.type[:80]}'", Code.BAD_DRAWING
        )
    outer = root.part("Items")
    inputs: list[ChartInput] = []
    ordered: list[Ordered] = []
    sources: list[tuple[int, int]] = []
    knows_feedback = False
    for found in () if outer is None else outer.objects("InnerList"):
        match found.type:
            case "CFCInputElement":
                inputs.append(ChartInput(_text(found), _pin(found, "Output"), found.at))
            case "CFCOutputElement":
                ordered.append(_output(found))
            case "CFCBoxElement":
                knows_feedback |= "IsFeedbackStart" in found.members
                ordered.append(_box(found))
            case "CFCComposerElement":
                ordered.append(_composer(found))
            case "CFCSelectorElement":
                ordered.append(_selector(found))
            case "CFCConnection":
                sources.append((found.number("DestPinId"), found.number("SourcePinId")))
            case "CFCCommentElement":
                pass
            case _:
                raise Unexpected(
                    found.at,
                    f"'{found.type[:80]}' is not supported in a chart",
                    Code.UNSUPPORTED_DRAWING,
                )
    return FunctionChart(tuple(inputs), tuple(ordered), tuple(sources), knows_feedback)


def _text(found: ArchiveObject) -> str:
    text = found.part("Text")
    return "" if text is None else text.text("Text").strip()


def _texts(found: ArchiveObject) -> list[str]:
    return [item.text("Text").strip() for item in _inner(found, "Texts")]


def _inner(found: ArchiveObject, name: str) -> list[ArchiveObject]:
    """The elements of a list that is in an object."""
    outer = found.part(name)
    return [] if outer is None else outer.objects("InnerList")


def _bounds(found: ArchiveObject) -> tuple[int, int]:
    parts = found.text("Bounds").split(",")
    numbers = [whole_number(one) for one in parts]
    left, top, *_ = (*numbers, 0, 0)
    return left, top


def _pin(found: ArchiveObject, name: str) -> ChartPin:
    pin = found.part(name)
    if pin is None:
        raise Unexpected(found.at, f"an element has no {name.lower()} pin", Code.BAD_DRAWING)
    return _of_pin(pin, "")


def _of_pin(pin: ArchiveObject, name: str) -> ChartPin:
    return ChartPin(pin.number("Id"), name, pin.flag("Negated"), pin.type == "CFCInOutPin")


def _pins(found: ArchiveObject, name: str, names: list[str]) -> tuple[ChartPin, ...]:
    pins = _inner(found, name)
    return tuple(_of_pin(pin, one) for pin, one in zip(pins, names, strict=False))


def _output(found: ArchiveObject) -> ChartOutput:
    pin = found.part("Input")
    if pin is None:
        raise Unexpected(found.at, "an output has no pin", Code.BAD_DRAWING)
    storing = pin.text("SetReset", "None")
    if storing not in ("None", "Set", "Reset"):
        raise Unexpected(
            found.at, f"SetReset {storing[:20]} is not supported", Code.UNSUPPORTED_DRAWING
        )
    return ChartOutput(_text(found), _of_pin(pin, ""), storing, _bounds(found), found.at)


def _box(found: ArchiveObject) -> ChartBox:
    texts = _texts(found)
    inputs, outputs = _inner(found, "Inputs"), _inner(found, "Outputs")
    if len(texts) != len(inputs) + len(outputs) + 2:
        raise Unexpected(
            found.at,
            f"a box has {len(texts)} texts, which its pins do not explain",
            Code.BAD_DRAWING,
        )
    if found.flag("EnEno"):
        raise Unexpected(
            found.at,
            f"the box {texts[-2][:80]} shows EN and ENO: not supported here",
            Code.UNSUPPORTED_DRAWING,
        )
    count = len(inputs)
    return ChartBox(
        found.text("KindOfCall"),
        texts[-2],
        texts[-1],
        _pins(found, "Inputs", texts[:count]),
        _pins(found, "Outputs", texts[count:-2]),
        found.flag("IsFeedbackStart"),
        _bounds(found),
        found.at,
    )


def _composer(found: ArchiveObject) -> ChartComposer:
    texts = _texts(found)
    if len(texts) != len(_inner(found, "Inputs")) + 1:
        raise Unexpected(
            found.at, "a composer has texts that its pins do not explain", Code.BAD_DRAWING
        )
    inputs = _pins(found, "Inputs", texts[:-1])
    return ChartComposer(texts[-1], inputs, _pin(found, "Output"), _bounds(found), found.at)


def _selector(found: ArchiveObject) -> ChartSelector:
    texts = _texts(found)
    if len(texts) != len(_inner(found, "Outputs")) + 1:
        raise Unexpected(
            found.at, "a selector has texts that its pins do not explain", Code.BAD_DRAWING
        )
    outputs = _pins(found, "Outputs", texts[1:])
    return ChartSelector(texts[0], _pin(found, "Input"), outputs, _bounds(found), found.at)
