"""The table of groups: which class makes which type, and all groups of an NC."""

from collections.abc import Callable, Iterable, Iterator, Mapping

from achse.motion.axis import Axis
from achse.motion.groups.fifo import FifoGroup
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.kinematics.table import KINEMATICS, law_from_file
from achse.motion.groups.parameters import GroupParameters, GroupParametersError
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import GroupType


def _kinematic(parameters: GroupParameters, axes: Mapping[int, Axis]) -> KinematicGroup:
    """Return a group with the law that its parameters name."""
    kinematics = parameters.kinematics
    if kinematics.file is None and kinematics.law not in KINEMATICS:
        raise GroupParametersError(
            f"group {parameters.group_id}: kinematics {kinematics.law!r}, expected "
            f"{', '.join(KINEMATICS)} or a file"
        )
    law = KINEMATICS[kinematics.law] if kinematics.file is None else law_from_file(kinematics.file)
    numbers = law.in_order(kinematics.values, f"group {parameters.group_id}: kinematics")
    return KinematicGroup(parameters, axes, law, numbers)


GROUPS: Mapping[GroupType, Callable[[GroupParameters, Mapping[int, Axis]], AxisGroup]] = {
    GroupType.THREE_D: PathGroup,
    GroupType.FIFO: FifoGroup,
    GroupType.KINEMATIC: _kinematic,
}


class Groups:
    """The groups of several axes of an NC, by their ids."""

    def __init__(
        self, configured: Iterable[GroupParameters], axes: Mapping[int, Axis], dt: float
    ) -> None:
        self._groups: dict[int, AxisGroup] = {}
        self._dt = dt
        for parameters in sorted(configured, key=lambda each: each.group_id):
            group_id = parameters.group_id
            if group_id in self._groups or group_id in axes:
                taken = "that of the PTP group of an axis" if group_id in axes else "given twice"
                raise GroupParametersError(f"group id {group_id} is {taken}")
            if parameters.type not in GROUPS:
                raise GroupParametersError(
                    f"group {group_id}: type {parameters.type!r}, expected one of "
                    f"{', '.join(type.name for type in GROUPS)}"
                )
            group = self._groups[group_id] = GROUPS[parameters.type](parameters, axes)
            code = group.assign(parameters.axes) if parameters.axes else 0
            if code:
                raise GroupParametersError(
                    f"group {group_id}: axes {list(parameters.axes)}: NC error 0x{code:X}"
                )
        self._kinematic = [each for each in self if isinstance(each, KinematicGroup)]

    def __iter__(self) -> Iterator[AxisGroup]:
        return iter(self._groups.values())

    def __len__(self) -> int:
        return len(self._groups)

    def group(self, group_id: int) -> AxisGroup:
        """Return the group with this id; KeyError if there is none."""
        return self._groups[group_id]

    @property
    def busy(self) -> bool:
        """True if any group gives set points, or may in the next cycles."""
        for group in self._groups.values():  # a third of the time of any()
            if group.moving:
                return True
        return any(group.wants_to_move for group in self._kinematic) if self._kinematic else False

    def step(self) -> None:
        """Run one cycle of all groups that move; before the axes have theirs."""
        for follower in self._kinematic:
            if follower.wants_to_move:
                follower.begin()
        for group in self._groups.values():
            if group.moving:
                group.step(self._dt)
