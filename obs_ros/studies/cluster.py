"""Calls on Dask: a cluster of processes on this machine, or a scheduler that is there already."""

import asyncio
import logging
import signal
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from multiprocessing import resource_tracker
from typing import Any

from obs_ros.core.texts import one_line, quoted
from obs_ros.replay.extras import require
from obs_ros.studies.versions import versions
from obs_ros.studies.worker import Arguments, Differs, Failure, packed, unpacked

LOOPBACK = '127.0.0.1'


@dataclass(frozen=True)
class ClusterSettings:
    """Patience with schedulers and workers."""

    connecting: float = 10.0  # s for a scheduler to answer: it is there, or it is not
    deaths: int = 3  # of workers over one call until it is given up: it is the call that kills


SETTINGS = ClusterSettings()


def over(
    work: Callable[..., Any],
    runs: Sequence[Arguments],
    jobs: int | None,
    scheduler: str | None,
    chunk: int,
    say: Callable[[str], None],
) -> Iterator[tuple[int, Any]]:
    """Yield index and result of each run as they come; see `runner.carried_out`."""
    distributed = require('distributed', '--jobs or --scheduler')
    _silence()
    groups = [range(k, min(k + chunk, len(runs))) for k in range(0, len(runs), chunk)]
    with ExitStack() as opened:
        # Versions are compared before anything is read, by rules of our own.
        opened.enter_context(warnings.catch_warnings())
        warnings.simplefilter('ignore')
        if scheduler is None:
            count = min(jobs or 1, max(len(groups), 1))
            scheduler = opened.enter_context(_local(distributed, count))
        client = opened.enter_context(_connected(distributed, scheduler))
        if not client.scheduler_info(n_workers=-1)['workers']:
            say(f'{scheduler} has no workers yet: waiting for them')
        futures = {
            client.submit(
                unpacked, packed(work, [runs[k] for k in group]), versions(), pure=False
            ): group
            for group in groups
        }
        done = distributed.as_completed(list(futures), loop=client.loop)
        for future in done:
            group = futures.pop(future)
            yield from zip(group, _results(distributed, future, len(group), scheduler), strict=True)


def _silence() -> None:
    """Leave out Dask's own words: many lines for what is one here."""
    for name in ('distributed', *logging.root.manager.loggerDict):
        if name.partition('.')[0] == 'distributed':
            logging.getLogger(name).setLevel(logging.CRITICAL)


@contextmanager
def _local(distributed: Any, count: int) -> Iterator[str]:
    """Start so many processes with one thread each, on the loopback only; give the address."""
    import dask

    config = {
        'distributed.scheduler.allowed-failures': SETTINGS.deaths,
        'distributed.comm.timeouts.connect': SETTINGS.connecting,
        'distributed.worker.profile.enabled': False,  # a hundred looks a second at every call
    }
    # A terminal sends Ctrl-C to all processes. Those that are started while it is blocked never
    # hear it, nor does the thread that replaces them; this one hears it when they are there.
    # The process that Python starts with the first of them would end the blocking.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with (
            dask.config.set(config),
            distributed.LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                processes=True,
                host=LOOPBACK,
                dashboard_address=f'{LOOPBACK}:0',
                scheduler_kwargs={'dashboard': False},
                memory_limit=None,
                silence_logs=logging.CRITICAL,
            ) as cluster,
        ):
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
            yield cluster.scheduler_address
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    """Connect to a scheduler; raises OSError in one line where there is none."""
    patience = SETTINGS.connecting
    try:
        # Asked first, since a client that finds nobody takes half a minute to give up.
        asyncio.run(_asked(distributed, address))
        client = distributed.Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise OSError(
            f'no Dask scheduler answers at {one_line(address)}: start one with `dask scheduler`, '
            'and workers with `dask worker`'
        ) from error
    with client:
        yield client


async def _asked(distributed: Any, address: str) -> None:
    """Let a scheduler tell who it is; raises OSError, TypeError or ValueError without one."""
    arguments = distributed.Security().get_connection_args('client')
    patience = SETTINGS.connecting
    async with distributed.rpc(address, timeout=patience, connection_args=arguments) as server:
        answer = await asyncio.wait_for(server.identity(), patience)
    if answer.get('type') != 'Scheduler':
        raise ValueError(answer.get('type'))


def _results(distributed: Any, future: Any, count: int, address: str) -> list[Any]:
    """Return the results of a group of runs; raises ValueError or OSError where all must end."""
    gone = f'the Dask scheduler at {one_line(address)} is gone'
    if future.cancelled():
        raise OSError(gone)
    try:
        error = future.exception()
        found = future.result() if error is None else None
    except (OSError, CancelledError) as lost:  # while the result was fetched
        raise OSError(gone) from lost
    if isinstance(error, distributed.scheduler.KilledWorker):
        return [Failure(f'{error.allowed_failures + 1} workers died of it')] * count
    if error is not None:
        raise ValueError(
            f'the workers at {one_line(address)} cannot run this, is the same obs_ros installed '
            f'there? {quoted(error)}'
        )
    if isinstance(found, Differs):
        raise ValueError(f'a worker at {one_line(address)} has other versions: {found.words}')
    assert isinstance(found, list)
    return found
