"""Hooks of MkDocs (see mkdocs.yml): the front page, links within the repository, anchors, pictures.

- README, CHANGELOG and their neighbours (`PAGES`) and the pages of examples/ are pages of the site
  too; links to files that are not pages become their names.
- The order of pages is made of README's list (`achse.site.navigation`), and `llms.txt` of that.
- Each row of a reference page has an anchor: its code (`0x4655`), its index group and offset
  (`0x4101-0xA`), or its name (`MC_Power`): see `achse.codes.links`.
- Pages of reference/ and the coverage of the NC are made now, from the rows
  (`achse.site.reference`); what `achse docs` has written into docs/ gives way to them.
- Each error code gets a page of its own when the others are built (`achse.site.code_pages`).
- Pictures are made now, in virtual time (`achse.site.pictures`), and stand where a page has
  `<!-- picture: NAME -->`.

Needs the extra `docs`.
"""

import posixpath
import re
from functools import cache
from pathlib import Path
from typing import Any

from achse.site.code_pages import write_code_pages
from achse.site.navigation import navigation, overview
from achse.site.pictures import MOVING, PICTURES, TEXTS

ROOT = Path(__file__).parents[3]

PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "SUPPORT.md": "support.md",
    "GOVERNANCE.md": "governance.md",
    "CODE_OF_CONDUCT.md": "conduct.md",
}
"""Files of the repository that are pages, and their places in the site."""

_LINK = re.compile(r"(?<!!)\[([^\]]*)\]\((?![a-z]+:|#)([^)#\s]+)(#[^)]*)?\)")
_PICTURE = re.compile(r"<!-- picture: (\w+) -->")
_FENCE = re.compile(r"^(```.*?^```$)", re.MULTILINE | re.DOTALL)
_HEX = re.compile(r"(0x[0-9A-Fa-f]+)( … 0x[0-9A-Fa-f]+)?")
_NAME = re.compile(r"`(\w+)`")


@cache
def _pages() -> dict[str, str]:
    """Return the pages outside docs/: place in the site by path in the repository."""
    examples = {
        str(path.relative_to(ROOT)): str(path.relative_to(ROOT))
        for path in sorted((ROOT / "examples").rglob("*.md"))
    }
    return PAGES | examples


@cache
def generated_pages() -> dict[str, str]:
    """Return the text of each page that is made from the rows, by its place in the site."""
    from achse.site.reference import reference_pages
    from achse.station import Station

    return dict(reference_pages(Station.demo().devices))


def on_files(files: Any, *, config: Any) -> Any:
    """Add pages from outside docs/, those made from the rows, and pictures; put all in order."""
    from mkdocs.structure.files import File

    for path, uri in _pages().items():
        text = (ROOT / path).read_text(encoding="utf-8")
        files.append(File.generated(config, uri, content=text))
    for uri, text in generated_pages().items():
        written = files.get_file_from_path(uri)
        if written is not None:
            files.remove(written)
        files.append(File.generated(config, uri, content=text))
    for name in ("pages.css", "pages.js"):
        text = Path(__file__).with_name(name).read_text(encoding="utf-8")
        files.append(File.generated(config, f"assets/{name}", content=text))
    for name, make in PICTURES.items():
        files.append(File.generated(config, f"pictures/{name}.svg", content=make()))
    texts = {file.src_uri: file.content_string for file in files.documentation_pages()}
    config.nav = navigation((ROOT / "README.md").read_text(encoding="utf-8"), texts)
    files.append(File.generated(config, "llms.txt", content=overview(config.nav, texts)))
    return files


def on_page_markdown(markdown: str, *, page: Any, config: Any, files: Any) -> str:
    """Return the text of a page as the site shows it."""
    uri = page.file.src_uri
    known = {file.src_uri for file in files}
    if uri.startswith("reference/"):
        markdown = "".join(anchored(line) for line in markdown.splitlines(keepends=True))
    parts = _FENCE.split(markdown)
    parts[::2] = [relinked(part, uri, known) for part in parts[::2]]
    return "".join(parts)


def on_post_page(output: str, *, page: Any, config: Any) -> str:
    """Give the search, a dialogue, the name that the theme leaves out."""
    return output.replace('role="dialog">', 'role="dialog" aria-label="Search">')


def on_post_build(*, config: Any) -> None:
    """Add the pages of error codes to the site that was built."""
    write_code_pages(Path(config.site_dir))


def relinked(text: str, uri: str, known: set[str]) -> str:
    """Links of a page at `uri` to files of the repository lead to the pages of the site."""
    pages = _pages()
    here = next((path for path, place in pages.items() if place == uri), f"docs/{uri}")

    def link(match: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join(posixpath.dirname(here), match[2]))
        target = pages.get(path, path.removeprefix("docs/"))
        if target not in known:
            return match[1]
        way = posixpath.relpath(target, posixpath.dirname(uri) or ".")
        return f"[{match[1]}]({way}{match[3] or ''})"

    def picture(match: re.Match[str]) -> str:
        way = posixpath.relpath(f"pictures/{match[1]}.svg", posixpath.dirname(uri) or ".")
        shown = f"![{TEXTS.get(match[1], match[1])}]({way})"
        if match[1] in MOVING:  # the style sheet shows one of the two
            still = way.removesuffix(".svg") + "_still.svg"
            shown += f"{{ .moving }}![{TEXTS[match[1]]}]({still}){{ .still }}"
        return shown

    return _PICTURE.sub(picture, _LINK.sub(link, text))


def anchored(line: str) -> str:
    """Return a row of a reference page with its anchor; other lines as they are."""
    if not line.startswith("| "):
        return line
    cells = [cell.strip() for cell in line[2:].split(" | ")]
    code = _HEX.fullmatch(cells[0])
    offset = _HEX.fullmatch(cells[1]) if len(cells) > 1 else None
    if code and offset:
        name = f"0x{int(code[1], 16):X}-0x{int(offset[1], 16):X}"
    elif code:
        name = f"0x{int(code[1], 16):X}"
    elif named := _NAME.fullmatch(cells[0]):
        name = named[1]
    else:
        return line
    return f'| <a id="{name}"></a>{line[2:]}'
