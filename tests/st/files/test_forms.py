"""Forms of files: each ending once, found in any case."""

from pathlib import Path

import pytest

from achse.st.files.forms import FORMS, Content, FileForm, form_of, has_content, suffixes_of


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.suffix)
def test_form_is_found_by_its_ending_in_any_case(form: FileForm) -> None:
    for suffix in (form.suffix, form.suffix.lower(), form.suffix.upper()):
        assert form_of(Path("folder.st") / f"a.b{suffix}") is form
        assert has_content(Path(f"x{suffix}"), form.content)
    assert form.suffix.lower() in suffixes_of(form.content)


def test_each_ending_has_one_row_and_each_content_an_ending() -> None:
    endings = [form.suffix.lower() for form in FORMS]
    assert len(set(endings)) == len(endings)
    assert list(suffixes_of(*Content)) == endings
    assert all(suffixes_of(content) for content in Content)


@pytest.mark.parametrize("name", ["a", "a.txt", ".st", "a.st.bak", "tcpou"])
def test_other_files_have_no_form(name: str) -> None:
    assert form_of(Path(name)) is None
    assert not has_content(Path(name), *Content)
