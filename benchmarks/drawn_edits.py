"""Drawn edits of a project, each with the findings of a cold check: errors, warnings and lint.

The project is copied; without a folder it is made up, of that many sources. Drawn are bodies,
declarations, signatures, names of units, members, whole files, references of libraries, syntax that
is broken and parts of the XML. Edits pile up until three files are other than at first, so that
findings come and go. Printed are the kinds, how far each edit reached, and the processor time of
the warm and of the cold checks. With EVERY only each so many edits are compared. Ends with 1 if one
has other findings than the cold check; the same SEED draws the same edits again.
Usage: python benchmarks/drawn_edits.py [SOURCES|FOLDER] [EDITS] [SEED] [EVERY]
"""

import random
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from weakref import WeakValueDictionary

from language_server import write_project

from achse.plc.system_info import lists_of_runtime
from achse.st.check import check
from achse.st.files.forms import Content, suffixes_of
from achse.st.files.reading import file_key, reading
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.lint.linting import lint
from achse.st.lint.options import LintOptions
from achse.st.project import read_files
from achse.st.workspace import ProjectFindings, Workspace, findings_of
from achse.st.workspace.findings import sorted_findings

_CODE = re.compile(r"<ST><!\[CDATA\[(.*?)\]\]></ST>", re.DOTALL)
_DECLARATION = re.compile(r"<Declaration><!\[CDATA\[(.*?)\]\]>", re.DOTALL)
_VARIABLE = re.compile(
    r"^[ \t]*(\w+)[ \t]*(?:,[ \t\w,]*)?:[ \t]*([^;:=\n]+)[^;\n]*;.*$", re.MULTILINE
)
_HEADER = re.compile(r"^[ \t]*(?:METHOD|PROPERTY|FUNCTION)\b[^\n]*$", re.MULTILINE)
_UNIT = re.compile(r"\b(?:FUNCTION_BLOCK|FUNCTION|PROGRAM|INTERFACE|TYPE)\s+(?:\w+\s+)*?(\w+)")
_PART = re.compile(r"<(Method|Property|Action|Get|Set)\b[^>]*>.*?</\1>\s*", re.DOTALL)
_TAG = re.compile(r"</?[A-Za-z][^>]*>|\]\]>|<!\[CDATA\[")
_REFERENCE = re.compile(r"<(PlaceholderReference|LibraryReference)\b.*?</\1>\s*", re.DOTALL)
_WORD = re.compile(r"\b[A-Za-z_]\w*\b")
_TYPES = ("INT", "BOOL", "LREAL", "STRING(20)", "DINT", "TIME", "POINTER TO BYTE", "T_Nothing")
_SECTIONS = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_STAT", "VAR CONSTANT")
_FACETS = ("ABSTRACT ", "PRIVATE ", "FINAL ", "PROTECTED ", "INTERNAL ", "")
_TOKENS = (
    ";",
    "(",
    ")",
    ":=",
    "END_IF;",
    "END_VAR",
    "(*",
    "'",
    ".",
    "^",
    "IF TRUE THEN",
    "VAR",
    "1",
)
_SOURCES = suffixes_of(Content.TEXT, Content.ENVELOPE)
_NEW = """<TcPlcObject><POU Name="{name}"><Declaration><![CDATA[FUNCTION_BLOCK {name}{base}
VAR_INPUT
    nNew : INT;
END_VAR]]></Declaration><Implementation><ST><![CDATA[nNew := nNew + {word};]]></ST></Implementation>
</POU></TcPlcObject>
"""

Drawing = Callable[[str, random.Random], str]


def _spliced(text: str, span: tuple[int, int], new: str) -> str:
    return text[: span[0]] + new + text[span[1] :]


def _inside(text: str, parts: re.Pattern[str], draw: random.Random) -> tuple[int, int]:
    spans = [one.span(1) for one in parts.finditer(text)]
    return draw.choice(spans) if spans else (0, len(text))


