"""A jet engine's compressor, Moore-Greitzer's three states: Gremling & Passino 2000, eqs. 21-23.

Pressure rise Psi, squared amplitude of the rotating stall cells R >= 0, mass flow Phi; the input is
the mass flow through the throttle, Phi_T, and Psi is measured. R grows where |Phi| < 1; it falls
above 1 and R = 0 stays 0, so that the bound R >= 0 is the plant's own.

The parameters are those of eq. 23: c1 = Psi_C0 + 1, c2 = 3/2, c3 = 1/2, c4 = 3, c5 = 1/beta^2 and
c6 = sigma. (The paper prints the flow where the pressure rise belongs in the second line there.)
"""

from typing import Any

from obs_ros.core.model import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Rates in 1/s of pressure rise, stall and mass flow (1) under the throttle's flow (1)."""
    psi, r, phi = x
    c1, c2, c3, c4, c5, c6 = p
    return (
        c5 * (phi - u[0]),
        c6 * r * (1.0 - phi * phi - r),
        c1 + c2 * phi - c3 * phi * phi * phi - c4 * phi * r - psi,
    )


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the measured pressure rise Psi."""
    return (x[0],)


JET_ENGINE = Model(
    name='jet_engine',
    states=(
        Variable('Psi', lower=0.0, upper=4.0, nominal=0.5),
        Variable('R', lower=0.0, upper=1.2, nominal=0.05),
        Variable('Phi', lower=-2.5, upper=2.5, nominal=1.0),
    ),
    inputs=(Variable('Phi_T', lower=-15.0, upper=15.0, nominal=1.0),),
    outputs=(Variable('Psi', lower=0.0, upper=4.0, nominal=0.5),),
    parameters=(
        Variable('c1', unit='1/s', lower=1.0, upper=2.0, nominal=1.5),
        Variable('c2', unit='1/s', lower=1.2, upper=1.8, nominal=1.5),
        Variable('c3', unit='1/s', lower=0.2, upper=0.8, nominal=0.5),
        Variable('c4', unit='1/s', lower=2.0, upper=4.0, nominal=3.0),
        Variable('c5', unit='1/s', lower=0.3, upper=0.7, nominal=0.4823),
        Variable('c6', unit='1/s', lower=5.0, upper=9.0, nominal=7.0),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.02,
    reference='Gremling & Passino 2000, eqs. 21-23',
)
