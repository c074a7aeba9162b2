"""Windows one after the other, each in steps that suffice: those of the one before, if they do."""

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.horizon.earlier import Earlier
from obs_ros.horizon.integration_error import Answer
from obs_ros.horizon.solution import Solution, solved
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.stepping import Stepping, SteppingMemory
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.backends import Kernels, kernels_for


class SteppedWindows:
    """The method and steps of the newest window that was solved, for those that follow."""

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self._before: Stepping | None = None
        self._kernels: tuple[Stepping, Kernels] | None = None  # rollouts after those steps

    @property
    def memory(self) -> SteppingMemory | None:
        """The method and steps of the newest window; None if there was none."""
        return None if self._before is None else self._before.memory

    def recall(self, memory: SteppingMemory | None) -> None:
        """Begin with the method and steps of another one, of the same model."""
        model = self._solver.model
        self._before = None if memory is None else Stepping(model, **vars(memory))

    @property
    def kernels(self) -> Kernels:
        """The rollouts from one window to the next."""
        if self._before is None:
            return self._solver.kernels
        if self._kernels is None or self._kernels[0] is not self._before:
            found = kernels_for(self._before.between, self._solver.settings.backend)
            self._kernels = self._before, found
        return self._kernels[1]

    def solved(
        self,
        posed: WindowState,
        earlier: Earlier,
        given: Array,
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> tuple[Solution | None, Answer | None]:
        """Return a window's best explanation and its integration error.

        See `solution.solved`, and for the arguments too.
        """
        integration = self._solver.integration
        window = integration.begun(posed, earlier.warm, self._before)
        for left in reversed(range(1 + integration.attempts)):
            solution = solved(window, self._solver, earlier, given, rng, deadline)
            if solution is None:
                return None, None
            answer = answer_of(solution)
            self._before = Stepping.of(answer)
            if answer.fine or deadline.passed or not left:
                break
            finer = integration.finer(window, answer)
            if finer is window:
                break
            window = finer
        return solution, answer


def answer_of(solution: Solution) -> Answer:
    """Return the integration error of a solution."""
    own, window = solution.disturbed, solution.window
    noise = None if own is None else own.noise.noise
    return Answer.of(window, solution.found.z, solution.hypothesis, noise)
