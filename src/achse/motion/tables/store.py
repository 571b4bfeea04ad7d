"""All tables of an NC by id: their users, and the memory from which slaves read.

Tables know axes only as `achse.motion.tables.users.TableUser`.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from typing import Any

from achse.codes import NcError
from achse.codes.nc.choices import TableType
from achse.motion.couplings.cam_checks import check_follow
from achse.motion.couplings.cams import CHANGE_POINTS, law_now, show_cams
from achse.motion.laws.element import ELEMENT
from achse.motion.states import CamActivation, CamInterpolation, CamScaling
from achse.motion.tables.block import LEAST_ROWS, WORTH_MACHINE_CODE, block_size, write_block
from achse.motion.tables.characteristics import Characteristics
from achse.motion.tables.errors import TableError
from achse.motion.tables.function import survey_function
from achse.motion.tables.limits import TableLimits
from achse.motion.tables.memory import (
    COUNT,
    HEADER,
    CamMemory,
)
from achse.motion.tables.search import CamCurve, Crossing, FunctionCurve, nearest
from achse.motion.tables.survey import SURVEY, VALUES, at_velocity, survey
from achse.motion.tables.table import (
    MOST_NUMBERS,
    MOTION_POINT,
    PointActivation,
    Table,
    TableParameters,
    TableScaling,
)
from achse.motion.tables.users import TableUser, at_work, cams_in_use
from achse.native.declare import assign

_POINTS_STAY = (
    CamActivation.INSTANTANEOUS,
    CamActivation.OFF,
    CamActivation.DELETE_QUEUED,
)
"""With these nothing waits for changed points."""


def _returns(layer: Any) -> bool:
    """Return True if a layer has other points for one cycle, and waits for those from before."""
    return bool(layer.change.kind == CHANGE_POINTS and layer.change.returns)


class Tables:
    """All tables of an NC by id. The kernel reads `cams` and the spans of `characteristics`."""

    def __init__(self, axes: Callable[[], Iterable[TableUser]]) -> None:
        self._axes = axes
        self.limits = TableLimits()
        """Of tables that clients make."""
        self._created_ids: set[int] = set()
        self._tables: dict[int, Table] = {}
        self.characteristics = Characteristics(axes, self)
        self.cams = CamMemory()
        self._blocks: dict[tuple[int, int], int] = {}
        """Begin of each table in `cams`, by its id and interpolation."""
        self._newest: dict[tuple[int, int], int] = {}
        """Begin of the points of a changed motion function in `cams`."""
        self.laid_out: Callable[[], None] = lambda: None
        """Called after `cams` moved; `characteristics.laid_out` after its curves changed."""

    def __iter__(self) -> Iterator[Table]:
        return iter(self._tables.values())

    def __len__(self) -> int:
        return len(self._tables)

    def ids(self) -> list[int]:
        return sorted(self._tables)

    def find(self, table_id: int) -> Table:
        """Return the table with this id; TableError 0x4261 if there is none."""
        try:
            return self._tables[table_id]
        except KeyError:
            raise TableError(NcError.TABLE_NOT_FOUND, f"no table {table_id}") from None

    def create(
        self, table_id: int, main_type: TableType, sub_type: int, rows: int, columns: int
    ) -> Table:
        """Return a new table, all 0. Raises TableError: 0x4063, 0x4A00, 0x4A02, 0x4A03, 0x4A07,
        0x4A11."""
        if table_id in self._tables:
            raise TableError(NcError.TABLE_EXISTS, f"table {table_id} is there already")
        created = (self._tables[each] for each in self._created_ids)
        self.limits.demand(main_type, rows, columns, created)
        table = Table(table_id, main_type, sub_type, rows, columns)
        self.add(table)
        self._created_ids.add(table_id)
        return table

    def add(self, table: Table) -> None:
        """Take a new table in; TableError 0x4063 if its id is taken, 0x4A11 without memory."""
        if table.table_id in self._tables:
            raise TableError(NcError.TABLE_EXISTS, f"{table!r} is there already")
        if table.size + sum(each.size for each in self) > MOST_NUMBERS:
            raise TableError(
                NcError.TABLE_NO_MEMORY, f"{table!r}: tables take at most {MOST_NUMBERS} numbers"
            )
        self._tables[table.table_id] = table

    def add_configured(self, parameters: TableParameters) -> None:
        """Take a table in with its points. Raises TableError."""
        of_points = parameters.main_type == TableType.MOTION_FUNCTION
        table = Table(
            parameters.table_id,
            parameters.main_type,
            parameters.sub_type,
            len(parameters.points),
            1 if of_points else 2,
            parameters.name,
        )
        if of_points:
            for number, point in enumerate(parameters.points):
                MOTION_POINT.pack_into(table.motion, number * MOTION_POINT.size, *point)
        else:
            table.values = array("d", (value for point in parameters.points for value in point))
        table.filled = True
        table.boundary = parameters.boundary, parameters.begin_slope, parameters.end_slope
        if table.table_main_type == TableType.CHARACTERISTIC:
            table.curve()
        else:
            table.checked()
        self.add(table)

    def delete(self, table_id: int) -> None:
        """Forget a table; TableError 0x4261 if there is none, 0x4259 if it is in use."""
        self.find(table_id)
        users = self.user_count(table_id)
        if users:
            raise TableError(NcError.SLAVE_TABLE_IN_USE, f"table {table_id} has {users} users")
        self._forget_blocks()
        del self._tables[table_id]
        self._created_ids.discard(table_id)

    def user_count(self, table_id: int) -> int:
        """Return the number of drives, simulated valves and slaves that use a table."""
        drives = self.characteristics.user_count(table_id)
        slaves = sum(table_id == used for _, used, _ in cams_in_use(self._axes()))
        named = sum(table_id in axis.camming.tables for axis in self._axes())
        return drives + slaves + named

    def write(self, table: Table, index: int, values: Iterable[float], step: int = 1) -> None:
        """Change numbers of a table from `index` on, each `step` behind the one before.

        Its users go on with the new curve. Raises TableError, and changes nothing, if the
        table is in use and would not be a function any more, or if a slave at work would jump by
        more than its position window (0x4A18): cam tables have no later activation (002).
        """
        fresh = array("d", values)
        # a sum of finite numbers is finite, or they are looked at one by one
        if not isfinite(sum(fresh)) and not all(map(isfinite, fresh)):
            raise TableError(NcError.TABLE_PARAMETER, f"{table!r} takes finite numbers")
        end = index + step * len(fresh)
        before = table.values[index:end:step]
        table.values[index:end:step] = fresh
        last = index + step * (len(fresh) - 1)
        rows = index // table.column_count, last // table.column_count + 1
        table.changed(*rows)
        try:
            self._take_over(table, *rows)
        except TableError:
            table.values[index:end:step] = before
            table.changed(*rows)
            self._fill_again(table, *rows)
            raise
        table.filled = True
        table.last_written = last

    def write_points(self, table: Table, index: int, points: bytes, step: int = 1) -> None:
        """Change points of a motion function, as `write` changes numbers.

        Raises TableError: 0x4262 if the table is none, 0x4A1C for a number that is not finite.
        """
        table.demand_points()
        fresh = list(MOTION_POINT.iter_unpack(points))
        if not all(isfinite(number) for point in fresh for number in point):
            raise TableError(NcError.TABLE_PARAMETER, f"{table!r} takes finite numbers")
        before = bytes(table.motion)
        size = MOTION_POINT.size
        for n in range(len(fresh)):
            at = size * (index + n * step)
            table.motion[at : at + size] = points[size * n : size * (n + 1)]
        table.changed()
        try:
            self._take_over(table, 0, table.row_count)
        except TableError:
            table.motion[:] = before
            table.changed()
            self._fill_newest(table)
            raise
        table.filled = True

    def scale(self, table: Table, scaling: TableScaling) -> None:
        """Read a monotonic table otherwise from now on (0x115).

        Raises TableError, and changes nothing: 0x4A12 for other tables, 0x4A17 for a scaling of 0
        or a range that ends before it begins, 0x4A18 where a slave at work would jump.
        """
        if table.equidistant or table.of_points:
            raise TableError(NcError.TABLE_FUNCTION_NOT_AVAILABLE, f"{table!r} is not monotonic")
        if not scaling.master_scaling > 0.0 or scaling.range_high < scaling.range_low:
            raise TableError(NcError.TABLE_SCALING, f"{table!r}: {scaling}")
        before, table.scaling = table.scaling, scaling
        table.changed()
        try:
            self._take_over(table, 0, table.row_count)
        except TableError:
            table.scaling = before
            table.changed()
            self._fill_again(table, 0, table.row_count)
            raise

    def _take_over(self, table: Table, low: int, high: int) -> None:
        """Update the users of a table with its rows `low` … `high` - 1 as they are now."""
        if self.characteristics.user_count(table.table_id):
            self.characteristics.lay_out()
        mine = [key for key in self._blocks if key[0] == table.table_id]
        if not mine:
            return
        self._forget_blocks()
        in_memory = [key for key in mine if key in self._blocks]
        for key in in_memory:
            if table.of_points:
                self._renew(table, key)
            else:
                self._refill(table, key, low, high)
        in_use = cams_in_use(self._axes())
        users = {axis.axis_id: axis for axis, used, _ in in_use if used == table.table_id}
        for axis in users.values():
            axis.show_cams()

    @staticmethod
    def show_slave(slave: Any) -> None:
        """Update the gear ratio of a slave, the places of its cams and what waits for them."""
        show_cams(slave, slave.rows)

    def _refill(self, table: Table, key: tuple[int, int], low: int, high: int) -> None:
        """Write some rows of a block, unless a slave would jump."""
        write_block(table, key[1], self.cams.numbers, self._blocks[key], low, high)
        self._check_slaves(table, key)

    def _check_slaves(self, table: Table, key: tuple[int, int]) -> None:
        """Raise TableError if a slave at work would have to jump to its cams as they are now."""
        for axis in at_work(self._axes(), key):
            position, velocity, acceleration = law_now(axis, axis.rows, -1)
            error = NcError.of(check_follow(axis, position, velocity, acceleration))
            if error:
                raise TableError(
                    error,
                    f"{table!r}: axis {axis.axis_id} would jump from "
                    f"{axis.set.position - axis.coupling.offset:g} to {position:g}",
                )

    def _fill_again(self, table: Table, low: int, high: int) -> None:
        """Write the blocks of a table of numbers as they were before these rows were refused."""
        for key, begin in self._blocks.items():
            if key[0] == table.table_id and not table.of_points:
                write_block(table, key[1], self.cams.numbers, begin, low, high)

    def _fill_newest(self, table: Table) -> None:
        """Write the newest points of a motion function as they were before these were refused."""
        for key, place in self._newest.items():
            if key[0] == table.table_id:
                write_block(table, key[1], self.cams.numbers, place, 0, 0)

    def change_online(self, table: Table, change: PointActivation) -> None:
        """Say when changed points of a motion function become active (0x1A).

        Raises TableError 0x4A1B for an activation, 0x4A17 for a scaling type that is not known.
        """
        if change.activation not in CamActivation.__members__.values():
            raise TableError(
                NcError.TABLE_EXECUTION_MODE, f"activation {change.activation}, expected 0..9"
            )
        for each in (change.master_scaling_type, change.slave_scaling_type):
            if each not in CamScaling.__members__.values():
                raise TableError(NcError.TABLE_SCALING, f"scaling type {each}, expected 0..2")
        if not isfinite(change.position):
            raise TableError(NcError.TABLE_PARAMETER, f"{table!r} takes finite numbers")
        table.online = change

    def _renew(self, table: Table, key: tuple[int, int]) -> None:
        """Let slaves change to the points of a motion function as they are now, when it says.

        Its block then has each version that a slave still uses, and behind them this one.
        """
        layers = [layer for axis in self._axes() for layer in axis.cams[: axis.camming.count]]
        running = [each for each in layers if (each.now.table, each.now.interpolation) == key]
        later = table.online.activation not in _POINTS_STAY
        if later and any(
            each.change.kind not in (0, CHANGE_POINTS) or _returns(each) for each in running
        ):
            raise TableError(
                NcError.ACTIVATION_PENDING, f"{table!r}: another change of its slave waits"
            )
        waiting = [each for each in layers if (each.next.table, each.next.interpolation) == key]
        used = {each.now.cam for each in running} | {each.next.cam for each in waiting}
        before, numbers = self.cams.arguments, self.cams.numbers
        versions = {}
        for address in sorted(used):
            size = HEADER + ELEMENT * int(numbers[address + COUNT])
            versions[address] = numbers[address : address + size]
        version_size = sum(map(len, versions.values()))
        place = self._blocks[key] = self.cams.take(version_size + block_size(table))
        self.cams.keep(self._blocks.values())
        moved = {}
        for address, version in versions.items():
            self.cams.numbers[place : place + len(version)] = version
            moved[address] = place
            place += len(version)
        self._newest[key] = place
        write_block(table, key[1], self.cams.numbers, place, 0, 0)
        at_once = table.online.activation == CamActivation.INSTANTANEOUS
        former = [moved[layer.now.cam] for layer in running]
        for layer, cam in zip(running, former, strict=True):
            layer.now.cam = place if at_once else cam
        for layer in waiting:
            layer.next.cam = moved[layer.next.cam] if _returns(layer) else place
        try:
            if at_once:
                self._check_slaves(table, key)
        except TableError:
            for layer, cam in zip(running, former, strict=True):
                layer.now.cam = cam
            raise
        finally:
            if self.cams.arguments != before:
                self.laid_out()
        for layer in running:
            self._change_points(layer, table.online, place)

    @staticmethod
    def _change_points(layer: Any, online: PointActivation, place: int) -> None:
        """Let a layer go on with other points of its motion function, when they are to be active.

        Offsets and scalings stay what they are unless they follow by themselves.
        """
        returns = _returns(layer) and online.activation != CamActivation.DELETE_QUEUED
        change = layer.change
        if change.kind == CHANGE_POINTS and not returns:
            change.kind = layer.next.table = 0
        if online.activation in _POINTS_STAY:
            return
        change.kind, change.when, change.returns = CHANGE_POINTS, online.activation, 0
        change.position = online.position
        change.master_type, change.slave_type = (
            online.master_scaling_type,
            online.slave_scaling_type,
        )
        assign(layer.next, layer.now)
        layer.next.cam = place

    # -- cams --------------------------------------------------------------------------------

    def cam(self, table_id: int, interpolation: int) -> int:
        """Return the begin in `cams` of a table joined like this; it stays while a slave uses it.

        Raises TableError: 0x4261 no table, 0x4262 not for slaves, 0x4256 nothing was written to it,
        0x4A08 interpolation, 0x4A21 too few rows for it, 0x4A06 … no function.
        """
        table = self.find(table_id)
        if table.table_main_type == TableType.CHARACTERISTIC:
            raise TableError(NcError.TABLE_WRONG_KIND, f"{table!r} is for CHARACTERISTIC")
        if interpolation not in CamInterpolation.__members__.values():
            raise TableError(
                NcError.TABLE_INTERPOLATION_TYPE, f"interpolation {interpolation}, expected 0..3"
            )
        if not table.filled:
            raise TableError(NcError.TABLE_SLAVE_WITHOUT_TABLE, f"{table!r} is empty")
        least = LEAST_ROWS.get(CamInterpolation(interpolation), 2)
        if table.row_count < least and not table.of_points:
            raise TableError(
                NcError.TABLE_TOO_FEW_SPLINE_POINTS,
                f"{table!r}: {table.row_count} points, expected {least} or more",
            )
        if interpolation == CamInterpolation.FOUR_POINTS and not table.equidistant:
            raise TableError(
                NcError.TABLE_INTERPOLATION_TYPE, f"{table!r} has no equal steps for four points"
            )
        key = table_id, interpolation
        self._forget_blocks()
        if key not in self._blocks:
            table.checked()
            before = self.cams.arguments
            begin = self._blocks[key] = self.cams.take(block_size(table))
            write_block(table, interpolation, self.cams.numbers, begin, 0, table.row_count)
            if self.cams.arguments != before:
                self.laid_out()
        return self._newest.get(key, self._blocks[key])

    def characteristic_values(self, table: Table, velocity: float) -> list[float]:
        """Return the values of `achse.motion.tables.survey` at a master velocity.

        Rows are joined as slaves join them, else by a spline through all that there can be one of.
        Raises TableError if the table is not a function.
        """
        if table.of_points:
            return at_velocity(survey_function(table.function()), velocity)
        cams, first = self._joined(table, CamInterpolation.SPLINE)
        values = array("d", [0.0]) * VALUES
        if table.row_count >= WORTH_MACHINE_CODE and SURVEY.available:
            SURVEY.function(*cams.arguments, first, *values.buffer_info())
        else:
            survey(cams.numbers, first, values)
        return at_velocity(values, velocity)

    def nearest(
        self, table: Table, value: float, start: float
    ) -> tuple[Crossing | None, Crossing | None]:
        """Return the nearest master positions at or below `start`, and at or above, where the slave
        is at `value`; rows are joined as slaves join them, else by straight lines. Raises
        TableError."""
        if table.of_points:
            below, above = nearest(FunctionCurve(table.function(), table.cyclic), value, start)
            return below, above
        cams, first = self._joined(table, CamInterpolation.LINEAR)
        below, above = nearest(CamCurve(cams.numbers, first), value, start)
        return below, above

    def _joined(self, table: Table, otherwise: CamInterpolation) -> tuple[CamMemory, int]:
        """Return a table as slaves use it, else joined `otherwise` if it has the rows for it."""
        for key, begin in self._blocks.items():
            if key[0] == table.table_id:
                return self.cams, begin
        if table.row_count < LEAST_ROWS.get(otherwise, 2):
            otherwise = CamInterpolation.LINEAR
        cams = CamMemory()
        begin = cams.take(block_size(table))
        write_block(table, otherwise, cams.numbers, begin, 0, table.row_count)
        return cams, begin

    def _forget_blocks(self) -> None:
        """Free the memory of unused cams."""
        used = {
            (table_id, interpolation) for _, table_id, interpolation in cams_in_use(self._axes())
        }
        blocks = {key: begin for key, begin in self._blocks.items() if key in used}
        if len(blocks) < len(self._blocks):
            self._blocks = blocks
            self._newest = {key: at for key, at in self._newest.items() if key in blocks}
            self.cams.keep(blocks.values())
