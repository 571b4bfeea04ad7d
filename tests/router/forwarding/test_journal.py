"""The journal names the handles at targets, whatever becomes of the process and its disk."""

import logging
from collections import Counter
from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.router.forwarding.journal import HandleJournal, JournalError, JournalHandle

ALIASES = [bytes([n]) * 8 for n in range(1, 4)]
DEVICES = [b"target" + bytes([n, 3]) for n in range(2)] + [b"others\1\2"]

STEP = st.tuples(
    st.sampled_from(("asked", "fetched", "fetched", "released", "client", "device", "reopen")),
    st.sampled_from(ALIASES),
    st.sampled_from(DEVICES),
    st.integers(1, 5),
)


class Disk(BytesIO):
    """A file on a disk with room for so many bytes; with `broken` nothing can be written."""

    room = 1 << 40
    broken = False

    def write(self, data: bytes) -> int:  # type: ignore[override]
        if self.broken:
            raise OSError(5, "Input/output error")
        fits = max(0, self.room - self.tell())
        if not fits:
            raise OSError(28, "No space left on device")
        return super().write(data[:fits])


def contents(journal: HandleJournal) -> Counter[JournalHandle]:
    return Counter(
        {
            each: count
            for net_id in (b"target", b"others")
            for each, count in journal.handles_at(net_id)
        }
    )


@given(st.lists(STEP, max_size=60))
def test_next_process_finds_what_the_last_one_wrote(
    steps: list[tuple[str, bytes, bytes, int]],
) -> None:
    file = BytesIO()
    journal = HandleJournal(file)
    expected: Counter[JournalHandle] = Counter()
    for kind, alias, device, handle in steps:
        key = JournalHandle(alias, device, handle)
        match kind:
            case "asked":
                journal.add_requester(alias, device)
                expected[key._replace(handle=0)] = 1
            case "fetched":
                journal.fetched(*key)
                expected[key] += 1
            case "released":
                journal.released(*key)
                expected[key] -= expected[key] > 0
            case "client":
                journal.forget_client(alias, device[:6])
                for each in list(expected):
                    if each.alias == alias and each.device[:6] == device[:6] and not each.handle:
                        del expected[each]
            case "device":
                journal.forget_device(device)
                for each in list(expected):
                    if each.device == device:
                        del expected[each]
            case _:
                file = BytesIO(file.getvalue())
                journal = HandleJournal(file)
        expected += Counter()
        assert contents(journal) == expected
        assert len(journal) == sum(n for each, n in expected.items() if each.handle)
    order = list(contents(journal))
    reopened = HandleJournal(BytesIO(file.getvalue()))
    assert list(contents(reopened)) == order
    assert len(file.getvalue()) <= 32 * (1 + 128 * (1 + len(steps) // 128))


@given(st.integers(1, 300), st.data())
def test_torn_journal_loses_the_torn_records_alone(count: int, data: st.DataObject) -> None:
    file = BytesIO()
    journal = HandleJournal(file)
    for handle in range(1, count + 1):
        journal.fetched(ALIASES[0], DEVICES[0], handle)
    length = data.draw(st.integers(32, len(file.getvalue())))
    torn = bytearray(file.getvalue()[:length])
    if length > 32:
        place = data.draw(st.integers(32, length - 1))
        torn[place] ^= data.draw(st.integers(1, 255))
    next_file = BytesIO(torn)
    handles = contents(HandleJournal(next_file))
    assert set(handles) <= set(contents(journal))
    whole = sum(32 * slot + 32 <= length for slot in range(1, 1 + -(-count // 128) * 128))
    assert len(handles) >= min(count, whole) - (-(-count // 128) * 128 - count) - 1
    HandleJournal(next_file).fetched(ALIASES[1], DEVICES[0], 1)
    assert next_file.getvalue()[:32] == file.getvalue()[:32]


def test_another_file_is_not_overwritten() -> None:
    text = b"[router]\nhost = '127.0.0.1'\nnet_id = '1.2.3.4.1.1'\n"
    file = BytesIO(text)
    with pytest.raises(JournalError, match="not a journal"):
        HandleJournal(file)
    assert file.getvalue() == text


@given(st.integers(32, 32 * 400), st.integers(1, 500))
def test_full_disk_is_reported_once_and_leaves_no_released_handle(room: int, count: int) -> None:
    file = Disk()
    journal = HandleJournal(file)
    file.room = room
    with _Warnings() as warnings:
        for handle in range(1, count + 1):
            journal.fetched(ALIASES[0], DEVICES[0], handle)
        assert len(journal) == count
        for handle in range(1, count + 1, 2):
            journal.released(ALIASES[0], DEVICES[0], handle)
    full = room < 32 * (1 + -(-count // 128) * 128)
    assert len(warnings) == full
    known = contents(HandleJournal(BytesIO(file.getvalue())))
    assert set(known) <= set(contents(journal))
    assert full or known == contents(journal)


def test_file_that_cannot_be_kept_true_is_emptied(caplog: pytest.LogCaptureFixture) -> None:
    file = Disk()
    journal = HandleJournal(file)
    journal.fetched(ALIASES[0], DEVICES[0], 1)
    file.broken = True
    journal.released(ALIASES[0], DEVICES[0], 1)
    journal.fetched(ALIASES[0], DEVICES[0], 2)
    assert len(journal) == 1
    assert file.getvalue() == b""
    assert caplog.text.count("cannot be written: Input/output error") == 1


class _Warnings(logging.Handler):
    """Counts warnings of the router."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.count = 0

    def __len__(self) -> int:
        return self.count

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1

    def __enter__(self) -> "_Warnings":
        logging.getLogger("achse.router").addHandler(self)
        return self

    def __exit__(self, *_: object) -> None:
        logging.getLogger("achse.router").removeHandler(self)
