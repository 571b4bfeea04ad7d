"""Views: a record of the kernel from outside, its fields as attributes, equal for both forms.

A `View` has every field of its layout as an attribute that holds a Python float, int or indexable
array, or the view of the record that it refers to or holds. A change of a value calls
`changed`, so that what rests wakes.
"""

from functools import cache
from operator import attrgetter
from types import CodeType, FunctionType
from typing import TYPE_CHECKING, Any

from achse.motion.fields.declare import Field
from achse.native.declare import RecordLayout, pack
from achse.native.memory import AttributeCell, Rows, RowView, reader, structure_of

_WORD = 8
"""Bytes of a value in a record."""


class View:
    """One record from outside.

    `_record` has the values as attributes: a plain object, or a structure over the memory.
    """

    layout: RecordLayout[Field]
    inner: "type[InnerView]"
    """The class of views of the records within."""
    _record: Any

    def changed(self, field: Field) -> None:
        """Note that a field has got another value."""

    @classmethod
    def after_change(cls, field: Field) -> str:
        """Return the statement that a write runs after a change: of `view`, `record`, `field`."""
        return "view.changed(field)"

    @classmethod
    def path_of(cls, field: Field) -> str:
        """Return the names on the way from a record to a field of it or of a record within."""
        return field.name

    @property
    def record(self) -> Any:
        """The values themselves, for functions of the kernel: a change of them wakes nothing."""
        return self._record

    def link(self, name: str, view: "View") -> None:
        """Let a reference point to the record of another view."""
        raise NotImplementedError

    def pack(self) -> bytes:
        """Return all fields as bytes, in record order, equal for both forms of the record."""
        raise NotImplementedError


class InnerView(View):
    """A record within another one, whose `changed` is called."""

    outer: View
    outermost: View

    def changed(self, field: Field) -> None:
        self.outer.changed(field)


View.inner = InnerView


class _LazyView(View):
    """A view whose views of records within are made at their first use."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            row = self.layout.fields.get(name[1:]) if name[:1] == "_" else None
            if row is None or row.holds is None:
                kind = type(self).__name__
                raise AttributeError(f"{kind!r} object has no attribute {name!r}")
            views = self._views_within(row, row.holds)
            for each in views:
                each.outer = self
                each.outermost = vars(self).get("outermost", self)
            inner = views if row.length else views[0]
            setattr(self, name, inner)
            return inner

    def _views_within(self, row: Field, layout: RecordLayout[Field]) -> list[Any]:
        """Make the views of the records that a field holds."""
        raise NotImplementedError


class _OfObject(_LazyView):
    """A view of a plain object."""

    def __init__(self, record: Any) -> None:
        super().__init__()
        self._record = record

    def _views_within(self, row: Field, layout: RecordLayout[Field]) -> list[Any]:
        inner = getattr(self._record, row.name)
        view = views_of(self.inner, layout)[0]  # type: ignore[arg-type]  # mypy: a class has no hash
        return [view(each) for each in (inner if row.length else (inner,))]

    def link(self, name: str, view: View) -> None:
        setattr(self, f"_{name}", view)
        setattr(self._record, name, view._record)

    def place(self, field: Field, size: int) -> AttributeCell | None:
        """Return the first `size` bytes of a field, None if these are more than one value."""
        if size > _WORD or field.length:
            return None
        return AttributeCell(self._record, self.path_of(field), size, is_real=field.is_real)

    def pack(self) -> bytes:
        return pack(self.layout, self._record)


class _OfRow(RowView, _LazyView):
    """A view of a record in memory."""

    def __init__(self, rows: Rows, index: int) -> None:
        RowView.__init__(self, rows, index)
        View.__init__(self)
        self._rows, self._index = rows, index
        self._record = structure_of(self.layout).from_buffer(self.row)

    def _views_within(self, row: Field, layout: RecordLayout[Field]) -> list[Any]:
        inner = self._rows.within(self._index, row)
        view = views_of(self.inner, layout)[1]  # type: ignore[arg-type]  # mypy: a class has no hash
        return [view(inner, number) for number in range(inner.count)]

    def link(self, name: str, view: View) -> None:
        assert isinstance(view, RowView)
        setattr(self, f"_{name}", view)
        setattr(self._record, name, view._record)
        self.refer(self.layout.fields[name], view)

    def pack(self) -> bytes:
        return self.content(self.layout)


_FIELD, _PART = "the_field", "the_part"
"""Names in the sources of writing functions that stand for those of a field and of a part."""

_WRITE = f"""
def write(view, value, field):
 record = view._record
 if record.{_FIELD} != value:
  record.{_FIELD} = KIND(value)
  AFTER
"""

_WRITE_WITHIN = f"""
def write(view, value):
 inner = view.{_PART}._record
 if inner.{_FIELD} != value:
  inner.{_FIELD} = KIND(value)
  record = view._record
  AFTER
"""


@cache
def _code(source: str, kind: str, after: str) -> CodeType:
    """Compile a writing function; those of other fields have the same code with other names."""
    module = compile(source.replace("KIND", kind).replace("AFTER", after), __file__, "exec")
    return next(each for each in module.co_consts if isinstance(each, CodeType))


def _write(
    base: type[View], field: Field, source: str, part: str = "", defaults: tuple[Field, ...] = ()
) -> FunctionType:
    """Return the function that writes a field of a view, or of its `part`."""
    code = _code(source, "float" if field.is_real else "int", base.after_change(field))
    names = {_FIELD: field.name, _PART: part}
    code = code.replace(co_names=tuple([names.get(name, name) for name in code.co_names]))
    return FunctionType(code, globals(), field.name, defaults)


@cache
def views_of(base: type[View], layout: RecordLayout[Field]) -> tuple[Any, Any]:
    """Return the two classes of views of a record: of a plain object, and of one in memory."""
    shared: dict[str, Any] = {"layout": layout}
    arrays = []
    for name, row in layout.fields.items():
        if row.refers is not None or row.holds is not None:
            shared[name] = property(attrgetter(f"_{name}"))
        elif row.length:
            arrays.append(row)
        else:
            shared[name] = property(
                attrgetter(f"_record.{name}"), _write(base, row, _WRITE, defaults=(row,))
            )
    objects = {row.name: property(attrgetter(f"_record.{row.name}")) for row in arrays}
    rows = {row.name: property(reader(row)) for row in arrays}
    return (
        type(base.__name__, (_OfObject, base), shared | objects),
        type(base.__name__, (_OfRow, base), shared | rows),
    )


def property_within(base: type[View], part: str, field: Field) -> property:
    """Return the property of a view for a field of a record within, which wakes as its own do."""
    write = _write(base, field, _WRITE_WITHIN, part)
    return property(attrgetter(f"_{part}._record.{field.name}"), write)


@cache
def _content(layout: RecordLayout[Field], fresh: type) -> bytes:
    """Return the bytes of a fresh record, computed once."""
    return pack(layout, fresh())


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
            content = _content(layout, fresh)
            for view in self.views:
                view.row[: len(content)] = content
            self.arguments = rows.address, count
        else:
            records = [fresh() for _ in range(count)]
            self.views = [of_object(record) for record in records]
            self.arguments = (records,)