def _word_in(text: str, parts: re.Pattern[str], draw: random.Random) -> str:
    """Put a word of the file in the place of another."""
    first, last = _inside(text, parts, draw)
    places = list(_WORD.finditer(text, first, last))
    if not places:
        return _spliced(text, (last, last), " nothing_here;")
    new = draw.choice(_WORD.findall(text))
    return _spliced(text, draw.choice(places).span(), new)


def body(text: str, draw: random.Random) -> str:
    """Change a word or a line of a body."""
    if draw.random() < 0.5:
        return _word_in(text, _CODE, draw)
    first, last = _inside(text, _CODE, draw)
    lines = text[first:last].split("\n")
    lines.insert(draw.randrange(len(lines) + 1), draw.choice(lines))
    return _spliced(text, (first, last), "\n".join(lines))


def declaration(text: str, draw: random.Random) -> str:
    """Change, add, rename, double or remove a variable, or its section."""
    variables = list(_VARIABLE.finditer(text))
    if not variables:
        return _word_in(text, _DECLARATION, draw)
    one, other = draw.choice(variables), draw.choice(variables)
    match draw.randrange(6):
        case 0:
            return _spliced(text, one.span(2), draw.choice((*_TYPES, other[2])))
        case 1:
            return _spliced(text, one.span(1), draw.choice((f"{one[1]}X", other[1])))
        case 2:
            return _spliced(text, one.span(), "")
        case 3:
            return _spliced(text, (one.end(), one.end()), f"\n    {other[1]}2 : {other[2]};")
        case 4:
            return _spliced(text, (one.end(), one.end()), f"\n{other[0]}")
    place = text.rfind("VAR", 0, one.start())
    end = text.find("\n", place)
    return text if place < 0 else _spliced(text, (place, end), draw.choice(_SECTIONS))


def signature(text: str, draw: random.Random) -> str:
    """Change the first line of a routine: its name, its result, or who may call it."""
    headers = list(_HEADER.finditer(text))
    if not headers:
        return declaration(text, draw)
    one = draw.choice(headers)
    words = one[0].split(":", 1)
    match draw.randrange(4):
        case 0:
            new = f"{words[0]}: {draw.choice(_TYPES)}"
        case 1:
            new = words[0]
        case 2:
            kind, _, rest = one[0].strip().partition(" ")
            new = f"{kind} {draw.choice(_FACETS)}{rest}"
        case _:
            new = one[0].replace(_WORD.findall(one[0])[-1], "Other")
    return _spliced(text, one.span(), new)


def unit_name(text: str, draw: random.Random) -> str:
    """Rename a unit where it is declared, or change what it extends."""
    units = list(_UNIT.finditer(text))
    if not units:
        return _word_in(text, _DECLARATION, draw)
    one = draw.choice(units)
    if draw.random() < 0.5:
        return _spliced(text, one.span(1), f"{one[1]}X")
    base = draw.choice(_WORD.findall(text))
    return _spliced(
        text, (one.end(), one.end()), draw.choice((f" EXTENDS {base}", f" IMPLEMENTS {base}"))
    )


def member(text: str, draw: random.Random) -> str:
    """Change, take away or add members of a type, a value or a bound."""
    numbers = list(re.finditer(r"\b\d+\b", text))
    commas = list(re.finditer(r"(\w+)(?:\s*:=\s*[\w#]+)?\s*,", text))
    if commas and draw.random() < 0.6:
        one = draw.choice(commas)
        return _spliced(
            text, one.span(), draw.choice(("", f"{one[1]}X,", f"{one[0]} New_{one[1]},"))
        )
    if numbers:
        return _spliced(text, draw.choice(numbers).span(), str(draw.randrange(5)))
    return declaration(text, draw)


