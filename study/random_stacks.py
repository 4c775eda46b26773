# SPDX-License-Identifier: GPL-3.0-or-later
"""Random stacks by a generator that is passed in: what constants are fitted to, and what is held out."""

import numpy as np

from ..reference_py.schema import METALS
from ..reference_py.stack import Stack

# Of layers: index of refraction, and the alphas that every kind of set has.
_IOR = (1.2, 2.1)
_ALPHA = 0.8
_TINTED, _METAL, _BECKMANN, _SMOOTH = 0.4, 0.6, 0.4, 0.15


def plain_stacks(rng: np.random.Generator, count: int) -> list[Stack]:
    """Stacks of one or two layers, two in five tinted, three in five over metals."""
    return [_stack(rng, int(rng.integers(1, 3)), strong=False) for _ in range(count)]


def hard_stacks(rng: np.random.Generator, count: int) -> list[Stack]:
    """Stacks of three to six rough and strongly tinted layers."""
    return [_stack(rng, int(rng.integers(3, 7)), strong=True) for _ in range(count)]


def _stack(rng: np.random.Generator, layers: int, strong: bool) -> Stack:
    return Stack.from_dict({"layers": [_layer(rng, strong) for _ in range(layers)], "base": _base(rng)})


def _layer(rng: np.random.Generator, strong: bool) -> dict:
    layer = {"kind": "dielectric", "ior": float(rng.uniform(*_IOR)), **_surface(rng, may_be_smooth=not strong)}
    if strong:
        layer |= {"tint": rng.uniform(0.1, 0.7, 3).tolist()}
    elif rng.random() < _TINTED:
        layer |= {"tint": rng.uniform(0.2, 1.0, 3).tolist(), "thickness": float(rng.uniform(0.2, 1.5))}
    return layer


def _base(rng: np.random.Generator) -> dict:
    if rng.random() < _METAL:
        return {"kind": "conductor", "metal": METALS[int(rng.integers(len(METALS)))], **_surface(rng)}
    return {"kind": "lambert", "color": rng.uniform(0.05, 0.95, 3).tolist()}


def _surface(rng: np.random.Generator, may_be_smooth: bool = True) -> dict:
    """Even in alpha's root, which is the roughness."""
    smooth = may_be_smooth and rng.random() < _SMOOTH
    low = 0.0 if may_be_smooth else 0.3
    roughness = 0.0 if smooth else float(rng.uniform(low, _ALPHA**0.5))
    return {"roughness": roughness, "distribution": "beckmann" if rng.random() < _BECKMANN else "ggx"}
