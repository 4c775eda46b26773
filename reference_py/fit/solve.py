# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounded nonlinear least squares: Levenberg and Marquardt with an active set, in numpy.

Blender's Python has no scipy, and the operator has to work there, so this is the one solver; a test holds it against
`scipy.optimize.least_squares`. Damping follows Nielsen 1999, "Damping Parameter in Marquardt's Method"; derivatives that a
step confirmed are corrected by one rank instead of taken anew (Broyden 1965), as in Madsen, Nielsen and Tingleff 2004,
"Methods for Non-Linear Least Squares Problems", 3.5.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

import numpy as np

# With less, values that do the same make the matrix singular.
_LEAST_DAMPING = 1e-14
# A step that gains this part of what the derivatives promise confirms them; so many of them are followed by new ones.
_CONFIRMED, _MOST_CONFIRMED = 0.5, 3


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """`x` (p,), residual (m,) there, and the count of steps."""

    x: np.ndarray
    residual: np.ndarray
    steps: int

    @property
    def cost(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residual @ self.residual)


@dataclass(frozen=True, eq=False, repr=False)
class Ask:
    """What a search wants to know at `x` (p,): the residual (m,), or, where that is known to be `r`, the Jacobian (m, p)."""

    x: np.ndarray
    r: np.ndarray | None = None


Search = Generator[Ask, np.ndarray, Solution]


def least_squares(
    residual: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray, np.ndarray], np.ndarray],
    start: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    steps: int = 60,
    tolerance: float = 1e-7,
) -> Solution:
    """Minimise |residual(x)|^2 for low <= x <= high, as `search` does.

    residual: x (p,) to (m,); jacobian: (x, residual(x)) to (m, p).
    """
    return side_by_side(
        lambda asks: [residual(ask.x) if ask.r is None else jacobian(ask.x, ask.r) for ask in asks], [search(start, low, high, steps, tolerance)]
    )[0]


def side_by_side(answers: Callable[[list[Ask]], Sequence[np.ndarray]], searches: Sequence[Search]) -> list[Solution]:
    """Solutions of searches that take their steps together: what all of them ask for is computed at once."""
    asked, found = {i: next(each) for i, each in enumerate(searches)}, {}
    while asked:
        for i, answer in zip(list(asked), answers(list(asked.values()))):
            try:
                asked[i] = searches[i].send(answer)
            except StopIteration as end:
                found[i] = end.value
                del asked[i]
    return [found[i] for i in range(len(searches))]


def search(start: np.ndarray, low: np.ndarray, high: np.ndarray, steps: int, tolerance: float) -> Search:
    """A minimum of |residual(x)|^2 for low <= x <= high, each (p,).

    Stops after `steps` trials or when cost or x move less than `tolerance` (relative, and absolute).
    """
    x = np.clip(start, low, high)
    r = yield Ask(x)
    j, age = (yield Ask(x, r)), 0
    damping, growth, cost = 1e-3, 2.0, float(r @ r)
    for step in range(steps):
        gradient = j.T @ r
        free = ~(((x <= low) & (gradient > 0.0)) | ((x >= high) & (gradient < 0.0)))
        if not free.any() or cost == 0.0:
            if not age or cost == 0.0:
                break
            j, age = (yield Ask(x, r)), 0
            continue
        normal = j[:, free].T @ j[:, free]
        scale = np.maximum(np.diagonal(normal), 1e-9 * max(float(np.max(np.diagonal(normal))), 1e-30))
        move = np.zeros(len(x))
        move[free] = -np.linalg.solve(normal + damping * np.diag(scale), gradient[free])
        trial = np.clip(x + move, low, high)
        moved = trial - x
        if np.max(np.abs(moved)) < tolerance:
            if not age:
                break
            j, age = (yield Ask(x, r)), 0
            continue
        new = yield Ask(trial)
        new_cost = float(new @ new)
        expected = -float(2.0 * gradient @ moved + np.sum(np.square(j @ moved)))
        if new_cost < cost:
            converged = cost - new_cost < tolerance * cost
            gain = (cost - new_cost) / expected if expected > 0.0 else 0.0
            if converged and not age:
                x, r, cost = trial, new, new_cost
                break
            damping, growth = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3), _LEAST_DAMPING), 2.0
            if gain > _CONFIRMED and age < _MOST_CONFIRMED and not converged:
                j, age = j + np.outer(new - r - j @ moved, moved / (moved @ moved)), age + 1
            else:
                j, age = (yield Ask(trial, new)), 0
            x, r, cost = trial, new, new_cost
        elif age:
            j, age = (yield Ask(x, r)), 0
        else:
            damping, growth = damping * growth, 2.0 * growth
            if damping > 1e12:
                break
    return Solution(x, r, step + 1 if steps else 0)
