"""`ros2 run obs_ros replay RECORDING... --params FILE`: estimates of recordings, in files."""

import argparse
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

from obs_ros.cli.study import STUDY, add_options, study
from obs_ros.core.texts import LONGEST_NAME, one_line, quoted
from obs_ros.replay.comparison import NONE, Other, alternative
from obs_ros.replay.engine import Account, replay
from obs_ros.replay.extras import MissingPackageError
from obs_ros.replay.parameter_file import parse_assignment, read_parameters
from obs_ros.replay.recording import Recording, Source, open_recording
from obs_ros.replay.report import Report
from obs_ros.replay.settings import Setup, setup
from obs_ros.replay.summary import summary
from obs_ros.replay.writers import Take, bag_writer, table_writer
from obs_ros.studies.runner import Where

TABLE, BAG, SUMMARY, REPORT = 'estimates.csv', 'estimates', 'summary.md', 'report.html'
PICTURES = ('parameters.png', 'states.png', 'misfit.png')
OUR_FILES = (TABLE, SUMMARY, REPORT, *PICTURES, f'{BAG}/{BAG}.mcap', f'{BAG}/metadata.yaml')
NO_COMPARISON = f'--compare {NONE}'
REFRESH = 0.2  # s from one progress line to the next


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay what the command line names; 1, with one line on stderr, when that is impossible."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    options = _parser().parse_args(arguments)
    try:
        return run(options)
    except KeyboardInterrupt:
        print('\nreplay: stopped; what stands in the output is not all', file=sys.stderr)
        return 130
    except (ValueError, OSError, ImportError) as error:
        # There the line of progress stands.
        begin = '\r' if sys.stdout.isatty() else ''
        print(f'{begin}replay: {one_line(error)}', file=sys.stderr)
        return 1


def run(options: argparse.Namespace) -> int:
    """Replay; return the exit code.

    Raises ValueError, OSError or MissingPackageError when that is impossible.
    """
    given: dict[str, Any] = read_parameters(options.params, options.node) if options.params else {}
    given |= dict(parse_assignment(text) for text in options.parameters)
    first, *others = options.recordings
    source = Source(
        first,
        columns=_pairs('--column', options.columns),
        period=options.period,
        topics=_pairs('--topic', options.topics),
        node=options.node,
    )
    where = Where(options.jobs, options.scheduler)
    if others or options.vary or not where.here:
        return study(options, given, source, where)
    single(options, given, source)
    return 0


def single(options: argparse.Namespace, given: Mapping[str, Any], source: Source) -> None:
    """Replay one recording; raises as `run` does."""
    chosen = setup(given)
    compared = None
    if options.compare != NONE:
        asked = parse_assignment(options.compare) if options.compare else None
        compared = alternative(chosen, given, asked)
    recording = open_recording(source, chosen)
    name = source.path.resolve().name
    folder = options.output or source.path.resolve().with_name(f'{name}_replay')
    _make_room(folder, options.force)
    for remark in (*chosen.remarks, *recording.remarks):
        print(f'replay: {one_line(remark)}', file=sys.stderr)
    print(f'compiling model {quoted(chosen.model.name)}; the first time it takes several seconds')
    report = Report(chosen)
    summarise = partial(summary, name, chosen, deadline=options.deadline)
    with ExitStack() as files:
        takers = [report.take, files.enter_context(table_writer(folder / TABLE, chosen.model))]
        try:
            takers.append(files.enter_context(bag_writer(folder / BAG, chosen.model)))
        except MissingPackageError as error:
            _warn(error, BAG)
        account = replay(
            chosen,
            report.heard(recording),
            deadline=options.deadline,
            take=_all(takers),
            watch=_progress(name, recording),
        )
    _write(folder, summarise(account, recording))
    text = report.text(name, account, recording.remarks)
    (folder / REPORT).write_text(text, encoding='utf-8')
    _draw(account, chosen, folder)
    if compared is not None and len(account.history):
        print(f'once more with {one_line(compared)}, to compare ({NO_COMPARISON} to leave it out)')
        again = open_recording(source, compared.setup)
        other = replay(
            compared.setup, again, deadline=options.deadline, watch=_progress(name, again)
        )
        _write(folder, summarise(account, recording, other=Other(compared, other)))
    print(
        f'{len(account.history)} estimates, {account.speed:.3g} times real time; '
        f'see {one_line(folder / SUMMARY)}'
    )


