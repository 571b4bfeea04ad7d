"""Cams: let an axis follow others by tables, change that while it runs, take cams in and out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.commands.slaves.couplings import begin_coupling, check_slave
from achse.motion.couplings.cam_checks import carry_out_now, check_change
from achse.motion.couplings.cams import (
    CHANGE_BEGIN,
    CHANGE_EXCHANGE,
    CHANGE_NOTHING,
    CHANGE_REMOVE,
    CHANGE_SCALING,
    master_position_of,
    names_of,
)
from achse.motion.couplings.masters import as_leader
from achse.motion.fields.cams import CAM_LAYERS, CamSlave
from achse.motion.fields.coupling import SlaveCoupling
from achse.motion.order import CouplingRing
from achse.motion.record import AXIS_PARTS, CAM, CamFields
from achse.motion.rows import NcRows
from achse.motion.states import (
    CAM_COUPLINGS,
    CamActivation,
    CamInterpolation,
    CamOperation,
    CamScaling,
    SlaveType,
)
from achse.motion.tables import TableError
from achse.motion.tables.memory import BEGIN, CYCLIC, PERIOD
from achse.native.declare import assign

LARGEST_OFFSET = 1e9
LARGEST_SCALING = 1e6
SMALLEST_SCALING = 1e-6
"""Between these bounds positions of cams are distinguishable numbers."""

_AT_COUPLING = (
    CamActivation.INSTANTANEOUS,
    CamActivation.MASTER_CAM_POSITION,
    CamActivation.MASTER_AXIS_POSITION,
    CamActivation.NEXT_CYCLE,
    CamActivation.AS_SOON_AS_POSSIBLE,
    CamActivation.MASTER_AXIS_POSITION_POSITIVE,
    CamActivation.MASTER_AXIS_POSITION_NEGATIVE,
)
_AT_EXCHANGE = (*_AT_COUPLING, CamActivation.NEXT_CYCLE_ONCE)
"""A cam may take the place of another for one cycle; it cannot begin, or go, for one."""
_WHILE_RUNNING = (*_AT_EXCHANGE, CamActivation.OFF, CamActivation.DELETE_QUEUED)
_BY_CYCLE = (CamActivation.MASTER_CAM_POSITION, CamActivation.NEXT_CYCLE)
"""They count from the begin of the cam, which an axis in relative positions has not yet."""


@dataclass(frozen=True)
class CamDemand:
    """Request to follow a cam, and the moment from which on (0x4200 + ID:0x4A, 0x4D).

    Offsets in axis units. Scalings: axis units for one of the cam.
    """

    table_id: int = 0
    interpolation: int = CamInterpolation.LINEAR
    slave_offset: float = 0.0
    master_offset: float = 0.0
    slave_scaling: float = 1.0
    master_scaling: float = 1.0
    slave_absolute: int = 0
    master_absolute: int = 0
    activation: int = CamActivation.INSTANTANEOUS
    position: float = 0.0
    master_type: int = CamScaling.USER_DEFINED
    slave_type: int = CamScaling.USER_DEFINED


def couple_by_cam(
    slave: Axis,
    slave_type: int,
    master_id: int,
    demand: CamDemand,
    operation: int = CamOperation.DEFAULT,
    reference: int = 0,
    *,
    further_tables: Sequence[int] = (),
) -> int:
    """Let a standing axis follow a master by a cam (0x45, 0x4A); positions do not jump.

    A slave of type 10 or 13 that follows the master already changes to the table when the
    activation says so. One of type 11 takes the cam in beside others, takes it in place of the
    table `reference`, or takes the table `table_id` out. Where it names `further_tables` at
    coupling, it holds them: they cannot be deleted, and only they can be its corrections.
    """
    if slave_type not in CAM_COUPLINGS:
        return NcError.SLAVE_TYPE
    if operation not in CamOperation.__members__.values():
        return NcError.TABLE_EXECUTION_MODE
    if slave_type == SlaveType.MULTI_TABULAR and operation == CamOperation.REMOVE:
        return _remove(slave, demand)
    exchanges = slave.coupling.law == slave_type and (
        slave_type != SlaveType.MULTI_TABULAR or operation == CamOperation.EXCHANGE
    )
    code = _check(slave, demand, _AT_EXCHANGE if exchanges else _AT_COUPLING)
    if code:
        return code
    try:
        if slave_type == SlaveType.MOTION_FUNCTION:
            slave.tables.find(demand.table_id).demand_points()
        cam = slave.tables.cam(demand.table_id, demand.interpolation)
        for table_id in further_tables:
            slave.tables.find(table_id)
    except TableError as fault:
        return fault.error
    if slave.coupling.law != slave_type:
        code = _begin(slave, slave_type, master_id, demand, cam, operation)
        for n, table_id in enumerate(further_tables if not code else ()):
            slave.camming.tables[n] = table_id
        return code
    if slave_type != SlaveType.MULTI_TABULAR:
        return _exchange(slave, slave.cams[0], master_id, demand, cam)
    if operation == CamOperation.EXCHANGE:
        layer = _layer_of(slave, reference)
        if layer is None:
            return _check_layer(slave, reference)
        return _exchange(slave, layer, master_id, demand, cam)
    return _add(slave, master_id, demand, cam)


def _check(slave: Axis, demand: CamDemand, activations: Sequence[CamActivation]) -> int:
    """Return the error that forbids a request at any time, or 0."""
    if demand.activation not in activations:
        return NcError.ONLINE_CHANGE_MODE
    for scaling_type in (demand.master_type, demand.slave_type):
        if scaling_type not in CamScaling.__members__.values():
            return NcError.SCALING_MODE
    numbers = (demand.slave_offset, demand.master_offset, demand.position)
    scalings = (demand.slave_scaling, demand.master_scaling)
    if not all(map(isfinite, (*numbers, *scalings))):
        return NcError.SLAVE_COUPLING_PARAMETER
    if max(map(abs, numbers)) > LARGEST_OFFSET or max(map(abs, scalings)) > LARGEST_SCALING:
        return NcError.SLAVE_COUPLING_PARAMETER
    if abs(demand.master_scaling) < SMALLEST_SCALING and demand.master_type != CamScaling.OFF:
        return NcError.SLAVE_COUPLING_PARAMETER
    return OK


def _order(layer: CamFields, kind: int, demand: CamDemand, cam: int) -> None:
    """Let a layer wait for this."""
    change, law = layer.change, layer.next
    change.kind = kind
    change.when = demand.activation
    change.position = demand.position
    change.master_type = demand.master_type
    change.slave_type = demand.slave_type
    law.table = demand.table_id if cam else 0
    law.cam = cam
    law.interpolation = demand.interpolation
    law.master_absolute = int(demand.master_absolute != 0)
    law.slave_absolute = int(demand.slave_absolute != 0)
    law.master_offset = demand.master_offset
    law.slave_offset = demand.slave_offset
    law.master_scaling = demand.master_scaling
    law.slave_scaling = demand.slave_scaling


def _fresh(slave: Axis, master: Axis, demand: CamDemand, cam: int, once: int = 0) -> CamFields:
    """Return a layer that is to begin, which belongs to no axis yet: a refusal changes nothing."""
    layer: CamFields = CAM.plain()
    layer.master, layer.once = master.index, once
    layer.last_master_position = master_position_of(slave, _rows_as_seen(slave, master), layer)
    _order(layer, CHANGE_BEGIN, demand, cam)
    return layer


def _rows_as_seen(slave: Axis, master: Axis) -> NcRows:
    """Return all axes, of which this one leads."""
    rows = slave.rows
    axes = list(rows.axes)
    axes[master.index] = as_leader(master)
    return replace(rows, axes=axes)


def _begin(
    slave: Axis, slave_type: int, master_id: int, demand: CamDemand, cam: int, operation: int
) -> int:
    """Return the first cam of an axis without a coupling."""
    code = check_slave(slave)
    if code:
        return code
    if slave_type == SlaveType.MULTI_TABULAR and operation == CamOperation.EXCHANGE:
        return NcError.TABLE_SLAVE_WITHOUT_TABLE
    if demand.master_type == CamScaling.AUTO_OFFSET:
        return NcError.SCALING_WITHOUT_REFERENCE_TABLE
    if demand.activation in _BY_CYCLE and not demand.master_absolute:
        return NcError.ONLINE_CHANGE_MODE
    begun: list[CamFields] = []

    def check(masters: Sequence[Axis]) -> int:
        begun.append(_fresh(slave, masters[0], demand, cam))
        return _check_begin(slave, begun[0], demand, masters[0])

    code = begin_coupling(slave, slave_type, [master_id], check=check)
    if code:
        return code
    for n, layer in enumerate(slave.cams):
        assign(layer, CAM.plain() if n else begun[0])
    slave.camming.count = 1
    _carry_out(slave, slave.cams[0])
    return OK


def _carry_out(slave: Axis, layer: CamFields) -> None:
    """Carry out what is due already, and show what has changed and what waits."""
    carry_out_now(slave, slave.rows, layer)
    slave.show_cams()


def _check_begin(slave: Axis, layer: CamFields, demand: CamDemand, master: Axis) -> int:
    """Refuse a cam that the slave would have to jump to, or whose master is already past the place
    where it is to begin."""
    rows = _rows_as_seen(slave, master)
    at = master_position_of(slave, rows, layer)
    names = names_of(rows, layer)
    moves = rows.axes[layer.master].leading_value.velocity
    by_axis = (
        CamActivation.MASTER_AXIS_POSITION,
        CamActivation.MASTER_AXIS_POSITION_POSITIVE,
        CamActivation.MASTER_AXIS_POSITION_NEGATIVE,
    )
    if demand.activation in by_axis and (demand.position - names - at) * moves < 0.0:
        return NcError.ACTIVATION_POSITION_PASSED
    slave_fixed = demand.slave_absolute and demand.slave_type != CamScaling.AUTO_OFFSET
    if demand.activation == CamActivation.AS_SOON_AS_POSSIBLE and slave_fixed:
        return _check_in_range(rows, layer, demand, at + names)
    return check_change(slave, rows, -1, layer)


def _check_in_range(rows: NcRows, layer: CamFields, demand: CamDemand, at: float) -> int:
    """Refuse a linear cam beside which its master is."""
    numbers, cam = rows.cams, layer.next.cam
    if not demand.master_absolute or numbers[cam + CYCLIC] != 0.0:
        return OK
    scaling, offset = demand.master_scaling, demand.master_offset
    if demand.master_type == CamScaling.OFF:
        scaling, offset = 1.0, 0.0
    place = (at - offset) / scaling
    if place < numbers[cam + BEGIN]:
        return NcError.TABLE_MASTER_BELOW
    if place > numbers[cam + BEGIN] + numbers[cam + PERIOD]:
        return NcError.TABLE_MASTER_ABOVE
    return OK


def _exchange(slave: Axis, layer: CamFields, master_id: int, demand: CamDemand, cam: int) -> int:
    """Let another table take the place of one that runs."""
    master = slave.fellows.get(master_id)
    if master is None:
        return NcError.ADDRESS_MASTER_AXIS
    if master.index != layer.master:
        return NcError.SLAVE_COUPLING_PARAMETER
    if demand.master_type == CamScaling.AUTO_OFFSET and not layer.now.table:
        return NcError.SCALING_WITHOUT_REFERENCE_TABLE
    if layer.change.kind not in (CHANGE_NOTHING, CHANGE_EXCHANGE):
        return NcError.ACTIVATION_PENDING
    return _let_wait(slave, layer, CHANGE_EXCHANGE, demand, cam)


def _let_wait(slave: Axis, layer: CamFields, kind: int, demand: CamDemand, cam: int = 0) -> int:
    """Order a change of a cam at work, unless its master is already past the place for it, or the
    slave would have to jump."""
    axes = list(slave.fellows.values())
    moves = axes[layer.master].leading_value.velocity
    at = master_position_of(slave, slave.rows, layer)
    at += names_of(slave.rows, layer)
    by_axis = demand.activation == CamActivation.MASTER_AXIS_POSITION
    if by_axis and (demand.position - at) * moves < 0.0:
        return NcError.ACTIVATION_POSITION_PASSED
    copy: CamFields = CAM.plain()
    assign(copy, layer)
    _order(copy, kind, demand, cam)
    code = check_change(slave, slave.rows, slave.cams.index(layer), copy)
    if code:
        return code
    _order(layer, kind, demand, cam)
    _carry_out(slave, layer)
    return OK


def _layer_of(slave: Axis, table_id: int) -> CamFields | None:
    """Return the layer that runs a table; 0: the first that runs any."""
    for layer in slave.cams[: slave.camming.count]:
        if layer.now.table and table_id in (0, layer.now.table):
            return layer
    return None


def _queued_layer(slave: Axis, table_id: int) -> CamFields | None:
    """Return the layer whose table has not begun yet; 0: the first such layer."""
    for layer in slave.cams[: slave.camming.count]:
        if layer.change.kind == CHANGE_BEGIN and table_id in (0, layer.next.table):
            return layer
    return None


def _check_layer(slave: Axis, table_id: int) -> int:
    """Code that refuses a change of a table that is not at work."""
    queued = _queued_layer(slave, table_id)
    return NcError.ACTIVATION_PENDING if queued else NcError.TABLE_NOT_FOUND


def _add(slave: Axis, master_id: int, demand: CamDemand, cam: int, once: int = 0) -> int:
    """Take a further cam in."""
    master = slave.fellows.get(master_id)
    if master is None:
        return NcError.ADDRESS_MASTER_AXIS
    if demand.master_type == CamScaling.AUTO_OFFSET:
        return NcError.SCALING_WITHOUT_REFERENCE_TABLE
    if demand.activation in _BY_CYCLE and not demand.master_absolute:
        return NcError.ONLINE_CHANGE_MODE
    free = [layer for layer in slave.cams if not layer.now.table and not layer.change.kind]
    if not free:
        return NcError.TOO_MANY_TABLES
    layer = free[0]
    fresh = _fresh(slave, master, demand, cam, once)
    code = _check_begin(slave, fresh, demand, master)
    code = code or _follow_too(slave, master)
    if code:
        return code
    assign(layer, fresh)
    slave.camming.count = max(slave.camming.count, slave.cams.index(layer) + 1)
    _carry_out(slave, layer)
    return OK


def _follow_too(slave: Axis, master: Axis) -> int:
    """Let the slave follow this axis besides those that it follows."""
    if master.index in slave.followed:
        return OK
    axes = list(slave.fellows.values())
    masters = [axes[row] for row in slave.followed]
    if len(masters) == CAM_LAYERS:
        return NcError.TOO_MANY_TABLES
    if master.error_code:
        return master.error_code
    before: SlaveCoupling = AXIS_PARTS["coupling"].plain()
    assign(before, slave.coupling)
    camming: CamSlave = AXIS_PARTS["camming"].plain()
    assign(camming, slave.camming)
    try:
        slave.follow(slave.coupling.law, [*masters, master])
    except CouplingRing:
        return NcError.MASTER_NOT_INSERTED
    coupling = slave.coupling
    for n, row in enumerate(coupling.masters):
        before.masters[n] = row
    before.master_count = coupling.master_count
    assign(coupling, before)
    assign(slave.camming, camming)
    return OK


def _remove(slave: Axis, demand: CamDemand) -> int:
    """Take a cam out; what it adds then remains."""
    if slave.coupling.law != SlaveType.MULTI_TABULAR:
        return NcError.TABLE_SLAVE_WITHOUT_TABLE
    code = _check(slave, demand, _AT_COUPLING)
    if code:
        return code
    layer = _layer_of(slave, demand.table_id)
    if layer is None:
        return _check_layer(slave, demand.table_id)
    stay = [
        each
        for each in slave.cams[: slave.camming.count]
        if each.now.table and each.change.kind != CHANGE_REMOVE
    ]
    if stay == [layer]:  # a slave without any cam: that is what decoupling is for
        return NcError.DECOUPLING_NOT_POSSIBLE
    if layer.change.kind not in (CHANGE_NOTHING, CHANGE_REMOVE):
        return NcError.ACTIVATION_PENDING
    return _let_wait(slave, layer, CHANGE_REMOVE, demand)


def change_cam_scaling(slave: Axis, demand: CamDemand) -> int:
    """Change offsets and scalings of a cam at work (0x4D); `table_id` 0 is the first cam.

    Activation 6 keeps the values waiting for good, 7 forgets what waits.
    """
    if slave.coupling.law not in CAM_COUPLINGS:
        return NcError.SLAVE_TYPE
    code = _check(slave, demand, _WHILE_RUNNING)
    if code:
        return code
    if demand.activation == CamActivation.DELETE_QUEUED:
        return _delete_queued(slave, demand.table_id)
    layer = _layer_of(slave, demand.table_id)
    if layer is None:
        return _check_layer(slave, demand.table_id)
    if demand.master_type == CamScaling.AUTO_OFFSET and not layer.now.master_absolute:
        return NcError.SCALING_MODE
    if layer.change.kind not in (CHANGE_NOTHING, CHANGE_SCALING):
        return NcError.ACTIVATION_PENDING
    return _let_wait(slave, layer, CHANGE_SCALING, demand)


def _delete_queued(slave: Axis, table_id: int) -> int:
    """Delete what waits for a cam; a cam that has not begun goes, unless it is the only one."""
    layer = _layer_of(slave, table_id) or _queued_layer(slave, table_id)
    if layer is None:
        return NcError.TABLE_NOT_FOUND
    others = (each for each in slave.cams[: slave.camming.count] if each is not layer)
    if not layer.now.table and not any(each.now.table or each.change.kind for each in others):
        return NcError.DECOUPLING_NOT_POSSIBLE
    layer.change.kind = layer.next.table = 0
    slave.show_cams()
    return OK


def change_cam_offsets(slave: Axis, slave_offset: float, master_offset: float, *more: float) -> int:
    """Change offsets, and scalings, of the first cam (0x43), at once or at a master position.

    `more` is empty, or slave scaling and master scaling, or these and the position.
    """
    if slave.coupling.law not in CAM_COUPLINGS:
        return NcError.SLAVE_TYPE
    layer = _layer_of(slave, 0)
    if layer is None:
        return _check_layer(slave, 0)
    slave_scaling, master_scaling = more[:2] or (layer.now.slave_scaling, layer.now.master_scaling)
    if 0.0 in more[:2]:
        return NcError.SLAVE_COUPLING_PARAMETER
    demand = CamDemand(
        slave_offset=slave_offset,
        master_offset=master_offset,
        slave_scaling=slave_scaling,
        master_scaling=master_scaling,
    )
    if len(more) > 2:
        demand = CamDemand(
            slave_offset=slave_offset,
            master_offset=master_offset,
            slave_scaling=slave_scaling,
            master_scaling=master_scaling,
            activation=CamActivation.MASTER_AXIS_POSITION,
            position=more[2],
        )
    return change_cam_scaling(slave, demand)


def scale_slave(slave: Axis, scaling: float) -> int:
    """Change the slave scaling of the first cam at once (0x49)."""
    if slave.coupling.law not in CAM_COUPLINGS:
        return NcError.SLAVE_TYPE
    layer = _layer_of(slave, 0)
    if layer is None:
        return _check_layer(slave, 0)
    return change_cam_scaling(
        slave,
        CamDemand(
            slave_offset=layer.now.slave_offset, slave_scaling=scaling, master_type=CamScaling.OFF
        ),
    )


def follow_correction(slave: Axis, table_id: int, position: float | None = None) -> int:
    """Run a correction table once, from now or from a master position on (0x46).

    Its slave positions are added from where it begins; its stroke remains.
    """
    if slave.coupling.law != SlaveType.MULTI_TABULAR:
        return NcError.SLAVE_TYPE
    begins = CamActivation.INSTANTANEOUS
    if position is not None:
        begins = CamActivation.MASTER_AXIS_POSITION
    demand = CamDemand(table_id, activation=begins, position=position or 0.0)
    code = _check(slave, demand, _AT_COUPLING)
    if code:
        return code
    if any(slave.camming.tables) and table_id not in slave.camming.tables:
        return NcError.TABLE_NOT_FOUND
    ran = _layer_of(slave, table_id) if table_id else None
    if ran is not None and not ran.once:
        return NcError.SLAVE_TABLE_IN_USE
    try:
        cam = slave.tables.cam(table_id, demand.interpolation)
    except TableError as fault:
        return fault.error
    axes = list(slave.fellows.values())
    if ran is not None:  # what it has added remains
        return _let_wait(slave, ran, CHANGE_EXCHANGE, demand, cam)
    return _add(slave, axes[slave.cams[0].master].axis_id, demand, cam, once=1)


def end_profile(slave: Axis, table_id: int) -> int:
    """Take a cam out at the end of its cycle (0x47)."""
    if slave.coupling.law != SlaveType.MULTI_TABULAR:
        return NcError.SLAVE_TYPE
    return _remove(slave, CamDemand(table_id, activation=CamActivation.NEXT_CYCLE))


def last_correction(slave: Axis, table_id: int) -> float | None:
    """Return the sum that a correction table has added so far (0x48); None without such a table."""
    for layer in slave.cams[: slave.camming.count]:
        if layer.now.table == table_id and layer.once:
            return layer.part
    return None
