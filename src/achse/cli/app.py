"""The command tree. Commands import what they need when they run, so that `--help` stays quick."""

import typer

from achse.cli import (
    ads,
    axis,
    check,
    docs,
    drive,
    excite,
    fault,
    monitor,
    parameters,
    record,
    route,
    run,
    scan,
    stats,
    symbols,
    warmup,
)

__all__ = ["app"]

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="A motion station: PLC and NC devices with moving axes behind an ADS/AMS router.",
)

run.register(app)
docs.register(app)
check.register(app)
app.add_typer(ads.ads, name="ads")
app.add_typer(axis.axis, name="axis")
app.add_typer(drive.drive, name="drive")
app.add_typer(fault.fault, name="fault")
excite.register(axis.axis)
parameters.register(axis.axis)
stats.register(ads.ads)
monitor.register(app)
scan.register(ads.ads)
route.register(app, ads.ads)
app.add_typer(symbols.symbols, name="symbols")
record.register(app)
warmup.register(app)
