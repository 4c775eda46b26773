# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin films in a shader's own arithmetic: what they add to functions that carry light through interfaces."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ....reference_py.material.schema import THIN_FILM
from ....reference_py.material.stack import Stack
from ....reference_py.optics.thin_film import LAST_PHASE_NM, STEPS, TERMS, THINNEST_NM, sensitivities
from ..inputs import BASE
from .parts import fill, listed


@dataclass(frozen=True)
class FilmWords:
    """How functions name the films of interfaces: parameters, arguments, and a reflectance of interface j and its type."""

    parameters: str
    arguments: str
    reflectance: str
    type: str

    @property
    def words(self) -> dict[str, str]:
        return {"FILM_PARAMETERS": self.parameters, "FILM_ARGUMENTS": self.arguments}


NO_FILM = FilmWords("", "", "fresnel_dielectric(cos_h, n[j + 1] / n[j])", "float")
FILM = FilmWords(
    "float sensitivity[], float film_nm[], float film_ior[], ",
    "sensitivity, film_nm, film_ior, ",
    "interface_reflectance(sensitivity, film_nm[j], film_ior[j], cos_h, n[j], n[j + 1])",
    "color",
)


def has_film(stack: Stack) -> bool:
    """Whether a shader of the stack has to compute with films; that on the top interface alone is its closure's, but all
    that lies below sees light that has passed it."""
    return any(element.has(THIN_FILM) for element in (*stack.layers, stack.base))


def film_arguments(stack: Stack) -> str:
    """What a call to such a function gives it."""
    return "FilmSensitivity, film_nm, film_ior, " if has_film(stack) else ""


def film_arrays(stack: Stack, owners: Sequence[str]) -> str:
    """Statements that declare the films of all surfaces."""
    if not has_film(stack):
        return ""
    pairs = list(zip((*stack.layers, stack.base), (*owners, BASE)))
    nm, ior = ([f"{owner}{name}" if e.has(THIN_FILM) else none for e, owner in pairs] for name, none in (("FilmThickness", "0.0"), ("FilmIor", "1.0")))
    return f"    float film_nm[{len(pairs)}] = {{{listed(nm)}}};\n    float film_ior[{len(pairs)}] = {{{listed(ior)}}};\n"


def film_functions() -> str:
    return fill("film.h", STEPS=STEPS, LAST_STEP=STEPS - 1, LAST_PHASE=f"{LAST_PHASE_NM:.1f}", TERMS=TERMS, THINNEST=f"{THINNEST_NM:g}")


@cache
def film_table() -> str:
    """The array parameter of the channels' sensitivities."""
    parts = np.concatenate([sensitivities().real.T, sensitivities().imag.T]).ravel()
    return f"    float FilmSensitivity[{parts.size}] = {{{','.join(f'{v:.5g}' for v in np.round(parts, 5) + 0.0)}}},"
