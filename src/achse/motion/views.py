"""Views: a record of the kernel from outside, its fields as attributes, equal for both forms.

A `View` has every field of its layout as an attribute that holds a Python float, int or indexable
array, or the view of the record that it refers to or holds. A change of a value is told
(`changed`), so that what rests wakes.
"""

from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any

from achse.motion.fields.declare import Field
from achse.native.declare import RecordLayout, pack
from achse.native.memory import Rows, RowView, reader

__all__ = ["InnerView", "Store", "View", "views_of"]


class View:
    """One record from outside."""

    layout: RecordLayout[Field]

    def __init__(self) -> None:
        self.linked: dict[str, View] = {}

    def changed(self, field: Field) -> None:
        """A field has got another value."""

    def link(self, name: str, view: "View") -> None:
        """Let a reference lead to the record of another view."""
        raise NotImplementedError

    def pack(self) -> bytes:
        """All fields as bytes, in record order, equal for both forms of the record."""
        raise NotImplementedError


class InnerView(View):
    """A record within another one, which is told of changes."""

    outer: View

    def changed(self, field: Field) -> None:
        self.outer.changed(field)


class _OfObject(View):
    """A view of a plain object."""

    def __init__(self, record: Any) -> None:
        super().__init__()
        self._record = record
        self.held: dict[str, Any] = {}
        for row, layout in self.layout.held:
            inner = getattr(record, row.name)
            view = views_of(InnerView, layout)[0]
            _hold(self, row, [view(each) for each in (inner if row.length else (inner,))])

    def link(self, name: str, view: View) -> None:
        self.linked[name] = view
        setattr(self._record, name, view._record)  # type: ignore[attr-defined]

    def pack(self) -> bytes:
        return pack(self.layout, self._record)


class _OfRow(RowView, View):
    """A view of a record in memory."""

    def __init__(self, rows: Rows, index: int) -> None:
        RowView.__init__(self, rows, index)
        View.__init__(self)
        self.held: dict[str, Any] = {}
        for row, layout in self.layout.held:
            inner = rows.within(index, row)
            view = views_of(InnerView, layout)[1]
            _hold(self, row, [view(inner, number) for number in range(inner.count)])

    def link(self, name: str, view: View) -> None:
        assert isinstance(view, RowView)
        self.linked[name] = view
        self.refer(self.layout.fields[name], view)

    def pack(self) -> bytes:
        return self.content(self.layout)


def _hold(view: Any, row: Field, views: list[Any]) -> None:
    """Keep the views of the records that a field holds."""
    for each in views:
        each.outer = view
    view.held[row.name] = views if row.length else views[0]


def _reference(row: Field) -> property:
    name = row.name
    if row.holds is not None:
        return property(lambda view: view.held[name])
    return property(lambda view: view.linked[name])


def _object_property(row: Field) -> property:
    name = row.name
    if row.refers is not None or row.holds is not None:
        return _reference(row)
    read: Callable[[Any], Any] = attrgetter(f"_record.{name}")
    if row.length:
        return property(read)

    def write(view: Any, value: float) -> None:
        record = view._record
        if getattr(record, name) != value:
            setattr(record, name, kind(value))
            view.changed(row)

    kind = float if row.is_real else int
    return property(read, write)


def _row_property(row: Field) -> property:
    if row.refers is not None or row.holds is not None:
        return _reference(row)
    if row.length:
        return property(reader(row))
    first = row.offset
    words = "reals" if row.is_real else "wholes"

    def write(view: Any, value: float) -> None:
        memory = getattr(view, words)
        if memory[first] != value:
            memory[first] = kind(value)
            view.changed(row)

    kind = float if row.is_real else int
    return property(reader(row), write)


@cache
def views_of(base: type[View], layout: RecordLayout[Field]) -> tuple[Any, Any]:
    """The two classes of views of a record: of a plain object, and of one in memory."""
    made = []
    for form, make in ((_OfObject, _object_property), (_OfRow, _row_property)):
        fields = {name: make(row) for name, row in layout.fields.items()}
        made.append(type(base.__name__, (form, base), fields | {"layout": layout}))
    return made[0], made[1]


class Store:
    """Records of one layout, one behind the other, and a view of each.

    `compiled` has them in memory. `argument` is what a kernel takes for them.
    """

    def __init__(
        self,
        base: type[View],
        layout: RecordLayout[Field],
        fresh: type,
        count: int,
        *,
        compiled: bool,
    ) -> None:
        of_object, of_row = views_of(base, layout)  # type: ignore[arg-type]  # mypy: a class has no hash
        self.views: list[Any]
        self.arguments: tuple[Any, ...]
        if compiled:
            rows = Rows(layout, count)
            self.views = [of_row(rows, index) for index in range(count)]
            content = pack(layout, fresh())
            for view in self.views:
                view.row[: len(content)] = content
            self.arguments = rows.address, count
        else:
            records = [fresh() for _ in range(count)]
            self.views = [of_object(record) for record in records]
            self.arguments = (records,)