def broken(text: str, draw: random.Random) -> str:
    """Take characters of the code away, or put a token where none belongs."""
    first, last = _inside(text, draw.choice((_CODE, _DECLARATION)), draw)
    at = draw.randint(first, last)
    if draw.random() < 0.5:
        return _spliced(text, (at, min(at + draw.choice((1, 2, 8)), last)), "")
    return _spliced(text, (at, at), f" {draw.choice(_TOKENS)} ")


def part(text: str, draw: random.Random) -> str:
    """Take a part of the XML away, double it, or break a tag."""
    parts = list(_PART.finditer(text))
    if parts and draw.random() < 0.7:
        one = draw.choice(parts)
        return _spliced(text, one.span(), one[0] * 2 if draw.random() < 0.3 else "")
    tags = list(_TAG.finditer(text))
    return _spliced(text, draw.choice(tags).span(), "") if tags else broken(text, draw)


_KINDS: dict[str, tuple[int, Drawing]] = {
    "body": (16, body),
    "declaration": (24, declaration),
    "signature": (12, signature),
    "unit": (8, unit_name),
    "member": (12, member),
    "syntax": (12, broken),
    "xml": (6, part),
}


class DrawnProject:
    """A project whose files an editor has, with drawn edits."""

    def __init__(self, root: Path, draw: random.Random) -> None:
        self.root, self._draw = root, draw
        projects = sorted(root.rglob("*.plcproj"))
        self.place = projects[0] if len(projects) == 1 else root
        self.files = sorted(f for f in root.rglob("*") if f.suffix.lower() in _SOURCES)
        self._firsts: dict[Path, bytes | None] = {file: file.read_bytes() for file in self.files}
        self._listing = self.place.read_bytes() if self.place.is_file() else b""
        self.texts: dict[Path, bytes] = {}
        """Contents of open files."""
        self._moved: list[Path] = []
        self._is_listing_changed = False

    def edit(self, workspace: Workspace) -> tuple[str, str]:
        """Make an edit in the workspace; return its kind, and how far it reached."""
        draw = self._draw
        changed = len(self.texts) + len(self._moved) + self._is_listing_changed
        if changed > 2 or (changed and draw.random() < 0.25):
            return "back", self._go_back(workspace)
        chance = draw.random()
        if chance < 0.04:
            return "file", self._move_file(workspace)
        if chance < 0.06 and self._listing:
            return "library", self._change_references(workspace)
        kinds = list(_KINDS)
        (kind,) = draw.choices(kinds, [_KINDS[one][0] for one in kinds])
        file = draw.choice([one for one in self.files if one.is_file()])
        before = self.texts.get(file, file.read_bytes())
        after = before
        while after == before:
            after = _KINDS[kind][1](before.decode("utf-8-sig"), draw).encode()
        self.texts[file] = after
        return kind, workspace.edit(file, after).value

    def _go_back(self, workspace: Workspace) -> str:
        if self._is_listing_changed:
            self._is_listing_changed = False
            self.place.write_bytes(self._listing)
            return workspace.reread(self.place).value
        if self._moved:
            file = self._moved.pop()
            first = self._firsts[file]
            if first is None:
                file.unlink(missing_ok=True)
            else:
                file.write_bytes(first)
            return workspace.reread(file).value
        file = self._draw.choice(sorted(self.texts))
        del self.texts[file]
        return workspace.close(file).value

    def _move_file(self, workspace: Workspace) -> str:
        draw = self._draw
        file = draw.choice([one for one in self.files if one.is_file() and one not in self.texts])
        if draw.random() < 0.5:
            file.unlink()
        else:
            word = draw.choice(_WORD.findall(file.read_text("utf-8-sig")))
            base = draw.choice(("", f" EXTENDS {file.stem}"))
            name = draw.choice(("FB_Drawn", word, file.stem))
            file = file.with_name(f"Drawn{draw.randrange(99)}.TcPOU")
            self._firsts[file] = None
            file.write_text(_NEW.format(name=name, base=base, word=word))
        self._moved.append(file)
        return workspace.reread(file).value

    def _change_references(self, workspace: Workspace) -> str:
        text = self._listing.decode("utf-8-sig")
        references = list(_REFERENCE.finditer(text))
        if references:
            text = _spliced(text, self._draw.choice(references).span(), "")
        self.place.write_text(text, "utf-8")
        self._is_listing_changed = True
        return workspace.reread(self.place).value


