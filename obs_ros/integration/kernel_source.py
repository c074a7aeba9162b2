"""The text of the generated modules: sizes and tuple functions of a model, then its kernels."""

import math

import numba

from obs_ros.core.model import Model
from obs_ros.core.periods import periods
from obs_ros.core.saturation import has_range, ranges
from obs_ros.integration.delayed import delay_names
from obs_ros.integration.filter_pass import DIFFERENCE, central
from obs_ros.integration.path import LANES, REGISTER, lanes
from obs_ros.integration.rosenbrock_source import method_texts, own_steps_texts, text_in

BLOCK_VALUES = 4096  # 32 kB: the outputs of one time block stay in the first-level cache
LEAST_ROWS = 128  # of outputs in a block: sums over fewer take longer
MORE_COLUMNS = 3  # of zeros: products are taken of two by four columns

# Products may be fused, reciprocals taken and the sign of zero lost; NaN and infinity must survive,
# since a diverged candidate is known by them.
FASTMATH = {'contract', 'arcp', 'nsz'}

# Differences of outputs as in `core/periods.shortest`; without periods nothing is left of them.
SHORTEST = """@jit
def shortest(difference, period):
    if period > 0.0:
        return difference - period * np.floor(difference / period + 0.5)
    return difference
"""
STRAIGHT = """@jit
def shortest(difference, period):
    return difference
"""


def source(model: Model) -> str:
    """Text of the generated module: sizes and tuple functions of the model, then the kernels."""
    more = 'kernels_delayed.py' if delay_names(model) else 'kernels_injected.py'
    names = 'kernels.py', 'kernels_grams.py', 'kernels_one_step.py', more
    return '\n\n'.join([text_of(model, *names), *own_steps_texts(model)])


def filter_source(model: Model, d: int) -> str:
    """Text of the module of a filter of d states and moving parameters."""
    points = 1 + (2 * d if central(d) else d)
    chunks = lanes(points) // LANES
    sizes = f'N_JOINT, N_CHUNKS, CENTRAL, DIFFERENCE = {d}, {chunks}, {central(d)}, {DIFFERENCE}'
    sizes += f'\nN_POINTS = {points}'
    return f'{text_of(model, "kernels.py", "kernels_filter.py")}\n{sizes}\n'


def text_of(model: Model, *names: str) -> str:
    """Text of a module with the kernels of these files."""
    return '\n\n'.join([header(model), *map(text_in, names), *method_texts(model)])


def header(model: Model) -> str:
    """Sizes, and the tuple functions unrolled for them: loops over tuples would not compile."""
    n, m = len(model.states), len(model.inputs)
    r, q = len(model.outputs), len(model.parameters)

    def returning(signature: str, entry: str, count: int) -> str:
        entries = ''.join(entry.replace('#', str(i)) + ', ' for i in range(count))
        return f'@jit\ndef {signature}:\n    return ({entries})\n'

    def doing(signature: str, line: str, count: int) -> str:
        lines = ''.join(f'    {line.replace("#", str(i))}\n' for i in range(count))
        return f'@jit\ndef {signature}:\n{lines or "    pass"}'

    at = 'a[ROW# + lane]'
    clip = 'max(min(x[#], high[#]), low[#])'  # in this order NaN stays NaN
    late = 'u[k, #, lane] + s * slope[k, #, lane]'
    between = 'a * x[k, #, lane] + b * x[k + 1, #, lane] + c * v[k, #, lane] + d * w[k, #, lane]'
    turns = periods(model.outputs).tolist()
    squares = ''.join(f'    {squared(i, turn > 0.0)}\n' for i, turn in enumerate(turns))
    low, high = (tuple(ends.tolist()) for ends in ranges(model.outputs))
    return '\n'.join(
        [
            f'# Numba {numba.__version__}, {sorted(FASTMATH)}',
            'import numpy as np\n',
            f'N_STATES, N_OUTPUTS, N_PARAMETERS, N_LANES = {n}, {r}, {q}, {LANES}',
            f'LANES, BLOCK_VALUES = np.uint64({LANES}), {BLOCK_VALUES}',
            f'LEAST_ROWS, MORE_COLUMNS = {LEAST_ROWS}, {MORE_COLUMNS}',
            f'REST, WHOLE = np.uint64({REGISTER - 1}), np.uint64({2 * LANES - REGISTER})',
            *(f'ROW{i} = np.uint64({i * LANES})' for i in range(max(n, m, r, q))),
            f'PERIODS, PERIODIC = {tuple(turns)}, {any(turns)}',
            f'RANGED, inf = {has_range(model.outputs)}, np.inf',
            f'LOW, HIGH = {low}, {high}',
            f'DISCRETE = {model.kind == "discrete"}\n',
            SHORTEST if any(turns) else STRAIGHT,
            shown(model),
            returning('gather_x(a, lane)', at, n),
            returning('gather_p(a, lane)', at, q),
            doing('scatter_x(a, lane, x)', f'{at} = x[#]', n),
            doing('scatter_y(a, lane, y)', f'{at} = y[#]', r),
            doing('put_x(a, k, lane, x)', 'a[k, #, lane] = x[#]', n),
            doing('put_y(a, k, lane, y)', 'a[k, #, lane] = y[#]', r),
            doing('put_lane(a, lane, x)', 'a[#, lane] = x[#]', n),
            doing('put_outputs(a, lane, y)', 'a[#, lane] = y[#]', r),
            doing('put_rows(a, row, lane, y, w, k)', 'a[row + #, lane] = y[#] * w[k, #]', r),
            f'@jit\ndef add_squares(a, lane, yhat, y, weight, period, k):\n{squares}',
            corrections(model),
            returning('input_at(u, slope, k, s)', 'u[k, #] + s * slope[k, #]', m),
            returning('late_input(u, slope, k, lane, s)', late, m),
            returning('track_at(track, k, lane)', 'track[k, #, lane]', n),
            returning('hermite_at(x, v, w, k, lane, a, b, c, d)', between, n),
            doing('put_entry(a, k, i, lane, y)', 'if i == #: a[k, #, lane] = y[#]', r),
            returning('inputs(u)', 'u[#]', m),
            returning('inputs_at(u, k)', 'u[k, #]', m),
            returning('clipped(x, low, high)', clip, n),
            returning('axpy(x, a, k)', 'x[#] + a * k[#]', n),
            returning(
                'rk4_sum(x, h, a, b, c, d)', 'x[#] + h * (a[#] + 2.0 * (b[#] + c[#]) + d[#])', n
            ),
        ]
    )


