"""Tests mirror the package: each module has its test file, each test file its module."""

from pathlib import Path

TABLES = {
    Path("src/achse/codes/nc/error_texts"),
    Path("src/achse/codes/nc/rows"),
    Path("src/achse/motion/fields"),
}
"""Folders of declarations; the test of the module that puts them together walks them all."""

OF_THE_PROJECT = {"house", "docs", "interop", "benchmarks", "fuzz", "libraries", "replay", "rules"}
"""Rooms of tests/ whose subject is the project as a whole, not one module."""

NEED_NO_TEST_FILE: dict[str, str] = {
    "__init__.py": "names only",
    "__main__.py": "one call; the interop tests start the station through it",
}
"""File names of modules without logic of their own, and why."""

WITHOUT_MODULE: dict[str, str] = {
    "tests/camshaft/test_random_cams.py": "kernel, controller and parameters against closed forms",
    "tests/client/nc/test_random_calls.py": "every method of an axis, at random",
    "tests/devices/nc/test_coupling_rings.py": "any couplings of four axes over ADS: no rings",
    "tests/devices/nc/test_coupling_rows.py": "every row of couplings: access, lengths, values",
    "tests/devices/nc/axes/test_effects.py": "every parameter row and what it does to an axis",
    "tests/devices/nc/test_every_row.py": "every row of the NC, asked at random",
    "tests/devices/nc/tables/test_every_table_row.py": "every row, on a table of every kind",
    "tests/devices/nc/test_random_programs.py": "channels, groups, axes and programs, at random",
    "tests/devices/plc/test_symbol_pointers.py": "symbols, memory and types of a PLC together",
    "tests/drive/modes/test_mode_bits.py": "every bit of controlword and statusword in each mode",
    "tests/motion/channels/test_homing_programs.py": "interpreter, feeder, group and axis in G74",
    "tests/motion/channels/test_random_channels.py": "all that clients do to a channel, at random",
    "tests/motion/channels/test_single_blocks.py": "single blocks of channel and group together",
    "tests/native/kernels/test_records_as_values.py": "records of all forms, plain and compiled",
    "tests/motion/couplings/test_cam_bounds.py": "each bound at which a cam changes",
    "tests/motion/couplings/test_cams_drawn.py": "cams, tables, commands and the kernel, at random",
    "tests/motion/couplings/test_every_law.py": "all laws, chains and the kernel, at random",
    "tests/motion/couplings/test_renamed_positions.py": "commands of positions against laws",
    "tests/motion/couplings/test_life.py": "masters, laws, superposition and errors together",
    "tests/motion/couplings/test_refused.py": "every coupling and its refusals, at random",
    "tests/motion/tables/test_edited_tables.py": "tables, slaves and the cycle, at an edit",
    "tests/motion/test_fast_path.py": "which axes take the fast path of a cycle, and which rest",
    "tests/motion/test_supervision_bounds.py": "each bound of what supervises an axis",
    "tests/motion/groups/test_singular_places.py": "group, laws and axes at singular places",
    "tests/motion/path/test_path_oracle.py": "planner and TOPP-RA, path by path",
    "tests/motion/path/test_random_paths.py": "all of a path at random: contour, limits, commands",
    "tests/motion/test_profile_oracle.py": "planner and ruckig, case by case",
    "tests/motion/test_wrong_parameters.py": "NC and machine, which are set up alike or not",
    "tests/st/test_edition.py": "features of the standard, over all rooms",
    "tests/plc/code/test_random_names.py": "any names in programs, in both forms of code",
    "tests/plc/coverage/test_drawn_programs.py": "lowering and both forms of code, at random",
    "tests/plc/machine/test_random_recursion.py": "recursion of any shape on stacks of any size",
    "tests/router/forwarding/test_floods.py": "table, shares and releases under floods, at random",
    "tests/st/graphical/exports/test_random_exports.py": "readers of exports, at random",
    "tests/st/graphical/test_random_networks.py": "reader, lowering and a run, at random",
    "tests/station/buses/test_catching_up.py": "bus, master and link while a station catches up",
    "tests/station/test_departed_clients.py": "station and peers after clients of all kinds",
    "tests/swarm/test_planted.py": "faults of all rooms, which the swarm finds",
    "tests/transport/secure/test_admission.py": "listener, routes, users and proofs in tables",
    "tests/transport/serial/test_faults.py": "both ends of a serial line that does harm",
    "tests/web/pages/test_modules.py": "the JavaScript of the pages, by node",
    "tests/motion/test_random_commands.py": "all commands and the kernel, at random",
    "tests/motion/test_random_dynamics.py": "what all commands and faults may make of a velocity",
    "tests/motion/test_random_enables.py": "enables against every motion, in both kernels",
}
"""Test files about several modules together, and why they stand apart."""


def test_each_module_has_its_test_file(modules: list[Path], tracked: list[Path]) -> None:
    expected = {
        Path("tests", *module.parts[2:-1], f"test_{module.name}")
        for module in modules
        if module.name not in NEED_NO_TEST_FILE and module.parent not in TABLES
    }
    missing = sorted(map(str, expected.difference(tracked)))
    assert not missing, "modules without test file: " + ", ".join(missing)


def test_each_test_file_has_its_module(modules: list[Path], tracked: list[Path]) -> None:
    orphans = [
        str(path)
        for path in tracked
        if path.parts[0] == "tests"
        and path.name.startswith("test_")
        and path.parts[1] not in OF_THE_PROJECT
        and str(path) not in WITHOUT_MODULE
        and Path("src", "achse", *path.parts[1:-1], path.name.removeprefix("test_")) not in modules
    ]
    assert not orphans, "test files without module: " + ", ".join(orphans)


def test_the_exceptions_are_needed(tracked: list[Path]) -> None:
    assert [name for name in WITHOUT_MODULE if Path(name) not in tracked] == []
