"""What the tests of the linter share: a text in, what it declares out."""

from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse


def declared(text: str) -> Declarations:
    """Return what a sound text declares."""
    return declare([parse(Source(text, "x.st")).check()])
