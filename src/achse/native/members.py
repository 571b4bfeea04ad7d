"""Members of enumerations in plain kernels, looked up once instead of each time.

`phase == MotionPhase.HOMING` costs 80 ns in Python 3.11 and a number 14; a kernel compares some
fifty times per axis and cycle. So what a kernel reaches is changed in place: where its byte code
loads a member of an enumeration of numbers, it loads the number. A Python whose byte code is not
known here runs the functions as they are.
"""

import dis
import sys
from collections.abc import Iterator
from enum import EnumMeta
from itertools import pairwise
from types import CodeType, FunctionType, ModuleType

_KNOWN = (3, 11) <= sys.version_info[:2] <= (3, 14)
_GLOBAL, _ATTRIBUTE = dis.opmap["LOAD_GLOBAL"], dis.opmap["LOAD_ATTR"]
_CONSTANT, _JUMP = dis.opmap["LOAD_CONST"], dis.opmap["JUMP_FORWARD"]
_NOTHING, _EXTENDED = dis.opmap["NOP"], dis.opmap["EXTENDED_ARG"]
_CACHE = 0
_METHOD = sys.version_info >= (3, 12)
"""True if the lowest bit of the argument of LOAD_ATTR marks a method."""


def fold_members(entry: FunctionType) -> None:
    """Let a kernel's functions load numbers where they name members of enumerations."""
    if not _KNOWN:
        return
    for _, function in list(reached(entry)):
        if isinstance(function, FunctionType):
            spaces = function.__globals__
            if any(isinstance(spaces.get(name), EnumMeta) for name in function.__code__.co_names):
                function.__code__ = _folded(function.__code__, spaces)


def _folded(code: CodeType, scope: dict[str, object]) -> CodeType:
    words, constants = bytearray(code.co_code), list(code.co_consts)
    targets = set(dis.findlabels(code.co_code))  # type: ignore[arg-type]  # bytes in truth
    loads = list(_loads(code.co_code))
    for (start, _, load, name), (place, end, attribute, member) in pairwise(loads):
        if load != _GLOBAL or attribute != _ATTRIBUTE or name & 1 or place in targets:
            continue
        if _METHOD and member & 1:
            continue
        owner = scope.get(code.co_names[name >> 1])
        member_value = getattr(owner, code.co_names[member >> _METHOD], None)
        if (
            isinstance(owner, EnumMeta)
            and isinstance(member_value, owner)
            and isinstance(member_value, int)
        ):
            constants.append(int(member_value))
            index = len(constants) - 1
            new = [_EXTENDED, index >> 8] if index > 255 else []
            new += [_CONSTANT, index & 255]
            new += [_JUMP, (end - start - len(new)) // 2 - 1]
            rest = (end - start - len(new)) // 2
            words[start:end] = bytes([*new, *[_NOTHING, 0] * rest])
    return code.replace(co_code=bytes(words), co_consts=tuple(constants))


def _loads(words: bytes) -> Iterator[tuple[int, int, int, int]]:
    """Yield each instruction: where it begins, with its prefixes, and ends, what it is, its
    argument."""
    begin, argument, place = 0, 0, 0
    while place < len(words):
        operation, low = words[place], words[place + 1]
        argument = argument << 8 | low
        place += 2
        if operation == _EXTENDED:
            continue
        while place < len(words) and words[place] == _CACHE:
            place += 2
        yield begin, place, operation, argument
        begin, argument = place, 0


def reached(entry: FunctionType) -> Iterator[tuple[str, object]]:
    """Yield the function and all that it and what it calls may refer to by name."""
    known = {entry}
    waiting = [entry]
    while waiting:
        caller = waiting.pop()
        yield caller.__name__, caller
        names = caller.__code__.co_names
        spaces = [caller.__globals__]
        spaces += (vars(spaces[0][name]) for name in names if _is_module(spaces[0].get(name)))
        for name in names:
            for thing in (space[name] for space in spaces if name in space):
                for part in _parts(thing):
                    if not isinstance(part, FunctionType):
                        yield name, part
                    elif part not in known:
                        known.add(part)
                        waiting.append(part)


def _parts(thing: object) -> Iterator[object]:
    """Yield the thing itself; of a table, what its rows hold."""
    if isinstance(thing, tuple) and any(isinstance(row, tuple) for row in thing):
        for row in thing:
            yield from _parts(row)
    elif isinstance(thing, tuple) and any(isinstance(part, FunctionType) for part in thing):
        for part in thing:
            yield from _parts(part)
    else:
        yield thing


def _is_module(thing: object) -> bool:
    return isinstance(thing, ModuleType)
