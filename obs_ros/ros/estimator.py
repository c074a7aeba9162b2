"""The estimator node: samples in, estimates and diagnostics out, by itself or as it is managed."""

import sys
from collections.abc import Callable
from typing import Any

from lifecycle_msgs.srv import ChangeState
from rclpy.exceptions import ParameterException
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from obs_ros.core.texts import listing, one_line, quoted
from obs_ros.interface.checkpoint_writer import CheckpointWriter
from obs_ros.interface.fleet import OWN, PlantStatus
from obs_ros.interface.health import not_configured
from obs_ros.interface.parameters import CHOICE, RENAMED
from obs_ros.interface.pool import Pool
from obs_ros.interface.status import Health
from obs_ros.interface.terminal import Terminal
from obs_ros.ros.diagnostics import log, publish_health
from obs_ros.ros.draft import Draft
from obs_ros.ros.estimation import PATIENCE, Estimation
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.parameters import Parameters, given_at_start
from obs_ros.ros.run import run

# What a user, a model or the middleware may have wrong; all else is a defect.
FAILURES = (ValueError, ParameterException, RuntimeError)


class Estimator(LifecycleNodeMixin, GuardedNode):
    """Estimates while it is active; see `Estimation`, which it has from configure to cleanup.

    With the parameter `managed` others send it from state to state, by the services of a managed
    node. Else it has none of those, and configures and activates itself at once: it raises
    ValueError when parameters given at start are wrong.
    """

    def __init__(
        self, *, pool: Pool | None = None, writer: CheckpointWriter | None = None, **options: Any
    ) -> None:
        GuardedNode.__init__(
            self, 'estimator', automatically_declare_parameters_from_overrides=True, **options
        )
        self._pool, self._writer = pool, writer
        self._terminal = Terminal()
        self.estimation: Estimation | None = None
        self.trouble: Exception | None = None  # why the last transition did not succeed
        try:
            given = given_at_start(self, RENAMED, lambda name: pool is None or name not in OWN)
            (spec,) = (spec for spec in CHOICE if spec.name == 'managed')
            self.managed = bool(spec.coerce(given.get(spec.name, spec.default)))
            self._draft = Draft(self, given)
            if self.managed:
                LifecycleNodeMixin.__init__(self, enable_communication_interface=True)
                self._draft.open()
                self._guard_transitions()
            else:
                self._configure()
                self._activate()
            publish_health(self, self._plant, self._examine)
        except BaseException:
            self.close()
            self.destroy_node()
            raise

    @property
    def state(self) -> str:
        """The state of a managed node, as ROS calls it; one that is not managed is active."""
        return str(self._state_machine.current_state[1]) if self.managed else 'active'

    def status(self) -> PlantStatus:
        """Return what a fleet shows of it."""
        if self.estimation is None:
            return PlantStatus(error=_words(self.trouble))
        progress, lag = self.estimation.progress, self.estimation.lag
        return PlantStatus(
            estimates=progress.published + progress.withheld,
            skipped=self.estimation.observer.counts.get('skipped', 0),
            lag=progress.latency if lag is None else max(lag, progress.latency),
            error=progress.error,
        )

    def close(self, patience: float = PATIENCE) -> bool:
        """End the worker; False when its solve has not ended within so many s."""
        return self.estimation is None or self.estimation.close(patience)

    def destroy_node(self) -> None:
        """End the node; rclpy lets its state machine keep it on the graph."""
        super().destroy_node()
        if hasattr(self, '_state_machine'):  # of a managed node
            self._state_machine.destroy_when_not_in_use()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Make everything from the parameters, and begin to compile."""
        return self._attempt(self._configure, TransitionCallbackReturn.FAILURE)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Listen, and estimate."""
        return self._attempt(self._activate, TransitionCallbackReturn.FAILURE)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Hear and estimate nothing."""
        return self._attempt(self._configured.deactivate)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget everything but the parameters."""
        return self._attempt(self._clean_up)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget everything."""
        return self._attempt(self._clean_up)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean up after a transition that failed half way; then the node can be configured."""
        trouble = self.trouble
        result = self._attempt(self._clean_up)
        self.trouble = self.trouble or trouble
        return result

    def _attempt(
        self,
        transition: Callable[[], Any],
        refused: TransitionCallbackReturn = TransitionCallbackReturn.ERROR,
    ) -> TransitionCallbackReturn:
        """Return what has become of a transition: `refused` where others can mend what is wrong.

        rclpy would take an exception for an error, and say nothing of it.
        """
        self.trouble = None
        try:
            transition()
        except Exception as error:
            self.trouble = error
            self.get_logger().error(_words(error))
            return refused if isinstance(error, FAILURES) else TransitionCallbackReturn.ERROR
        return TransitionCallbackReturn.SUCCESS

    @property
    def _configured(self) -> Estimation:
        assert self.estimation is not None
        return self.estimation

    def _configure(self) -> None:
        self._configuration = Parameters(self, self._draft.close(), passing=self.managed)
        try:
            self.estimation = Estimation(self, self._configuration, self._pool, self._writer)
        except BaseException:
            self._reopen()
            raise

    def _activate(self) -> None:
        try:
            self._configured.activate()
        except BaseException:
            self._configured.deactivate()
            raise

    def _clean_up(self) -> None:
        if self.estimation is not None:
            self.estimation.close()
            self.estimation = None
            self._reopen()

    def _reopen(self) -> None:
        if self.managed:
            self._draft.open(self._configuration.withdraw())

    def _guard_transitions(self) -> None:
        """Let no call of the services of a managed node end it: rclpy raises where none is."""
        for service in self.services:
            if service.srv_type is ChangeState:
                service.callback = self._answering(service.callback)
        self.guard_services()

    def _answering(self, change: Callable[..., Any]) -> Callable[..., Any]:
        def change_state(
            request: ChangeState.Request, response: ChangeState.Response
        ) -> ChangeState.Response:
            possible = {each[0]: each[1] for each in self._state_machine.available_transitions}
            asked = request.transition
            if asked.label not in ('', *possible.values()) or (
                not asked.label and asked.id not in possible
            ):
                self.get_logger().error(
                    f'choose one of {listing([*possible.values()])}: the node is {self.state}, '
                    f'from where there is no transition {one_line(asked.label or asked.id)}'
                )
                response.success = False
                return response
            return change(request, response)

        return change_state

    def _plant(self) -> str:
        return '' if self.estimation is None else self.estimation.model.name

    def _examine(self) -> Health:
        if self.estimation is not None:
            health = self.estimation.examine()
            for level, line in self._terminal.lines(health):
                log(self, level, line)
        else:
            health = not_configured(self.state, _words(self.trouble))
        return Health(health.level, health.message, {**health.figures, 'lifecycle': self.state})


def _words(error: Exception | None) -> str:
    """Return what is wrong in one line: a text for users as it is, of a defect its kind too."""
    if error is None:
        return ''
    return one_line(error) if isinstance(error, FAILURES) else quoted(error)


def main() -> int:
    """Run the estimator as a process."""
    return run('estimator', Estimator)


if __name__ == '__main__':
    sys.exit(main())
