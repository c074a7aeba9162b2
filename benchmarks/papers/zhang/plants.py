"""The heat exchanger in short cases of the same truth as the scenarios of Zhang et al. 2020."""

import functools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.play import columns, played
from obs_ros.core.typing import Array
from obs_ros.models import heat_exchanger as plant
from plant_sim.scenario import Scenario
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import AT_REST, NOMINAL, VALVE_FAULTS
from plant_sim.signals import Schedule

NOISE_TIME = 0.1  # s, correlation of the noise
SETTLED = 3.0  # s, end of the runs from random starts
CLOGGED, HARDENED = VALVE_FAULTS.parameters(80.0), VALVE_FAULTS.parameters(150.0)  # of case 2


class Case(NamedTuple):
    """A case: when its fault comes (0: none), its end and from when on errors count, in s."""

    label: str
    fault: float
    end: float
    counted: float


COLD = Case('case 1', 0.0, 12.0, 8.0)
# Case 2, from 3 and 6 s before each fault on: the process valve is watched after a fault of the
# other one, which a slow observer must have got over.
UTILITY = Case('case 2, utility valve', 3.0, 9.0, 7.0)
PROCESS = Case('case 2, process valve', 6.0, 12.0, 10.0)
CALM = Case('case 2, before the faults', 0.0, 8.0, 4.0)
MOVING = Case('case 3', 0.0, 30.0, 10.0)
FAULTS = (UTILITY, PROCESS)
CASES = (COLD, *FAULTS)


def scenario_of(case: Case) -> Scenario:
    """Return the scenario of a case."""
    if case.label == COLD.label:
        return load_scenario('heat_exchanger_case1')
    if case == MOVING:
        return load_scenario('heat_exchanger_case3')
    before, after = (CLOGGED, HARDENED) if case == PROCESS else (NOMINAL, CLOGGED)
    at = case.fault if case in FAULTS else 2.0 * case.end
    return replace(
        VALVE_FAULTS,
        initial_state=(*steady(before), *AT_REST),
        parameters=Schedule((0.0, at), (before, after)),
    )


@functools.cache
def truth_of(case: Case) -> tuple[Array, Array, Array, Array]:
    """Times (K,), inputs, temperatures without noise and true flows (K, 2) of a case."""
    scenario = scenario_of(case)
    rows = played(scenario, round(case.end / scenario.sample_period) + 1, snr_db=math.inf)
    flows = [[plant.flow2(i.p[1], i.x[4]), plant.flow1(i.p[0], i.x[2])] for i in rows]
    t, u, y = columns(rows, 'tuy')
    return t, u, y, np.array(flows)


def steady(p: Sequence[float]) -> tuple[float, float]:
    """Return Tp and Tu (degC) at rest, from eq. 42-43 with parameters p and nominal pressures."""
    pressures = (v.nominal or 0.0 for v in plant.HEAT_EXCHANGER.inputs)
    x1, x2 = (plant.DIAPHRAGM_AREA * pc / k for pc, k in zip(pressures, p[2:], strict=True))
    washed = float(plant.flow2(p[1], x2)) / plant.VP, float(plant.flow1(p[0], x1)) / plant.VU
    A = [[plant.AP + washed[0], -plant.AP], [-plant.AU, plant.AU + washed[1]]]
    tp, tu = np.linalg.solve(A, [plant.TPI * washed[0], plant.TUI * washed[1]])
    return float(tp), float(tu)


def flow_ratio() -> tuple[float, float]:
    """Return Fu / Fp that one Cv for both valves gives with the printed constants, and the print's.

    Section 4.1.1 at rest: F = Cv sqrt(dP) Aa pc / k.
    """
    pc1, pc2 = (v.nominal or 0.0 for v in plant.HEAT_EXCHANGER.inputs)
    dp1, dp2, k1, k2 = NOMINAL
    fp, fu = (flow.nominal or 0.0 for flow in plant.HEAT_EXCHANGER.flows)
    return math.sqrt(dp1 / dp2) * (pc1 / k1) / (pc2 / k2), fu / fp
