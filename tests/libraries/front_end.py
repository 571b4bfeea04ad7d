"""What the front end makes of a program, for all stations of a process with that program."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar
from unittest.mock import patch

from achse.iec.structs import StaticRecord
from achse.st.check import check
from achse.st.declare import Declarations
from achse.st.lexis.source import Diagnostic
from achse.st.project import Project, load_project
from achse.st.reach import Reach
from achse.st.typed.project import TypedProject

__all__ = ["FrontEnd"]

KEPT = 64
"""Programs of which the declarations and the typed form are kept for the next station."""


class FrontEnd:
    """What the front end makes of a program: stations with the same program share it."""

    _by_text: ClassVar[dict[str, "FrontEnd"]] = {}

    def __init__(self, project: Project) -> None:
        self.project = project
        self._typed: TypedProject | None = None

    @classmethod
    def of(cls, text: str, file: Path) -> "FrontEnd":
        """Return what is made of a file with that text."""
        known = cls._by_text
        if text not in known:
            if len(known) == KEPT:
                del known[next(iter(known))]
            known[text] = cls(load_project(file))
        return known[text]

    def check(
        self,
        declared: Declarations,
        *,
        predefined: Iterable[type[StaticRecord]] = (),
        check_bounds: bool = True,
        reach: Reach | None = None,
        unreached: Iterable[Diagnostic] = (),
    ) -> TypedProject:
        """Stand in for `check`."""
        assert declared is self.project.declarations
        assert check_bounds
        assert not list(unreached)
        if self._typed is None:
            self._typed = check(declared, predefined=predefined)
        return self._typed

    @contextmanager
    def shared(self) -> Iterator[None]:
        """Let stations that are made take this instead of reading their sources."""
        with (
            patch("achse.st.project.load_project", lambda *_, **options: self.project),
            patch("achse.st.check.check", self.check),
        ):
            yield
