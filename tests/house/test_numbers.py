"""A number that has a name is written by its name: no row's or member's number stands bare."""

import io
import re
import tokenize
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest

from achse.codes import NcError, PlcGroup, ReservedGroup, ReturnCode
from achse.ethercat.registers import Register
from tests.house.sources import Texts

HOMES = (Path("src/achse/codes"), Path("src/achse/ethercat/registers.py"))
"""Where names get their numbers."""

NAMES: dict[str, tuple[Iterable[int], tuple[str, ...]]] = {
    "index groups": ([*ReservedGroup, *PlcGroup], ("src/achse",)),
    "return codes": (
        [code.number for code in ReturnCode if 0x700 <= code.number < 0x800],
        (
            *("src/achse/ams", "src/achse/client", "src/achse/cli", "src/achse/devices/plc"),
            *("src/achse/devices/system", "src/achse/faults", "src/achse/monitor"),
            *("src/achse/router", "src/achse/server", "src/achse/station", "src/achse/transport"),
        ),
    ),
    # a round number is an index group
    "NC errors": (
        [each for each in NcError if each % 0x100],
        ("src/achse/devices/nc", "src/achse/motion"),
    ),
    "registers": (
        [each for each in Register if each >= 0x100],
        ("src/achse/ethercat", "src/achse/testing/reach.py"),
    ),
}
"""What has names, and where its numbers mean nothing else."""

BARE: dict[str, set[str]] = {
    "src/achse/devices/io/master_objects.py": {"0xF020", "0xF040"},  # objects of a dictionary
    "src/achse/ethercat/application.py": {"0x0100", "0x0200"},  # bits of an object's access
    "src/achse/ethercat/description.py": {"0x0300"},  # AssignActivate: a word, no address
    "src/achse/ethercat/master/configuration.py": {"0x0300"},  # the same
    "src/achse/ethercat/loopback.py": {"0x100"},  # a step of indices
    "src/achse/ethercat/pdi.py": {"0x100"},  # a bit of the AL events
}
"""Numbers that may stand bare in a file, because they mean something else there."""


HEXADECIMAL = re.compile(r"0[xX][0-9a-fA-F]+(?:_[0-9a-fA-F]+)*")


@cache
def _hexadecimal(source: str) -> frozenset[str]:
    """Numbers of a text, those in its comments and strings too: tokens are dear."""
    return frozenset(HEXADECIMAL.findall(source))


def _bare(source: str, path: Path, numbers: set[int]) -> list[str]:
    """Hexadecimal numbers of a file that are among `numbers`, each with its line."""
    if not any(int(number, 16) in numbers for number in _hexadecimal(source)):
        return []
    with io.StringIO(source) as text:
        return [
            f"{path}:{token.start[0]}: {token.string}"
            for token in tokenize.generate_tokens(text.readline)
            if token.type == tokenize.NUMBER
            and token.string[:2].lower() == "0x"
            and int(token.string, 16) in numbers
            and token.string not in BARE.get(str(path), ())
        ]


@pytest.mark.parametrize("kind", NAMES)
def test_numbers_with_a_name_are_written_by_name(
    kind: str, texts: Texts, modules: list[Path]
) -> None:
    members, rooms = NAMES[kind]
    numbers = {int(member) for member in members}
    bare = [
        each
        for path in modules
        if str(path).startswith(rooms) and not {path, *path.parents} & {*HOMES}
        for each in _bare(texts[path], path, numbers)
    ]
    assert not bare, "\n".join(bare)


ALIAS = re.compile(r"^_[A-Z_0-9]+ = [A-Z]\w+\.[A-Z_0-9]+\.value$", re.MULTILINE)


def test_members_have_no_second_name(texts: Texts, modules: list[Path]) -> None:
    """Kernels name members of enumerations; plain Python pays nothing for it."""
    aliases = [f"{path}: {line}" for path in modules for line in ALIAS.findall(texts[path])]
    assert not aliases, "\n".join(aliases)


def test_the_exceptions_are_needed(root: Path, modules: list[Path]) -> None:
    for name, allowed in BARE.items():
        assert Path(name) in modules
        assert all(number in (root / name).read_text(encoding="utf-8") for number in allowed)
