"""Results of tools: what an agent gets, with the schema that it reads."""

from typing import Any

from pydantic import BaseModel, ConfigDict


def _without_titles(schema: dict[str, Any]) -> None:
    """Leave titles out of a schema: an agent pays for it in every conversation."""
    schema.pop("title", None)
    for each in schema.get("properties", {}).values():
        each.pop("title", None)


class _Result(BaseModel):
    """A result with a short schema."""

    model_config = ConfigDict(json_schema_extra=_without_titles)


class CodeFinding(_Result):
    """A finding; lines and columns count from 1, the end is behind the last character."""

    severity: str
    code: str
    file: str
    line: int
    column: int
    end_line: int
    end_column: int
    message: str


class CheckReport(_Result):
    """Findings of a project; `ok` is True if none of them is an error."""

    ok: bool
    sources: int
    errors: int
    warnings: int
    lint: int
    findings: list[CodeFinding]
    left_out: int


class CodeExplanation(_Result):
    """Meaning and remedy of a finding's code."""

    code: str
    title: str
    meaning: str
    remedy: str
    wrong: dict[str, str]
    right: dict[str, str]


class SymbolMatch(_Result):
    """A declared name: `name` is what read_code takes."""

    name: str
    kind: str
    file: str
    line: int


class SymbolMatches(_Result):
    """Symbols that match."""

    symbols: list[SymbolMatch]
    left_out: int


class CodeExcerpt(_Result):
    """Declaration and body of a unit, method, action or property."""

    name: str
    kind: str
    file: str
    line: int
    text: str
    parts: list[str]
    left_out: int
    """Characters that were left out."""


class EditReport(_Result):
    """An edit that was made, and what the checker says about the project now."""

    file: str
    line: int
    check: CheckReport


class PlcReport(_Result):
    """A PLC: `fault` has cause and place if it stopped."""

    port: int
    name: str
    state: str
    fault: str = ""


class AxisReport(_Result):
    """An axis, in its unit and seconds."""

    id: int
    name: str
    position: float
    velocity: float
    set_position: float
    enabled: bool
    homed: bool
    in_target: bool
    state: str
    error_code: int
    error: str = ""


class DriveReport(_Result):
    """A slave of a bus, with the state of its drive if it has one."""

    station: int
    name: str
    state: str
    al_code: int
    present: bool
    power_state: str = ""


class BusReport(_Result):
    """A bus and its slaves."""

    name: str
    operational: bool
    slaves: list[DriveReport]


class StationReport(_Result):
    """A station; equal histories have equal digests."""

    station: str
    time_s: float
    digest: str
    plcs: list[PlcReport]
    axes: list[AxisReport]
    buses: list[BusReport]
    warnings: list[str]
    runs: list[str]


class RunReport(_Result):
    """Time that passed; `reason`: done, plc stopped, or time limit. `run` names a recording."""

    time_s: float
    passed_s: float
    reason: str
    plcs: list[PlcReport]
    run: str = ""


class VariableValues(_Result):
    """Values by name; what cannot be read or written is in `errors`."""

    values: dict[str, Any]
    errors: dict[str, str]


class FaultReports(_Result):
    """Faults that wait or are active; `kinds` if asked for."""

    active: list[dict[str, Any]]
    kinds: dict[str, str]


class TestFailure(_Result):
    """An assertion that did not hold."""

    __test__ = False

    message: str
    expected: str
    actual: str
    file: str
    line: int


class TestResult(_Result):
    """A test and its outcome."""

    __test__ = False

    suite: str
    name: str
    outcome: str
    failures: list[TestFailure]


class TestReport(_Result):
    """Outcome of the tests; `tests` are those that did not pass."""

    __test__ = False

    ok: bool
    passed: int
    failed: int
    skipped: int
    unfinished: int
    plc_time_s: float
    problem: str
    tests: list[TestResult]
    left_out: int


class TraceColumn(_Result):
    """A channel of a recording: extremes, and the time of each in s."""

    name: str
    unit: str
    samples: int
    minimum: float
    minimum_at: float
    maximum: float
    maximum_at: float
    last: float


class TraceTable(_Result):
    """A recording: rows are time in s and the value of each column, None where it has none."""

    run: str
    columns: list[TraceColumn]
    rows: list[list[float | int | bool | None]]
    left_out: int


class RunDifference(_Result):
    """First and largest difference of a channel; times in s."""

    name: str
    first_at: float
    first_a: float
    first_b: float
    largest: float
    largest_at: float


class RunComparison(_Result):
    """Two recordings; `equal`: same channels, same samples within the tolerance."""

    equal: bool
    only_a: list[str]
    only_b: list[str]
    lengths: dict[str, list[int]]
    differences: list[RunDifference]
