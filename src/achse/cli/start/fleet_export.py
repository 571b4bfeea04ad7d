"""`achse fleet export`: the same fleet in containers."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json
from achse.cli.target import Json


class ExportKind(Enum):
    """Format of the export."""

    COMPOSE = "compose"
    KUBERNETES = "kubernetes"


FleetFile = Annotated[
    Path, typer.Argument(metavar="FLEET.TOML", help="What the fleet consists of.")
]


def export(
    kind: Annotated[ExportKind, typer.Argument(help="For which program.")],
    file: FleetFile,
    image: Annotated[str, typer.Option(help="The image of the stations.")] = "achse:latest",
    as_json: Json = False,
) -> None:
    """Print the fleet as a Compose file, or as a manifest for Kubernetes."""
    from achse.fleet.export import compose, kubernetes
    from achse.fleet.plan import FleetPlan
    from achse.station import ConfigError

    try:
        plan = FleetPlan.load(file)
        plan.check()
        text = (compose if kind is ExportKind.COMPOSE else kubernetes)(plan, image)
    except ConfigError as faults:
        fail(str(faults), name="CONFIGURATION")
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", name="CONFIGURATION")
    if as_json:
        print_json({"kind": kind.value, "text": text})
    else:
        print(text, end="")
