"""A machine that feeds parts to a table: the program under test."""

from achse.client.nc import AxisError
from achse.client.nc.blocking import RemoteAxis

STATIONS = 4


class Machine:
    """Moves a part forward and turns the table by one station."""

    def __init__(self, feeder: RemoteAxis, table: RemoteAxis) -> None:
        self.feeder = feeder
        self.table = table
        self.parts = 0

    def start(self) -> None:
        for axis in (self.feeder, self.table):
            if axis.error() is not None:
                axis.reset()
            axis.enable()

    def feed(self, length: float) -> None:
        """Push a part onto the table. The feeder is back, and the fault told, whatever happens."""
        try:
            self.feeder.move_to(length, velocity=500, within=10)
            self.table.move_by(360 / STATIONS, velocity=360, within=10)
            self.parts += 1
        except AxisError as error:
            for axis in (self.feeder, self.table):
                axis.halt() if axis.error() is None else None
            raise RuntimeError(f"part {self.parts + 1}: {error}") from error
        finally:
            if self.feeder.error() is None:
                self.feeder.move_to(0, velocity=800)
