"""Processes that measure with the package of another source tree."""

import pytest

from benchmarks.runner import ROOT, monte_carlo
from benchmarks.trees import Tree, called_in

MARK = "__import__('obs_ros').MARK"


def test_a_call_uses_the_package_of_the_tree_and_these_benchmarks(tmp_path):
    for name, text in (('obs_ros', 'MARK = 7\n'), ('benchmarks', 'raise ImportError\n')):
        (tmp_path / name).mkdir()
        (tmp_path / name / '__init__.py').write_text(text)
    with Tree(tmp_path) as tree:
        assert tree.call(eval, MARK) == 7
        home = tree.call(eval, "__import__('benchmarks').__file__")
        assert home == str(ROOT / 'benchmarks' / '__init__.py')
        with pytest.raises(RuntimeError, match='ZeroDivisionError'):
            tree.call(divmod, 1, 0)
        assert tree.call(divmod, 7, 2) == (3, 1)  # it lives on
    runs = {'all': [(tmp_path, eval, MARK)] * 2}
    assert monte_carlo(called_in, runs, 'marks') == {'all': [7, 7]}
    with pytest.raises(FileNotFoundError, match='give a source tree'):
        Tree(tmp_path / 'obs_ros')
