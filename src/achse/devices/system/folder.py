"""The one folder that file services show: names that clients send, as paths that never leave it.

Whatever a name tries (`..`, another computer, a device, a link that leads out, a NUL, an endless
text), it names nothing: 0x70C, which is what a wrong path is answered with. An absolute path, `/x`
or `C:\\TwinCAT\\x`, begins at the one folder: `x` and `TwinCAT/x` in it.

Upper and lower case are the same, as on the targets: what is spelled exactly so comes first, else
the one name that differs in nothing but case. Where several do, the name means none of them.
"""

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from fnmatch import translate
from pathlib import Path

from achse.ams import DeviceError
from achse.codes import ReturnCode

_LONGEST = 255
"""Bytes of a path; PLC code has a STRING(255) for it."""

_MOST_NAMES = 100_000
"""In a folder that is searched."""

_PLACES = {
    0: "",
    1: "",
    **dict.fromkeys((2, 3, 4), "Boot"),
    5: "Target",
    6: "Config",
    **{number: f"User{number - 10}" for number in range(11, 20)},
}
"""Folders by the path number of a request: any, boot project, boot data, boot folder, target,
configuration, nine folders of the user. On this station all are below the one folder.

000 §5.1 has 1 (any); the others are in no manual at hand and are what PLC libraries send."""

_RESERVED = re.compile(
    r"(?:con|prn|aux|nul|com[\d¹²³]|lpt[\d¹²³]|conin\$|conout\$|clock\$) *(?:\.|$)", re.IGNORECASE
)
"""Names of devices where the station runs on Windows, whatever is behind a dot."""
_ABSOLUTE = re.compile(r"(?:[A-Za-z]:)?/")
"""Beginning of an absolute path: such a path begins at the one folder, whatever place is named."""
_NEVER = re.compile(r'[\x00-\x1f<>:"|]')
_WILD = re.compile(r"[*?]")


class Folder:
    """A folder and the names in it."""

    def __init__(self, root: Path) -> None:
        self.root = root.resolve()

    def path(self, name: bytes, place: int, *, itself: bool = False) -> Path:
        """Return the path that a client's `name` means at a numbered place.

        `itself`: a link in the last position is meant, not what it leads to. Raises DeviceError
        0x703 for an unknown place, 0x70C for a name that is none or leads out.
        """
        parts = self._parts(name, place)
        if any(_WILD.search(part) for part in parts):
            raise _nothing(name)
        if not parts:
            raise _nothing(name)
        return self._inside(parts, name, itself)

    def matching(self, pattern: bytes, place: int) -> tuple[Path, list[str]]:
        """Return a folder, and the names in it that a pattern means, sorted.

        Wildcards are in the last part only; without them it means the one name. Whether what a
        name stands for is in the folder at all, `holds` returns. Raises DeviceError as `path` does,
        0x70A for a folder with too many names.
        """
        parts = self._parts(pattern, place)
        if any(_WILD.search(part) for part in parts[:-1]):
            raise _nothing(pattern)
        if not parts or not _WILD.search(parts[-1]):
            path = self._inside(parts, pattern, False)
            return path.parent, [path.name] if path.exists() else []
        folder = self._inside(parts[:-1], pattern, False)
        if not folder.is_dir():
            return folder, []
        matches = re.compile(translate(_folded(parts[-1]).replace("[", "[[]"))).match
        everything = parts[-1] in ("*", "*.*")  # the latter is every name, as ever
        names = []
        with os.scandir(folder) as entries:
            for number, entry in enumerate(entries):
                if number >= _MOST_NAMES:
                    raise DeviceError(
                        ReturnCode.DEVICE_NO_MEMORY, f"more than {_MOST_NAMES} names in a folder"
                    )
                if everything or matches(_folded(entry.name)):
                    names.append(entry.name)
        return folder, sorted(names)

    def holds(self, path: Path) -> bool:
        """Return True if the entry at `path` is in the folder and no link that leads out."""
        try:
            return not path.is_symlink() or _resolved(path).is_relative_to(self.root)
        except (OSError, RuntimeError):
            return False

    def last_name(self, name: bytes, place: int) -> str:
        """Return the last part of a name that `path` takes, spelled as the client does."""
        return self._parts(name, place)[-1]

    def _parts(self, name: bytes, place: int) -> list[str]:
        if place not in _PLACES:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"path number {place}")
        name = name.removesuffix(b"\0")
        if len(name) > _LONGEST or b"\0" in name:
            raise _nothing(name)
        text = _decoded(name).replace("\\", "/")
        absolute = _ABSOLUTE.match(text)
        if absolute is not None:
            text = text[absolute.end() :]
        if text.startswith("/") or _NEVER.search(text):
            raise _nothing(name)
        parts = [part for part in text.split("/") if part not in ("", ".")]
        for part in parts:
            wild = _WILD.search(part)
            if part == ".." or _RESERVED.match(part) or (part[-1] in ". " and not wild):
                raise _nothing(name)
        start = "" if absolute is not None else _PLACES[place]
        return [start, *parts] if start else parts

    def _inside(self, parts: list[str], name: bytes, itself: bool) -> Path:
        path = self.root
        for left, part in zip(range(len(parts) - 1, -1, -1), parts, strict=True):
            path /= _spelled(path, part)
            if left or not itself:
                try:
                    path = _resolved(path)
                except (OSError, RuntimeError):  # links in a circle
                    raise _nothing(name) from None
                if not path.is_relative_to(self.root):
                    raise _nothing(name)
        return path


