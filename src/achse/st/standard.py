"""What every PLC project can name without declaring it: the libraries that come with achse.

Source: IEC 61131-3 (2013) tables 43 to 46.
"""

from collections.abc import Sequence
from functools import cache

from achse import libraries
from achse.st.parser import Parsed, parse
from achse.st.source import Source

__all__ = ["standard_libraries"]


@cache
def standard_libraries() -> Sequence[Parsed]:
    """The declarations of all libraries, read once. Raises `SourceError` for a faulty file.

    The variables of a file without a list around them are in a list of its name and library.
    """
    found = []
    for name, text in libraries.sources():
        source = Source(text, name)
        folder = name.partition("/")[0]
        source.library = "__SYSTEM" if folder == "language" else folder
        found.append(parse(source, name=name.replace("/", "_").removesuffix(".st")).check())
    return tuple(found)
