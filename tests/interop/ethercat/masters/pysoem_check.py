"""The conformance check of drives, through pysoem; JSON on stdout. `… INTERFACE MS check`."""

from typing import Any

from pysoem_bus import Found, run

from achse.testing import ConformanceError, PysoemReach, check_drive


def check(master: Any, found: Found) -> None:
    found["count"] = master.config_init()
    try:
        check_drive(PysoemReach(master))
        found["faults"] = []
    except ConformanceError as failure:
        found["faults"] = str(failure).splitlines()


if __name__ == "__main__":
    run({"check": check})
