"""Drawn bodies for tests: nodes of networks as the XML of a `.TcPOU`, and a PLC that runs it."""

from collections.abc import Iterable, Sequence
from itertools import count
from typing import Any
from xml.sax.saxutils import escape

from achse.iec import plain
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.system_info import system_info_list
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.files.envelope import WITHOUT_TEXT, parse_envelope
from achse.st.lexis.xml import parse_xml
from achse.st.syntax.parser import Parsed, parse

NEGATED, SET, RESET, JUMP, RETURN, RISING, FALLING = 1, 2, 3, 4, 8, 16, 32
_ids = count(1)


def scalar(name: str, value: object) -> str:
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return f'<v n="{name}">{escape(text)}</v>\n'


def quoted(name: str, text: str) -> str:
    return scalar(name, f'"{text}"')


def thing(type: str, inside: str, name: str = "") -> str:
    label = f' n="{name}"' if name else ""
    return f'<o{label} t="{type}">\n{inside}</o>\n'


def listed(name: str, items: Iterable[str]) -> str:
    return f'<l2 n="{name}">\n{"".join(items)}</l2>\n'


def flags(number: int) -> str:
    return thing("Flags", scalar("Flags", number) + scalar("Fixed", False), "Flags")


def operand(text: str, number: int = 0, name: str = "") -> str:
    inside = quoted("Operand", text) + quoted("Type", "BOOL") + flags(number)
    return thing("Operand", inside + scalar("Id", f"{next(_ids)}L"), name)


def contact(text: str, number: int = 0) -> str:
    return thing("BoxTreeOperand", operand(text, number, "Operand"))


def open_end() -> str:
    return thing("BoxTreeTerminator", '<n n="Input" />')


def wire(number: int, input: str = "") -> str:
    inside = input.replace("<o ", '<o n="Input" ', 1) if input else '<n n="Input" />'
    return thing("BoxTreeDemux", scalar("VarId", number) + inside)


def parallel(branches: Sequence[str], input: str = "", *, sequential: bool = False) -> str:
    inside = input.replace("<o ", '<o n="Input" ', 1) if input else '<n n="Input" />'
    mode = "Sequential" if sequential else "BoxShortCircuit"
    return thing(
        "BoxTreeParallel", inside + listed("Trees", branches) + f'<v n="Mode" t="M">{mode}</v>'
    )


def assign(value: str, *targets: str | tuple[str, int]) -> str:
    items = [operand(*((one, 0) if isinstance(one, str) else one)) for one in targets]
    outputs = thing("OutputItemList", listed("OutputItems", items), "OutputItems")
    return thing("BoxTreeAssign", outputs + value.replace("<o ", '<o n="RValue" ', 1))


def box(
    type: str,
    *inputs: str,
    call: str = "",
    instance: str = "",
    names: Sequence[str] = (),
    types: Sequence[str] = (),
    outputs: Sequence[tuple[str, str | tuple[str, int] | None]] = (),
    output_types: Sequence[str] = (),
    en: str | None = None,
    eno: bool | None = None,
    pins: Sequence[int] = (),
    number: int = 0,
    text: str | None = None,
) -> str:
    """A box; an output `(name, None)` is the one that the node around it reads."""
    shows_eno = eno if eno is not None else en is not None
    if en is not None:
        inputs = (en, *inputs)
        names, types = ("EN", *names), ("BOOL", *types)
    slots = [
        "<n />\n" if target is None
        else operand(*((target, 0) if isinstance(target, str) else target))
        for _, target in outputs
    ]  # fmt: skip
    bare = "".join
    inside = quoted("BoxType", type) + operand(instance, name="Instance")
    inside += f'<v n="CallType" t="Operator">{call or type.title()}</v>'
    inside += listed("InputItems", inputs)
    inside += thing(
        "ParamList",
        listed("Names", [bare(("<v>", one, "</v>")) for one in names])
        + listed("Types", [bare(("<v>", one, "</v>")) for one in types]),
        "InputParam",
    )
    inside += thing(
        "ParamList",
        listed("Names", [f"<v>{one}</v>" for one, _ in outputs])
        + listed("Types", [f"<v>{one}</v>" for one in output_types]),
        "OutputParam",
    )
    inside += thing("OutputItemList", listed("OutputItems", slots), "OutputItems")
    inside += scalar("EN", en is not None) + scalar("ENO", shows_eno)
    if pins:
        inside += listed("InputFlags", [thing("Flags", scalar("Flags", one)) for one in pins])
    if text is not None:
        lines = [thing("TextLine", quoted("Text", line)) for line in text.split("\n")]
        array = f'<a n="TextLines">{"".join(lines)}</a>'
        implementation = thing("STImplementationObject", thing("T", array, "TextDocument"))
        implementation = implementation.replace("<o ", '<o n="STSnippet" ', 1)
        inside += thing("STSnippet", implementation, "STSnippet") + scalar(
            "ProvidesSTSnippet", True
        )
    return thing("BoxTreeBox", inside + flags(number) + scalar("Id", f"{next(_ids)}L"))


