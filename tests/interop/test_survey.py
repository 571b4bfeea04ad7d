"""The survey of public projects, on three small ones."""

from pathlib import Path

from tests.interop.survey import page_of, projects_below, rows_of, survey, try_project

PROGRAM = "PROGRAM MAIN VAR n : UINT; x : UINT; END_VAR {} END_PROGRAM"
PROJECT = "<Project><Title>{}</Title><Compile Include='MAIN.st'/></Project>"


def _repository(folder: Path, name: str, body: str, project: str = "") -> None:
    (folder / name).mkdir()
    (folder / name / "COMMIT").write_text("0123456789abcdef\n")
    (folder / name / "MAIN.st").write_text(PROGRAM.format(body))
    if project:
        (folder / name / f"{project}.plcproj").write_text(PROJECT.format(project))


def test_how_far_projects_come(tmp_path: Path) -> None:
    _repository(tmp_path, "me+good", "n := n + 1;", "good")
    _repository(tmp_path, "me+loose", "n := n + 1; IF n = 8 THEN x := 1 / x; END_IF")
    _repository(tmp_path, "me+wrong", "n := missing;", "wrong")
    assert [project.name for _, project in projects_below(tmp_path)] == [
        "good.plcproj", "me+loose", "wrong.plcproj",
    ]  # fmt: skip
    good, loose, wrong = (
        try_project(tmp_path, repository, project)
        for repository, project in projects_below(tmp_path)
    )
    assert (good.loads, good.ran, good.commit[:4]) == (True, True, "0123")
    assert (loose.loads, loose.ran, loose.cycles) == (True, False, 8)
    assert loose.reason.startswith("stopped after 8 cycles: ")
    assert (wrong.loads, wrong.errors) == (False, 1)
    assert "nothing is named 'missing'" in wrong.reason


def test_the_page_follows_each_project(tmp_path: Path) -> None:
    """A survey of some projects leaves the rows of the others as they are."""
    (tmp_path / "all").mkdir()
    _repository(tmp_path / "all", "me+good", "n := n + 1;", "good")
    _repository(tmp_path / "all", "me+wrong", "n := missing;", "wrong")
    page = tmp_path / "page.md"
    survey(tmp_path / "all", page, only=["good"])
    assert "1 projects: 1 load, 1 of them run 1,000 cycles (100 %), 0 of these" in page.read_text()
    survey(tmp_path / "all", page, begin="me+w")
    text = page.read_text()
    assert "2 projects: 1 load, 1 of them run 1,000 cycles (50 %), 0 of these" in text
    assert "| me/good | 01234567 | good.plcproj | 1 | yes | " in text
    assert page_of(rows_of(text)) == text


def test_what_cannot_be_read_is_reported(tmp_path: Path) -> None:
    _repository(tmp_path, "me+odd", "", "odd")
    (tmp_path / "me+odd/odd.plcproj").write_text("<Project")
    outcome = try_project(tmp_path, tmp_path / "me+odd", tmp_path / "me+odd/odd.plcproj")
    assert (outcome.loads, outcome.errors) == (False, 1)


def test_a_project_with_stand_ins_names_the_libraries_that_are_not_here(tmp_path: Path) -> None:
    """Also if its uses do not show which of them they mean."""
    _repository(tmp_path, "me+block", "fb(bIn := TRUE);", "block")
    source = tmp_path / "me+block/MAIN.st"
    source.write_text(source.read_text().replace("VAR n", "VAR fb : FB_Thing; n"))
    reference = (
        "<PlaceholderReference Include='{0}'><Namespace>{0}</Namespace></PlaceholderReference>"
    )
    references = "".join(map(reference.format, ("Far", "Further")))
    (tmp_path / "me+block/block.plcproj").write_text(
        PROJECT.format("block").replace("</Project>", f"{references}</Project>")
    )
    outcome = try_project(tmp_path, tmp_path / "me+block", tmp_path / "me+block/block.plcproj")
    assert (outcome.ran, outcome.missing) == (True, ["Far", "Further"])
