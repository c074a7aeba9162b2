"""Beliefs about a window: its hypotheses under all lineages that came before it.

A window is fitted under the moments of all lineages. Where there are several, its hypotheses are
solved anew under the prior of each; their evidences, which hold what the prior costs, multiply the
lineages' weights: each window counts once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Jump
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.horizon.arrival_cost import KnownJump, Lineal
from obs_ros.horizon.found_jumps import JumpFound, jumps_of, together
from obs_ros.horizon.gaussian_sum import SUM, Component, Lineage, same_event, set_at
from obs_ros.horizon.stages import under
from obs_ros.inference.assessment.interval import covariance_without_boxes
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis, discounted
from obs_ros.inference.jumps.mixture import Mixture, probabilities
from obs_ros.inference.jumps.screening import widened
from obs_ros.inference.parameterisation import Unknowns


@dataclass(frozen=True)
class Belief:
    """A hypothesis about a window with its probability, and the jumps up to the window's end.

    `own` are those of the window itself.
    """

    weight: float
    hypothesis: Hypothesis
    jumps: Lineage
    own: Lineage


@dataclass(frozen=True)
class Beliefs:
    """All that is believed of a window, the most probable first.

    `start` and `duration` (s) are the window's, `still` the probability that nothing jumped in it,
    however small.
    """

    every: tuple[Belief, ...]
    start: float
    duration: float
    still: float

    @property
    def mixture(self) -> Mixture:
        """The hypotheses as a mixture."""
        return Mixture(
            tuple(one.hypothesis for one in self.every),
            np.array([one.weight for one in self.every]),
            still=self.still,
        )

    def chances(self, event: JumpFound) -> dict[frozenset[str], float]:
        """Return the probability of each set of parameters to have jumped at the time of an event.

        The empty set stands for no jump.
        """
        found: dict[frozenset[str], float] = {}
        for one in self.every:
            names = set_at(one.jumps, event, self.duration)
            found[names] = found.get(names, 0.0) + one.weight
        return found

    def shown(self, event: JumpFound, names: frozenset[str]) -> JumpFound | None:
        """Return the jump of these parameters at the time of an event, as the likeliest has it."""
        for one in self.every:
            for jump in one.jumps:
                if jump.names == names and same_event(jump, event, self.duration):
                    return jump
        return None

    def events(self) -> list[JumpFound]:
        """Return the jumps inside the window by any hypothesis, one for each time."""
        found: list[JumpFound] = []
        for one in self.every:
            found += [
                jump
                for jump in one.own
                if not any(same_event(jump, other, self.duration) for other in found)
            ]
        return found

    def known_jumps(self, unknowns: Unknowns) -> list[KnownJump]:
        """Return the jumps inside the window with what else may have jumped at their times."""
        places = {name: i for i, name in enumerate(unknowns.names)}
        known = []
        for event in self.events():
            best = set_at(self.every[0].own, event, self.duration)
            chances = [
                (chance, frozenset(places[name] for name in names), self.shown(event, names))
                for names, chance in self.chances(event).items()
            ]
            parameters = frozenset(places[name] for name in best)
            known.append(KnownJump(event.time, parameters, tuple(chances)))
        return known

    def components(self, inflation: float) -> list[Component]:
        """Return the parameters at the end by all but the first, in boxes.

        `inflation` raises the variances.
        """
        found = []
        for one in self.every[1:]:
            mean, covariance = _at_end(one.hypothesis)
            found.append(Component(one.weight, mean, inflation * covariance, one.jumps))
        return found


def believed(
    mixture: Mixture, lineages: Sequence[Lineal], start: float, duration: float, deadline: Deadline
) -> Beliefs:
    """Return what the hypotheses of a window and the lineages before it add up to.

    With one lineage the mixture stays as it is.
    """
    solved = _solved(mixture, lineages, deadline) if len(lineages) > 1 else []
    if not solved or deadline.passed:
        before = lineages[0].jumps if lineages else ()
        every = [
            Belief(weight, one, (*before, *own), own)
            for weight, one in zip(mixture.weights.tolist(), mixture.hypotheses, strict=True)
            for own in [tuple(jumps_of(one, one.covariance))]
        ]
        return Beliefs(tuple(every), start, duration, mixture.still)
    weights = probabilities(np.array([evidence for _, _, evidence in solved]))
    order = [k for k in np.argsort(-weights) if weights[k] >= SUM.least_weight]
    total, every = weights[order].sum(), []
    for k in order:
        found, before, _ = solved[k]
        own = tuple(jumps_of(found, found.covariance))
        every.append(Belief(float(weights[k] / total), found, (*before, *own), own))
    still = float(sum(w for w, (h, _, _) in zip(weights, solved, strict=True) if not h.jumps))
    return Beliefs(tuple(every), start, duration, still)


def _solved(
    mixture: Mixture, lineages: Sequence[Lineal], deadline: Deadline
) -> list[tuple[Hypothesis, Lineage, float]]:
    """Return every hypothesis under every lineage, with its jumps before and -2 log evidence."""
    found = []
    for one in mixture.hypotheses:
        for lineage in lineages:
            other = _under(lineage, one, deadline)
            evidence = discounted(other, mixture.inflation) - 2.0 * np.log(lineage.weight)
            if np.isfinite(evidence):
                found.append((other, lineage.jumps, float(evidence)))
    return found


def jumps_shown(
    uncertainty: Uncertainty, beliefs: Beliefs, alternatives: Sequence[Hypothesis], record: Record
) -> tuple[Jump, ...]:
    """Return the jumps of a window's hypothesis, in order of time and earlier ones last.

    None of them is news yet.
    """
    best = uncertainty.hypothesis
    grid, names = best.problem.objective.grid, best.problem.objective.unknowns.names
    sets = dict.fromkeys(
        one.parameters for one in alternatives if one.parameters != best.parameters
    )
    others = [together(names[i] for i in places) or 'no jump' for places in sets]
    newest = float(grid.t[np.flatnonzero(grid.measured)[-1]])
    return tuple(
        _jump(found, beliefs.chances(found).get(found.names, 0.0), others, newest, record.stamp)
        for found in jumps_of(best, uncertainty.covariance)
    )


def jump_among(
    found: JumpFound,
    chances: Mapping[frozenset[str], float],
    newest: float,
    stamp: int | None,
) -> Jump:
    """Return a jump with the other sets of parameters that may have jumped at its time.

    `stamp` (ns) is that of the `newest` output (s).
    """
    others = [together(names) or 'no jump' for names in chances if names != found.names]
    return _jump(found, chances.get(found.names, 0.0), others, newest, stamp)


def _jump(
    found: JumpFound,
    probability: float,
    alternatives: Sequence[str],
    newest: float,
    stamp: int | None,
) -> Jump:
    """Return a jump as it is reported; `stamp` (ns) is that of the `newest` output (s)."""
    return Jump(
        time=found.time,
        time_stddev=found.deviation,
        sizes={name: size.value for name, size in found.sizes.items()},
        stddev={name: size.stddev for name, size in found.sizes.items()},
        new=False,
        alternatives=tuple(alternatives),
        stamp=None if stamp is None else stamp - round((newest - found.time) * 1e9),
        probability=probability,
    )


def _under(lineage: Lineal, one: Hypothesis, deadline: Deadline) -> Hypothesis:
    """Return a hypothesis solved anew under the prior of one lineage."""
    prior = lineage.prior()
    if one.earlier:
        prior = widened(prior, one.problem.objective.unknowns, *one.earlier)
    return under(prior, one, deadline)


def _at_end(one: Hypothesis) -> tuple[Array, Array]:
    """Return mean (q,) and covariance (q, q) of the parameters at the end, in boxes."""
    final = one.final_parameters
    return one.point[final], covariance_without_boxes(one)[np.ix_(final, final)]