def series(*inputs: str) -> str:
    return box("AND", *inputs)


def branches(*inputs: str) -> str:
    return box("OR", *inputs)


def fb(
    type: str,
    instance: str,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str | tuple[str, int] | None]] = (("Q", None),),
    **more: Any,
) -> str:
    names = [name for name, _ in inputs]
    return box(
        type, *(node for _, node in inputs), call="FunctionBlock", instance=instance, names=names,
        types=["BOOL" if name in ("IN", "CLK") else "X" for name in names], outputs=outputs, **more,
    )  # fmt: skip


def network(*items: str, label: str = "", disabled: bool = False) -> str:
    inside = scalar("ILActive", False) + quoted("Label", label) + scalar("OutCommented", disabled)
    return thing("Network", inside + listed("NetworkItems", items))


def line(
    operator: str, text: str = "", *, prefix: str = "", postfix: str = "", number: int = 0
) -> str:
    inside = quoted("Operator", operator) + quoted("Prefix", prefix) + quoted("Postfix", postfix)
    return thing("ILStatement", inside + operand(text, number, "Operand"))


def instructions(*lines: str, label: str = "") -> str:
    inside = scalar("ILActive", True) + quoted("Label", label) + scalar("OutCommented", False)
    return thing("Network", inside + listed("ILLines", lines))


def networks(*items: str, view: str = "Ld") -> str:
    root = thing(
        "NWLImplementationObject",
        quoted("DefaultViewMode", view) + listed("NetworkList", items),
    )
    return f"<NWL><XmlArchive><Data>{root}</Data></XmlArchive></NWL>"


def unit(declaration: str, body: str, parts: str = "", settings: str = "") -> str:
    """A whole `.TcPOU`."""
    name = declaration.split()[1]
    head = f"<Declaration><![CDATA[{declaration}]]></Declaration>"
    return (
        f'<TcPlcObject>\n<POU Name="{name}">\n{head}\n'
        f"<Implementation>\n{body}</Implementation>\n{parts}{settings}</POU></TcPlcObject>"
    )


def part(tag: str, name: str, body: str, declaration: str = "") -> str:
    head = f"<Declaration><![CDATA[{declaration}]]></Declaration>" if declaration else ""
    if not body.startswith("<"):
        body = f"<ST><![CDATA[{body}]]></ST>"
    return f'<{tag} Name="{name}">{head}<Implementation>{body}</Implementation></{tag}>\n'


def read(text: str, path: str = "MAIN.TcPOU") -> Parsed:
    return parse_envelope(parse_xml(text.encode(), path, skip=WITHOUT_TEXT), path)


