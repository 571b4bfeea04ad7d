"""Contents of the pages of one target: calls, topics and downloads, by name."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, NamedTuple

from achse.router.rights import Right
from achse.web.shared_subscriptions import Topic

Download = Callable[[str], tuple[str, bytes] | None]
"""Returns file name and contents of a download by its key; None if it is unknown."""


class PageCall(NamedTuple):
    """One call: what does it, and what pages need to be allowed for it."""

    do: Callable[..., Awaitable[Any]]
    needs: Right = Right.READ
    of_page: bool = False
    """True if the call is about the calling page, which is then passed before the arguments."""


class PageContents(NamedTuple):
    """All that pages may call, watch and download."""

    calls: Mapping[str, PageCall]
    topics: Mapping[str, Topic]
    download: Download
