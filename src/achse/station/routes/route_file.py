"""Routes of a station: those of its configuration, and those that its StaticRoutes.xml keeps."""

import logging
from collections.abc import Sequence
from pathlib import Path

from achse.router import Router
from achse.router.rights import rights_named
from achse.router.routes import Route, RouteError
from achse.router.static_routes import parse_static_routes, static_routes
from achse.station.configuration.network import NetworkConfig
from achse.station.configuration.types import ConfigError
from achse.station.persistence.state_file import StateFile

log = logging.getLogger("achse.station")


class RouteFile:
    """The routes of a station: those of its configuration, and those in its StaticRoutes.xml."""

    def __init__(self, config: NetworkConfig, router: Router, base: Path) -> None:
        """Fill the router's table and follow it. Raises ConfigError, OSError."""
        router.routes.rights_of_others = rights_named(config.router.rights)
        self._configured = [item.route() for item in config.route]
        self._file: StateFile | None = None
        self._text = ""
        name = config.router.static_routes
        table = router.routes
        try:
            if name is not None:
                self._file = StateFile(base / name)
                for route in self._read(self._file):
                    table.add(route)
                self._text = static_routes(table)
            for route in self._configured:
                table.add(route, fixed=True)
        except RouteError as fault:
            raise ConfigError(f"route: {fault}") from None
        if self._file is not None:
            table.keep = self._keep

    def _read(self, file: StateFile) -> list[Route]:
        try:
            text = file.read()
            return [] if text is None else parse_static_routes(text)
        except (RouteError, UnicodeDecodeError) as fault:
            raise ConfigError(f"router.static_routes: {file.path}: {fault}") from None

    def _keep(self, routes: Sequence[Route]) -> None:
        """Write what the table is to hold. Raises OSError; the file is then as it was."""
        assert self._file is not None
        text = static_routes(route for route in routes if route not in self._configured)
        if text == self._text:
            return
        try:
            self._file.write(text)
        except OSError as failure:
            log.error("%s cannot be written: %s", self._file.path, failure.strerror)
            raise
        self._text = text
