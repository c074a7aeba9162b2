"""Wrapped angles beside the same ones unwrapped: a simulated heading, and a recorded car's."""

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.play import followed
from benchmarks.recordings import part
from benchmarks.report import Requirement, table
from benchmarks.sensors.attempts import attempted, carried_out, failures, judged
from benchmarks.sensors.solved import Solved, alone
from benchmarks.sensors.spring import Run, run_of
from obs_ros import Model, Record, Sample, Variable
from obs_ros.core.typing import Array
from obs_ros.observers.base import load_observer
from plant_sim.scenario import Scenario
from plant_sim.sensors import Sensor
from plant_sim.signals import Signal, constant
from plant_sim.simulation import Simulation

TURN = 2.0 * math.pi
NOISE = 0.01  # rad
INTERVAL, SAMPLES = 0.02, 200  # s, in a window
SAME = 1e-3  # standard deviations between the parameters of wrapped and unwrapped windows
FILTERS = ('ekf', 'ukf')
# Times the error of the unwrapped angle. Filters take how little is known of a start, and how far
# the model may err, from bounds, a turn wide or many: both are given the same by hand.
FILTERED = 1.001
START_SD, WALK = 0.3, 1e-3  # rad, rad/sqrt(s)
RECORDING, WINDOW = 'car_yaw.csv', 3.0  # s
WAYS = ('wrapped', 'unwrapped')


def heading_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of a ship's heading and turn."""
    return x[1], p[0] * u[0] - p[1] * x[1]


def yaw_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the yaw rate of a kinematic single track."""
    return (p[0] * u[1] * np.tan(u[0] + p[1]),)


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the angle."""
    return (x[0],)


HEADING = Model(
    name='benchmark_heading',
    states=(
        Variable('yaw', 'rad', lower=-100.0, upper=100.0),
        Variable('rate', 'rad/s', lower=-30.0, upper=30.0),
    ),
    inputs=(Variable('rudder', '1/s2'),),
    outputs=(Variable('angle', 'rad'),),
    parameters=(
        Variable('gain', lower=0.1, upper=5.0),
        Variable('damping', '1/s', lower=0.05, upper=5.0),
    ),
    dynamics=heading_dynamics,
    output=output,
    max_step=0.02,
)
CAR = Model(
    name='benchmark_yaw',
    states=(Variable('yaw', 'rad', lower=-20.0, upper=20.0),),
    inputs=(Variable('steer', 'rad'), Variable('vx', 'm/s')),
    outputs=(Variable('angle', 'rad'),),
    parameters=(
        Variable('gain', '1/m', lower=0.1, upper=10.0),
        Variable('offset', 'rad', lower=-0.2, upper=0.2),
    ),
    dynamics=yaw_dynamics,
    output=output,
    max_step=0.02,
)
# Start: yaw and rate; the rudder in one direction and in both.
SCENES: Mapping[str, tuple[float, float, float, float]] = {
    'crossing': (math.pi - 0.8, 0.4, 0.5, 0.6),
    'hovering at pi': (math.pi, 0.0, 0.0, 0.15),
    'many turns': (0.0, 8.0, 8.0, 2.0),
}


def periodic(model: Model) -> Model:
    """Return a model whose first state and output wrap."""
    first, *others = model.states
    yaw = replace(first, lower=-math.pi, upper=math.pi, period=TURN)
    return replace(
        model,
        states=(yaw, *others),
        outputs=[replace(v, period=TURN) for v in model.outputs],
    )


def rudder(rng: np.random.Generator, steady: float, swing: float) -> Signal:
    """Return an input that changes between two levels at random times."""
    ends = np.cumsum(rng.uniform(0.3, 0.8, size=40)).round(2) - 0.5 * INTERVAL
    return lambda t: (steady + swing * (1.0 - 2.0 * (int(np.searchsorted(ends, t)) % 2)),)


def sailed(scene: str, seed: int, *, wrapped: bool) -> Run:
    """Return the run of that seed by the simulator, whose sensor wraps or not."""
    rng = np.random.default_rng([seed, SAMPLES])
    yaw, rate, steady, swing = SCENES[scene]
    gain, damping = rng.uniform((0.8, 0.5), (1.2, 1.0)).tolist()
    scenario = Scenario(
        name='heading',
        model=f'{__name__}:HEADING',
        initial_state=(yaw, rate),
        inputs=rudder(rng, steady, swing),
        parameters=constant(gain, damping),
        sample_period=INTERVAL,
        duration=INTERVAL * SAMPLES,
        snr_db=-20.0 * math.log10(NOISE),
    )
    simulation = Simulation(scenario, seed=seed)
    simulation.sensors = {'angle': Sensor(period=TURN)} if wrapped else {}
    instants = [simulation.sample() for _ in range(SAMPLES)]
    return run_of(instants, {'gain': gain, 'damping': damping})


def shifted(record: Record) -> Record:
    """Return the record without wraps, its start by whole turns in [-pi, pi)."""
    y = np.unwrap(record.y, axis=0)
    return record.with_outputs(y - TURN * np.floor(y[0] / TURN + 0.5))


def heading(scene: str, way: str, seed: int) -> Solved:
    """Solve a window of a heading with its wraps declared, or without any."""
    drawn = sailed(scene, seed, wrapped=way == 'wrapped')
    return _solved(HEADING, drawn.record, drawn.truth, way, seed, {'angle': NOISE})


def car(folder: str, way: str, start: float) -> Solved:
    """Solve a window of the recorded car likewise."""
    whole = recorded_yaw(Path(folder))
    window = part(whole, start, start + WINDOW)
    unknown = {'gain': np.nan, 'offset': np.nan}
    return _solved(CAR, window, unknown, way, 1, None)


