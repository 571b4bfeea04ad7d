"""Random projects: functions, blocks that extend each other, methods, pointers and a program."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from random import Random
from typing import Any

from tests.rules.oracle import (
    COUNTERS,
    INTEGERS,
    WIDTHS,
    Action,
    Back,
    Cell,
    Env,
    Place,
    Routine,
    Value,
    converted,
    literal,
    wrap,
)
from tests.rules.random_expressions import letters_of
from tests.rules.random_parts import (
    DURATIONS,
    duration,
    property_access,
    property_text,
    structure,
    structures,
)
from tests.rules.random_programs import Scope
from tests.rules.random_shapes import shapes
from tests.rules.random_timers import timer

TYPES = (*INTEGERS, "BOOL", "BOOL", "REAL", "LREAL", "STRING(20)", "STRING(5)",
         "WSTRING(20)", "WSTRING(5)")  # fmt: skip
Variable = tuple[str, str, Any]
NOTHING = Action("", lambda env: None)


def start(rng: Random, type: str) -> Any:
    """An initial value of a type."""
    if type in WIDTHS:
        number = rng.choice([0, 1, -1, 5, 200, 1 << 15, (1 << 31) - 1, rng.getrandbits(64)])
        return wrap(number, type)
    if type == "BOOL":
        return rng.random() < 0.5
    if type in ("REAL", "LREAL"):
        return rng.choice([0.0, 1.0, -2.5, 0.5, rng.randint(-800, 800) / 8])
    return letters_of(rng, rng.randint(0, 5), type.startswith("W"))


@dataclass
class Block:
    """A function block: what an instance has, and what it does."""

    name: str
    base: "Block | None" = None
    inputs: list[Variable] = field(default_factory=list)
    outputs: list[Variable] = field(default_factory=list)
    locals: list[Variable] = field(default_factory=list)
    temporaries: list[Variable] = field(default_factory=list)
    body: Action = NOTHING
    property: Variable = ("", "", None)
    """The variable that its property `P` is."""
    methods: dict[str, Routine] = field(default_factory=dict)
    hidden: list[Variable] = field(default_factory=list)
    """VAR_INST of its methods."""
    retained: set[str] = field(default_factory=set)
    """Its RETAIN and PERSISTENT variables."""
    init: Routine | None = None
    """Its own FB_init."""
    statics: list[tuple[str, str, Cell]] = field(default_factory=list)

    def statics_of_bases(self) -> "list[tuple[str, str, Cell]]":
        return [one for block in self.chain()[:-1] for one in block.statics]

    def chain(self) -> "list[Block]":
        return [*(self.base.chain() if self.base else []), self]

    def all_of(self, kind: str) -> list[Variable]:
        return [one for block in self.chain() for one in getattr(block, kind)]

    def instance(self, is_retained: bool = False) -> Env:
        """The variables of an instance, before FB_init; `is_retained` is said of all of it."""
        names = {name for block in self.chain() for name in block.retained}
        env: Env = {
            name: Cell(value, is_retained or name in names)
            for kind in ("inputs", "outputs", "locals")
            for name, _, value in self.all_of(kind)
        }
        env["__hidden__"] = {n: Cell(value, is_retained) for n, _, value in self.all_of("hidden")}
        env["__block__"] = self
        return env

    def parameters(self) -> list[tuple[str, str]]:
        """What a declaration of an instance hands to FB_init."""
        parameters = [block.init.parameters for block in self.chain() if block.init is not None]
        return parameters[-1] if parameters else []

    def begin(self, env: Env, values: list[Any], types: list[str]) -> None:
        """Each FB_init, that of the base first."""
        names = (name for name, _ in self.parameters())
        arguments = dict(zip(names, zip(values, types, strict=True), strict=True))
        for block in self.chain():
            if block.init is not None:
                own = [arguments[name] for name, _ in block.init.parameters]
                block.init.called([value for value, _ in own], [type for _, type in own], env)

    def run(self, env: Env) -> None:
        for name, _, value in self.temporaries:
            env[name] = Cell(value)
        with suppress(Back):
            self.body.run(env)

    def method(self, name: str) -> Routine:
        for block in reversed(self.chain()):
            if name in block.methods:
                return block.methods[name]
        raise KeyError(name)


def _declared(variables: list[Variable]) -> str:
    return "\n".join(
        f"    {name} : {type} := {literal(value, type)};" for name, type, value in variables
    )


def _section(word: str, variables: list[Variable]) -> str:
    """What is declared between a word and END_VAR."""
    return f"{word}\n{_declared(variables)}\nEND_VAR\n" if variables else ""


class Project:
    """A whole random project; `text` is its source, `cycle` what one cycle does."""

    def __init__(self, rng: Random, exceptions: bool) -> None:
        self.rng = rng
        self.exceptions = exceptions
        self._number = 0
        self.parts: list[str] = []
        self.functions: list[Routine] = []
        self.main: Env = {}
        self.names: list[str] = []
        """Variables of MAIN that are compared."""
        self.statics: Env = {}
        """VAR_STAT variables, by their whole name."""
        self.clock = [0]
        """The time of the cycle, in nanoseconds."""
        self.again: list[Callable[[], None]] = []
        """What a reset does beside the cells of MAIN."""
        self.starts: list[Callable[[], None]] = []
        """FB_init of the instances, in order."""
        for _ in range(rng.randint(0, 2)):
            self._function()
        self.blocks: list[Block] = []
        if rng.random() < 0.8:
            self._block(None)
            if rng.random() < 0.7:
                self._block(self.blocks[0])
        self._program()
        self.text = "\n".join(self.parts)

    def name(self, prefix: str) -> str:
        self._number += 1
        return f"{prefix}{self._number}"

    def variables(self, most: int, types: tuple[str, ...] = TYPES) -> list[Variable]:
        chosen = [self.rng.choice(types) for _ in range(self.rng.randint(1, most))]
        return [(self.name("v"), type, start(self.rng, type)) for type in chosen]

    def scope(self, reach: Callable[[Env, str], Cell], variables: list[Variable]) -> Scope:
        """A scope that has at least a number and a real."""
        scope = Scope(self.rng, self.exceptions)
        scope.functions = list(self.functions)
        for name, type, _ in variables:
            scope.add(Place(name, type, partial(_reached, reach, name)))
        return scope

    def _needed(self) -> list[Variable]:
        """What every routine has of its own."""
        types = [self.rng.choice(INTEGERS), self.rng.choice(["REAL", "LREAL"]), "BOOL"]
        return [(self.name("v"), type, start(self.rng, type)) for type in types]

    def _counters(self, scope: Scope, reach: Callable[[Env, str], Cell]) -> list[Variable]:
        counters = []
        for _ in range(3):
            name, type = self.name("c"), self.rng.choice(COUNTERS)
            scope.counters.append(Place(name, type, partial(_reached, reach, name)))
            counters.append((name, type, 0))
        return counters

    # functions and methods -------------------------------------------------------------------

    def _routine(
        self, name: str, inherited: list[Variable], block: Block | None = None
    ) -> tuple[Routine, str]:
        """A function (no instance variables) or method: it and its inside as text."""
        rng = self.rng
        parameters = [
            (self.name("p"), rng.choice([*INTEGERS, "BOOL", "LREAL"]))
            for _ in range(rng.randint(1, 3))
        ]
        routine = Routine(name, parameters, rng.choice(INTEGERS))
        return routine, self._inside(routine, inherited, block)

    def _inside(
        self, routine: Routine, inherited: list[Variable], block: Block | None = None
    ) -> str:
        routine.locals = [*self._needed(), *self.variables(3)]
        scope = self.scope(_own, [*routine.locals, *((n, t, 0) for n, t in routine.parameters)])
        owner = routine.name if block is None else f"{block.name}.{routine.name}"
        further = self._static(owner, scope)
        if block is not None and self.rng.random() < 0.6:
            hidden = self.variables(3)
            block.hidden += hidden
            for name, type, _ in hidden:
                scope.add(Place(name, type, partial(_reached, _hidden, name)))
            further += _section("VAR_INST", hidden)
        counters = self._counters(scope, _own)
        routine.locals += counters
        for name, type, _ in inherited:
            scope.add(Place(name, type, partial(_reached, _of_instance, name)))
        body = scope.block(2)
        value = scope.integer(2)
        result, own = routine.result, routine.name

        def run(env: Env) -> None:
            body.run(env)
            env[own].v = converted(value.run(env), value.type, result)

        routine.run = run
        inputs = "\n".join(f"    {name} : {type};" for name, type in routine.parameters)
        return (
            f"VAR_INPUT\n{inputs}\nEND_VAR\n{_section('VAR', routine.locals)}{further}"
            f"{body.text}\n{routine.name} := {value.text};\n"
        )

    def _static(self, owner: str, scope: Scope, block: Block | None = None) -> str:
        """Variables that are there once, which join the scope: their section."""
        if self.rng.random() < 0.5:
            return ""
        word = self._remanence(0.3)
        variables = self.variables(2)
        for name, type, value in variables:
            cell = self.statics[f"{owner}.{name}"] = Cell(value, bool(word))
            scope.add(Place(name, type, partial(_itself, cell)))
            if block is not None:
                block.statics.append((name, type, cell))
        return _section(f"VAR_STAT{word}", variables)

    def _remanence(self, often: float = 0.4) -> str:
        """What is said of variables that outlive a reset, or nothing."""
        return self.rng.choice([" RETAIN", " PERSISTENT"]) if self.rng.random() < often else ""

    def _function(self) -> None:
        routine, inside = self._routine(self.name("F_"), [])
        self.parts.append(f"FUNCTION {routine.name} : {routine.result}\n{inside}END_FUNCTION")
        self.functions.append(routine)

    # blocks ----------------------------------------------------------------------------------

    def _block(self, base: Block | None) -> None:
        block = Block(self.name("FB_"), base)
        block.inputs, block.outputs = self.variables(2), self.variables(2)
        block.locals = [*self._needed(), *self.variables(3)]
        block.temporaries = self.variables(1)
        own = [*block.all_of("inputs"), *block.all_of("outputs"), *block.all_of("locals")]
        scope = self.scope(_own, [*own, *block.temporaries])
        further = self._static(block.name, scope, block)
        for name, type, cell in block.statics_of_bases():
            scope.add(Place(name, type, partial(_itself, cell)))
        block.locals += self._counters(scope, _own)
        words = {kind: self._remanence(0.25) for kind in ("inputs", "outputs", "locals")}
        block.retained = {
            n for kind, word in words.items() if word for n, _, _ in getattr(block, kind)
        }
        if base is not None:
            scope.calls.append(partial(_super_call, base))
        block.body = scope.block(2)
        methods = ""
        implements = ""
        if base is None:
            routine, inside = self._routine("M", own, block)
            block.methods["M"] = routine
            block.property = next(one for one in block.locals if one[1] in INTEGERS)
            methods = property_text("P", block.property[0], block.property[1])
            implements = " IMPLEMENTS I_Derived"
            parameters = "\n".join(f"    {name} : {type};" for name, type in routine.parameters)
            self.parts.append(
                f"INTERFACE I_Base\nMETHOD M : {routine.result}\nVAR_INPUT\n{parameters}\n"
                "END_VAR\nEND_METHOD\nEND_INTERFACE\nINTERFACE I_Derived EXTENDS I_Base\n"
                f"PROPERTY P : {block.property[1]}\nGET\nEND_GET\nSET\nEND_SET\n"
                "END_PROPERTY\nEND_INTERFACE"
            )
        else:
            before = base.method("M")
            routine = Routine("M", before.parameters, before.result)
            inside = self._inside(routine, own, block)
            block.methods["M"] = routine
            block.property = base.property
        methods += f"METHOD M : {routine.result}\n{inside}END_METHOD\n"
        if self.rng.random() < 0.6:
            methods += self._init(block, own)
        extends = f" EXTENDS {base.name}" if base is not None else ""
        self.parts.append(
            f"FUNCTION_BLOCK {block.name}{extends}{implements}\n"
            f"{_section('VAR_INPUT' + words['inputs'], block.inputs)}"
            f"{_section('VAR_OUTPUT' + words['outputs'], block.outputs)}"
            f"{_section('VAR' + words['locals'], block.locals)}{further}"
            f"{_section('VAR_TEMP', block.temporaries)}{block.body.text}\n{methods}"
            "END_FUNCTION_BLOCK"
        )
        self.blocks.append(block)

    def _init(self, block: Block, own: list[Variable]) -> str:
        """An FB_init of a block: it takes what that of the base takes, and more."""
        rng = self.rng
        before = block.base.parameters() if block.base is not None else []
        more = [
            (self.name("p"), rng.choice([*INTEGERS, "BOOL", "LREAL", "STRING(5)", "WSTRING(5)"]))
            for _ in range(rng.randint(0, 2))
        ]
        routine = Routine("FB_init", [*before, *more], "BOOL")
        routine.locals = self._needed()
        places = [*routine.locals, *((name, type, 0) for name, type in routine.parameters)]
        scope = self.scope(_own, places)
        for name, type, _ in own:
            scope.add(Place(name, type, partial(_reached, _of_instance, name)))
        routine.run = (body := scope.block(1)).run
        inputs = "\n".join(f"    {name} : {type};" for name, type in routine.parameters)
        block.init = routine
        return (
            "METHOD FB_init : BOOL\nVAR_INPUT\n    bInitRetains, bInCopyCode : BOOL;\n"
            f"{inputs}\nEND_VAR\n{_section('VAR', routine.locals)}{body.text}\nEND_METHOD\n"
        )

    def _begun(self, block: Block, env: Env, scope: Scope) -> str:
        """What a declaration hands to FB_init, which begins the instance."""
        values = [scope.argument(type, 1) for _, type in block.parameters()]

        def start() -> None:
            block.begin(env, [one.run(self.main) for one in values], [one.type for one in values])

        if not any(each.init for each in block.chain()):
            return ""
        self.starts.append(start)
        named = self.rng.random() < 0.5
        texts = [
            f"{name} := {one.text}" if named else one.text
            for (name, _), one in zip(block.parameters(), values, strict=True)
        ]
        return f"({', '.join(texts)})" if texts else ""

    # the program -----------------------------------------------------------------------------

    def _program(self) -> None:
        rng, env = self.rng, self.main
        variables = [*self._needed(), *self.variables(10)]
        scope = self.scope(_own, variables)
        scope.may_return = rng.random() < 0.2
        counters = self._counters(scope, _own)
        lines = _declared([*variables, *counters]).split("\n")
        remanence = {name: self._remanence(0.3) for name, _, _ in variables}
        opened = self.scope(_own, variables)
        for name, _, value in (*variables, *counters):
            env[name] = Cell(value, bool(remanence.get(name)))
        self.names = [name for name, _, _ in (*variables, *counters)]
        lines += [self._array(scope) for _ in range(rng.randint(0, 2))]
        for _ in range(rng.randint(0, 2)):
            type = self.name("ST_")
            fields = self.variables(4)
            self.parts.append(structure(type, fields))
            name = self.name("s")
            line, env[name] = structures(rng, name, type, fields, scope)
            lines.append(line)
            self.names.append(name)
        for type in DURATIONS:
            lines.append(duration(rng, self.name("t"), type, env, scope))
        opening: list[Action] = []
        for number, block in enumerate(self.blocks):
            for _ in range(rng.randint(1, 2)):
                name = self.name("f")
                remanence[name] = self._remanence(0.2)
                env[name] = block.instance(bool(remanence[name]))
                arguments = self._begun(block, env[name], opened)
                lines.append(f"    {name} : {block.name}{arguments};")
                self.names.append(name)
                scope.calls.append(partial(_call, name, block))
                scope.calls.append(partial(_method_call, name, name, block))
                for output, type, _ in block.all_of("outputs"):
                    scope.add(Place(f"{name}.{output}", type, partial(_member, name, output)))
                field, type, _ = block.property
                for path in (name, *self._interfaces(name, block, lines, opening, scope)):
                    scope.calls.append(partial(property_access, f"{path}.P", name, field, type))
                if number == len(self.blocks) - 1:
                    pointer = self.name("p")
                    lines.append(f"    {pointer} : POINTER TO {self.blocks[0].name};")
                    opening.append(Action(f"{pointer} := ADR({name});", lambda env: None))
                    scope.calls.append(partial(_method_call, f"{pointer}^", name, block))
        opening += self._pointers(scope, variables, lines)
        lines += [timer(rng, self.name("t"), scope, self.clock) for _ in range(rng.randint(0, 2))]
        further, types, actions = shapes(rng, self.name, scope)
        self.again += scope.again
        lines += further
        self.parts += types
        body = scope.block(3, 12)
        text = "\n".join([*(one.text for one in opening), body.text])
        self.parts.append(
            f"PROGRAM MAIN\n{_sections(lines, remanence)}{text}\n{actions}END_PROGRAM"
        )
        self._body = body

    def _interfaces(
        self, name: str, block: Block, lines: list[str], opening: list[Action], scope: Scope
    ) -> list[str]:
        """Interfaces of an instance, whose methods join the scope; those that have `P`."""
        variables = []
        for type in ("I_Base", "I_Derived"):
            variable = self.name("i")
            lines.append(f"    {variable} : {type};")
            opening.append(Action(f"{variable} := {name};", lambda env: None))
            scope.calls.append(partial(_method_call, variable, name, block))
            if type == "I_Derived":
                variables.append(variable)
        return variables

    def _array(self, scope: Scope) -> str:
        rng = self.rng
        name, type = (
            self.name("a"),
            rng.choice([*INTEGERS, "BOOL", "LREAL", "STRING(5)", "WSTRING(5)"]),
        )
        first = rng.randint(-3, 3)
        last = first + rng.randint(0, 4)
        values = [start(rng, type) for _ in range(last - first + 1)]
        self.main[name] = [Cell(value) for value in values]
        self.names.append(name)
        scope.arrays.append((name, type, first, last, lambda env: env[name]))
        shown = ", ".join(literal(value, type) for value in values)
        return f"    {name} : ARRAY [{first}..{last}] OF {type} := [{shown}];"

    def _pointers(self, scope: Scope, variables: list[Variable], lines: list[str]) -> list[Action]:
        """Pointers and references to variables, which are further names of them."""
        actions = []
        for target, type, _ in variables:
            if "STRING" in type or self.rng.random() < 0.7:
                continue
            name = self.name("p")
            if self.rng.random() < 0.5:
                lines.append(f"    {name} : POINTER TO {type};")
                actions.append(Action(f"{name} := ADR({target});", lambda env: None))
                text = f"{name}^"
            else:
                lines.append(f"    {name} : REFERENCE TO {type};")
                actions.append(Action(f"{name} REF= {target};", lambda env: None))
                text = name
            scope.add(Place(text, type, partial(_reached, _own, target)))
        return actions

    def begin(self) -> None:
        """Create the instances. Raise `Stop`."""
        for start in self.starts:
            start()

    def reset(self, origin: bool, again: bool) -> None:
        """Begin as declared. What is kept keeps its value unless `origin`; it has its start value
        until FB_init has run if all is made `again`. Raises `Stop`."""
        cells = [*_cells(self.main), *_cells(self.statics)]
        retained = [] if origin else [(cell, cell.v) for cell in cells if cell.is_retained]
        for cell in cells:
            if again or origin or not cell.is_retained:
                cell.v = cell.start
        for one in self.again:
            one()
        self.begin()
        for cell, value in retained:
            cell.v = value

    def cycle(self) -> None:
        """One cycle of MAIN. Raises `Stop`."""
        with suppress(Back):
            self._body.run(self.main)


def _cells(value: Any) -> Iterator[Cell]:
    """All that a variable is made of."""
    if isinstance(value, Cell):
        yield value
    elif isinstance(value, dict | list):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _cells(one)


def _sections(lines: list[str], remanence: dict[str, str]) -> str:
    """Declarations in their order, each below what is said of it."""
    text, said = "", None
    for line in lines:
        word = remanence.get(line.split()[0], "")
        if word != said:
            text += f"{'END_VAR' if text else ''}\nVAR{word}\n"
        said = word
        text += f"{line}\n"
    return f"{text}END_VAR\n"


def _reached(reach: Callable[[Env, str], Cell], name: str, env: Env) -> Cell:
    return reach(env, name)


def _itself(cell: Cell, env: Env) -> Cell:
    return cell


def _hidden(env: Env, name: str) -> Cell:
    cell: Cell = env["this"]["__hidden__"][name]
    return cell


def _own(env: Env, name: str) -> Cell:
    cell: Cell = env[name]
    return cell


def _of_instance(env: Env, name: str) -> Cell:
    cell: Cell = env["this"][name]
    return cell


def _member(instance: str, name: str, env: Env) -> Cell:
    cell: Cell = env[instance][name]
    return cell


def _super_call(base: Block, scope: Scope) -> Action:
    return Action("SUPER^();", base.run)


def _call(name: str, block: Block, scope: Scope) -> Action:
    """A call of an instance: some inputs, some outputs."""
    inputs: list[tuple[str, str, Value]] = [
        (key, type, scope.argument(type, 2))
        for key, type, _ in block.all_of("inputs")
        if scope.rng.random() < 0.6
    ]
    outputs = []
    for key, type, _ in block.all_of("outputs"):
        place = scope.any_place(type)
        if place is not None and "." not in place.text and scope.rng.random() < 0.5:
            outputs.append((key, place))
    arguments = [f"{key} := {value.text}" for key, _, value in inputs]
    arguments += [f"{key} => {place.text}" for key, place in outputs]

    def run(env: Env) -> None:
        instance = env[name]
        for key, type, value in inputs:
            instance[key].v = converted(value.run(env), value.type, type)
        block.run(instance)
        for key, place in outputs:
            place.cell(env).v = instance[key].v

    return Action(f"{name}({', '.join(arguments)});", run)


def _method_call(text: str, name: str, block: Block, scope: Scope) -> Action:
    """A method of an instance; its result goes into a variable."""
    routine = block.method("M")
    values = [scope.argument(type, 2) for _, type in routine.parameters]
    place = scope.any_place(*INTEGERS)
    assert place is not None

    def run(env: Env) -> None:
        instance = env[name]
        result = routine.called(
            [value.run(env) for value in values], [value.type for value in values], instance
        )
        place.cell(env).v = converted(result, routine.result, place.type)

    shown = ", ".join(value.text for value in values)
    return Action(f"{place.text} := {text}.M({shown});", run)
