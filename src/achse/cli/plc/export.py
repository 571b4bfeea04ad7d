"""`achse plc export` writes the sources of a PLC project as PLCopen XML."""

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.options import Sources
from achse.cli.output import print_json
from achse.cli.target import Json


def export(
    sources: Sources,
    to: Annotated[
        Path, typer.Argument(metavar="FILE.xml", help="The file to write.", show_default=False)
    ],
    in_json: Json = False,
) -> None:
    """Write the sources of a PLC project as PLCopen XML (TC6), which other editors import.

    Bodies that are drawn are left out and named; their units keep their variables. Files that have
    one text for everything (.st, .EXP) lose the comments between their statements. The time in the
    document is that of the newest source.
    """
    from achse.st.files.files import read_sources
    from achse.st.files.plcopen.documents import is_plcopen
    from achse.st.files.plcopen.writer import plcopen_document
    from achse.st.lexis.source import Diagnostic, SourceError

    faults: list[Diagnostic] = []
    try:
        units, tasks = read_sources(sources, (), faults)
        faults += (fault for parsed in units for fault in parsed.faults)
        if faults:
            raise SourceError(faults)
    except SourceError as error:
        fail(str(error))
    if to.suffix.lower() != ".xml":
        fail(f"expected a name like plc.xml, got {to}")
    changed = max((os.path.getmtime(parsed.source.file) for parsed in units), default=0.0)
    created = datetime.fromtimestamp(changed, UTC).strftime("%Y-%m-%dT%H:%M:%S")
    document = plcopen_document(units, tasks, sources.stem, created)
    write_file(to, document.text.encode(), is_plcopen, "PLCopen XML")
    if in_json:
        print_json({"file": str(to), "left_out": document.left_out})
        return
    for name in document.left_out:
        print(f"left out: the body of {name}, which is not text")
    print(f"{to}: {len(units)} sources, {len(tasks)} tasks")
