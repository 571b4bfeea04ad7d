"""Modbus devices, queried for PLC programs."""

from achse.devices.modbus.device import MODBUS_PORT, ModbusDevice

__all__ = ["MODBUS_PORT", "ModbusDevice"]
