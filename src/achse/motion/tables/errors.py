"""Errors of a table."""

from achse.codes import NcError


class TableError(Exception):
    """A table cannot be as requested: `error` is the NC's."""

    def __init__(self, error: NcError, message: str) -> None:
        super().__init__(message)
        self.error = error
