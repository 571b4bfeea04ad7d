"""The table of kinematics: each law by its name, with its numbers and their defaults."""

import runpy
from collections.abc import Callable, Mapping, MutableSequence, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from achse.motion.groups.kinematics import delta, identity, parallel, portal, scara
from achse.motion.groups.parameters import GroupParametersError

Transformation = Callable[[Sequence[float], Sequence[float], MutableSequence[float]], int]


class KinematicsLaw(NamedTuple):
    """Law between axes and places."""

    forward: Transformation
    inverse: Transformation
    numbers: Mapping[str, float]
    """Names of its numbers in their order, with what they are by default."""

    def in_order(self, values: Mapping[str, float], what: str) -> list[float]:
        """Return its numbers, of which `values` are given. Raises GroupParametersError."""
        for name in values:
            if name not in self.numbers:
                known = ", ".join(self.numbers) or "none"
                raise GroupParametersError(f"{what}: no number {name!r}, there are {known}")
        return [values.get(name, default) for name, default in self.numbers.items()]


KINEMATICS: Mapping[str, KinematicsLaw] = MappingProxyType(
    {
        "identity": KinematicsLaw(identity.forward, identity.inverse, {}),
        "portal": KinematicsLaw(
            portal.forward,
            portal.inverse,
            {
                **{f"zero_{axis}": 0.0 for axis in "xyz"},
                **{f"direction_{axis}": 1.0 for axis in "xyz"},
                "angle": 0.0,
            },
        ),
        "scara": KinematicsLaw(
            scara.forward, scara.inverse, {"first_arm": 300.0, "second_arm": 200.0}
        ),
        "parallel": KinematicsLaw(
            parallel.forward, parallel.inverse, {"distance": 200.0, "arm": 250.0, "rod": 400.0}
        ),
        "delta": KinematicsLaw(
            delta.forward,
            delta.inverse,
            {"base_radius": 200.0, "plate_radius": 50.0, "arm": 300.0, "rod": 700.0},
        ),
    }
)


def law_from_file(file: Path) -> KinematicsLaw:
    """Return the law of a user: a Python file with `forward`, `inverse` and, if it has numbers,
    `NUMBERS`, a dictionary of their names and defaults. Raises GroupParametersError."""
    try:
        module = runpy.run_path(str(file))
    except Exception as failure:
        raise GroupParametersError(f"{file}: {type(failure).__name__}: {failure}") from failure
    missing = [name for name in ("forward", "inverse") if not callable(module.get(name))]
    numbers = module.get("NUMBERS", {})
    if missing:
        raise GroupParametersError(f"{file}: expected a function {' and '.join(missing)}")
    if not isinstance(numbers, dict) or not all(
        isinstance(name, str) and isinstance(value, int | float) for name, value in numbers.items()
    ):
        raise GroupParametersError(f"{file}: NUMBERS: expected names and numbers")
    return KinematicsLaw(
        module["forward"], module["inverse"], {name: float(each) for name, each in numbers.items()}
    )
