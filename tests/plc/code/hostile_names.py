"""Names that Structured Text may have and Python, emitted code or machine code have, too."""

import builtins
import dis
import keyword
import re

from hypothesis import strategies as st

from achse.iec.names import ELEMENTARY
from achse.st.check.builtins import is_builtin
from achse.st.lexis.words import KEYWORDS

PYTHON = {*keyword.kwlist, *keyword.softkwlist, *dir(builtins), *dir(type), *dis.opmap, "self"}
_LETTERS = (f"{letter}{number}" for letter in "fotxv" for number in ("", *range(10)))
_VIEWS = (f"{letter}_{code}" for letter in "tA" for code in "bBhHiIqQfd")
_WORDS = """
again body call caught clock dispatched enter entry exhausted failure frame fuel hold iec instance
items keys kind leave members misaligned missing offset plain raised retain returned size stack
stack_here achse_stack symbol table text_made this value words v_a v_v_a routine_main CATCHABLE DOT
routine_sumDOTa K_1 U62U vU62U F
"""
EMITTED = {*_LETTERS, *_VIEWS, *_WORDS.split()}
_ALIKE = """
µ μ ﬁ fi ª º x² x2 x₂ ß ss ẞ K ſ s ı i ﬀ ff é ℮ Ⅷ viii ａ ａｂ Ω Ω ö ö𝐱 𝐱 h ℎ ǆ ǅ ด
ب 名 名前
"""
ALIKE = _ALIKE.split()
"""Python reads several of these as one, or takes them for no identifier."""
LONG = ["n" * 40, "n" * 41, "n" * 254, "n" * 255, "é" * 255, "名" * 255]

RESERVED = {word.lower() for word in KEYWORDS | ELEMENTARY.keys()} | {"true", "false", "null"}


def is_free(name: str) -> bool:
    """True for an identifier of Structured Text that has no meaning of its own."""
    is_name = re.fullmatch(r"\w+", name) and (name[0].isalpha() or name[0] == "_")
    is_reserved = name.startswith("__") or name.lower() in RESERVED or is_builtin(name)
    return bool(is_name) and not is_reserved


POOL = sorted(
    name
    for name in {*PYTHON, *EMITTED, *ALIKE, *LONG, *(name.upper() for name in EMITTED)}
    if is_free(name)
)
NAMES = st.one_of(
    st.sampled_from(POOL),
    st.from_regex(r"[a-z_][a-z0-9_]{0,3}", fullmatch=True),
    st.text(st.characters(categories=("L", "Nd", "No", "Nl")), min_size=1, max_size=4),
).filter(is_free)
