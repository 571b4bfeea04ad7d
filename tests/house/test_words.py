"""One word, one thing: a public class name is there once; texts are in plain English."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

WORDS = Path("docs/explanation/words.md")
"""The glossary: one word for each thing, and phrases that are not to be used."""

TWICE = {
    "AxisTrace": "the samples of an axis, awaited and blocking (achse.client.nc)",
    "AxisValue": "the same parameter, awaited and blocking",
    "AxisValues": "the same parameters, awaited and blocking",
    "Client": "the same client, awaited and blocking (achse.client, achse.client.blocking)",
    "FunctionBlock": "as a source declares it (st.units) and as it is at run time (iec)",
    "Method": "as a source declares it (st.units) and as clients call it (iec)",
    "Move": "the same command, awaited and blocking",
    "Program": "as a source declares it (st.units) and as it is at run time (iec)",
    "Property": "as a source declares it (st.units) and as clients reach it (iec)",
    "RemoteAxis": "the same axis, awaited and blocking",
    "RemoteNc": "the same NC, awaited and blocking",
    "RemoteTable": "the same table, awaited and blocking",
    "Subscription": "the same subscription, awaited and blocking",
    "Target": "the same device, awaited and blocking",
}
"""Class names that two modules share, because they are the same thing at two levels."""


def _classes(body: Iterable[ast.stmt]) -> Iterator[str]:
    """Public classes and type aliases of a module, those within `if` included."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield node.name
        elif isinstance(node, ast.AnnAssign) and "TypeAlias" in ast.unparse(node.annotation):
            yield ast.unparse(node.target)
        elif isinstance(node, ast.If):
            yield from {*_classes(node.body), *_classes(node.orelse)}


def test_a_class_name_means_one_thing(root: Path, modules: list[Path]) -> None:
    places = defaultdict(list)
    for path in modules:
        for name in _classes(ast.parse((root / path).read_bytes()).body):
            places[name].append(str(path))
    shared = {name: found for name, found in places.items() if len(found) > 1}
    new = {name: found for name, found in shared.items() if name not in TWICE}
    assert not new, f"rename the less central one to the field's word: {new}"
    gone = TWICE.keys() - shared.keys()
    assert not gone, f"no longer shared, take them out of the exceptions: {gone}"


PHRASES = {
    "is not a … (are not …)": re.compile(
        r"(?<!there )(?<!there will )\b(?:is|are|was|were|be) no\b(?! (?:longer|more|better)\b)",
        re.IGNORECASE,
    ),
    "again": re.compile(r"\banew\b", re.IGNORECASE),
    "any client that, anyone who": re.compile(r"\bwhoever\b", re.IGNORECASE),
    "later": re.compile(r"\bby and by\b", re.IGNORECASE),
    "none": re.compile(r"\bnone such\b", re.IGNORECASE),
    "say who does what": re.compile(r"\b(?:of whom|what nothing)\b", re.IGNORECASE),
    "postpone": re.compile(r"\b(?:owes?|owed|owing)\b", re.IGNORECASE),
    "is at, is in": re.compile(
        r"\b(?:stands?|stood|lies?|lay) "
        r"(?:at|in(?! for\b)|on|before|behind|beside|there|here|under|after|above|between|with)\b",
        re.IGNORECASE,
    ),
}
"""What to write, and what not to write instead."""

VERBS = {
    "succeed": "inherit", "give": "load", "owe": "postpone", "part": "leave",
    "begin_anew": "begin_again",
}  # fmt: skip
"""Names of public functions that are not the field's verbs, and what to write."""

ROOMS_TO_MEND: dict[str, int] = {}
"""Phrases that are still there, by room. The numbers only shrink."""


def _texts(root: Path, path: Path) -> Iterator[str]:
    """The paragraphs of a page; the string literals of a module, docstrings among them."""
    source = (root / path).read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield from re.split(r"\n\s*\n", source)
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def _room(path: Path) -> str:
    """`docs/how-to`, `src/achse/st`; the root's pages by name."""
    return "/".join(path.parts[:-1][:3]) or str(path)


def test_texts_are_in_plain_english(root: Path, tracked: list[Path]) -> None:
    found = defaultdict(list)
    for path in tracked:
        read = path.suffix == ".md" or (path.parts[0] == "src" and path.suffix == ".py")
        if not read or path == WORDS:
            continue
        for text in _texts(root, path):
            line = " ".join(text.split())
            for instead, phrase in PHRASES.items():
                for hit in phrase.finditer(line):
                    around = line[max(0, hit.start() - 30) : hit.end() + 30]
                    found[_room(path)].append(f"{path}: …{around}… (write: {instead})")
    more = [
        line
        for room, lines in found.items()
        if len(lines) > ROOMS_TO_MEND.get(room, 0)
        for line in lines
    ]
    assert not more, "\n".join(more)
    mended = ROOMS_TO_MEND.keys() - found.keys()
    assert not mended, f"nothing left there, take them out of ROOMS_TO_MEND: {mended}"


def test_public_functions_have_the_verbs_of_the_field(root: Path, modules: list[Path]) -> None:
    found = [
        f"{path}:{node.lineno}: {node.name} (write: {VERBS[node.name]})"
        for path in modules
        for node in ast.walk(ast.parse((root / path).read_bytes()))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and node.name in VERBS
        and (node.name != "part" or len(node.args.args) < 2)  # a part of something is a noun
    ]
    assert not found, "\n".join(found)


def test_words_are_listed_once(root: Path) -> None:
    """Each word of the glossary has one row, and its class, where it names one, is there."""
    page = (root / WORDS).read_text(encoding="utf-8")
    words = [row.split("|")[1].strip() for row in page.splitlines() if row.startswith("| ")]
    words = [word for word in words if word not in {"word", "we say", "---"}]
    assert len(words) == len(set(words))
    assert str(WORDS) in (root / "README.md").read_text(encoding="utf-8")
