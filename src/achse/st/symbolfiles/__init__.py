"""Symbol files: `.tmc` and `.tpy` read and written, and what differs between two of them."""

from achse.st.files.tasks import FileTask
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Location, SourceError
from achse.st.symbolfiles.difference import Change, differences
from achse.st.symbolfiles.model import FileVariable, SymbolFile, units_of
from achse.st.symbolfiles.tmc import read_tmc
from achse.st.symbolfiles.tmcwriter import write_tmc
from achse.st.symbolfiles.tpy import read_tpy
from achse.st.symbolfiles.tpywriter import write_tpy

__all__ = [
    "Change",
    "FileTask",
    "FileVariable",
    "SymbolFile",
    "differences",
    "read_symbol_file",
    "read_tmc",
    "read_tpy",
    "units_of",
    "write_symbol_file",
    "write_tmc",
    "write_tpy",
]

_WRITERS = {".tmc": write_tmc, ".tpy": write_tpy}
_READERS = {".tmc": read_tmc, ".tpy": read_tpy}


def read_symbol_file(data: bytes, source: str) -> SymbolFile:
    """Return the content of a `.tmc` or `.tpy`; the name `source` says which. Raises
    `SourceError`."""
    for suffix, read in _READERS.items():
        if source.lower().endswith(suffix):
            return read(data, source)
    expected = "expected a file name that ends in .tmc or .tpy"
    raise SourceError([Diagnostic(Location(source, 1, 1), expected, Code.BAD_SYMBOL_FILE)])


def write_symbol_file(file: SymbolFile, name: str) -> bytes:
    """Return the bytes of a `.tmc` or `.tpy`, as the ending of `name` says. Raises ValueError."""
    for suffix, write in _WRITERS.items():
        if name.lower().endswith(suffix):
            return write(file)
    raise ValueError(f"expected a file name that ends in .tmc or .tpy, got {name!r}")
