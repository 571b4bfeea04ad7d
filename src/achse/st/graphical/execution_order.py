"""Automatic order of execution of continuous function charts: by data flow, then by position.

Source: the vendor's editor calls it execution order by data flow; ties are our choice.
"""

from collections.abc import Iterable, Sequence

from achse.st.graphical.function_charts import ChartBox, ChartOutput, Ordered


def execution_order(elements: Sequence[Ordered], edges: Iterable[tuple[int, int]]) -> list[Ordered]:
    """Return elements so that producers run before their consumers.

    Of elements that may run, the one that is highest, then leftmost, is next; an output comes
    right behind its producer. Where a loop is left, the element that is marked as the start of
    its feedback begins, else the highest. `edges` are numbers `(producer, consumer)`.
    """
    waiting: list[set[int]] = [set() for _ in elements]
    following: list[list[int]] = [[] for _ in elements]
    for producer, consumer in edges:
        if producer != consumer:
            waiting[consumer].add(producer)
            following[producer].append(consumer)
    left = set(range(len(elements)))
    order: list[Ordered] = []

    def place(number: int) -> tuple[int, int, int]:
        x, y = elements[number].bounds
        return y, x, number

    def run(number: int) -> None:
        left.discard(number)
        order.append(elements[number])
        for consumer in sorted(set(following[number]), key=place):
            waiting[consumer].discard(number)
            if (
                consumer in left
                and not waiting[consumer]
                and isinstance(elements[consumer], ChartOutput)
            ):
                run(consumer)

    while left:
        ready = [number for number in left if not waiting[number]]
        if not ready:
            ready = _in_loops(left, waiting)
            marked = [number for number in ready if _is_start(elements[number])]
            number = min(marked or ready, key=place)
            waiting[number].clear()
            run(number)
            continue
        run(min(ready, key=place))
    return order


def _in_loops(left: set[int], waiting: Sequence[set[int]]) -> list[int]:
    """Return the elements that are in loops, without those that only wait for a loop."""
    numbers = []
    for start in left:
        seen: set[int] = set()
        stack = list(waiting[start])
        while stack:
            number = stack.pop()
            if number in seen:
                continue
            seen.add(number)
            stack.extend(waiting[number])
        if start in seen:
            numbers.append(start)
    return numbers


def _is_start(element: Ordered) -> bool:
    return isinstance(element, ChartBox) and element.starts_feedback
