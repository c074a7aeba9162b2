"""A headless Chromium, where this machine has one, and what stands on its page."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from patience import patience

FLAGS = ('--headless', '--no-sandbox', '--disable-gpu', '--no-first-run',
         '--disable-background-networking', '--window-size=1400,1200')  # fmt: skip


@contextmanager
def chromium(profile: Path) -> Iterator[Any]:
    """Return a driver with an empty profile; skip the test where Chromium or Selenium is missing.

    Files are saved in the profile's folder.
    """
    webdriver = pytest.importorskip('selenium.webdriver', reason='needs selenium: make setup')
    found = shutil.which('chromium'), shutil.which('chromedriver')
    if None in found:
        pytest.skip('needs Chromium: apt install chromium chromium-driver')
    options = webdriver.ChromeOptions()
    options.binary_location = found[0]
    for flag in (*FLAGS, f'--user-data-dir={profile}'):
        options.add_argument(flag)
    options.add_experimental_option('prefs', {'download.default_directory': str(profile)})
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    driver = webdriver.Chrome(options, webdriver.ChromeService(found[1]))
    driver.set_script_timeout(patience(10.0))
    try:
        yield driver
    finally:
        driver.quit()


def wait(driver: Any, script: str, timeout: float = 10.0) -> Any:
    """Return the value of an expression once it is true."""
    from selenium.webdriver.support.ui import WebDriverWait

    def value(driver: Any) -> Any:
        return driver.execute_script(f'return {script}')

    return WebDriverWait(driver, patience(timeout), 0.05).until(value, f'never true: {script}')


def inked(driver: Any, kind: str, name: str) -> int:
    """Return how many pixels of a panel's canvas are in the first estimator's colour."""
    return int(driver.execute_script(
        """
        const canvas = figures.get(arguments[0]).canvas, probe = document.createElement('canvas');
        const context = probe.getContext('2d');
        context.fillStyle = theme().of(0);
        context.fillRect(0, 0, 1, 1);
        const [r, g, b] = context.getImageData(0, 0, 1, 1).data;
        const all = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        let count = 0;
        for (let k = 0; k < all.length; k += 4) {
          const off = Math.abs(all[k] - r) + Math.abs(all[k + 1] - g) + Math.abs(all[k + 2] - b);
          count += all[k + 3] > 200 && off < 24;
        }
        return count;
        """,
        f'{kind}/{name}',
    ))  # fmt: skip


def errors(driver: Any) -> list[str]:
    """Return what the page complained of: errors of scripts, and all that its policy refused."""
    return [each['message'] for each in driver.get_log('browser') if each['level'] == 'SEVERE']
