# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes data/rough_interface.json: `python -m lamina.study.make_interface_tables` (about a minute).

Deterministic: every number comes from the operators of `models.adding`.
"""

import json

import numpy as np

from ..reference_py.atomic import write_text
from ..reference_py.lobes.analytic.interface_tables import (
    ALPHA,
    ANISOTROPIC_ALPHAS,
    ANISOTROPIC_AZIMUTHS,
    ANISOTROPIC_COSINES,
    ANISOTROPIC_RATIOS,
    CLOSURE_CELLS,
    FILE,
    LEAST_RATIO,
    RHO,
    UNIT,
    T,
    V,
    cosine_of_critical_variable,
)
from ..reference_py.lobes.closure import unit_energy
from ..reference_py.lobes.lobe import DielectricCurve, GlossyLobe
from ..reference_py.models.adding.direction_grid import Grid
from ..reference_py.models.adding.facets import MULTIPLE
from ..reference_py.models.adding.operators import Resolution, dielectric_rows
from ..reference_py.optics.facet_reflectance import DielectricFacet
from ..reference_py.optics.fresnel import fresnel_dielectric
from ..reference_py.optics.microfacet import BECKMANN, GGX

_RESOLUTION = Resolution(modes=1, across=16, along=36)
_GRID_NODES = 12
# Grazing views take the limit at this cosine.
_GRAZING = 1e-3
_GAUSS = 24


def lossless_reflectance(cos_theta: np.ndarray, alpha: float, eta: float, distribution: str) -> np.ndarray:
    """Directional reflectance (n,) of a rough interface for light at cosines (n,); alpha > 0, eta != 1."""
    grid = Grid.shared((1.0, eta), _GRID_NODES)
    single, multi, _ = dielectric_rows(DielectricFacet(1.0, eta), cos_theta, alpha, distribution, MULTIPLE, grid, _RESOLUTION)
    return (single + multi)[0].sum(axis=1)


def _tables_of(distribution: str) -> dict[str, list[int]]:
    shape = (len(RHO), len(ALPHA))
    thin, dense = np.zeros((*shape, len(T))), np.zeros((*shape, len(V)))
    diffuse, gain = np.zeros(shape), np.zeros((*shape, len(T)))
    x, w = np.polynomial.legendre.leggauss(_GAUSS)
    u = 0.5 * (x + 1.0)
    cos_t = np.maximum(np.square(T), _GRAZING)
    for i, rho in enumerate(RHO):
        eta = (1.0 + rho) / (1.0 - rho)
        for j, alpha in enumerate(ALPHA):
            if alpha > 0.0:
                gain[i, j] = _gain(cos_t, alpha, max(eta, 1.001), distribution) - 1.0
            if eta == 1.0:
                continue
            mean = fresnel_dielectric(u, eta)
            if alpha > 0.0:
                mean = lossless_reflectance(u, alpha, eta, distribution)
                thin[i, j] = lossless_reflectance(cos_t, alpha, eta, distribution) - fresnel_dielectric(cos_t, eta)
                cos_v = np.maximum(cosine_of_critical_variable(V, 1.0 / eta), _GRAZING)
                dense[i, j] = lossless_reflectance(cos_v, alpha, 1.0 / eta, distribution) - fresnel_dielectric(cos_v, 1.0 / eta)
            diffuse[i, j] = np.sum(w * u * mean)
    closure = np.ones((CLOSURE_CELLS + 1, CLOSURE_CELLS + 1))
    even = np.square(np.arange(CLOSURE_CELLS + 1) / CLOSURE_CELLS)
    for j, alpha in enumerate(even[1:], start=1):
        closure[j] = unit_energy(GlossyLobe(distribution, np.ones(3), alpha, alpha), np.maximum(even, _GRAZING))[:, 0]
    tables = {"thin": thin, "dense": dense, "diffuse": diffuse, "gain": gain, "closure": closure, "anisotropic": _anisotropic(distribution)}
    return {name: np.rint(table / UNIT).astype(int).ravel().tolist() for name, table in tables.items()}


def _anisotropic(distribution: str) -> np.ndarray:
    """Energy of an anisotropic white closure minus that of the isotropic one of as much variance."""
    cosines = np.maximum(np.square(np.arange(ANISOTROPIC_COSINES + 1) / ANISOTROPIC_COSINES), _GRAZING)
    alphas = np.square(np.arange(ANISOTROPIC_ALPHAS + 1) / ANISOTROPIC_ALPHAS)
    ratios = LEAST_RATIO ** (np.arange(ANISOTROPIC_RATIOS + 1) / ANISOTROPIC_RATIOS)
    table = np.zeros((len(ANISOTROPIC_AZIMUTHS), len(alphas), len(ratios), len(cosines)))
    for j, alpha in enumerate(alphas[1:], start=1):
        isotropic = unit_energy(GlossyLobe(distribution, np.ones(3), alpha, alpha), cosines)[:, 0]
        for k, ratio in enumerate(ratios[1:], start=1):
            alpha_x = alpha * np.sqrt(2.0 / (1.0 + ratio * ratio))
            lobe = GlossyLobe(distribution, np.ones(3), alpha_x, alpha_x * ratio, frame=0.0)
            for i, phi in enumerate(ANISOTROPIC_AZIMUTHS):
                table[i, j, k] = unit_energy(lobe, cosines, phi)[:, 0] - isotropic
    return table


def _gain(cos_theta, alpha, eta, distribution) -> np.ndarray:
    closure = GlossyLobe(distribution, np.ones(3), alpha, alpha, fresnel=DielectricCurve(eta))
    return lossless_reflectance(cos_theta, alpha, eta, distribution) / unit_energy(closure, cos_theta)[:, 0]


def main() -> None:
    data = {
        "description": "Energies of rough dielectric interfaces, in units of 1e-4; axes and meaning in lobes/analytic/interface_tables.py",
        "distributions": [GGX, BECKMANN],
        **{distribution: _tables_of(distribution) for distribution in (GGX, BECKMANN)},
    }
    rows = ",\n".join(f"{json.dumps(key)}: {json.dumps(value, separators=(',', ':'))}" for key, value in data.items())
    write_text(FILE, "{\n" + rows + "\n}\n")


if __name__ == "__main__":
    main()
