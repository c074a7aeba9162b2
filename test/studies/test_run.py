import csv

import numpy as np
import pytest
from study_runs import GIVEN, bits, recordings

from obs_ros.replay.engine import replay
from obs_ros.replay.recording import Source, open_recording
from obs_ros.replay.settings import setup
from obs_ros.replay.writers import table_writer
from obs_ros.studies.keys import content
from obs_ros.studies.result import Result
from obs_ros.studies.run import at, replayed


@pytest.fixture
def source(tmp_path):
    return Source(*recordings(tmp_path, 1))


def test_a_run_gives_what_a_replay_gives(source, tmp_path):
    result = Result.from_bytes(replayed(source, content(source.path), GIVEN, False))
    chosen = setup(GIVEN)
    with table_writer(tmp_path / 'alone.csv', chosen.model) as take:
        account = replay(chosen, open_recording(source, chosen), take=take)
    with (tmp_path / 'alone.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert len(result) == len(rows) == 3
    for name in rows[0]:
        cells = [row[name] for row in rows]
        own = result.columns[name]
        assert [repr(v) if isinstance(v, float) else str(v) for v in list(
            own.tolist() if isinstance(own, np.ndarray) else own)] == cells  # fmt: skip
    forecasts = account.history.rows('forecasts')[:, 0]
    np.testing.assert_array_equal(result.columns['forecast_rms.y'], forecasts)
    assert np.isfinite(forecasts[0])
    facts = result.facts
    assert (facts['samples'], facts['jumps'], facts['every_sd'], facts['failed']) == (220, 0, 3, 0)
    assert facts['horizon'] == 5.0 and facts['wall_time'] > 0.0


def test_the_same_run_has_the_same_bits(source):
    one, two = (Result.from_bytes(replayed(source, content(source.path), GIVEN, False))
                for _ in range(2))  # fmt: skip
    assert bits(one.columns) == bits(two.columns)


def test_another_recording_in_its_place_is_refused(source):
    with pytest.raises(ValueError, match='is another recording here, or was changed meanwhile'):
        replayed(source, 'abc', GIVEN, False)


def test_an_immediate_observer_has_no_forecasts(source):
    given = {**GIVEN, 'observer': 'ekf', 'noise.y': 1e-4}
    result = Result.from_bytes(replayed(source, content(source.path), given, False))
    assert len(result) == 110 and result.facts['horizon'] is None
    assert np.isnan(result.columns['forecast_rms.y']).all()


def test_another_recording_is_read_alike(source, tmp_path):
    moved = at(Source(source.path, period=0.1), tmp_path)
    assert (moved.path, moved.period) == (tmp_path, 0.1)
