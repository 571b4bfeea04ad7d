"""Loads and runs all PLC projects below a folder, and writes down how far each comes.

    python -m tests.interop.survey FOLDER docs/coverage/projects.md [--only WORD]... [--from NAME]
        [--versions FOLDER]

The page is written again after each project, so that a survey may be ended at any time and go on
`--from` a repository; rows of projects that it does not try stay. FOLDER has checked-out
repositories, one folder each, named `owner+name`; a file `COMMIT` in one says which commit it is.
Each project is loaded with the libraries of all repositories at hand, checked, and run for 1,000
cycles in virtual time, in a process of its own with a time limit. `--versions` has libraries of
these repositories at other commits, one folder each, named `title@version`: a project that its
`.plcproj` resolves to that version is built with it, else with the repository's.
"""

import json
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path

__all__ = [
    "Outcome",
    "page_of",
    "projects_below",
    "row_of",
    "rows_of",
    "survey",
    "try_project",
]

Rows = dict[tuple[str, str], str]
"""Lines of the page by repository and project."""

CYCLES = 1000
LIMIT_S = 240.0
"""Real time that one project may take."""
_FAULTS = Path(__file__).with_name("own_faults.tsv")
"""Repository, project and fault of projects that cannot build or run anywhere, by our reading."""
_SOURCES = (".tcpou", ".st")
_SLICES = 20
_WITH_STUBS = "with stubs for"
_OWN_FAULT = "own fault: "
"""Begins the reason of a project that cannot build or run anywhere."""
_RESOLUTION = re.compile(r"<(?:Default)?Resolution>([^<,]*),\s*([^<,( ]*)")


@dataclass
class Outcome:
    """How far a project came."""

    repository: str
    project: str
    commit: str = ""
    units: int = 0
    errors: int = 0
    cycles: int = 0
    reason: str = ""
    """The first error, or why it stopped."""
    missing: list[str] = field(default_factory=list)
    """Titles of libraries that it needs and that are not here."""

    @property
    def loads(self) -> bool:
        """True if no unit has an error."""
        return self.units > 0 and not self.errors

    @property
    def ran(self) -> bool:
        """True if it came through all cycles."""
        return self.loads and self.cycles >= CYCLES


