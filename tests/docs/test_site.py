"""The documentation as a site: it builds without a warning, and each row has its anchor there."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from achse.codes import NcError, ReturnCode
from achse.codes.links import code_link, library_link, service_link
from achse.site.code_pages import code_pages
from achse.site.hooks import generated_pages
from achse.site.moving import CAST_FILE
from achse.st.declared.standard import standard_libraries
from achse.st.syntax.units import Function, FunctionBlock
from achse.station import Station

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mkdocs", reason="needs the extra docs")
    out = tmp_path_factory.mktemp("site")
    cast = out.with_name("demo.cast")
    cast.write_text('{"version": 2}\n[0.1, "o", "$ achse axis move X --to 100\\r\\n"]\n')
    built = subprocess.run(
        [sys.executable, "-m", "achse", "docs", "--site", str(out)],
        cwd=ROOT,
        env={**os.environ, "PYTHONWARNINGS": "ignore", CAST_FILE: str(cast)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    return out


def test_it_is_whole_and_queries_no_other_host(site: Path) -> None:
    assert "A motion station you can pip-install" in (site / "index.html").read_text()
    assert (site / "search" / "search_index.json").stat().st_size > 100_000
    foreign = re.compile(r'<(?:script|link|img)[^>]*(?:src|href)="(?:https?:)?//')
    pages = list(site.rglob("*.html"))
    assert len(pages) > 100
    assert [page for page in pages if foreign.search(page.read_text(encoding="utf-8"))] == []


def test_pictures_are_made_by_the_run(site: Path) -> None:
    shown = (site / "explanation" / "life-of-a-move" / "index.html").read_text(encoding="utf-8")
    assert "pictures/profile.svg" in shown
    assert "<svg" in (site / "pictures" / "terminal.svg").read_text(encoding="utf-8")


def test_the_front_page_has_a_moving_picture_and_a_still_one(site: Path) -> None:
    front = (site / "index.html").read_text(encoding="utf-8")
    for picture in ("demo", "demo_still"):
        assert f'src="pictures/{picture}.svg"' in front
        assert "axis move X --to 100" in (site / "pictures" / f"{picture}.svg").read_text("utf-8")


def test_each_error_code_has_a_page_that_the_search_finds(site: Path) -> None:
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    places = {each["location"] for each in index["docs"]}
    for page in code_pages():
        place = f"reference/{page.place}/"
        assert place in places
        text = (site / place / "index.html").read_text(encoding="utf-8")
        assert f"{page.title} - achse</title>" in text


def test_each_page_made_from_rows_is_built(site: Path) -> None:
    pages = generated_pages()
    assert len(pages) > 40
    built = [site / name.removesuffix(".md") / "index.html" for name in pages]
    assert [str(page) for page in built if not page.is_file()] == []


def test_each_code_service_and_block_has_its_anchor(site: Path) -> None:
    links = [code_link(code.number) for code in (*ReturnCode, *NcError)]
    for device in Station.demo().devices:
        port = min(address.port for address in device.addresses)
        links += [
            service_link(port, row.index_group, row.index_offset)
            for row in device.services.describe()
        ]
    for parsed in standard_libraries():
        library = parsed.source.path.partition("/")[0]
        links += [
            library_link(library, unit.name)
            for unit in parsed.units
            if isinstance(unit, Function | FunctionBlock) and not unit.name.startswith("_")
        ]
    assert len(links) > 2000
    texts: dict[str, str] = {}
    missing = []
    for link in links:
        assert link is not None
        page, _, anchor = link.partition("#")
        if page not in texts:
            texts[page] = (site / page / "index.html").read_text(encoding="utf-8")
        if anchor and f'id="{anchor}"' not in texts[page]:
            missing.append(link)
    assert missing == []
