from obs_ros.interface.status import Health, Level
from obs_ros.interface.terminal import Terminal


def health(outcome='converged', level=Level.OK, **figures):
    return Health(level, outcome, {'outcome': outcome, **figures})


def test_what_is_waited_for_is_shown_with_its_level():
    terminal = Terminal()
    shown = [
        line
        for each in (health('collecting'), health(), health('stale_input', Level.STALE))
        for line in terminal.lines(each)
    ]
    assert shown == [(Level.OK, 'collecting'), (Level.STALE, 'stale_input')]


def test_a_drift_is_said_once_until_other_parameters_drift():
    terminal = Terminal()
    seen = [
        [*terminal.lines(health(**figures))]
        for figures in (
            {}, {'drifting': 'a'}, {'drifting': 'a'}, {}, {'drifting': 'a'}, {'drifting': 'a, b'},
        )
    ]  # fmt: skip
    assert seen == [[], [(Level.WARN, 'a')], [], [], [], [(Level.WARN, 'a, b')]]
