"""Windows that cannot be solved as they are, and what they need."""

from obs_ros.core.estimate import Outcome
from obs_ros.core.model import Model
from obs_ros.core.record import Record
from obs_ros.horizon.settings import POSING


class Unsolvable(ValueError):
    """A window cannot be solved as it is; the text says what it needs, `outcome` is its outcome."""

    outcome = Outcome.DIVERGED


class TooFewSamples(Unsolvable):
    """A window has too few measured values for its unknowns; the text says how many it needs."""

    outcome = Outcome.TOO_FEW_SAMPLES


class TooManySteps(Unsolvable):
    """A window has more integration steps than can be taken."""


def check_steps(model: Model, record: Record) -> None:
    """Raise TooManySteps for a record with more steps of at most `max_step` than can be taken."""
    length = float(record.t[-1] - record.t[0])
    if length > POSING.most_steps * model.max_step:
        raise TooManySteps(
            f'give times in s, or a max_step longer than {model.max_step:g} s: the window of '
            f'{length:g} s has more than {POSING.most_steps} steps'
        )
