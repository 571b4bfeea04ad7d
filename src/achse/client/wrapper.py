"""Blocking methods derived from the coroutine methods of an asyncio class.

    class Target(Wrapper[target.Target]):
        read = blocking(target.Target.read)
        subscribe = wrapping(target.Target.subscribe, Subscription)

The derived method has the parameters, the result and the docstring of its source.
"""

import inspect
from collections.abc import Callable, Coroutine
from contextlib import AbstractAsyncContextManager
from functools import wraps
from types import FunctionType, TracebackType
from typing import Any, Concatenate, Generic, ParamSpec, Self, TypeVar, overload

from achse.client.loop import LoopThread

A = TypeVar("A", covariant=True)
C = TypeVar("C", bound=AbstractAsyncContextManager[Any, Any], covariant=True)
P = ParamSpec("P")
V = TypeVar("V")
W = TypeVar("W")


class Wrapper(Generic[A]):
    """An asyncio object and the loop that runs its coroutines."""

    def __init__(self, loop: LoopThread, inner: A) -> None:
        self._loop = loop
        self._inner = inner

    def __init_subclass__(cls) -> None:
        """Name derived methods after their class, as `repr` and `help()` show them."""
        super().__init_subclass__()
        for name, member in vars(cls).items():
            if isinstance(member, FunctionType) and hasattr(member, "__wrapped__"):
                member.__module__ = cls.__module__
                member.__qualname__ = f"{cls.__qualname__}.{name}"

    def __repr__(self) -> str:
        return repr(self._inner)


class ContextWrapper(Wrapper[C]):
    """An asyncio context manager for `with`."""

    __repr__ = object.__repr__  # the asyncio objects have no text of their own

    def __enter__(self) -> Self:
        self._loop.run(self._inner.__aenter__())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._loop.run(self._inner.__aexit__(kind, error, trace))


@overload
def blocking(
    method: Callable[Concatenate[A, P], Coroutine[Any, Any, V]],
) -> Callable[Concatenate[Wrapper[A], P], V]: ...
@overload
def blocking(
    method: Callable[Concatenate[A, P], Coroutine[Any, Any, V]],
    result: Callable[[LoopThread, V], W],
) -> Callable[Concatenate[Wrapper[A], P], W]: ...
def blocking(method: Any, result: Any = None) -> Any:
    """Return a method that runs the coroutine of `method` in the loop and waits for its result.

    `result` wraps that result, as in `wrapping`.
    """

    @wraps(method)
    def wait(self: Wrapper[Any], /, *arguments: Any, **options: Any) -> Any:
        value = self._loop.run(method(self._inner, *arguments, **options))
        return value if result is None else result(self._loop, value)

    return _described(wait, result)


def wrapping(
    method: Callable[Concatenate[A, P], V], result: Callable[[LoopThread, V], W]
) -> Callable[Concatenate[Wrapper[A], P], W]:
    """Return a method that calls `method` in the caller's thread and wraps its result.

    `result` is a subclass of `Wrapper`, or a function with its result type annotated.
    """

    @wraps(method)
    def wrap(self: Wrapper[A], /, *arguments: P.args, **options: P.kwargs) -> W:
        return result(self._loop, method(self._inner, *arguments, **options))

    return _described(wrap, result)


def _described(derived: V, result: Any) -> V:
    """Return `derived` with a docstring without `await`, and with the type of `result`."""
    function: Any = derived
    if function.__doc__ is not None:  # it is with python -OO
        function.__doc__ = function.__doc__.replace("`await ", "`").replace("async ", "")
    if result is not None:
        type = result if inspect.isclass(result) else inspect.get_annotations(result)["return"]
        signature = inspect.signature(function).replace(return_annotation=type)
        function.__signature__ = signature
        function.__annotations__ = {**function.__annotations__, "return": type}
    return derived
