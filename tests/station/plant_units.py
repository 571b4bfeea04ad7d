"""Units that are built from C sources: an axis of two masses, a tank, a conveyor, a wild one."""

import shutil
import subprocess
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from achse.fmu.compiler import binary_name, platform_folder

__all__ = ["VARIABLES", "description", "plant_units", "put_unit"]

UNITS = Path(__file__).parent / "plants" / "units"

Row = tuple[str, str, str]
"""Name, type in FMI 3.0, causality."""

VARIABLES: dict[str, Sequence[Row]] = {
    "two_mass": (
        ("motor.torque", "Float64", "input"),
        ("motor.phi", "Float64", "output"),
        ("motor.w", "Float64", "output"),
        ("load.phi", "Float64", "output"),
        ("load.w", "Float64", "output"),
        ("motor.J", "Float64", "parameter"),
        ("load.J", "Float64", "parameter"),
        ("spring.c", "Float64", "parameter"),
        ("spring.d", "Float64", "parameter"),
    ),
    "tank": (
        ("pump", "Float64", "input"),
        ("valve", "Float64", "input"),
        ("level", "Float64", "output"),
        ("full", "Boolean", "output"),
        ("area", "Float64", "parameter"),
    ),
    "conveyor": (
        ("speed", "Float64", "input"),
        ("position", "Float64", "output"),
        ("barrier", "Boolean", "output"),
        ("count", "Int32", "output"),
        ("pitch", "Float64", "parameter"),
    ),
    "wild": (
        ("deed", "Int32", "input"),
        ("value", "Float64", "output"),
        ("added", "Float64", "parameter"),
    ),
}
"""Variables of each unit; the value reference is the place in the list."""

_TYPES2 = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean"}
_STARTS = {"Float64": "0", "Int32": "0", "Boolean": "false"}


def description(name: str, fmi: int, variables: Sequence[Row] | None = None) -> str:
    """The modelDescription.xml of a unit."""
    rows = VARIABLES[name] if variables is None else variables
    lines = []
    for reference, (variable, type, causality) in enumerate(rows):
        start = f' start="{_STARTS[type]}"' if causality in ("input", "parameter") else ""
        variability = "fixed" if causality == "parameter" else "discrete"
        head = f'name="{variable}" valueReference="{reference}" causality="{causality}"'
        head += f' variability="{variability}"'
        lines.append(
            f"<{type} {head}{start}/>"
            if fmi == 3
            else f"<ScalarVariable {head}><{_TYPES2[type]}{start}/></ScalarVariable>"
        )
    token = "instantiationToken" if fmi == 3 else "guid"
    return (
        f'<?xml version="1.0"?><fmiModelDescription fmiVersion="{fmi}.0" modelName="{name}"'
        f' {token}="{{{name}}}"><CoSimulation modelIdentifier="{name}"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables><ModelStructure/></fmiModelDescription>"
    )


@pytest.fixture(scope="session")
def plant_units(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all units: `tank.fmu` of FMI 3.0, `tank2.fmu` of FMI 2.0."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    folder = tmp_path_factory.mktemp("plants")
    for name in VARIABLES:
        library = folder / binary_name(name)
        command = [compiler, "-shared", "-fPIC", "-O1", str(UNITS / f"{name}.c"), "-lm"]
        subprocess.run([*command, "-o", str(library)], check=True)
        for fmi, suffix in ((2, "2"), (3, "")):
            with zipfile.ZipFile(folder / f"{name}{suffix}.fmu", "w") as archive:
                archive.writestr("modelDescription.xml", description(name, fmi))
                archive.write(library, f"binaries/{platform_folder(fmi)}/{library.name}")
    return folder


@pytest.fixture
def put_unit(plant_units: Path, tmp_path: Path) -> Callable[..., Path]:
    """Copy units into the folder of the test."""

    def put(*names: str) -> Path:
        for name in names:
            shutil.copy(plant_units / f"{name}.fmu", tmp_path)
        return tmp_path

    return put
