"""Alarms and warnings of the drive: their numbers on the bus, on the panel and in words.

An alarm is a fault (transition 13); its code is what 603Fh and the emergency message carry. A
warning is a bit of 3110h or 3111h and changes neither state nor motion. Source: 001 table of
603Fh, 3110h, 3111h.
"""

from enum import Enum


class Alarm(Enum):
    """One alarm: `code` as in 603Fh, `panel` as the drive shows it."""

    code: int
    panel: str
    text: str

    def __new__(cls, code: int, panel: str, text: str) -> "Alarm":
        member = object.__new__(cls)
        member._value_ = code
        member.code = code
        member.panel = panel
        member.text = text
        return member

    @staticmethod
    def of(code: int) -> "Alarm | None":
        """Return the alarm with this 603Fh code, or None if the table has none."""
        return _BY_CODE.get(code)

    SYSTEM_ALARM_1 = (0xFF04, "AL.024", "System alarm 1.")
    SYSTEM_ALARM_2 = (0xFF05, "AL.025", "System alarm 2.")
    MAIN_CIRCUIT_DETECTOR_ERROR = (0xFF06, "AL.030", "Main circuit detector error.")
    PARAMETER_SETTING_ERROR = (0xFF07, "AL.040", "Parameter setting error.")
    COMBINATION_ERROR = (0xFF0B, "AL.050", "Combination error.")
    MOTOR_TYPE_CHANGE_DETECTED = (0xFF0C, "AL.070", "Motor type change detected.")
    INVALID_SERVO_ON_COMMAND_ALARM = (0xFF0E, "AL.0b0", "Invalid Servo ON command alarm.")
    OVER_CURRENT_DETECTED = (0xFF0F, "AL.100", "Over current detected.")
    REGENERATIVE_OVERLOAD = (0xFF10, "AL.320", "Regenerative overload.")
    OVER_VOLTAGE = (0xFF11, "AL.400", "Over voltage.")
    UNDER_VOLTAGE = (0xFF12, "AL.410", "Under voltage.")
    OVER_SPEED = (0xFF13, "AL.510", "Over speed.")
    ENCODER_OUTPUT_PULSE_OVERSPEED = (0xFF14, "AL.511", "Encoder output pulse overspeed.")
    INSTANTANEOUS_OVERLOAD = (0xFF18, "AL.710", "Instantaneous overload.")
    CONTINUOUS_OVERLOAD = (0xFF19, "AL.720", "Continuous overload.")
    INTERNAL_OVERHEAT_ERROR_2 = (0xFF1E, "AL.7A2", "Internal overheat error 2 (power board).")
    DATA_BACKUP_ERROR = (0xFF21, "AL.800", "Data backup error.")
    BATTERY_ERROR = (0xFF22, "AL.810", "Battery error.")
    ENCODER_COMMUNICATION_ERROR = (0xFF23, "AL.820", "Encoder com. error.")
    ENCODER_DATA_ERROR = (0xFF24, "AL.830", "Encoder data error.")
    ENCODER_CRC_ERROR = (0xFF25, "AL.840", "Encoder crc error.")
    ENCODER_COUNTING_ERROR = (0xFF26, "AL.850", "Encoder counting error.")
    WRITE_DATA_FAIL_ERROR = (0xFF27, "AL.860", "Write data fail error.")
    ENCODER_OVER_HEAT_ERROR = (0xFF28, "AL.870", "Encoder over heat error.")
    ENCODER_SENSOR_PHASE_ERROR = (0xFF29, "AL.880", "Encoder sensor phase error (AqB).")
    ESC_INCREMENTAL_ENCODER_CABLE_NOT_CONNECTED = (
        0xFF2A,
        "AL.890",
        "ESC ALM - Incremental encoder cable not connected.",
    )
    ESC_CH1_ESC_SIDE_ERROR = (0xFF2B, "AL.8A0", "ESC ALM - CH1 ESC side error.")
    ESC_CH1_ENCODER_SIDE_ERROR = (0xFF2C, "AL.8b0", "ESC ALM - CH1 Encoder side error.")
    ESC_CH2_ESC_SIDE_ERROR = (0xFF2D, "AL.8C0", "ESC ALM - CH2 ESC side error.")
    ESC_CH2_ENCODER_SIDE_ERROR = (0xFF2E, "AL.8d0", "ESC ALM - CH2 Encoder side error.")
    DIGITAL_ENCODER_CABLE_NOT_CONNECTED = (
        0xFF2F,
        "AL.8E0",
        "Digital encoder cable not connected.",
    )
    ESC_INTERNAL_FAULT = (0xFF30, "AL.8F0", "ESC ALM - Internal fault.")
    MOTOR_OVERHEATED = (0xFF31, "AL.861", "Motor overheated.")
    SPEED_REFERENCE_AD_ERROR = (0xFF32, "AL.b10", "Speed reference A/D error.")
    TORQUE_REFERENCE_AD_ERROR = (0xFF34, "AL.b20", "Torque reference A/D error.")
    CURRENT_DETECTION_ERROR = (0xFF35, "AL.b33", "Current detection error.")
    SERVOMOTOR_OUT_OF_CONTROL = (0xFF36, "AL.C10", "Servomotor out of control.")
    PHASE_DETECTION_ERROR = (0xFF37, "AL.C20", "Phase detection error.")
    POLARITY_SENSOR_ERROR = (0xFF38, "AL.C21", "Polarity sensor error (Hall sensor).")
    POLARITY_DETECTION_FAILURE = (0xFF3A, "AL.C50", "Polarity detection failure.")
    OVERTRAVEL_DETECTED_DURING_POLARITY_DETECTION = (
        0xFF3B,
        "AL.C51",
        "Overtravel detected during polarity detection.",
    )
    POLARITY_DETECTION_NOT_COMPLETED = (0xFF3C, "AL.C52", "Polarity detection not completed.")
    POSITION_ERROR_TOO_BIG = (0xFF3E, "AL.d00", "Position error too big.")
    HYBRID_DEVIATION_ERROR = (0xFF41, "AL.d10", "Hybrid deviation error (motor to load).")
    SAFETY_FUNCTION_ALARM = (0xFF42, "AL.Eb0", "Safety function alarm.")
    SAFETY_FUNCTION_SIGNAL_INPUT_TIMING_ERROR = (
        0xFF43,
        "AL.Eb1",
        "Safety function signal input timing error.",
    )
    SAFETY_FUNCTION_SELF_CHECK_ERROR = (0xFF44, "AL.Eb2", "Safety function self-check error.")
    POWER_SUPPLY_LINE_OPEN_PHASE = (0xFF45, "AL.F10", "Power supply line open phase.")
    SERVOMOTOR_MAIN_CIRCUIT_CABLE_DISCONNECTION = (
        0xFF46,
        "AL.F50",
        "Servomotor main circuit cable disconnection (motor maybe disconnected).",
    )
    POWER_SUPPLY_FOR_ENCODER_ERROR = (
        0xFF47,
        "AL.FA0",
        "Power supply for encoder error (5V card fail).",
    )
    FIELDBUS_HARDWARE_FAULT = (0xFF48, "AL.FB0", "FieldBus Hardware Fault.")
    FIELDBUS_COMMUNICATION_FAULT = (0xFF49, "AL.FB1", "FieldBus Communication Fault.")
    GROUP_COMMUNICATION_FAULT = (0xFF4A, "AL.FC0", "Group Communication Fault.")
    GANTRY_SYSTEM_SLAVE_ALARM = (0xFF4B, "AL.FC1", "Gantry system slave alarm.")
    INCREMENTAL_ENCODER_SIGNAL_ERROR = (0xFF4C, "AL.891", "Incremental encoder signal error.")
    FIELDBUS_COMMUNICATION_SETUP_ERROR = (0xFF4D, "AL.FB2", "Fieldbus communication setup error.")


