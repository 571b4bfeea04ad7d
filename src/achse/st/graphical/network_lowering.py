"""Networks lowered to statements: power flow, boxes with EN and ENO, wires, parallel branches.

Power is a Boolean expression; None is TRUE, the left rail. Inputs of a box are evaluated before
it, in the order of its pins and depth first; what has been read before a box is called keeps the
value that it had then.

Source: IEC 61131-3 (2013) §8.2, §8.3; bodies of public TwinCAT 3 projects.
"""

import re
from collections.abc import Callable, Iterator, Sequence

from achse.st.graphical.body import BodyScope, GraphicalBody, Refused
from achse.st.graphical.boxes import (
    COMPARISONS,
    EDGES,
    UNFINISHED,
    BoxWriter,
    both,
    memory_of,
    operator_of,
    sign_of,
)
from achse.st.graphical.instructions import InstructionList, needs_accumulator
from achse.st.graphical.networks import (
    Assignment,
    Box,
    BoxInput,
    DrawnNetwork,
    Modifier,
    NetworkList,
    NetworkNode,
    NetworkOperand,
    NetworkWire,
    Parallel,
    Unconnected,
    read_networks,
)
from achse.st.graphical.writer import implicit_block
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import changed
from achse.st.syntax.tree import (
    Binary,
    Expression,
    Label,
    Literal,
    Name,
    Statements,
    Unary,
    VarBlock,
)

_EDGE = re.compile(r'<v n="Flags">(?:1[6-9]|[2-5]\d|6[0-3])</v>')


def memories_of_networks(body: GraphicalBody) -> tuple[VarBlock, ...]:
    """Return the memories of the edges in a body. What cannot be read has none."""
    text = body.text
    if not body.owner.keeps_memory or not _EDGE.search(text):
        return ()
    try:
        networks = read_networks(text).networks
    except Unexpected:
        return ()
    nodes = (node for network in networks for item in network.items for node in _within(item))
    names = [memory_of(body, key) for node in nodes for key in _edges_of(node)]
    return (implicit_block((name, "BOOL") for name in dict.fromkeys(names)),) if names else ()


def lowered_networks(
    body: GraphicalBody, scope: BodyScope, read: Callable[[str], NetworkList] = read_networks
) -> Statements:
    """Return the statements of a body that `read` reads. Raises `Refused` and `Unexpected`."""
    try:
        networks = read(body.text)
    except Unexpected as fault:
        raise Refused(body.name_place(fault.at, "the body"), fault.message, fault.code) from None
    return _Lowering(body, scope, networks).statements()


def _edges_of(node: NetworkNode) -> Iterator[str]:
    """Return the keys of the memories that a node itself needs."""
    if isinstance(node, NetworkOperand | Box) and node.modifiers & EDGES:
        yield str(node.id)
    if isinstance(node, Box):
        inputs = (node.enable, *node.inputs) if node.enable else node.inputs
        for number, pin in enumerate(inputs):
            if pin is not None and pin.modifiers & EDGES:
                yield f"{node.id}_{number}"


def _inner(node: NetworkNode) -> Iterator[NetworkNode]:
    match node:
        case Box():
            if node.enable is not None:
                yield node.enable.node
            for pin in node.inputs:
                yield pin.node
        case Assignment(value=inner) | NetworkWire(input=inner):
            if inner is not None:
                yield inner
        case Parallel():
            if node.input is not None:
                yield node.input
            yield from node.branches


def _within(node: NetworkNode) -> Iterator[NetworkNode]:
    yield node
    for inner in _inner(node):
        yield from _within(inner)


def _is_executed(node: NetworkNode) -> bool:
    """Return True if a branch has a box in it, other than those that are contacts."""
    return any(
        isinstance(inner, Box) and (inner.is_call or inner.enable is not None)
        for inner in _within(node)
    )


def _uses_power(node: NetworkNode) -> bool:
    """Return True if it makes a difference where the power in front of a node goes to."""
    return isinstance(node, Unconnected | Parallel) or any(
        isinstance(inner, Unconnected | Parallel | Assignment)
        or (isinstance(inner, Box) and (inner.is_call or inner.enable is not None))
        for inner in _within(node)
    )


