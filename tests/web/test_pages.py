"""The files of the pages: those that are there, and no others."""

import gzip
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from achse.web.pages import Pages


def test_the_package_has_its_first_page() -> None:
    page = Pages().find("/")
    assert page is not None
    assert page.type.startswith("text/html")
    assert gzip.decompress(page.packed) == page.data


def test_files_below_the_folder_and_none_beside_it(tmp_path: Path) -> None:
    folder = tmp_path / "pages"
    (folder / "scope").mkdir(parents=True)
    (folder / "index.html").write_text("<p>")
    (folder / "scope" / "ring.js").write_text("1")
    (folder / "secret.key").write_text("no page")
    (tmp_path / "beside.js").write_text("2")
    (folder / "link.js").symlink_to(tmp_path / "beside.js")
    pages = Pages(folder)
    page = pages.find("scope/ring.js")
    assert page is not None
    assert (page.type, page.data) == ("text/javascript; charset=utf-8", b"1")
    for path in ("../beside.js", "scope/../../beside.js", "link.js", "secret.key", "/etc/passwd"):
        assert pages.find(path) is None
    (folder / "scope" / "ring.js").write_text("other")
    changed = pages.find("scope/ring.js")
    assert changed is not None
    assert changed.tag != page.tag or changed.written == page.written
    (folder / "index.html").unlink()
    assert pages.find("") is None


@given(st.text())
def test_no_path_leads_out(path: str) -> None:
    pages = Pages()
    page = pages.find(path)
    assert page is None or path.strip("/") in ("", *pages.names)
