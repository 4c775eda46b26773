# SPDX-License-Identifier: GPL-3.0-or-later
"""Where models fail: hard stacks and directions, and what every model of the registry does there.

A case is a stack and the views it is looked at from; `measure` gives one row of the table figures/stress.csv.
Cases that no model ever sees, since `Stack` refuses them, are in `REFUSED`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np

from ..reference_py.errors import LaminaError
from ..reference_py.lobes.methods import DEFAULT_METHOD, METHODS
from ..reference_py.lobes.methods.closure_model import ClosureModel
from ..reference_py.material.stack import Stack
from ..reference_py.optics.frame import normalize, reflect, spherical
from ..reference_py.optics.quadrature import points
from ..reference_py.registry import MODELS, make_model
from .suite import suite_stack

SIGMAS = 4.0
"""How far the noise of a stochastic model may carry it: figures below are what exceeds that."""
WALKS = 200
FLOOR = 1e-3
"""f in 1/sr that is added to the denominator of relative differences: less is not seen."""

_VIEWS_DEG = (0.0, 40.0, 75.0)
_GRAZING_DEG = (85.0, 88.0, 89.0, 89.9)


@dataclass(frozen=True)
class Case:
    """A stack, the views it is tried at, and its albedo where that is known without any model."""

    stack: Stack
    views_deg: tuple[float, ...] = _VIEWS_DEG
    exact: float | None = None
    directions: str = "above"
    """What `pairs` pairs the views with: "above", "below" (the horizon) or "opposite" (wi = -wo)."""


@dataclass(frozen=True)
class Row:
    """What a model does in a case. Numbers are the worst over views, pairs and channels, beyond 4 standard errors."""

    finite: bool
    non_negative: bool
    energy_excess: float
    """Albedo above 1."""
    exact_error: float | None
    """Distance of the albedo from the known one; None where none is known."""
    reciprocity: float
    """|f(o, i) - f(i, o)|, relative to the larger + `FLOOR`."""
    float32_drift: float
    """|f - f of directions rounded to float32|, likewise relative."""
    below_horizon: float
    """f and albedo where light or view is below the horizon."""


def _layer(ior=1.5, alpha=0.0, **values) -> dict:
    return {"kind": "dielectric", "ior": ior, "roughness": alpha**0.5, **values}


def _lambert(value: float) -> dict:
    return {"kind": "lambert", "color": [value] * 3}


def _metal(alpha: float, **values) -> dict:
    return {"kind": "conductor", "metal": "gold", "roughness": alpha**0.5, **values}


def _stack(*layers: dict, base: dict) -> Stack:
    return Stack.from_dict({"layers": list(layers), "base": base})


_ROUGH = _stack(_layer(1.5, 0.3), base=_metal(0.1))
_TINT = [0.2, 0.5, 0.9]

CASES: Mapping[str, Case] = MappingProxyType(
    {
        "grazing, smooth over lambert": Case(_stack(_layer(), base=_lambert(0.5)), _GRAZING_DEG),
        "grazing, rough over lambert": Case(_stack(_layer(1.5, 0.3), base=_lambert(0.5)), _GRAZING_DEG),
        "grazing, smooth over metal": Case(_stack(_layer(), base=_metal(0.2)), _GRAZING_DEG),
        "grazing, rough over metal": Case(_ROUGH, _GRAZING_DEG),
        "grazing, bare metal": Case(_stack(base=_metal(0.3)), _GRAZING_DEG),
        "equal indices": Case(_stack(_layer(1.0, 0.3), base=_lambert(0.5)), exact=0.5),
        "equal indices inside": Case(_stack(_layer(), _layer(1.5, 0.3), base=_lambert(0.5))),
        "denser above thinner, smooth": Case(_stack(_layer(1.8), _layer(1.2), base=_lambert(0.8))),
        "denser above thinner, rough": Case(_stack(_layer(1.8, 0.1), _layer(1.2, 0.3), base=_metal(0.2))),
        "air gap": Case(_stack(_layer(1.5), _layer(1.0, 0.1), base=_lambert(0.8))),
        "index 4": Case(_stack(_layer(4.0, 0.1), base=_lambert(0.8))),
        "alpha 0": Case(_stack(_layer(), base=_metal(0.0))),
        "alpha .001": Case(_stack(_layer(1.5, 0.001), base=_metal(0.001))),
        "alpha 1": Case(_stack(_layer(1.5, 1.0), base=_metal(1.0))),
        "alpha 1, beckmann": Case(_stack(_layer(1.5, 1.0, distribution="beckmann"), base=_metal(1.0, distribution="beckmann"))),
        "thickness 0": Case(_stack(_layer(1.0, tint=_TINT, thickness=0.0), base=_lambert(0.5)), exact=0.5),
        "thickness 1000": Case(_stack(_layer(1.5, 0.1, tint=_TINT, thickness=1000.0), base=_lambert(0.8))),
        "absorption 0 and huge": Case(_stack(_layer(1.5, 0.1, tint=[1.0, 0.0, 0.5]), base=_lambert(0.8))),
        "rough over smooth": Case(_stack(_layer(1.5, 0.5), base=_metal(0.0))),
        "smooth over rough": Case(_stack(_layer(), base=_metal(0.5))),
        "rough over smooth, layers": Case(_stack(_layer(1.5, 0.5), _layer(1.3), base=_lambert(0.8))),
        "8 layers": Case(suite_stack("eight_layers")),
        "20 smooth layers": Case(suite_stack("twenty_smooth")),
        "20 rough layers": Case(suite_stack("twenty_rough")),
        "white, bare": Case(_stack(base=_lambert(1.0)), exact=1.0),
        "white, oren-nayar": Case(_stack(base={"kind": "oren_nayar", "color": [1.0] * 3, "sigma_deg": 60.0})),
        "white, smooth": Case(_stack(_layer(), base=_lambert(1.0)), exact=1.0),
        "white, rough": Case(_stack(_layer(1.5, 0.4), base=_lambert(1.0)), exact=1.0),
        "white, grazing": Case(_stack(_layer(1.5, 0.1), base=_lambert(1.0)), _GRAZING_DEG, exact=1.0),
        "white, 8 layers": Case(suite_stack("eight_white"), exact=1.0),
        "below the horizon": Case(_ROUGH, directions="below"),
        "view on the horizon": Case(_ROUGH, (90.0,)),
        "no half vector": Case(_ROUGH, (60.0, 89.9), directions="opposite"),
    }
)

REFUSED: Mapping[str, dict] = MappingProxyType(
    {
        "thickness -1": {"layers": [_layer(thickness=-1.0)], "base": _lambert(0.5)},
        "thickness nan": {"layers": [_layer(thickness=float("nan"))], "base": _lambert(0.5)},
        "thickness inf": {"layers": [_layer(thickness=float("inf"))], "base": _lambert(0.5)},
        "tint nan": {"layers": [_layer(tint=[1.0, float("nan"), 1.0])], "base": _lambert(0.5)},
        "tint -0.1": {"layers": [_layer(tint=[1.0, -0.1, 1.0])], "base": _lambert(0.5)},
        "ior nan": {"layers": [_layer(ior=float("nan"))], "base": _lambert(0.5)},
        "ior -1.5": {"layers": [_layer(ior=-1.5)], "base": _lambert(0.5)},
        "roughness -0.1": {"layers": [{"kind": "dielectric", "roughness": -0.1}], "base": _lambert(0.5)},
        "roughness inf": {"layers": [], "base": {"kind": "conductor", "metal": "gold", "roughness": float("inf")}},
        "color nan": {"layers": [], "base": _lambert(float("nan"))},
        "color 1.5": {"layers": [], "base": _lambert(1.5)},
    }
)


# Every model, and what Cycles renders by every method; auto is one of the others.
_CLOSURE_MODELS = tuple(f"{ClosureModel.name}:{method}" for method in METHODS if method != DEFAULT_METHOD)
MODELS_AND_METHODS = tuple(each for name in MODELS for each in (_CLOSURE_MODELS if name == ClosureModel.name else (name,)))


def is_refused(data: dict) -> bool:
    """Whether `Stack` refuses the data, so that no model has to answer for it."""
    try:
        Stack.from_dict(data)
    except LaminaError:
        return True
    return False


def views(case: Case) -> np.ndarray:
    """Directions (V, 3) to the viewer."""
    return spherical(np.radians(case.views_deg), 0.3)


def pairs(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """(wo, wi), each (P, 3): every view with its mirror, itself, the normal, a grazing light and a few around."""
    wo = views(case)
    if case.directions == "opposite":
        # exactly opposite lies below the horizon; then both are on it, where the sum is null; then just above it
        level = normalize(wo * np.array([1.0, 1.0, 0.0]))
        turned = wo * np.array([-1.0, -1.0, 1.0])
        return np.concatenate([wo, level, wo]), np.concatenate([-wo, -level, turned])
    u1, u2 = points(4)
    around = spherical(np.arccos(np.sqrt(1.0 - u1)), 2.0 * np.pi * u2)
    fixed = np.concatenate([spherical(np.radians([0.0, 89.5]), 2.0), around])
    every = [np.concatenate([reflect(w, np.array([0.0, 0.0, 1.0]))[None], w[None], fixed]) for w in wo]
    wi = np.concatenate(every)
    wo = np.repeat(wo, len(every[0]), axis=0)
    if case.directions == "below":
        down = np.array([1.0, 1.0, -1.0])
        return np.concatenate([wo, wo * down, wo * down]), np.concatenate([wi * down, wi, wi * down])
    return wo, wi


def make_model_or_method(name: str, stack: Stack, walks: int = WALKS):
    """One of `MODELS_AND_METHODS` of a stack, with default options, but few walks. Raises LaminaError on an unknown name."""
    model, _, method = name.partition(":")
    options = {"method": method} if method else {}
    if model in MODELS and MODELS[model].stochastic:
        options["walks"] = walks
    return make_model(model, stack, **options)


def f_and_error(model, wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """f (..., 3) and its standard error, 0 for deterministic models."""
    return model.f_stderr(wo, wi) if model.stochastic else (f := model.f(wo, wi), np.zeros_like(f))


def albedo_and_error(model, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directional albedo (..., 3) and its standard error, 0 for deterministic models."""
    return model.albedo_stderr(wo) if model.stochastic else (a := model.albedo(wo), np.zeros_like(a))