class Drawn:
    """A program MAIN that is drawn, run in virtual time by cycles of 10 ms."""

    def __init__(self, text: str | Parsed, *others: str, form: CodeForm = CodeForm.PLAIN) -> None:
        first = read(text) if isinstance(text, str) else text
        self.sources = [first, *(parse(other, name="GVL") for other in others)]
        project = declare(self.sources)
        system = system_info_list([Task()], app_name="", project_name="", port=0, timestamp=0)
        self.typed = check(project, predefined=[system])
        assert not self.typed.faults, "\n".join(map(str, self.typed.faults))
        self.task = Task("PlcTask", 10_000_000, [project.programs["main"]])
        self.plc = PlcRuntime([self.task], project.units, bodies=Bodies(self.typed, form=form))

    def cycle(self, **values: Any) -> "Drawn":
        """Put values into variables and run one cycle."""
        instance: Any = self.plc.instance("MAIN")
        for name, value in values.items():
            setattr(instance, name, value)
        self.plc.run_due(self.task.due_ns)
        assert self.plc.state is PlcState.RUN, self.plc.fault
        return self

    def __getitem__(self, path: str) -> Any:
        value: Any = self.plc.instance("MAIN")
        for name in path.split("."):
            value = value[name]
        return plain(value)

    def rows(self, inputs: str, outputs: str, rows: Iterable[str]) -> None:
        """Check lines `inputs | outputs`, one a cycle."""
        for number, row in enumerate(rows, 1):
            row_inputs, _, expected = row.partition("|")
            values = dict(zip(inputs.split(), map(int, row_inputs.split()), strict=True))
            self.cycle(**values)
            outcome = [int(self[name]) for name in outputs.split()]
            assert outcome == [int(word) for word in expected.split()], f"cycle {number}: {row}"


# charts ------------------------------------------------------------------------------------------

_GUIDS = {
    "name": "38391c6d",
    "initial": "6844a48e",
    "main": "700a583f",
    "entry": "a6b08bd8",
    "exit": "a2621e18",
    "minimum": "cacf1a68",
    "maximum": "b693554c",
    "parallel": "23bdaa98",
    "qualifier": "e174fc0d",
    "exclude": "01580b27",
}


def _element(type: str, inside: Iterable[str] | None = None, **attributes: str) -> str:
    items = [
        thing(
            "SFCAttribute",
            scalar("AttributeId", "{" + _GUIDS[key] + "-6d4a-42f8-8ee7-9f45e5adafa8}")
            + thing("StringValue", quoted("Value", value), "Value"),
        )
        for key, value in attributes.items()
    ]
    nested = ""
    if inside is not None:
        nested = thing("SFCElementList", listed("InnerList", inside), "ElementList")
    return thing(type, nested + listed("Attributes", items))


def step(name: str, *actions: tuple[str, str], **attributes: str) -> str:
    """A step with actions `(name, qualifier)`, and `initial`, `main`, `entry`, `exit` …"""
    associations = [
        _element("SFCActionAssociation", name=one, qualifier=two) for one, two in actions
    ]
    return _element("SFCStep", associations, name=name, **attributes)


def transition(text: str) -> str:
    return _element("SFCTransition", name=text)


def jump(target: str) -> str:
    return _element("SFCJump", name=target)


def segment(*elements: str) -> str:
    return thing(
        "SFCSegment", thing("SFCElementList", listed("InnerList", elements), "ElementList")
    )


def branch(*segments: str, parallel: bool = False, name: str = "Branch0") -> str:
    return _element("SFCBranch", segments, name=name, parallel=str(parallel).upper())


def macro(*elements: str) -> str:
    inside = segment(*elements).replace("<o ", '<o n="Segment" ', 1)
    return thing("SFCMacro", inside)


def chart(*elements: str) -> str:
    root = segment(*elements).replace("<o ", '<o n="Root" ', 1)
    body = thing("SFCImplementationObject", root)
    return f"<SFC><XmlArchive><Data>{body}</Data></XmlArchive></SFC>"


def sfc_flags(*names: str) -> str:
    """The settings of a POU whose chart uses these flags."""
    rows = "".join(
        f'<v>"{name}"</v>\n'
        + thing("SFCPropertyFlagData", scalar("Use", True) + scalar("Declare", True))
        for name in names
    )
    root = thing("SFCProperty", f'<d2 n="Flags" ckt="String">{rows}</d2>')
    archive = f"<XmlArchive><Data>{root}</Data></XmlArchive>"
    return f"<ObjectProperties>{archive}</ObjectProperties>\n"