class _Lowering(BoxWriter):
    """Writes the statements of one list of networks."""

    def __init__(self, body: GraphicalBody, scope: BodyScope, networks: NetworkList) -> None:
        super().__init__(body, scope)
        self._networks = networks.networks
        self._is_ladder = networks.view.lower() == "ld"
        self._carrying = {
            one.target.lower() for one in self._networks if one.target and needs_accumulator(one)
        }
        self._wires: set[int] = set()
        self._number = 0

    def statements(self) -> Statements:
        self._check_labels()
        for network in self._networks:
            if not network.is_disabled:
                self._network(network)
        return tuple(self.out)

    def _check_labels(self) -> None:
        taken: dict[str, int] = {}
        for network in self._networks:
            key = network.target.lower()
            if not key or network.is_disabled:
                continue
            if key in taken:
                self.location = f"network {network.number}"
                message = f"label {network.label} is at network {taken[key]} already"
                raise self.fault(network.at, message)
            taken[key] = network.number

    def _network(self, network: DrawnNetwork) -> None:
        self._number = network.number
        self._wires.clear()
        self.location = f"network {network.number}"
        if network.target:
            self.out.append(Label(network.target, self.at(network.at)))
        if network.lines:
            following = self._networks[network.number : network.number + 1]
            leads_on = any(one.target.lower() in self._carrying for one in following)
            InstructionList(self, network, self._carrying, leads_on=leads_on).write()
        for number, item in enumerate(network.items, 1):
            self.location = f"network {network.number}, rung {number}"
            self._item(item)

    # rungs -------------------------------------------------------------------------------------

    def _item(self, node: NetworkNode) -> None:
        match node:
            case Assignment():
                self._assignment(node, None)
            case NetworkWire(input=None):
                pass
            case NetworkWire():
                self._define(node)
            case Box():
                self._box(node, None, is_read=False)
            case NetworkOperand() | Unconnected():
                pass
            case Parallel():
                self._parallel(node, None)

    def _assignment(self, node: Assignment, power: Expression | None) -> Expression | None:
        """Write an assignment; return its value for the node around it."""
        at = self.at(node.at)
        if node.value is None:
            return power
        is_open = isinstance(node.value, Unconnected)
        leaves = Modifier.JUMP | Modifier.RETURN
        if is_open and not any(target.modifiers & leaves for target in node.targets):
            return power
        if isinstance(node.value, Box) and self._is_gated(node.value):
            return self._gated(node, node.value, power)
        value = self._flow(node.value, power)
        if value is None:
            value = Literal("boolean", "TRUE", at)
        if len(node.targets) > 1 and not isinstance(value, Literal):
            value = self.let(self.hidden("value"), value, at)
        for target in node.targets:
            self.store(target, value)
        return value

    def _is_gated(self, box: Box) -> bool:
        """Return True for an operator with EN whose result is assigned, if EN is TRUE."""
        shows_eno = box.enable_output is not None and box.enable_output.is_read
        return box.enable is not None and not box.is_call and not shows_eno

    def _gated(self, node: Assignment, box: Box, power: Expression | None) -> Expression | None:
        """Write an operator with EN and what its result is assigned to."""
        at = self.at(node.at, f"box {box.type}")
        enable = self._enable(box, power, at)
        value = self.modified(
            self.operator(box, self._inputs(box, None), at), box.modifiers, str(box.id), at
        )

        def store() -> None:
            self.assign_outputs(box, value)
            for target in node.targets:
                self.store(target, value)

        self.when(enable, store, at)
        return enable

    def _define(self, node: NetworkWire) -> None:
        """Write the value of a wire into its variable."""
        at = self.at(node.at)
        assert node.input is not None
        value = self._flow(node.input, None)
        if value is None:
            value = Literal("boolean", "TRUE", at)
        self.let(self._wire(node.number), value, at)
        self._wires.add(node.number)

    def _wire(self, number: int) -> str:
        return f"__w{self._number}_{number}"

    # values ------------------------------------------------------------------------------------

    def _value(self, node: NetworkNode) -> Expression:
        """Return the value of a node at the left rail."""
        power = self._flow(node, None)
        return Literal("boolean", "TRUE", self.at(node.at)) if power is None else power

    def _flow(self, node: NetworkNode, power: Expression | None) -> Expression | None:
        """Return the value of a node that power arrives at; None is TRUE."""
        at = self.at(node.at)
        match node:
            case Unconnected():
                return power
            case NetworkOperand():
                return both(power, self._operand(node), at)
            case NetworkWire():
                if node.input is not None or node.number not in self._wires:
                    raise Refused(
                        at,
                        f"wire {node.number} is read before it is defined",
                        Code.INCOMPLETE_DRAWING,
                    )
                return both(power, Name(self._wire(node.number), at), at)
            case Parallel():
                return self._parallel(node, power)
            case Assignment():
                return self._assignment(node, power)
            case Box():
                return self._box(node, power, is_read=True)

    def _operand(self, node: NetworkOperand) -> Expression:
        at = self.at(node.at)
        if node.text in ("", UNFINISHED):
            raise Refused(
                at,
                "an operand is not filled in: expected an expression, got '???'",
                Code.INCOMPLETE_DRAWING,
            )
        value = self.expression(node.text, at)
        return self.modified(value, node.modifiers, str(node.id), at)

    # boxes -------------------------------------------------------------------------------------

    def _box(self, node: Box, power: Expression | None, *, is_read: bool) -> Expression | None:
        name = f"{node.type} {node.instance}".rstrip()
        at = self.at(node.at, f"box {name}")
        if node.enable is not None:
            if not self._declares_enable(node):
                return self._enabled(node, power, at, is_read=is_read)
            outputs = (node.enable_output,) if node.enable_output else ()
            node = changed(
                node,
                inputs=(node.enable, *node.inputs),
                outputs=(*outputs, *node.outputs),
                enable=None,
                enable_output=None,
            )
        if not node.is_call:
            return self._without_enable(node, power, at)
        inputs = self._inputs(node, power)
        value = self.executed(node, inputs, at, is_read=is_read)
        return None if value is None else self.modified(value, node.modifiers, str(node.id), at)

    def _declares_enable(self, node: Box) -> bool:
        """Return True if EN of a box is an input that its block declares itself."""
        if node.call != "FunctionBlock" or any(pin.name.upper() == "EN" for pin in node.inputs):
            return False
        pins = self.scope.pins(node.type)
        return pins is not None and any(name.upper() == "EN" for name in pins.inputs)

    def _without_enable(self, node: Box, power: Expression | None, at: int) -> Expression | None:
        """Return an operator that is always executed."""
        kind = operator_of(node)
        value: Expression | None
        if kind == "and" and self._is_ladder:
            value = self._series(node, power)
        elif kind == "or" and self._is_ladder and _uses_power(node):
            value = self._alternatives(node, power, at)
        else:
            value = self.operator(node, self._inputs(node, None), at)
            self.assign_outputs(node, value)
            value = self.modified(value, node.modifiers, str(node.id), at)
            return value if power is None else both(power, value, at)
        if value is None:
            value = Literal("boolean", "TRUE", at)
        self.assign_outputs(node, value)
        return self.modified(value, node.modifiers, str(node.id), at)

    def _series(self, node: Box, power: Expression | None) -> Expression | None:
        """AND in a ladder: each input gets the power that is left behind the one before it."""
        so_far = power
        for number, pin in enumerate(node.inputs):
            at = self.at(pin.node.at)
            if not _uses_power(pin.node):
                start = len(self.out)
                value = self._pin(node, pin, number, None)
                if so_far is not None and len(self.out) > start:
                    so_far = self.frozen(so_far, start, at)
                so_far = both(so_far, value, at)
                continue
            if so_far is not None:
                so_far = self.simple(so_far, at)
            flow = self._flow(pin.node, so_far)
            if pin.modifiers and flow is not None:
                flow = self.modified(flow, pin.modifiers, f"{node.id}_{number}", at)
            so_far = flow
        return so_far

    def _alternatives(self, node: Box, power: Expression | None, at: int) -> Expression | None:
        """OR in a ladder: each input gets the power in front of the branch."""
        if power is not None:
            power = self.simple(power, at)
        nodes = [pin.node for pin in node.inputs]
        if any(pin.modifiers for pin in node.inputs):
            raise Refused(
                at, "a negated input of a branch is not supported", Code.UNSUPPORTED_DRAWING
            )
        return self._any(nodes, power, at)

    def _any(
        self, nodes: Sequence[NetworkNode], power: Expression | None, at: int
    ) -> Expression | None:
        """Evaluate branches in order; return the OR of their results."""
        result: Expression | None = None
        is_true = False
        for node in nodes:
            start = len(self.out)
            value = self._flow(node, power)
            if result is not None and len(self.out) > start:
                result = self.frozen(result, start, at)
            if value is None:
                is_true = True
            elif result is None:
                result = value
            else:
                result = Binary("OR", result, value, at)
        return None if is_true else result

    def _pin(self, node: Box, pin: BoxInput, number: int, power: Expression | None) -> Expression:
        value = self._flow(pin.node, power)
        at = self.at(pin.node.at)
        if value is None:
            value = Literal("boolean", "TRUE", at)
        return self.modified(value, pin.modifiers, f"{node.id}_{number}", at)

    def _inputs(self, node: Box, power: Expression | None) -> list[tuple[BoxInput, Expression]]:
        """Evaluate the inputs in order; those of pins that are not wired are left out."""
        values: list[tuple[BoxInput, Expression]] = []
        powered = _powered(node) if power is not None else -1
        offset = 0 if node.enable is None else 1
        for number, pin in enumerate(node.inputs):
            if isinstance(pin.node, NetworkOperand) and not pin.node.text:
                continue
            start = len(self.out)
            value = self._pin(node, pin, number + offset, power if number == powered else None)
            if len(self.out) > start:
                values = self._stable_values(node, values, start)
            values.append((pin, value))
        return values

    def _stable_values(
        self, node: Box, inputs: list[tuple[BoxInput, Expression]], index: int
    ) -> list[tuple[BoxInput, Expression]]:
        """Keep what was read before a box among the inputs was called. A variable that is an
        argument stays itself: it may be a VAR_IN_OUT."""
        frozen = []
        for pin, value in inputs:
            if not (
                node.is_call and isinstance(pin.node, NetworkOperand) and not pin.node.modifiers
            ):
                value = self.frozen(value, index, self.at(pin.node.at))
            frozen.append((pin, value))
        return frozen

    def _enabled(
        self, node: Box, power: Expression | None, at: int, *, is_read: bool
    ) -> Expression | None:
        """Return a box with EN: executed if EN is TRUE; ENO repeats EN."""
        enable = self._enable(node, power, at)
        inputs = self._inputs(node, None)
        reads_result = is_read and not (node.enable_output and node.enable_output.is_read)
        if node.is_call or not reads_result:
            result: Expression | None = None

            def execute() -> None:
                nonlocal result
                result = self.executed(node, inputs, at, is_read=reads_result)

            self.when(enable, execute, at)
        else:
            result = self.operator(node, inputs, at)
            value = result
            self.when(enable, lambda: self.assign_outputs(node, value), at)
            if enable is not None and sign_of(node) not in COMPARISONS:
                raise Refused(
                    at,
                    f"the result of {node.type} with EN that goes on is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )
            result = both(enable, result, at)
        if node.enable_output is not None and node.enable_output.target is not None:
            eno = enable or Literal("boolean", "TRUE", at)
            self.store(node.enable_output.target, eno)
        if reads_result:
            return (
                None if result is None else self.modified(result, node.modifiers, str(node.id), at)
            )
        if node.modifiers and enable is not None:
            return self.modified(enable, node.modifiers, str(node.id), at)
        return enable

    def _enable(self, node: Box, power: Expression | None, at: int) -> Expression | None:
        """Return the value at EN, kept in a variable; None is TRUE."""
        assert node.enable is not None
        enable = self._flow(node.enable.node, power)
        if node.enable.modifiers:
            enable = self.modified(
                Literal("boolean", "TRUE", at) if enable is None else enable,
                node.enable.modifiers,
                f"{node.id}_0",
                at,
            )
        return None if enable is None else self.let(self.hidden("en"), enable, at)

    # parallel branches -------------------------------------------------------------------------

    def _parallel(self, node: Parallel, power: Expression | None) -> Expression | None:
        at = self.at(node.at)
        entered = power if node.input is None else self._flow(node.input, power)
        if entered is not None:
            entered = self.simple(entered, at)
        executed = [branch for branch in node.branches if _is_executed(branch)]
        bridges = [branch for branch in node.branches if not _is_executed(branch)]
        if node.is_sequential or not executed or not bridges:
            return self._any(node.branches, entered, at)
        bridged = self._any(bridges, entered, at)
        if bridged is None:
            return entered
        result = self.let(self.hidden("bridge"), bridged, at)

        def run() -> None:
            joined = self._any(executed, entered, at)
            value = Literal("boolean", "TRUE", at) if joined is None else joined
            self.assign(result, value, at)

        self.when(Unary("NOT", result, at), run, at)
        return result


def _powered(node: Box) -> int:
    """Return the input of a call that the rung feeds: the first Boolean one."""
    types = [pin.type.upper() for pin in node.inputs]
    return types.index("BOOL") if "BOOL" in types else 0
