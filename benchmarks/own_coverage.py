"""How much of each module its own test module covers, and nobody else's.

One run of the tests of the rooms that are named, or of all rooms; lines count that ran while tests
of `tests/x/test_y.py` were at work, or when `src/achse/x/y.py` was imported. Lines in machine code
are not seen. Prints the modules with the least, and the sum of each room.
Usage: python benchmarks/own_coverage.py [ROOM …] [--below PERCENT]
"""

import argparse
from collections import defaultdict
from pathlib import Path

import coverage
import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "achse"
TESTS = ROOT / "tests"


class Contexts:
    """Tells the measurement which test file is at work."""

    def __init__(self, measured: coverage.Coverage) -> None:
        self._measured = measured

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self._measured.switch_context(item.path.relative_to(ROOT).as_posix())

    def pytest_sessionfinish(self) -> None:
        self._measured.switch_context("")


def own_test(module: Path) -> str:
    """The test file that mirrors a module."""
    place = module.relative_to(PACKAGE)
    return Path("tests", place.parent, f"test_{place.name}").as_posix()


def share(measured: coverage.Coverage, module: Path) -> tuple[int, int]:
    """Statements that ran in the module's own tests or at its import, and all there are."""
    name = str(module)
    _, statements, _, missing, _ = measured.analysis2(name)
    contexts = measured.get_data().contexts_by_lineno(name)
    own = {"", own_test(module)}
    ran = sum(bool(own.intersection(contexts.get(line, ()))) for line in statements)
    return min(ran, len(statements) - len(missing)), len(statements)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rooms", nargs="*")
    parser.add_argument("--below", type=float, default=80.0, help="print modules below this")
    arguments = parser.parse_args()
    rooms = arguments.rooms or sorted(
        p.name for p in PACKAGE.iterdir() if (p / "__init__.py").exists()
    )
    measured = coverage.Coverage(data_file=None, source=[str(PACKAGE / room) for room in rooms])
    measured.start()
    folders = [str(TESTS / room) for room in rooms if (TESTS / room).is_dir()]
    options = ["-q", "-p", "no:cacheprovider", "--no-header"]
    code = pytest.main([*options, *folders], plugins=[Contexts(measured)])
    measured.stop()
    sums: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    modules = []
    for room in rooms:
        for module in sorted((PACKAGE / room).rglob("*.py")):
            ran, there = share(measured, module)
            sums[room][0] += ran
            sums[room][1] += there
            if module.name != "__init__.py" and there:
                modules.append((100 * ran / there, there, module.relative_to(PACKAGE).as_posix()))
    for percent, there, name in sorted(modules):
        if percent < arguments.below:
            print(f"{percent:6.1f} %  {there:5} statements  {name}")
    for room, (ran, there) in sums.items():
        print(f"{100 * ran / max(there, 1):6.1f} %  {there:5} statements  {room}/ by its own tests")
    return int(code)


if __name__ == "__main__":
    raise SystemExit(main())
