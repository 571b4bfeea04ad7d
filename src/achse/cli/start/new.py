"""`achse new` writes the files of a project, or a test, to start from."""

import json
import os
import re
from collections.abc import Iterator, Set
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json
from achse.cli.target import Json
from achse.extras import requirement_elsewhere

if TYPE_CHECKING:
    from pydantic import BaseModel

SCHEMA_FILE = "station.schema.json"

_WIDTH = 98


class PlcKind(StrEnum):
    """Language of the PLC's programs."""

    ST = "st"
    PYTHON = "python"
    NONE = "none"


class Server(StrEnum):
    """CI server that runs the tests."""

    GITHUB = "github"
    GITLAB = "gitlab"


Folder = Annotated[
    Path,
    typer.Argument(
        metavar="NAME",
        help="A folder, called like the station; or the file of a test, as tests/test_feed.py.",
    ),
]
StationName = Annotated[
    str | None, typer.Option("--name", help="Name of the station.", show_default="NAME")
]
Plc = Annotated[PlcKind, typer.Option("--plc", help="Language of the PLC's program.")]
Axes = Annotated[str, typer.Option("--axes", metavar="NAME[,NAME…]", help="Its axes; '' for none.")]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(new)


def new(
    folder: Folder,
    name: StationName = None,
    plc: Plc = PlcKind.ST,
    axes: Axes = "X",
    tests: Annotated[
        bool, typer.Option("--tests/--no-tests", help="With a test of the station.")
    ] = True,
    ci: Annotated[
        Server | None,
        typer.Option(help="Write a recipe for this CI, which runs the tests.", show_default=False),
    ] = None,
    schema: Annotated[
        bool,
        typer.Option("--schema", help=f"Write {SCHEMA_FILE} only, again."),
    ] = False,
    station: Annotated[
        Path, typer.Option(metavar="FILE", help="Of a test: the station.toml that it is about.")
    ] = Path("station.toml"),
    in_json: Json = False,
) -> None:
    """Write a project to start from: station.toml, its schema, a PLC program, a test; or a test.

    A name that ends in .py is a test of a station, in virtual time. Files that are there are left
    alone: then nothing is written.
    """
    if folder.name.endswith(".py"):
        _new_test(folder, station, in_json)
        return
    if schema:
        _write(folder, {SCHEMA_FILE: _schema()}, in_json, over=True)
        return
    if ci is not None and not tests:
        raise typer.BadParameter("--ci runs the tests: leave --no-tests out")
    files = project(name or _called(folder), plc, _axes(axes), tests=tests, ci=ci)
    _write(folder, files, in_json)


