import csv

import pytest

from plant_sim.recording import main, write
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Simulation


def rows_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_the_table_holds_what_the_simulation_gives(tmp_path, capsys):
    path = tmp_path / 'a.csv'
    assert main(['three_tank', str(path), '--seed', '3', '--duration', '50']) == 0
    assert capsys.readouterr().out == f'50 rows in {path}\n'
    plant = Simulation(load_scenario('three_tank'), seed=3)
    rows = rows_of(path)
    assert list(rows[0]) == ['t', 'Q1', 'Q2', 'h1', 'h2']
    for row in rows:
        instant = plant.sample()
        values = [float(row[name]) for name in row]
        assert values == pytest.approx([instant.t, *instant.u, *instant.y], rel=1e-8)


def test_without_a_duration_it_is_the_scenarios_own(tmp_path):
    scenario = load_scenario('linear_second_order')
    rows = write('linear_second_order', tmp_path / 'a.csv')
    assert rows == len(rows_of(tmp_path / 'a.csv')) == scenario.duration / scenario.sample_period


def test_what_is_there_stays(tmp_path, capsys):
    path = tmp_path / 'a.csv'
    path.write_text('mine')
    assert main(['three_tank', str(path), '--duration', '5']) == 1
    assert path.read_text() == 'mine'
    assert capsys.readouterr().err.startswith('recording: [Errno 17] File exists')


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['three_tanks'], "unknown scenario 'three_tanks': did you mean 'three_tank'"),
        (['three_tank', '--duration', '0.5'], 'give a duration of 1 to 1e+07 s, not 0.5'),
        (['three_tank', '--duration', 'nan'], 'not nan'),
        (['three_tank', '--duration', '1e99'], 'not 1e+99'),
    ],
)
def test_mistakes_are_told_in_one_line(tmp_path, capsys, arguments, words):
    scenario, *options = arguments
    assert main([scenario, str(tmp_path / 'a.csv'), *options]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert not list(tmp_path.iterdir())


def test_what_stops_on_the_way_leaves_no_table(tmp_path, monkeypatch):
    def stop(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(Simulation, 'sample', stop)
    with pytest.raises(KeyboardInterrupt):
        write('three_tank', tmp_path / 'a.csv')
    assert not list(tmp_path.iterdir())
