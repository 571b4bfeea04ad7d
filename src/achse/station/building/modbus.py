"""The Modbus server of a station: what its PLC programs ask Modbus devices by."""

from achse.devices.modbus import MODBUS_PORT, ModbusDevice
from achse.devices.system import SystemDevice
from achse.station.building.building import Building


def make_modbus(building: Building) -> None:
    """Make the device at port 10500, if the configuration has it. Raises ConfigError."""
    ground = building.ground
    config = ground.config.modbus
    if config is None:
        return
    systems = [each for each in building.devices if isinstance(each, SystemDevice)]
    device = ModbusDevice(
        config.find,
        clock=ground.clock,
        beside=lambda: any(system.files.worker is not None for system in systems),
    )
    building.add_end(device.client.close)
    building.attach(device, MODBUS_PORT)