def _solved(
    model: Model,
    record: Record,
    truth: Mapping[str, float],
    way: str,
    seed: int,
    noise: Mapping[str, float] | None,
) -> Solved:
    if way == 'wrapped':
        return alone(periodic(model), record, truth, seed, noise=noise)
    return alone(model, shifted(record), truth, seed, noise=noise)


@functools.cache
def recorded_yaw(folder: Path) -> Record:
    """Return the whole recording of the car's yaw, wrapped as it is."""
    rows = np.genfromtxt(folder / RECORDING, delimiter=',', names=True)
    return Record(rows['t'], np.column_stack([rows['steer'], rows['vx']]), rows['yaw'])


def filtered(scene: str, name: str, way: str, seed: int) -> float:
    """Return the root mean square error (rad) of a filter's yaw, the shortest way round."""
    wrapped = way == 'wrapped'
    drawn = sailed(scene, seed, wrapped=wrapped)
    observer: Any = load_observer(name)
    made = observer(
        periodic(HEADING) if wrapped else HEADING,
        noise={'angle': NOISE},
        priors={'yaw': (SCENES[scene][0], START_SD)},
        walks={'yaw': WALK},
    )
    record = drawn.record
    samples = [
        Sample(round(t * 1e9), y=y, u=u)
        for t, u, y in zip(record.t, record.u, record.y, strict=True)
    ]
    estimates, _ = followed(made, samples)
    off = np.array([one.state['yaw'] for one in estimates]) - drawn.x[:, 0]
    off -= TURN * np.round(off / TURN)
    return float(np.sqrt(np.mean(off[SAMPLES // 2 :] ** 2)))


def measured(runs: int, seed: int, folder: Path) -> tuple[list[Requirement], str]:
    """Solve so many windows of each scene, all of the recording; return rows and table."""
    for way in WAYS:
        attempted(heading, 'crossing', way, seed)  # compiles here, so that workers find it cached
    seeds = range(seed, seed + runs)
    cells: dict[tuple[str, str], list[Any]] = dict(
        carried_out(
            heading,
            {(scene, way): [(scene, way, each) for each in seeds] for scene in SCENES
             for way in WAYS}, 'headings',
        )
    )  # fmt: skip
    filters = carried_out(
        filtered,
        {(scene, name, way): [(scene, name, way, each) for each in seeds] for scene in SCENES
         for name in FILTERS for way in WAYS}, 'filters',
    )  # fmt: skip
    if (folder / RECORDING).is_file():
        t = recorded_yaw(folder).t
        starts = np.arange(t[0], t[-1] - WINDOW, WINDOW).tolist()
        cells |= carried_out(
            car,
            {(RECORDING, way): [(str(folder), way, start) for start in starts] for way in WAYS},
            'car',
        )
    return [*_rows(cells), *_filters(filters)], _table(cells)


def _rows(cells: Mapping[tuple[str, str], list[Any]]) -> Iterator[Requirement]:
    for scene in dict.fromkeys(scene for scene, _ in cells):
        wrapped, unwrapped = (cells[scene, way] for way in WAYS)

        def near(_: list[Any], own: Any = wrapped, other: Any = unwrapped) -> tuple[str, bool]:
            off = apart(own, other)
            return f'worst {off.max():.1e} of {off.size} windows', bool(off.max() <= SAME)

        yield judged(
            f'{scene}, wrapped: parameters of the unwrapped windows to {SAME:g} sd',
            [*wrapped, *unwrapped], near,
        )  # fmt: skip
        yield judged(f'{scene}, wrapped: published angles lie in [-pi, pi)', wrapped, _inside)


def apart(own: list[Solved], other: list[Solved]) -> Array:
    """Return by window the largest distance of parameters in deviations, of those determined.

    A window that only one of both determines is infinitely far.
    """
    distances = []
    for one, two in zip(own, other, strict=True):
        given = np.isfinite(one.sd), np.isfinite(two.sd)
        same = bool((given[0] == given[1]).all())
        off = np.abs(one.values - two.values)[given[1]] / two.sd[given[1]]
        distances.append(float(off.max(initial=0.0)) if same else np.inf)
    return np.array(distances)


def _inside(windows: list[Solved]) -> tuple[str, bool]:
    angles = np.array([one.state[0] for one in windows])
    inside = bool(((angles >= -math.pi) & (angles < math.pi)).all())
    return f'{angles.min():.3f} to {angles.max():.3f}', inside


def _filters(cells: Mapping[tuple[str, str, str], list[Any]]) -> Iterator[Requirement]:
    for scene in SCENES:
        for name in FILTERS:
            own, other = (cells[scene, name, way] for way in WAYS)

            def ratio(_: list[Any], own: Any = own, other: Any = other) -> tuple[str, bool]:
                found = math.sqrt(np.mean(np.square(own)) / np.mean(np.square(other)))
                return f'{found:.6f}', 1.0 / FILTERED <= found <= FILTERED

            asked = (
                f'{scene}, {name}: error of the yaw within {FILTERED:g} x that of unwrapped angles'
            )
            yield judged(asked, [*own, *other], ratio)


def _table(cells: Mapping[tuple[str, str], list[Any]]) -> str:
    rows = []
    for (scene, way), windows in cells.items():
        if not failures(windows):
            good = sum(one.accepted for one in windows)
            outcomes = sorted({one.outcome for one in windows})
            rows.append({
                'scene': scene, 'angles': way, 'windows': len(windows), 'accepted': good,
                'outcomes': ', '.join(outcomes),
                'ms': f'{1e3 * np.median([one.seconds for one in windows]):.1f}',
            })  # fmt: skip
    return table(rows)
