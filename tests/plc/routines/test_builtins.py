"""Library routines without Structured Text."""

from tests.plc.code.conftest import Ran


def test_memory_by_address() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a : ARRAY[0..3] OF INT := [1, 2, 3, 4]; b : ARRAY[0..3] OF INT;"
        " n : UDINT; c : DINT; d : DINT; z : UDINT; END_VAR"
        " n := MEMCPY(ADR(b), ADR(a), SIZEOF(a)); c := MEMCMP(ADR(a), ADR(b), 8);"
        " MEMSET(ADR(b), 255, 2); d := MEMCMP(ADR(a), ADR(b), 8);"
        " MEMMOVE(ADR(a[1]), ADR(a[0]), 6); z := MEMCPY(0, ADR(a), 8); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["a"], ran["b"]) == ([1, 1, 2, 3], [-1, 2, 3, 4])
    assert (ran["n"], ran["c"], ran["d"], ran["z"]) == (8, 0, -1, 0)


def test_a_copy_beyond_memory_is_an_access_violation_and_copies_nothing() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a : INT := 7; END_VAR MEMSET(ADR(a), 0, 16#7FFFFFFF); END_PROGRAM"
    ).cycle()
    assert ran.stopped.name == "ACCESS_VIOLATION"
    assert ran["a"] == 7


def test_the_running_task_and_its_time() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR t : GETCURTASKINDEX; c : GETCPUCOUNTER; n : BYTE; END_VAR"
        " t(index => n); c(); END_PROGRAM"
    ).cycle(2)
    assert ran["n"] == 1
    assert ran["c.cpuCntLoDW"] == 200_000
