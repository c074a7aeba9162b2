"""The simulator node: plays a scenario live, as a plant that one can break while it runs."""

import math
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.parameter import Parameter
from rclpy.timer import Timer
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from obs_ros.core.model import names
from obs_ros.interface.bindings import Binding
from obs_ros.interface.status import Health, Level
from obs_ros.models import load_model
from obs_ros.ros.diagnostics import publish_health
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.info import model_info, publish_info, settings_info
from obs_ros.ros.message_types import message_type
from obs_ros.ros.messages import STREAM, named_vector, time_message
from obs_ros.ros.parameters import Parameters, given_at_start
from obs_ros.ros.run import run
from obs_ros.ros.streams import with_signals
from plant_sim.fault_settings import (
    actuators,
    check_faults,
    fault_parameters,
    instrument_parameters,
    plant_faults,
    sensors,
    told,
)
from plant_sim.plant_clock import PlantClock
from plant_sim.scenarios import load_scenario
from plant_sim.settings import CHOICE, COMMON, MOST_NAMES, check_rate
from plant_sim.simulation import Instant, Simulation


@dataclass(frozen=True)
class TimerSettings:
    """Wall times of the timer that plays the samples, in s."""

    shortest: float = 0.001  # from one tick to the next: more often, ticks themselves take the time
    longest: float = 0.01  # so that /clock runs on between samples that are far apart
    budget: float = 0.02  # spent on late samples before services get their turn


TIMER = TimerSettings()
READ = ('plant/output', 'plant/input')  # by an estimator
FURTHER = tuple(f'further_{i}' for i in range(1, MOST_NAMES + 1))  # names that nobody wants


