"""Both pages in a real browser: they draw, update, outlive a restart, and take text for text."""

import csv
from pathlib import Path

import numpy as np
import pytest
from browser import chromium, errors, inked, wait
from patience import patience

from obs_ros.interface.vectors import Vector
from obs_ros.pages.board import Board
from obs_ros.pages.information import Information, Shown
from obs_ros.pages.page import page
from obs_ros.pages.server import PageServer

pytestmark = pytest.mark.slow
NASTY = '<img src=x onerror="document.title=1">'
SECOND = 10**9


def information(model='tank'):
    return Information(
        model, 'sliding_window', states=(Shown('h', 'cm'),), outputs=(Shown('h', 'cm'),),
        parameters=(Shown('p'), Shown(NASTY)),
    )  # fmt: skip


class Live:
    """A board that is served, and what an estimator would tell it."""

    def __init__(self, port=0):
        self.board = Board()
        self.noise = np.random.default_rng(0)
        self.server = PageServer('127.0.0.1', port, *page('obs_ros'), self.board.answer)
        self.t = 0

    def run(self, seconds, name='/estimator', rate=10):
        for k in range(seconds * rate):
            stamp = self.t * SECOND + k * SECOND // rate
            self.board.hear(name, Vector('measured', stamp, {'h': float(self.noise.normal(20, 1))}))
            residual = {'h': float(self.noise.normal())}
            self.board.hear(name, Vector('residual', stamp, residual, effort=(1.0,)))
            if k % rate == 0:
                for topic, values in (('parameters', {'p': 0.5, NASTY: 1.0}), ('state', {'h': 20})):
                    self.board.hear(name, Vector(topic, stamp, values))
                    spread = dict.fromkeys(values, 0.1)
                    self.board.hear(name, Vector(f'{topic}_stddev', stamp, spread))
                self.board.conclude(name, stamp, 'converged', f'says {NASTY}')
        self.t += seconds


@pytest.fixture
def live():
    live = Live()
    yield live
    live.server.close()


@pytest.fixture
def driver(tmp_path):
    with chromium(tmp_path) as driver:
        yield driver


def test_the_live_page_says_draws_updates_and_exports(live, driver, tmp_path):
    driver.get(live.server.address)
    assert 'No estimator is heard' in wait(
        driver, "!$('trouble').hidden && $('trouble').textContent"
    )
    live.board.inform('/estimator', information(NASTY))
    live.run(60)
    live.board.hear('/estimator', Vector('jump', 30 * SECOND, {'p': -0.4}, (0.97,), (0.01,)))
    wait(driver, "state.answer && state.answer.shown.length && figures.has('parameter/p') && "
         "state.view.to > 59 && $('trouble').hidden")  # fmt: skip
    assert inked(driver, 'parameter', 'p') > 300
    assert inked(driver, 'residual', 'h') > 300
    text = driver.find_element('tag name', 'body').text
    for words in ('converged', 'p -0.4 ± 0.02', '0.97', 'of 25 lags outside', NASTY):
        assert words in text, words
    # Outcomes stand in one line, however long what is said beside them.
    live.board.conclude(
        '/estimator', 59 * SECOND + SECOND // 2, 'not_identifiable', 'a long message ' * 30
    )
    wait(driver, "$('lists').textContent.includes('not identifiable')")
    lines = driver.execute_script(
        """return [...document.querySelectorAll('.outcomes td:nth-child(2)')].map(cell => {
          const words = document.createRange();
          words.selectNodeContents(cell);
          return new Set([...words.getClientRects()].map(each => each.top)).size;
        })"""
    )
    assert lines == [1, 1]
    assert driver.title == 'obs_ros'  # what topics say is text
    assert driver.execute_script("return document.querySelectorAll('img').length") == 0
    # It updates, and stands still while it pauses.
    live.run(10)
    wait(driver, 'state.view.to > 69')
    driver.find_element('id', 'pause').click()
    live.run(10)
    wait(driver, 'state.paused && !state.asking && !state.again')  # what was asked before has come
    assert asked(driver, polls=2) == 0
    assert driver.execute_script('return state.view.to') < 70
    driver.find_element('id', 'pause').click()
    assert asked(driver, polls=2) > 0
    wait(driver, 'state.view.to > 79')
    # What is seen is exported: first a part is chosen.
    driver.execute_script('look(20, 40)')
    wait(driver, 'state.answer.from === 20 && !state.asking')
    for name in ('csv', 'png'):
        driver.find_element('id', name).click()
    saved = {ending: saved_file(driver, tmp_path, ending) for ending in ('csv', 'png')}
    rows = list(csv.DictReader(saved['csv'].read_text().splitlines()))
    assert {20.0, 40.0} <= {float(row['t_s']) for row in rows}
    assert all(20.0 <= float(row['t_s']) <= 40.0 for row in rows)
    (jump,) = [row for row in rows if row['kind'] == 'jump']
    assert (jump['name'], jump['value'], float(jump['stamp_s'])) == ('p', '0.97', 30.0)
    estimate = next(row for row in rows if (row['kind'], row['name']) == ('parameter', 'p'))
    ends = float(estimate['lower_2sd']), float(estimate['upper_2sd'])
    assert ends == pytest.approx((0.3, 0.7))
    assert saved['png'].read_bytes().startswith(b'\x89PNG')
    assert errors(driver) == []


