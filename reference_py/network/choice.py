# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `auto`: the cheapest way to tell Cycles about a stack whose error stays under a tolerance."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace

import numpy as np

from ..errors import LaminaError
from ..frame import spherical
from ..stack import Stack
from .analytic import AnalyticNetwork
from .baking import DEFAULT_GLOSSY, MAX_GLOSSY, Baker, axes_of, baked, described, pack_network, unpack_network
from .closure import lobe_energy
from .cost import cost
from .featured import featured_analytic
from .grid import GridNetwork
from .judge import SOFT_LIGHT_DEG, Errors, Judge, ball_cosines
from .lobe import DiffuseLobe, GlossyLobe
from .memory import content, known, remembered, truth_of
from .table import TableNetwork
from .weidlich_wilkie import WeidlichWilkieNetwork

DEFAULT_TOLERANCE = 0.02
# Errors that differ by less than this share of them are as good: the cheaper one is taken.
_AS_CLOSE = 0.05
# Of albedos with anisotropy: azimuths, views, and walks for each.
_AZIMUTHS = np.radians([0.0, 45.0, 90.0, 135.0])
_FEW, _WALKS = 4, 1 << 15
_LIVE_TIERS = {network.tier: network for network in (WeidlichWilkieNetwork, AnalyticNetwork)}


@dataclass(frozen=True)
class Candidate:
    """One way to tell Cycles: closures, estimated cost in units of a plain glossy node's, errors as shares of the light.

    `albedo` is the worst view's, `soft_light` and `shape` are means over the views; all of the worst channel.
    """

    label: str
    closures: int
    cost: float
    albedo: float
    soft_light: float
    shape: float

    @property
    def seen(self) -> float:
        return max(self.albedo, self.soft_light)

    def __str__(self) -> str:
        return f"{self.label}, error {100.0 * self.seen:.3g} %, cost {self.cost:.2g}x"


@dataclass(frozen=True)
class Choice:
    """What was chosen and its network, what was tried, and why as a sentence."""

    chosen: Candidate
    network: object
    tried: tuple[Candidate, ...]
    reason: str


class AutoNetwork:
    """What `choose` chose for a stack. Stacks of equal content share one choice (`memory`).

    `live` names the values that a texture or an animation gives, as (index of the layer or -1, parameter); bakes are
    tried with at most `glossy` glossy lobes.
    """

    tier = "auto"

    def __init__(
        self,
        stack: Stack,
        live: tuple[tuple[int, str], ...] = (),
        tolerance: float = DEFAULT_TOLERANCE,
        progress: Callable[[float], None] | None = None,
        glossy: int = MAX_GLOSSY,
    ):
        self.stack = stack
        self.choice = remembered(
            self.key(stack, live, tolerance, glossy), lambda: choose(stack, truth_of(stack), live, tolerance, progress=progress, glossy=glossy),
            _pack, lambda data: _unpack(data, stack),
        )  # fmt: skip
        self.resolved = _with_values_of(stack, self.choice.network)
        self.reason = f"{self.choice.chosen}: {self.choice.reason}"

    @staticmethod
    def key(stack: Stack, live: tuple[tuple[int, str], ...] = (), tolerance: float = DEFAULT_TOLERANCE, glossy: int = MAX_GLOSSY) -> str:
        """What a choice is remembered by."""
        return f"auto {content(stack, live)} {tolerance:g} {glossy}"

    @classmethod
    def is_known(cls, stack: Stack, live: tuple[tuple[int, str], ...] = (), tolerance: float = DEFAULT_TOLERANCE, glossy: int = MAX_GLOSSY) -> bool:
        """Whether making the network takes no time, as it was made before."""
        return known(cls.key(stack, live, tolerance, glossy), lambda data: _unpack(data, stack)) is not None

    def packed(self) -> dict:
        """The choice as JSON's types, for `remember`."""
        return _pack(self.choice)

    @classmethod
    def remember(cls, key: str, stack: Stack, data: dict) -> None:
        """Remember what `packed` gave in another process."""
        remembered(key, lambda: _unpack(data, stack), _pack, lambda packed: _unpack(packed, stack))

    @property
    def lobe_count(self) -> int:
        return self.resolved.lobe_count

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        return self.resolved.lobes(cos_theta_o, phi)


