"""The observer over a recording, one sample after the other, as the node runs it."""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from obs_ros.core.estimate import Estimate
from obs_ros.core.record import Sample
from obs_ros.core.texts import quoted
from obs_ros.interface.forecast import window_reach
from obs_ros.interface.settings import build_observer
from obs_ros.observers.base import Observer
from obs_ros.replay.forecast import Forecaster
from obs_ros.replay.history import History
from obs_ros.replay.settings import Setup


@dataclass
class Account:
    """The course of a replay; times in s, stamps in ns."""

    history: History
    compile_time: float = 0.0
    wall_time: float = 0.0
    samples: int = 0
    first: int | None = None
    last: int | None = None
    horizon: float | None = None  # of the forecasts; None: there are none
    failed: int = 0
    notes: list[str] = field(default_factory=list)  # the first breaks of the timeline and failures
    most_notes: int = 100  # kept, as many as anybody reads; all are counted
    counts: Mapping[str, int] = field(default_factory=dict)

    def tell(self, text: str) -> None:
        """Keep a note, unless there are many."""
        if len(self.notes) < self.most_notes:
            self.notes.append(text)

    @property
    def recorded(self) -> float:
        """Length of the recording in s."""
        return 0.0 if self.first is None or self.last is None else (self.last - self.first) / 1e9

    @property
    def speed(self) -> float:
        """Recorded time per time that the replay took, compilation left out."""
        return self.recorded / self.wall_time if self.wall_time > 0.0 else float('inf')


def replay(
    setup: Setup,
    samples: Iterable[Sample],
    *,
    deadline: bool = False,
    take: Callable[[Estimate, int], None] = lambda estimate, skipped: None,
    watch: Callable[[Account], None] = lambda account: None,
) -> Account:
    """Run the observer that the node would run over all samples; return the account.

    `take` gets each estimate when it is there, with the number of windows skipped so far; `watch`
    gets the account after each sample. With `deadline` a solve ends after the node's parameter of
    that name; without, nothing depends on the clock: the same samples give the same bits.

    Raises ValueError for parameters that do not go together, and the errors of `samples`.
    """
    values: Mapping[str, Any] = setup.values
    observer = build_observer(setup.model, values)
    account = Account(History(setup.model))
    forecaster = None
    if not observer.immediate:
        account.horizon = values['window.duration']
        forecaster = Forecaster(
            setup.model, account.horizon, window_reach(values), values['window.capacity']
        )
    account.compile_time = observer.prepare()
    limit = values['deadline'] if deadline and not observer.immediate else None
    begin = time.perf_counter()
    for sample in samples:
        _note(account, sample)
        estimate = _step(observer, sample, limit, account, forecaster)
        if estimate is not None:
            index = account.history.add(estimate)
            if forecaster is not None:
                forecaster.add(index, estimate)
            take(estimate, observer.counts['skipped'])
        if forecaster is not None:
            account.history.judged(forecaster.judge())
        account.wall_time = time.perf_counter() - begin
        watch(account)
    account.counts = observer.counts
    return account


def _note(account: Account, sample: Sample) -> None:
    account.samples += 1
    account.history.record(sample)
    account.first = sample.stamp if account.first is None else min(account.first, sample.stamp)
    account.last = sample.stamp if account.last is None else max(account.last, sample.stamp)


def _step(
    observer: Observer,
    sample: Sample,
    limit: float | None,
    account: Account,
    forecaster: Forecaster | None,
) -> Estimate | None:
    """Let the observer take a sample; return the estimate if one was due.

    An observer that raises is dealt with as in the node: the other windows go on without it.
    """
    last_break = observer.last_break
    estimate = None
    try:
        due = observer.absorb(sample)
        if observer.last_break is not last_break:
            account.tell(f'start anew: {observer.last_break}')
        if forecaster is not None:
            forecaster.push(sample)
        estimate = observer.estimate(limit) if due else None
    except Exception as error:
        account.failed += 1
        account.tell(f'failed at {sample.stamp / 1e9:g} s: {quoted(error)}')
        if observer.immediate:
            observer.reset()
    return estimate
