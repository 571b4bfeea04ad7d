"""One word, one thing: a public class name is there once; texts are in plain English."""

import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

TWICE = {
    "Client": "the same client, awaited and blocking (achse.client, achse.client.blocking)",
    "FunctionBlock": "as a source declares it (st.units) and as it is at run time (iec)",
    "Method": "as a source declares it (st.units) and as clients call it (iec)",
    "Program": "as a source declares it (st.units) and as it is at run time (iec)",
    "Property": "as a source declares it (st.units) and as clients reach it (iec)",
    "Subscription": "the same subscription, awaited and blocking",
    "Target": "the same device, awaited and blocking",
}
"""Class names that two modules share, because they are the same thing at two levels."""

UNTIL_RENAMED = {"AxisParameters", "Member", "Memory"}
"""Class names of `motion` and `devices.nc` that still mean two things. This set only shrinks."""


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
    new = {name: found for name, found in shared.items() if name not in {*TWICE, *UNTIL_RENAMED}}
    assert not new, f"rename the less central one to the field's word: {new}"
    gone = {*TWICE, *UNTIL_RENAMED} - shared.keys()
    assert not gone, f"no longer shared, take them out of the exceptions: {gone}"
