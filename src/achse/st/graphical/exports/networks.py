"""Networks in `.EXP`: ladders and function block diagrams, a keyword or an operand on each line.

`_LD_ASSIGN` has the rung as a tree of contacts, then the boxes that it enables, then its coils;
`_ASSIGN` has a tree of boxes and its targets. Pins of boxes have no names.

Source: programs in public repositories that write such files. Keywords that were not seen are
refused by name.
"""

import re

from achse.st.graphical.boxes import call_of_operator
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
    NetworkWire,
    Unconnected,
)
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import changed

_COUNTED = re.compile(r"(_NETWORKS|_OUTPUTS|_BOX_EXPR|_LD_OPERATOR|ENABLELIST)\s*:\s*([0-9]{1,9})$")
_DEEPEST = 200


def read_exported_networks(text: str) -> NetworkList:
    """Return the networks of a body. Raises `Unexpected` for what was not seen."""
    return _Reader(text).body()


class _Reader:
    """Reads the lines of a body from top to bottom."""

    def __init__(self, text: str) -> None:
        self._lines: list[tuple[str, int]] = []
        start = 0
        for line in text.splitlines(keepends=True):
            if line.strip():
                self._lines.append((line.strip(), start + len(line) - len(line.lstrip())))
            start += len(line)
        self._end = len(text)
        self._position = 0
        self._depth = 0

    # lines -------------------------------------------------------------------------------------

    @property
    def _line(self) -> str:
        return self._lines[self._position][0] if self._position < len(self._lines) else ""

    @property
    def _at(self) -> int:
        return self._lines[self._position][1] if self._position < len(self._lines) else self._end

    def _next(self) -> str:
        line = self._line
        self._position += 1
        return line

    def _take(self, word: str) -> bool:
        if self._line != word:
            return False
        self._position += 1
        return True

    def _expect(self, *words: str) -> str:
        if self._line not in words:
            raise self._fault(f"expected {' or '.join(words)}, got '{self._line[:60]}'")
        return self._next()

    def _count(self, word: str) -> int:
        match = _COUNTED.match(self._line)
        if match is None or match[1] != word:
            raise self._fault(f"expected {word} : NUMBER, got '{self._line[:60]}'")
        self._position += 1
        return int(match[2])

    def _fault(self, message: str, code: Code = Code.BAD_DRAWING) -> Unexpected:
        return Unexpected(self._at, message, code)

    def _unseen(self) -> Unexpected:
        return self._fault(f"'{self._line[:60]}' is not supported here", Code.UNSUPPORTED_DRAWING)

    def _modifiers(self) -> int:
        return Modifier.NEGATED if self._expect("_POSITIV", "_NEGATIV") == "_NEGATIV" else 0

    def _ending(self) -> int:
        """`_EXPRESSION` and the sign behind a tree."""
        self._expect("_EXPRESSION")
        return self._modifiers()

    # networks ----------------------------------------------------------------------------------

    def body(self) -> NetworkList:
        view = "Ld" if self._expect("_LD_BODY", "_FBD_BODY") == "_LD_BODY" else "Fbd"
        self._count("_NETWORKS")
        networks: list[DrawnNetwork] = []
        while self._position < len(self._lines):
            networks.append(self._network(len(networks) + 1))
        return NetworkList(view, tuple(networks))

    def _network(self, number: int) -> DrawnNetwork:
        at = self._at
        self._expect("_NETWORK")
        label = title = ""
        if self._line not in ("_COMMENT", "_LD_ASSIGN", "_ASSIGN", "_NETWORK", ""):
            if self._line.startswith("_"):
                raise self._unseen()
            label = self._next().rstrip(":")
        if self._take("_COMMENT"):
            lines = []
            while self._line and not self._take("_END_COMMENT"):
                lines.append(self._next().strip("'"))
            title = "\n".join(lines).strip()
        items: list[NetworkNode] = []
        while self._line and self._line != "_NETWORK":
            items += self._item(number)
        return DrawnNetwork(number, title, label, False, tuple(items), (), at)

    def _item(self, number: int) -> list[NetworkNode]:
        if self._line == "_LD_ASSIGN":
            return self._rung(number)
        if self._line == "_ASSIGN":
            return [self._assignment()]
        raise self._unseen()

    def _rung(self, number: int) -> list[NetworkNode]:
        at = self._at
        self._expect("_LD_ASSIGN")
        power = self._tree()
        if self._ending():
            power = _negated(power, at)
        count = self._count("ENABLELIST")
        boxes = [self._assignment() for _ in range(count)]
        self._expect("ENABLELIST_END")
        targets = self._targets()
        if not boxes:
            return [Assignment(targets, power, at)]
        wire = NetworkWire(number, None, at)
        enabled = [_enabled(item, wire) for item in boxes]
        return [NetworkWire(number, power, at), *enabled, Assignment(targets, wire, at)]

    def _assignment(self) -> NetworkNode:
        at = self._at
        self._expect("_ASSIGN")
        value = self._tree()
        modifiers = self._ending()
        if modifiers:
            value = _negated(value, at)
        targets = self._targets()
        if isinstance(value, Box) and not modifiers:
            # The first output of a box is that of the assignment around it.
            first = [BoxOutput("", target, False) for target in targets]
            return changed(value, outputs=(*first, *value.outputs[1:]))
        return Assignment(targets, value, at)

    def _targets(self) -> tuple[NetworkOperand, ...]:
        return tuple(self._target() for _ in range(self._count("_OUTPUTS")))

    def _target(self) -> NetworkOperand:
        self._expect("_OUTPUT")
        modifiers = self._modifiers()
        if self._expect("_NO_SET", "_SET") == "_SET":
            modifiers |= Modifier.SET
        at = self._at
        return NetworkOperand(self._next(), modifiers, at, at)

    # trees -------------------------------------------------------------------------------------

    def _tree(self) -> NetworkNode:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._fault("this nests too deep", Code.TOO_DEEP)
        try:
            return self._node()
        finally:
            self._depth -= 1

    def _node(self) -> NetworkNode:
        at = self._at
        match self._line:
            case "_EMPTY":
                self._next()
                return Unconnected(at)
            case "_LD_CONTACT":
                self._next()
                text = self._next()
                return NetworkOperand(text, self._ending(), at, at)
            case "_LD_AND" | "_LD_OR":
                kind = self._next().removeprefix("_LD_")
                count = self._count("_LD_OPERATOR")
                inputs = [self._tree() for _ in range(count)]
                modifiers = self._ending() if self._is_inner_ending() else 0
                return _operator(kind, inputs, modifiers, at)
            case "_OPERAND":
                self._next()
                modifiers = self._ending()
                return NetworkOperand(self._next(), modifiers, at, at)
            case "_OPERATOR" | "_FUNCTION" | "_FUNCTIONBLOCK":
                return self._box()
        raise self._unseen()

    def _is_inner_ending(self) -> bool:
        """True if a series or parallel branch has a sign of its own: one more follows it."""
        following = [line for line, _ in self._lines[self._position : self._position + 3]]
        if len(following) < 3 or following[0] != "_EXPRESSION":
            return False
        return not following[2].startswith("ENABLELIST")

    def _box(self) -> NetworkNode:
        at = self._at
        kind = self._next()
        instance = self._next() if kind == "_FUNCTIONBLOCK" else ""
        count = self._count("_BOX_EXPR")
        is_enabled = self._take("_ENABLED")
        inputs = tuple(BoxInput("", "", self._tree(), 0) for _ in range(count))
        modifiers = self._ending()
        type = self._next()
        outputs: tuple[BoxOutput, ...] = (BoxOutput("", None, True),)
        if kind == "_FUNCTIONBLOCK":
            outputs += tuple(BoxOutput("", target, False) for target in self._targets())
            call = "FunctionBlock"
        else:
            call = call_of_operator(type) or "Function"
        enable = BoxInput("EN", "BOOL", Unconnected(at), 0) if is_enabled else None
        return Box(type, instance, call, inputs, outputs, enable, None, None, modifiers, at, at)


def _operator(kind: str, inputs: list[NetworkNode], modifiers: int, at: int) -> Box:
    pins = tuple(BoxInput("", "", item, 0) for item in inputs)
    outputs = (BoxOutput("", None, True),)
    return Box(kind, "", kind.title(), pins, outputs, None, None, None, modifiers, at, at)


def _negated(node: NetworkNode, at: int) -> Box:
    return _operator("NOT", [node], 0, at)


def _enabled(node: NetworkNode, power: NetworkWire) -> NetworkNode:
    """Return a box of an enable list, whose EN is the rung."""
    return changed(node, enable=BoxInput("EN", "BOOL", power, 0)) if isinstance(node, Box) else node
