"""Unit tests of PLC projects: TcUnit's suites run in a station, in virtual time.

TcUnit itself is not part of achse: its public sources are loaded, unmodified, from where the user
has them.
"""

from achse.tcunit.bench import ProjectError
from achse.tcunit.junit import junit_xml
from achse.tcunit.locate import TcUnitMissing, find_tcunit
from achse.tcunit.results import CodePlace, Failure, Suite, TestRun, UnitTest
from achse.tcunit.runner import run_tests

__all__ = [
    "CodePlace",
    "Failure",
    "ProjectError",
    "Suite",
    "TcUnitMissing",
    "TestRun",
    "UnitTest",
    "find_tcunit",
    "junit_xml",
    "run_tests",
]