class ColdCheck:
    """Checks that begin with nothing but parsed files."""

    def __init__(self, place: Path) -> None:
        self._place = place
        self._trees: WeakValueDictionary[tuple[object, ...], object] = WeakValueDictionary()
        self._sources: object = None

    def findings(
        self, texts: dict[Path, bytes], *, linted: bool
    ) -> tuple[ProjectFindings, list[Diagnostic] | None]:
        """Return what is found with these texts of open files, and by the linter if `linted`."""
        contents = {file_key(file): text for file, text in texts.items()}
        try:
            with reading(contents, self._trees):
                files = read_files(self._place)
                project, error = files.examined(None, None, "libraries", None, check_all=False)
        except SourceError as nothing:
            return sorted_findings(nothing.faults, (), ()), [] if linted else None
        self._sources = project.sources
        typed = check(
            project.declarations,
            predefined=lists_of_runtime(files.tasks),
            reach=project.reach,
            unreached=project.unreached,
        )
        findings = findings_of(project, error, typed)
        if not linted:
            return findings, None
        rules = LintOptions().with_all()
        return findings, list(lint(project.sources, project.declarations, typed, rules))


def compare(root: Path, edits: int, seed: int, every: int) -> int:
    """Draw edits of a project; return how many have other findings than a cold check."""
    draw = random.Random(seed)
    project = DrawnProject(root, draw)
    workspace = Workspace(
        project.place, predefined=lists_of_runtime, lint_rules=lambda _: LintOptions().with_all()
    )
    cold = ColdCheck(project.place)
    kinds, reaches = Counter[str](), Counter[str]()
    warm_seconds = cold_seconds = 0.0
    compared = differing = 0
    for number in range(edits):
        start = time.process_time()
        kind, reach = project.edit(workspace)
        linted = number % (8 * every) == 0
        lint_findings = list(workspace.lint()) if linted else None
        middle = time.process_time()
        warm_seconds += middle - start
        kinds[kind] += 1
        reaches[reach] += 1
        if number % every:
            continue
        expected = cold.findings(project.texts, linted=linted)
        cold_seconds += time.process_time() - middle
        compared += 1
        if number % 100 == 0:
            print(f"  {number + 1} edits, {differing} differ", flush=True)
        if (workspace.findings, lint_findings) != expected:
            differing += 1
            print(f"edit {number}, {kind}, reached {reach}: other findings than a cold check")
            _show(workspace.findings, expected[0])
            workspace.load()
    print(f"{edits} edits: {dict(kinds)}")
    print(f"reached: {dict(reaches)}")
    print(f"processor: {warm_seconds:.1f} s warm, {cold_seconds:.1f} s cold")
    print(f"{compared} compared, {differing} with other findings than a cold check")
    return differing


def _show(got: ProjectFindings, expected: ProjectFindings) -> None:
    for name in got._fields:
        ours, theirs = set(getattr(got, name)), set(getattr(expected, name))
        for sign, ones in (("+", ours - theirs), ("-", theirs - ours)):
            for one in list(ones)[:4]:
                print(f"  {sign} {name} {one.location}: {one.message}")


def main() -> int:
    """Compare drawn edits of a made-up project, or of a copy of the user's."""
    project = sys.argv[1] if len(sys.argv) > 1 else "800"
    edits = int(sys.argv[2]) if len(sys.argv) > 2 else 1_000
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 7
    every = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve() / "project"
        if project.isdigit():
            root.mkdir()
            write_project(root, int(project))
        else:
            shutil.copytree(project, root)
        print(f"{project}, seed {seed}")
        return bool(compare(root, edits, seed, every))


if __name__ == "__main__":
    sys.exit(main())
