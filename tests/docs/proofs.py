"""What proves the sentences of docs/explanation/security.md: functions here, tests elsewhere."""

from collections.abc import Callable
from typing import Any

__all__ = ["PROOFS", "proves"]

PROOFS: dict[str, list[str]] = {}
"""Sentence: tests, `path::name` or functions of this module."""


def proves(sentence: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The test proves the sentence."""

    def note(test: Callable[..., Any]) -> Callable[..., Any]:
        PROOFS.setdefault(sentence, []).append(test.__name__)
        return test

    return note


def elsewhere(sentence: str, *tests: str) -> None:
    """These tests, `path::name`, prove the sentence."""
    PROOFS.setdefault(sentence, []).extend(tests)


# what tests elsewhere prove

NETWORK = "tests/station/routes/test_network.py"
FORWARDING = "tests/router/forwarding/test_forwarding.py"
FOLDER = "tests/devices/system/test_folder.py"
TCP = "tests/transport/tcp/test_listener.py"
OPENSSL = "tests/interop/test_openssl.py"
SECURED = "tests/station/configuration/test_secure.py"
SECURE = "tests/transport/secure/test_listener.py"
MQTT = "tests/transport/mqtt/test_routes.py"
UDP = "tests/transport/test_udp.py"
QUEUE = "tests/transport/secure/test_password_queue.py"
HOSTILE = "tests/interop/test_hostile_load.py"
STATE = "tests/station/persistence/test_state_file.py"
NESTING = "tests/fuzz/test_nesting.py"

elsewhere(
    "It asks no Modbus device of another computer that `[modbus]` does not name.",
    "tests/devices/modbus/test_device.py::test_only_devices_that_are_named_are_queried",
    "tests/station/configuration/test_modbus.py::test_without_lines_this_computer_alone",
    "tests/station/building/test_modbus.py::test_without_it_no_device_is_there",
)
elsewhere(
    "The native code of units that `[[fmu]]` names has these rights too, and runs in processes of"
    " its own: one that crashes, ends or hangs takes no station with it.",
    "tests/station/plants/test_process.py::test_failures_have_their_reason",
    "tests/station/plants/test_process.py::test_unit_that_hangs_is_ended",
    "tests/station/plants/test_axis_port.py::test_failed_unit_is_an_error_of_its_axis",
)
elsewhere(
    "Archives of units with names that lead out, links, document types or too many bytes are"
    " refused before any of it runs.",
    "tests/station/plants/test_archive.py::test_names_that_lead_out_are_refused",
    "tests/station/plants/test_archive.py::test_links_and_devices_are_refused",
    "tests/station/plants/test_archive.py::test_size_is_bounded",
    "tests/station/plants/test_description.py::test_document_types_are_refused",
)
elsewhere(
    "A PLC program reaches the memory of its own PLC, and a pointer elsewhere is an error.",
    "tests/plc/code/test_storages.py::test_a_wild_pointer_is_an_access_violation",
    "tests/plc/routines/test_builtins.py"
    "::test_a_copy_beyond_memory_is_an_access_violation_and_copies_nothing",
)
elsewhere(
    "A PLC program opens files below `root` alone.",
    "tests/libraries/test_tc2_system.py::test_files_from_the_first_byte_to_the_last",
    "tests/libraries/test_tc2_system.py::test_no_file_outside_of_the_root_is_opened",
)
elsewhere(
    "By Secure ADS values and passwords are encrypted.",
    f"{OPENSSL}::test_first_contact_then_known_by_fingerprint",
    f"{OPENSSL}::test_tls_below_1_2_gets_no_answer",
)
elsewhere(
    "By Secure ADS nobody gets in without a known certificate, one of the authority, or a"
    " pre-shared key.",
    f"{OPENSSL}::test_refusals",
    f"{OPENSSL}::test_a_certificate_of_another_authority",
    f"{SECURED}::test_pre_shared_keys",
)
elsewhere(
    "A client that came by Secure ADS speaks for its own NetId only, and never for the station's.",
    f"{SECURE}::test_no_client_speaks_for_this_router_or_for_others",
)
elsewhere(
    "The other side of a route by Secure ADS does not get in by plain AMS/TCP where routes are"
    " needed.",
    "tests/router/test_routes.py::test_a_secure_route_admits_no_client_by_plain_tcp",
)
elsewhere(
    "By MQTT nobody has the rights of a route by Secure ADS.",
    f"{MQTT}::test_the_rights_of_a_secure_route_are_not_had_by_a_broker",
)
elsewhere(
    "By MQTT nobody speaks for the station.",
    f"{MQTT}::test_no_router_in_the_network_speaks_for_this_router",
)
elsewhere(
    "A certificate of the authority or a pre-shared key does not take a NetId whose route has the"
    " fingerprint of another, or leads to another host.",
    f"{SECURE}::test_a_certificate_of_the_authority_does_not_take_the_route_of_another",
    f"{SECURE}::test_a_certificate_of_the_authority_has_the_rights_of_its_own_route_alone",
    f"{SECURE}::test_a_key_has_the_rights_of_its_own_route_alone",
)
elsewhere(
    "Connections by Secure ADS end when their route is removed, or when its rights change.",
    f"{SECURE}::test_who_came_by_a_route_that_is_gone_goes",
)
elsewhere(
    "A password does not lead in by a route of the configuration with another fingerprint.",
    f"{SECURE}::test_a_password_does_not_lead_in_by_a_fixed_route_of_another",
)
elsewhere(
    "Who changes routes over ADS, or sends sums of writes to port 10000, needs all rights.",
    "tests/router/test_rights.py::test_what_a_request_needs",
)
elsewhere(
    "Starting a program needs all rights, and `programs` in `[system]` has to name it.",
    "tests/router/test_rights.py::test_what_a_request_needs",
    "tests/devices/system/test_processes.py::test_only_paths_of_a_pattern_start",
)
elsewhere(
    "Keys and values of the registry services are in memory, and never those of the computer.",
    "tests/devices/system/test_registry.py::test_registry_holds_what_was_written_and_not_deleted",
)
elsewhere(
    'With `listen = "secure"` nothing listens for plain AMS/TCP.',
    f"{SECURED}::test_secure_only_closes_plain_tcp_and_both_answers_searches",
)
elsewhere(
    "A first contact is checked as slowly as a UDP request with a password.",
    f"{SECURE}::test_wrong_passwords_slow_a_host_down",
)
elsewhere(
    "Clients that have not shown who they are have ten seconds, and are 32 of a host at most.",
    f"{SECURE}::test_half_handshakes_do_not_keep_others_out",
    "tests/transport/secure/test_channel.py::test_a_server_that_says_nothing_is_waited_for_in_vain",
)
elsewhere(
    "Only its owner may read the key that a station made.",
    "tests/transport/secure/test_own_certificate.py::test_only_its_owner_reads_the_key",
)
elsewhere(
    "At an address that other computers reach it does not start without `strict = true` or"
    " `let_everybody_in = true` in `[router]`.",
    f"{NETWORK}::test_beyond_this_computer_a_station_listens_only_with_an_explicit_key",
    "tests/station/routes/test_addresses.py::test_which_addresses_other_computers_reach",
)
elsewhere(
    "With `let_everybody_in` it says at the start what everybody may do.",
    f"{NETWORK}::test_a_station_reports_the_rights_of_every_client",
    "tests/cli/start/test_run.py::test_beyond_this_computer_it_listens_only_with_an_explicit_option",
)
elsewhere(
    "Only programs on this computer get AMS ports of their own.",
    f"{TCP}::test_peers_on_other_hosts_get_no_port_service_unless_let_in",
    "tests/transport/test_own_address.py::test_loopback_addresses",
)
elsewhere(
    "Nobody changes its routes from outside.",
    f"{NETWORK}::test_who_may_change_routes",
    f"{NETWORK}::test_only_users_change_routes",
)
elsewhere(
    "It shows no files without `root` in `[system]`.",
    "tests/devices/system/test_files.py::test_without_a_folder_files_are_not_supported",
)
elsewhere(
    "Anyone who gets in may record the traffic of others, and cause faults, by port 26000.",
    "tests/devices/test_station.py::test_a_tap_shows_what_others_do",
    "tests/interop/test_faults.py::test_a_lost_answer_is_a_timeout",
)
elsewhere(
    "A client from another computer needs a route, to its NetId and with the address it comes"
    " from.",
    f"{NETWORK}::test_strict_closes_clients_without_a_route",
    f"{NETWORK}::test_who_may_change_routes",
    "tests/router/test_routes.py::test_senders_are_admitted_by_net_id_and_address",
    "tests/transport/uplinks/test_uplinks.py"
    "::test_where_routes_are_required_a_stranger_learns_how_to_get_one",
)
elsewhere(
    "A route by host name lets in who comes from an address of that name, looked up again every"
    " minute.",
    f"{NETWORK}::test_strict_lets_in_by_a_host_name_only_who_is_there",
    "tests/router/test_routes.py::test_by_a_host_name_only_its_addresses_are_admitted",
    "tests/transport/uplinks/test_host_names.py::test_names_are_looked_up_again_every_minute",
)
elsewhere(
    "By a name that nobody knows, nobody gets in.",
    f"{NETWORK}::test_strict_lets_in_by_a_host_name_only_who_is_there",
    "tests/transport/uplinks/test_host_names.py::test_an_unknown_name_is_reported_and_admits_no_client",
)
elsewhere(
    "A computer has one connection, and a second one closes the first.",
    f"{TCP}::test_strict_a_second_connection_of_a_host_closes_one_without_port",
)
elsewhere(
    "From the far end of a one-way route requests are refused, in a station without `strict` too.",
    "tests/transport/uplinks/test_uplinks.py::test_requests_from_the_far_end_of_a_one_way_route_are_refused",
    "tests/transport/uplinks/test_dialled.py::test_behind_a_one_way_route_no_client_is_admitted_under_any_name",
    "tests/router/test_routes.py::test_a_one_way_route_refuses_also_before_its_host_is_known",
)
elsewhere(
    "A user in `[router.users]` changes routes by UDP requests with name and password.",
    f"{NETWORK}::test_only_users_change_routes",
    f"{UDP}::test_the_right_password_adds_and_deletes_a_route",
    "tests/interop/test_discovery.py::test_pyads_learns_the_net_id_and_adds_a_route",
)
elsewhere(
    "A user changes nothing but routes.",
    f"{UDP}::test_other_services_are_not_supported_and_answers_not_answered",
    f"{NETWORK}::test_who_may_change_routes",
)
elsewhere(
    "Only scrypt hashes of passwords are kept.",
    "tests/router/test_access.py::test_a_hash_survives_its_text_and_does_not_show_the_password",
    "tests/router/test_access.py::test_the_hash_is_scrypt_as_rfc_7914_has_it",
    "tests/router/test_access.py::test_what_is_no_hash_is_refused",
)
elsewhere(
    "After three wrong passwords a computer waits a second for the next check, then twice as long"
    " each time, up to a minute.",
    f"{QUEUE}::test_wrong_passwords_slow_a_host_down",
)
elsewhere(
    "Computers that have not known a password get five checks a second together.",
    f"{QUEUE}::test_all_strangers_together_get_five_checks_a_second",
)
elsewhere(
    "A flood of requests from one computer does not crowd out another.",
    f"{UDP}::test_a_flood_from_one_host_does_not_crowd_out_another",
    f"{HOSTILE}::test_datagrams",
)
elsewhere(
    "A newcomer's password is one of the next two to be checked, however many computers that guess"
    " were there before.",
    f"{QUEUE}::test_a_newcomer_is_checked_within_two_turns_whatever_crowd_of_guessers_waits",
)
elsewhere(
    "A password that was wrong once is not checked again, and does not count as a guess.",
    "tests/transport/secure/test_password_checker.py::test_a_password_that_was_wrong_is_not_checked_again",
)
elsewhere(
    "Routes of the configuration are neither replaced nor removed, by nobody.",
    f"{NETWORK}::test_a_route_of_the_configuration_stays",
    f"{NETWORK}::test_who_may_change_routes",
    "tests/router/test_routes.py::test_a_fixed_route_stays",
    f"{HOSTILE}::test_routes",
)
elsewhere(
    "Over ADS routes change with `routes_over_ads = true` only, and then everybody who gets in may"
    " change them.",
    f"{NETWORK}::test_who_may_change_routes",
    "tests/devices/system/test_routes.py::test_without_permission_routes_cannot_be_changed",
)
elsewhere(
    "A change that cannot be written to `static_routes` is refused.",
    "tests/station/routes/test_route_file.py"
    "::test_a_route_is_refused_if_the_file_cannot_be_written",
    f"{UDP}::test_a_fixed_route_and_one_that_cannot_be_written_are_refused",
)
elsewhere(
    "No name of a file leads out of `root`: no `..`, no absolute path, no drive, no device, no"
    " link.",
    f"{FOLDER}::test_what_leads_out_names_nothing",
    f"{FOLDER}::test_nor_does_a_search_or_another_place",
    f"{FOLDER}::test_any_bytes_stay_inside_or_are_refused",
    "tests/devices/system/test_files.py::test_any_request_stays_inside_and_is_answered",
)
elsewhere(
    "A station does not start with a `root` that shows its configuration, `static_routes` or"
    " `persistent_data` to clients.",
    "tests/station/building/test_assembly.py::test_clients_are_not_shown_what_the_station_reads_itself",
)
elsewhere(
    "Machine code is not loaded from a cache that others own or may write to.",
    "tests/native/backend/test_cache.py::test_a_folder_that_others_may_write_to_is_not_used",
    "tests/native/backend/test_cache.py::test_a_file_that_others_may_write_to_is_not_loaded",
    "tests/native/backend/test_cache.py::test_a_file_of_another_user_is_not_loaded",
)
elsewhere(
    "What a station writes is whole on the disk, the old or the new, when it is killed or the power"
    " fails.",
    f"{STATE}::test_killed_at_any_system_call_the_old_or_the_new_is_there",
    f"{STATE}::test_a_text_is_on_the_disk_before_its_name_and_the_name_before_the_answer",
)
elsewhere(
    "What a client holds has limits, for itself and for all together, in `[limits]`.",
    "tests/server/test_limits.py::test_notifications_per_client",
    "tests/server/test_limits.py::test_handles_of_one_client_and_of_all",
    "tests/server/test_limits.py::test_bytes_of_all_samples_of_all_clients",
    "tests/devices/test_station.py"
    "::test_taps_of_many_addresses_have_a_limit_together_and_harm_no_client",
)
elsewhere(
    "No client ends the value handles of another one that is connected.",
    "tests/server/test_symbols.py::test_handle_is_used_by_all_clients_and_released_by_its_own",
    "tests/server/test_handles.py"
    "::test_whatever_clients_do_their_own_handles_stay_and_the_oldest_abandoned_give_way",
)
elsewhere(
    "A client that does not read is cut off.",
    f"{TCP}::test_a_peer_that_does_not_read_is_cut_off",
    f"{TCP}::test_of_unfinished_packets_that_are_too_much_together_the_largest_goes",
)
elsewhere(
    "Bytes that are not AMS close the connection they come by, and no other.",
    f"{TCP}::test_garbage_closes_with_a_log_line_after_the_answers_before_it",
    f"{TCP}::test_an_exception_over_one_frame_is_reported_and_closes_nothing",
)
elsewhere(
    "Text that nests too deep is refused with an error, wherever a parser reads it.",
    *(
        f"{NESTING}::test_{parser}"
        for parser in (
            *("expressions", "statements", "declarations_and_comments", "names_of_types", "paths"),
            *("types_that_rest_on_each_other", "values", "station_toml", "state_files", "xml"),
            "faults_that_a_client_wants",
        )
    ),
)
elsewhere(
    "File services and host names are looked after beside the loop, so that a slow disk or network"
    " holds up nobody else.",
    "tests/devices/system/test_files.py::test_no_file_service_holds_the_loop",
    "tests/transport/uplinks/test_host_names.py::test_a_look_up_that_hangs_delays_no_other",
)
elsewhere(
    "During a restart nobody takes the ports of the configuration.",
    "tests/station/building/test_assembly.py::test_configured_ports_stay_the_stations_through_restarts",
)
elsewhere(
    "However often clients restart a station, it is in RUN as long as each restart took, a second"
    " at most.",
    *(
        f"tests/station/running/test_state_requests.py::test_{each}"
        for each in (
            "resets_faster_than_a_restart_do_not_keep_the_station_out_of_run",
            "whatever_is_requested_each_run_lasts_and_each_request_is_answered",
            "a_station_is_kept_in_run_for_a_second_at_most",
        )
    ),
)
elsewhere(
    "Where file descriptors run out connections wait until some are free, and the log says so"
    " once.",
    "tests/transport/tcp/test_acceptor.py"
    "::test_without_descriptors_the_log_has_one_line_and_connections_wait",
    "tests/transport/tcp/test_acceptor.py::test_while_accepting_fails_the_loop_does_not_spin",
)
elsewhere(
    "Beside an attack a good client is answered in time.",
    *(
        f"{HOSTILE}::test_{attack}"
        for attack in ("taps", "logging", "routes", "files", "loops_of_routes")
    ),
)
elsewhere(
    "Virtual drives give the processor back when a master asks without a pause.",
    "tests/station/clocks/test_priority.py"
    "::test_starvation_ends_the_priority_and_its_end_brings_it_back",
)
elsewhere(
    "The link opens an EtherCAT segment that DL control has closed.",
    "tests/station/slaves/test_serving.py::test_a_segment_closed_by_dl_control_opens_again_with_the_link",
    "tests/ethercat/test_segment.py::test_whatever_dl_control_does_the_link_opens_the_segment",
)
PEERS = "tests/router/test_rights.py"
elsewhere(
    "A route may be limited to `read`, `write`, `state`, `files` and `methods`, in any selection.",
    f"{NETWORK}::test_a_route_may_what_it_says",
)
elsewhere(
    "Rights of those without a route are `rights` in `[router]`, and everything without it.",
    f"{NETWORK}::test_those_without_a_route_may_what_the_router_says",
    f"{NETWORK}::test_rights_in_a_configuration",
)
elsewhere(
    "A route that a user adds may what `user_rights` says of that user.",
    f"{NETWORK}::test_a_route_that_a_user_adds_may_what_the_user_may",
)
elsewhere(
    "A request without its right is answered with 0x723, counted, and told once by the log.",
    f"{NETWORK}::test_a_route_may_what_it_says",
)
ROWS = "tests/fuzz/test_rights.py"
elsewhere(
    "Who records traffic, causes faults, debugs or changes programs at port 26000 needs"
    " all rights.",
    f"{PEERS}::test_what_a_request_needs",
    f"{ROWS}::test_every_row_once_with_one_right_too_few",
    f"{ROWS}::test_who_writes_changes_no_states_routes_or_files",
)
elsewhere(
    "File services need `files`, those of the older form too.",
    f"{ROWS}::test_every_row_once_with_one_right_too_few",
    f"{ROWS}::test_who_writes_changes_no_states_routes_or_files",
)
elsewhere(
    "Pages in the browser call and watch what `rights` in `[router]` allow, and see the traffic of"
    " others with all rights only.",
    "tests/web/test_calls.py::test_calls_that_change_something_need_more_than_reading",
    "tests/web/test_shared_subscriptions.py::test_a_topic_needs_what_the_station_allows",
)
elsewhere(
    "With `--web-edit` or `[web] edit` they read the sources of the PLCs, and save them with all"
    " rights: files that the project lists, and no other.",
    "tests/web/test_sources.py::test_what_is_refused",
    "tests/web/test_sources.py::test_pages_that_may_only_look_do_not_write",
)
elsewhere(
    "Strangers behind a route that the station dialled may no more than that route, and nothing"
    " with `strict`.",
    "tests/transport/uplinks/test_dialled.py::test_strangers_behind_it_may_no_more_than_the_route",
    "tests/transport/uplinks/test_dialled.py::test_a_strict_station_admits_no_client_without_a_route",
)
elsewhere(
    "A stranger behind a router that has a route is refused (0x723), and others behind it are"
    " served on.",
    f"{FORWARDING}::test_stranger_behind_a_router_does_not_end_its_connection_to_a_strict_target",
)
elsewhere(
    "The address of a port is used by its holder alone: from others requests are refused under it,"
    " and answers and samples are lost.",
    "tests/transport/connections/test_peer.py::test_address_of_a_port_is_used_by_its_holder_alone",
)
elsewhere(
    "A router forwards 4 MB of one client at a time, so that the requests of others are not kept"
    " waiting.",
    f"{FORWARDING}::test_client_with_few_requests_is_forwarded_beside_one_with_many",
)
elsewhere(
    "A router has 512 requests of a computer at a target, however many connections it opens.",
    "tests/router/forwarding/test_windows.py"
    "::test_request_never_waits_for_more_than_eight_windows_of_another_computer",
)
elsewhere(
    "A router lets a computer keep 65,536 subscriptions, symbol handles and open files at its"
    " targets.",
    f"{FORWARDING}::test_client_keeps_no_more_than_its_share_and_others_theirs",
)
elsewhere(
    "File requests wait in a bounded number, however many addresses send them.",
    "tests/devices/system/test_file_worker.py"
    "::test_requests_of_many_addresses_are_limited_together",
)
elsewhere(
    "However many addresses send over one connection, the subscriptions of others on it go on.",
    f"{FORWARDING}::test_samples_go_on_beside_more_senders_than_a_connection_remembers",
)
elsewhere(
    "Sums need the rights of their parts.",
    f"{PEERS}::test_what_a_request_needs",
    f"{ROWS}::test_rights_hold_for_every_row_by_every_transport",
)
elsewhere(
    "Reading alone is enough for a client that takes handles, subscribes and lists symbols.",
    f"{NETWORK}::test_reading_alone_is_enough_for_a_client_that_reads",
)
elsewhere(
    "A program on this computer with a port of the station's router may everything.",
    f"{NETWORK}::test_a_route_may_what_it_says",
)
