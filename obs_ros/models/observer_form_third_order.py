"""A third-order linear plant in observer form: Gremling & Passino 2000, eqs. 10-12 and 20.

x' = [[-a2, 1, 0], [-a1, 0, 1], [-a0, 0, 0]] x + [b2, b1, b0]' u and y = x1, so that

    y / u = (b2 s^2 + b1 s + b0) / (s^3 + a2 s^2 + a1 s + a0).

One dynamics, two models: the paper's plants differ in the coefficients and in what is known of them
beforehand, and a model's nominal values and bounds are just that. The second has a zero in the
right half plane.
"""

from typing import Any

from obs_ros.core.model import Model, Variable

_COEFFICIENTS = ('a2', 'a1', 'a0', 'b2', 'b1', 'b0')
_UNITS = ('1/s', '1/s2', '1/s3', '1/s', '1/s2', '1/s3')


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Rates of x1 (1), x2 (1/s) and x3 (1/s2) under the input (1)."""
    x1, x2, x3 = x
    a2, a1, a0, b2, b1, b0 = p
    return x2 - a2 * x1 + b2 * u[0], x3 - a1 * x1 + b1 * u[0], -a0 * x1 + b0 * u[0]


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the measured x1."""
    return (x[0],)


def _model(
    name: str,
    reference: str,
    sizes: tuple[float, float, float],
    coefficients: tuple[float, ...],
    ranges: tuple[tuple[float, float], ...],
) -> Model:
    """Return the plant whose states stay within ±`sizes`, its coefficients in `ranges`."""
    return Model(
        name=name,
        states=tuple(
            Variable(state, unit=unit, lower=-size, upper=size, nominal=0.0)
            for state, unit, size in zip(
                ('x1', 'x2', 'x3'), ('1', '1/s', '1/s2'), sizes, strict=True
            )
        ),
        inputs=(Variable('u', lower=-20.0, upper=20.0, nominal=0.0, interpolation='linear'),),
        outputs=(Variable('x1', lower=-sizes[0], upper=sizes[0], nominal=0.0),),
        parameters=tuple(
            Variable(coefficient, unit=unit, lower=lower, upper=upper, nominal=nominal)
            for coefficient, unit, (lower, upper), nominal in zip(
                _COEFFICIENTS, _UNITS, ranges, coefficients, strict=True
            )
        ),
        dynamics=dynamics,
        output=output,
        max_step=0.05,
        reference=reference,
    )


OBSERVER_FORM_THIRD_ORDER = _model(
    'observer_form_third_order',
    'Gremling & Passino 2000, section 4',
    sizes=(10.0, 10.0, 10.0),
    coefficients=(2.1, 2.1, 1.0, 1.0, 0.9, 0.8),
    ranges=((1.8, 2.3), (1.8, 2.3), (0.8, 1.2), (0.8, 1.2), (0.7, 1.1), (0.6, 1.1)),
)

OBSERVER_FORM_THIRD_ORDER_NMP = _model(
    'observer_form_third_order_nmp',
    'Gremling & Passino 2000, section 5, eq. 20',
    sizes=(10.0, 20.0, 10.0),
    coefficients=(2.9, 2.91, 0.959, 0.0, 1.0, -0.05),
    ranges=((2.7, 3.2), (2.7, 3.2), (0.8, 1.2), (-0.2, 0.2), (0.7, 1.2), (-0.2, 0.2)),
)
