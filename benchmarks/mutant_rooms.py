"""Rooms of mutants: what guards people and data, and the tests that guard it."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

__all__ = ["ROOMS", "Room"]


class Room(NamedTuple):
    """Sources and tests that belong together."""

    guards: str
    sources: Mapping[str, Sequence[str]]
    """Modules below src/achse, each with the functions that count; empty: all."""
    tests: Sequence[str]
    """Files and folders below tests/."""
    without: Sequence[str] = ()
    """Functions that guard nothing."""
    kind: str = ""
    """The kind of faults that are planted, if it is only one."""
    change: str = ""
    """What the text of a fault has, if not all are planted."""


_FEATURE_TESTS = (
    "motion/test_features.py",
    "motion/test_fast_path.py",
    "motion/test_kernel.py",
    "motion/control/test_drive.py",
)

ROOMS: Mapping[str, Room] = {
    "limits": Room(
        "limits, stops, ramps, enables and errors of axes",
        {
            "motion/setpoints/limits.py": (),
            "motion/monitoring.py": (
                "report",
                "_watch_signals",
                "supervise_enable",
                "_supervise_following_error",
                "_not_found",
                "_at_limit",
                "_supervise_limits",
                "supervise_motion",
                "watch_standstill",
                "supervise_arrival",
            ),
            "motion/commands/stops.py": (),
            "motion/profiles/ramps.py": (),
            "motion/checks.py": (),
            "motion/setpoints/setpoint.py": ("fail", "stop_fast", "drop_job", "arrived"),
        },
        (
            "motion/setpoints/test_limits.py",
            "motion/test_supervision_bounds.py",
            "motion/test_monitoring.py",
            "motion/commands/test_stops.py",
            "motion/profiles/test_ramps.py",
            "motion/test_checks.py",
            "motion/setpoints/test_setpoint.py",
            "motion/setpoints/test_targets.py",
            "motion/control/test_signals.py",
            "motion/control/test_controller.py",
            "motion/control/test_drive.py",
            "motion/generators/test_homing.py",
            "motion/commands/test_starts.py",
        ),
    ),
    "fast_path": Room(
        "the condition for the fast path of a cycle, and its stages",
        {
            "motion/features.py": (),
            "motion/kernel.py": (
                "_by_parameters",
                "_asleep",
                "_hand_over",
                "_adapt",
                "_measure_fast",
                "_watch",
                "_supervise_enable_fast",
                "_shift_phase",
                "_generate",
                "_generate_fast",
                "_couple",
                "_couple_fast",
                "_control",
                "_control_fast",
                "_supervise",
                "_put_out",
                "_show_state",
                "_show_state_fast",
                "_arm",
                "cycle",
            ),
            "motion/monitoring.py": ("stays_closed", "_supervise_rare", "_count_delay", "settle"),
            "motion/control/signals.py": ("arm_in_force",),
        },
        (
            *_FEATURE_TESTS,
            "motion/test_monitoring.py",
            "motion/control/test_signals.py",
            "motion/control/test_discrete.py",
            "motion/setpoints/test_phasing.py",
            "motion/control/test_encoder.py",
            "motion/commands/special_generators/test_external.py",
            "motion/commands/test_probes.py",
            "motion/generators/test_external.py",
            "motion/generators/test_homing.py",
            "motion/couplings/test_linear.py",
        ),
    ),
    "feature_bits": Room(
        "bits of features: where they are set and cleared",
        {
            "motion/axis.py": (),
            "motion/control/controller.py": (),
            "motion/control/drive.py": (),
            "motion/elements.py": (),
            "motion/kernel.py": (),
            "motion/monitoring.py": (),
            "motion/parts.py": (),
            "motion/setpoints/phasing.py": (),
            "motion/setpoints/setpoint.py": (),
            "motion/control/signals.py": (),
        },
        (
            *_FEATURE_TESTS,
            "motion/setpoints/test_setpoint.py",
            "motion/test_supervision_bounds.py",
            "motion/test_monitoring.py",
            "motion/test_parts.py",
            "motion/commands/test_loops.py",
        ),
        kind="skipped bit",
        change="eature",
    ),
    "cams": Room(
        "exchange of cams and their tables",
        {
            "motion/couplings/cams.py": (),
            "motion/commands/slaves/cams.py": (),
            "motion/tables/checking.py": (),
            "motion/tables/limits.py": (),
            "motion/tables/memory.py": (),
            "motion/tables/store.py": (),
            "motion/tables/users.py": (),
        },
        (
            "motion/couplings/test_cam_bounds.py",
            "motion/couplings/test_cam_checks.py",
            "motion/couplings/test_cams.py",
            "motion/couplings/test_cams_drawn.py",
            "motion/couplings/test_refused.py",
            "motion/commands/slaves/test_cams.py",
            "motion/tables",
        ),
    ),
    "rights": Room(
        "rights of users and routes in the router",
        {
            "router/rights.py": (),
            "router/access.py": (),
            "router/static_routes.py": (),
            "router/routes.py": (),
            "router/rate.py": (),
            "router/clients.py": (),
            "transport/connections/sender_rights.py": (),
        },
        (
            "router",
            "transport/connections/test_sender_rights.py",
            "devices/system/test_routes.py",
        ),
    ),
    "access": Room(
        "access by certificates, passwords, keys and tokens",
        {
            "transport/secure/tls.py": (),
            "transport/secure/listener.py": (),
            "transport/secure/handshakes.py": (),
            "transport/secure/password_queue.py": (),
            "transport/secure/password_checker.py": (),
            "transport/secure/own_certificate.py": (),
            "web/access_guard.py": (),
        },
        (
            "transport/secure/test_tls.py",
            "transport/secure/test_channel.py",
            "transport/secure/test_listener.py",
            "transport/secure/test_admission.py",
            "transport/secure/test_handshakes.py",
            "transport/secure/test_password_queue.py",
            "transport/secure/test_password_checker.py",
            "transport/secure/test_own_certificate.py",
            "web/test_access_guard.py",
            "web/test_app.py",
            "web/test_server.py",
        ),
        ("_error_text", "_first_reason"),
    ),
    "handles": Room(
        "handles, their owners and bounds",
        {
            "server/symbols.py": (),
            "server/table.py": (),
            "server/budget.py": (),
            "server/sums.py": (),
            "devices/plc/areas.py": (),
            "devices/plc/requests.py": (),
            "devices/plc/symbols.py": (),
        },
        ("server", "devices/plc"),
        (
            "AreaGroup.describe",
            "Group.describe",
            "ObjectGroup.describe",
            "RawGroup.describe",
            "_from",
        ),
    ),
    "persistence": Room(
        "data that outlive the program",
        {
            "plc/retention/retained_state.py": (),
            "motion/retained.py": (),
            "station/persistence/persistent_data.py": (),
            "station/persistence/state_file.py": (),
            "station/slaves/parameter_file.py": (),
            "transport/file_lock.py": (),
        },
        (
            "plc/retention/test_retained_state.py",
            "motion/test_retained.py",
            "station/persistence/test_persistent_data.py",
            "station/persistence/test_state_file.py",
            "station/slaves/test_parameter_file.py",
            "station/plcs/test_sources.py",
            "transport/test_file_lock.py",
        ),
        ("_error_text",),
    ),
    "counters": Room(
        "working counters of process data",
        {
            "ethercat/frame_plan.py": (),
            "ethercat/logical.py": (),
            "ethercat/fmmu.py": (),
            "ethercat/syncmanager.py": (),
            "ethercat/master/cyclic.py": (),
            "ethercat/master/process_image.py": (),
            "ethercat/master/steps.py": (),
        },
        (
            "ethercat/test_frame_plan.py",
            "ethercat/test_logical.py",
            "ethercat/test_fmmu.py",
            "ethercat/test_syncmanager.py",
            "ethercat/test_segment.py",
            "ethercat/master/test_cyclic.py",
            "ethercat/master/test_process_image.py",
            "ethercat/master/test_steps.py",
            "ethercat/master/test_master.py",
            "ethercat/master/test_supervision.py",
            "ethercat/master/test_redundancy.py",
        ),
    ),
}
