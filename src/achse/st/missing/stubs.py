"""Stubs: declarations for what a project uses and nothing declares, as Structured Text.

A type has the members, inputs, outputs and methods that the project uses, an enumeration the
values. What no use shows is guessed from the name (`bBusy` is a BOOL) and has a question mark.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from enum import Enum
from itertools import groupby
from typing import Any

from achse.iec.structs import RecordKind, StructType
from achse.iec.variables import Section
from achse.st.declared.signatures import is_open_array, open_array
from achse.st.missing.kinds import (
    guessed,
    has_kind,
    has_values,
    is_array,
    is_block,
    is_constant,
    is_enumeration,
    is_method,
    is_name,
    is_read,
)
from achse.st.missing.uses import MissingUse, open_bounds
from achse.st.missing.walk import MissingNames
from achse.st.syntax.printer import print_type
from achse.st.syntax.units import Method

TYPES_FILE = "types.st"
LISTS_FILE = "constants.st"

_HIGHEST = 255
"""The last index of an array that is indexed by variables only."""
_HIGHEST_OF_MANY = 31
"""The same of an array with several dimensions."""
_VALUE = 16
"""Value of constants; a project has arrays of that many elements."""
_STEP = "    "
_COUNTS = (
    "sint",
    "usint",
    "int",
    "uint",
    "dint",
    "udint",
    "lint",
    "ulint",
    "byte",
    "word",
    "dword",
)
_ANY = {"pvalue", "disize"}
_BY_PLACE = re.compile(r"p\d+")
"""Names of parameters that calls pass by their place alone."""
_MARK = "{attribute 'stub'}"
"""Mark of blocks whose interfaces are not known: each fits any."""
_INTERFACE = re.compile(r"I_?[A-Z][a-z]|ITc[A-Z]|I_")
_COM = re.compile(r"ITc[A-Z]")
_ROOT = "ITcUnknown"
"""Base of all interfaces of TcCOM."""
_QUALIFIED = re.compile(r"(?:[^\W\d]\w*\.)+([^\W\d]\w*)", re.ASCII)
_EVENTS = "TC_EVENTS"
"""List of the event classes of a project, whose members are their events."""
_PARAMETERS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")


def stub_files(missing: MissingNames) -> dict[str, str]:
    """Files of Structured Text by name: the types, and one for each list of variables.

    Nothing is in there if nothing is missing.
    """
    return _Writer(missing).files()


class _Writer:
    def __init__(self, missing: MissingNames) -> None:
        meanings = missing.meanings
        self._root = _ROOT if missing.declares(_ROOT) else ""
        self._types = meanings.types.uses
        self._blocks = missing.blocks
        self._names = meanings.names
        self._lists = meanings.lists
        self._values: dict[str, dict[str, str]] = {}
        """Values of enumerations, which may be named with and without their library."""
        self._texts: dict[str, list[str]] = {}
        """Declarations by name in lower case."""

    def files(self) -> dict[str, str]:
        lists: dict[str, dict[str, MissingUse]] = {}
        values = {key for use in self._types.values() if has_values(use) for key in use.values}
        for key, use in self._names.items():
            if key in self._types or not is_name(use.name):
                continue
            if key in values and not use.is_called and not use.members:
                continue  # a value of an enumeration, named without it
            if key in self._lists and use.members and not use.is_called:
                if is_enumeration(use):
                    names = [one.name for one in use.members.values()]
                    self._enumeration(use.name, names, use.first)
                    continue
                variables = self._of_library(use)
                if variables:
                    lists[f"{use.name}.st"] = variables
            elif use.is_called:
                self._function(use)
            else:
                lists.setdefault(LISTS_FILE, {})[key] = use
        for use in list(self._types.values()):
            self._type(use.name, use)
        files = {name: "\n".join(self._list(uses)) for name, uses in sorted(lists.items())}
        types = [line for text in self._texts.values() for line in (*text, "")]
        if types:
            files[TYPES_FILE] = "\n".join(types)
        return files

    def _of_library(self, space: MissingUse) -> dict[str, MissingUse]:
        """Return the variables behind a name; its types and functions are declared without it."""
        variables: dict[str, MissingUse] = {}
        for key, use in space.members.items():
            if not is_name(use.name):
                continue
            if use.is_called and (use.is_method or not use.members):
                self._function(use)
            elif use.members and space.name.upper() == _EVENTS:
                for event in use.members.values():
                    event.type = "TcEventEntry"
                variables[key] = use
            elif use.members and is_enumeration(use):
                names = [one.name for one in use.members.values()]
                self._enumeration(use.name, names, use.first)
            else:
                variables[key] = use
        return variables

    # lists -----------------------------------------------------------------------------------

    def _list(self, variables: Mapping[str, MissingUse]) -> Iterator[str]:
        constants = [use for use in variables.values() if is_constant(use)]
        rest = [use for use in variables.values() if not is_constant(use)]
        if constants:
            yield "VAR_GLOBAL CONSTANT"
            for number, use in enumerate(constants, 1):
                value = ""
                if use.is_bound:
                    value = f" := {1 if use.is_low else _VALUE}"
                elif self._type_of(use, "Global")[0].lower() in _COUNTS:
                    value = f" := {number}"  # Labels of a CASE have to differ.
                yield f"{_STEP}{self._declared(use, 'Global', value)}"
            yield "END_VAR"
        if rest:
            yield "VAR_GLOBAL"
            yield from (f"{_STEP}{self._declared(use, 'Global')}" for use in rest)
            yield "END_VAR"
        yield ""

    def _declared(
        self, use: MissingUse, owner: str, value: str = "", *, is_input: bool = False
    ) -> str:
        type, is_sure = self._type_of(use, owner)
        if is_input and (use.is_mixed or (not is_sure and _BY_PLACE.fullmatch(use.name))):
            type = "ANY"
        note = " // value?" if value else "" if is_sure else " // type?"
        return f"{use.name} : {type}{value};{note}"

    # types -----------------------------------------------------------------------------------

    def _type_of(self, use: MissingUse, owner: str) -> tuple[str, bool]:
        """Return the type of a variable or member, and True if a use or a symbol file shows it."""
        if use.is_part:
            return self._own_names(use.type), True
        if use.is_bound:
            return "INT", True
        if use.is_reference:
            target, is_sure = self._type_of(replace(use, is_reference=False), owner)
            return f"REFERENCE TO {target}", is_sure
        if use.is_called and not (use.inputs or use.outputs):
            self._type(name := f"{owner}_{use.name}", replace(use, is_interface=True))
            return name, True
        if use.element is not None:
            inner, is_sure = self._type_of(use.element, owner)
            highest, is_known = use.highest, use.highest > 0 and not use.is_indexed_by_variable
            if not is_known:
                highest = max(highest, _HIGHEST if use.dimensions == 1 else _HIGHEST_OF_MANY)
            bounds = ", ".join([f"0..{highest}"] * use.dimensions)
            return f"ARRAY [{bounds}] OF {inner}", is_sure and is_known
        if use.target is not None:
            inner, is_sure = self._type_of(use.target, owner)
            return f"POINTER TO {inner}", is_sure
        if use.members or use.is_called:
            name = use.kind or f"{owner}_{use.name}"
            self._type(name, use)
            return name, True
        if use.type and use.type.lower() != owner.lower() and not use.type.startswith("ARRAY [*"):
            return use.type, True
        like = use.like
        if like is not None and like.space is not None and is_enumeration(like.space):
            return like.space.name, True
        if like is not None and like.type and like.type.lower() != owner.lower():
            return like.type, True
        return guessed(use.name), False

    def _type(self, name: str, use: MissingUse) -> None:
        if name.lower() in self._texts or not is_name(name):
            return
        self._texts[name.lower()] = []  # A type may point to its own kind.
        is_called = any(is_method(one) for one in use.members.values())
        is_named = (is_called or is_read(use)) and _INTERFACE.match(name)
        if use.is_interface or (use.block is None and is_named):
            lines = list(self._interface(name, use))
        elif use.block is not None and use.block.kind is not RecordKind.FUNCTION_BLOCK:
            lines = list(self._structure(name, use.block))
        elif _ANY <= use.members.keys() <= {*_ANY, "typeclass"}:
            lines = [f"TYPE {name} : __SYSTEM.AnyType; END_TYPE"]
        elif has_values(use):
            self._enumeration(name, use.values.values(), use.first)
            return
        elif is_block(use):
            lines = list(self._block(name, use))
        elif use.members or use.is_structure:
            members = [self._declared(one, name) for one in use.members.values()]
            lines = [f"TYPE {name} : STRUCT", *(_STEP + line for line in members)]
            lines += ["END_STRUCT END_TYPE"]
        elif use.element is not None:
            type, _ = self._type_of(use, name)
            lines = [f"TYPE {name} : {type}; END_TYPE"]
        elif use.type and use.type.lower() != name.lower():
            lines = [f"TYPE {name} : {use.type}; END_TYPE"]
        else:
            lines = [_MARK, f"FUNCTION_BLOCK {name} // what is it?", "END_FUNCTION_BLOCK"]
        self._texts[name.lower()] = lines

    def _enumeration(self, name: str, values: Iterable[str], first: int) -> None:
        known = self._values.setdefault(name.lower(), {})
        for value in values:
            known.setdefault(value.lower(), value)
        start = f" := {first}" if first else ""
        members = ", ".join(
            f"{value}{'' if n else start}" for n, value in enumerate(known.values())
        )
        self._texts[name.lower()] = [f"TYPE {name} : ({members}); END_TYPE // numbers?"]

    def _block(self, name: str, use: MissingUse) -> Iterator[str]:
        methods = [one for one in use.members.values() if is_method(one)]
        variables = [one for one in use.members.values() if not is_method(one)]
        taken = {*use.inputs, *use.outputs}
        inputs = [*use.inputs.values(), *use.arguments]
        inputs += [one for one in variables if one.is_written and one.name.lower() not in taken]
        outputs = list(use.outputs.values())
        outputs += [
            one for one in variables if not one.is_written and one.name.lower() not in taken
        ]
        for key, one in {**use.inputs, **use.outputs}.items():
            if key in use.members and not one.type:
                one.type = use.members[key].type
        passed = [one for one in inputs if self._is_passed(one)]
        if use.block is None:
            yield _MARK
        yield f"FUNCTION_BLOCK {name}{self._bases(use)}"
        if use.block is not None:
            yield from self._of_symbol_file(use.block, with_inherited=not use.extends)
            signed = self._signed(use)
            for one in variables:
                if one.name.lower() not in signed:
                    yield from self._property(one, name)
            methods = [one for one in methods if one.name.lower() not in signed]
            yield from self._by_signature(use, is_block=True)
            inputs, passed, outputs = [], [], []
        if use.generics:
            numbers = ", ".join(f"nGeneric{number + 1}" for number in range(use.generics))
            yield f"VAR_GENERIC CONSTANT {numbers} : DINT := 1; END_VAR"
        yield from self._section("VAR_INPUT", [one for one in inputs if one not in passed], name)
        if passed:  # a call may leave one out: a reference, and no VAR_IN_OUT
            yield "VAR_INPUT"
            for one in passed:
                yield f"{_STEP}{one.name} : REFERENCE TO {self._type_of(one, name)[0]};"
            yield "END_VAR"
        yield from self._section("VAR_OUTPUT", outputs, name)
        if use.initials:
            yield "METHOD FB_init : BOOL"
            yield "VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR"
            yield from self._section("VAR_INPUT", use.initials.values(), name, is_routine=True)
            yield "END_METHOD"
        for one in methods:
            yield from self._method(one, name)
        yield "END_FUNCTION_BLOCK"

    def _of_symbol_file(self, block: StructType[Any], *, with_inherited: bool) -> Iterator[str]:
        """Return the variables of a block, in the order in which memory has them."""
        members = block.members if with_inherited else block.own_members
        members = tuple(one for one in members if is_name(one.name))
        for section, variables in groupby(members, lambda one: one.section):
            yield section.value
            for one in variables:
                if is_open_array(one.attributes):
                    continue
                type = self._own_names(one.type.name)
                if section is Section.IN_OUT:
                    type = type.removeprefix("REFERENCE TO ")
                yield f"{_STEP}{one.name} : {type};"
            yield "END_VAR"
        for one in members:
            if is_open_array(one.attributes):
                type = open_array(one.type.name, one.attributes)
                yield f"VAR_IN_OUT {one.name} : {self._own_names(type)}; END_VAR"

    def _structure(self, name: str, type: StructType[Any]) -> Iterator[str]:
        """Return a structure of a symbol file, with the values that numbers in it start with."""
        yield f"TYPE {name} : {'UNION' if type.kind is RecordKind.UNION else 'STRUCT'}"
        for one in type.members:
            if is_name(one.name):
                start = None if one.initial is None else one.type.decode(one.initial_bytes())
                is_plain = isinstance(start, bool | int | float) and not isinstance(start, Enum)
                value = f" := {start}" if is_plain else ""
                yield f"{_STEP}{one.name} : {self._own_names(one.type.name)}{value};"
        yield "END_UNION END_TYPE" if type.kind is RecordKind.UNION else "END_STRUCT END_TYPE"

    def _bases(self, use: MissingUse) -> str:
        """Return the bases that a symbol file has, as the declaration writes them."""
        text = ""
        for word, names in (("EXTENDS", use.extends), ("IMPLEMENTS", use.implements)):
            if names:
                text += f" {word} {', '.join(self._own_names(name) for name in names)}"
        return text

    def _signed(self, use: MissingUse) -> set[str]:
        """Return the parts of a type and its bases, in lower case, that a symbol file has."""
        names: set[str] = set()
        waiting, seen = [use], {id(use)}
        while waiting:
            one = waiting.pop()
            if one.signature is not None:
                names |= {*one.signature.methods, *one.signature.properties}
            bases = [self._types.get(name.rpartition(".")[2].lower()) for name in one.extends]
            new = [base for base in bases if base is not None and id(base) not in seen]
            seen.update(map(id, new))
            waiting += new
        return names

    def _by_signature(self, use: MissingUse, *, is_block: bool = False) -> Iterator[str]:
        """Return the methods and properties that a symbol file has of a type.

        A property of a block that returns a reference refers to a variable of its own.
        """
        if use.signature is None:
            return
        for item in use.signature.properties.values():
            target = self._own_names(item.type).removeprefix("REFERENCE TO ")
            is_reference = is_block and item.type.startswith("REFERENCE TO ")
            body = f"VAR_STAT target : {target}; END_VAR {item.name} REF= target; "
            getter = f"GET {body if is_reference else ''}END_GET"
            accessors = [getter] * item.readable + ["SET END_SET"] * item.writable
            yield f"PROPERTY {item.name} : {self._own_names(item.type)}"
            yield " ".join(accessors)
            yield "END_PROPERTY"
        for method in use.signature.methods.values():
            result = f" : {self._own_names(method.returns)}" if method.returns else ""
            yield f"METHOD {method.name}{result}"
            for section, parameters in groupby(method.parameters, lambda one: one.section):
                yield section
                yield from (
                    f"{_STEP}{one.name} : {self._own_names(one.type)};" for one in parameters
                )
                yield "END_VAR"
            yield "END_METHOD"

    def _own_names(self, type: str) -> str:
        """Return the text of a type, where other stubs have no library in front."""
        return _QUALIFIED.sub(
            lambda match: match[1] if match[1].lower() in self._types else match[0], type
        )

    def _is_passed(self, use: MissingUse) -> bool:
        """Return True if an input is a block, which is not copied."""
        if use.type.lower() in self._blocks:
            return True
        declared = self._types.get(use.type.lower())
        return declared is not None and (is_block(declared) or not has_kind(declared))

    def _interface(self, name: str, use: MissingUse) -> Iterator[str]:
        is_com = use.signature is None and _COM.match(name) and name != self._root
        root = f" EXTENDS {self._root}" if is_com and self._root else ""
        yield f"INTERFACE {name}{self._bases(use) or root}"
        yield from self._by_signature(use)
        signed = self._signed(use)
        for one in use.members.values():
            if one.name.lower() in signed:
                continue
            if is_method(one):
                yield from self._method(one, name)
            else:
                yield from self._property(one, name)
        yield "END_INTERFACE"

    def _property(self, use: MissingUse, owner: str) -> Iterator[str]:
        type, _ = self._type_of(use, owner)
        yield f"PROPERTY {use.name} : {type}"
        yield "GET END_GET" if not use.is_written else "GET END_GET SET END_SET"
        yield "END_PROPERTY"

    def _method(self, use: MissingUse, owner: str) -> Iterator[str]:
        if use.override is not None:
            yield from self._overridden(use.override)
            return
        yield f"METHOD {use.name} : {self._result(use, owner) or use.type or 'BOOL'}"
        inside = f"{owner}_{use.name}"
        yield from self._section(
            "VAR_INPUT", [*use.inputs.values(), *use.arguments], inside, is_routine=True
        )
        yield from self._section("VAR_OUTPUT", use.outputs.values(), inside)
        yield "END_METHOD"

    def _overridden(self, method: Method) -> Iterator[str]:
        """Return the parameters and the result of a method of the project."""
        result = "" if method.returns is None else f" : {print_type(method.returns)}"
        yield f"METHOD {method.name}{result}"
        for block in method.blocks:
            if block.section in _PARAMETERS:
                yield block.section
                for one in block.variables:
                    names = ", ".join(name.name for name in one.names)
                    yield f"{_STEP}{names} : {self._own_names(print_type(one.type))};"
                yield "END_VAR"
        yield "END_METHOD"

    def _result(self, use: MissingUse, owner: str) -> str:
        """Return the type of which a use reads parts, of what a call gives: `fb.A().B()`."""
        if not use.members:
            return ""
        value = replace(use, inputs={}, outputs={}, arguments=[], is_called=False)
        return self._type_of(value, owner)[0]

    def _function(self, use: MissingUse) -> None:
        result = self._result(use, "Result") or use.type or guessed(use.name)
        lines = [f"FUNCTION {use.name} : {result}"]
        lines += self._section(
            "VAR_INPUT", [*use.inputs.values(), *use.arguments], use.name, is_routine=True
        )
        lines += self._section("VAR_OUTPUT", use.outputs.values(), use.name)
        self._texts[use.name.lower()] = [*lines, "END_FUNCTION"]

    def _section(
        self, word: str, variables: Iterable[MissingUse], owner: str, *, is_routine: bool = False
    ) -> Iterator[str]:
        """Yield a section; arrays that a routine takes have any length, as variables of the
        caller."""
        is_input = word == "VAR_INPUT" and is_routine
        for is_open, group in groupby(variables, lambda one: is_input and is_array(one)):
            yield "VAR_IN_OUT" if is_open else word
            for one in group:
                if is_open:
                    yield f"{_STEP}{one.name} : {open_bounds(one.type)};"
                else:
                    yield _STEP + self._declared(one, owner, is_input=is_input)
            yield "END_VAR"
