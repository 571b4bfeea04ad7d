"""`async with`: what a block enters is closed at its end."""

from abc import ABC, abstractmethod
from types import TracebackType
from typing import Self


class ClosedByBlock(ABC):
    """An object that `async with` closes, however the block ends."""

    __slots__ = ()

    @abstractmethod
    async def close(self) -> None:
        """End it. Again is not an error."""

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()