# function charts ---------------------------------------------------------------------------------

Source = str | int
"""Text of an input element, or the number of the pin that leads here."""


class Canvas:
    """Collects the elements of a function chart; each returns the pins of its outputs."""

    def __init__(self) -> None:
        self.items: list[str] = []
        self._pins = count(1)
        self._rows = count(1)

    def _pin(self, number: int, *, negated: bool = False, type: str = "CFCInputPin") -> str:
        return thing(type, scalar("Id", f"{number}L") + scalar("Negated", negated))

    def connect(self, source: Source, destination: int) -> None:
        if isinstance(source, str):
            pin = next(self._pins)
            inside = self._pin(pin, type="CFCOutputPin").replace("<o ", '<o n="Output" ', 1)
            self.items.append(
                thing("CFCInputElement", inside + thing("CFCText", quoted("Text", source), "Text"))
            )
            source = pin
        ends = scalar("SourcePinId", f"{source}L") + scalar("DestPinId", f"{destination}L")
        self.items.append(thing("CFCConnection", ends))

    def output(
        self, text: str, source: Source | None = None, *, storing: str = "None", row: int = 0
    ) -> int:
        """An output; returns its pin."""
        pin = next(self._pins)
        inside = scalar("Id", f"{pin}L") + scalar("Negated", False)
        inside += f'<v n="SetReset" t="S">{storing}</v>'
        inside = thing("CFCInputPinWithSetReset", inside, "Input")
        inside += quoted("Bounds", f"20, {row or next(self._rows)}, 0, 0")
        inside += thing("CFCText", quoted("Text", text), "Text")
        self.items.append(thing("CFCOutputElement", inside))
        if source is not None:
            self.connect(source, pin)
        return pin

    def box(
        self,
        type: str,
        *sources: Source | None,
        call: str = "Operator",
        instance: str = "",
        names: Sequence[str] = (),
        outputs: Sequence[str] = ("",),
        negated: Sequence[int] = (),
        start: bool | None = None,
        row: int = 0,
        in_outs: Sequence[int] = (),
    ) -> tuple[list[int], list[int]]:
        """A box; returns the pins of its inputs and outputs."""
        pins = [next(self._pins) for _ in sources]
        out = [next(self._pins) for _ in outputs]
        wrapped = "<o n={!r} t='CFCItemList'>{}</o>".format
        inputs = [
            self._pin(
                pin,
                negated=number in negated,
                type="CFCInOutPin" if number in in_outs else "CFCInputPin",
            )
            for number, pin in enumerate(pins)
        ]
        texts = [*(names or [""] * len(pins)), *outputs, type, instance]
        inside = wrapped("Inputs", listed("InnerList", inputs))
        inside += wrapped("Outputs", listed("InnerList", map(self._pin, out)))
        inside += wrapped(
            "Texts", listed("InnerList", [thing("CFCText", quoted("Text", one)) for one in texts])
        )
        inside = inside.replace("'", '"')
        inside += quoted("Bounds", f"10, {row or next(self._rows)}, 0, 0")
        inside += scalar("EnEno", False) + f'<v n="KindOfCall" t="K">{call}</v>'
        if start is not None:
            inside += scalar("IsFeedbackStart", start)
        self.items.append(thing("CFCBoxElement", inside))
        for source, pin in zip(sources, pins, strict=True):
            if source is not None:
                self.connect(source, pin)
        return pins, out

    def __str__(self) -> str:
        inside = thing("CFCItemList", listed("InnerList", self.items), "Items")
        root = thing("CFCImplementationObject", inside)
        return f"<CFC><XmlArchive><Data>{root}</Data></XmlArchive></CFC>"


def explicit_order(value: bool) -> str:
    root = thing("CFCProperty", scalar("UseExplicitExecutionOrder", value))
    archive = f"<XmlArchive><Data>{root}</Data></XmlArchive>"
    return f"<ObjectProperties>{archive}</ObjectProperties>\n"
