# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the constants of the method `analytic` again (`reference_py/lobes/analytic/calibration.py`), from `models.adding`.

    python -m lamina.study.calibrate_analytic [--seed N] [--start committed|plain] [--steps N] [--only NAME...] [--write]

Levenberg-Marquardt steps in the constants' logarithms (logits where they have an upper limit), on the signed relative errors of the
albedo in per cent, of every channel at 0, 40, 65 and 80 degrees, squared in size so that large ones count. Stacks: the suite and the
paper's presets (weight 1) and `TRAINING` random ones (weight 1/4). Two constants are found by themselves: LOBE_BEND moves no energy
and is fitted to shapes, ANISOTROPIC_RETAINED matters under anisotropy alone and is fitted to the walks of `position_free`.
Prints committed and fitted constants, and the errors of both on what was fitted and on what was held out.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from statistics import median

import numpy as np

from ..reference_py.fit.solve import least_squares
from ..reference_py.lobes.analytic import AnalyticLobes, base, beam, calibration, lobe_set
from ..reference_py.lobes.analytic.interface_tables import anisotropic_energy, closure_energy
from ..reference_py.lobes.closure import lobe_energy
from ..reference_py.lobes.error_estimate import ErrorEstimator
from ..reference_py.lobes.lobe import DiffuseLobe, GlossyLobe
from ..reference_py.lobes.methods.featured_analytic import featured_analytic
from ..reference_py.material import presets
from ..reference_py.material.stack import Stack
from ..reference_py.models.adding.adding_model import Adding
from ..reference_py.models.position_free import PositionFree
from ..reference_py.optics.frame import spherical
from .charts.output import print_table
from .constants_file import Value, read_constants, rounded, write_constants
from .random_stacks import hard_stacks, plain_stacks
from .suite import suite
from .tables import FIGURES, write_table

FILE = Path(calibration.__file__)
TABLE = FIGURES / "calibration.csv"
ERROR_COLUMNS = ("stacks", "number", "constants", "median", "mean", "worst", "mean gain", "its standard error")
THETA_DEG = (0.0, 40.0, 65.0, 80.0)
SEED = 7
TRAINING, HELD_OUT, HELD_OUT_HARD = 51, 40, 24
# Of the sum of squares that random stacks have, over those that have names.
RANDOM_WEIGHT = 0.25
# What a constant's move by a factor of e must gain at least, as a root of the sum of squares: what the stacks do not determine stays where it was.
PULL = 25.0
# Stacks that shapes are fitted to; and anisotropic metals.
SHAPES = 6
ANISOTROPIC_REFLECTANCES, ANISOTROPIC_ROUGHNESSES, ANISOTROPIES = (0.9, 0.6, 0.2), (0.35, 0.6, 0.9), (0.4, 0.7, 1.0)
ANISOTROPIC_AZIMUTHS_DEG = (0.0, 45.0, 90.0)
_BENDS, _KEPTS = np.geomspace(0.2, 3.2, 9), np.geomspace(0.3, 1.2, 9)

# What energies are fitted by, from where a fit starts that knows nothing, and an upper limit.
_LIMITED = {"MOST_SHARE": 1.0, "TRAPPED_COS": 1.0, "TAU_SHARE": 1.0, "MOST_LOBE_SHARE": 1.0, "RETAINED_ORDER": 1.0}
PLAIN: dict[str, Value] = {
    "LEAN_GGX": (1.0, 1.0, 1.0), "LEAN_BECKMANN": (1.0, 1.0, 1.0), "LOBE_SPREAD": 1.0, "SPREAD_GRAZING": 1.0, "MOST_SHARE": 0.9,
    "SPREAD_INCIDENCE": 1.0, "SPREAD_HALF": 1.0, "SPREAD_LIMIT": 1.0, "BACK_SPREAD": 1.0, "TRAPPED_COS": 0.5, "TRAPPED_SPREAD": 1.0,
    "TAU_SPREAD": 1.0, "TAU_SHARE": 0.9, "EXIT_SPREAD": 1.0, "NODE_SPREAD": 1.0, "MOST_LOBE_SHARE": 0.9,
    "REMIX_SCALE": 0.3, "REMIX_BACK": 0.3, "REMIX_POWER": 1.0, "RETAINED_ORDER": 0.5, "RETAINED_SCALE": 0.1, "BASE_LOSS": 0.3,
}  # fmt: skip
# How far a constant may go from where it starts, in its logarithm or logit, and the step of derivatives.
_RANGE, _STEP = 3.0, 1e-3