def _spelled(folder: Path, name: str) -> str:
    """Return the spelling of `name` in `folder`; a name that is not there is new and stays
    unchanged."""
    if os.path.lexists(folder / name):
        return name
    try:
        with os.scandir(folder) as entries:
            alike = [each.name for each in entries if _folded(each.name) == _folded(name)]
    except OSError:  # no folder, or none to look into
        return name
    if len(alike) > 1:
        raise DeviceError(ReturnCode.NOT_FOUND, f"{name!r} may be {' or '.join(sorted(alike))}")
    return alike[0] if alike else name


def _folded(name: str) -> str:
    """Without case: sign by sign, so that no other letters become alike (ß is not ss)."""
    if name.isascii():
        return name.upper()
    return "".join(upper if len(upper := sign.upper()) == 1 else sign for sign in name)


def _decoded(name: bytes) -> str:
    try:
        return name.decode()
    except UnicodeDecodeError:
        return name.decode("cp1252", "replace")


def as_name(path: Path) -> bytes:
    """Return the name of a file as it goes to a client."""
    return path.name.encode("utf-8", "surrogateescape")


def _nothing(name: bytes) -> DeviceError:
    return DeviceError(ReturnCode.NOT_FOUND, f"path {name[:60]!r}")


_CODES = {
    errno.EEXIST: ReturnCode.EXISTS,
    errno.ENOTEMPTY: ReturnCode.EXISTS,
    errno.EACCES: ReturnCode.DEVICE_ACCESS_DENIED,
    errno.EPERM: ReturnCode.DEVICE_ACCESS_DENIED,
    errno.EROFS: ReturnCode.DEVICE_ACCESS_DENIED,
    errno.ENOSPC: ReturnCode.DEVICE_NO_MEMORY,
    errno.EDQUOT: ReturnCode.DEVICE_NO_MEMORY,
    errno.EFBIG: ReturnCode.DEVICE_NO_MEMORY,
    **dict.fromkeys(
        (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL),
        ReturnCode.NOT_FOUND,
    ),
}


@contextmanager
def device_errors() -> Iterator[None]:
    """Context manager that raises an OSError as a DeviceError with the code of the same meaning."""
    try:
        yield
    except OSError as failure:
        code = _CODES.get(failure.errno or 0, ReturnCode.DEVICE_ERROR)
        raise DeviceError(code, failure.strerror or "") from failure


def _resolved(path: Path) -> Path:
    """Return the target of links. OSError for links in a circle, which Python 3.13 leaves as they
    are."""
    resolved = path.resolve()
    if resolved.is_symlink():
        raise OSError(errno.ELOOP, "links in a circle", str(path))
    return resolved
