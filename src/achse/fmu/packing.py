"""Files of a station: those that are read while it is built, and those that the user names."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import source_from_cache
from os.path import commonpath
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from achse.fmu.errors import ExportError
from achse.native.backend.cache import cache_directory
from achse.station.configuration.documents import parse_toml

_MOST_BYTES = 1 << 28

_watched: list[set[Path]] = []
"""Sets that get the files that are opened; the last one is of the innermost `files_read`."""

_hooked = False


class Packed(NamedTuple):
    """The files by their paths in the unit, and the path of the station file."""

    files: Mapping[str, Path]
    station: str


def _on_open(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or not _watched:
        return
    name, mode = arguments[0], arguments[1]
    if isinstance(name, str) and (mode is None or not set(str(mode)) & set("wax+")):
        _watched[-1].add(Path(name))


@contextmanager
def files_read() -> Iterator[set[Path]]:
    """Collect the files that are opened for reading meanwhile."""
    global _hooked
    if not _hooked:
        sys.addaudithook(_on_open)
        _hooked = True
    files: set[Path] = set()
    _watched.append(files)
    try:
        yield files
    finally:
        _watched.pop()


def packed_files(station_file: Path, read: set[Path], include: list[Path]) -> Packed:
    """Return the files of a station below their common folder. Raises ExportError, OSError.

    Files of Python, of achse and of caches stay out.
    """
    base = station_file.resolve().parent
    sources = {station_file.resolve()}
    for path in read:
        source = _source_of(path)
        if source.suffix != ".pyc" and source.is_file() and _belongs(source.resolve(), base):
            sources.add(source.resolve())
    for path in include:
        if not path.exists():
            raise ExportError(f"--include: expected a file or folder, got {str(path)!r}")
        inner = path.rglob("*") if path.is_dir() else [path]
        sources |= {each.resolve() for each in inner if each.is_file()}
    size = sum(each.stat().st_size for each in sources)
    if size > _MOST_BYTES:
        raise ExportError(f"files: expected at most {_MOST_BYTES} bytes, got {size}")
    root = Path(commonpath([base, *(each.parent for each in sources)]))
    files = {_below(root, each): each for each in sorted(sources)}
    return Packed(files, _below(root, station_file.resolve()))


def _below(root: Path, file: Path) -> str:
    return str(PurePosixPath("station") / file.relative_to(root).as_posix())


def _source_of(path: Path) -> Path:
    """Return the source of a compiled module; other files are their own."""
    if path.suffix != ".pyc":
        return path
    prefix = sys.pycache_prefix
    if prefix is not None and path.is_relative_to(prefix):
        source = Path("/", path.relative_to(prefix))
        return source.with_name(path.name.partition(".")[0] + ".py")
    try:
        return Path(source_from_cache(str(path)))
    except ValueError:
        return path


def _belongs(file: Path, base: Path) -> bool:
    """Return True if a file is the user's: beside the station, or in no folder of a program."""
    if file.is_relative_to(base) and ".venv" not in file.relative_to(base).parts:
        return True
    places = [Path(__file__).parents[1], Path(sys.prefix), Path(sys.base_prefix)]
    places.append(cache_directory())
    places += [Path("/proc"), Path("/sys"), Path("/dev"), Path("/etc"), Path("/usr")]
    return not (
        any(file.is_relative_to(each.resolve()) for each in places)
        or any(part in (".cache", "__pycache__", "site-packages") for part in file.parts)
    )


def refuse_absolute_paths(station_file: Path) -> None:
    """Raise ExportError if the station file names files by absolute paths."""
    document = parse_toml(station_file.read_text(encoding="utf-8-sig"))
    for key, value in _texts("", document):
        if key.startswith("system.programs"):
            continue
        if Path(value).is_absolute() and Path(value).exists():
            raise ExportError(
                f"{key}: expected a path relative to the station.toml, got {value!r}:"
                " a unit goes to other computers"
            )


def _texts(key: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _texts(f"{key}.{name}" if key else name, inner)
    elif isinstance(value, list):
        for number, inner in enumerate(value, 1):
            yield from _texts(f"{key}[{number}]", inner)
