"""PLC sources in the browser: read, checked as one types, saved, taken over by online change."""

import asyncio
import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

from achse.codes.station import ONLINE_CHANGE
from achse.web.arguments import Arguments
from achse.web.messages import CallError
from achse.web.settings import EditedProject
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import LONGEST_TEXT, STATION_PORT, WatchedTarget

if TYPE_CHECKING:
    from achse.web.source_project import SourceProject

LONGEST_CODE = 1 << 20
"""Characters of all sections of a file that a page may send: those of the largest file."""

_T = TypeVar("_T")


class SourceHandlers:
    """Gives pages the sources of some projects; one thread at a time works on them."""

    def __init__(self, watched: WatchedTarget, projects: Sequence[EditedProject]) -> None:
        self._watched = watched
        self._projects = projects
        self._loaded: dict[int, SourceProject] = {}
        self._thread = ThreadPoolExecutor(1, "achse-sources")
        """Goes on to its end with what a page that is gone has asked; the next one waits."""

    async def there(self) -> bool:
        """Return True if there are projects to edit."""
        return bool(self._projects)

    async def _work(self, work: Callable[[], _T]) -> _T:
        return await asyncio.get_running_loop().run_in_executor(self._thread, work)

    def _project(self, number: int) -> "SourceProject":
        if number not in self._loaded:
            from achse.web.source_project import SourceProject  # the checker

            self._loaded[number] = SourceProject(self._projects[number])
        return self._loaded[number]

    def _named(self, arguments: Arguments) -> tuple[int, str]:
        if not self._projects:
            raise CallError("sources: these pages edit none (`achse run --web-edit`)")
        return arguments.integer("project", most=len(self._projects) - 1), arguments.text("file")

    # calls -----------------------------------------------------------------------------------

    async def listed(self, arguments: Arguments) -> list[dict[str, Any]]:
        """Call `sources.list`: projects with their files and the number of errors in each."""

        def work() -> list[dict[str, Any]]:
            return [
                {"project": number, "name": one.name, "files": self._project(number).files()}
                for number, one in enumerate(self._projects)
            ]

        return await self._work(work)

    async def read(self, arguments: Arguments) -> dict[str, Any]:
        """Call `sources.read`: `sections` of a file with their code, its `tag`, findings."""
        number, name = self._named(arguments)
        return await self._work(lambda: self._project(number).read(name))

    async def watch_drawings(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `drawings`: the drawn bodies of a file as lines of text.

        They have the values of its program or of the block `of`.
        """
        from achse.web.drawings import operand_values, shown

        number, name = self._named(arguments)
        every, instance = arguments.number("every", 0.5, 0.1, 10.0), arguments.text("of", "")
        port = self._projects[number].port
        bodies = await self._work(lambda: self._project(number).drawn(name, instance))
        while bodies:
            values = [await operand_values(self._watched, port, one) for one in bodies]
            subscription.show([shown(*each) for each in zip(bodies, values, strict=True)])
            await subscription.pause(every)

    async def check(self, arguments: Arguments) -> dict[str, Any]:
        """Call `sources.check`: findings of the project with other code in one of its files.

        `is_changed` if the file has not the given `tag` any more: others wrote it meanwhile.
        """
        (number, name), texts, tag = (
            self._named(arguments),
            _texts(arguments),
            arguments.text("tag", ""),
        )
        return await self._work(lambda: self._project(number).check(name, texts, tag))

    async def save(self, arguments: Arguments) -> dict[str, Any]:
        """Call `sources.save`: write the code of a file that still has the given `tag`."""
        (number, name), texts, tag = (
            self._named(arguments),
            _texts(arguments),
            arguments.text("tag"),
        )
        return await self._work(lambda: self._project(number).save(name, texts, tag))

    async def apply(self, arguments: Arguments) -> dict[str, int]:
        """Call `sources.apply`: the station reads its sources again and goes on with them.

        Returns the online changes of each PLC by its port; after an error the programs go on as
        they were.
        """
        if not self._projects:
            raise CallError("sources: these pages edit none (`achse run --web-edit`)")
        device = self._watched.device(STATION_PORT)
        answer = json.loads(await device.read_write_raw(ONLINE_CHANGE, 0, LONGEST_TEXT, b""))
        if "error" in answer:
            raise CallError(str(answer["error"]))
        return {str(port): int(count) for port, count in answer.items()}


def _texts(arguments: Arguments) -> list[str]:
    texts = arguments.value("texts")
    if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
        raise CallError(f"texts: expected a list of texts, got {texts!r:.60}")
    if sum(map(len, texts)) > LONGEST_CODE:
        raise CallError(f"texts: expected up to {LONGEST_CODE} characters in all")
    return texts
