"""The peers: other ways to estimate the states and parameters of a window, one small file each.

A peer prepares itself for a kind of window, which is timed apart (`prepare(problem)`), and returns
a function `solve(oracle, seed)`. It solves until the oracle stops it, or until it has no more to
try; or it returns a `Filtered`, when it does not minimise the squares at all.
"""

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.peers.problem import Filtered, Oracle, Problem

Solve = Callable[[Oracle, int], Filtered | None]
OURS = 'obs_ros'


@dataclass(frozen=True)
class Peer:
    """A peer's name, the package it needs (as imported), and `module:function` to prepare it.

    `slow`: it is given fewer windows. `filters`: it gives the end of the window only.
    """

    name: str
    package: str
    path: str
    slow: bool = False
    filters: bool = False

    @property
    def present(self) -> bool:
        """True if its package is installed."""
        return importlib.util.find_spec(self.package) is not None

    def prepare(self, problem: Problem) -> Solve:
        """Import it and make it ready for this kind of window."""
        module, _, function = self.path.partition(':')
        solver = importlib.import_module(f'benchmarks.peers.solvers.{module}')
        return getattr(solver, function)(problem)


PEERS = {
    peer.name: peer
    for peer in (
        Peer(OURS, 'obs_ros', 'ours:noise_unknown'),
        Peer('obs_ros, noise given', 'obs_ros', 'ours:noise_given'),
        Peer('scipy least_squares, 1 start', 'scipy', 'scipy_least_squares:once'),
        Peer('scipy least_squares, 1 start, batched', 'scipy', 'scipy_least_squares:once_batched'),
        Peer('scipy least_squares, restarts', 'scipy', 'scipy_least_squares:restarts'),
        Peer('scipy DE, solve_ivp', 'scipy', 'scipy_de:with_solve_ivp', slow=True),
        Peer('scipy DE, vectorised NumPy', 'scipy', 'scipy_de:vectorised', slow=True),
        Peer('pygmo de', 'pygmo', 'pygmo_de:de'),
        Peer('pygmo sade', 'pygmo', 'pygmo_de:sade'),
        Peer('pygmo de1220', 'pygmo', 'pygmo_de:de1220'),
        Peer('pymoo DE', 'pymoo', 'pymoo_de:prepare'),
        Peer('pycma', 'cma', 'pycma:prepare'),
        Peer('CasADi multiple shooting', 'casadi', 'casadi_shooting:prepare'),
        Peer('do-mpc MHE', 'do_mpc', 'do_mpc_mhe:prepare', slow=True),
        Peer('EKF (filterpy)', 'filterpy', 'kalman:extended', filters=True),
        Peer('UKF (filterpy)', 'filterpy', 'kalman:unscented', filters=True),
    )
}
