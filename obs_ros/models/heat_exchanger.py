"""A heat exchanger whose two flows come through pneumatic valves: Zhang et al. 2020, eq. 36-44.

Index 1 is the utility valve (flow Fu, Tu), index 2 the process valve (Fp, Tp). The chamber
pressures pc1 and pc2 are measured, as in section 4.3, and so are the outlet temperatures; the
openings are hidden. The equation of the pressures themselves (section 4.1.1, eq. 41) is left out:
no value of V0, of the air pressure and of the command pressures is printed.
An opening X is scaled, not in metres: only Cv X counts. Cv is calibrated valve by valve, so that
Fu = 4.22e-5 and Fp = 4.17e-6 m3/s: one Cv for both, as printed, gives Fu/Fp = 2.64, not 10.12.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from obs_ros.core.interconnected_model import InterconnectedModel
from obs_ros.core.model import Variable

STEM_MASS = 2.0  # m, kg
DIAPHRAGM_AREA = 0.029  # Aa, m2
FRICTION = 1500.0  # mu, N s/m
CV1 = 1.143891e-8  # m3/s per unit of opening and root of Pa
CV2 = 2.978703e-9
SPECIFIC_GRAVITY = 1.0  # sg

HEAT_TRANSFER = 214.8  # hA, W/K
HEAT_CAPACITY = 1000.0 * 4180.0  # rho cp, J/m3/K: water, which the paper does not say
VP, VU = 2.685e-5, 1.141e-4  # m3
TPI, TUI = 76.0, 15.0  # degC, inlets
AP = HEAT_TRANSFER / (HEAT_CAPACITY * VP)  # 1/s
AU = HEAT_TRANSFER / (HEAT_CAPACITY * VU)  # 1/s


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Rates from temperatures (degC), openings and their rates (1/s), pressures and parameters."""
    tp, tu, x1, v1, x2, v2 = x
    pc1, pc2 = u
    dp1, dp2, k1, k2 = p
    dtp, dtu = temperature_rates(tp, tu, flow2(dp2, x2), flow1(dp1, x1))
    return dtp, dtu, v1, stem(pc1, x1, v1, k1), v2, stem(pc2, x2, v2, k2)


def reduced_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any, Any]:
    """Return the rates with stems that have no inertia: mu X' = Aa pc - k X."""
    tp, tu, x1, x2 = x
    pc1, pc2 = u
    dp1, dp2, k1, k2 = p
    dtp, dtu = temperature_rates(tp, tu, flow2(dp2, x2), flow1(dp1, x1))
    return dtp, dtu, massless_stem(pc1, x1, k1), massless_stem(pc2, x2, k2)


def temperature_rates(tp: Any, tu: Any, fp: Any, fu: Any) -> tuple[Any, Any]:
    """Return Tp' and Tu' in K/s from temperatures (degC) and flows (m3/s), eq. 42-43."""
    ftp, ftu = exchange(tp, tu)
    gtp, gtu = feed(tp, tu)
    return ftp + gtp * fp, ftu + gtu * fu


def exchange(tp: Any, tu: Any) -> tuple[Any, Any]:
    """Return f in K/s: what the fluids take from each other."""
    return AP * (tu - tp), AU * (tp - tu)


def feed(tp: Any, tu: Any) -> tuple[Any, Any]:
    """Return g in K/m3: what a flow changes, nothing where it comes in as warm as it goes out."""
    return (TPI - tp) / VP, (TUI - tu) / VU