@contextmanager
def in_force(values: Mapping[str, Value]) -> Iterator[None]:
    """The method with other constants."""
    places = [(module, name) for module in (calibration, beam, base, lobe_set) for name in values if hasattr(module, name)]
    before = [getattr(module, name) for module, name in places]
    try:
        for module, name in places:
            setattr(module, name, values[name])
        yield
    finally:
        for (module, name), value in zip(places, before):
            setattr(module, name, value)


def to_numbers(values: Mapping[str, Value], names: Sequence[str] = tuple(PLAIN)) -> np.ndarray:
    """Constants (p,) as the solver sees them."""
    parts = []
    for name in names:
        v = np.atleast_1d(np.asarray(values[name], float))
        parts.append(np.log(v / (_LIMITED[name] - v)) if name in _LIMITED else np.log(v))
    return np.concatenate(parts)


def from_numbers(x: np.ndarray, names: Sequence[str] = tuple(PLAIN)) -> dict[str, Value]:
    """The inverse of `to_numbers`."""
    values: dict[str, Value] = {}
    at = 0
    for name in names:
        like = PLAIN[name]
        count = len(like) if isinstance(like, tuple) else 1
        v = np.exp(x[at : at + count])
        v = _LIMITED[name] * v / (1.0 + v) if name in _LIMITED else v
        values[name] = tuple(map(float, v)) if isinstance(like, tuple) else float(v[0])
        at += count
    return values


class Case:
    """A stack, its albedo (v, 3) by the truth at `THETA_DEG`, and its weight."""

    def __init__(self, stack: Stack, weight: float = 1.0, truth: np.ndarray | None = None):
        self.stack, self.weight = stack, weight
        theta = np.radians(THETA_DEG)
        self._cos = np.cos(theta)
        self.truth = Adding(stack).albedo(spherical(theta, 0.0)) if truth is None else truth
        # no constant moves what these lobes have with weight 1, and it takes most of the time
        self._units = [_unit_energy(lobe, self._cos) for lobe in AnalyticLobes(stack).lobes(self._cos)]

    def albedo(self) -> np.ndarray:
        """(v, 3) by the method with the constants in force."""
        total = np.zeros(self.truth.shape)
        for lobe, unit in zip(AnalyticLobes(self.stack).lobes(self._cos), self._units):
            total += lobe.weight * (closure_energy(self._cos, lobe.alpha_x, lobe.distribution)[:, None] if unit is None else unit)
        return total

    def errors(self) -> np.ndarray:
        """(v, 3) signed and relative."""
        return (self.albedo() - self.truth) / np.maximum(self.truth, 1e-3)


def _unit_energy(lobe: GlossyLobe | DiffuseLobe, cos_theta: np.ndarray) -> np.ndarray | None:
    """Energy (v, 3) of a lobe of weight 1; None for one whose width the constants move."""
    if isinstance(lobe, GlossyLobe) and lobe.fresnel is None:
        return None
    return lobe_energy(type(lobe)(**{**vars(lobe), "weight": np.ones((len(cos_theta), 3))}), cos_theta)


def fit(
    cases: Sequence[Case],
    start: Mapping[str, Value],
    steps: int = 40,
    report: Callable[[str], None] = lambda text: None,
    names: Sequence[str] = tuple(PLAIN),
    pull: float = PULL,
) -> dict[str, Value]:
    """The constants `names` that leave least, from those of `start`, towards which each is pulled; others are those in force."""
    begin = to_numbers(start, names)
    cases = [case for case in cases if _is_moved(case, from_numbers(begin + 0.3, names))]

    def residual(x: np.ndarray) -> np.ndarray:
        with in_force(from_numbers(x, names)):
            errors = [np.sqrt(case.weight) * 100.0 * case.errors() for case in cases]
        flat = np.concatenate([e.ravel() for e in errors])
        return np.concatenate([flat * np.abs(flat), pull * (x - begin)])

    def jacobian(x: np.ndarray, r: np.ndarray) -> np.ndarray:
        report(f"sum of squares {r @ r:.5g}")
        return np.stack([(residual(x + step) - r) / _STEP for step in _STEP * np.eye(len(x))], axis=1)

    return from_numbers(least_squares(residual, jacobian, begin, begin - _RANGE, begin + _RANGE, steps, tolerance=1e-4).x, names)


