import pytest

from obs_ros.core.drifting import remedy


@pytest.mark.parametrize(
    ('drifting', 'words'),
    [
        ((), ''),
        (('k1',), 'give it a walk: walk.k1 (k1 moves too often to have jumped)'),
        (
            ('k1', 'k2'),
            'give them walks: walk.k1, walk.k2 (k1, k2 move too often to have jumped)',
        ),
    ],
)
def test_the_remedy_comes_first(drifting, words):
    assert remedy(drifting) == words