class Simulator(GuardedNode):
    """Publishes outputs, inputs and the truth of a simulated plant, sample by sample.

    Outputs and inputs that parameters `signals.<name>` bind go out where the estimator of the same
    parameters reads them, as a rig would publish them. Stamps are plant time from 0 where /clock
    is published, else the wall time of the run's start plus plant time. `clock` gives the wall time
    (s) that plant time keeps up with. Raises ValueError when parameters given at start are wrong.
    """

    def __init__(self, *, clock: Callable[[], float] = time.monotonic, **options: Any) -> None:
        super().__init__(
            'simulator', automatically_declare_parameters_from_overrides=True, **options
        )
        self._wall_clock = clock
        parameters = Parameters(self, given_at_start(self))
        parameters.declare(CHOICE)
        self.scenario = load_scenario(str(parameters.values['scenario']))
        self.model = load_model(self.scenario.model)
        parameters.declare(COMMON)
        self.model, bound = with_signals(self, self.model, parameters)
        parameters.declare((*fault_parameters(self.model), *instrument_parameters(self.model)))
        self._settings: Mapping[str, Any] = parameters.values
        self._simulates_time = bool(
            self._settings['publish_clock'] or self._settings['speed'] != 1.0
        )
        self._names = {
            'plant/output': [n for n in names(self.model.outputs) if n not in bound],
            'plant/input': [n for n in names(self.model.inputs) if n not in bound],
            'plant/state': names(self.model.states),
            'plant/parameters': names(self.model.parameters),
        }
        self._publishers_of = {
            topic: self.create_publisher(JointState, topic, STREAM)
            for topic, order in self._names.items()
            if order
        }
        self._bound = _by_topic(bound.values())
        for topic, (kind, _) in self._bound.items():
            self._publishers_of[topic] = self.create_publisher(kind, topic, STREAM)
        self._clock_publisher = (
            self.create_publisher(ClockMessage, '/clock', 10) if self._simulates_time else None
        )
        self._publish_info = publish_info(self)
        self._restart()
        parameters.watch(self._propose, self._adopt)
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(SetBool, '~/enable', self._on_enable)
        self._examined = time.monotonic(), 0, 0.0
        publish_health(self, lambda: self.model.name, self._examine)
        self.get_logger().info(
            f'playing {self.scenario.name}: a sample every {self._simulation.period:g} s of plant '
            f'time, {self._settings["speed"]:g} times real time'
            f'{"" if self._settings["enabled"] else ", paused"}'
        )

    def _restart(self) -> None:
        """Begin the scenario again, with the settings as they are now."""
        settings = self._settings
        self._simulation = Simulation(
            self.scenario,
            model=self.model,
            period=1.0 / settings['rate'] if settings['rate'] else None,
            seed=settings['seed'],
            noise_reference=settings['noise_reference'],
        )
        self._break(settings)
        self._epoch = 0 if self._simulates_time else time.time_ns()
        self.sent = 0
        self._examined = time.monotonic(), 0, 0.0
        self._plant_clock = PlantClock(settings['speed'], self._wall_clock)

    def _snr_db(self, settings: Mapping[str, Any]) -> float:
        snr_db = float(settings['snr_db'])
        return self.scenario.snr_db if math.isnan(snr_db) else snr_db

    def _break(self, settings: Mapping[str, Any]) -> None:
        """Let plant, sensors and actuators be as bad as the settings say."""
        self._simulation.faults = plant_faults(settings)
        self._simulation.sensors = sensors(self.model, settings)
        self._simulation.actuators = actuators(self.model, settings)
        self._simulation.snr_db = self._snr_db(settings)

    def _propose(self, values: Mapping[str, Any]) -> Mapping[str, Any]:
        if values['speed'] != 1.0 and not self._simulates_time:
            raise ValueError(
                'stamps are wall time here, so speed must stay 1: start with publish_clock true '
                'to change it while running'
            )
        check_rate(self.scenario, self.model, values)
        rate = values['rate'] or 1.0 / self.scenario.sample_period
        # The run goes on at the rate that it began with until ~/reset.
        check_faults(self.model, values, min(1.0 / rate, self._simulation.period))
        return values

    def _adopt(self, values: Mapping[str, Any]) -> None:
        if values['speed'] != self._settings['speed']:
            self._plant_clock.change(
                values['speed'], min(self._plant_clock.now(), self._simulation.t)
            )
        if values['enabled'] and not self._settings['enabled']:
            # The plant stood still meanwhile, and so did its time.
            self._plant_clock.hold(self._simulation.t)
        self._settings = values
        self._break(values)
        self._publish_info({
            'scenario': self.scenario.name,
            **model_info(self.model),
            'sample_period': self._simulation.period,
            'duration': self.scenario.duration,
            'stamps': 'plant time' if self._simulates_time else 'wall time',
            **settings_info(values),
        })  # fmt: skip
        self._schedule()

    def _schedule(self) -> None:
        """Let a timer tick at every sample, in time with them, or so often that none waits."""
        interval = self._simulation.period / self._settings['speed']
        tick = max(interval / math.ceil(interval / TIMER.longest), TIMER.shortest)
        timer: Timer | None = getattr(self, '_timer', None)
        if timer is not None and timer.timer_period_ns == int(tick * 1e9):
            return
        if timer is not None:
            self.destroy_timer(timer)
        # Not the node's clock: that may be the very /clock published here.
        self._timer = self.create_timer(
            tick, self._tick, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _tick(self) -> None:
        if not self._settings['enabled']:
            return
        started, simulation = time.monotonic(), self._simulation
        while simulation.t <= self._plant_clock.now() and time.monotonic() - started < TIMER.budget:
            self._publish(simulation.sample())
        self._plant_clock.yield_to(simulation.t)
        if self._clock_publisher:
            # In between, time runs on, but never into the next sample.
            self._publish_clock(min(self._nanoseconds(self._plant_clock.now()),
                                    self._nanoseconds(simulation.t) - 1))  # fmt: skip

    def _publish(self, instant: Instant) -> None:
        stamp = self._nanoseconds(instant.t)
        if self._clock_publisher:
            self._publish_clock(stamp)
        measured = dict(zip(names(self.model.outputs), instant.y, strict=True))
        applied = dict(zip(names(self.model.inputs), instant.u, strict=True))
        for topic, values in (
            ('plant/state', dict(zip(names(self.model.states), instant.x, strict=True))),
            ('plant/parameters', dict(zip(names(self.model.parameters), instant.p, strict=True))),
            ('plant/input', applied),
            ('plant/output', measured),
        ):
            if order := self._names[topic]:
                further = FURTHER[: self._settings['further_names']] if topic in READ else ()
                numbers = [*(0.0 for _ in further), *(values[name] for name in order)]
                message = named_vector(stamp, (*further, *order), numbers)
                self._publishers_of[topic].publish(message)
        for topic, (kind, bound) in self._bound.items():
            message = kind()
            if hasattr(message, 'header'):
                message.header.stamp = time_message(stamp)
            for binding in bound:
                value = {**measured, **applied}[binding.name]
                binding.path.write(message, (value - binding.offset) / binding.scale)
            self._publishers_of[topic].publish(message)
        self.sent += 1

    def _publish_clock(self, stamp: int) -> None:
        assert self._clock_publisher is not None
        self._clock_publisher.publish(ClockMessage(clock=time_message(stamp)))

    def _nanoseconds(self, t: float) -> int:
        return self._epoch + round(t * 1e9)

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._restart()
        self._schedule()
        response.success, response.message = True, f'{self.scenario.name} starts again'
        return response

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self.set_parameters([Parameter('enabled', value=request.data)])
        response.success = True
        response.message = 'running' if request.data else 'paused'
        return response

    def _examine(self) -> Health:
        (since, before, lag), now = self._examined, time.monotonic()
        self._examined = now, self.sent, self._plant_clock.lag
        rate = (self.sent - before) / (now - since)
        wanted = self._settings['speed'] / self._simulation.period
        figures: dict[str, object] = {
            'scenario': self.scenario.name,
            'plant_time_s': max(0.0, self._simulation.t - self._simulation.period),
            'samples': self.sent,
            'rate_hz': rate,
            'wanted_rate_hz': wanted,
            'lag_s': self._plant_clock.lag,
            'faults': told(self.model, self._settings),
        }
        if not self._settings['enabled']:
            return Health(Level.WARN, 'paused: call ~/enable with true to go on', figures)
        if self._plant_clock.lag > lag:
            message = f'cannot keep up: {rate:.0f} of {wanted:.0f} samples/s; lower speed or rate'
            return Health(Level.WARN, message, figures)
        return Health(Level.OK, f'playing {self.scenario.name}', figures)


def _by_topic(bound: Iterable[Binding]) -> dict[str, tuple[type, list[Binding]]]:
    """Return the message type of each topic, and what is written into its messages."""
    topics: dict[str, tuple[type, list[Binding]]] = {}
    for binding in bound:
        topics.setdefault(binding.topic, (message_type(binding.type), []))[1].append(binding)
    return topics


def main() -> int:
    """Run the simulator as a process."""
    return run('simulator', Simulator)


if __name__ == '__main__':
    sys.exit(main())
