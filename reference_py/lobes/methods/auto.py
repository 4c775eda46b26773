# SPDX-License-Identifier: GPL-3.0-or-later
"""Method `auto`: the cheapest way to tell Cycles about a stack whose error stays under a tolerance."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ...errors import LaminaError
from ...material.place import Place, in_words, places
from ...material.qualities import AUTO
from ...material.schema import ANISOTROPY, SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...models.position_free import PositionFree
from ...optics.error_measure import albedo_error, worst_share
from ...optics.frame import spherical
from ...optics.optical_stack import Support
from ..analytic import AnalyticLobes
from ..baked import DEFAULT_GLOSSY, MAX_GLOSSY, Baker, RampBaker, baked, follows, is_brushed, level, pack_lobes, unpack_lobes
from ..bare_base import is_bare_brushed, is_bare_oren_nayar
from ..brushing import isotropic
from ..cache import stack_key
from ..closure import lobe_energy
from ..error_estimate import SOFT_LIGHT_DEG, ErrorEstimator, Errors, ball_cosines
from ..live_grid import LiveLobes
from ..made import Candidate, Choice, LobeSet, Made, Options
from ..tabulate import stock_lobes
from ..truth import truth_of
from .cost import cost
from .featured_analytic import featured_analytic
from .method import Computed, Method
from .not_bakeable import beyond_bakes, has_film, scatters
from .paper import PaperLobes

NAME = AUTO
# Errors that differ by less than this share of them are as good: the cheaper one is taken.
_AS_CLOSE = 0.05
# A bake is expected to be off by so many times `Baker.least_soft_light`, and surely by the second.
_LIKELY, _SURELY = 1.6, 1.15
# With one lobe more a bake is judged too where `Baker.least_soft_light` falls below this share: of a hundred stacks none that gained less was worth its lobe.
_GAIN = 0.96
# With fewer lobes than fits have a ramp is looked at no further below this share of the tolerance.
_WELL_WITHIN = 0.5
# Of albedos with anisotropy: azimuths, views, and walks for each.
_AZIMUTHS = np.radians([0.0, 45.0, 90.0, 135.0])
_FEW, _WALKS = 4, 1 << 15
_LIVE = {PaperLobes.name: PaperLobes, AnalyticLobes.name: featured_analytic}


def choose(stack: Stack, truth, options: Options, cosines: np.ndarray | None = None, light_deg: float = SOFT_LIGHT_DEG) -> Choice:
    """The cheapest candidate whose visible error is at most the tolerance, or the closest if none is.

    Judged at view `cosines` (n,), those of a ball's pixels unless given, under lights `light_deg` wide. Where values
    are live, the only bake is the one that follows them, if there is one. Raises LaminaError for a tolerance outside 0 to 1.
    """
    live, tolerance, glossy = options.live, options.tolerance, options.glossy or MAX_GLOSSY
    if not 0.0 < tolerance <= 1.0:
        raise LaminaError("tolerance {percent:g} percent: choose more than 0 and at most 100", percent=100.0 * tolerance)
    report = options.report
    cosines = ball_cosines() if cosines is None else cosines
    estimator = ErrorEstimator(stack, truth, cosines, light_deg)
    can_bake = follows(stack, live)
    able = {} if scatters(stack) else {PaperLobes.name: PaperLobes} if has_film(stack) else _LIVE
    tried: list[tuple[Candidate, Any]] = []

    def judge(label: str, lobe_set) -> float:
        tried.append((_candidate(label, lobe_set, estimator.errors(lobe_set), bool(live)), lobe_set))
        report(0.2 + 0.8 * len(tried) / (glossy + len(_LIVE)))
        return tried[-1][0].visible

    if live and can_bake and not is_bare_oren_nayar(stack):  # stock nodes follow what is baked over, and of live methods a bare rough base alone
        judge(f"baked over {in_words(live)}", baked(stack, live, min(DEFAULT_GLOSSY, glossy), lambda share: report(0.4 + 0.6 * share)))
    else:
        for method, lobe_set in able.items():
            judge(method, lobe_set(stack))
    if not live:
        baker = Baker(stack, truth)
        _try_bakes(baker, glossy, tolerance, lambda count: baker.least_soft_light(count, cosines, light_deg), judge)
    (stock, lobe_set), reason = _best(tried, tolerance)
    chosen = stock
    if isinstance(lobe_set, LiveLobes) and lobe_set.stock is not None and lobe_set.knows_metal:
        stock = _candidate(chosen.label, lobe_set.stock, estimator.errors(lobe_set.stock), live=True)
        reason += f"; where its Fresnel curve is not known, as in EEVEE, the error is {100.0 * stock.visible:.3g} %"
    if not live and stock.label not in _LIVE:
        _try_ramps(RampBaker(baker), glossy, tolerance, judge)
        # what is cheaper is not to be further off in shape
        closer = [t for t in tried if t[0].shape <= stock.shape or t[0] is stock]
        (chosen, best), reason = _best(closer, tolerance, len(tried))
        if best.has_ramps:
            own = stock_lobes(lobe_set)
            stock = _candidate(stock.label, own, estimator.errors(own), live=False)
            lobe_set = best if best is lobe_set else replace(best, stock=lobe_set)
            reason += f"; stock nodes have {stock.label}, error {100.0 * stock.visible:.3g} %"
    report(1.0)
    if not can_bake:
        reason += f"; a bake cannot {beyond_bakes(stack, live)}"
    return Choice(chosen, lobe_set, tuple(candidate for candidate, _ in tried), reason, stock)


def _try_ramps(baker: RampBaker, glossy: int, tolerance: float, judge: Callable[[str, object], float]) -> None:
    """Judge bakes for OSL alone with ever more glossy lobes until one is well within the tolerance, or gains next to nothing."""
    before = np.inf
    for count in baker.counts(glossy):
        error = judge(f"ramp, {count} glossy", baker.lobe_set(count))
        if error <= _WELL_WITHIN * tolerance or error > _GAIN * before:
            return
        before = error


def _try_bakes(baker: Baker, glossy: int, tolerance: float, least_error: Callable[[int], float], judge: Callable[[str, object], float]) -> None:
    """Judge bakes with ever more glossy lobes until one is within the tolerance. Those that by their `least_error` will hardly be are left out, and if none is
    judged too, from the last on, while they are as close as the closest. One lobe more that gains next to nothing is no bake of its own."""
    most, left_out, least, before = min(glossy, baker.most_glossy), [], np.inf, np.inf

    def error(count: int) -> float:
        return judge(f"baked, {count} glossy", baker.lobe_set(baker.path(count, known=True)))

    for count in range(1, most + 1):
        expected = least_error(count)
        if count < most and _LIKELY * expected > tolerance:
            left_out.append(count)
        elif least == np.inf or expected <= _GAIN * before:
            least = min(least, error(count))
        if least <= tolerance:
            return
        before = expected
    for count in reversed(left_out):
        close = least * (1.0 + _AS_CLOSE)
        if _SURELY * least_error(count) > close or (now := error(count)) > close:
            return
        least = min(least, now)


def _best(tried: list[tuple[Candidate, Any]], tolerance: float, count: int | None = None) -> tuple[tuple[Candidate, Any], str]:
    """What to take of candidates and their lobe sets, of `count` that were tried, and why."""
    good = [t for t in tried if t[0].visible <= tolerance]
    if good:
        return min(good, key=lambda t: (t[0].cost, t[0].visible)), f"the cheapest whose error is at most {100.0 * tolerance:g} %"
    best = min(candidate.visible for candidate, _ in tried)
    close = min((t for t in tried if t[0].visible <= best * (1.0 + _AS_CLOSE)), key=lambda t: (t[0].cost, t[0].visible))
    return close, f"the cheapest of those about as close as the closest; none of {count or len(tried)} reaches {100.0 * tolerance:g} %"


def choose_brushed(stack: Stack, options: Options, cosines: np.ndarray | None = None, light_deg: float = SOFT_LIGHT_DEG) -> Choice:
    """As `choose`, for a stack of which `is_brushed` is true: a bake is tried too, but not of a bare metal, or, where values are live and it follows them, alone."""
    plain, report, live = isotropic(stack), options.report, options.live
    truth, brushing = truth_of(plain), tuple(Place(i, ANISOTROPY.name) for i, element in places(stack) if element.has(ANISOTROPY))
    choice = choose(plain, truth, replace(options, live=brushing, progress=lambda share: report(0.3 * share)), cosines, light_deg)
    if not live and is_bare_brushed(stack):
        reason = f"{choice.reason}; errors are those without {in_words(brushing)}"
        return replace(choice, lobe_set=_LIVE[choice.chosen.label](stack), reason=reason)
    if not follows(stack, live):
        choice = with_anisotropy(choice, stack, options.tolerance, cosines)
        return replace(choice, reason=f"{choice.reason}; a bake cannot {beyond_bakes(stack, live)}")
    lobe_set = baked(stack, live, DEFAULT_GLOSSY, lambda share: report(0.3 + 0.5 * share))
    errors = ErrorEstimator(plain, truth, ball_cosines() if cosines is None else cosines, light_deg).errors(level(plain))
    candidate = _candidate(f"baked over {in_words(live)}, brushed" if live else "baked, brushed", lobe_set, errors, bool(live))
    tried = (candidate,) if live else (*choice.tried, candidate)
    return with_anisotropy(replace(choice, tried=tried), stack, options.tolerance, cosines, {candidate.label: lobe_set})


def with_anisotropy(
    choice: Choice, stack: Stack, tolerance: float, cosines: np.ndarray | None = None, bakes: Mapping[str, LobeSet] = MappingProxyType({})
) -> Choice:
    """The choice for a stack with anisotropy, of what was tried without: albedos are compared with walks through the whole stack. `bakes` are those of the tried that are no live method.

    At a few of the view `cosines` (n,), those of a ball's pixels unless given, and at `_AZIMUTHS`. Soft light and shape stay those
    of the isotropic stack.
    """
    views = np.sort(ball_cosines() if cosines is None else cosines)
    views = views[np.unique(np.linspace(0, len(views) - 1, _FEW).round().astype(int))]
    wo = spherical(np.arccos(views)[:, None], _AZIMUTHS)
    truth, stderr = PositionFree(stack, walks=_WALKS).albedo_stderr(wo)
    tried = []
    for candidate in choice.tried:
        if candidate.label in _LIVE or candidate.label in bakes:
            lobe_set: LobeSet = bakes[candidate.label] if candidate.label in bakes else _LIVE[candidate.label](stack)
            albedo = np.stack([sum(lobe_energy(lobe, views, phi) for lobe in lobe_set.lobes(views, phi)) for phi in _AZIMUTHS], axis=1)
            error = float(np.max(albedo_error(albedo, truth)))
            tried.append((replace(candidate, albedo=error), lobe_set))
    (chosen, lobe_set), reason = _best(tried, tolerance)
    noise = float(np.max(worst_share(stderr, truth)))
    reason += f"; albedo is judged with the anisotropy (standard error {100.0 * noise:.2g} %), soft light and shape without it"
    return Choice(chosen, lobe_set, tuple(candidate for candidate, _ in tried), reason, chosen)


def _make(stack: Stack, options: Options) -> Made:
    choice = COMPUTED.result(stack, options)
    return Made(NAME, stack, choice.lobe_set.with_values_of(stack), f"{choice.chosen}: {choice.reason}", choice)


def _candidate(label: str, lobe_set, errors: Errors, live: bool) -> Candidate:
    means = float(np.mean(errors.soft_light)), float(np.mean(errors.shape))
    return Candidate(label, lobe_set.lobe_count, cost(lobe_set, live), float(np.max(errors.albedo)), *means)


def _pack(choice: Choice) -> dict:
    live = choice.chosen.label in _LIVE
    return {
        "chosen": choice.tried.index(choice.chosen),
        "stock": asdict(choice.stock),
        "lobe_set": None if live else pack_lobes(choice.lobe_set),
        "tried": [asdict(candidate) for candidate in choice.tried],
        "reason": choice.reason,
    }


def _unpack(data: dict, stack: Stack) -> Choice:
    tried = tuple(Candidate(**candidate) for candidate in data["tried"])
    chosen = tried[data["chosen"]]
    lobe_set = unpack_lobes(data["lobe_set"], stack) if data["lobe_set"] else _LIVE[chosen.label](stack)
    return Choice(chosen, lobe_set, tried, str(data["reason"]), Candidate(**data["stock"]))


COMPUTED = Computed(
    compute=lambda stack, options: choose_brushed(stack, options) if is_brushed(stack) else choose(stack, truth_of(stack), options),
    key=lambda stack, options: f"auto {stack_key(stack, options.live)} {options.tolerance:g} {options.glossy or MAX_GLOSSY}",
    pack=_pack,
    unpack=_unpack,
    most_glossy=MAX_GLOSSY,
)

METHOD = Method(
    NAME,
    _make,
    lambda stack, live: True,
    COMPUTED,
    Support(features=(ANISOTROPY, THIN_FILM, SCATTERING)),
)
