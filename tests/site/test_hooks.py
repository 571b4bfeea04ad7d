"""What MkDocs is told: anchors of rows, links within the repository."""

from pathlib import Path

import pytest

from achse.site.hooks import ROOT, anchored, generated_pages, relinked
from achse.site.moving import CAST_FILE


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("| 0x4655 | 18005 | `DRIVE` | text |\n", "0x4655"),
        ("| 0x00004655 | 18005 | `DRIVE` | text |\n", "0x4655"),
        ("| 0x1000 | 0x00000010 | R | UINT32 |\n", "0x1000-0x10"),
        ("| 0x4000 … 0x40FF | 0x0000000A … 0x0000000B | R |\n", "0x4000-0xA"),
        ("| `MC_Power` | function block | x |\n", "MC_Power"),
    ],
)
def test_a_row_has_an_anchor(line: str, name: str) -> None:
    assert anchored(line) == f'| <a id="{name}"></a>{line[2:]}'


@pytest.mark.parametrize("line", ["| hex | decimal |\n", "| --- | --- |\n", "0x10 | 0x20\n", "\n"])
def test_other_lines_stay(line: str) -> None:
    assert anchored(line) == line


KNOWN = {"index.md", "how-to/a.md", "how-to/b.md", "examples/drives/README.md", "changelog.md"}


@pytest.mark.parametrize(
    ("text", "uri", "target"),
    [
        ("[b](b.md)", "how-to/a.md", "[b](b.md)"),
        ("[b](b.md#part)", "how-to/a.md", "[b](b.md#part)"),
        ("[top](../../README.md)", "how-to/a.md", "[top](../index.md)"),
        ("[a](docs/how-to/a.md)", "index.md", "[a](how-to/a.md)"),
        ("[d](examples/drives/README.md)", "index.md", "[d](examples/drives/README.md)"),
        ("[top](../../README.md)", "examples/drives/README.md", "[top](../../index.md)"),
        ("[code](../../src/achse/x.py)", "how-to/a.md", "code"),
        ("[far](https://example.org/x.md)", "index.md", "[far](https://example.org/x.md)"),
        ("[here](#part)", "index.md", "[here](#part)"),
        ("<!-- picture: other -->", "how-to/a.md", "![other](../pictures/other.svg)"),
    ],
)
def test_links_lead_to_pages_of_the_site(text: str, uri: str, target: str) -> None:
    assert relinked(text, uri, KNOWN) == target


def test_a_moving_picture_has_a_still_one_beside_it() -> None:
    text = relinked("<!-- picture: demo -->", "index.md", KNOWN)
    assert "(pictures/demo.svg){ .moving }" in text
    assert "(pictures/demo_still.svg){ .still }" in text


def test_pages_made_from_rows_replace_those_that_were_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cast = tmp_path / "demo.cast"
    cast.write_text('{"version": 2}\n[0.1, "o", "$ achse\\r\\n"]\n')
    monkeypatch.setenv(CAST_FILE, str(cast))
    pytest.importorskip("mkdocs", reason="needs the extra docs")
    from mkdocs.config import load_config
    from mkdocs.structure.files import File, Files

    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(tmp_path / "site"))
    (tmp_path / "reference").mkdir()
    (tmp_path / "reference" / "nc-errors.md").write_text("# Old\n")
    old = File("reference/nc-errors.md", str(tmp_path), config.site_dir, use_directory_urls=True)
    files = config.plugins.on_files(Files([old]), config=config)
    texts = {file.src_uri: file.content_string for file in files if file.is_documentation_page()}
    assert texts["reference/nc-errors.md"].startswith("# NC error codes")
    assert texts.keys() >= generated_pages().keys()
