"""The NC of a TwinCAT solution: its axes and channels as tables of a station.toml.

    <Axis Id="1"><Name>X</Name><AxisPara><Velo Maximum="200"/></AxisPara>
      <Encoder><EncPara ScaleFactorNumerator="5" ScaleFactorDenominator="1000"/></Encoder></Axis>
    <Channel Id="2" ChannelType="2"><Name>NCI</Name><Group Id="5" GroupType="4"/></Channel>

Values are decimal, or `#x` and hexadecimal. Source: as in `achse.station.configuration.solution`.
"""

import logging
import math
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from achse.codes.nc.choices import EncoderType
from achse.motion.groups.parameters import LONGEST_FIFO, MOST_AXES
from achse.motion.nc import HIGHEST_AXIS_ID
from achse.motion.record import FIELDS
from achse.st.lexis.xml import Element
from achse.station.configuration.types import LONGEST_NAME, LONGEST_UNIT, ConfigError

log = logging.getLogger("achse.station")

_HEXADECIMAL = re.compile(r"#x[0-9a-f]{1,8}")


class AxisPara(NamedTuple):
    """One parameter of an axis in the files of a solution, and its key in station.toml."""

    path: str
    """Elements from `<Axis>` on."""
    attribute: str
    key: str


_AXIS, _ENCODER, _CONTROLLER = "AxisPara", "Encoder/EncPara", "Controller/CtrPara"
_DRIVE = "Drive/DrvPara"

PARAMETERS = (
    AxisPara(f"{_AXIS}/Dynamic", "Acceleration", "default_acceleration"),
    AxisPara(f"{_AXIS}/Dynamic", "Deceleration", "default_deceleration"),
    AxisPara(f"{_AXIS}/Dynamic", "Jerk", "default_jerk"),
    AxisPara(f"{_AXIS}/Dynamic", "AccelerationMaximum", "max_acceleration"),
    AxisPara(f"{_AXIS}/Dynamic", "DecelerationMaximum", "max_deceleration"),
    AxisPara(f"{_AXIS}/Velo", "Maximum", "max_velocity"),
    AxisPara(f"{_AXIS}/Velo", "Fast", "rapid_traverse_velocity"),
    AxisPara(f"{_AXIS}/Velo", "FastManual", "jog_velocity_fast"),
    AxisPara(f"{_AXIS}/Velo", "SlowManual", "jog_velocity_slow"),
    AxisPara(f"{_AXIS}/Velo", "RefSearch", "homing_velocity_towards_cam"),
    AxisPara(f"{_AXIS}/Velo", "RefSync", "homing_velocity_off_cam"),
    AxisPara(f"{_AXIS}/PositionAreaControl", "Enable", "position_range_monitoring_enable"),
    AxisPara(f"{_AXIS}/PositionAreaControl", "Range", "position_range_window"),
    AxisPara(f"{_AXIS}/TargetPosControl", "Enable", "target_position_monitoring_enable"),
    AxisPara(f"{_AXIS}/TargetPosControl", "Range", "target_position_window"),
    AxisPara(f"{_AXIS}/TargetPosControl", "Time", "target_position_monitoring_time"),
    AxisPara(f"{_AXIS}/PEHControl", "Enable", "peh_monitoring_enable"),
    AxisPara(f"{_AXIS}/PEHControl", "Time", "peh_monitoring_time"),
    AxisPara(f"{_AXIS}/MotionControl", "Enable", "motion_monitoring_enable"),
    AxisPara(f"{_AXIS}/MotionControl", "Range", "motion_monitoring_window"),
    AxisPara(f"{_AXIS}/MotionControl", "Time", "motion_monitoring_time"),
    AxisPara(f"{_AXIS}/OtherSettings", "AllowMotionCmdToSlave", "allow_slave_motion_commands"),
    AxisPara(f"{_AXIS}/OtherSettings", "ErrorReactionDelay", "error_reaction_delay"),
    AxisPara(f"{_AXIS}/OtherSettings", "NoMotionFilterTime", "no_motion_time"),
    AxisPara(f"{_AXIS}/OtherSettings", "PulseDistancePos", "pulse_distance_positive"),
    AxisPara(f"{_AXIS}/OtherSettings", "PulseDistanceNeg", "pulse_distance_negative"),
    AxisPara(_ENCODER, "ScaleFactorNumerator", "encoder_scaling_numerator"),
    AxisPara(_ENCODER, "ScaleFactorDenominator", "encoder_scaling_denominator"),
    AxisPara(_ENCODER, "Offset", "encoder_position_offset"),
    AxisPara(_ENCODER, "Inverse", "encoder_count_direction"),
    AxisPara(_ENCODER, "MaxCount", "encoder_mask"),
    AxisPara(f"{_ENCODER}/Inc", "RefSoftSyncMask", "encoder_sub_mask"),
    AxisPara(_ENCODER, "ModuloFactor", "encoder_modulo_factor"),
    AxisPara(_ENCODER, "ToleranceWndModuloStart", "encoder_modulo_tolerance_window"),
    AxisPara(f"{_ENCODER}/SoftEndMinControl", "Enable", "encoder_soft_limit_min_enable"),
    AxisPara(f"{_ENCODER}/SoftEndMinControl", "Range", "encoder_soft_limit_min"),
    AxisPara(f"{_ENCODER}/SoftEndMaxControl", "Enable", "encoder_soft_limit_max_enable"),
    AxisPara(f"{_ENCODER}/SoftEndMaxControl", "Range", "encoder_soft_limit_max"),
    AxisPara(
        f"{_CONTROLLER}/PosDiffControl",
        "Enable",
        "controller_following_error_position_monitoring_enable",
    ),
    AxisPara(f"{_CONTROLLER}/PosDiffControl", "Range", "controller_following_error_position_max"),
    AxisPara(
        f"{_CONTROLLER}/PosDiffControl", "Time", "controller_following_error_position_filter_time"
    ),
    AxisPara(_DRIVE, "Inverse", "drive_motor_polarity"),
    AxisPara(f"{_DRIVE}/Analog", "VeloReferenz", "drive_reference_velocity"),
    AxisPara(f"{_DRIVE}/Analog", "ScaleFactorActTorque", "drive_actual_torque_scaling"),
)
"""Parameters that an axis takes from its solution; its simulated machine counts in increments of
the same scaling, whatever hardware the solution has."""

