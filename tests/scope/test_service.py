"""The modern face: groups and words are what pages and clients know."""

from achse.scope.service import SAMPLES_REQUEST, SCOPE_PORT, ScopeCommand, ScopeGroup


def test_numbers_and_words_stay() -> None:
    assert SCOPE_PORT == 14_000
    assert [int(group) for group in ScopeGroup] == [0x1000, 0x2000, 0x3000, 0xFA10, 0xFA11]
    assert list(ScopeCommand) == ["start", "stop", "trigger", "close", "progress"]
    assert SAMPLES_REQUEST.pack(1, 2) == bytes((1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0))
