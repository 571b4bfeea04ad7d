"""Fault sites: places where checked machine code leaves, and the exception of Python there."""

import builtins
import json
from dataclasses import astuple, dataclass


@dataclass(frozen=True, slots=True)
class TrapSite:
    """A line of a kernel where an operation can fail; `text` may name two values, {0} and {1}."""

    error: str
    text: str
    file: str
    line: int
    function: str

    def exception(self, first: int, second: int) -> Exception:
        """Return the exception that Python raises there."""
        kind: type[Exception] = getattr(builtins, self.error)
        text = self.text.format(first, second)
        return kind(f"{self.file}:{self.line}: {self.function}: {text}")


class Sites:
    """Sites by the numbers of their faults, which begin with 1."""

    def __init__(self, packed: bytes = b"[]") -> None:
        self._numbers: dict[TrapSite, int] = {}
        for each in json.loads(packed):
            self.number(TrapSite(*each))

    def number(self, site: TrapSite) -> int:
        """Return the number of a site, the same for equal ones."""
        return self._numbers.setdefault(site, len(self._numbers) + 1)

    def pack(self) -> bytes:
        """Return all sites, to be saved with the machine code."""
        return json.dumps([astuple(site) for site in self._numbers]).encode()

    def __getitem__(self, number: int) -> TrapSite:
        return list(self._numbers)[number - 1]