def projects_below(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Repositories with their projects: each `.plcproj`, else the folder if it has sources."""
    for repository in sorted(item for item in folder.iterdir() if item.is_dir()):
        files = sorted(item for item in repository.rglob("*") if item.is_file())
        projects = [item for item in files if item.suffix.lower() == ".plcproj"]
        if not projects and any(item.suffix.lower() in _SOURCES for item in files):
            projects = [repository]
        for project in projects:
            yield repository, project


def versions_of(project: Path, versions: Path | None) -> list[Path]:
    """Return the folders `title@version` of the libraries that a project resolves."""
    if versions is None or not project.is_file():
        return []
    text = project.read_text(encoding="utf-8", errors="replace")
    names = dict.fromkeys("@".join(pair) for pair in _RESOLUTION.findall(text))
    return [versions / name for name in names if (versions / name).is_dir()]


def try_project(
    folder: Path, repository: Path, project: Path, versions: Path | None = None
) -> Outcome:
    """Load, check and run one project."""
    from achse.plc import Task
    from achse.plc.system_info import system_info_list
    from achse.st.check import check
    from achse.st.lexis.source import SourceError
    from achse.st.project import examine_project

    commit = repository / "COMMIT"
    name = project.relative_to(repository).as_posix()
    outcome = Outcome(repository.name.replace("+", "/"), "" if name == "." else name)
    if commit.exists():
        outcome.commit = commit.read_text().strip()
    libraries = [repository, *versions_of(project, versions), folder]
    try:
        examined, error = examine_project(project, libraries=libraries)
    except SourceError as nothing:
        outcome.errors, outcome.reason = 1, _first_line(str(nothing))
        return outcome
    tasks = [Task(task.name) for task in examined.tasks] or [Task()]
    system = system_info_list(tasks, app_name="", project_name="", port=851, timestamp=0)
    typed = check(
        examined.declarations,
        predefined=[system],
        reach=examined.reach,
        unreached=examined.unreached,
    )
    faults = list(dict.fromkeys([*(error.faults if error else ()), *typed.faults]))
    outcome.units, outcome.errors = len(examined.sources), len(faults)
    outcome.missing = [item.reference.title for item in examined.missing if item.uses]
    if examined.stubs and not outcome.missing:  # a use does not show which of them it means
        outcome.missing = [item.reference.title for item in examined.missing]
    if faults:
        outcome.reason = _first_line(str(min(faults, key=lambda fault: fault.location)))
        return outcome
    _run(outcome, project, libraries)
    return outcome


def _run(outcome: Outcome, project: Path, libraries: list[Path]) -> None:
    """A station with that PLC, until its slowest task had its cycles."""
    from achse.station import Station
    from achse.station.configuration.station_file import parse
    from achse.station.configuration.types import ConfigError

    plc_section = {"sources": str(project), "libraries": [str(item) for item in libraries]}
    try:
        station = Station(parse({"plc": [plc_section]}, "survey.toml"), base=project.parent)
    except ConfigError as fault:
        outcome.errors, outcome.reason = 1, _first_line(str(fault))
        return
    plc = station.plcs[851]
    tasks = [task for task in plc.tasks if task.programs] or plc.tasks
    slowest = max(task.cycle_ns for task in tasks)
    for _ in range(_SLICES):
        station.advance(slowest * CYCLES / _SLICES / 1e9)
        if plc.failure:
            break
    station.advance(slowest / 1e9)
    outcome.cycles = min(task.cycle_count for task in tasks)
    if plc.failure:
        said = str(plc.fault) if plc.fault is not None else plc.failure.strip().splitlines()[-1]
        outcome.reason = f"stopped after {outcome.cycles} cycles: {_first_line(said)}"
        outcome.cycles = min(outcome.cycles, CYCLES - 1)


def _first_line(text: str) -> str:
    return text.strip().splitlines()[0][:200] if text.strip() else ""


def survey(
    folder: Path,
    page: Path,
    only: Sequence[str] = (),
    begin: str = "",
    versions: Path | None = None,
) -> None:
    """Projects below a folder, each in a process of its own; the page follows each of them.

    `only` are words of which one is in the repository's name, `begin` the first repository,
    `versions` the folder of libraries at other commits.
    """
    jobs = [
        job
        for job in projects_below(folder)
        if job[0].name >= begin and (not only or any(word in job[0].name for word in only))
    ]
    before = page.read_text(encoding="utf-8") if page.exists() else ""
    rows = rows_of(before.partition("\n## ")[0])
    sections = "".join(before.partition("\n## ")[1:])
    with ThreadPoolExecutor(2) as pool:
        for outcome in pool.map(lambda job: _apart(folder, job[0], job[1], versions), jobs):
            rows[outcome.repository, outcome.project] = row_of(outcome)
            page.write_text(page_of(rows) + sections, encoding="utf-8")


def _apart(folder: Path, repository: Path, project: Path, versions: Path | None) -> Outcome:
    paths = [str(item) for item in (folder, repository, project, versions) if item is not None]
    command = [sys.executable, "-m", "tests.interop.survey", "--one", *paths]
    name = project.relative_to(repository).as_posix()
    failed = Outcome(repository.name.replace("+", "/"), name, errors=1)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        failed.reason = f"took longer than {LIMIT_S:.0f} s"
        return failed
    try:
        return Outcome(**json.loads(done.stdout.splitlines()[-1]))
    except (IndexError, ValueError):
        failed.reason = f"ended with {done.returncode}: {done.stderr.strip()[-200:]}"
        return failed


def rows_of(page: str) -> Rows:
    """The rows of a page that was written before."""
    cells = [line.split(" | ") for line in page.splitlines() if line.startswith("| ")]
    return {
        (row[0].removeprefix("| "), row[2]): " | ".join(row) for row in cells[2:] if len(row) > 2
    }


def own_fault(repository: str, project: str) -> str:
    """Return the fault of a project that cannot build or run anywhere; empty without one."""
    lines = _FAULTS.read_text(encoding="utf-8").splitlines()
    faults = {(name, path): fault for name, path, fault in (line.split("\t") for line in lines)}
    return faults.get((repository, project), "")


def row_of(item: Outcome) -> str:
    """The line of one project."""
    reason = item.reason.replace("|", "\\|").replace("`", "'")
    if item.errors > 1:
        reason = f"{item.errors} errors: {reason}"
    if item.errors and item.missing:
        reason = f"needs {', '.join(item.missing)}; {reason}"
    elif item.missing and not reason:
        reason = f"{_WITH_STUBS} {', '.join(item.missing)}"
    if not item.ran and (fault := own_fault(item.repository, item.project)):
        reason = f"{_OWN_FAULT}{fault}"
    return (
        f"| {item.repository} | {item.commit[:8]} | {item.project} | {item.units}"
        f" | {'yes' if item.loads else 'no'} | {item.cycles} | {reason} |"
    )


def page_of(rows: Rows) -> str:
    """The page of all projects, by repository and name."""
    cells = [line.split(" | ") for line in rows.values()]
    load = sum(row[4] == "yes" for row in cells)
    all_cycles = [row for row in cells if row[4] == "yes" and int(row[5]) >= CYCLES]
    with_stubs = sum(row[6].startswith(_WITH_STUBS) for row in all_cycles)
    faulty = sum(row[6].startswith(_OWN_FAULT) for row in cells)
    lines = [
        "# Public PLC projects",
        "",
        "Made by `python -m tests.interop.survey`, which loads every PLC project of a folder of"
        " checked-out repositories, checks all of it, and runs it for 1,000 cycles of its slowest"
        " task in virtual time. Libraries come from the same folder where their sources are there."
        " A project loads if no unit has an error."
        " A library comes in the version that the project's `.plcproj` resolves where the library's"
        " repository has a tag of that version, else in the newest."
        " Rows are of different days: those of repositories that were not at hand"
        " stay as they were."
        " Projects that move axes are in [a page of their own](motion-projects.md),"
        " [unseen projects](unseen-projects.md) in another,"
        " and results of the projects' own tests in [a third](project-tests.md).",
        "",
        f"{len(rows)} projects: {load} load, {len(all_cycles)} of them run 1,000 cycles"
        f" ({_percent(len(all_cycles), len(rows))} %),"
        f" {with_stubs} of these with stubs for libraries that are not here. {faulty} others have"
        f" a fault of their own and build or run nowhere: of the {len(rows) - faulty} without one,"
        f" {_percent(len(all_cycles), len(rows) - faulty)} % run.",
        "",
        "| repository | commit | project | units | loads | cycles | reason |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *(rows[key] for key in sorted(rows)),
    ]
    return "\n".join(lines) + "\n"


def _percent(part: int, of: int) -> int:
    """Return a share in whole percent, rounded down."""
    return 100 * part // max(of, 1)


def main(arguments: list[str]) -> None:
    """See the module."""
    if arguments[0] == "--one":
        print(json.dumps(asdict(try_project(*map(Path, arguments[1:])))))
        return
    folder, page, *options = arguments
    pairs = list(zip(options[::2], options[1::2], strict=True))
    only = [word for option, word in pairs if option == "--only"]
    begin = next((name for option, name in pairs if option == "--from"), "")
    versions = next(
        (Path(name).resolve() for option, name in pairs if option == "--versions"), None
    )
    survey(Path(folder).resolve(), Path(page), only, begin, versions)
    print(Path(page).read_text(encoding="utf-8").splitlines()[4])


if __name__ == "__main__":
    main(sys.argv[1:])
