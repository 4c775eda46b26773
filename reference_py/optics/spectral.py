# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacks whose colours are spectra: the colour axis holds wavelengths in nm instead of RGB.

    stack = spectral_stack(presets.load("tinted_glaze"), wavelength_nm, tints={0: np.exp(-tau)})
    f = make_model("weidlich_wilkie", stack).f(wo, wi)      # (..., wavelengths)
    rgb = reflectance_to_rgb(f, wavelength_nm)

Bouguer's law (Weidlich07, eq. 5) then holds for each wavelength alone; for three broad channels it does not.
Such a stack is for models; those that know RGB alone, as shaders do, refuse it in one line. It is not for files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import LaminaError
from ..material.schema import COLOR, NORMAL, SCHEMA, THIN_FILM, VECTOR
from ..material.stack import Base, Layer, LayerOrBase, Stack
from ..material.tint_spectrum import spectrum_of
from .colour import metal_index, rgb_weights


@dataclass(frozen=True)
class SpectralStack(Stack):
    """A stack whose colours have one number for each of its wavelengths."""

    wavelength_nm: tuple[float, ...] = ()


def spectral_stack(
    stack: Stack,
    wavelength_nm: Sequence[float],
    tints: Mapping[int, Sequence[float]] | None = None,
    color: Sequence[float] | None = None,
) -> SpectralStack:
    """`stack` on increasing wavelengths (n,) in nm.

    tints: per layer index, what one crossing of unit thickness leaves, (n,); color: reflectance (n,) of a diffuse
    base. Greys count as flat spectra, named metals have their measured index and layers their `tint_spectrum`, so only what else is coloured must be
    given. Raises LaminaError for a coloured value without spectrum, a wrong length, values outside 0 to 1, and a thin film, which is for RGB.
    """
    nm = np.asarray(wavelength_nm, float)
    if nm.ndim != 1 or not len(nm) or not np.all(np.isfinite(nm)) or not np.all(np.diff(nm) > 0.0):
        raise LaminaError(f"wavelengths must be a list that increases, in nm; got {nm.tolist()}")
    tints = dict(tints or {})
    unknown = sorted(set(tints) - set(range(len(stack.layers))))
    if unknown:
        raise LaminaError(f"tint spectrum for layer {unknown[0]}; the stack has {len(stack.layers)} layers, numbered from 0")
    layers = tuple(_spectral_layer(layer, nm, tints.get(i), f"layer {i}") for i, layer in enumerate(stack.layers))
    base = _spectral_base(stack.base, nm, color, "base")
    return SpectralStack(layers, base, stack.name, stack.source, stack.unknown, tuple(nm.tolist()))


def gaussian_band(wavelength_nm: np.ndarray, center_nm: float, width_nm: float, depth: float) -> np.ndarray:
    """Optical depth (n,) of unit thickness of one absorption band: `depth` at the centre, standard deviation `width_nm`."""
    return depth * np.exp(-0.5 * np.square((np.asarray(wavelength_nm, float) - center_nm) / width_nm))


def smoothest_reflectance(rgb: Sequence[float], wavelength_nm: np.ndarray) -> np.ndarray:
    """The reflectance (n,) of linear Rec.709 `rgb` with the least squared slope (Burns 2020, Color Res. Appl. 45(1), 8-21).

    A guess where nothing but a colour is known. Raises LaminaError where it leaves 0 to 1, as saturated colours do.
    """
    weights = rgb_weights(wavelength_nm)
    slope = np.diff(np.eye(len(weights)), axis=0)
    zero = np.zeros((3, 3))
    system = np.block([[slope.T @ slope, weights], [weights.T, zero]])
    spectrum = np.linalg.solve(system, np.concatenate([np.zeros(len(weights)), np.asarray(rgb, float)]))[:-3]
    if not np.all((spectrum >= 0.0) & (spectrum <= 1.0)):
        raise LaminaError(f"color {list(rgb)} is too saturated for a smooth spectrum within 0 to 1; give its spectrum")
    return spectrum


def _spectral_layer(layer: Layer, wavelength_nm: np.ndarray, tint, where: str) -> Layer:
    if layer.is_opaque:
        if tint is not None:
            raise LaminaError(f"{where}: an opaque {layer.kind} has no tint")
        return _spectral_base(layer, wavelength_nm, None, where)
    _refuse_film(layer, where)
    if tint is None and (own := spectrum_of(layer)) is not None:
        tint = np.interp(wavelength_nm, *own)
    colors = [p.name for p in SCHEMA.layers[layer.kind].all_parameters if p.type in (COLOR, VECTOR) and p.name in layer and p not in NORMAL.parameters]
    return layer.with_values(**{name: _spectrum(layer, name, tint if name == "tint" else None, len(wavelength_nm), where) for name in colors})


def _refuse_film(element: Layer | Base, where: str) -> None:
    if element.has(THIN_FILM):
        raise LaminaError(f"{where} has a thin film, whose colors are for RGB; leave out film_thickness and film_ior")


def _spectral_base(base: LayerOrBase, wavelength_nm: np.ndarray, color, where: str) -> LayerOrBase:
    _refuse_film(base, where)
    count = len(wavelength_nm)
    if "color" in base:
        return base.with_values(color=_spectrum(base, "color", color, count, where))
    if color is not None:
        raise LaminaError(f"{where}: a conductor has no color; its index sets it")
    if "metal" in base:
        eta, k = metal_index(base["metal"], wavelength_nm)
        values = {name: value for name, value in base.values.items() if name != "metal"}
        return replace(base, values=values).with_values(eta=tuple(eta), k=tuple(k))
    pair = ("eta", "k") if "eta" in base else ("reflectance", "edge_color")
    return base.with_values(**{name: _spectrum(base, name, None, count, where) for name in pair})


def _spectrum(element: Layer | Base, name: str, given, count: int, where: str) -> tuple[float, ...]:
    if given is None:
        if len(set(element[name])) > 1:
            raise LaminaError(f"{where}: {name} {list(element[name])} is coloured; give its spectrum")
        return (element[name][0],) * count
    values = np.asarray(given, float)
    if values.shape != (count,):
        raise LaminaError(f"{where}: {name} spectrum of shape {values.shape} needs one value for each of {count} wavelengths")
    if not np.all((values >= 0.0) & (values <= 1.0)):
        raise LaminaError(f"{where}: {name} spectrum must lie within 0 to 1, not {values.min():g} to {values.max():g}")
    return tuple(values)
