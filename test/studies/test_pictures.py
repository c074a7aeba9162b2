import dataclasses
import math

import pytest

from obs_ros.studies.pictures import PICTURE, WORST, compared, draw
from obs_ros.studies.scores import Score, Scores

GOOD = Score(10, {'converged': 9, 'at_bound': 1}, 10, 1, 0, 0.75, {'a': 1.25}, 0.5)
SCORES = {
    'seed=1': Scores({'x.csv': GOOD, 'y.csv': dataclasses.replace(GOOD, skill=-math.inf)}),
    'seed=2': Scores({'x.csv': dataclasses.replace(GOOD, outcomes={'diverged': 10})}),
}
pytest.importorskip('matplotlib').use('Agg')


def test_each_kind_of_figure_has_its_panel_and_each_variant_its_row():
    import matplotlib.pyplot as plt

    figure = compared(plt, SCORES)
    assert [ax.get_title(loc='left') for ax in figure.axes] == [
        'Outcomes (%)', 'Forecast skill by recording', 'Scatter over sd by recording'
    ]  # fmt: skip
    shares, skill, _ = figure.axes
    assert [text.get_text() for text in shares.get_yticklabels()] == ['seed=1', 'seed=2']
    widths = {bars.get_label(): [bar.get_width() for bar in bars] for bars in shares.containers}
    assert widths['converged'] == [90.0, 0.0] and widths['diverged'] == [0.0, 100.0]
    assert list(skill.lines[0].get_xdata()) == [0.75, WORST]
    plt.close(figure)


def test_a_picture_is_written_where_there_are_estimates(tmp_path):
    assert draw(SCORES, tmp_path) == [PICTURE]
    assert (tmp_path / PICTURE).read_bytes().startswith(b'\x89PNG')
    blank = dataclasses.replace(GOOD, estimates=0, outcomes={})
    assert draw({'as given': Scores({'x.csv': blank})}, tmp_path / 'none') == []
