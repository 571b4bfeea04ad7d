"""Pages of error codes: one for each code, made from the page of its table."""

import json
from pathlib import Path

import pytest

from achse.site.code_pages import CodePage, code_pages, framed, linked, write_code_pages

FRAME = """<head><title>T - achse</title>
<link rel="prev" href="../"><link rel="next" href="../b/"></head>
<a href="#table" class="md-skip">Skip</a>
<label class="md-header__button md-icon" for="__drawer"><svg></svg></label>
<div class="md-sidebar md-sidebar--primary">navigation</div>
<div class="md-content"><article class="md-content__inner md-typeset">
<table><tr><td><a id="0x706"></a>0x706</td><td>INVALID</td></tr></table></article></div>"""
PAGE = CodePage("0x706", "0x706", "A_B", "ADS return code", "t", "x < `y`.", "do `z`", True)


def test_places_differ_and_each_table_has_several() -> None:
    pages = list(code_pages())
    assert len({page.place for page in pages}) == len(pages) > 500
    tables = {page.table for page in pages}
    assert tables == {"return-codes", "nc-errors", "sdo-aborts", "al-status", "drive-alarms"}


def test_a_page_has_title_text_remedy_and_its_neighbours() -> None:
    text = framed(FRAME, PAGE, [PAGE._replace(place="0x707", code="0x707")])
    assert "<title>0x706 A_B - achse</title>" in text
    assert "ADS return code 0x706 (1798): x &lt; <code>y</code>.</p>" in text
    assert "Remedy.</strong> do <code>z</code>." in text
    assert 'href="../0x707/"' in text
    assert 'href="../t/"' in text
    assert 'href="#code"' in text
    for gone in ("navigation", "__drawer", "rel=", "<table>"):
        assert gone not in text


@pytest.mark.parametrize("part", ["<title>", "md-skip", "__drawer", "md-sidebar", "<article"])
def test_a_frame_without_a_part_is_refused(part: str) -> None:
    with pytest.raises(ValueError, match="page of t: expected"):
        framed(FRAME.replace(part, "_"), PAGE, [])


def test_tables_link_to_the_pages_of_their_codes() -> None:
    assert '<td><a id="0x706"></a><a href="../0x706/">0x706</a></td>' in linked(FRAME, [PAGE])
    assert linked(FRAME, []) == FRAME


def test_the_search_finds_each_page(tmp_path: Path) -> None:
    for table in {page.table for page in code_pages()}:
        folder = tmp_path / "reference" / table
        folder.mkdir(parents=True)
        (folder / "index.html").write_text(FRAME, encoding="utf-8")
    index = tmp_path / "search" / "search_index.json"
    index.parent.mkdir()
    index.write_text('{"docs": []}')
    count = write_code_pages(tmp_path)
    listed = json.loads(index.read_text())["docs"]
    assert len(listed) == count == len(list(code_pages()))
    assert all((tmp_path / each["location"] / "index.html").is_file() for each in listed)
    assert "0x706 ADSERR_DEVICE_INVALIDDATA" in {each["title"] for each in listed}
