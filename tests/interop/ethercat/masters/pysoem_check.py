"""The conformance check of drives, through pysoem; JSON on stdout. `… INTERFACE MS check`."""

from typing import Any

from pysoem_bus import Report, run

from achse.testing import ConformanceError, PysoemReach, check_drive


def check(master: Any, report: Report) -> None:
    report["count"] = master.config_init()
    try:
        check_drive(PysoemReach(master))
        report["faults"] = []
    except ConformanceError as failure:
        report["faults"] = str(failure).splitlines()


if __name__ == "__main__":
    run({"check": check})
