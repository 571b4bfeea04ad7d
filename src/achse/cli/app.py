"""The command tree. Commands import what they need when they run, so that `--help` stays quick."""

from achse.cli.ads import ads, route, router, scan, stats
from achse.cli.axes import axis, camshaft, excite, gear, parameters, table
from achse.cli.fieldbus import bus, drive
from achse.cli.install import certificate, docs, warmup
from achse.cli.plc import format, lsp, mcp, plc, symbols
from achse.cli.programs import channel, gcode
from achse.cli.record import monitor, replay, scope
from achse.cli.root import in_panels, new_root
from achse.cli.start import demo, detached, fleet, fmu, new, run, web
from achse.cli.test import check, explain, fault, mutate, swarm, sweep, unit_tests

app = new_root()

new.register(app)
run.register(app)
demo.register(app)
detached.register(app)
docs.register(app)
check.register(app)
explain.register(app)
unit_tests.register(app)
mutate.register(app)
app.add_typer(ads.ads, name="ads")
router.register(app)
app.add_typer(axis.axis, name="axis")
app.add_typer(drive.drive, name="drive")
app.add_typer(fault.fault, name="fault")
app.add_typer(fleet.fleet, name="fleet")
app.add_typer(table.table, name="table")
app.add_typer(plc.plc, name="plc")
gcode.register(app)
app.add_typer(scope.scope, name="scope")
app.add_typer(camshaft.camshaft, name="camshaft")
app.add_typer(bus.bus, name="bus")
app.add_typer(channel.channel, name="channel")
certificate.register(app)
excite.register(axis.axis)
parameters.register(axis.axis)
gear.register(axis.axis)
stats.register(ads.ads)
monitor.register(app)
scan.register(ads.ads)
route.register(app, ads.ads)
symbols.register(app)
lsp.register(app)
format.register(app)
mcp.register(app)
replay.register(app)
sweep.register(app)
fmu.register(app)
swarm.register(app)
warmup.register(app)
web.register(app)
in_panels(app)