_READ = frozenset((row.path, row.attribute) for row in PARAMETERS) | {
    (f"{_AXIS}/General", "UnitName")
}
_SECTIONS = (_AXIS, _ENCODER, _CONTROLLER, _DRIVE)
_KINDS = (("Encoder", "EncType"), ("Controller", "CtrType"), ("Drive", "DrvType"))
_SCALING = ("encoder_scaling_numerator", "encoder_scaling_denominator")
_SOFT_LIMITS = (("encoder_soft_limit_min", 1.0), ("encoder_soft_limit_max", -1.0))
"""Limits, with the sign of the distance from them to a permitted position."""

_CHANNELS = {"2": "interpreter", "3": "fifo", "4": "kinematic"}
_GROUPS = {"4": "3d", "11": "fifo", "12": "kinematic"}
_INTERPOLATIONS = {"0": "linear", "1": "four_point", "4": "cubic_spline"}
_FIFO = (("FifoDimension", "dimension", MOST_AXES), ("FifoLength", "length", LONGEST_FIFO))
_LONGEST_DELTA_NS = 3_600_000_000_000
_PROGRAMS = ("Interpreter", "Interpreter/MFunc")
"""Elements of a channel whose program or M functions are left out."""
_HIGHEST_ID = HIGHEST_AXIS_ID
"""Of channels too, and of groups, which share the ids of axes."""
_LONGEST_PART = 80
_MOST_REPORTED = 40

_WITHIN = (
    ("max_velocity", "rapid_traverse_velocity", "jog_velocity_fast", "jog_velocity_slow"),
    ("max_acceleration", "default_acceleration"),
    ("max_deceleration", "default_deceleration"),
)
"""A limit, and values whose defaults may not exceed it."""


# axes ----------------------------------------------------------------------------------------


