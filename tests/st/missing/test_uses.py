"""What is known of a missing name grows with its uses."""

from achse.st.missing.uses import LONG_TEXT, MissingUse


def test_literals_are_weak_evidence() -> None:
    use = MissingUse("x")
    for type, known in [
        ("", ""),
        ("DINT", "DINT"),
        ("LREAL", "LREAL"),
        ("DINT", "LREAL"),
        ("REAL", "REAL"),
    ]:
        use.note_type(type)
        assert use.type == known
    assert not use.is_mixed
    use.note_type("BOOL")
    assert (use.type, use.is_mixed) == ("REAL", True)


def test_texts_and_numbers_are_mixed() -> None:
    use = MissingUse("x")
    use.note_type(LONG_TEXT)
    use.note_type("INT")
    assert (use.type, use.is_mixed) == ("INT", True)


def test_members_without_case() -> None:
    use = MissingUse("x")
    assert use.member("bDone") is use.member("BDONE")
    assert use.members["bdone"].name == "bDone"
