"""Pragmas: attributes of declarations, and conditional compilation.

`{attribute 'name' := 'value'}` belongs to the declaration it stands before. Of the rest,
`{define X}`, `{undefine X}` and `{IF …} {ELSIF …} {ELSE} {END_IF}` decide which tokens there are;
conditions are `defined (X)`, `project_defined (X)`, `hasvalue (X, 'v')`, NOT, AND, OR and
parentheses. Any other test (`hastype`, `defined (variable: x)`, …) asks what only a compiler
knows, and is false. Every other pragma (`region`, `warning`, `info`, …) is for the editor and is
passed over.
"""

import re
from collections.abc import Iterable, Mapping

__all__ = ["Conditions", "attribute_of"]

_QUOTED = r"""(?:'((?:[^'$]|\$.)*)'|"((?:[^"$]|\$.)*)")"""
_ATTRIBUTE = re.compile(
    rf"\{{\s*attribute\s+{_QUOTED}\s*(?::=\s*{_QUOTED}\s*)?\}}", re.IGNORECASE | re.DOTALL
)
_DIRECTIVE = re.compile(
    r"\{\s*(IF|ELSIF|ELSE|END_IF|DEFINE|UNDEFINE)\b(.*)\}", re.IGNORECASE | re.DOTALL
)
_DEFINE = re.compile(r"\s*(\w+)\s*(?::?=?\s*'(.*)')?\s*", re.DOTALL)
_WORD = re.compile(r"\s*(\w+|'[^']*'|[^\w\s'])")
_ESCAPED = re.compile(r"\$(.)", re.DOTALL)
_DEEPEST = 16


def attribute_of(pragma: str) -> tuple[str, str] | None:
    """Name and value of an attribute pragma; None if it is another one."""
    found = _ATTRIBUTE.fullmatch(pragma)
    if found is None:
        return None
    name, value = found[1] or found[2] or "", found[3] or found[4] or ""
    return name.strip(), _ESCAPED.sub(r"\1", value)


class Conditions:
    """Follows the pragmas of one text and tells which parts of it count."""

    def __init__(self, defines: Mapping[str, str] | Iterable[str] = ()) -> None:
        pairs = defines.items() if isinstance(defines, Mapping) else ((key, "") for key in defines)
        self._defines = {name.lower(): value for name, value in pairs}
        self._open: list[tuple[bool, bool]] = []
        """Of each open IF: whether a branch was taken already, and whether the outer part counts.
        """
        self.counts = True

    @property
    def is_open(self) -> bool:
        """Whether an `{IF}` waits for its `{END_IF}`."""
        return bool(self._open)

    def take(self, pragma: str) -> str:
        """Follow a pragma. Returns what is wrong with it, or nothing."""
        found = _DIRECTIVE.fullmatch(pragma)
        if found is None:
            return ""
        word = found[1].upper()
        if word == "IF":
            self._open.append((False, self.counts))
            return self._branch(found[2])
        if word in ("DEFINE", "UNDEFINE"):
            return self._define(word, found[2]) if self.counts else ""
        if not self._open:
            return f"{{{word}}} without {{IF}}"
        if word == "END_IF":
            self.counts = self._open.pop()[1]
            return ""
        return self._branch(found[2] if word == "ELSIF" else None)

    def _branch(self, condition: str | None) -> str:
        taken, outer = self._open[-1]
        problem = ""
        holds = True
        if condition is not None:
            words = _WORD.findall(condition)
            holds, rest = _either(words, self._defines, 0)
            if rest:
                holds, problem = False, "expected a condition like defined (X) AND NOT defined (Y)"
        self.counts = outer and not taken and holds
        self._open[-1] = (taken or holds, outer)
        return problem

    def _define(self, word: str, rest: str) -> str:
        found = _DEFINE.fullmatch(rest)
        if found is None:
            return f"expected a name after {word.lower()}"
        if word == "DEFINE":
            self._defines[found[1].lower()] = found[2] or ""
        else:
            self._defines.pop(found[1].lower(), None)
        return ""


Words = list[str]
_Truth = tuple[bool, Words]
"""A truth, and the words after the condition; a condition that is none leaves words over."""


def _either(words: Words, defines: Mapping[str, str], depth: int) -> _Truth:
    truth, words = _both(words, defines, depth)
    while words and words[0].upper() == "OR":
        other, words = _both(words[1:], defines, depth)
        truth = truth or other
    return truth, words


def _both(words: Words, defines: Mapping[str, str], depth: int) -> _Truth:
    truth, words = _test(words, defines, depth)
    while words and words[0].upper() == "AND":
        other, words = _test(words[1:], defines, depth)
        truth = truth and other
    return truth, words


def _test(words: Words, defines: Mapping[str, str], depth: int) -> _Truth:
    wrong = (False, ["?"])
    if not words or depth > _DEEPEST:
        return wrong
    if words[0].upper() == "NOT":
        truth, words = _test(words[1:], defines, depth + 1)
        return not truth, words
    if words[0] == "(":
        truth, words = _either(words[1:], defines, depth + 1)
        return (truth, words[1:]) if words[:1] == [")"] else wrong
    if words[1:2] != ["("] or ")" not in words:
        return wrong
    end = words.index(")")
    inside = words[2:end]
    test = words[0].lower()
    truth = False
    if test in ("defined", "project_defined") and len(inside) == 1:
        truth = inside[0].lower() in defines
    elif test == "hasvalue" and len(inside) == 3:
        truth = defines.get(inside[0].lower()) == inside[2].strip("'")
    return truth, words[end + 1 :]
