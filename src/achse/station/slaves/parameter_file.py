"""Parameters that drives store by 1010h, kept in a JSON file over restarts of the program."""

from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from pathlib import Path

from achse.codes import DataType, SdoAbort
from achse.drive.objects import find
from achse.station.persistence.state_file import StateFile

Number = int | float


class ParameterFileError(Exception):
    """A file cannot be read: says which, what was expected and what came."""


class ParameterFile:
    """Parameters that drives store; without a path they last as long as the program.

    The file is a table for each drive, by its number: `{"1": {"6072:00": 1500}}`.
    """

    def __init__(self, path: Path | None) -> None:
        self._drives: dict[str, dict[int, Number]] = {}
        self._file: StateFile | None = None
        if path is None:
            return
        self._file = StateFile(path)
        try:
            document = self._file.read_json()
            if document is not None:
                self._drives = {
                    str(int(number)): dict(_entry(*item) for item in table.items())
                    for number, table in document.items()
                }
        except OSError as failure:
            raise ParameterFileError(f"{path}: {failure.strerror}") from None
        except (ValueError, AttributeError) as fault:
            raise ParameterFileError(
                f"{path}: expected a table of INDEX:SUB and number for each drive; {fault}"
            ) from None

    def of(self, drive: int) -> MutableMapping[int, Number]:
        """Return the store of a drive, by index << 8 | subindex; what it is updated with is
        written."""
        return _Store(self, self._drives.setdefault(str(drive), {}))

    def write(self) -> None:
        """Write all. OSError if the file cannot be written; the old one is then whole."""
        if self._file is None:
            return
        document = {
            number: {f"{key >> 8:04X}:{key & 0xFF:02X}": value for key, value in values.items()}
            for number, values in self._drives.items()
            if values
        }
        self._file.write_json(document)


class _Store(MutableMapping[int, Number]):
    """The values of one drive."""

    def __init__(self, file: ParameterFile, values: dict[int, Number]) -> None:
        self._file = file
        self._values = values

    def __getitem__(self, key: int) -> Number:
        return self._values[key]

    def __setitem__(self, key: int, value: Number) -> None:
        self.update({key: value})

    def __delitem__(self, key: int) -> None:
        del self._values[key]
        self._file.write()

    def __iter__(self) -> Iterator[int]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def update(  # type: ignore[override]
        self, other: Mapping[int, Number] | Iterable[tuple[int, Number]] = (), /
    ) -> None:
        self._values.update(other)
        self._file.write()


def _entry(entry: str, value: object) -> tuple[int, Number]:
    """Key and value of an entry; raises ValueError for what the dictionary does not allow."""
    index, _, subindex = entry.partition(":")
    number = not isinstance(value, bool) and isinstance(value, int | float) and value
    if number is False:
        raise ValueError(f"got {entry}: {value!r}")
    try:
        row = find(int(index, 16), int(subindex, 16))
        row.check(number)
    except SdoAbort as refusal:
        raise ValueError(f"{entry}: {value}: {refusal.code.text}") from None
    return row.key, number if row.type is DataType.F32 else int(number)
