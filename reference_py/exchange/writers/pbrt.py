# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of pbrt-v4: RGL's table of spectra, or pbrt's own layered materials where they are the stack exactly.

These are one interface over a base, by random walks, with single facets of GGX: what light meets as the models say of `surface=single`. Their
medium has extinction 1, so that `thickness` is an optical depth. Colors would be made spectra of pbrt's choice, and reflections between layers are
not linear in them: so layered materials are grey.
"""

import numpy as np

from ...errors import LaminaError
from ...material.coverage import is_plain
from ...material.schema import SCATTERING
from ...material.stack import Stack
from ...optics.bases import DiffuseBase
from ...optics.interface import Interface, Microfacets
from ...optics.microfacet import GGX
from ...optics.optical_stack import OpticalStack, supports

# Walks end by themselves long before.
_MAX_DEPTH = 1000
# pbrt takes smaller ones for a mirror.
_LEAST_ALPHA = 1e-3
_OTHERWISE = "leave out --as layers for a table"


@supports("scene", distributions=(GGX,), features=(SCATTERING,))
class LayeredMaterial:
    """What pbrt's layered materials can be."""

    name = "pbrt"


def measured_material(name: str, table: str) -> str:
    """A named material with the file of a table of spectra, which stands beside it."""
    return _material(name, [("string type", "measured"), ("string filename", table)])


def layered_material(stack: Stack) -> str:
    """A named material of at most one layer. Raises LaminaError for what pbrt's are not exactly."""
    if not is_plain(stack):
        raise LaminaError(f"pbrt's layered materials cover the whole surface; {_OTHERWISE}")
    optics = OpticalStack.of(stack, LayeredMaterial)
    if len(optics.interfaces) > 1:
        raise LaminaError(f"pbrt's layered materials have one layer, this stack has {len(optics.interfaces)}; {_OTHERWISE}")
    base, base_values = _base(optics)
    if not optics.interfaces:
        return _material(stack.name, [("string type", base), *base_values])
    return _material(stack.name, [("string type", f"coated{base}"), *base_values, *_coat(optics.interfaces[0], "interface." if base == "conductor" else "")])


def _base(optics: OpticalStack) -> tuple[str, list]:
    """pbrt's name of the base's kind, and its values; under a coat a metal's have a prefix of their own."""
    base, prefix = optics.base, "conductor." if optics.interfaces else ""
    if isinstance(base, DiffuseBase):
        if base.sigma_deg > 0.0:
            raise LaminaError(f"pbrt has no rough diffuse base; {_OTHERWISE}")
        return "diffuse", [("spectrum reflectance", _flat("the base's color", base.color))]
    index = [(f"spectrum {prefix}{name}", _flat(f"the base's {name}", values)) for name, values in (("eta", base.eta), ("k", base.k))]
    return "conductor", [*index, (f"float {prefix}roughness", _alpha("the base", base.facets)), ("bool remaproughness", False)]


def _coat(interface: Interface, prefix: str) -> list:
    scattering = interface.scattering
    albedo, g = (np.zeros(3), 0.0) if scattering is None else (scattering.albedo, scattering.g)
    values = [
        (f"float {prefix}eta", interface.eta),
        (f"float {prefix}roughness", _alpha("layer 0", interface.facets)),
        ("float thickness", _grey("layer 0's medium", interface.tau)),
        ("spectrum albedo", _flat("layer 0's medium", albedo)),
        ("float g", g),
        ("integer maxdepth", _MAX_DEPTH),
    ]
    return values if prefix else [*values, ("bool remaproughness", False)]


def _alpha(where: str, facets: Microfacets) -> float:
    if facets.is_specular:
        return 0.0
    if facets.alpha < _LEAST_ALPHA:
        raise LaminaError(f"pbrt takes {where} for a mirror: its alpha is {facets.alpha:.2g}, less than {_LEAST_ALPHA}; {_OTHERWISE}")
    return facets.alpha


def _grey(where: str, values: np.ndarray) -> float:
    if np.ptp(values) > 0.0:
        raise LaminaError(f"pbrt's layered materials are exact for greys alone, and {where} is colored; {_OTHERWISE}")
    return float(values[0])


def _flat(where: str, values: np.ndarray) -> tuple[float, ...]:
    """A spectrum of one value: wavelengths and values in turn."""
    value = _grey(where, values)
    return (360.0, value, 830.0, value)


def _material(name: str, values: list[tuple[str, object]]) -> str:
    lines = [f'MakeNamedMaterial "{_quoted(name) or "surface"}"']
    return "\n    ".join([*lines, *(f'"{key}" {_written(value)}' for key, value in values)]) + "\n"


def _written(value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{_quoted(value)}"'
    return f"[ {' '.join(map(repr, value))} ]" if isinstance(value, tuple) else repr(value)


def _quoted(text: str) -> str:
    return text.replace("\\", "/").replace('"', "'")
