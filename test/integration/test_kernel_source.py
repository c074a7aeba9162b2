"""Tests of obs_ros.integration.kernel_source: the text of the generated modules."""

import re

import pytest
from plants import BLOW_UP, OSCILLATOR

pytest.importorskip('numba')

from obs_ros.integration.kernel_source import filter_source, source


def test_the_generated_module_is_python_with_the_models_sizes() -> None:
    text = source(OSCILLATOR)
    compile(text, 'kernels', 'exec')
    assert re.search(r'N_STATES, N_OUTPUTS, N_PARAMETERS, N_LANES = 2, 2, 2, 16', text)


@pytest.mark.parametrize(
    ('d', 'sizes'), [(2, '2, 1, True'), (7, '7, 1, True'), (8, '8, 1, False'), (16, '16, 2, False')]
)
def test_a_filter_has_a_module_for_each_number_of_states_and_moving_parameters(
    d: int, sizes: str
) -> None:
    text = filter_source(OSCILLATOR, d)
    compile(text, 'kernels', 'exec')
    assert f'N_JOINT, N_CHUNKS, CENTRAL, DIFFERENCE = {sizes}, 0.0001' in text


def test_a_correction_is_spelled_out_for_the_models_sizes() -> None:
    text = source(OSCILLATOR)
    assert '    h1 = yhat[1] + node[2] * e0\n' in text
    assert '    return (x[0] + node[5] * e0 + node[6] * e1, ' in text
    assert '    h0 = yhat[0]\n' in source(BLOW_UP)