def _is_moved(case: Case, values: Mapping[str, Value]) -> bool:
    """Whether constants do anything to a stack: smooth ones over diffuse bases are exact."""
    before = case.errors()
    with in_force(values):
        return bool(np.max(np.abs(case.errors() - before)) > 1e-6)


def best_on(grid: np.ndarray, loss: Callable[[float], float]) -> float:
    """Where a loss is least: the lowest point of the parabola through the best of a grid, even in the logarithm, and its neighbours."""
    values = np.array([loss(float(v)) for v in grid])
    i = int(np.clip(np.argmin(values), 1, len(grid) - 2))
    below, at, above = values[i - 1 : i + 2]
    bend = below - 2.0 * at + above
    shift = np.clip(0.5 * (below - above) / bend, -1.0, 1.0) if bend > 0.0 else float(np.argmin(values) - i)
    return float(np.exp(np.log(grid[i]) + shift * np.log(grid[1] / grid[0])))


class ShapeCase:
    """A stack whose shape is compared at the views of `THETA_DEG`."""

    def __init__(self, stack: Stack):
        self.stack, self._estimator = stack, ErrorEstimator(stack, Adding(stack), np.cos(np.radians(THETA_DEG)))

    def errors(self) -> np.ndarray:
        """(v,) distances of f over the albedo, with the constants in force."""
        return self._estimator.errors(AnalyticLobes(self.stack)).shape


def fit_lobe_bend(cases: Sequence[ShapeCase]) -> float:
    """LOBE_BEND that leaves the least mean distance of shapes; other constants are those in force."""

    def loss(value: float) -> float:
        with in_force({"LOBE_BEND": value}):
            return float(np.mean([case.errors() for case in cases]))

    return best_on(_BENDS, loss)


class AnisotropicCase:
    """A bare anisotropic metal, and its albedo (v, a, 3) by walks."""

    def __init__(self, reflectance: float, roughness: float, anisotropy: float, walks: int = 1 << 15):
        grey = {"reflectance": [reflectance] * 3, "edge_color": [reflectance] * 3}
        self.lobe_set = featured_analytic(Stack.from_dict({"base": {"kind": "conductor", **grey, "roughness": roughness, "anisotropy": anisotropy}}))
        self._cos, self._phi = np.cos(np.radians(THETA_DEG))[:, None], np.radians(ANISOTROPIC_AZIMUTHS_DEG)
        self.truth = PositionFree(self.lobe_set.stack, walks=walks).albedo(spherical(np.arccos(self._cos), self._phi))

    def errors(self) -> np.ndarray:
        """(v, a, 3) signed and relative, with the constants in force."""
        (lobe,) = self.lobe_set.lobes(self._cos, self._phi)
        energy = anisotropic_energy(self._cos, self._phi, lobe.alpha_x, lobe.alpha_y, lobe.distribution)
        return lobe.weight * energy[..., None] / self.truth - 1.0


def anisotropic_cases() -> list[AnisotropicCase]:
    """Metals of three reflectances, widths and anisotropies."""
    return [AnisotropicCase(*values) for values in product(ANISOTROPIC_REFLECTANCES, ANISOTROPIC_ROUGHNESSES, ANISOTROPIES)]


def fit_anisotropic_retained(cases: Sequence[AnisotropicCase]) -> float:
    """ANISOTROPIC_RETAINED; errors count as in `fit`."""

    def loss(value: float) -> float:
        with in_force({"ANISOTROPIC_RETAINED": value}):
            return float(sum(np.sum(case.errors() ** 4) for case in cases))

    return best_on(_KEPTS, loss)


@dataclass(frozen=True)
class Set:
    """Stacks of one kind; `fitted` are those that a fit sees."""

    name: str
    fitted: bool
    cases: tuple[Case, ...]


