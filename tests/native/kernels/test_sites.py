"""Sites of faults."""

from achse.native.kernels.sites import Sites, TrapSite

INDEX = TrapSite("IndexError", "index {0} of {1} elements", "wheels.py", 7, "turn")
ZERO = TrapSite("ZeroDivisionError", "division by zero", "wheels.py", 9, "turn")


def test_equal_sites_are_one() -> None:
    sites = Sites()
    assert [sites.number(each) for each in (INDEX, ZERO, INDEX)] == [1, 2, 1]


def test_sites_go_with_the_code() -> None:
    sites = Sites()
    sites.number(INDEX)
    sites.number(ZERO)
    again = Sites(sites.pack())
    assert (again[1], again[2]) == (INDEX, ZERO)


def test_a_site_raises_what_python_raises() -> None:
    error = INDEX.exception(-3, 2)
    assert isinstance(error, IndexError)
    assert str(error) == "wheels.py:7: turn: index -3 of 2 elements"