def _new_test(file: Path, station: Path, in_json: bool) -> None:
    """Write a test for a station, in virtual time: of its first axis, if it has one."""
    word = re.sub(r"[\s-]+", "_", file.name.removesuffix(".py").removeprefix("test_"))
    if not re.fullmatch(r"\w+", word):
        raise typer.BadParameter(
            f"letters, digits and _, as in a Python name; got {file.name!r}", param_hint="NAME"
        )
    folder, first = file.parent, _first_axis(station)
    try:
        # relative, so that the test runs where the project is checked out
        place = Path(os.path.relpath(station.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive of Windows
        place = station.resolve().as_posix()
    text = _NEW_TEST[first is not None].format(
        name=word.casefold(), file=json.dumps(place), axis=json.dumps(first, ensure_ascii=False)
    )
    _write(folder, {f"test_{word}.py": text}, in_json)


def _first_axis(station: Path) -> str | None:
    """Name of the first axis of a station; a file that cannot be used ends the command."""
    from achse.station import ConfigError, Station

    try:
        config = Station.load(station).config
    except ConfigError as faults:
        fail(str(faults), name="CONFIGURATION")
    except OSError as failure:
        hint = "; `achse new NAME` writes one, --station says where it is"
        fail(f"{station}: {failure.strerror}{hint}", name="CONFIGURATION")
    return config.axis[0].name if config.axis else None


def _called(folder: Path) -> str:
    return folder.resolve().name or "station"


def _axes(text: str) -> list[str]:
    names = [each.strip() for each in text.split(",") if each.strip()]
    if twice := sorted({each for each in names if _keys(names).count(each.casefold()) > 1}):
        raise typer.BadParameter(
            f"an axis each, got {', '.join(twice)} more than once", param_hint="--axes"
        )
    return names


def _write(folder: Path, files: dict[str, str], in_json: bool, *, over: bool = False) -> None:
    """Write all files, or with one that is there already none, unless it is to be written over."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        fail(f"{folder}: {failure.strerror}", name="CANNOT_WRITE")
    if not over and (there := [each for each in files if (folder / each).exists()]):
        fail(
            f"{', '.join(there)} in {folder}: there already, so nothing is written",
            name="FILE_EXISTS",
        )
    for file, text in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        write_file(folder / file, text.encode())
    if in_json:
        print_json([str(folder / file) for file in files])
        return
    for file in files:
        print(folder / file)


def project(
    name: str, plc: PlcKind, axes: list[str], tests: bool, ci: Server | None
) -> dict[str, str]:
    """Return the files, by their names."""
    files = {"station.toml": "".join(_station(name, plc, axes)), SCHEMA_FILE: _schema()}
    if plc is PlcKind.ST:
        files["plc/MAIN.st"] = _MAIN_ST
    elif plc is PlcKind.PYTHON:
        files["plc.py"] = _MAIN_PY
    if tests or ci is not None:
        files["tests/test_station.py"] = _TEST[plc]
    if ci is Server.GITHUB:
        files[".github/workflows/tests.yml"] = ci_recipe(GITHUB)
    elif ci is Server.GITLAB:
        files[".gitlab-ci.yml"] = ci_recipe(GITLAB)
    return files


def ci_recipe(text: str) -> str:
    """Return GITHUB or GITLAB with the requirement that installs this copy of achse."""
    requirement, is_reachable = requirement_elsewhere("fast")
    note = "" if is_reachable else _FROM_A_FOLDER
    step = text.partition("{note}")[2]
    indent = step[: step.index("-")]
    lines = "".join(f"{indent}# {line}\n" for line in note.splitlines())
    return text.replace("{note}", lines).replace("{achse}", requirement)


def _keys(names: list[str]) -> list[str]:
    return [each.casefold() for each in names]


def _schema() -> str:
    from achse.station.configuration.schema import station_schema

    return json.dumps(station_schema(), indent=1, ensure_ascii=False) + "\n"


def _station(name: str, plc: PlcKind, axes: list[str]) -> Iterator[str]:
    """Yield a station.toml: what it has, and as comments what else it could have."""
    from achse.station.configuration import plc as plc_keys
    from achse.station.configuration import station_file
    from achse.station.configuration.limits import LimitsConfig
    from achse.station.configuration.network import RouterConfig

    yield f"#:schema ./{SCHEMA_FILE}\n"
    yield "# A station of achse. Keys in comments have their default, if they have one.\n"
    yield "# `achse check station.toml` looks at it, `achse run station.toml` runs it.\n\n"
    yield f"name = {json.dumps(name, ensure_ascii=False)}\n"
    yield from _table("[router]", RouterConfig)
    yield from _table("[system]", station_file.SystemConfig)
    yield from _table("[nc]", station_file.NcConfig)
    for number, axis in enumerate(axes, 1):
        yield from _axis(number, axis, first=number == 1)
    if plc is PlcKind.ST:
        yield from _table("[[plc]]", plc_keys.PlcConfig, {"port": 851, "sources": "plc"})
    elif plc is PlcKind.PYTHON:
        yield from _table("[[plc]]", plc_keys.PlcConfig, {"port": 851, "globals": ["plc.py:GVL"]})
        task = {"name": "PlcTask", "cycle": "10ms", "programs": ["plc.py:MAIN"]}
        yield from _table("[[plc.task]]", plc_keys.TaskConfig, task)
    if plc is not PlcKind.NONE:
        yield _SIGNALS
    yield "\n# How much clients may take:\n"
    yield from _table("[limits]", LimitsConfig)


def _axis(number: int, name: str, *, first: bool) -> Iterator[str]:
    yield "\n[[axis]]\n"
    if first:
        yield "# Any parameter of axis, encoder, controller, drive: `achse axis show AXIS '*'`.\n"
    yield f"id = {number}\nname = {json.dumps(name, ensure_ascii=False)}\n"
    yield 'unit = "mm"\n'
    yield "max_velocity = 500.0   # mm/s\n" if first else "max_velocity = 500.0\n"
    yield "default_acceleration = 1500.0\ndefault_deceleration = 1500.0\ndefault_jerk = 15000.0\n"
    if first:
        yield "# modulo = true     # with encoder_modulo_factor = 360.0 and unit degree\n"
        yield "# encoder_soft_limit_min_enable = true\n# encoder_soft_limit_min = 0.0\n"
        yield "# encoder_soft_limit_max_enable = true\n# encoder_soft_limit_max = 1000.0\n"


def _table(
    head: str, model: "type[BaseModel]", values: dict[str, Any] | None = None
) -> Iterator[str]:
    """Yield a table with the keys of `values`, and all others of the model in comments."""
    yield f"\n{head}\n"
    for key, value in (values or {}).items():
        yield f"{key} = {json.dumps(value)}\n"
    yield from commented(model, set(values or {}))


def commented(model: "type[BaseModel]", values: Set[str] = frozenset()) -> Iterator[str]:
    """Yield the other keys of a table in comments, each with its meaning and its default.

    A key without a default has an example behind it.
    """
    from achse.station.configuration.schema import descriptions_of, station_schema

    shown = station_schema()["$defs"][model.__name__]["properties"]
    texts = descriptions_of(model)
    for key, facts in shown.items():
        if key in values or (facts.get("type") == "array" and "$ref" in facts.get("items", {})):
            continue
        default = facts.get("default", _EXAMPLES.get(key))
        if isinstance(default, dict) or default is None:
            continue  # a table of its own
        if text := texts.get(key):
            yield from (f"# {line}\n" for line in _wrapped(text))
        yield f"# {key} = {json.dumps(default, ensure_ascii=False)}\n"


_EXAMPLES = {
    "udp_port": 48899,
    "static_routes": "StaticRoutes.xml",
    "root": "files",
    "persistent_data": "persistent.json",
    "sources": "plc",
    "symbols": "plc.tmc",
}
"""Example values of keys without a default."""


def _wrapped(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, _WIDTH - 2)


_SIGNALS = """
# A signal writes a variable of the PLC before each of its cycles: sine, ramp, triangle, square,
# counter, noise, csv, expression.
[[signal]]
symbol = "MAIN.fLevel"
kind = "sine"
period = "10s"
amplitude = 50.0
offset = 50.0
"""

_MAIN_ST = """PROGRAM MAIN
VAR
    nCounter : UDINT;   // cycles since the start
    fLevel : LREAL;     // written by a [[signal]] of the station.toml
    bHigh : BOOL;
END_VAR

nCounter := nCounter + 1;
bHigh := fLevel > 80;
END_PROGRAM
"""

_MAIN_PY = '''"""The PLC's programs and variables; `achse.iec` has the types."""

from achse.iec import BOOL, LREAL, UDINT, GlobalVariables, Program, var


class GVL(GlobalVariables):
    nParts = var(UDINT, 3, comment="for clients to read and write")


class MAIN(Program):
    nCounter = var(UDINT, comment="cycles since the start")
    fLevel = var(LREAL, comment="written by a [[signal]] of the station.toml")
    bHigh = var(BOOL)

    def cycle(self) -> None:
        """Called once a task cycle."""
        self.nCounter = (self.nCounter + 1) & 0xFFFF_FFFF
        self.bHigh = self.fLevel > 80
'''

_OF_PLC = '''"""The station in virtual time: no waits, and each run is the same."""

from pathlib import Path

from achse import Station

FILE = Path(__file__).parents[1] / "station.toml"


def test_a_high_level_is_seen() -> None:
    station = Station.load(FILE)
    main = station.plcs[851].instance("MAIN")
    station.advance(1.0)
    assert main["nCounter"] == 100
    assert not main["bHigh"]
    station.advance(1.5)
    assert main["bHigh"]
'''

_TEST = {
    PlcKind.ST: _OF_PLC,
    PlcKind.PYTHON: _OF_PLC,
    PlcKind.NONE: '''"""The station in virtual time: no waits, and each run is the same."""

from pathlib import Path

from achse import Station

FILE = Path(__file__).parents[1] / "station.toml"


def test_time_passes() -> None:
    station = Station.load(FILE)
    station.advance(1.0)
    assert station.time_ns == 1_000_000_000
''',
}

_NEW_TEST = {
    True: '''"""An axis in virtual time: no waits, and each run is the same."""

from pathlib import Path
from typing import Any

import pytest

FILE = Path(__file__).parent / {file}


@pytest.mark.achse_station(config=str(FILE), axis={axis})
def test_{name}(achse_axis: Any) -> None:
    achse_axis.enable()
    target = achse_axis.position() + 1.0
    achse_axis.move_to(target, velocity=10.0)
    assert abs(achse_axis.position() - target) < 0.1
''',
    False: '''"""The station in virtual time: no waits, and each run is the same."""

from pathlib import Path

from achse import Station

FILE = Path(__file__).parent / {file}


def test_{name}() -> None:
    station = Station.load(FILE)
    station.advance(1.0)
    assert station.time_ns == 1_000_000_000
''',
}
"""Of a station with an axis, and without one."""

_FROM_A_FOLDER = """This achse was installed from a folder, which a server does not have:
name its repository, for example "achse[fast] @ git+https://HOST/PATH.git".
"""

GITHUB = """name: tests
on: [push, pull_request]
jobs:
  tests:
    strategy:
      matrix:
        os: [ubuntu-latest, windows-latest]
        python: ["3.11", "3.12", "3.13", "3.14"]
    runs-on: ${{ matrix.os }}
    steps:
      - uses: actions/checkout@v4
      - uses: actions/setup-python@v5
        with:
          python-version: ${{ matrix.python }}
{note}      - run: pip install "{achse}" pytest
      - run: achse check station.toml
      - run: pytest
"""

GITLAB = """tests:
  parallel:
    matrix:
      - PYTHON: ["3.11", "3.12", "3.13", "3.14"]
  image: python:$PYTHON
  script:
{note}    - pip install "{achse}" pytest
    - achse check station.toml
    - pytest --junitxml=report.xml
  artifacts:
    when: always
    reports:
      junit: report.xml
"""
