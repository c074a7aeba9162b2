"""Multiple shooting in CasADi, solved by IPOPT: the states at every sample are unknowns too.

States start at the measurements where they are measured, else anywhere, which is what multiple
shooting is liked for; parameters start anywhere. At every iterate the oracle is asked, with a
rollout from its initial states. Where IPOPT gives up, it starts again from elsewhere.
"""

from typing import Any

import casadi
import numpy as np

from benchmarks.peers.problem import Oracle, Problem, Stopped
from benchmarks.peers.registry import Solve
from obs_ros import Model
from obs_ros.core.typing import Array
from obs_ros.integration.steps import STEPS

MAX_ITERATIONS = 300
IPOPT = {'ipopt.print_level': 0, 'ipopt.sb': 'yes', 'ipopt.max_iter': MAX_ITERATIONS}


def prepare(problem: Problem) -> Solve:
    """Build the program and its derivatives."""
    return Program(problem).solve


class Asking(casadi.Callback):
    """Asks the oracle at IPOPT's iterates; which begin with x0 (n,) and end with p (q,)."""

    def __init__(self, sizes: tuple[int, int, int], n: int, q: int) -> None:
        super().__init__()
        self.sizes, self.n, self.q = sizes, n, q
        self.oracle: Oracle | None = None
        self.construct('asking', {})

    # do-mpc copies its settings, and this with them.
    def __deepcopy__(self, memo: object) -> 'Asking':
        return self

    def get_n_in(self) -> int:
        return casadi.nlpsol_n_out()

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return casadi.nlpsol_out(i)

    def get_sparsity_in(self, i: int) -> casadi.Sparsity:
        variables, constraints, parameters = self.sizes
        size = {'f': 1, 'x': variables, 'lam_x': variables, 'lam_p': parameters}
        return casadi.Sparsity.dense(size.get(casadi.nlpsol_out(i), constraints))

    def eval(self, given: Any) -> list[int]:
        """Return [1] to stop IPOPT."""
        w = np.array(given[0]).ravel()
        point = np.concatenate([w[: self.n], w[w.size - self.q :]])
        try:
            self.oracle.costs(np.clip(point, 0.0, 1.0)[None])
        except Stopped:
            return [1]
        return [0]


class Program:
    """The nonlinear program of one kind of window; its unknowns are scaled by their box."""

    def __init__(self, problem: Problem) -> None:
        model, record = problem.model, problem.record
        n, q, k = len(model.states), len(model.parameters), record.t.size
        low, width = problem.objective.unknowns.scale.lower, problem.width
        x, p = casadi.MX.sym('x', n, k), casadi.MX.sym('p', q)
        y = casadi.MX.sym('y', record.y.shape[1], k)
        states = low[:n] + width[:n] * x
        values = casadi.repmat(low[n:] + width[n:] * p, 1, k)
        step, output = functions(model, record.u[0], float(record.t[1] - record.t[0]))
        after = step.map(k - 1)(states[:, :-1], values[:, :-1])
        gaps = (after - states[:, 1:]) / width[:n]
        residuals = (output.map(k)(states, values) - y) / problem.noise
        w = casadi.vertcat(casadi.vec(x), p)
        program = {
            'x': w,
            'p': casadi.vec(y),
            'f': 0.5 * casadi.sumsqr(residuals),
            'g': casadi.vec(gaps),
        }
        self.asking = Asking((w.size1(), gaps.numel(), y.numel()), n, q)
        self.solver = casadi.nlpsol(
            'solver',
            'ipopt',
            program,
            {**IPOPT, 'print_time': False, 'expand': True, 'iteration_callback': self.asking},
        )

    def solve(self, oracle: Oracle, seed: int) -> None:
        """Start again from random points until the oracle stops it."""
        problem, rng = oracle.problem, np.random.default_rng(seed)
        n, k = len(problem.model.states), problem.record.t.size
        lower, upper = np.full(n * k, -np.inf), np.full(n * k, np.inf)
        lower[:n], upper[:n] = 0.0, 1.0
        q = problem.d - n
        self.asking.oracle = oracle
        while True:
            self.solver(
                x0=np.concatenate([first_states(problem, rng).ravel(), rng.random(q)]),
                p=problem.record.y.ravel(),
                lbx=np.concatenate([lower, np.zeros(q)]),
                ubx=np.concatenate([upper, np.ones(q)]),
                lbg=0.0,
                ubg=0.0,
            )
            oracle.check()


def functions(model: Model, u: Array, h: float) -> tuple[casadi.Function, casadi.Function]:
    """Return x, p -> the next x, by the model's own step, and x, p -> y; inputs are steady."""
    x, p = (casadi.SX.sym(s, len(v)) for s, v in (('x', model.states), ('p', model.parameters)))
    xs, ps, us = tuple(casadi.vertsplit(x)), tuple(casadi.vertsplit(p)), tuple(u)
    following = STEPS[model.method](model.dynamics, 0.0, h, xs, us, us, us, ps)
    outputs = model.output(0.0, xs, us, ps)
    return (
        casadi.Function('step', [x, p], [casadi.vertcat(*following)]),
        casadi.Function('output', [x, p], [casadi.vertcat(*outputs)]),
    )


def first_states(problem: Problem, rng: np.random.Generator) -> Array:
    """Return scaled states (K, n) to start from: measured ones as measured, others anywhere."""
    model = problem.model
    n = len(model.states)
    x = np.tile(rng.random(n), (problem.record.t.size, 1))
    for i, variable in enumerate(model.states):
        for j, output in enumerate(model.outputs):
            if output.name == variable.name:
                width = variable.upper - variable.lower
                x[:, i] = (problem.record.y[:, j] - variable.lower) / width
    x[0] = np.clip(x[0], 0.0, 1.0)
    return x
