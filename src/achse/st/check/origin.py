"""Digest of the inputs of a typed project: it differs wherever the project could.

Inputs are the contents of all sources that were read, wherever their files are, all constants that
were computed from them or passed in, and the declarations of the runtime. The digest is the key of
cached results.
"""

import hashlib
from collections.abc import Iterable

from achse.iec.structs import StaticRecord
from achse.st.declared.resolve import Resolver


def origin_of(
    names: Resolver, predefined: Iterable[type[StaticRecord]], *, check_bounds: bool = True
) -> str:
    """40 hexadecimal digits; call it when everything is checked, and so worked out."""
    digest = hashlib.blake2b(b"" if check_bounds else b"unchecked", digest_size=20)
    entries = names.scopes.entries
    sources = {id(entry.source): entry.source for entry in entries.values()}
    for source in sources.values():
        digest.update(source.content_digest + f"{source.library}\0".encode())
    # Which of their parts count can depend on names that were defined for the parser, but not in
    # the libraries that achse has.
    own = (f"{name}:{entry.at}" for name, entry in entries.items() if not entry.is_built_in)
    digest.update(" ".join(own).encode())
    for owner, name, value in names.constants.known():
        digest.update(f"{owner} {name} {value!r}\0".encode("utf-8", "surrogatepass"))
    for name, type in names.predefined.handed_in.items():
        digest.update(f"{name} {type.name} {type.guid!r}\0".encode())
    for unit in predefined:
        record = unit.__iec__
        digest.update(f"{record.name} {record.guid!r}".encode() + record.default)
    return digest.hexdigest()
