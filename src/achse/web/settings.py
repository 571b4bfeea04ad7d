"""Settings of a station's web server: address, rights of the pages, number of pages."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from achse.extras import needs_extra

WEB_PORT = 8080
"""TCP port unless another is named."""

VIEWERS = 64
"""Open pages at most."""


class WebExtraMissing(ImportError):
    """The packages of the extra `web` are not installed."""

    def __init__(self) -> None:
        super().__init__(needs_extra("the browser page", "web"))


class EditedProject(NamedTuple):
    """A PLC project whose sources pages may edit."""

    name: str
    path: Path
    """A folder, a `.plcproj` or a source."""
    libraries: tuple[Path, ...] = ()
    port: int = 851
    """AMS port of the PLC that runs it."""


@dataclass(frozen=True, slots=True)
class WebSettings:
    """Settings of a `WebServer`."""

    host: str = "127.0.0.1"
    port: int = WEB_PORT
    """0 takes a free one."""
    token: str = ""
    """Needed to open the page; empty: none on this computer, a random one elsewhere."""
    read_only: bool = False
    """Pages may look, and change nothing."""
    viewers: int = VIEWERS
    """Largest number of open pages; further ones are refused."""
    scene: Path | None = None
    """A JSON file that describes the machine for its picture."""
    projects: tuple[EditedProject, ...] = ()
    """PLC projects whose sources pages may edit."""

    def __post_init__(self) -> None:
        if not 0 <= self.port <= 0xFFFF:
            raise ValueError(f"web port: expected 0..65535, got {self.port!r}")
        if self.viewers < 1:
            raise ValueError(f"web viewers: expected 1 or more, got {self.viewers!r}")
        if self.token and not (self.token.isascii() and self.token.isprintable()):
            raise ValueError("web token: expected letters and digits")
