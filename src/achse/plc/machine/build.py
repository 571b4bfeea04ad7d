"""Building the machine code of a project, or taking it from the user's cache.

The cache is keyed by the digest of the project in its memory (`achse.plc.lowering.digest`) and our
own code from the parser to the back end.
"""

import hashlib
from collections.abc import Collection, Mapping
from functools import cache
from pathlib import Path

from achse.native.backend import Effort, ObjectCache, compile_module, identity
from achse.plc.lowering.placement import Placement
from achse.plc.machine.module import ProjectTranslator
from achse.st.typed.project import TypedProject

_NAME = "structured-text"


def machine_code(
    project: TypedProject,
    placement: Placement,
    by_python: Collection[str],
    *,
    exceptions: bool,
    digest: str = "",
    counted: Mapping[str, int] | None = None,
    counters: int = 0,
    conditions: bool = False,
) -> bytes:
    """Return the object file of a project; of one with a digest, what is in the cache will do.
    `counted` has the number of the first of all `counters` for each routine whose statements
    count."""
    cache: ObjectCache | None = None
    if digest:
        of_all = hashlib.blake2b(_own_code(), digest_size=20)
        of_all.update(f"{identity()} {digest}".encode())
        cache = ObjectCache(_NAME, of_all.hexdigest())
        content = cache.load()
        if content is not None:
            return content
    module = ProjectTranslator(
        project,
        placement,
        by_python,
        exceptions=exceptions,
        counted=counted,
        counters=counters,
        conditions=conditions,
    )
    content = compile_module(module.translated(), Effort.FAST)
    if cache is not None:
        cache.save(content)
    return content


@cache
def _own_code() -> bytes:
    """Return a hash of our own part in what comes out: parser, checker, types, front and back
    end."""
    digest = hashlib.blake2b()
    root = Path(__file__).parents[2]
    for room in ("iec", "st", "plc", "native/backend"):
        for file in sorted((root / room).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.digest()
