"""Connections break off, are refused, or close each other."""

from achse.station import Station

NAME = b"MAIN.nCounter\0"


async def test_links_refused_from_the_start_and_twice_are_taken_again_in_the_end() -> None:
    station = Station.demo()
    station.faults.add("refuse_links", lasting=1.0)
    station.faults.add("one_connection")
    async with station.running("127.0.0.1", 0, speed=0) as running:
        limits = []
        for _ in range(3):
            limits.append((running.listener.accepting, running.listener.strict))
            station.advance(0.6)
            station.faults.add("refuse_links", lasting=0.3)
        assert limits == [(False, True)] * 3
        station.advance(0.4)
        station.faults.clear()
        assert (running.listener.accepting, running.listener.strict) == (True, False)
