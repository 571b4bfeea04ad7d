"""Random declarations that change: what is declared, its text, and what its values are.

A model of its own: values are Python lists and dicts, nothing in it knows of bytes.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from random import Random
from typing import Any

from tests.rules.oracle import literal, start_of, wrap

Path = tuple[object, ...]
SCALARS = ("INT", "INT", "UINT", "DINT", "LINT", "BOOL", "LREAL", "STRING(5)", "WSTRING(5)")
WORDS = ("", "", "", " PERSISTENT", " RETAIN")
UNITS = ("MAIN", "GVL_A", "GVL_B")


@dataclass
class Scalar:
    """An elementary type, or a pointer to one."""

    name: str

    def text(self) -> str:
        return self.name

    def layout(self) -> Any:
        return self.name


@dataclass
class ArrayOf:
    """An array with one dimension."""

    first: int
    last: int
    element: "Type"

    def text(self) -> str:
        return f"ARRAY [{self.first}..{self.last}] OF {self.element.text()}"

    def layout(self) -> Any:
        return (self.first, self.last, self.element.layout())


@dataclass
class Field:
    """A member, or a variable of a unit."""

    name: str
    type: "Type"
    word: str = ""
    start: Any = None
    renewed: bool = False
    """Attribute `init_on_onlchange`."""

    def text(self) -> str:
        start = "" if self.start is None else f" := {literal(self.start, self.type.text())}"
        said = "{attribute 'init_on_onlchange'} " if self.renewed else ""
        arguments = (
            f"('{self.name}')" if isinstance(self.type, Record) and self.type.is_block else ""
        )
        return f"VAR{self.word} {said}{self.name} : {self.type.text()}{arguments}{start}; END_VAR"

    def begun(self) -> Any:
        """The value at a start."""
        if self.start is not None:
            return self.start
        value = begun(self.type)
        if isinstance(self.type, Record) and self.type.is_block:
            value["sOwn"] = self.name
        return value


@dataclass
class Record:
    """A structure, or a function block. Every block extends FB_Root, which logs its life."""

    name: str
    is_block: bool
    own: list[Field]
    base: "Record | None" = None

    def text(self) -> str:
        return self.name

    def fields(self) -> list[Field]:
        return [*(self.base.fields() if self.base else []), *self.own]

    def layout(self) -> Any:
        below = None if self.base is None else self.base.layout()
        own = [(one.name, one.word, one.type.layout()) for one in self.own]
        return (self.name, self.is_block, below, own)

    def declaration(self, step: int) -> str:
        if not self.is_block:
            members = "\n".join(
                one.text().removeprefix("VAR ").removesuffix(" END_VAR") for one in self.own
            )
            return f"TYPE {self.name} : STRUCT\n{members}\nEND_STRUCT END_TYPE"
        lines = "\n".join(one.text() for one in self.own)
        counted = "\n".join(f"{n} := {n} + {step};" for n in self.counters())
        base = self.base.name if self.base is not None else "FB_Root"
        return f"FUNCTION_BLOCK {self.name} EXTENDS {base}\n{lines}\n{counted}\nEND_FUNCTION_BLOCK"

    def counters(self) -> list[str]:
        """What the body of a block counts."""
        return [one.name for one in self.own if one.type == Scalar("INT")]


Type = Scalar | ArrayOf | Record

ROOT = """FUNCTION_BLOCK FB_Root
VAR sOwn : STRING(5); END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; sName : STRING(5); END_VAR
sOwn := sName;
GVL_LOG.sLog := CONCAT(CONCAT(GVL_LOG.sLog, SEL(bInCopyCode, 'j', 'i')), CONCAT(sOwn, ' '));
END_METHOD
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
GVL_LOG.sLog := CONCAT(CONCAT(GVL_LOG.sLog, SEL(bInCopyCode, 'f', 'e')), CONCAT(sOwn, ' '));
END_METHOD
METHOD FB_reinit : BOOL
GVL_LOG.sLog := CONCAT(CONCAT(GVL_LOG.sLog, 'r'), CONCAT(sOwn, ' '));
END_METHOD
END_FUNCTION_BLOCK
VAR_GLOBAL sLog : STRING(255); END_VAR
"""


def begun(type: Type) -> Any:
    """What a variable of a type starts with."""
    if isinstance(type, Scalar):
        return 0 if type.name.startswith("POINTER") else start_of(type.name)
    if isinstance(type, ArrayOf):
        return [begun(type.element) for _ in range(type.first, type.last + 1)]
    values = {one.name: one.begun() for one in type.fields()}
    return {"sOwn": "", **values} if type.is_block else values


def poured(old: Type, value: Any, new: Type, fresh: Any) -> Any:
    """What is left of a value when its type changes; `fresh` is what it starts with."""
    if isinstance(old, Scalar) or isinstance(new, Scalar):
        return value if old == new else fresh
    if isinstance(old, ArrayOf) and isinstance(new, ArrayOf):
        elements = list(fresh)
        for index in range(max(old.first, new.first), min(old.last, new.last) + 1):
            number = index - new.first
            was = value[index - old.first]
            elements[number] = poured(old.element, was, new.element, elements[number])
        return elements
    if not (isinstance(old, Record) and isinstance(new, Record)) or old.is_block != new.is_block:
        return fresh
    before = {one.name: one.type for one in old.fields()}
    members = dict(fresh)
    if new.is_block:
        members["sOwn"] = value["sOwn"]
    for one in new.fields():
        if one.name in before:
            was, begins = value[one.name], members[one.name]
            members[one.name] = poured(before[one.name], was, one.type, begins)
    return members


@dataclass
class State:
    """What is declared and what its values are."""

    records: list[Record] = field(default_factory=list)
    units: dict[str, list[Field]] = field(default_factory=lambda: {name: [] for name in UNITS})
    values: dict[str, Any] = field(default_factory=dict)
    leads: dict[str, tuple[str, Path]] = field(default_factory=dict)
    """Where pointers lead, by the whole name of a variable: variable and path in it."""
    step: int = 1
    number: int = 0

    def name(self, prefix: str) -> str:
        self.number += 1
        return f"{prefix}{self.number}"

    def variables(self) -> Iterator[tuple[str, Field]]:
        """All variables of units, by whole name in the order of their life."""
        for unit in UNITS:
            for one in self.units[unit]:
                yield f"{unit}.{one.name}", one

    def sources(self) -> dict[str, str]:
        """The text, by the name that its variable list has."""
        texts = {"GVL_LOG": ROOT + "\n".join(one.declaration(self.step) for one in self.records)}
        for unit in UNITS[1:]:
            lines = [one.text().replace("VAR", "VAR_GLOBAL", 1) for one in self.units[unit]]
            if lines:
                texts[unit] = "\n".join(lines)
        body = []
        for name, one in self.variables():
            if one.type == Scalar("INT"):
                body.append(f"{name} := {name} + {self.step};")
            elif isinstance(one.type, Record) and one.type.is_block:
                body.append(f"{name}();")
        lines = [one.text() for one in self.units["MAIN"]]
        lines += [text.removeprefix("MAIN.") for text in body]
        texts["GVL_LOG"] += "\nPROGRAM MAIN\n" + "\n".join(lines) + "\nEND_PROGRAM"
        return texts

    def text(self) -> str:
        return "\n".join(self.sources().values())

    def declared(self) -> str:
        """What is declared, without what bodies do."""
        step, self.step = self.step, 0
        text, self.step = str(self.sources()), step
        return text

    def start(self) -> None:
        """All variables as declared."""
        self.values = {name: one.begun() for name, one in self.variables()}
        self.leads = {}

    def cycle(self) -> None:
        """What one cycle does."""
        for name, one in self.variables():
            if one.type == Scalar("INT"):
                self.values[name] = wrap(self.values[name] + self.step, "INT")
            elif isinstance(one.type, Record) and one.type.is_block:
                value = self.values[name]
                for counter in one.type.counters():
                    value[counter] = wrap(value[counter] + self.step, "INT")

    def values_by_path(self) -> dict[str, tuple[Any, Any]]:
        """Layout and value of all that outlives a restart, by path."""
        values = {}
        for name, one in self.variables():
            for path, type, value in _values_by_path(name, one, self.values[name]):
                values[path] = (type.layout(), value)
        return values

    def inherit(self, before: "State") -> None:
        """Begin, with what the state before has to keep."""
        old_values, layouts = before.values_by_path(), before.layouts()
        self.start()
        for name, one in self.variables():
            self.values[name] = _inherited(name, one, self.values[name], old_values)
            target, path = before.leads.get(name, ("", ()))
            is_alike = old_values.get(name, ("",))[0] == one.type.layout()
            stays = target in layouts and layouts[target] == self.layouts().get(target)
            if one.word and is_alike and stays:
                self.leads[name] = (target, path)

    def change(self, before: "State") -> list[str]:
        """Go on from a state with other declarations. Gives what life does, in order."""
        old = dict(before.variables())
        self.start()
        if before.declared() == self.declared():
            self.values, self.leads = deepcopy(before.values), dict(before.leads)
            return []
        for name, one in self.variables():
            if name in old and not one.renewed:
                was = before.values[name]
                self.values[name] = poured(old[name].type, was, one.type, self.values[name])
        new = dict(self.variables())
        for name, (target, path) in before.leads.items():
            if name not in new or new[name].type != old[name].type or new[name].renewed:
                continue
            if target in new and survives(old[target].type, new[target].type, path):
                self.leads[name] = (target, path)
        again = {
            name for name in old.keys() & new.keys()
            if old[name].type.layout() != new[name].type.layout() and not new[name].renewed
        }  # fmt: skip
        renewed = {name for name in old.keys() & new.keys() if new[name].renewed}
        return [
            *_life(UNITS[::-1], old, again | renewed, "e", "f", old.keys() - new.keys()),
            *_life(UNITS, new, again, "i", "j", new.keys() - old.keys()),
            *_life(UNITS, new, again, "r", "", set()),
        ]

    def layouts(self) -> dict[str, Any]:
        return {name: one.type.layout() for name, one in self.variables()}


def _life(
    units: Sequence[str],
    variables: dict[str, Field],
    again: Collection[str],
    word: str,
    other: str,
    others: Collection[str],
) -> Iterator[str]:
    """Unit by unit: `word` of what ends and begins, then `other` of what comes or goes."""
    for unit in units:
        for said, names in ((word, again), (other, others)):
            for name, one in variables.items():
                is_block = isinstance(one.type, Record) and one.type.is_block
                if is_block and name in names and name.startswith(f"{unit}."):
                    yield said + one.name


def survives(old: Type, new: Type, path: Path) -> bool:
    """Whether an elementary part is still there."""
    if not path:
        return isinstance(old, Scalar) and old == new
    if isinstance(old, ArrayOf) and isinstance(new, ArrayOf):
        index = path[0]
        assert isinstance(index, int)
        return new.first <= index <= new.last and survives(old.element, new.element, path[1:])
    if not (isinstance(old, Record) and isinstance(new, Record)) or old.is_block != new.is_block:
        return False
    was, now = ({one.name: one.type for one in of.fields()} for of in (old, new))
    name = str(path[0])
    return name in now and survives(was[name], now[name], path[1:])


def _values_by_path(name: str, one: Field, value: Any) -> Iterator[tuple[str, Type, Any]]:
    if one.word:
        yield name, one.type, value
    elif isinstance(one.type, Record):
        for inner in one.type.fields():
            yield from _values_by_path(f"{name}.{inner.name}", inner, value[inner.name])


def _inherited(name: str, one: Field, value: Any, old_values: dict[str, tuple[Any, Any]]) -> Any:
    if one.word:
        layout, was = old_values.get(name, (None, None))
        return was if layout == one.type.layout() else value
    if isinstance(one.type, Record):
        for inner in one.type.fields():
            path = f"{name}.{inner.name}"
            value[inner.name] = _inherited(path, inner, value[inner.name], old_values)
    return value


def scalars(type: Type, value: Any, path: Path = ()) -> Iterator[tuple[Path, str, Any]]:
    """Path, type and value of each elementary part."""
    if isinstance(type, Scalar):
        yield path, type.name, value
    elif isinstance(type, ArrayOf):
        for number, item in enumerate(value):
            yield from scalars(type.element, item, (*path, type.first + number))
    else:
        for one in type.fields():
            yield from scalars(one.type, value[one.name], (*path, one.name))


# edits ------------------------------------------------------------------------------------------


def drawn_type(rng: Random, state: State, depth: int = 1) -> Type:
    kind = rng.random()
    if kind < 0.6 or not depth:
        return Scalar(rng.choice(SCALARS))
    if kind < 0.75:
        first = rng.randint(-2, 2)
        inner = drawn_type(rng, state, 0)
        structures = [one for one in state.records if not one.is_block]
        element = rng.choice(structures) if structures and rng.random() < 0.4 else inner
        return ArrayOf(first, first + rng.randint(0, 4), element)
    return rng.choice(state.records) if state.records else Scalar("LREAL")


def drawn_field(rng: Random, state: State, *, member: Record | None = None) -> Field:
    """A variable, or a member of a record."""
    type = drawn_type(rng, state, 0 if member is not None else 1)
    if member is not None and rng.random() < 0.3:
        type = ArrayOf(first := rng.randint(-2, 2), first + rng.randint(0, 3), type)
    word = "" if member is not None and not member.is_block else rng.choice(WORDS)
    start = None
    if type in (Scalar("INT"), Scalar("LINT")) and rng.random() < 0.5:
        start = rng.randint(-99, 99)
    renewed = member is None and isinstance(type, Scalar) and rng.random() < 0.1
    return Field(state.name("v"), type, word, start, renewed)


def edits(rng: Random, state: State) -> list[Callable[[], None]]:
    """What somebody may do to declarations."""

    def add_record() -> None:
        is_block = rng.random() < 0.5
        record = Record(state.name("FB_" if is_block else "ST_"), is_block, [])
        record.own = [drawn_field(rng, state, member=record) for _ in range(rng.randint(1, 3))]
        state.records.append(record)
        state.units[rng.choice(UNITS)].append(Field(state.name("v"), record))

    def add() -> None:
        fields = state.units[rng.choice(UNITS)]
        fields.insert(rng.randint(0, len(fields)), drawn_field(rng, state))

    def add_pointer() -> None:
        fields = state.units[rng.choice(UNITS)]
        target = rng.choice(["INT", "LINT", "LREAL"])
        one = Field(state.name("p"), Scalar(f"POINTER TO {target}"), rng.choice(WORDS))
        fields.insert(rng.randint(0, len(fields)), one)

    def of_lists() -> tuple[list[Field], Record | None]:
        lists = [(fields, None) for fields in state.units.values() if fields]
        more: list[tuple[list[Field], Record | None]] = [(one.own, one) for one in state.records]
        return rng.choice([*lists, *more] or [([], None)])

    def remove() -> None:
        fields, record = of_lists()
        if len(fields) > (record is not None):
            fields.pop(rng.randrange(len(fields)))

    def rename() -> None:
        fields, _ = of_lists()
        if fields:
            rng.choice(fields).name = state.name("v")

    def retype() -> None:
        fields, record = of_lists()
        if fields:
            number = rng.randrange(len(fields))
            member = drawn_field(rng, state, member=record)
            member.name = fields[number].name
            fields[number] = member

    def widen() -> None:
        arrays = [o for f in state.units.values() for o in f if isinstance(o.type, ArrayOf)]
        arrays += [o for r in state.records for o in r.own if isinstance(o.type, ArrayOf)]
        if arrays:
            one = rng.choice(arrays)
            assert isinstance(one.type, ArrayOf)
            first, last = one.type.first + rng.randint(-2, 2), one.type.last + rng.randint(-1, 3)
            one.type = ArrayOf(first, max(first, last), one.type.element)

    def extend() -> None:
        blocks = [one for one in state.records if one.is_block]
        if blocks:
            number = rng.randrange(len(blocks))
            blocks[number].base = rng.choice([None, *blocks[:number]])

    def grow() -> None:
        if state.records:
            record = rng.choice(state.records)
            at = rng.randint(0, len(record.own))
            record.own.insert(at, drawn_field(rng, state, member=record))

    def swap() -> None:
        rng.shuffle(of_lists()[0])

    def move() -> None:
        source, target = rng.sample(UNITS, 2)
        if state.units[source]:
            state.units[target].append(state.units[source].pop())

    def edit_body() -> None:
        state.step = rng.randint(1, 9)

    return [add_record, add, add, add_pointer, remove, rename, retype, widen, extend, grow, grow,
            swap, move, edit_body]  # fmt: skip
