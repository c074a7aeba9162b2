"""From samples to estimates: what an estimator node has from configure to cleanup."""

import time
from collections.abc import Mapping
from contextlib import ExitStack
from functools import partial
from typing import Any

import rclpy
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from obs_ros.core.estimate import Estimate
from obs_ros.core.record import Sample
from obs_ros.core.texts import one_line, quoted
from obs_ros.interface.checkpoint import Checkpoint
from obs_ros.interface.checkpoint_writer import CheckpointWriter
from obs_ros.interface.compilation import Compilation
from obs_ros.interface.forecast import Forecast
from obs_ros.interface.health import examine
from obs_ros.interface.parameters import CHOICE, observer_parameters
from obs_ros.interface.pool import Pool
from obs_ros.interface.progress import Progress
from obs_ros.interface.settings import build_observer, differs
from obs_ros.interface.status import Health
from obs_ros.interface.worker import Finished, Worker
from obs_ros.models import load_model
from obs_ros.observers.base import Observer
from obs_ros.ros.diagnostics import log
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.info import info_on, model_info, settings_info
from obs_ros.ros.messages import LATCHED
from obs_ros.ros.parameters import Parameters
from obs_ros.ros.publication import EstimatePublisher
from obs_ros.ros.streams import Streams, with_signals

PATIENCE = 0.3  # s that the end of the node waits for a solve, which nothing can interrupt


