"""Tests of demo.domain: who claims a ROS domain has it to themselves."""

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from demo import domain
from demo.domain import Domain, usable_domains

# Nobody else claims 250 and 251, which have no ports.
CLAIM = """
from demo import domain
domain._usable = domain._turns = [250]
held = domain.Domain()
input(held.number)
"""


def only(monkeypatch: pytest.MonkeyPatch, *numbers: int) -> None:
    """Let there be no other domains."""
    monkeypatch.setattr(domain, '_usable', list(numbers))
    monkeypatch.setattr(domain, '_turns', iter(numbers * 9))


def test_two_claims_are_two_domains(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, 250, 251)
    with Domain() as one, Domain() as other:
        assert {one, other} == {250, 251}
        with pytest.raises(RuntimeError, match='all of 2 ROS domains are in use'):
            Domain()
    with Domain() as again:
        assert again in (250, 251)


def test_a_claim_lasts_as_long_as_its_process_however_that_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with subprocess.Popen(
        [sys.executable, '-c', CLAIM],
        cwd=Path(domain.__file__).parents[1],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        assert other.stdout is not None
        assert other.stdout.read(3) == '250'
        only(monkeypatch, 250)
        with pytest.raises(RuntimeError):
            Domain()
        other.kill()
        other.wait()
    with Domain() as mine:
        assert mine == 250


def test_a_participant_that_claims_nothing_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, 250, 251)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as participant:
        participant.bind(('127.0.0.1', 0))
        ports = {250: {participant.getsockname()[1]}, 251: set[int]()}
        monkeypatch.setattr(domain, '_ports_of', ports.__getitem__)
        for _ in range(3):
            with Domain() as number:
                assert number == 251


def test_domains_keep_out_of_the_ports_that_the_system_gives_away() -> None:
    found = usable_domains(range(32768, 61000))
    assert found == [*range(1, 101), *range(215, 233)]
    assert usable_domains(range(0)) == list(range(1, 233))
