"""A kernel as a C program: the same instructions, compiled by gcc, to measure ours beside it.

No benchmark of its own. It reads the assembly of `achse.native` line by line, which has no more
than loads, stores, arithmetic, branches and calls.
"""

import ctypes
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FLAGS = (
    *("-O2", "-march=native", "-shared", "-fPIC", "-w"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),  # IEEE 754, roundings inline
    *("-fwrapv", "-fno-strict-aliasing"),
)

_TYPES = {"i64": "int64_t", "double": "double", "ptr": "char *", "i1": "_Bool", "i8": "uint8_t"}
_BINARY = {
    "fadd": "+", "fsub": "-", "fmul": "*", "fdiv": "/", "add": "+", "sub": "-", "mul": "*",
    "and": "&", "or": "|", "xor": "^", "shl": "<<", "ashr": ">>", "sdiv": "/", "srem": "%",
}  # fmt: skip
_RELATIONS = {
    "eq": "==", "ne": "!=", "une": "!=", "oeq": "==", "gt": ">", "ge": ">=", "lt": "<", "le": "<=",
}  # fmt: skip
_FUNCTIONS = {"roundeven": "rint"}

_HEAD = """#include <math.h>
#include <stdint.h>
static inline double D(uint64_t bits) { double d; __builtin_memcpy(&d, &bits, 8); return d; }
"""


def gcc_installed() -> bool:
    return shutil.which("gcc") is not None


def compiled_by_gcc(assembly: str) -> Any:
    """The function `entry` of a module, made by gcc."""
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "kernel.c"), Path(folder, "kernel.so")
        source.write_text("\n".join([_HEAD, *c_lines(assembly)]), encoding="utf-8")
        subprocess.run(["gcc", *FLAGS, str(source), "-o", str(library), "-lm"], check=True)
        return ctypes.PyDLL(str(library)).entry


def c_lines(assembly: str) -> Iterator[str]:
    """The lines of the C program."""
    structures = sorted({*re.findall(r"\{ [a-z0-9, ]+ \}", assembly)})
    for text in structures:
        members = " ".join(f"{_TYPES[each]} m{n};" for n, each in enumerate(text[2:-2].split(", ")))
        yield f"{_type(text)} {{ {members} }};"
    for name, content in re.findall(r"^@(\w+) = private constant .* c\"(.*)\"", assembly, re.M):
        values = ", ".join(f"0x{each}" for each in content.split("\\")[1:])
        yield f"static const uint8_t {name}[] __attribute__((aligned(8))) = {{ {values} }};"
    functions = re.findall(
        r"^define ([^\n(]*)\(([^\n]*)\) nounwind \{\n(.*?)^\}", assembly, re.M | re.S
    )
    for head, parameters, _ in functions:
        yield f"{_head(head, parameters)};"
    for head, parameters, body in functions:
        yield from _function(_head(head, parameters), body)


def _type(text: str) -> str:
    if text.startswith("{"):
        return "struct s_" + "_".join(re.findall(r"\w+", text))
    return _TYPES.get(text, text)


def _name(symbol: str) -> str:
    name = symbol.strip('@%"').replace(".", "_")
    return f"{name}_" if symbol.startswith(("%", '@"achse')) else name


def _head(head: str, parameters: str) -> str:
    result, symbol = re.fullmatch(r"(internal )?(.*) (@\S+)", head).group(2, 3)  # type: ignore[union-attr]
    fields = (each.split(" ") for each in parameters.split(", ") if each)
    names = ", ".join(f"{_type(type)} {_name(name)}" for type, name in fields)
    linkage = "" if _name(symbol) == "entry" else "static "
    return f"{linkage}{_type(result)} {_name(symbol)}({names})"


def _function(head: str, body: str) -> Iterator[str]:
    declared, lines = [], []
    body = re.sub(r"%s(\d+) = alloca \[", r"%b\1 = alloca [", body)
    for number in re.findall(r"%b(\d+) = alloca", body):
        body = re.sub(rf"%s{number}\b", f"%b{number}", body)  # a record of the function's own
    for line in body.splitlines():
        text = re.sub(r"(, align \d+|, !invariant.load !\d+)", "", line.strip())
        if text.endswith(":"):
            lines.append(f"{text[:-1]}_: ;")
        elif " = " in text:
            target, rest = text.split(" = ", 1)
            if rest.startswith("alloca ["):
                size = rest[8:].split(" ")[0]
                declared.append(f"_Alignas(8) char {_name(target)}[{size}];")
                continue
            if rest.startswith("alloca "):
                declared.append(f"{_type(rest[7:])} {_name(target)};")
                continue
            type, value = _value(rest)
            declared.append(f"{type} {_name(target)};")
            lines.append(f"{_name(target)} = {value};")
        else:
            lines.append(_statement(text))
    yield f"{head} {{"
    yield from declared
    yield from lines
    yield "}"


