"""Commands of the documents, translated to what this machine has of ROS."""

import re
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from bag_session import play, record
from documents import ROOT, Command
from patience import patience
from session import Session

from obs_ros.interface.vectors import TOPICS

Action = Callable[[Session, list[str]], None]


class UntranslatableError(Exception):
    """A command that nothing here stands for; the message says where to teach it."""


def perform(session: Session, block: Sequence[Command]) -> None:
    """Do what stands in one block; every `echo` of it must have printed something at its end.

    Raises AssertionError where a command fails, UntranslatableError where one is new.
    """
    for command in block:
        action, condition = translation(command), awaited(command)
        condition(session)
        action(session, [session.filled(word) for word in command.words])
    session.hear_echoes()


def translation(command: Command) -> Action:
    """Return what is done for a command; raises UntranslatableError where nothing is known."""
    line = re.sub(
        r'^(python -m (?:benchmarks|obs_ros\.cli))\.\w+', r'\1', ' '.join(command.words)
    ).split()
    for length in range(len(line), 0, -1):
        if found := TRANSLATIONS.get(' '.join(line[:length])):
            return found
    raise UntranslatableError(
        f'{command} is documented, but never tried: tell TRANSLATIONS in {Path(__file__).name} how'
    )


def awaited(command: Command) -> Callable[[Session], None]:
    """Return what the comment beside a command waits for; raises UntranslatableError."""
    if not command.comment.startswith('once '):
        return lambda session: None
    if command.comment not in CONDITIONS:
        raise UntranslatableError(f'{command}: nothing is known of "{command.comment}"')
    return CONDITIONS[command.comment]


def _covered(reason: str) -> Action:
    """Stand for what cannot run here, and why; or what other tests run."""
    assert reason
    return lambda session, words: None


def _cd(session: Session, words: list[str]) -> None:
    """Go into a folder that an earlier command has made; others are the reader's."""
    if (session.folder / words[1]).is_dir():
        session.folder /= words[1]


def _make(session: Session, words: list[str]) -> None:
    """Let `make` look for the target; demo, test and check run by themselves, help runs here."""
    dry = [] if words[1:] == ['help'] else ['-n']
    done = subprocess.run(
        ['make', *dry, *words[1:]], cwd=ROOT, env=session.environment, capture_output=True,
        text=True, timeout=patience(10.0), check=False,
    )  # fmt: skip
    assert done.returncode == 0 and done.stdout, done.stderr


def _pip_install(session: Session, words: list[str]) -> None:
    """See that the package is one that set-up installs, or the extra one of setup.py."""
    pinned = (ROOT / 'requirements' / 'pins.txt').read_text().lower()
    extras = (ROOT / 'setup.py').read_text()
    for word in [each for each in words[2:] if not each.startswith('--')]:
        if match := re.fullmatch(r'\.\[(\w+)\]', word):
            assert f"'{match[1]}': [" in extras, word
        else:
            assert re.search(rf'^{re.escape(word)}==', pinned, re.MULTILINE), word


def _colcon_build(session: Session, words: list[str]) -> None:
    """See that the packages are there: colcon itself is not among the wheels."""
    assert words[2] == '--packages-select'
    named = '\n'.join(file.read_text() for file in ROOT.glob('**/package.xml'))
    assert all(f'<name>{package}</name>' in named for package in words[3:])


def _benchmark(session: Session, words: list[str]) -> None:
    """See that the module is there: benchmarks take minutes to hours."""
    assert list(ROOT.glob(f'{words[2].replace(".", "/")}*')), words[2]


def _export(session: Session, words: list[str]) -> None:
    """Set variables, but for those of SROS2, which is not among the wheels."""
    for name, _, value in (word.partition('=') for word in words[1:]):
        if not name.startswith('ROS_SECURITY'):
            session.environment[name] = value


def _replay(session: Session, words: list[str]) -> None:
    """Replay once more where an earlier line has: `--force`, which its refusal names."""
    there = Path(f'{session.files["RECORDING"]}_replay').exists()
    line = [*words, '--force'] if there else words
    (session.run if words[0] == 'ros2' else session.python)(line)


def _play(session: Session, words: list[str]) -> None:
    """Play the clock too where it is asked for; else see that there is what is to be played."""
    if '--clock' in words:
        play(session, words)
        return
    if not Path(words[3]).exists():
        _replay(session, ['ros2', 'run', 'obs_ros', 'replay', *session.files['REPLAY'].split()])
    assert (Path(words[3]) / 'metadata.yaml').exists()


def _plot(session: Session, words: list[str]) -> None:
    """See that the topics of the curves are published: rqt is not among the wheels."""
    for curve in words[4:]:
        assert curve.split('/')[2] in TOPICS, curve


def _layout(session: Session, words: list[str]) -> None:
    """See that the layout is installed: PlotJuggler is not among the wheels."""
    assert words[4] == '--layout' and Path(words[5]).is_file(), words[5]


CONDITIONS = {'once the first window is full': Session.first_window}
TRANSLATIONS: dict[str, Action] = {
    'make': _make,
    'cd': _cd,
    'docker run --rm -it': _covered('there is no Docker here, as the README says'),
    'rosdep install --from-paths src': _covered('rosdep is not among the wheels'),
    'git clone': _covered('the reader has done so'),
    'colcon build': _colcon_build,
    'source CLONE/.venv/bin/activate': _covered('these tests run in it'),
    'source .venv/bin/activate': _covered('these tests run in it'),
    'source install/setup.bash': _covered('AMENT_PREFIX_PATH names the prefixes here'),
    'export': _export,
    'grep': Session.tool,
    'pip install': _pip_install,
    'python -m benchmarks': _benchmark,
    'python -m obs_ros.cli': Session.python,
    'python -m obs_ros.replay': _replay,
    'python -m plant_sim.recording': Session.python,
    'python -m pytest': Session.python,
    'python -m obs_ros.interface.usage': Session.python,
    'python -m obs_ros.observers.papers.design.h_infinity': _covered(
        'CVXPY is not among what tests need: `make test-design` runs it'
    ),
    'ros2 run obs_ros': Session.run,
    'ros2 run obs_ros replay': _replay,
    'ros2 run rqt_plot': _plot,
    'ros2 run plotjuggler': _layout,
    'ros2 run foxglove_bridge': _covered('the bridge is not among the wheels'),
    'sudo apt install': _covered('only who administers the machine can'),
    'ros2 topic echo': Session.echo,
    'ros2 param set': Session.set_parameter,
    'ros2 param get': Session.get_parameter,
    'ros2 param dump': Session.dump_parameters,
    'ros2 lifecycle set': Session.transition,
    'ros2 lifecycle get': Session.transition,
    'ros2 service call': Session.call,
    'ros2 bag play': _play,
    'ros2 bag record': record,
    'ros2 security': _covered('SROS2 is not among the wheels'),
}
