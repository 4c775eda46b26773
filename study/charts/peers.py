# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina chart peers`: what others make of media that scatter, and what it costs, beside the truth's two ways and a bake.

Each stack of the suite by LayeredBxDF of pbrt-v4 (`layered_bxdf`: his ten events, and 200 of them), by the statistical operators of Belcour 2018, by a
bake of two glossy lobes and by the walks of `position_free`, all in numpy on one core and held against `adding`.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...reference_py.atomic import require_writable
from ...reference_py.material.stack import Stack
from ...reference_py.models.baselines import LayeredBxdf
from ...reference_py.optics.error_measure import albedo_error
from ...reference_py.optics.frame import spherical
from ...reference_py.optics.quadrature import cosine_directions, points
from ...reference_py.registry import make_model
from ..suite import scattering_suite
from ..tables import Report, write_table
from .output import print_table, pyplot, save_picture

VIEWS_DEG = (0.0, 40.0, 65.0)
LIGHTS = 64
EQUAL = 0.02
"""Noise of f, as a share of its mean, at which costs of what is stochastic are compared."""
COLUMNS = ("stack", "model", "albedo", "shape", "noise", "prepare_s", "ms_per_f")
_HEADING = (
    "lamina chart peers",
    f"against adding at {', '.join(f'{v:g}' for v in VIEWS_DEG)} degrees and {LIGHTS} lights each, seed 1; albedo: relative, worst view and channel",
    "shape: cosine-weighted L1 of f over its mean, the channel where it is worst, mean of the views, noise included",
    f"noise: the same of the standard error; ms_per_f: CPU of one f of all channels, where it is stochastic of as many walks as bring its noise to {EQUAL:g}",
)
_WALKS = 200
_ALBEDO = 100  # times as many
_MANY = 200
_COLORS = {"layered_bxdf": "tab:orange", "layered_bxdf_200": "tab:brown", "belcour": "tab:purple", "baked": "tab:blue", "position_free": "0.4", "adding": "k"}


@dataclass(frozen=True)
class _Way:
    """A way to have f and albedo: `make` gives it for a stack and a number of walks, 0 where it has no noise."""

    name: str
    make: Callable
    is_stochastic: bool


WAYS = (
    _Way("layered_bxdf", lambda stack, walks: LayeredBxdf(stack, walks, seed=1), True),
    _Way("layered_bxdf_200", lambda stack, walks: LayeredBxdf(stack, walks, _MANY, seed=1), True),
    _Way("belcour", lambda stack, walks: make_model("belcour", stack), False),
    _Way("baked", lambda stack, walks: make_model("closure_model", stack, method="baked"), False),
    _Way("position_free", lambda stack, walks: make_model("position_free", stack, walks=walks, seed=1), True),
    _Way("adding", lambda stack, walks: make_model("adding", stack), False),
)


def chart(folder: Path, report: Report) -> None:
    """Write scattering_peers.csv and .png, and print the medians of each way."""
    table = folder / "scattering_peers.csv"
    require_writable(table)
    rows = list(peer_rows(scattering_suite().items(), report))
    print_table(("model", "albedo", "worst", "shape", "worst", "ms_per_f"), list(_medians(rows)))
    write_table(table, _HEADING, COLUMNS, rows, report)
    plt = pyplot(report)
    if plt is not None:
        save_picture(_picture(plt, rows), folder / "scattering_peers.png", report)


def peer_rows(stacks: Iterable[tuple[str, Stack]], report: Report, walks: int = _WALKS) -> Iterator[list[str]]:
    """One row for each stack and way; `walks` for each pair of directions."""
    for name, stack in stacks:
        report(name)
        wo, wi = _pairs()
        truth = make_model("adding", stack)
        f, albedo = truth.f(wo, wi), truth.albedo(_views())
        for way in WAYS:
            start = time.process_time()
            model = way.make(stack, walks)
            if not way.is_stochastic:
                model.albedo(_views()), model.f(wo[:1], wi[:1])
            prepared = time.process_time()
            value, stderr = model.f_stderr(wo, wi) if way.is_stochastic else (model.f(wo, wi), np.zeros_like(f))
            seconds = (time.process_time() - prepared) / len(wo)
            found = way.make(stack, _ALBEDO * walks).albedo_stderr(_views())[0] if way.is_stochastic else model.albedo(_views())
            noise = _share(stderr, f)
            cost = seconds * (noise / EQUAL) ** 2 if way.is_stochastic else seconds
            numbers = (np.max(albedo_error(found, albedo)), _share(np.abs(value - f), f), noise, prepared - start, 1e3 * cost)
            yield [name, way.name, *(f"{v:.4g}" for v in numbers)]


def _views() -> np.ndarray:
    return spherical(np.radians(VIEWS_DEG), 0.0)


def _pairs() -> tuple[np.ndarray, np.ndarray]:
    """(wo, wi) (n, 3); lights of each view are as dense as their cosine."""
    return np.repeat(_views(), LIGHTS, axis=0), np.tile(cosine_directions(*points(LIGHTS)), (len(VIEWS_DEG), 1))


def _share(values: np.ndarray, f: np.ndarray) -> float:
    """Mean of the views of the mean over lights (n, channels), over that of f; the worst channel. Channels that are black do not count."""
    part, whole = (np.mean(v.reshape(len(VIEWS_DEG), LIGHTS, -1), axis=1) for v in (values, f))
    return float(np.max(np.mean(part / np.maximum(whole, 1e-3 * np.max(whole)), axis=0)))


def _medians(rows: list[list[str]]) -> Iterator[list[str]]:
    for way in WAYS:
        albedo, shape, _, _, cost = np.array([row[2:] for row in rows if row[1] == way.name], float).T
        yield [way.name, *(f"{v:.3g}" for v in (np.median(albedo), np.max(albedo), np.median(shape), np.max(shape), np.median(cost)))]


def _picture(plt, rows: list[list[str]]):
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.6), sharex=True, layout="constrained")
    for axis, column, what in ((axes[0], 2, "albedo: worst relative error"), (axes[1], 3, "shape: L1 of f over its mean")):
        for way in WAYS[:-1]:
            own = np.array([(row[6], row[column]) for row in rows if row[1] == way.name], float)
            axis.scatter(own[:, 0], np.maximum(own[:, 1], 1e-4), s=16, color=_COLORS[way.name], label=way.name)
        axis.set(xscale="log", yscale="log", xlabel=f"CPU ms of one f (noise of {EQUAL:.0%} where stochastic)", ylabel=what)
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=8)
    return figure
