# SPDX-License-Identifier: GPL-3.0-or-later
"""A layer's tint given as a spectrum: `"tint_spectrum": {"wavelengths_nm": [...], "transmittance": [...]}`.

It is integrated to the layer's `tint` at the layer's thickness over the stack's base, under the stack's `illuminant`. What it was integrated to stays in it,
as its own `tint`: where a layer has another tint, somebody gave it that, and the spectrum has no effect. So a tint that an artist
sets in Blender counts, and so does that of a stack of before, to which the key meant nothing.
"""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

from ..errors import LaminaError, one_of
from .schema import ILLUMINANTS

Part = TypeVar("Part", bound=Any)

KEY, ILLUMINANT = "tint_spectrum", "illuminant"
MOST_SAMPLES = 1000
_WAVELENGTHS, _TRANSMITTANCE = "wavelengths_nm", "transmittance"
# Reflectance of a metal, and the least of a diffuse base, by which colors are matched.
_METAL, _DARKEST = 0.9, 0.02
# What single precision leaves of a tint.
_CLOSE = 1e-5


def with_tint(layer: Part, base: Part, illuminant, has_own: bool, where: str) -> Part:
    """A layer with the tint of its spectrum; as it is where it has none, or a tint of its own, which `has_own` says may be.

    Raises LaminaError naming `where` and what is wrong with the spectrum or the illuminant.
    """
    spectrum = layer.unknown.get(KEY)
    if KEY not in layer.unknown or (has_own and not _is_its_tint(spectrum, layer["tint"])):
        return layer
    nm, transmittance = _checked(spectrum, where)
    one_of(where, ILLUMINANT, illuminant, ILLUMINANTS)
    # here, as nothing else of a stack needs numpy
    from ..optics.colour.tint import tint_of_spectrum

    reflectance = sum(base["color"]) / 3.0 if "color" in base else _METAL
    tint = tint_of_spectrum(nm, transmittance, layer["thickness"], layer["ior"], max(reflectance, _DARKEST), "color" not in base, illuminant)
    kept = {**layer.unknown, KEY: {**spectrum, "tint": list(tint)}}
    return replace(layer.with_values(tint=tint), unknown=MappingProxyType(kept))


def spectrum_of(layer) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Wavelengths in nm and transmittances of a layer's spectrum; None where it has none that has an effect."""
    spectrum = layer.unknown.get(KEY)
    return _checked(spectrum, "layer") if _is_its_tint(spectrum, layer.values.get("tint")) else None


def _is_its_tint(spectrum, tint) -> bool:
    own = spectrum.get("tint") if isinstance(spectrum, Mapping) else None
    if not (_is_numbers(own) and _is_numbers(tint) and len(own) == len(tint)):
        return False
    return all(abs(a - b) <= _CLOSE * max(abs(a), 0.1) for a, b in zip(own, tint))


def _is_numbers(values) -> bool:
    return isinstance(values, (list, tuple)) and all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values)


def _checked(spectrum, where: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if not isinstance(spectrum, Mapping) or not all(_is_numbers(spectrum.get(key)) for key in (_WAVELENGTHS, _TRANSMITTANCE)):
        raise LaminaError(
            "{where}: {key} must be an object with two lists of numbers, {wavelengths} and {transmittance}",
            where=where,
            key=KEY,
            wavelengths=_WAVELENGTHS,
            transmittance=_TRANSMITTANCE,
        )
    nm, transmittance = (tuple(map(float, spectrum[key])) for key in (_WAVELENGTHS, _TRANSMITTANCE))
    if len(nm) != len(transmittance) or not 2 <= len(nm) <= MOST_SAMPLES:
        raise LaminaError(
            "{where}: {key} has {count} {wavelengths} and {values} {transmittance}; choose as many of both, 2 to {most}",
            where=where,
            key=KEY,
            count=len(nm),
            wavelengths=_WAVELENGTHS,
            values=len(transmittance),
            transmittance=_TRANSMITTANCE,
            most=MOST_SAMPLES,
        )
    if not all(a < b for a, b in zip(nm, nm[1:])) or not 100.0 <= nm[0] or not nm[-1] <= 10000.0:
        raise LaminaError(
            "{where}: {key}: {wavelengths} must increase, from 100 nm at least to 10000 nm at most, not {first:g} to {last:g}",
            where=where,
            key=KEY,
            wavelengths=_WAVELENGTHS,
            first=nm[0],
            last=nm[-1],
        )
    if not all(0.0 <= t <= 1.0 for t in transmittance):
        worst = next(t for t in transmittance if not 0.0 <= t <= 1.0)
        raise LaminaError(
            "{where}: {key}: {transmittance} is {worst:g}; choose 0 to 1, what one crossing of unit thickness leaves",
            where=where,
            key=KEY,
            transmittance=_TRANSMITTANCE,
            worst=worst,
        )
    return nm, transmittance
