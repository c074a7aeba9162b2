"""`replay` of many recordings and variants: one table, and a summary that compares."""

import argparse
import signal
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any, NoReturn

from obs_ros.core.texts import one_line
from obs_ros.replay.extras import MissingPackageError
from obs_ros.replay.recording import Source
from obs_ros.studies.page import Findings, page
from obs_ros.studies.pictures import draw
from obs_ros.studies.progress import Progress
from obs_ros.studies.runner import Where
from obs_ros.studies.scores import Score, Scores
from obs_ros.studies.store import Store
from obs_ros.studies.study import Study
from obs_ros.studies.tables import Block, csv_table, header, parquet_table
from obs_ros.studies.variants import Variant, shown, variants

STUDY = 'study'
TABLE, PARQUET, SUMMARY, RESULTS = 'estimates.csv', 'estimates.parquet', 'summary.md', 'results'
MOST_TOLD = 20  # remarks and failures on the terminal; the summary has more


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a study to those of a replay."""
    add = parser.add_argument_group('studies of many recordings and variants').add_argument
    add(
        '--vary',
        action='append',
        default=[],
        metavar='NAME=A,B',
        help='values of a parameter to compare; of several, every combination',
    )
    add('--jobs', type=int, metavar='N', help='processes that share a study (needs distributed)')
    add('--scheduler', metavar='ADDRESS', help='a Dask scheduler, tcp://host:port, whose workers '
        'share it')  # fmt: skip


def study(
    options: argparse.Namespace, given: Mapping[str, Any], source: Source, where: Where
) -> int:
    """Replay every recording with every variant; return the exit code, 1 where results are missing.

    Raises ValueError, OSError or MissingPackageError where nothing can be done.
    """
    if options.compare:
        raise ValueError('--compare is for one recording: give --vary NAME=A,B for a study')
    folder = options.output or options.recordings[0].resolve().with_name(STUDY)
    chosen = variants(given, options.vary)
    store = _opened(folder, options.force)
    own = folder.resolve()
    paths = list(dict.fromkeys(path for path in options.recordings if path.resolve() != own))
    asked = Study.of(paths, chosen, source, store, deadline=options.deadline)
    left = asked.left()
    told = list(dict.fromkeys(remark for variant in chosen for remark in variant.setup.remarks))
    told += [f'{name}: {why}' for name, why in asked.unreadable.items()]
    for line in told[:MOST_TOLD]:
        print(f'replay: {one_line(line)}', file=sys.stderr)
    print(
        f'{len(paths)} recordings, {len(chosen)} variants: {len(asked.runs)} runs, '
        f'{len(asked.runs) - len(left)} of them done already'
    )
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _stop_once)
    bar = Progress('replay', len(left), lines=True)
    try:
        with closing(asked.carry_out(left, where, bar.say)) as steps:
            for run, why in steps:
                if why and len(asked.failed) <= MOST_TOLD:
                    bar.say(f'replay: {one_line(run)}: {one_line(why)}')
                bar.step()
        _write(asked, chosen, folder, told)
    except KeyboardInterrupt:
        bar.leave()
        done = len(asked.runs) - len(asked.left())
        print(
            f'replay: stopped; {done} of {len(asked.runs)} runs are kept in {one_line(folder)}, '
            'the same command goes on from there',
            file=sys.stderr,
        )
        return 130
    except BaseException:
        bar.leave()
        raise
    return 1 if asked.missing else 0


def _stop_once(*_: object) -> NoReturn:
    """End by KeyboardInterrupt; workers are then ended, and a second Ctrl-C changes nothing."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


def _opened(folder: Path, force: bool) -> Store:
    """Return the store in the folder of a study; a folder of something else only by `force`."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f'{folder} is a file, not a folder to write to')
    store = Store(folder / RESULTS)
    if folder.exists() and any(folder.iterdir()) and not store.folder.is_dir() and not force:
        raise ValueError(f'{folder} exists and is no study: --force to write there, or --output')
    if force:
        store.forget()
    store.folder.mkdir(parents=True, exist_ok=True)
    return store


def _write(asked: Study, chosen: Sequence[Variant], folder: Path, told: Sequence[str]) -> None:
    """Write table, picture and summary of all results there are."""
    scores: dict[str, dict[str, Score]] = {str(variant): {} for variant in chosen}
    seconds, remarks, columns = 0.0, dict.fromkeys(told), dict[str, type]()
    for run, result in asked.results():
        scores[str(run.variant)][run.recording] = Score.of(result)
        facts = result.facts
        seconds += facts['wall_time'] + facts['compile_time']
        notes = (*facts['remarks'], *facts['notes'])
        remarks |= dict.fromkeys(f'{run}: {note}' for note in notes)
        columns |= header([Block(run.labels, result)])
    _write_tables(asked, columns, folder)
    compared = {name: Scores(runs) for name, runs in scores.items()}
    try:
        drawn = draw(compared, folder)
    except MissingPackageError as error:
        drawn = []
        print(f'replay: no picture: {one_line(error)}', file=sys.stderr)
    found = Findings(
        len({run.recording for run in asked.runs}) + len(asked.unreadable), compared,
        asked.missing, list(remarks), drawn, seconds, _about(chosen),
    )  # fmt: skip
    (folder / SUMMARY).write_text(page(found), encoding='utf-8')
    estimates = sum(each.estimates for each in compared.values())
    print(
        f'{estimates} estimates in {_counted(compared.values())} runs, {len(asked.missing)} '
        f'without a result; see {one_line(folder / SUMMARY)}'
    )


def _about(chosen: Sequence[Variant]) -> str:
    """Say which model and observer run, with which windows and seed, where these do not vary."""
    first, varied = chosen[0].setup.values, chosen[0].varied
    told = ('model', 'observer', 'window.duration', 'window.period', 'process_noise', 'seed')
    return ', '.join(
        f'{name} `{shown(first[name])}`' for name in told if name in first and name not in varied
    )


def _write_tables(asked: Study, columns: Mapping[str, type], folder: Path) -> None:
    with ExitStack() as files:
        adders = [files.enter_context(csv_table(folder / TABLE, columns))]
        try:
            adders.append(files.enter_context(parquet_table(folder / PARQUET, columns)))
        except MissingPackageError as error:
            print(f'replay: no {PARQUET}: {one_line(error)}', file=sys.stderr)
        for run, result in asked.results():
            for add in adders:
                add(Block(run.labels, result))


def _counted(scores: Iterable[Scores]) -> int:
    return sum(len(each.runs) for each in scores)
