"""[web] and [metrics] of a station.toml: HTTP servers beside the station."""

from pathlib import Path

from pydantic import Field

from achse.station.configuration.types import ConfigTable


class PagesConfig(ConfigTable):
    """[web] of a router.toml: the router in the browser at `http://host:port/` (extra `web`)."""

    port: int | None = Field(default=None, ge=0, le=65535)
    """Without it there is a page only with `--web`; 0 takes a free one."""
    host: str = Field(default="127.0.0.1", min_length=1)
    """An address that other computers reach needs a token, which the address printed has."""
    token: str = Field(default="", pattern=r"^[A-Za-z0-9_.~-]*$", max_length=200)
    """Needed to open the page; empty: none on this computer, a random one elsewhere."""


class WebConfig(PagesConfig):
    """[web]: the station in the browser at `http://host:port/` (extra `web`)."""

    read_only: bool = False
    """Pages may look, and change nothing. Without it they may what `router.rights` says."""
    edit: bool = False
    """Pages may edit the sources of the PLCs, and save them, if the rights of pages allow all."""
    scene: Path | None = None
    """A JSON file that describes the machine for its picture."""


class MetricsConfig(ConfigTable):
    """[metrics]: figures for Prometheus at `http://host:port/metrics` (extra `metrics`)."""

    port: int | None = Field(default=None, ge=0, le=65535)
    """Without it there are none; 0 takes a free one."""
    host: str = Field(default="127.0.0.1", min_length=1)