def choose(
    stack: Stack,
    truth,
    live: tuple[tuple[int, str], ...] = (),
    tolerance: float = DEFAULT_TOLERANCE,
    cosines: np.ndarray | None = None,
    light_deg: float = SOFT_LIGHT_DEG,
    progress: Callable[[float], None] | None = None,
    glossy: int = MAX_GLOSSY,
) -> Choice:
    """The cheapest candidate whose error is at most `tolerance`, or the closest if none is; bakes have at most `glossy` glossy lobes.

    Judged at view `cosines` (n,), those of a ball's pixels unless given, under lights `light_deg` wide. Where values
    are live, the only bake is the one that follows them, if there is one. `progress` gets the share done and may raise to cancel.
    Raises LaminaError for a tolerance outside 0 to 1.
    """
    if not 0.0 < tolerance <= 1.0:
        raise LaminaError(f"tolerance {100.0 * tolerance:g} percent: choose more than 0 and at most 100")
    report = progress or (lambda share: None)
    judge = Judge(stack, truth, ball_cosines() if cosines is None else cosines, light_deg)
    report(0.2)
    axes = axes_of(stack, live)
    makers = [(tier, lambda network=network: network(stack)) for tier, network in _LIVE_TIERS.items()]
    if not live:
        baker = Baker(stack, truth)
        makers += [(f"baked, {k} glossy", lambda k=k: baker.bake(k).network) for k in range(1, glossy + 1)]
    elif axes is not None:
        makers.append((f"baked over {described(live)}", lambda: baked(stack, axes, min(DEFAULT_GLOSSY, glossy), lambda share: report(0.4 + 0.6 * share))))
    tried: list[tuple[Candidate, object]] = []
    for done, (label, make) in enumerate(makers):
        network = make()
        tried.append((_candidate(label, network, judge.errors(network), bool(live)), network))
        report(0.2 + 0.8 * (done + 1) / len(makers))
        if label not in _LIVE_TIERS and tried[-1][0].seen <= tolerance:
            break  # more lobes cost more
    (chosen, network), reason = _best(tried, tolerance)
    if live and axes is None:
        reason += f"; a bake cannot follow {described(live)}"
    return Choice(chosen, network, tuple(candidate for candidate, _ in tried), reason)


def _best(tried: list[tuple[Candidate, object]], tolerance: float) -> tuple[tuple[Candidate, object], str]:
    """What to take of candidates and their networks, and why."""
    good = [t for t in tried if t[0].seen <= tolerance]
    if good:
        return min(good, key=lambda t: t[0].cost), f"the cheapest whose error is at most {100.0 * tolerance:g} %"
    best = min(candidate.seen for candidate, _ in tried)
    close = min((t for t in tried if t[0].seen <= best * (1.0 + _AS_CLOSE)), key=lambda t: t[0].cost)
    return close, f"the cheapest of those about as close as the closest; none of {len(tried)} reaches {100.0 * tolerance:g} %"


def with_anisotropy(choice: Choice, stack: Stack, tolerance: float, cosines: np.ndarray | None = None) -> Choice:
    """The choice for a stack with anisotropy, of what was tried without: albedos are compared with walks through the whole stack.

    At a few of the view `cosines` (n,), those of a ball's pixels unless given, and at `_AZIMUTHS`. Soft light and shape stay those
    of the isotropic stack.
    """
    from ..models.position_free import PositionFree  # models import networks

    views = np.sort(ball_cosines() if cosines is None else cosines)
    views = views[np.unique(np.linspace(0, len(views) - 1, _FEW).round().astype(int))]
    wo = spherical(np.arccos(views)[:, None], _AZIMUTHS)
    truth, stderr = PositionFree(stack, walks=_WALKS).albedo_stderr(wo)
    tried = []
    for candidate in choice.tried:
        if candidate.label in _LIVE_TIERS:
            network = featured_analytic(stack) if candidate.label == AnalyticNetwork.tier else _LIVE_TIERS[candidate.label](stack)
            albedo = np.stack([sum(lobe_energy(lobe, views, phi) for lobe in network.lobes(views, phi)) for phi in _AZIMUTHS], axis=1)
            error = float(np.max(np.abs(albedo - truth) / truth))
            tried.append((replace(candidate, albedo=error), network))
    (chosen, network), reason = _best(tried, tolerance)
    noise = float(np.max(stderr / truth))
    reason += f"; albedo is judged with the anisotropy (standard error {100.0 * noise:.2g} %), soft light and shape without it"
    return Choice(chosen, network, tuple(candidate for candidate, _ in tried), reason)


def _with_values_of(stack: Stack, network):
    """A remembered network with a stack's own live values."""
    if isinstance(network, TableNetwork):
        return network
    return replace(network, stack=stack) if isinstance(network, GridNetwork) else type(network)(stack)


def _candidate(label: str, network, errors: Errors, live: bool) -> Candidate:
    means = float(np.mean(errors.soft_light)), float(np.mean(errors.shape))
    return Candidate(label, network.lobe_count, cost(network, live), float(np.max(errors.albedo)), *means)


def _pack(choice: Choice) -> dict:
    live = choice.chosen.label in _LIVE_TIERS
    return {
        "chosen": choice.tried.index(choice.chosen),
        "network": None if live else pack_network(choice.network),
        "tried": [asdict(candidate) for candidate in choice.tried],
        "reason": choice.reason,
    }


def _unpack(data: dict, stack: Stack) -> Choice:
    tried = tuple(Candidate(**candidate) for candidate in data["tried"])
    chosen = tried[data["chosen"]]
    network = unpack_network(data["network"], stack) if data["network"] else _LIVE_TIERS[chosen.label](stack)
    return Choice(chosen, network, tried, str(data["reason"]))