def _operand(text: str) -> str:
    if re.fullmatch(r"0x[0-9A-F]{16}", text):
        return f"D({text}ULL)"
    if text in ("true", "false", "null"):
        return str(int(text == "true"))
    if re.fullmatch(r"-?\d+", text):
        return "INT64_MIN" if text == "-9223372036854775808" else f"{text}LL"
    name = _name(text)
    return f"(char *){name}" if text.startswith("@data") else name


def _place(type: str, text: str) -> str:
    """A local variable, or a place in memory."""
    if re.fullmatch(r"%s\d+", text):
        return _name(text)
    return f"*({_type(type)} *)({_operand(text)})"


def _arguments(text: str) -> list[str]:
    return [_operand(each.split(" ")[-1]) for each in text.split(", ") if each]


def _call(text: str) -> str:
    symbol, passed = re.fullmatch(r"(@\S+?)\((.*)\)", text).groups()  # type: ignore[union-attr]
    name = symbol.strip('@"')
    if name.startswith(("llvm.", "achse_")):
        name = name.removeprefix("llvm.").removeprefix("achse_").split(".")[0]
        name = _FUNCTIONS.get(name, name)
    else:
        name = _name(symbol)
    arguments = _arguments(passed)
    if name in ("memmove", "memset"):
        arguments = arguments[:3]  # behind them is whether they are volatile
    return f"{name}({', '.join(arguments)})"


def _value(text: str) -> tuple[str, str]:
    """Type and expression of what an instruction gives."""
    operation, rest = text.split(" ", 1)
    if operation == "call":
        type, call = re.fullmatch(r"(\{.*?\}|\w+) (@.*)", rest).groups()  # type: ignore[union-attr]
        return _type(type), _call(call)
    if operation == "load":
        type, place = rest.split(", ptr ")
        return _type(type), _place(type, place)
    if operation in ("icmp", "fcmp"):
        relation, _, a, b = rest.replace(",", "").split(" ")
        unsigned = "(uint64_t)" if relation.startswith("u") and operation == "icmp" else ""
        relation = relation if relation in _RELATIONS else relation[1:]
        return "_Bool", f"{unsigned}{_operand(a)} {_RELATIONS[relation]} {unsigned}{_operand(b)}"
    if operation == "getelementptr":
        unit, base, index = rest.split(", ")
        size = 8 if unit == "i64" else 1
        return (
            "char *",
            f"{_operand(base.split(' ')[1])} + {size} * {_operand(index.split(' ')[1])}",
        )
    if operation == "select":
        test, yes, no = _arguments(rest)
        return _type(rest.split(", ")[1].split(" ")[0]), f"{test} ? {yes} : {no}"
    if operation == "insertvalue":
        type, whole, value, n = re.fullmatch(r"(\{.*?\}) (\S+), \w+ (\S+), (\d+)", rest).groups()  # type: ignore[union-attr]
        before = f"({_type(type)}){{0}}" if whole == "undef" else _operand(whole)
        return _type(type), f"({{ {_type(type)} t = {before}; t.m{n} = {_operand(value)}; t; }})"
    if operation == "extractvalue":
        type, whole, n = re.fullmatch(r"(\{.*?\}) (\S+), (\d+)", rest).groups()  # type: ignore[union-attr]
        return _type(type[2:-2].split(", ")[int(n)]), f"{_operand(whole)}.m{n}"
    if operation in _BINARY:
        type, a, b = rest.replace(",", "").split(" ")
        return _type(type), f"{_operand(a)} {_BINARY[operation]} {_operand(b)}"
    if operation in ("fneg", "freeze"):
        type, a = rest.split(" ")
        return _type(type), ("-" if operation == "fneg" else "") + _operand(a)
    type, a, _, new = rest.split(" ")  # sitofp, fptosi, zext, trunc
    return _type(new), f"({_type(new)}){_operand(a)}"


def _statement(text: str) -> str:
    operation, _, rest = text.partition(" ")
    if operation == "store":
        value, place = rest.split(", ptr ")
        type, operand = value.split(" ", 1)
        return f"{_place(type, place)} = {_operand(operand)};"
    if operation == "br":
        ways = [f"goto {each}_;" for each in re.findall(r"label %(\w+)", rest)]
        if len(ways) == 1:
            return ways[0]
        return f"if ({_operand(rest.split(',')[0].split(' ')[1])}) {ways[0]} else {ways[1]}"
    if operation == "ret":
        return "return;" if rest == "void" else f"return {_operand(rest.split(' ')[-1])};"
    if operation == "call":
        return _call(rest.split(" ", 1)[1]) + ";"
    return "__builtin_unreachable();"
