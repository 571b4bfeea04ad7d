"""Faults say what they are."""

from achse.native.backend.faults import RUNTIME, MachineFault, OwnFault


def test_own_faults_have_names() -> None:
    assert str(MachineFault(OwnFault.TOO_DEEP)) == "fault TOO_DEEP (0, 0)"
    assert str(MachineFault(7, 1, 2)) == "fault 7 (1, 2)"
    assert all(number < 0 for number in OwnFault)


def test_the_runtime_declares_each_symbol_once() -> None:
    assert RUNTIME.count("= dso_local global") == 4
