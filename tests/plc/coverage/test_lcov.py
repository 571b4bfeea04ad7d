"""The tracefile of lcov, as a reader takes it."""

from achse.plc.coverage.lcov import tracefile_of
from achse.plc.coverage.results import CoverageResult


def test_the_tracefile_sums_up_what_it_lists(result: CoverageResult) -> None:
    (file,) = result.files
    lines: dict[int, int] = {}
    branches: dict[tuple[int, ...], str] = {}
    calls: dict[str, int] = {}
    found: dict[str, int] = {}
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
                found[kind] = int(value)
    assert found == {
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
    assert (found["BRF"], found["BRH"]) == (covered.branches, covered.branches_hit)
