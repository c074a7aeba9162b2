"""ROS domains of this machine that nothing else uses: for the demo, the tests and benchmarks."""

import itertools
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

# RTPS (OMG, DDSI-RTPS 2.2, 9.6.1.1): the ports of domain d are 7400 + 250 d and those that follow.
_FIRST_PORT, _PORTS = 7400, 250
_LARGEST = 232  # above, ports end


class Domain:
    """A ROS domain for one user: no other claims it, and no participant is in it.

    The claim lasts until `close`, the end of a `with` block, or the end of this process, however
    that ends. Programs that do not claim are noticed by their ports when the domain is chosen.
    Raises RuntimeError where every domain is in use.
    """

    def __init__(self) -> None:
        for number in itertools.islice(_turns, len(_usable)):
            claim = socket.socket(socket.AF_UNIX)
            try:
                claim.bind(f'\0ros_domain_{number}')  # abstract: it goes with the process
            except OSError:
                claim.close()
                continue
            if not _ports_of(number) & _bound_ports():
                self.number, self._claim = number, claim
                return
            claim.close()
        raise RuntimeError(f'all of {len(_usable)} ROS domains are in use: end some ROS programs')

    def close(self) -> None:
        """Leave the domain to others."""
        self._claim.close()

    def __enter__(self) -> int:
        return self.number

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def usable_domains(ephemeral: range) -> list[int]:
    """Return the domains, but for 0, whose ports the system never gives to other programs."""
    return [
        number
        for number in range(1, _LARGEST + 1)
        if all(port not in ephemeral for port in (min(_ports_of(number)), max(_ports_of(number))))
    ]


def _ports_of(number: int) -> set[int]:
    first = _FIRST_PORT + _PORTS * number
    return set(range(first, min(first + _PORTS, 2**16)))


def _bound_ports() -> set[int]:
    """Return the UDP ports in use. Looked up, not tried: to bind one would bar it from its user."""
    lines = [
        line
        for table in ('/proc/net/udp', '/proc/net/udp6')
        if Path(table).exists()
        for line in Path(table).read_text().splitlines()[1:]
    ]
    return {int(line.split()[1].rpartition(':')[2], 16) for line in lines}


def _ephemeral_ports() -> range:
    first, last = Path('/proc/sys/net/ipv4/ip_local_port_range').read_text().split()
    return range(int(first), int(last) + 1)


_usable = usable_domains(_ephemeral_ports())
# Each process begins elsewhere, and goes on to the next: what has just ended may still be leaving.
_turns: Iterator[int] = itertools.cycle(
    _usable[(start := os.getpid() % len(_usable)) :] + _usable[:start]
)