def relative_difference(a, b) -> float:
    """Worst |a - b| beyond the noise, over the larger + `FLOOR`; a and b are (value, standard error)."""
    gap = np.maximum(np.abs(a[0] - b[0]) - SIGMAS * np.hypot(a[1], b[1]), 0.0)
    return _worst(gap / (np.maximum(np.abs(a[0]), np.abs(b[0])) + FLOOR))


def reciprocity_defect(model, wo: np.ndarray, wi: np.ndarray) -> float:
    """Worst relative |f(wo, wi) - f(wi, wo)| for directions (P, 3)."""
    return relative_difference(f_and_error(model, wo, wi), f_and_error(model, wi, wo))


def energy_excess(model, wo: np.ndarray) -> float:
    """Worst albedo above 1 for views (V, 3)."""
    value, stderr = albedo_and_error(model, wo)
    return max(_worst(value - SIGMAS * stderr - 1.0), 0.0)


def measure(name: str, case: Case) -> Row:
    """One row of the table for one of `MODELS_AND_METHODS`. Raises LaminaError on an unknown one."""
    model = make_model_or_method(name, case.stack)
    wo, wi = pairs(case)
    view = views(case) * (np.array([1.0, 1.0, -1.0]) if case.directions == "below" else 1.0)
    with np.errstate(all="ignore"):  # what is not finite is counted, not said
        f, albedo = f_and_error(model, wo, wi), albedo_and_error(model, view)
        rounded = f_and_error(model, wo.astype(np.float32), wi.astype(np.float32))
        beyond = albedo[0] - SIGMAS * albedo[1] - 1.0
        off = None
        if case.exact is not None:
            off = max(_worst(np.abs(albedo[0] - case.exact) - SIGMAS * albedo[1]), 0.0)
        hidden = (wo[:, 2] < 0.0) | (wi[:, 2] < 0.0)
        values = np.concatenate([f[0].ravel(), rounded[0].ravel(), albedo[0].ravel()])
        dark = np.concatenate([f[0][hidden].ravel(), albedo[0][view[:, 2] < 0.0].ravel()])
        return Row(
            finite=bool(np.all(np.isfinite(values))),
            non_negative=not np.any(values < 0.0),
            energy_excess=max(_worst(beyond), 0.0),
            exact_error=off,
            reciprocity=relative_difference(f, f_and_error(model, wi, wo)),
            float32_drift=relative_difference(f, rounded),
            below_horizon=_worst(np.abs(dark)),
        )


def _worst(values: np.ndarray) -> float:
    """Largest of the finite values; 0 without any."""
    return float(np.max(values, where=np.isfinite(values), initial=0.0))


COLUMNS = tuple(field.name for field in fields(Row))
