"""Marks of equivalent mutants: comments, achse.toml, and files that are malformed."""

from pathlib import Path

import pytest

from achse.st.lint.options import LintOptionsError
from achse.tcunit.mutation.marks import MutationOptions, is_marked, mutation_options
from achse.tcunit.mutation.operators import mutants_of
from tests.tcunit.mutation.conftest import Routines

TEXT = """FUNCTION F_Marked : INT
F_Marked := 1; // achse: equivalent, nobody reads it
(* achse: equivalent *)
F_Marked := 2;
F_Marked := 3; // equivalent
END_FUNCTION
"""


def test_comments_and_names(routines: Routines) -> None:
    mutants = {
        (one.routine.locate(one.at).line, one.change): one
        for one in mutants_of(routines(TEXT)["f_marked"])
    }
    options = MutationOptions(equivalent=("f_marked: 3 becomes 4",), exclude=("F_Other", "F_M*d"))
    marked = {key for key, one in mutants.items() if is_marked(one, options)}
    assert {line for line, _ in marked} == {2, 4, 5}
    assert [change for line, change in marked if line == 5] == ["3 becomes 4"]
    assert all(options.excludes(one) for one in mutants.values())
    assert not any(MutationOptions().excludes(one) for one in mutants.values())


def test_options_of_a_project(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    assert mutation_options(tmp_path) == MutationOptions()
    file = tmp_path / "achse.toml"
    file.write_text('[mutate]\nequivalent = ["F: a removed"]\nexclude = ["FB_Old*"]\n')
    assert mutation_options(tmp_path) == MutationOptions(("F: a removed",), ("FB_Old*",))
    for text, message in [
        ("[mutate]\nequivalent = 3", "equivalent: expected a list of texts, got 3"),
        ("[mutate]\nexclud = []", "expected key of .mutate. equivalent or exclude, got 'exclud'"),
    ]:
        file.write_text(text)
        with pytest.raises(LintOptionsError, match=message):
            mutation_options(tmp_path)
