"""Pragmas: attributes of declarations, and conditional compilation.

`{attribute 'name' := 'value'}` belongs to the declaration it is before. Of the rest,
`{define X}`, `{undefine X}` and `{IF …} {ELSIF …} {ELSE} {END_IF}` decide which tokens there are;
conditions are `defined (X)`, `project_defined (X)`, `hasvalue (X, 'v')`, NOT, AND, OR and
parentheses. `defined (variable: x)`, `hastype (variable: x, T)`, `hasattribute (pou: p, 'a')` and
`hasconstantvalue (c, 'v')` ask for what a project declares: `ProjectDefines` knows it, without one
they are false. Every other pragma (`region`, `warning`, `info`, …) is for the editor and is passed
over.

Source: IEC 61131-3 (2013) table 4; attributes and conditions as in TwinCAT 3.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Protocol

_QUOTED = r"""(?:'((?:[^'$]|\$.)*)'|"((?:[^"$]|\$.)*)")"""
_ATTRIBUTE = re.compile(
    rf"\{{\s*attribute\s+{_QUOTED}\s*(?::=\s*{_QUOTED}\s*)?\}}", re.IGNORECASE | re.DOTALL
)
_DIRECTIVE = re.compile(
    r"\{\s*(IF|ELSIF|ELSE|END_IF|DEFINE|UNDEFINE)\b(.*)\}", re.IGNORECASE | re.DOTALL
)
_DEFINE = re.compile(r"\s*(\w+)\s*(?::?=?\s*'(.*)')?\s*", re.DOTALL)
_WORD = re.compile(r"\s*(\w+|'[^']*'|[^\w\s'])")
_ASKING = re.compile(
    r"""\{\s*(?:ELS)?IF\b[^}]*\b(?:hastype|hasattribute|hasconstantvalue|defined)\s*
    \(\s*\w+\s*[:,]""",
    re.IGNORECASE | re.VERBOSE,
)
_ESCAPED = re.compile(r"\$(.)", re.DOTALL)
_DEEPEST = 16


def attribute_of(pragma: str) -> tuple[str, str] | None:
    """Name and value of an attribute pragma; None if it is another one."""
    match = _ATTRIBUTE.fullmatch(pragma)
    if match is None:
        return None
    name, value = match[1] or match[2] or "", match[3] or match[4] or ""
    return name.strip(), _ESCAPED.sub(r"\1", value)


class ProjectDefines(Protocol):
    """Defines, and what a project declares: for tests that only a compiler can answer."""

    @property
    def defines(self) -> Mapping[str, str]:
        """Names that are defined, with their values."""
        ...

    def is_declared(self, kind: str, name: str) -> bool:
        """Return True if there is a variable, type or pou of that name."""
        ...

    def attribute(self, kind: str, name: str, attribute: str) -> str | None:
        """Return the value of an attribute of a variable, type or pou; None if it has none."""
        ...

    def type_name(self, variable: str) -> str:
        """Return the type of a variable as declared; empty if there is none."""
        ...

    def constant(self, name: str) -> str | None:
        """Return the initial value of a variable as declared."""
        ...


def needs_declarations(text: str) -> bool:
    """Return True if a condition in a text can only be evaluated with all declarations."""
    return _ASKING.search(text) is not None