def _write(folder: Path, page: str) -> None:
    """Write the summary, below the line of progress."""
    if sys.stdout.isatty():
        print()
    (folder / SUMMARY).write_text(page, encoding='utf-8')


def _draw(account: Account, chosen: Setup, folder: Path) -> None:
    try:
        from obs_ros.replay.picture import draw

        draw(account, folder)
    except MissingPackageError as error:
        _warn(error, ', '.join(PICTURES))


def _warn(error: MissingPackageError, what: str) -> None:
    print(f'replay: no {what}: {one_line(error)}', file=sys.stderr)


def _make_room(folder: Path, force: bool) -> None:
    """Make the folder; what an earlier replay left goes only by `force`, and nothing else."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f'{folder} is a file, not a folder to write to')
    there = [folder / name for name in OUR_FILES if (folder / name).exists()]
    if (folder.exists() and any(folder.iterdir())) and not force:
        raise ValueError(f'{folder} exists and is not empty: --force to overwrite, or --output')
    for path in there:
        path.unlink()
    if (folder / BAG).is_dir():
        (folder / BAG).rmdir()
    folder.mkdir(parents=True, exist_ok=True)


def _all(takers: Sequence[Take]) -> Take:
    def take(estimate: Any, skipped: int) -> None:
        for each in takers:
            each(estimate, skipped)

    return take


def _progress(name: str, recording: Recording) -> Callable[[Account], None]:
    """Return what shows a line that the next one replaces; nothing where the output is a file."""
    if not sys.stdout.isatty():
        return lambda account: None
    shown = 0.0

    def watch(account: Account) -> None:
        nonlocal shown
        now = time.monotonic()
        if now - shown >= REFRESH:
            shown = now
            text = (
                f'{100.0 * recording.done:3.0f} % of {one_line(name, LONGEST_NAME)}, '
                f'{len(account.history)} estimates, {account.speed:.3g} times real time'
            )
            print(f'\r{text:<78}', end='', flush=True)

    return watch


def _pairs(option: str, texts: Sequence[str]) -> Mapping[str, str]:
    pairs = {}
    for text in texts:
        name, separator, value = text.partition('=')
        if not (name and separator and value):
            raise ValueError(f'{option} {quoted(text)} is not of the form NAME=VALUE')
        pairs[name] = value
    return pairs


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='replay',
        description='Runs the estimator over a recording, faster than real time, and writes its '
        'estimates, a summary and pictures. Same recording, parameters and seed: same estimates. '
        'Several recordings, or variants of the parameters, are a study: one table, one summary.',
    )
    add = parser.add_argument
    add('recordings', type=Path, nargs='+', metavar='RECORDING',
        help='a bag (folder, .mcap, .db3) or a table (.csv, .tsv, .txt)')  # fmt: skip
    add('--params', type=Path, metavar='FILE', help="the estimator's ROS parameter file")
    add(
        '-p',
        dest='parameters',
        action='append',
        default=[],
        metavar='NAME:=VALUE',
        help='one parameter, over those of the file',
    )
    add(
        '--node',
        default='/estimator',
        help='whose parameters count, by its full name (default: %(default)s)',
    )
    add(
        '--output', type=Path, metavar='DIR', help=f'default: RECORDING_replay, {STUDY} for a study'
    )
    add('--force', action='store_true', help='overwrite what an earlier replay wrote there')
    add(
        '--topic',
        dest='topics',
        action='append',
        default=[],
        metavar='output=/TOPIC',
        help='topic in the bag, of output or input',
    )
    add(
        '--column',
        dest='columns',
        action='append',
        default=[],
        metavar='NAME=COLUMN',
        help="column of the table for one of the model's inputs or outputs; t=COLUMN: the time",
    )
    add('--period', type=float, metavar='S', help='s from row to row of a table without time')
    add(
        '--compare',
        metavar='NAME:=VALUE',
        help='replay once more with this parameter and set both beside each other in the summary '
        '(default: process_noise:=off, or auto where it is off; none: do not)',
    )
    add('--deadline', action='store_true', help='end each solve at the parameter deadline, as the '
        'node does; what comes out then depends on the machine')  # fmt: skip
    add_options(parser)
    return parser
