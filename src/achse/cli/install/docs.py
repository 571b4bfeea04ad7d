"""`achse docs`: the reference pages and the site."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json
from achse.cli.target import Json
from achse.extras import needs_extra

_INSTEAD = {
    "write": "'achse docs' writes the pages",
    "serve": "'achse docs --serve' shows the site",
    "build": "'achse docs --site FOLDER' writes the site",
    "site": "'achse docs --site FOLDER' writes the site",
}
"""Advice for words of actions, by word."""


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(docs)


def docs(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...", help="Only pages with such a word in their title: nc, plc, 10000."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("docs"),
    serve: Annotated[
        bool,
        typer.Option(
            "--serve", help="Show the site at http://host:port; pages that change are built again."
        ),
    ] = False,
    site: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Write the site to a folder.", show_default=False),
    ] = None,
    host: Annotated[str, typer.Option(help="With --serve: address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="With --serve: TCP port.")] = 8000,
    in_json: Json = False,
) -> None:
    """Write the reference pages of all devices and codes, or build the documentation's site.

    MkDocs builds the site from docs/ and the rows, in a clone, with the extra docs.
    """
    if site is not None:
        _mkdocs("build", "--strict", "--quiet", "--site-dir", str(site.absolute()))
        print(site)
    elif serve:
        _mkdocs("serve", "--dev-addr", f"{host}:{port}")
    else:
        for word in words or []:
            if word in _INSTEAD:
                fail(f"docs has no command {word!r}: {_INSTEAD[word]}", name="USAGE")
        _write(words or [], out, in_json)


def _write(words: list[str], out: Path, in_json: bool) -> None:
    """Write the reference pages of the demo station's devices and of all codes."""
    from achse.site.reference import reference_pages
    from achse.station import Station

    pages = list(reference_pages(Station.demo().devices))
    wanted = [page for page in pages if not words or _is_about(page[1], words)]
    if not wanted:
        titles = "; ".join(_title(text) for _, text in pages)
        advice = f"`achse explain {words[0]}` explains codes and names of libraries"
        fail(f"no page about {' or '.join(words)}; {advice}; there are: {titles}")
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


def _title(page: str) -> str:
    return page.partition("\n")[0].removeprefix("# ")


def _is_about(page: str, words: list[str]) -> bool:
    """Return True if a word of the title begins with one of the words."""
    title = _title(page).lower().split()
    return any(part.startswith(word.lower()) for part in title for word in words)