def asked(driver, polls: int) -> int:
    """Return how often the page has asked its server after so many polls were due.

    Timers of a page run in the order in which they are due, however busy the machine is.
    """
    return int(driver.execute_async_script(
        """
        const whole = window.fetch, [polls, done] = arguments;
        let count = 0;
        window.fetch = (...all) => { count += 1; return whole(...all); };
        setTimeout(() => { window.fetch = whole; done(count); }, (polls + 0.4) * POLL);
        """,
        polls,
    ))  # fmt: skip


def saved_file(driver, folder: Path, ending: str) -> Path:
    """Return the file of that ending which the browser saves, once it is there."""
    from selenium.webdriver.support.ui import WebDriverWait

    def there(_):
        return [p for p in folder.glob(f'obs_ros*.{ending}') if p.stat().st_size]

    return WebDriverWait(driver, patience(10.0), 0.05).until(there, f'no {ending} was saved')[0]


def test_measurements_of_several_plants_are_told_apart_and_those_of_one_are_drawn_once(
    live, driver
):
    names = ['/a/estimator', '/b/estimator']
    measured = """state.panels.find(panel => panel.key === 'state/h').curves
      .filter(curve => curve.role === 'measured').map(curve => [curve.by, curve.own])"""
    for name in names:
        live.board.inform(name, information())
        live.board.follow(name, f'{name}/output')
        live.run(10, name)
    driver.get(live.server.address)
    wait(driver, 'state.answer && state.answer.shown.length')
    driver.execute_script('choose(arguments[0])', names[1])
    wait(driver, 'state.answer.shown.length === 2')
    assert driver.execute_script(f'return {measured}') == [[name, True] for name in names]
    live.board.follow(names[1], f'{names[0]}/output')
    wait(driver, f'{measured}.length === 1')
    assert driver.execute_script(f'return {measured}') == [[names[0], False]]
    assert errors(driver) == []


def test_one_that_is_shown_no_more_leaves_its_place_and_its_colour_to_others(live, driver):
    shown = 'state.answer.shown.map(each => each.name)'
    pressed = """[...document.querySelectorAll('#estimators [aria-pressed=true]')]
      .map(button => button.dataset.name)"""
    live.board.inform('/old', information())
    live.run(10, '/old')
    driver.get(live.server.address)
    wait(driver, f'state.answer && {shown}[0] === "/old"')
    live.board.forget('/old')
    for name in ('/x', '/y'):
        live.board.inform(name, information())
        live.run(10, name)
    wait(driver, f'{shown}[0] === "/x" && {pressed}[0] === "/x"')
    driver.execute_script("choose('/y')")
    wait(driver, f'{shown}.length === 2 && {pressed}.length === 2')
    assert driver.execute_script(f'return {shown}') == ['/x', '/y']
    assert driver.execute_script('return state.chosen') == ['/x', '/y']
    assert errors(driver) == []


def test_restarts_of_estimator_and_server_are_outlived(live, driver):
    live.board.inform('/estimator', information())
    live.run(20)
    driver.get(live.server.address)
    wait(driver, 'state.answer && state.view.to >= 19')
    live.board.attend('/estimator', present=False)
    wait(driver, "document.querySelector('.card .unwell')?.textContent.startsWith('gone for')")
    live.board.attend('/estimator', present=True)
    live.board.inform('/estimator', information())
    live.run(20)
    wait(driver, "state.view.to >= 39 && !document.querySelector('.card .unwell')")
    # The server itself, on the same port, with other estimators.
    live.server.close()
    wait(driver, "$('trouble').textContent.startsWith('No answer')")
    again = Live(live.server.port)
    try:
        for name in ('/b/estimator', '/estimator'):
            again.board.inform(name, information())
            again.run(20, name)
        wait(driver, "$('trouble').hidden && state.answer.estimators.length === 2")
        driver.execute_script("choose('/b/estimator')")
        wait(driver, "state.answer.shown.length === 2 && "
             "state.panels[0].curves.filter(c => c.role === 'estimate').length === 2")  # fmt: skip
    finally:
        again.server.close()


def test_keys_zoom_move_pause_and_change_the_light(live, driver):
    from selenium.webdriver.common.keys import Keys

    live.board.inform('/estimator', information())
    live.run(100)
    driver.get(live.server.address)
    wait(driver, 'state.answer && state.view.to > 99')
    body = driver.find_element('tag name', 'body')
    for key, expected in (
        ('+', 'state.view.to - state.view.from < 50'), (Keys.ARROW_LEFT, 'state.view.from < 24'),
        ('-', 'state.view.to - state.view.from > 98'), ('0', 'state.fixed === null'),
        (' ', 'state.paused'), (' ', '!state.paused'),
        ('d', "document.documentElement.dataset.theme === 'dark'"),
    ):  # fmt: skip
        body.send_keys(key)
        wait(driver, expected)


def test_the_report_opens_from_its_file_and_shows_the_same(driver, tmp_path):
    live = Live()
    live.server.close()
    live.board.inform('/estimator', information(NASTY))
    live.run(60)
    text, _ = page('Replay of ' + NASTY, live.board.answer({}))
    (tmp_path / 'report.html').write_text(text, encoding='utf-8')
    driver.get((tmp_path / 'report.html').as_uri())
    wait(driver, "figures.has('parameter/p')")
    assert driver.title == 'Replay of ' + NASTY
    assert inked(driver, 'parameter', 'p') > 300
    whole = inked(driver, 'residual', 'h')
    driver.execute_script('look(0, 5)')
    assert 0 < inked(driver, 'residual', 'h') < whole
    assert errors(driver) == []
