"""Lines of keys, in documents that are made so that the line is known."""

from hypothesis import given
from hypothesis import strategies as st

from achse.fleet.lines import line_of

TEXT = """
name = "press" # a comment
[mqtt]
topic = '''
name = "not this one"
'''
ports = [
  1,
  2,
]

[[station]]
number = 1
[[station]]
# number = 9
number = 2
nc.cycle = "2ms"
"""


def test_keys_of_tables_lists_and_values_over_many_lines() -> None:
    assert line_of(TEXT, ["name"]) == 2
    assert line_of(TEXT, ["mqtt"]) == 3
    assert line_of(TEXT, ["mqtt", "topic"]) == 4
    assert line_of(TEXT, ["mqtt", "ports"]) == 7
    assert line_of(TEXT, ["station", 0, "number"]) == 13
    assert line_of(TEXT, ["station", 1]) == 14
    assert line_of(TEXT, ["station", 1, "number"]) == 16
    assert line_of(TEXT, ["station", 1, "nc", "cycle"]) == 17
    assert line_of(TEXT, []) == 1


def test_what_is_not_there_has_no_line() -> None:
    places: list[list[str | int]] = [["x"], ["station", 2], ["name", "x"], ["name", 0]]
    places.append(["station", "number"])
    for place in places:
        assert line_of(TEXT, place) == 0
    assert line_of("", ["name"]) == 0
    assert line_of("no [ document", ["no"]) == 0


@given(
    blanks=st.lists(st.sampled_from(["", "# x = 1", '  ""=2']), max_size=3),
    entries=st.lists(st.integers(0, 3), min_size=1, max_size=6),
    data=st.data(),
)
def test_any_list_of_tables(blanks: list[str], entries: list[int], data: st.DataObject) -> None:
    lines = [blank for blank in blanks if not blank.endswith("=2")]
    lines_of = []
    for entry in entries:
        lines_of.append(len(lines) + 1)
        lines += ["[[t]]", *[""] * entry, "x = [", "1]"]
    place = data.draw(st.integers(0, len(entries) - 1))
    text = "\n".join(lines)
    assert line_of(text, ["t", place]) == lines_of[place]
    assert line_of(text, ["t", place, "x"]) == lines_of[place] + entries[place] + 1
