"""Router memory by the manual's rule."""

from achse.router.memory import notification_packet, router_memory_kb


def test_the_worked_example_of_the_manual() -> None:
    """10 controllers with 20 notifications of 2 kB each need 1100 kB (000 §6.4)."""
    assert router_memory_kb([2048] * 10 * 20) == 1100


def test_a_notification_counts_at_least_one_kb() -> None:
    assert router_memory_kb([]) == 700
    assert router_memory_kb([1, 40, 1024]) == 703
    assert router_memory_kb([1025]) == 702


def test_a_packet_is_its_sample_with_all_headers() -> None:
    assert notification_packet(0) == 6 + 32 + 4 + 4 + 8 + 4 + 4 + 4
