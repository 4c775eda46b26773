# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes data/cycles_energies.json: `python -m lamina.study.make_cycles_energies` (half a second)."""

import json

import numpy as np

from ..reference_py.atomic import write_text
from ..reference_py.models.baselines.cycles import ENERGY_NODES, FILE, RISE_NODES, UNIT
from ..reference_py.models.baselines.energy import facets_seen, reflected_share
from ..reference_py.models.baselines.parts import dielectric_f0
from ..reference_py.optics.fresnel import fresnel_dielectric
from ..reference_py.optics.gauss import gauss_legendre
from ..reference_py.optics.quadrature import points

# Of the tables' first nodes, and the most of an index' node: there eta would be infinite.
_FLOOR, _MOST = 1e-4, 0.99
_ORDER = 24
_FACETS = 4096


def nodes(count: int) -> np.ndarray:
    """Those of a table's axis."""
    return np.clip(np.linspace(0.0, 1.0, count), _FLOOR, 1.0)


def energy(cos_o: np.ndarray, alpha: float) -> np.ndarray:
    """(N,) albedo of a lossless single-scattering GGX lobe."""
    alphas = np.full(len(cos_o), alpha)
    _, cos_i = facets_seen(cos_o, alphas, *points(_FACETS))
    return np.mean(reflected_share(cos_i, cos_o, alphas), axis=1)


def mean_energy(alpha: float) -> float:
    """The cosine-weighted mean of it."""
    x, w = gauss_legendre(_ORDER)
    cos = 0.5 * (x + 1.0)
    return float(np.sum(w * cos * energy(cos, alpha)))


def rise(cos_o: np.ndarray, alpha: float, depth: float) -> np.ndarray:
    """(N,) mean of (F - F0) / (1 - F0) over the facets seen, of an index at a node `depth`; masked light counts as none."""
    z2 = min(depth, _MOST) ** 2
    eta = (1.0 + z2) / (1.0 - z2)
    cos_om, cos_i = facets_seen(cos_o, np.full(len(cos_o), alpha), *points(_FACETS))
    f0 = dielectric_f0(eta)
    return np.mean(np.where(cos_i > 0.0, np.clip((fresnel_dielectric(cos_om, eta) - f0) / (1.0 - f0), 0.0, 1.0), 0.0), axis=1)


def main() -> None:
    even, few = nodes(ENERGY_NODES), nodes(RISE_NODES)
    tables = {
        "energy": [energy(even, root**2) for root in even],
        "mean": [mean_energy(root**2) for root in even],
        "rise": [[rise(few, root**2, depth) for depth in few] for root in few],
    }
    data = {
        "description": f"Energies of glossy lobes that Cycles keeps in tables, in units of {UNIT:g}; axes and meaning in models/baselines/cycles.py",
        **{name: np.rint(np.array(table) / UNIT).astype(int).ravel().tolist() for name, table in tables.items()},
    }
    rows = ",\n".join(f"{json.dumps(key)}: {json.dumps(value, separators=(',', ':'))}" for key, value in data.items())
    write_text(FILE, "{\n" + rows + "\n}\n")


if __name__ == "__main__":
    main()
