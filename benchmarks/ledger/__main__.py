"""The ledger of instructions and allocations: what fixed works take, kept per commit.

    python benchmarks/ledger check                   fail if a work grew by more than 5 %
    python benchmarks/ledger add --reason TEXT       add lines for what changed by more than 5 %
    python benchmarks/ledger measure [WORK …]        print figures
    python benchmarks/ledger history WORK            print the lines of a work

Needs valgrind, x86-64 and Linux; elsewhere `check` says so and passes, unless ACHSE_WITNESSES is
"required". On a build without lines `check` measures the commit before beside it, and compares with
that. `add` and `measure` take `--commit COMMIT`: the sources of another commit, with these works.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from builds import Build, this_build
from figures import Finding, Line, append, compare, latest, read
from measuring import ROOT, Figures, LedgerUnavailable, Outcome, check_available, measure
from works import WORKS, Work

HERE = Path(__file__).parent
FIGURES, BUILDS = HERE / "figures.tsv", HERE / "builds.tsv"


def git(*arguments: str) -> str:
    """Return what git prints; empty if it fails."""
    ended = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return ended.stdout.strip() if ended.returncode == 0 else ""


def commit_of_tree() -> str:
    """Return the commit of this tree; with "+" if sources differ from it."""
    changed = git("status", "--porcelain", "--", "src", "benchmarks/ledger")
    return git("rev-parse", "--short=7", "HEAD") + ("+" if changed else "")


def chosen(names: Sequence[str]) -> list[Work]:
    """Return works by name, all without names; exits for a name that is none."""
    unknown = set(names) - {work.name for work in WORKS}
    if unknown:
        known = ", ".join(work.name for work in WORKS)
        sys.exit(f"unknown work {sorted(unknown)[0]!r}: expected one of {known}")
    return [work for work in WORKS if not names or work.name in names]


def show(outcomes: dict[str, Outcome]) -> None:
    """Print figures as a table."""
    print(f"{'work':<18}{'instructions':>16}{'allocations':>14}")
    for name, outcome in outcomes.items():
        if isinstance(outcome, str):
            print(f"{name:<18}  {outcome}")
        else:
            print(f"{name:<18}{outcome.instructions:>16,}{outcome.allocations:>14,.2f}")


def of_commit(commit: str, works: Sequence[Work]) -> dict[str, Outcome]:
    """Measure the sources of a commit."""
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(
            ["git", "archive", commit, "src"], cwd=ROOT, stdout=subprocess.PIPE, check=True
        )
        subprocess.run(["tar", "x", "-C", folder], input=archive.stdout, check=True)
        return measure(works, Path(folder))


def measured(works: Sequence[Work], commit: str) -> dict[str, Outcome]:
    """Measure this tree, or the sources of a commit."""
    return of_commit(commit, works) if commit else measure(works)


def check(names: Sequence[str]) -> int:
    """Compare with the newest lines of this build, or with the commit before; the exit code."""
    works, build = chosen(names), this_build()
    lines = latest(read(FIGURES), build.key)
    now = measure(works)
    show(now)
    if lines:
        before = {name: line.figures for name, line in lines.items()}
        reference = f"figures.tsv, build {build.key}"
    else:
        explain_unknown(build)
        commit = "HEAD" if commit_of_tree().endswith("+") else "HEAD^"
        if not git("rev-parse", "--verify", commit):
            print("no commit before this one here: nothing to compare with")
            return 0
        recorded = of_commit(commit, works)
        before = {name: each for name, each in recorded.items() if isinstance(each, Figures)}
        reference = f"commit {git('rev-parse', '--short=7', commit)}"
    if names:
        before = {name: each for name, each in before.items() if name in names}
    return report(compare(before, now), reference)


def explain_unknown(build: Build) -> None:
    """Print in what this build differs from those that have lines."""
    print(f"no lines of build {build.key}:")
    for line in BUILDS.read_text(encoding="utf-8").splitlines():
        other = Build.parse(line)
        print(f"  {other.key} has lines; here {'; '.join(build.differences(other))}")


def report(findings: Sequence[Finding], reference: str) -> int:
    """Print findings; return 1 if one fails."""
    for each in findings:
        print(f"{'FAILED ' if each.fails else ''}{each.work}: {each.text}")
    failed = any(each.fails for each in findings)
    if failed:
        print('Make it cheaper, or say why: python benchmarks/ledger add --reason "…"')
    else:
        print(f"no work grew, compared with {reference}")
    return int(failed)


def add(names: Sequence[str], reason: str, commit: str) -> None:
    """Add lines for works without one and for those that changed by more than 5 %."""
    build, works = this_build(), chosen(names)
    known = latest(read(FIGURES), build.key) if FIGURES.exists() else {}
    now = measured(works, commit)
    before = {name: line.figures for name, line in known.items()}
    changed = {finding.work for finding in compare(before, now)}
    commit = git("rev-parse", "--short=7", commit) if commit else commit_of_tree()
    lines = [
        Line(build.key, commit, name, outcome, " ".join(reason.split()))
        for name, outcome in now.items()
        if name in changed and isinstance(outcome, Figures)
    ]
    append(FIGURES, lines)
    if not known:
        with BUILDS.open("a", encoding="utf-8") as out:
            print(build.line(), file=out)
    for line in lines:
        print(f"added {line.work}: {line.figures.instructions:,} instructions")
    if not lines:
        print("nothing changed by more than 5 %: no line added")


def history(name: str) -> None:
    """Print the lines of a work."""
    [work] = chosen([name])
    print(f"{work.name}: {work.what}")
    for line in read(FIGURES):
        if line.work == name:
            instructions, allocations = line.figures
            figures = f"{instructions:>14,} {allocations:>12,.2f}"
            print(f"{line.build} {line.commit:<9}{figures}  {line.reason}")


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python benchmarks/ledger", description=__doc__.splitlines()[0]
    )
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("check", "add", "measure"):
        command = commands.add_parser(name)
        command.add_argument("works", nargs="*", metavar="WORK", help="all without one")
        if name == "add":
            command.add_argument("--reason", required=True, help="why figures differ")
        if name != "check":
            command.add_argument("--commit", default="", help="another commit's sources")
    commands.add_parser("history").add_argument("work", metavar="WORK")
    arguments = parser.parse_args()
    if arguments.command == "history":
        history(arguments.work)
        return
    try:
        check_available()
    except LedgerUnavailable as missing:
        required = os.environ.get("ACHSE_WITNESSES") == "required"
        print(f"the ledger is left out: {missing}")
        sys.exit(1 if required or arguments.command != "check" else 0)
    if arguments.command == "check":
        sys.exit(check(arguments.works))
    if arguments.command == "add":
        add(arguments.works, arguments.reason, arguments.commit)
    else:
        show(measured(chosen(arguments.works), arguments.commit))


if __name__ == "__main__":
    main()
