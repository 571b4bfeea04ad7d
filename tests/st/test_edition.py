"""Each row of the table of features does what it says."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import SourceError
from achse.st.syntax.parser import parse
from tests.st.edition import FEATURES, PAGE, Feature, page
from tests.st.graphical.drawings import Drawn


def _refusal(feature: Feature) -> str:
    """What is wrong with the program of a feature; empty for nothing."""
    parsed = parse(feature.program, name="GVL")
    try:
        return "\n".join(map(str, check(declare([parsed])).faults))
    except SourceError as error:
        return str(error)


@pytest.mark.parametrize("feature", FEATURES, ids=lambda one: f"{one.table} {one.name}"[:60])
def test_feature(feature: Feature) -> None:
    if feature.status == "not":
        assert _refusal(feature)
        return
    plc = Drawn(parse(feature.program, name="GVL")).cycle()
    values = {name: plc[name] for name in feature.result}
    assert {name: _shown(value) for name, value in values.items()} == feature.result


def _shown(value: object) -> object:
    return value if isinstance(value, bool | int | float | str) else str(value)


def test_page_is_that_of_the_table() -> None:
    assert PAGE.read_text() == page(), "python -m tests.st.edition"