def drift(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return f of the temperatures (degC)."""
    return exchange(x[0], x[1])


def gain(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the diagonal of g, for Fp and Fu."""
    return feed(x[0], x[1])


def flow_gain(p: Any) -> tuple[Any, Any]:
    """Return c in m3/s per unit of opening, for Fp and Fu."""
    return flow2(p[1], 1.0), flow1(p[0], 1.0)


def flow1(dp1: Any, x1: Any) -> Any:
    """Return Fu in m3/s from the pressure drop (Pa) over the utility valve and its opening."""
    return CV1 * np.sqrt(dp1 / SPECIFIC_GRAVITY) * x1


def flow2(dp2: Any, x2: Any) -> Any:
    """Return Fp in m3/s from the pressure drop (Pa) over the process valve and its opening."""
    return CV2 * np.sqrt(dp2 / SPECIFIC_GRAVITY) * x2


def stem(pc: Any, x: Any, v: Any, k: Any) -> Any:
    """Return V' from chamber pressure (Pa), opening, its rate (1/s) and spring (N/m), eq. 37."""
    return (DIAPHRAGM_AREA * pc - FRICTION * v - k * x) / STEM_MASS


def massless_stem(pc: Any, x: Any, k: Any) -> Any:
    """Return X' in 1/s of a stem without inertia."""
    return (DIAPHRAGM_AREA * pc - k * x) / FRICTION


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the measured temperatures Tp and Tu in degC."""
    return x[0], x[1]


_TEMPERATURES = tuple(Variable(name, 'degC', 0.0, 100.0) for name in ('Tp', 'Tu'))
# Openings at rest, Aa pc / k, with everything nominal.
_OPENINGS = (
    Variable('X1', lower=0.0, upper=15.0, nominal=DIAPHRAGM_AREA * 1.0e6 / 6089.0),
    Variable('X2', lower=0.0, upper=15.0, nominal=DIAPHRAGM_AREA * 1.2e6 / 6089.0),
)
_RATES = tuple(Variable(name, '1/s', -30.0, 30.0, nominal=0.0) for name in ('V1', 'V2'))

# The fast poles of the stems, at -746 1/s, let RK4 take steps of 3.7 ms at most.
HEAT_EXCHANGER = InterconnectedModel(
    name='heat_exchanger',
    states=(*_TEMPERATURES, _OPENINGS[0], _RATES[0], _OPENINGS[1], _RATES[1]),
    inputs=(
        Variable('pc1', 'Pa', lower=0.0, nominal=1.0e6),
        Variable('pc2', 'Pa', lower=0.0, nominal=1.2e6),
    ),
    outputs=tuple(Variable(name, 'degC') for name in ('Tp', 'Tu')),
    parameters=(
        Variable('dP1', 'Pa', 1.0e5, 1.0e6, nominal=6.0e5, scale='log'),
        Variable('dP2', 'Pa', 1.0e4, 1.0e5, nominal=6.0e4, scale='log'),
        Variable('k1', 'N/m', 3000.0, 12000.0, nominal=6089.0, scale='log'),
        Variable('k2', 'N/m', 3000.0, 12000.0, nominal=6089.0, scale='log'),
    ),
    dynamics=dynamics,
    output=output,
    max_step=1e-3,
    drift=drift,
    gain=gain,
    flow_gain=flow_gain,
    openings=('X2', 'X1'),
    flows=(
        Variable('Fp', 'm3/s', 0.0, 5.0 * 4.17e-6, nominal=4.17e-6),
        Variable('Fu', 'm3/s', 0.0, 5.0 * 4.22e-5, nominal=4.22e-5),
    ),
    least_gain=(2.0 / VP, 2.0 / VU),  # as 2 K from the inlets
    opening_rates=('V2', 'V1'),
    reference='Zhang et al. 2020, eq. 36-44',
)

# A pressure is fed as the mean over an interval: the valves' poles at -4 1/s see no more of it.
HEAT_EXCHANGER_REDUCED = replace(
    HEAT_EXCHANGER,
    name='heat_exchanger_reduced',
    states=(*_TEMPERATURES, *_OPENINGS),
    inputs=tuple(replace(each, interpolation='mean') for each in HEAT_EXCHANGER.inputs),
    dynamics=reduced_dynamics,
    max_step=0.05,
    opening_rates=(),
    reference='Zhang et al. 2020, eq. 36-44, without the inertia of the stems',
)