class Estimation:
    """Hands plant/output and plant/input to an observer and publishes its estimates.

    Parameters `signals.<name>` bind outputs and inputs to fields of other topics.
    Callbacks only append samples. A thread, of `pool` or its own, has the model compiled and then
    solves; of windows that close meanwhile it takes the newest, others count as skipped. Immediate
    observers take their step in the callback instead, and samples are counted until they can.
    Between windows the state is predicted from sample to sample, in the callback as well.

    It compiles from the start, and listens from `activate` to `deactivate`. `close` ends all of it.
    Raises ValueError when parameters given are wrong.
    """

    def __init__(
        self, node: GuardedNode, parameters: Parameters, pool: Pool | None = None,
        writer: CheckpointWriter | None = None,
    ) -> None:  # fmt: skip
        self._node, self._log = node, node.get_logger()
        self.progress = Progress(active=False)
        self._settings: Mapping[str, Any] = {}
        self.observer: Observer
        self._break: str | None = None
        self._prepared = False  # for the first estimate
        # Arrival (steady clock, s) of the sample that closed the newest window, until it is solved.
        self._due: float | None = None
        self._solving = 0.0  # the same of the window that is being solved
        self._forecast: Forecast | None = None
        self._closing = ExitStack()  # destroys what is made here, the last of it first
        self._guard = node.create_guard_condition(self._collect)
        self._closing.callback(node.destroy_guard_condition, self._guard)
        self._kernels = Compilation()
        self._checkpoint = Checkpoint()
        self._worker = Worker(self._guard.trigger, pool, lambda: self._kernels.of(self._settings))
        try:
            self._configure(parameters, writer)
        except BaseException:
            self.close()
            raise

    def _configure(self, parameters: Parameters, writer: CheckpointWriter | None) -> None:
        node, closing = self._node, self._closing
        parameters.declare(CHOICE)
        name = node.get_fully_qualified_name()
        self._checkpoint = Checkpoint.of(parameters.values, name, writer)
        self.model = load_model(parameters.values['model'])
        self.model, bound = with_signals(node, self.model, parameters)
        parameters.declare(observer_parameters(self.model, parameters.values['observer']))
        info = node.create_publisher(String, '~/info', LATCHED)
        closing.callback(node.destroy_publisher, info)
        self._publish_info = info_on(info)
        predicting = 'prediction.enabled' in parameters.values
        self._publisher = EstimatePublisher(node, self.model, predicting=predicting)
        closing.callback(self._publisher.destroy)
        parameters.watch(self._propose, self._adopt)
        for level, line in self._checkpoint.take_up(self.observer):
            log(node, level, line)
        wait = parameters.values['merge_wait']
        self.streams = Streams(node, self.model, bound, wait, self._absorb)
        closing.callback(self.streams.destroy)
        reset = node.create_service(Trigger, '~/reset', self._on_reset)
        enable = node.create_service(SetBool, '~/enable', self._on_enable)
        closing.callback(node.destroy_service, reset)
        closing.callback(node.destroy_service, enable)
        jumps = node.watch_clock(lambda _: self._reset('ROS time jumped back'))
        closing.callback(jumps.unregister)

    def activate(self) -> None:
        """Listen, and estimate."""
        self.streams.open()
        self.progress.active = True
        self._proceed()

    def deactivate(self) -> None:
        """Hear and estimate nothing; what has been learned, and the samples so far, are kept."""
        self.progress.active = False
        self.streams.close()
        self._drop_solve()

    def close(self, patience: float = PATIENCE) -> bool:
        """End all of it; False when its solve has not ended within so many s: none hears of it."""
        self._kernels.close()
        ended = self._worker.close(patience)
        self._closing.close()
        return self._checkpoint.close() and ended

    def _propose(self, values: Mapping[str, Any]) -> tuple[Mapping[str, Any], Observer | None]:
        new = differs(values, self._settings)
        return values, build_observer(self.model, values) if new else None

    def _adopt(self, proposal: tuple[Mapping[str, Any], Observer | None]) -> None:
        self._settings, observer = proposal
        self._predict(observer or self.observer)
        if observer is None:
            if not self._prepared:
                self._proceed()
            return
        if self._prepared:
            self._log.info('parameters changed: the next window is for a new observer')
            if not observer.inherit(self.observer):
                self._due = None
        self._worker.discard()
        self._checkpoint.begin_anew('parameters changed')
        self.observer, self._break = observer, observer.last_break
        self._prepared = False
        self.progress.restart()
        self._publish_info({**model_info(observer.model), **settings_info(self._settings)})
        self._proceed()

    def _predict(self, observer: Observer) -> None:
        """Begin to predict, or cease, as the settings say."""
        if self._settings.get('prediction.enabled') and self._forecast is None:
            self._forecast = Forecast(self.model, self._publisher.publish_prediction)
            self._prepared = False
        elif not self._settings.get('prediction.enabled'):
            self._forecast = None
        if self._forecast is not None:
            self._forecast.follow(self._settings, getattr(observer, 'unknowns', None))

    def _prepare(self) -> float:
        """Compile or load what is needed, in the worker; return the seconds that it took."""
        seconds = self.observer.prepare()
        return seconds if self._forecast is None else seconds + self._forecast.prepare()

    def _absorb(self, sample: Sample, arrival: float) -> None:
        """Let the observer take a sample that arrived at `arrival` (steady clock, s)."""
        if not self.progress.enabled:
            return
        self.progress.note_lag(time.monotonic() - arrival)
        if self.observer.immediate:
            self._step(sample, arrival)
            return
        if self.observer.absorb(sample):
            self._due = arrival
        self._watch_timeline()
        if self._forecast is not None:
            self._forecast.absorb(
                sample, arrival, silent=lambda: self.streams.alternating or self.stale
            )
        if self._due is not None:
            self._proceed()

    def _step(self, sample: Sample, arrival: float) -> None:
        """Let an immediate observer take the sample, and publish its estimate."""
        if not self._prepared:
            self.progress.too_early += 1
            return
        try:
            due = self.observer.absorb(sample)
            self._watch_timeline()
            estimate = self.observer.estimate() if due else None
        except Exception as error:
            self.observer.reset()
            self._fail(Finished('estimate', None, error))
            return
        if estimate is not None:
            self._publish(estimate, arrival)

    def _watch_timeline(self) -> None:
        if self.observer.last_break is not self._break:
            self._break = self.observer.last_break
            self._forget_solve()
            self._checkpoint.forget(one_line(self._break))
            self._log.warning(f'start anew: {one_line(self._break)}')

    def _proceed(self) -> None:
        """Give the worker what is next, unless it is busy."""
        if self._worker.running is not None:
            return
        if not self._prepared:
            if not self.progress.compile_time:
                name = quoted(self.model.name)
                self._log.info(f'compiling model {name}; the first time it takes seconds')
            self._worker.start('prepare', self._prepare)
        elif self._due is not None:
            deadline = self._settings['deadline']
            solve = partial(self.observer.estimate, deadline)
            self._worker.start('estimate', solve, self._due + deadline)
            self._solving, self._due = self._due, None
        elif not self.progress.compiled and not self._kernels.under_way:
            # Like a window, so that none of this plant waits behind it for long.
            due = time.monotonic() + self._settings.get('deadline', 0.0)
            self._worker.start('prepare more', self.observer.prepare_more, due)

    def _collect(self) -> None:
        if (finished := self._worker.collect()) is not None:
            self._conclude(finished)
        if rclpy.ok(context=self._node.context):
            self._proceed()

    def _conclude(self, finished: Finished) -> None:
        if finished.error is not None:
            self._fail(finished)
        elif finished.kind == 'estimate' and finished.result is not None:
            self._publish(finished.result, self._solving)
            self._checkpoint.keep(self.observer)
        if finished.kind != 'estimate':
            self.progress.compiled = finished.kind == 'prepare more' and not finished.result
        if finished.kind == 'prepare':
            self._prepared = self.progress.ready = True
            if finished.error is None and not self.progress.compile_time:
                self.progress.compile_time = float(finished.result)
                self._log.info(f'ready after {finished.result:.1f} s of compilation')

    def _fail(self, finished: Finished) -> None:
        self.progress.fail(finished)
        if finished.kind == 'estimate' and self._checkpoint.failed():
            self.observer.reset()
        self._log.error(f'cannot {finished.kind}: {self.progress.error}', throttle_duration_sec=5.0)

    @property
    def lag(self) -> float | None:
        """Time (s) since a window closed whose estimate is not published; None if there is none."""
        closed = self._solving if self._worker.running == 'estimate' else self._due
        return None if closed is None else time.monotonic() - closed

    @property
    def idle(self) -> bool:
        """Whether nothing is compiled or solved, and no sample waits for others."""
        return self._due is None and self._worker.running is None and not self.streams.waiting

    @property
    def stale(self) -> bool:
        """Whether a stream has stopped, so that the plant's inputs or outputs are not known."""
        return self.streams.stale(self._settings['stale_after'])

    def _publish(self, estimate: Estimate, arrival: float) -> None:
        latency = time.monotonic() - arrival
        published = not self.streams.alternating and self._publisher.publish(
            estimate, latency, self.observer.counts['skipped']
        )
        self.progress.conclude(estimate, latency, published)
        if self._forecast is not None:
            self._forecast.start(estimate)

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._reset('asked to')
        response.success, response.message = True, 'all samples and estimates forgotten'
        return response

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if request.data and not self.progress.enabled:
            # The plant went on unseen meanwhile, so no window may span it.
            self._reset('enabled')
            self.streams.rest()
        self.progress.enabled = request.data
        response.success = True
        response.message = 'estimating' if request.data else 'paused: samples are ignored'
        return response

    def _reset(self, why: str) -> None:
        self._log.info(f'reset: {why}')
        self.streams.clear()
        self.observer.reset()
        self._checkpoint.forget(why)
        self._forget_solve()
        if self._forecast is not None:
            self._forecast.forget()

    def _forget_solve(self) -> None:
        self._drop_solve()
        self.progress.estimate, self.progress.behind = None, 0.0
        if self._forecast is not None:
            self._forecast.end()

    def _drop_solve(self) -> None:
        self._due = None
        if self._worker.running == 'estimate':
            self._worker.discard()

    def examine(self) -> Health:
        """Return the worst that is known, and every figure; to be called once a second."""
        self._proceed()  # a child may have ended
        self.progress.begin_examination(self.observer.counts.get('late', 0))
        self.progress.collected = self.observer.collected
        self.progress.solving = self.lag is not None
        self._checkpoint.tell(self.progress)
        return examine(
            self.progress, self.streams.status(), self._settings, self.observer.counts,
            self._break, self._forecast,
        )  # fmt: skip