def shown(model: Model) -> str:
    """Text of `shown`: outputs at node k as the sensors show them where these are saturated."""
    entries = ''.join(f'{_shown(model, i, f"yhat[{i}]", f"y[k, {i}]")}, '
                      for i in range(len(model.outputs)))  # fmt: skip
    return f'@jit\ndef shown(yhat, y, k):\n    return ({entries})\n'


def _shown(model: Model, i: int, output: str, measured: str) -> str:
    """Text of output i as its sensor shows it beside what that measured; NaN stays NaN."""
    low, high = model.outputs[i].range or (-math.inf, math.inf)
    if math.isfinite(high):
        output = f'min({output}, {high!r} if {measured} >= {high!r} else inf)'
    if math.isfinite(low):
        output = f'max({output}, {low!r} if {measured} <= {low!r} else -inf)'
    return output


def squared(i: int, wraps: bool) -> str:
    """Text that adds the squared scaled residual of output i to its sum."""
    residual = f'yhat[{i}] - y[k, {i}]'
    residual = f'shortest({residual}, period[{i}])' if wraps else residual
    return f'a[ROW{i} + lane] += (weight[k, {i}] * ({residual})) ** 2'


def corrections(model: Model) -> str:
    """Text of the updates of all states by all outputs, one after the other; see `Injection`.

    `node_at` loads the numbers of a node, once for all lanes; `corrected` returns a candidate's
    states after the updates, its outputs such that y - outputs are the innovations, and these.
    """
    n, r = len(model.states), len(model.outputs)
    numbers: dict[str, int] = {}

    def number(entry: str) -> str:
        return f'node[{numbers.setdefault(entry, len(numbers))}]'

    lines, n, r = [], len(model.states), len(model.outputs)
    for i, variable in enumerate(model.outputs):
        cross = ''.join(f' + {number(f"cross[k, {i}, {j}]")} * e{j}' for j in range(i))
        y, weight = number(f'y[k, {i}]'), number(f'weight[k, {i}]')
        error = f'{y} - h{i}'
        if variable.period:
            error = f'shortest({error}, {number(f"period[{i}]")})'
        lines.append(f'    h{i} = yhat[{i}]{cross}')
        if variable.range is not None:
            lines.append(f'    h{i} = {_shown(model, i, f"h{i}", y)}')
        lines.append(f'    e{i} = {error} if {weight} != 0.0 else 0.0')
        if variable.period:
            lines.append(f'    h{i} = {y} - e{i} if {weight} != 0.0 else h{i}')
    states = [
        f'x[{s}]' + ''.join(f' + {number(f"gain[k, {i}, {s}]")} * e{i}' for i in range(r))
        for s in range(n)
    ]
    parts = states, [f'h{i}' for i in range(r)], [f'e{i}' for i in range(r)]
    return '\n'.join(
        [
            '@jit\ndef node_at(y, weight, period, gain, cross, k):',
            f'    return ({", ".join(numbers)},)\n',
            '@jit\ndef corrected(x, yhat, node):',
            *lines,
            '    return ' + ', '.join(f'({", ".join(part)},)' for part in parts) + '\n',
        ]
    )
