"""Each option is written once: blocks that several commands share are in `achse.cli.options`."""

import ast
from collections import defaultdict
from pathlib import Path

import achse.cli


def _options() -> dict[str, list[str]]:
    """Return the places of each option or argument of the command line, by its source."""
    folder = Path(achse.cli.__file__).parent
    places = defaultdict(list)
    for file in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in (
                *("typer.Option", "typer.Argument"),
            ):
                places[ast.unparse(node)].append(f"{file.relative_to(folder)}:{node.lineno}")
    return places


def test_no_option_is_written_twice() -> None:
    assert {option: at for option, at in _options().items() if len(at) > 1} == {}
