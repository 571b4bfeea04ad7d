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
    """Elements in the order of the file, which is the order of execution if that is explicit."""
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
    for source in () if outer is None else outer.objects("InnerList"):
        match source.type:
            case "CFCInputElement":
                inputs.append(ChartInput(_text(source), _pin(source, "Output"), source.at))
            case "CFCOutputElement":
                ordered.append(_output(source))
            case "CFCBoxElement":
                knows_feedback |= "IsFeedbackStart" in source.members
                ordered.append(_box(source))
            case "CFCComposerElement":
                ordered.append(_composer(source))
            case "CFCSelectorElement":
                ordered.append(_selector(source))
            case "CFCConnection":
                sources.append((source.number("DestPinId"), source.number("SourcePinId")))
            case "CFCCommentElement":
                pass
            case _:
                raise Unexpected(
                    source.at,
                    f"'{source.type[:80]}' is not supported in a chart",
                    Code.UNSUPPORTED_DRAWING,
                )
    return FunctionChart(tuple(inputs), tuple(ordered), tuple(sources), knows_feedback)


def _text(source: ArchiveObject) -> str:
    text = source.part("Text")
    return "" if text is None else text.text("Text").strip()


def _texts(source: ArchiveObject) -> list[str]:
    return [item.text("Text").strip() for item in _inner(source, "Texts")]


def _inner(source: ArchiveObject, name: str) -> list[ArchiveObject]:
    """Return the elements of a list that is in an object."""
    outer = source.part(name)
    return [] if outer is None else outer.objects("InnerList")


def _bounds(source: ArchiveObject) -> tuple[int, int]:
    parts = source.text("Bounds").split(",")
    numbers = [whole_number(one) for one in parts]
    left, top, *_ = (*numbers, 0, 0)
    return left, top


def _pin(source: ArchiveObject, name: str) -> ChartPin:
    pin = source.part(name)
    if pin is None:
        raise Unexpected(source.at, f"an element has no {name.lower()} pin", Code.BAD_DRAWING)
    return _of_pin(pin, "")


def _of_pin(pin: ArchiveObject, name: str) -> ChartPin:
    return ChartPin(pin.number("Id"), name, pin.flag("Negated"), pin.type == "CFCInOutPin")


def _pins(source: ArchiveObject, name: str, names: list[str]) -> tuple[ChartPin, ...]:
    pins = _inner(source, name)
    return tuple(_of_pin(pin, one) for pin, one in zip(pins, names, strict=False))


def _output(source: ArchiveObject) -> ChartOutput:
    pin = source.part("Input")
    if pin is None:
        raise Unexpected(source.at, "an output has no pin", Code.BAD_DRAWING)
    storing = pin.text("SetReset", "None")
    if storing not in ("None", "Set", "Reset"):
        raise Unexpected(
            source.at, f"SetReset {storing[:20]} is not supported", Code.UNSUPPORTED_DRAWING
        )
    return ChartOutput(_text(source), _of_pin(pin, ""), storing, _bounds(source), source.at)


def _box(source: ArchiveObject) -> ChartBox:
    texts = _texts(source)
    inputs, outputs = _inner(source, "Inputs"), _inner(source, "Outputs")
    if len(texts) != len(inputs) + len(outputs) + 2:
        raise Unexpected(
            source.at,
            f"a box has {len(texts)} texts, which its pins do not explain",
            Code.BAD_DRAWING,
        )
    if source.flag("EnEno"):
        raise Unexpected(
            source.at,
            f"the box {texts[-2][:80]} shows EN and ENO: not supported here",
            Code.UNSUPPORTED_DRAWING,
        )
    count = len(inputs)
    return ChartBox(
        source.text("KindOfCall"),
        texts[-2],
        texts[-1],
        _pins(source, "Inputs", texts[:count]),
        _pins(source, "Outputs", texts[count:-2]),
        source.flag("IsFeedbackStart"),
        _bounds(source),
        source.at,
    )


def _composer(source: ArchiveObject) -> ChartComposer:
    texts = _texts(source)
    if len(texts) != len(_inner(source, "Inputs")) + 1:
        raise Unexpected(
            source.at, "a composer has texts that its pins do not explain", Code.BAD_DRAWING
        )
    inputs = _pins(source, "Inputs", texts[:-1])
    return ChartComposer(texts[-1], inputs, _pin(source, "Output"), _bounds(source), source.at)


def _selector(source: ArchiveObject) -> ChartSelector:
    texts = _texts(source)
    if len(texts) != len(_inner(source, "Outputs")) + 1:
        raise Unexpected(
            source.at, "a selector has texts that its pins do not explain", Code.BAD_DRAWING
        )
    outputs = _pins(source, "Outputs", texts[1:])
    return ChartSelector(texts[0], _pin(source, "Input"), outputs, _bounds(source), source.at)