class LeftOut:
    """Parameters of a solution that a station has no key for, with their counts."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def add(self, name: str) -> None:
        """Count a parameter of that name."""
        self._counts[name[:_LONGEST_PART]] += 1

    def add_axis(self, axis: Element) -> None:
        """Count the parameters of an axis that no key of ours has."""
        for tag, attribute in _KINDS:
            elements = axis.all(tag)
            for element in elements[:1]:
                if attribute in element.attributes and not _is_simulated(axis, tag):
                    self.add(f"{tag}@{attribute}")
            for _ in elements[1:]:
                self.add(f"second {tag}")
        for section in _SECTIONS:
            inner = _inner(axis, section)
            parts = () if inner is None else ((section, inner), *_parts(section, inner))
            for path, element in parts:
                for attribute in element.attributes:
                    if (path, attribute) not in _READ:
                        self.add(f"{path}@{attribute}")

    def report(self, path: Path) -> None:
        """Log all of them in one line."""
        if self._counts:
            names = [
                f"{name} ({count})" for name, count in self._counts.most_common(_MOST_REPORTED)
            ]
            more = len(self._counts) - len(names)
            rest = f", and {more} more" if more else ""
            log.info("%s: left out of the NC: %s%s", path, ", ".join(names), rest)


def _parts(path: str, element: Element) -> Iterator[tuple[str, Element]]:
    for child in element:
        yield f"{path}/{child.tag}", child


def axis_table(element: Element, path: Path, left_out: LeftOut) -> dict[str, Any]:
    """Return the [[axis]] of an `<Axis>`; parameters without a key are added to `left_out`."""
    name = element.text_of("Name").strip()
    axis: dict[str, Any] = {"id": whole_number(element.attributes.get("Id", ""))}
    axis["name"] = name[:LONGEST_NAME] or f"Axis {axis['id']}"
    unit = _attribute(element, f"{_AXIS}/General", "UnitName")
    if unit:
        axis["unit"] = unit[:LONGEST_UNIT]
    if _is_simulated(element, "Encoder"):
        axis["simulation_ideal"] = True
    for row in PARAMETERS:
        text = _attribute(element, row.path, row.attribute)
        if text is None:
            continue
        value = _value(text, row.key)
        if value is None:
            log.warning("%s: axis %s: %s: %.40r is left out", path, name, row.key, text)
        else:
            axis[row.key] = value
    for limit, *keys in _WITHIN:
        for key in keys if limit in axis else ():
            axis.setdefault(key, min(FIELDS[key].default, axis[limit]))
    left_out.add_axis(element)
    _check_encoder(axis, path)
    return axis


def _is_simulated(axis: Element, tag: str) -> bool:
    """True for an encoder without hardware, whose position is the set point."""
    kind = whole_number(_attribute(axis, tag, "EncType") or "")
    return tag == "Encoder" and kind == EncoderType.SIMULATION


def _check_encoder(axis: dict[str, Any], path: Path) -> None:
    """Remove a scaling out of range and an offset beyond an enabled soft limit, and log both.

    The offset of an absolute encoder belongs to the count of its hardware; the simulated encoder
    starts at count 0.
    """
    numerator, denominator = (axis.get(key, FIELDS[key].default) for key in _SCALING)
    field = FIELDS["encoder_scaling_factor"]
    if not field.least <= numerator / denominator <= field.most:
        values = path, axis["name"], numerator, denominator
        log.warning("%s: axis %s: scaling %g / %g is left out", *values)
        for key in _SCALING:
            axis.pop(key, None)
    offset = axis.get("encoder_position_offset", 0.0)
    for key, sign in _SOFT_LIMITS:
        limit = axis.get(key, FIELDS[key].default)
        if axis.get(f"{key}_enable") and sign * (offset - limit) < 0.0 < abs(offset):
            end = f"{key} {limit:g}"
            log.info(
                "%s: axis %s: offset %g is left out, beyond %s", path, axis["name"], offset, end
            )
            del axis["encoder_position_offset"]
            return


def make_names_unique(axes: list[dict[str, Any]]) -> None:
    """Append its id to the name of each axis whose shortened name is not unique."""
    names = Counter(axis["name"] for axis in axes)
    for axis in axes:
        if names[axis["name"]] > 1:
            end = f" {axis['id']}"
            axis["name"] = axis["name"][: LONGEST_NAME - len(end)] + end


def _attribute(element: Element, path: str, name: str) -> str | None:
    inner = _inner(element, path)
    return None if inner is None else inner.attributes.get(name)


def _inner(element: Element, path: str) -> Element | None:
    inner: Element | None = element
    for tag in path.split("/"):
        inner = None if inner is None else inner.find(tag)
    return inner


def _value(text: str, key: str) -> bool | float | None:
    """Return a value of the parameter's type and range; None for another."""
    text = text.strip().lower()
    if text in ("true", "false"):
        return text == "true"
    try:
        number = float(int(text[2:10], 16)) if _HEXADECIMAL.fullmatch(text) else float(text)
    except ValueError:
        return None
    field = FIELDS[key]
    return number if math.isfinite(number) and field.least <= number <= field.most else None


