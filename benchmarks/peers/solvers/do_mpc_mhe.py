"""do-mpc's moving horizon estimator with the whole window as its horizon, solved by IPOPT once.

Its model is the same RK4 step, in discrete time and without process noise. It measures every sample
but the first, which goes into the arrival cost; so its optimum is everybody's. It starts, and asks
the oracle, as CasADi's multiple shooting does.
"""

import casadi
import do_mpc
import numpy as np

from benchmarks.peers.problem import Oracle, Problem
from benchmarks.peers.registry import Solve
from benchmarks.peers.solvers.casadi_shooting import IPOPT, Asking, first_states, functions


def prepare(problem: Problem) -> Solve:
    """Build the estimator."""
    return Estimator(problem).solve


class Estimator:
    """The moving horizon estimator of one kind of window; its unknowns are scaled by their box."""

    def __init__(self, problem: Problem) -> None:
        plant = scaled_plant(problem)
        mhe = do_mpc.estimator.MHE(plant, ['p'])
        mhe.settings.n_horizon = problem.record.t.size - 1
        mhe.settings.t_step = float(problem.record.t[1] - problem.record.t[0])
        mhe.settings.meas_from_data = True
        mhe.settings.store_full_solution = False
        gap = first_residuals(problem, mhe._x['x'], mhe._x_prev['x'])
        mhe.set_objective(0.5 * casadi.sumsqr(mhe._v.cat), 0.5 * casadi.sumsqr(gap))
        mhe.bounds['lower', '_p_est', 'p'] = 0.0
        mhe.bounds['upper', '_p_est', 'p'] = 1.0
        mhe.prepare_nlp()
        n, q = len(problem.model.states), len(problem.model.parameters)
        mhe.lb_opt_x['_x', 0] = np.zeros(n)
        mhe.ub_opt_x['_x', 0] = np.ones(n)
        constraints = sum(g.shape[0] for g in mhe._nlp_cons)
        self.asking = Asking((mhe.n_opt_x, constraints, mhe.n_opt_p), n, q)
        mhe.settings.nlpsol_opts = {
            **IPOPT,
            'print_time': False,
            'expand': True,
            'iteration_callback': self.asking,
        }
        mhe.create_nlp()
        self.mhe = mhe

    def solve(self, oracle: Oracle, seed: int) -> None:
        """Start again from random points until the oracle stops it."""
        problem, rng, mhe = oracle.problem, np.random.default_rng(seed), self.mhe
        self.asking.oracle = oracle
        n = len(problem.model.states)
        y = problem.record.y / problem.noise
        previous = np.zeros(n)
        previous[: y.shape[1]] = y[0]
        while True:
            x = first_states(problem, rng)
            mhe.opt_x_num['_x', :, -1] = list(x)
            mhe.opt_x_num['_p_est'] = rng.random(problem.d - n)
            mhe.opt_x_num['_v'] = 0.0
            mhe.opt_p_num['_x_prev'] = previous
            mhe.opt_p_num['_y_meas'] = list(y[1:])
            mhe.solve()
            oracle.check()


def scaled_plant(problem: Problem) -> do_mpc.model.Model:
    """Return the plant in discrete time: unknowns in the unit box, outputs in units of noise."""
    model, record = problem.model, problem.record
    n = len(model.states)
    low, width = problem.objective.unknowns.scale.lower, problem.width
    plant = do_mpc.model.Model('discrete', 'SX')
    x = plant.set_variable('_x', 'x', (n, 1))
    p = plant.set_variable('_p', 'p', (len(model.parameters), 1))
    states, values = low[:n] + width[:n] * x, low[n:] + width[n:] * p
    step, output = functions(model, record.u[0], float(record.t[1] - record.t[0]))
    plant.set_rhs('x', (step(states, values) - low[:n]) / width[:n])
    plant.set_meas('y', output(states, values) / problem.noise, meas_noise=True)
    plant.setup()
    return plant


def first_residuals(problem: Problem, x: casadi.SX, previous: casadi.SX) -> casadi.SX:
    """Return the residuals of the first sample, whose measurements lead `previous`."""
    n = len(problem.model.states)
    low, width = problem.objective.unknowns.scale.lower, problem.width
    _, output = functions(problem.model, problem.record.u[0], 1.0)
    outputs = output(low[:n] + width[:n] * x, np.zeros(len(problem.model.parameters)))
    return outputs / problem.noise - previous[: outputs.size1()]