def sets(seed: int, report: Callable[[str], None]) -> list[Set]:
    """All that is fitted and held out, with the truth."""
    rng = np.random.default_rng(seed)
    named = suite() | {f"preset {name}": presets.load(name) for name in presets.PAPER}
    found = []
    for name, fitted, weight, stacks in (
        ("suite and paper's presets", True, 1.0, list(named.values())),
        ("random, 1 or 2 layers", True, RANDOM_WEIGHT, plain_stacks(rng, TRAINING)),
        ("held out, 1 or 2 layers", False, 1.0, plain_stacks(rng, HELD_OUT)),
        ("held out, 3 to 6 tinted layers", False, 1.0, hard_stacks(rng, HELD_OUT_HARD)),
    ):
        report(f"truth of {name}")
        found.append(Set(name, fitted, tuple(Case(stack, weight) for stack in stacks)))
    return found


def comparison(
    measures: Mapping[str, Callable[[Mapping[str, Value]], np.ndarray]], committed: Mapping[str, Value], fitted: Mapping[str, Value]
) -> list[tuple[str, ...]]:
    """Rows of `ERROR_COLUMNS`: of each measure (n,) that constants give. Gain is the mean that is better, with its standard error: noise of the draw."""
    rows = []
    for name, measure in measures.items():
        before, after = measure(committed), measure(fitted)
        gain = before - after
        noise = np.std(gain, ddof=1) / np.sqrt(len(gain))
        for constants, e in (("committed", before), ("fitted", after)):
            shares = [f"{100.0 * v:.2f} %" for v in (median(e), np.mean(e), np.max(e))]
            rows.append(
                (name, str(len(e)), constants, *shares, f"{100.0 * np.mean(gain):+.2f} %" if e is after else "", f"{100.0 * noise:.2f} %" if e is after else "")
            )
    return rows


def _measure(cases: Sequence[Case | ShapeCase | AnisotropicCase], reduce: Callable[[np.ndarray], float]) -> Callable[[Mapping[str, Value]], np.ndarray]:
    def errors(values: Mapping[str, Value]) -> np.ndarray:
        with in_force(values):
            return np.array([reduce(np.abs(case.errors())) for case in cases])

    return errors


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="lamina.study.calibrate_analytic", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=SEED, help="of the random stacks (default: %(default)s)")
    parser.add_argument("--start", choices=("committed", "plain"), default="committed", help="constants that the fit begins with (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=40, help="of the solver at most (default: %(default)s)")
    parser.add_argument(
        "--only", nargs="+", choices=tuple(PLAIN), default=tuple(PLAIN), metavar="NAME", help="constants of energies to fit, others stay (default: all)"
    )
    parser.add_argument("--write", action="store_true", help=f"write the fitted constants into {FILE.name}")
    options = parser.parse_args(arguments)

    def report(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    committed = read_constants(FILE)
    all_sets = sets(options.seed, report)
    begin = committed if options.start == "committed" else PLAIN
    fitted = fit([case for one in all_sets if one.fitted for case in one.cases], begin, options.steps, report, options.only)
    report("LOBE_BEND and ANISOTROPIC_RETAINED")
    rng = np.random.default_rng([options.seed, 1])
    shapes, held_out_shapes = ([ShapeCase(stack) for stack in plain_stacks(rng, SHAPES)] for _ in range(2))
    anisotropic = anisotropic_cases()
    with in_force(fitted):
        fitted |= {"LOBE_BEND": fit_lobe_bend(shapes), "ANISOTROPIC_RETAINED": fit_anisotropic_retained(anisotropic)}
    fitted = {name: rounded(value) for name, value in fitted.items()}
    print_table(("constant", "committed", "fitted"), [(name, _text(committed[name]), _text(value)) for name, value in fitted.items()])
    print()
    measures = {f"albedo, {one.name}": _measure(one.cases, np.max) for one in all_sets}
    measures |= {
        "shape, random": _measure(shapes, np.mean),
        "shape, held out": _measure(held_out_shapes, np.mean),
        "albedo, brushed metals": _measure(anisotropic, np.max),
    }
    rows = comparison(measures, committed, fitted)
    print_table(ERROR_COLUMNS, rows)
    command = f"make calibration: lamina.study.calibrate_analytic --seed {options.seed} --start {options.start} --steps {options.steps}"
    heading = (command, "albedo: worst view and channel of each stack", "shape: mean of the views")
    write_table(TABLE, heading, ERROR_COLUMNS, rows, report)
    if options.write:
        write_constants(FILE, fitted)
        print(f"wrote {FILE}")
    return 0


def _text(value: Value) -> str:
    return ", ".join(f"{v:g}" for v in value) if isinstance(value, tuple) else f"{value:g}"


if __name__ == "__main__":
    sys.exit(main())