_BY_CODE = {alarm.code: alarm for alarm in Alarm}


class Warn(Enum):
    """One warning: its word (3110h or 3111h), its bit there and its panel number."""

    index: int
    bit: int
    panel: str
    text: str

    def __new__(cls, index: int, bit: int, panel: str, text: str) -> "Warn":
        member = object.__new__(cls)
        member._value_ = (index, bit)
        member.index = index
        member.bit = bit
        member.panel = panel
        member.text = text
        return member

    @property
    def mask(self) -> int:
        return 1 << self.bit

    @property
    def number(self) -> int:
        """The panel number as a hexadecimal number, AL.9A0 is 0x9A0: the warning code of 4096h."""
        return int(self.panel[3:], 16)

    POSITION_DEVIATION_OVERFLOW = (0x3110, 0, "AL.900", "Position deviation overflow.")
    OVERLOAD = (0x3110, 2, "AL.910", "Overload.")
    INTERNAL_FAN_STOP = (0x3110, 7, "AL.923", "Internal fan stop.")
    ENCODER_BATTERY_MALFUNCTION = (0x3110, 8, "AL.930", "Encoder battery malfunction.")
    RESTART_REQUIRED = (
        0x3110,
        9,
        "AL.941",
        "Change of parameters and functions with save and restart requirement.",
    )
    UNDERVOLTAGE = (0x3110, 10, "AL.971", "Undervoltage.")
    OVERTRAVEL = (
        0x3110,
        11,
        "AL.9A0",
        "Overtravel detected when servo ON (P-OT or N-OT signal is received).",
    )
    POSITIVE_LIMIT = (0x3110, 12, "AL.9A1", "P-OT signal is received.")
    NEGATIVE_LIMIT = (0x3110, 13, "AL.9A2", "N-OT signal is received.")
    SERVO_VOLTAGE_TOO_BIG = (0x3111, 0, "AL.9F0", "Servo voltage too big.")
    SYNC_CYCLE_TIME = (0x3111, 1, "AL.943", "Fieldbus synchronous cycle time warning.")
    SYSTEM = (0x3111, 2, "AL.944", "System warning.")
    TORQUE_LIMIT = (0x3111, 3, "AL.945", "Torque limit warning.")
    ENCODER_COMMUNICATION = (0x3111, 4, "AL.946", "Encoder communication warning.")
    MULTI_MOTION = (0x3111, 5, "AL.947", "Multi-motion malfunction warning.")
    I2T = (0x3111, 6, "AL.924", "I2T.")
