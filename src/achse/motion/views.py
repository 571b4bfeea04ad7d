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
from achse.native.memory import Rows, RowView, reader, structure_of

__all__ = ["InnerView", "Store", "View", "views_of"]


class View:
    """One record from outside.

    `_record` has the values as attributes: a plain object, or a structure over the memory.
    """

    layout: RecordLayout[Field]
    inner: "type[InnerView]"
    """The class of views of the records within."""
    _record: Any

    def changed(self, field: Field) -> None:
        """A field has got another value."""

    @classmethod
    def after_change(cls, field: Field) -> str:
        """Return the statement that a write runs after a change: of `view`, `record`, `field`."""
        return "view.changed(field)"

    @property
    def record(self) -> Any:
        """The values themselves, for functions of the kernel: a change of them wakes nothing."""
        return self._record

    def link(self, name: str, view: "View") -> None:
        """Let a reference lead to the record of another view."""
        raise NotImplementedError

    def pack(self) -> bytes:
        """All fields as bytes, in record order, equal for both forms of the record."""
        raise NotImplementedError


class InnerView(View):
    """A record within another one, which is told of changes."""

    outer: View
    outermost: View

    def changed(self, field: Field) -> None:
        self.outer.changed(field)


View.inner = InnerView


class _OfObject(View):
    """A view of a plain object."""

    def __init__(self, record: Any) -> None:
        super().__init__()
        self._record = record
        for row, layout in self.layout.held:
            inner = getattr(record, row.name)
            view = views_of(self.inner, layout)[0]  # type: ignore[arg-type]  # mypy: a class has no hash
            _hold(self, row, [view(each) for each in (inner if row.length else (inner,))])

    def link(self, name: str, view: View) -> None:
        setattr(self, f"_{name}", view)
        setattr(self._record, name, view._record)

    def pack(self) -> bytes:
        return pack(self.layout, self._record)


class _OfRow(RowView, View):
    """A view of a record in memory."""

    def __init__(self, rows: Rows, index: int) -> None:
        RowView.__init__(self, rows, index)
        View.__init__(self)
        self._record = structure_of(self.layout).from_buffer(self.row)
        for row, layout in self.layout.held:
            inner = rows.within(index, row)
            view = views_of(self.inner, layout)[1]  # type: ignore[arg-type]  # mypy: a class has no hash
            _hold(self, row, [view(inner, number) for number in range(inner.count)])

    def link(self, name: str, view: View) -> None:
        assert isinstance(view, RowView)
        setattr(self, f"_{name}", view)
        setattr(self._record, name, view._record)
        self.refer(self.layout.fields[name], view)

    def pack(self) -> bytes:
        return self.content(self.layout)


def _hold(view: Any, row: Field, views: list[Any]) -> None:
    """Keep the views of the records that a field holds."""
    for each in views:
        each.outer = view
        _lead_out(each, view)
    setattr(view, f"_{row.name}", views if row.length else views[0])


def _lead_out(inner: Any, outermost: View) -> None:
    """Let the view of a record within, and those within it, know the outermost record."""
    inner.outermost = outermost
    for row, _ in inner.layout.held:
        held = getattr(inner, f"_{row.name}")
        for each in held if row.length else (held,):
            _lead_out(each, outermost)


def _property(base: type[View], row: Field, array: Callable[[Any], Any]) -> property:
    """A field as attribute; `array` reads one with several values."""
    if row.refers is not None or row.holds is not None:
        return property(attrgetter(f"_{row.name}"))
    if row.length:
        return property(array)
    kind = "float" if row.is_real else "int"
    scope: dict[str, Any] = {"field": row}
    exec(
        "def write(view, value):\n"
        " record = view._record\n"
        f" if record.{row.name} != value:\n"
        f"  record.{row.name} = {kind}(value)\n"
        f"  {base.after_change(row)}\n",
        scope,
    )
    return property(attrgetter(f"_record.{row.name}"), scope["write"])


@cache
def views_of(base: type[View], layout: RecordLayout[Field]) -> tuple[Any, Any]:
    """The two classes of views of a record: of a plain object, and of one in memory."""
    forms: list[tuple[type[View], Callable[[Field], Callable[[Any], Any]]]] = [
        (_OfObject, lambda row: attrgetter(f"_record.{row.name}")),
        (_OfRow, reader),
    ]
    made = []
    for form, array in forms:
        fields: dict[str, Any] = {
            name: _property(base, row, array(row)) for name, row in layout.fields.items()
        }
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
