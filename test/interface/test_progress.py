"""Progress of an estimator, as its health shows it."""

from interface.test_health import estimate, judged

from obs_ros.core.estimate import Outcome
from obs_ros.interface.progress import Progress
from obs_ros.interface.status import Level
from obs_ros.interface.worker import Finished


def test_progress_counts_what_was_published_withheld_and_failed():
    progress = Progress(ready=True)
    progress.conclude(estimate(), 0.1, published=True)
    progress.conclude(estimate(), 0.1, published=True)
    progress.fail(Finished('estimate', None, ZeroDivisionError('by zero')))
    assert judged(progress) == (
        Level.ERROR, 'failed', "the observer failed: ZeroDivisionError('by zero')"
    )  # fmt: skip
    progress.conclude(estimate(Outcome.DIVERGED, float('nan')), 0.3, published=False)
    assert (progress.published, progress.withheld, progress.failed) == (2, 1, 1)
    assert judged(progress)[:2] == (Level.ERROR, 'diverged')


def test_a_restart_forgets_the_last_estimate_and_error_but_not_the_counts():
    progress = Progress(ready=True)
    progress.conclude(estimate(), 0.1, published=True)
    progress.fail(Finished('estimate', None, RuntimeError('no')))
    progress.restart()
    assert judged(progress)[1] == 'compiling'
    progress.ready = True
    assert judged(progress)[1] == 'collecting'
    assert (progress.published, progress.failed) == (1, 1)


def test_late_samples_count_for_some_calls():
    progress = Progress(late_for=2)
    seen = []
    for total in (0, 3, 5, 5, 5):
        progress.begin_examination(total)
        seen.append(progress.late)
    assert seen == [0, 3, 5, 2, 0]


def test_what_waited_is_over_at_the_examination_after_the_next():
    progress = Progress()
    shown = []
    for lags in ([0.2, 3.0, 0.1], [], [1.5], [0.4]):
        for lag in lags:
            progress.note_lag(lag)
        progress.begin_examination(0)
        shown.append(progress.behind)
    assert shown == [3.0, 0.0, 1.5, 0.4]