# channels ------------------------------------------------------------------------------------


def channel_tables(
    nc: Element, taken: set[int], path: Path, left_out: LeftOut
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the [[channel]] and [[group]] of an NC; no group has the id of an axis (`taken`)."""
    elements = nc.all("Channel")
    if len(elements) > _HIGHEST_ID:
        raise ConfigError(f"{path}: expected up to {_HIGHEST_ID} channels, got {len(elements)}")
    channels: dict[int, dict[str, Any]] = {}
    groups: list[dict[str, Any]] = []
    for element in elements:
        name = _name(element)
        number = whole_number(element.attributes.get("Id", ""))
        kind = _CHANNELS.get(element.attributes.get("ChannelType", ""))
        if kind is None or not 1 <= number <= _HIGHEST_ID or number in channels:
            log.warning("%s: channel %s is left out", path, name)
            continue
        channels[number] = {"id": number, "name": name, "type": kind}
        for tag in _PROGRAMS:
            part = _inner(element, tag)
            if part is not None and (part.text or "ProgName" in part.attributes):
                left_out.add(f"Channel/{tag}")
        for each in element.all("Group"):
            group = _group(each, number, kind, taken, path, left_out)
            if group is not None:
                groups.append(group)
                taken = taken | {group["id"]}
    return list(channels.values()), groups


def _group(
    element: Element, channel: int, kind: str, taken: set[int], path: Path, left_out: LeftOut
) -> dict[str, Any] | None:
    name = _name(element)
    number = whole_number(element.attributes.get("Id", ""))
    type_ = _GROUPS.get(element.attributes.get("GroupType", ""))
    free = [each for each in range(_HIGHEST_ID, 0, -1) if each not in taken]
    if type_ is None or (type_ == "3d") != (kind == "interpreter") or not free:
        log.warning("%s: group %s is left out", path, name)
        return None
    if number in taken or not 1 <= number <= _HIGHEST_ID:
        log.info("%s: group %s has id %d, %d is taken", path, name, free[0], number)
        number = free[0]
    group: dict[str, Any] = {"id": number, "name": name, "type": type_, "channel": channel}
    fifo = _inner(element, "Parameter/Fifo")
    if type_ == "fifo" and fifo is not None:
        said = fifo.attributes
        for attribute, key, most in _FIFO:
            if 1 <= (value := whole_number(said.get(attribute, ""))) <= most:
                group[key] = value
        if (interpolation := _INTERPOLATIONS.get(said.get("FifoIpolType", ""))) is not None:
            group["interpolation"] = interpolation
        try:
            nanoseconds = round(float(said.get("TimeUnitFifo", "")) * 1e9)
        except (ValueError, OverflowError):
            nanoseconds = 0
        if 0 < nanoseconds <= _LONGEST_DELTA_NS:
            group["time_delta"] = f"{nanoseconds}ns"
    if type_ == "kinematic":
        left_out.add("Channel/Group/Parameter/Kinematic")
    return group


def _name(element: Element) -> str:
    name = element.text_of("Name").strip()[:LONGEST_NAME]
    return "".join(sign for sign in name if sign.isprintable())


def whole_number(text: str) -> int:
    """Return the number of up to nine decimal digits; 0 for any other text."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else 0
