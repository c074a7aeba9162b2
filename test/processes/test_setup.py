"""Set-up that is cut short, or begun twice: with a Python that only pretends to install."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from patience import patience

ROOT = Path(__file__).resolve().parents[2]
SOURCES = (
    'Makefile', 'setup.py', 'setup.cfg', 'pyproject.toml', 'package.xml', 'resource', 'tools',
    'config', 'docs', 'layouts', 'obs_ros', 'plant_sim', 'requirements',
)  # fmt: skip
PATIENCE = patience(20.0)  # s
# Writes down what it is called for. A file `hang` in $NOTES holds the step in which it sits and
# waits, as noisy as Python when it is interrupted.
PYTHON = """#!/usr/bin/env bash
step=none
case "$*" in
  -) cat >/dev/null; echo ok; exit ;;
  '-S -c '*) echo 3.12; exit ;;
  *'-m venv'*) step=venv; rm -rf .venv; mkdir -p .venv/bin; cp "$0" .venv/bin/python ;;
  *requirements/runtime.txt) step=runtime; echo 'Collecting numpy' ;;
  *--no-index*) step=package; echo 'Installing collected packages: obs_ros' ;;
esac
echo "$step" >>"$NOTES/steps"
if [[ $(cat "$NOTES/hang" 2>/dev/null) == "$step" ]]; then
  exec REAL -c '
import os, signal, sys, time
if os.path.exists(os.environ["NOTES"] + "/deaf"):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
open(os.environ["NOTES"] + "/hangs", "w").close()
print("loud", file=sys.stderr, flush=True)
time.sleep(600)'
fi
""".replace('REAL', sys.executable)


@pytest.fixture
def project(tmp_path):
    """A copy of what set-up reads, and the environment that it is run with."""
    place, notes, python = tmp_path / 'a project', tmp_path / 'notes', tmp_path / 'python3'
    notes.mkdir()
    for name in SOURCES:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        place.mkdir(exist_ok=True)
        copy(ROOT / name, place / name)
    python.write_text(PYTHON)
    python.chmod(0o755)
    environment = {name: value for name, value in os.environ.items() if not name.startswith('MAKE')}
    return place, notes, {**environment, 'PYTHON': str(python), 'NOTES': str(notes)}


def start(project, *command):
    """Begin in a group of its own, as a terminal does; stderr and stdout together."""
    place, _, environment = project
    return subprocess.Popen(
        command or ('tools/setup.sh', 'runtime'), cwd=place, env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip


def until(predicate):
    end = time.monotonic() + PATIENCE
    while not predicate():
        assert time.monotonic() < end, 'nothing came of it'
        time.sleep(0.02)


def steps(project):
    return (project[1] / 'steps').read_text().split()


def hang(project, step):
    (project[1] / 'hang').write_text(step)
    return lambda: until((project[1] / 'hangs').exists)


def release(project):
    for name in ('hang', 'hangs', 'steps'):
        (project[1] / name).unlink(missing_ok=True)


@pytest.mark.parametrize(
    ('step', 'then'),
    [
        ('venv', ['venv', 'runtime', 'package']),
        ('runtime', ['runtime', 'package']),
        # Half installed: nothing of it can be trusted.
        ('package', ['venv', 'runtime', 'package']),
    ],
)
@pytest.mark.parametrize('to_all', [True, False], ids=['as a terminal', 'to it alone'])
def test_an_interrupted_set_up_says_one_line_and_goes_on_next_time(project, step, then, to_all):
    hangs = hang(project, step)
    process = start(project)
    hangs()
    (os.killpg if to_all else os.kill)(process.pid, signal.SIGINT)
    text, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    *before, last = text.splitlines()
    assert last == 'setup: stopped; run it again to go on'
    assert all(line.startswith('setup: ') and line.endswith(' ...') for line in before), text

    release(project)
    again = start(project)
    assert 'setup: ' in again.communicate(timeout=PATIENCE)[0]
    assert (again.returncode, steps(project)) == (0, then)
    release(project)
    third = start(project)
    assert (third.communicate(timeout=PATIENCE)[0], third.returncode) == ('', 0)
    assert not (project[1] / 'steps').exists()


def test_a_step_that_does_not_hear_is_ended_all_the_same(project):
    (project[1] / 'deaf').touch()
    hangs = hang(project, 'runtime')
    process = start(project)
    hangs()
    os.killpg(process.pid, signal.SIGINT)
    text, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert text.splitlines()[-1] == 'setup: stopped; run it again to go on'


def test_make_adds_no_more_than_its_own_line(project):
    hangs = hang(project, 'runtime')
    process = start(project, 'make', 'demo')
    hangs()
    os.killpg(process.pid, signal.SIGINT)
    text, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode != 0
    rest = text.split('stopped; run it again to go on\n')[1].splitlines()
    assert all(line.startswith('make: ') for line in rest) and len(rest) <= 1, text


def test_a_second_set_up_says_what_it_waits_for_and_can_be_stopped(project):
    hangs = hang(project, 'runtime')
    first = start(project)
    hangs()
    waiting = 'setup: another make is setting up .venv: waiting until it is done ...\n'
    second, third = start(project), start(project)
    assert [second.stdout.readline(), third.stdout.readline()] == [waiting, waiting]
    os.killpg(third.pid, signal.SIGINT)
    assert third.communicate(timeout=PATIENCE)[0] == 'setup: stopped; run it again to go on\n'
    assert third.returncode == 130

    release(project)
    os.killpg(first.pid, signal.SIGINT)
    first.communicate(timeout=PATIENCE)
    text, _ = second.communicate(timeout=PATIENCE)
    assert second.returncode == 0 and text.endswith('this package (seconds) ...\n'), text
    assert steps(project) == ['runtime', 'package']
