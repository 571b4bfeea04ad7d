"""Requests that wait for the check of their password: each host in turn, slower after wrong ones.

UDP has no connections: any host may send anything as fast as the wire allows. So one request waits
for each host, a host that guesses waits longer each time, and hosts that knew the password go
first. Among the others, those with the fewest wrong passwords are next: in turns the one that waits
longest, and the one that came last. So a newcomer does not wait until a crowd has had its turns. If
all places are taken, the newcomer displaces the middle one of those with the most wrong passwords:
both ends of the queue keep their turns.
"""

import math
from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

_HOSTS = 256
"""Hosts that may wait at a time."""

_REMEMBERED = 4096
"""Hosts whose wrong passwords are remembered; the oldest are forgotten."""

_FREE = 3
"""Wrong passwords of a host until it has to wait: people mistype."""

_FIRST_PAUSE, _LONGEST_PAUSE = 1.0, 60.0
"""Seconds after a further one, doubled each time."""

_FORGIVEN = 600.0
"""Seconds without a wrong password after which a host starts afresh."""

_PACE = 0.2
"""Seconds between the checks of hosts that have not known a password yet, all together."""


class _Host:
    """Record of a host: its wrong passwords and its waiting time."""

    __slots__ = ("last_wrong", "not_before", "right", "wrong")

    def __init__(self) -> None:
        self.right = False
        self.wrong = 0
        self.last_wrong = -math.inf
        self.not_before = -math.inf


class PasswordQueue(Generic[T]):
    """The requests and their hosts; `now()` is in seconds and never goes back."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._waiting: OrderedDict[str, T] = OrderedDict()
        self._hosts: OrderedDict[str, _Host] = OrderedDict()
        self._next_stranger = -math.inf
        self._newest_next = False
        """True if the next turn of strangers is that of the newest."""

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, host: str, request: T) -> bool:
        """Let a request wait; it replaces one of the same host.

        False if there is no room: all that wait have fewer wrong passwords.
        """
        if host not in self._waiting and len(self._waiting) >= _HOSTS:
            most = max(map(self._rank, self._waiting))
            if most < self._rank(host):
                return False
            worst = [each for each in self._waiting if self._rank(each) == most]
            del self._waiting[worst[len(worst) // 2]]
        self._waiting[host] = request
        return True

    def _rank(self, host: str) -> float:
        """Return the distrust of a host: -1 after a right password, else its number of wrong
        ones."""
        known = self._hosts.get(host)
        return 0 if known is None else -1 if known.right else known.wrong

    def _due(self, host: str) -> float:
        known = self._hosts.get(host)
        if known is None:
            return self._next_stranger
        return known.not_before if known.right else max(known.not_before, self._next_stranger)

    def pause(self) -> float:
        """Seconds until `take` gives a request; 0 if it does now, infinite if none waits."""
        return max(min(map(self._due, self._waiting), default=math.inf) - self._now(), 0.0)

    def take(self) -> tuple[str, T] | None:
        """Host and request to check now, None if none is due: hosts that knew a password come
        first."""
        now = self._now()
        due = [host for host in self._waiting if self._due(host) <= now]
        if not due:
            return None
        best = min(map(self._rank, due))
        equals = [host for host in due if self._rank(host) == best]
        host = equals[0]
        if best >= 0:
            self._next_stranger = now + _PACE
            if self._newest_next:
                host = equals[-1]
            self._newest_next = not self._newest_next
        return host, self._waiting.pop(host)

    def remove(self, matches: Callable[[T], bool]) -> list[tuple[str, T]]:
        """Take out the requests that match, with their hosts; this is not a check."""
        matching = [(host, each) for host, each in self._waiting.items() if matches(each)]
        for host, _ in matching:
            del self._waiting[host]
        return matching

    def checked(self, host: str, *, right: bool) -> None:
        """Note the result of a check."""
        known = self._hosts.setdefault(host, _Host())
        self._hosts.move_to_end(host)
        now = self._now()
        if right:
            known.right, known.wrong, known.not_before = True, 0, -math.inf
        else:
            if now - known.last_wrong > _FORGIVEN:
                known.wrong = 0
            known.wrong += 1
            known.last_wrong = now
            if known.wrong >= _FREE:
                pause = min(_FIRST_PAUSE * 2.0 ** min(known.wrong - _FREE, 16), _LONGEST_PAUSE)
                known.not_before = now + pause
                known.right = False
        while len(self._hosts) > _REMEMBERED:
            self._hosts.popitem(last=False)
