"""The tracefile of lcov, as a reader takes it."""

from achse.plc.code.execution import CodeForm
from achse.plc.coverage.lcov import tracefile_of
from achse.plc.coverage.results import CoverageResult
from tests.plc.coverage.conftest import DECISIONS, Counting


def test_the_tracefile_sums_up_what_it_lists(result: CoverageResult) -> None:
    (file,) = result.files
    lines: dict[int, int] = {}
    branches: dict[tuple[int, ...], str] = {}
    calls: dict[str, int] = {}
    sums: dict[str, int] = {}
    text = tracefile_of(result)
    assert text.startswith("TN:\nSF:a.st\n")
    assert text.endswith("\nend_of_record\n")
    for line in text.splitlines():
        kind, _, value = line.partition(":")
        match kind:
            case "DA":
                number, hits = map(int, value.split(","))
                assert number not in lines
                lines[number] = hits
            case "BRDA":
                at, block, branch, taken = value.split(",")
                key = (int(at), int(block), int(branch))
                assert key not in branches
                branches[key] = taken
            case "FNDA":
                hits_text, name = value.split(",")
                calls[name] = int(hits_text)
            case "FNF" | "FNH" | "BRF" | "BRH" | "LF" | "LH":
                sums[kind] = int(value)
    assert sums == {
        "FNF": len(calls),
        "FNH": sum(map(bool, calls.values())),
        "BRF": len(branches),
        "BRH": sum(taken not in ("-", "0") for taken in branches.values()),
        "LF": len(lines),
        "LH": sum(map(bool, lines.values())),
    }
    assert lines == file.lines
    assert calls["F_Recursion"] == 4
    never = [taken for taken in branches.values() if taken == "-"]
    assert len(never) == 2  # the third condition of F_ElsifFault
    covered = result.covered
    assert (sums["BRF"], sums["BRH"]) == (covered.branches, covered.branches_hit)


def test_conditions_are_groups_by_their_number() -> None:
    text = DECISIONS.read_text(encoding="utf-8")
    result = Counting(text, CodeForm.PLAIN, conditions=True).run().result
    lines = tracefile_of(result).splitlines()
    assert [line for line in lines if line.startswith("MCDC:6,")] == [
        "MCDC:6,2,t,1,0,a",
        "MCDC:6,2,f,1,0,a",
        "MCDC:6,2,t,1,1,b",
        "MCDC:6,2,f,1,1,b",
    ]
    rows = [line.removeprefix("MCDC:").split(",", 5) for line in lines if line[:5] == "MCDC:"]
    keys = [tuple(row[:3] + row[4:5]) for row in rows]
    assert len(set(keys)) == len(keys)
    for line, size, *_ in rows:
        indices = {int(row[4]) for row in rows if row[:2] == [line, size]}
        assert indices == set(range(int(size)))
    assert f"MCF:{len(rows)}" in lines
    assert f"MCH:{sum(row[3] != '0' for row in rows)}" in lines
    hit = {line.split(",")[0][3:] for line in lines if line.startswith("DA:")}
    assert {row[0] for row in rows} <= hit
