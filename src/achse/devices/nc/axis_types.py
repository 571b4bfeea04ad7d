"""The cyclic axis interface as IEC structures, for symbols and for programs that look into it.

Names of the members as in the PLC library (004 §5.1) and its successor; the bytes are those of
`layouts.NC_TO_PLC_TC3` and `layouts.PLC_TO_NC`.
"""

from achse.iec import ARRAY, BOOL, BYTE, DINT, DWORD, LREAL, UDINT, UINT, USINT, Struct, var

__all__ = ["NCTOPLC_AXIS_REF", "PLCTONC_AXIS_REF"]


class NCTOPLC_AXIS_REF(Struct):  # noqa: N801
    """What the NC shows the PLC in each cycle, 256 bytes."""

    StateDWord = var(DWORD)
    ErrorCode = var(DWORD)
    AxisState = var(DWORD)
    AxisModeConfirmation = var(DWORD)
    HomingState = var(DWORD)
    CoupleState = var(DWORD)
    SvbEntries = var(DWORD)
    SafEntries = var(DWORD)
    AxisId = var(DWORD)
    OpModeDWord = var(DWORD)
    ActPos = var(LREAL)
    ModuloActPos = var(LREAL)
    ActiveControlLoopIndex = var(UINT)
    ControlLoopIndex = var(UINT)
    ModuloActTurns = var(DINT)
    ActVelo = var(LREAL)
    PosDiff = var(LREAL)
    SetPos = var(LREAL)
    SetVelo = var(LREAL)
    SetAcc = var(LREAL)
    TargetPos = var(LREAL)
    ModuloSetPos = var(LREAL)
    ModuloSetTurns = var(DINT)
    CmdNo = var(UINT)
    CmdState = var(UINT)
    SetJerk = var(LREAL)
    SetTorque = var(LREAL)
    ActTorque = var(LREAL)
    StateDWord2 = var(DWORD)
    StateDWord3 = var(DWORD)
    TouchProbeState = var(DWORD)
    TouchProbeCounter = var(DWORD)
    CamCouplingState = var(ARRAY(USINT, (0, 7)))
    CamCouplingTableID = var(ARRAY(UINT, (0, 7)))
    ActTorqueDerivative = var(LREAL)
    SetTorqueDerivative = var(LREAL)
    AbsPhasingPos = var(LREAL)
    TorqueOffset = var(LREAL)
    ActPosWithoutPosCorrection = var(LREAL)
    ActAcc = var(LREAL)
    DcTimeStamp = var(UDINT)
    UserData = var(LREAL)


class PLCTONC_AXIS_REF(Struct):  # noqa: N801
    """What the PLC gives the NC in each cycle, 128 bytes."""

    ControlDWord = var(DWORD)
    Override = var(UDINT)
    AxisModeRequest = var(DWORD)
    AxisModeDWord = var(DWORD)
    AxisModeLReal = var(LREAL)
    PositionCorrection = var(LREAL)
    ExtSetPos = var(LREAL)
    ExtSetVelo = var(LREAL)
    ExtSetAcc = var(LREAL)
    ExtSetDirection = var(DINT)
    ExtControllerOutput = var(LREAL)
    GearRatio1 = var(LREAL)
    GearRatio2 = var(LREAL)
    GearRatio3 = var(LREAL)
    GearRatio4 = var(LREAL)
    MapState = var(BOOL)
    PlcCycleControl = var(BYTE)
    PlcCycleCount = var(BYTE)
    ExtTorque = var(LREAL)
    Reserved = var(ARRAY(BYTE, (0, 7)))
