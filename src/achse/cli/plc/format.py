"""`achse format` gives PLC sources their layout: indentation, and no blanks at ends of lines."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command(name="format")(format_sources)


def format_sources(
    paths: Annotated[
        list[Path], typer.Argument(help="Source files, or folders of them.", show_default=False)
    ],
    check: Annotated[
        bool, typer.Option("--check", help="Change nothing; exit with 1 if a file would change.")
    ] = False,
) -> None:
    """Indent PLC sources and take blanks at ends of lines away.

    Words, comments and line ends stay, and of XML files all but the code. The table `format`
    of achse.toml says more: `indent`, `keywords`, `operators`.
    """
    from achse.st.files.forms import Content, has_content
    from achse.st.formatting.options import FormatOptionsError, format_options
    from achse.st.formatting.sources import formatted_bytes

    changed = 0
    for file in _files(paths):
        try:
            options = format_options(file.parent)
            data = file.read_bytes()
            formatted = formatted_bytes(data, options, is_xml=not has_content(file, Content.TEXT))
        except FormatOptionsError as failure:
            fail(str(failure), name="INVALID_FILE")
        except OSError as failure:
            fail(f"{file}: {failure.strerror or 'file error'}", name="FILE_ERROR")
        if formatted == data:
            continue
        changed += 1
        if not check:
            write_file(file, formatted)
        print(f"would format {file}" if check else f"formatted {file}")
    if check and changed:
        raise typer.Exit(1)


def _files(paths: list[Path]) -> Iterator[Path]:
    """Return the sources among paths, those in folders in order."""
    from achse.st.files.forms import Content, suffixes_of

    suffixes = suffixes_of(Content.TEXT, Content.ENVELOPE)
    for path in paths:
        if path.is_dir():
            below = (item for item in path.rglob("*") if item.suffix.lower() in suffixes)
            yield from sorted(item for item in below if item.is_file())
        else:
            yield path