class Conditions:
    """Follows the pragmas of one text and selects the parts of it that count."""

    def __init__(self, defines: Mapping[str, str] | Iterable[str] | ProjectDefines = ()) -> None:
        self._project: ProjectDefines | None = None
        if not isinstance(defines, Mapping | Iterable):
            self._project = defines
            defines = defines.defines
        pairs = defines.items() if isinstance(defines, Mapping) else ((key, "") for key in defines)
        self._defines = {name.lower(): value for name, value in pairs}
        self._outside = dict(self._defines)
        self._open: list[tuple[bool, bool]] = []
        """Of each open IF: whether a branch was taken already, and whether the outer part counts.
        """
        self.counts = True

    @property
    def is_open(self) -> bool:
        """True if an `{IF}` has no `{END_IF}` yet."""
        return bool(self._open)

    def begin_object(self) -> None:
        """Begin a unit or type: its defines end with it."""
        self._outside = dict(self._defines)

    def end_object(self) -> None:
        """End the object."""
        self._defines = dict(self._outside)

    def take(self, pragma: str) -> str:
        """Follow a pragma. Returns what is wrong with it, or nothing."""
        match = _DIRECTIVE.fullmatch(pragma)
        if match is None:
            return ""
        word = match[1].upper()
        if word == "IF":
            self._open.append((False, self.counts))
            return self._branch(match[2])
        if word in ("DEFINE", "UNDEFINE"):
            return self._define(word, match[2]) if self.counts else ""
        if not self._open:
            return f"{{{word}}} without {{IF}}"
        if word == "END_IF":
            self.counts = self._open.pop()[1]
            return ""
        return self._branch(match[2] if word == "ELSIF" else None)

    def _branch(self, condition: str | None) -> str:
        taken, outer = self._open[-1]
        problem = ""
        holds = True
        if condition is not None:
            words = _WORD.findall(condition)
            holds, rest = _either(words, (self._defines, self._project), 0)
            if rest:
                holds, problem = False, "expected a condition like defined (X) AND NOT defined (Y)"
        self.counts = outer and not taken and holds
        self._open[-1] = (taken or holds, outer)
        return problem

    def _define(self, word: str, rest: str) -> str:
        match = _DEFINE.fullmatch(rest)
        if match is None:
            return f"expected a name after {word.lower()}"
        if word == "DEFINE":
            self._defines[match[1].lower()] = match[2] or ""
        else:
            self._defines.pop(match[1].lower(), None)
        return ""


Words = list[str]
_Known = tuple[Mapping[str, str], ProjectDefines | None]
_Truth = tuple[bool, Words]
"""A truth, and the words after the condition; a condition that is none leaves words over."""


def _either(words: Words, known: _Known, depth: int) -> _Truth:
    truth, words = _both(words, known, depth)
    while words and words[0].upper() == "OR":
        other, words = _both(words[1:], known, depth)
        truth = truth or other
    return truth, words


def _both(words: Words, known: _Known, depth: int) -> _Truth:
    truth, words = _test(words, known, depth)
    while words and words[0].upper() == "AND":
        other, words = _test(words[1:], known, depth)
        truth = truth and other
    return truth, words


def _test(words: Words, known: _Known, depth: int) -> _Truth:
    wrong = (False, ["?"])
    if not words or depth > _DEEPEST:
        return wrong
    if words[0].upper() == "NOT":
        truth, words = _test(words[1:], known, depth + 1)
        return not truth, words
    if words[0] == "(":
        truth, words = _either(words[1:], known, depth + 1)
        return (truth, words[1:]) if words[:1] == [")"] else wrong
    if words[1:2] != ["("] or ")" not in words:
        return wrong
    end = words.index(")")
    inside = words[2:end]
    test = words[0].lower()
    truth = False
    defines, project = known
    if test in ("defined", "project_defined") and len(inside) == 1:
        truth = inside[0].lower() in defines
    elif test == "hasvalue" and len(inside) == 3:
        truth = defines.get(inside[0].lower()) == inside[2].strip("'")
    elif project is not None:
        truth = _declared(test, inside, project)
    return truth, words[end + 1 :]


def _declared(test: str, inside: Words, project: ProjectDefines) -> bool:
    """Return a test of what the project declares: `variable: x`, and what it is compared with."""
    kind, name, rest = "variable", "", inside
    if inside[1:2] == [":"]:
        kind, rest = inside[0].lower(), inside[2:]
    cut = rest.index(",") if "," in rest else len(rest)
    name, rest = "".join(rest[:cut]), rest[cut + 1 :]
    value = "".join(rest).strip("'")
    if test == "defined":
        return project.is_declared(kind, name)
    if test == "hastype":
        return project.type_name(name).replace(" ", "").lower() == value.lower()
    if test == "hasattribute":
        attribute, _, wanted = value.partition(",")
        attribute_value = project.attribute(kind, name, attribute.strip("' "))
        return attribute_value is not None and (not wanted or attribute_value == wanted.strip("' "))
    if test == "hasconstantvalue":
        constant, _, sign = value.partition(",")
        return _compared(project.constant(name), constant.strip("' "), sign.strip("' ") or "=")
    return False


def _compared(value: str | None, wanted: str, sign: str) -> bool:
    if value is None:
        return False
    try:
        left, right = float(value), float(wanted)
    except ValueError:
        return sign in ("=", "==") and value.strip("'").lower() == wanted.lower()
    return {
        "=": left == right,
        "==": left == right,
        "<": left < right,
        ">": left > right,
        "<=": left <= right,
        ">=": left >= right,
        "<>": left != right,
    }.get(sign, False)
