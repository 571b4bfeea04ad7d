"""Networks of the ladder editor of TwinCAT 3.1.4026, which has them as JSON, in drawn order.

A power line runs through the elements of a sequence. The input of a block whose sequence is empty
is fed by the element left of the block; the output without a variable is the one that runs on.
Keys that were not seen are refused by name.

Source: one public project.
"""

import json
from itertools import count
from typing import Any, TypeAlias

from achse.st.graphical.archive import read_archive
from achse.st.graphical.networks import (
    Assignment,
    Box,
    BoxInput,
    BoxOutput,
    DrawnNetwork,
    Modifier,
    NetworkList,
    NetworkNode,
    NetworkOperand,
    Parallel,
    Unconnected,
)
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected

_Json: TypeAlias = dict[str, Any]
_KEYS = {
    "LadderDataModel": ("Networks",),
    "Network": ("Id", "Sequence"),
    "Sequence": ("Elements",),
    "Contact": ("Operand",),
    "Coil": ("Operand",),
    "InVariable": ("Operand",),
    "OutVariable": ("Operand",),
    "Operand": ("Expression", "Modifier"),
    "Modifier": ("Negation",),
    "ParallelClosed": ("Branches",),
    "Block": ("BlockType", "Instance", "CallType", "Inputs", "Outputs"),
    "Input": ("Pin", "Sequence"),
    "Output": ("Pin", "OutVariable"),
    "Pin": ("Name",),
}
_CALLS = {None: "", 2: "FunctionBlock", 3: "Function"}


def read_ladder(text: str) -> NetworkList:
    """Return the networks of a body. Raises `Unexpected` for what the format does not have."""
    root = read_archive(text)
    try:
        return _Reader(text, root.at).model(json.loads(root.text("ModelJson")))
    except (ValueError, TypeError, AttributeError) as error:
        raise Unexpected(
            root.at, f"expected a ladder model in JSON: {error}", Code.BAD_DRAWING
        ) from None


class _Reader:
    """Makes nodes; those of a network are at the place of its `Id`."""

    def __init__(self, text: str, at: int) -> None:
        self._text = text
        self._start = at
        self._at = count(at)
        self._ids = count(1)

    def model(self, entry: _Json) -> NetworkList:
        self._check(entry, "LadderDataModel")
        networks = []
        for number, one in enumerate(entry.get("Networks", ()), 1):
            self._check(one, "Network")
            place = self._text.find(str(one.get("Id", "")), self._start)
            self._at = count(max(place, self._start))
            at = next(self._at)
            node = self._sequence(one.get("Sequence", {}))
            items = () if node is None else (node,)
            networks.append(DrawnNetwork(number, "", "", False, items, (), at))
        return NetworkList("Ld", tuple(networks))

    def _check(self, entry: Any, *types: str) -> str:
        """Return the type of an object; refuse other types and keys."""
        kind = entry.get("$type") if isinstance(entry, dict) else None
        if kind not in types:
            raise Unexpected(
                next(self._at), f"expected {types[0]}, got '{str(kind)[:40]}'", Code.BAD_DRAWING
            )
        for key in entry:
            if key != "$type" and key not in _KEYS[kind]:
                raise Unexpected(
                    next(self._at),
                    f"'{key[:40]}' of a {kind} is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )
        return str(kind)

    def _sequence(self, entry: _Json) -> NetworkNode | None:
        """Return the node at the right end of a sequence; None for an empty one."""
        self._check(entry, "Sequence")
        node: NetworkNode | None = None
        for element in entry.get("Elements", ()):
            node = self._element(element, node)
        return node

    def _element(self, entry: _Json, left: NetworkNode | None) -> NetworkNode:
        kinds = "Contact", "Coil", "InVariable", "Block", "ParallelClosed"
        match self._check(entry, *kinds):
            case "Contact":
                contact = self._operand(entry.get("Operand"))
                return contact if left is None else self._series(left, contact)
            case "Coil":
                value = NetworkOperand("TRUE", 0, 0, next(self._at)) if left is None else left
                target = self._operand(entry.get("Operand"))
                return Assignment((target,), value, next(self._at))
            case "InVariable":
                if left is not None:
                    raise Unexpected(
                        next(self._at),
                        "a variable behind an element is not supported",
                        Code.UNSUPPORTED_DRAWING,
                    )
                return self._operand(entry.get("Operand"))
            case "ParallelClosed":
                at = next(self._at)
                branches = [self._sequence(one) for one in entry.get("Branches", ())]
                nodes = tuple(Unconnected(at) if one is None else one for one in branches)
                return Parallel(left, nodes, True, at)
        return self._block(entry, left)

    def _series(self, left: NetworkNode, right: NetworkNode) -> NetworkNode:
        inputs = BoxInput("", "", left, 0), BoxInput("", "", right, 0)
        result = BoxOutput("", None, True)
        at, id = next(self._at), next(self._ids)
        return Box("AND", "", "And", inputs, (result,), None, None, None, 0, id, at)

    def _operand(self, entry: Any) -> NetworkOperand:
        self._check(entry, "Operand")
        modifier = entry.get("Modifier")
        negated = False
        if modifier is not None:
            self._check(modifier, "Modifier")
            negated = bool(modifier.get("Negation"))
        text = str(entry.get("Expression", "")).strip()
        modifiers = int(Modifier.NEGATED) if negated else 0
        return NetworkOperand(text, modifiers, next(self._ids), next(self._at))

    def _block(self, entry: _Json, left: NetworkNode | None) -> NetworkNode:
        at = next(self._at)
        name = str(entry.get("BlockType", "")).strip()
        call = _CALLS.get(entry.get("CallType"))
        if call is None:
            raise Unexpected(
                at,
                f"call type {entry['CallType']} of {name} is not supported",
                Code.UNSUPPORTED_DRAWING,
            )
        inputs: list[BoxInput] = []
        fed = 0
        for one in entry.get("Inputs", ()):
            self._check(one, "Input")
            node = self._sequence(one.get("Sequence", {"$type": "Sequence"}))
            fed += node is None
            type = "BOOL" if node is None else ""
            if node is None:
                node = Unconnected(at) if left is None else left
            inputs.append(BoxInput(self._pin(one), type, node, 0))
        if fed > 1 or (left is not None and not fed):
            raise Unexpected(
                at,
                f"the power line of {name} leads to {fed} inputs: expected one",
                Code.BAD_DRAWING,
            )
        outputs: list[BoxOutput] = []
        for one in entry.get("Outputs", ()):
            self._check(one, "Output")
            variable = one.get("OutVariable")
            target: NetworkOperand | None = None
            if variable is not None:
                self._check(variable, "OutVariable")
                operand = self._operand(variable.get("Operand"))
                target = operand if operand.text else None
            outputs.append(BoxOutput(self._pin(one), target, variable is None))
        enable = next((pin for pin in inputs if pin.name.upper() == "EN"), None)
        eno = next((out for out in outputs if enable and out.name.upper() == "ENO"), None)
        instance = entry.get("Instance")
        path = "" if instance is None else self._operand(instance).text
        return Box(
            name,
            path,
            call or name,
            tuple(pin for pin in inputs if pin is not enable),
            tuple(out for out in outputs if out is not eno),
            enable,
            eno,
            None,
            0,
            next(self._ids),
            at,
        )

    def _pin(self, entry: _Json) -> str:
        pin = entry.get("Pin", {"$type": "Pin"})
        self._check(pin, "Pin")
        return str(pin.get("Name", "")).strip()
