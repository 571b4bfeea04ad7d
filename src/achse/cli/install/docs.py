"""`achse docs`: the reference pages, the site, one entry."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json
from achse.cli.target import Json
from achse.extras import needs_extra

__all__ = ["register"]


class Docs(TyperGroup):
    """`achse docs` and `achse docs nc` write pages, as `achse docs write nc` does."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ("-h", "--help")):
            args = ["write", *args]
        return super().parse_args(ctx, args)


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    group = typer.Typer(cls=Docs, help="The documentation: reference pages, the site, one entry.")
    group.command()(write)
    for command in (serve, entry):
        group.command()(command)
    app.add_typer(group, name="docs")


def write(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...", help="Only pages with such a word in their title: nc, plc, 10000."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("docs"),
    in_json: Json = False,
) -> None:
    """Write the reference pages of the demo station's devices and of all codes."""
    from achse.site.reference import reference_pages
    from achse.station import Station

    pages = list(reference_pages(Station.demo().devices))
    wanted = [page for page in pages if not words or _is_about(page[1], words)]
    if not wanted:
        titles = "; ".join(_title(text) for _, text in pages)
        fail(f"no page about {' or '.join(words or ())}; there are: {titles}")
    for name, text in wanted:
        page = out / name
        try:
            page.parent.mkdir(parents=True, exist_ok=True)
        except OSError as failure:
            fail(f"{page.parent}: {failure.strerror}", name="CANNOT_WRITE")
        write_file(page, text.encode())
        if not in_json:
            print(page)
    if in_json:
        print_json([{"file": str(out / name), "title": _title(text)} for name, text in wanted])


def serve(
    host: Annotated[str, typer.Option(help="Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="TCP port.")] = 8000,
    build: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Write the site to a folder instead.", show_default=False
        ),
    ] = None,
) -> None:
    """Build the site from docs/ and the rows, and show it in a browser at http://host:port.

    MkDocs does it, in a clone, with the extra docs; pages that change are built again.
    """
    if build is not None:
        _mkdocs("build", "--strict", "--quiet", "--site-dir", str(build.absolute()))
        print(build)
    else:
        _mkdocs("serve", "--dev-addr", f"{host}:{port}")


def _mkdocs(*words: str) -> None:
    """Run MkDocs here; ends the command if it cannot."""
    if importlib.util.find_spec("mkdocs") is None:
        fail(needs_extra("the site", "docs"), name="NO_EXTRA")
    if not Path("mkdocs.yml").is_file():
        fail("no mkdocs.yml here: the site is built in a clone of the repository", name="NO_FILE")
    command = [sys.executable, "-m", "mkdocs", *words]
    ended = subprocess.run(command, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, check=False)
    if ended.returncode:
        fail(f"MkDocs ended with {ended.returncode}", name="FAILED")


def entry(
    code: Annotated[
        str,
        typer.Argument(metavar="ENTRY", help="A code or a name: 0x4655, 1861, MC_MoveAbsolute."),
    ],
    in_json: Json = False,
) -> None:
    """Show what a code or a name of a PLC library means, and where it is documented.

    With ACHSE_DOCS, the address of a site, it is a whole link.
    """
    from achse.codes import code_of
    from achse.codes.links import SITE, code_link, on_site
    from achse.codes.remedies import remedy_of

    try:
        number = int(code, 0)
    except ValueError:
        _library_entry(code, in_json)
        return
    link = code_link(number)
    found = code_of(number)
    if link is None or found is None:
        fail(f"no table has the code 0x{number:X}", name="NOT_FOUND")
    link = on_site(link, os.environ.get(SITE)) or link
    remedy = remedy_of(number)
    if in_json:
        shown = {"code": number, "name": found.name, "text": found.text, "remedy": remedy or None}
        print_json(shown | {"link": link})
    else:
        print(f"0x{number:X}  {found.name}  {found.text}")
        if remedy:
            print(f"remedy: {remedy}")
        print(link)


def _library_entry(name: str, in_json: bool) -> None:
    """Print what a name of a PLC library is."""
    from achse.codes.links import SITE, library_link, on_site
    from achse.iec.nearest import did_you_mean
    from achse.site.reference import library_rows

    found = {
        row[0].strip("`"): (library, row)
        for library, rows in library_rows().items()
        for row in rows
    }
    spelled = {known.casefold(): known for known in found}.get(name.casefold())
    if spelled is None:
        near = did_you_mean(name, found)
        fail(
            f"expected a code such as 0x4655, or a name of a PLC library, got {name!r:.40}{near}",
            name="NOT_FOUND",
        )
    library, (_, kind, meaning, inputs, outputs) = found[spelled]
    link = library_link(library, spelled)
    link = on_site(link, os.environ.get(SITE)) or link
    if in_json:
        document = {"name": spelled, "library": library, "kind": kind, "text": meaning}
        print_json(document | {"inputs": inputs, "outputs": outputs, "link": link})
        return
    print(f"{spelled}  {kind} of {library}  {meaning}".rstrip())
    for title, pins in (("inputs", inputs), ("outputs", outputs)):
        if pins:
            print(f"{title}: {pins}")
    print(link)


def _title(page: str) -> str:
    return page.partition("\n")[0].removeprefix("# ")


def _is_about(page: str, words: list[str]) -> bool:
    """Return True if a word of the title begins with one of the words."""
    title = _title(page).lower().split()
    return any(part.startswith(word.lower()) for part in title for word in words)
