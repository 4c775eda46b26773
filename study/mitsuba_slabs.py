# SPDX-License-Identifier: GPL-3.0-or-later
"""`make mitsuba-slabs`: stacks with media that scatter, as explicit slabs in Mitsuba 3, against `adding`.

Needs Mitsuba (pip install mitsuba in .venv), which nothing else here does. Its facets are `single`, and so is the truth here. A camera sees
a wide slab in a uniform white sky, so that radiance is directional albedo.
"""

import sys
from pathlib import Path

import numpy as np

from ..reference_py.material.stack import Stack
from ..reference_py.optics.bases import DiffuseBase
from ..reference_py.optics.frame import spherical
from ..reference_py.optics.interface import Interface
from ..reference_py.optics.optical_stack import OpticalStack
from ..reference_py.registry import make_model
from .charts.output import print_table
from .suite import scattering_suite
from .tables import FIGURES, write_table

NAMES = ("rough_one_isotropic", "smooth_milk_over_black", "rough_very_forward", "two_media", "rough_rgb_extinction", "bare_dust_over_metal",
         "between_two_media", "smooth_back_over_rough_metal")  # fmt: skip
VIEWS_DEG = (0.0, 40.0, 65.0, 80.0)
_PIXELS, _ROUNDS, _MOST_ROUNDS = 64, 6, 40
# Relative standard error at which more renders are not worth it.
_TARGET = 0.0025
_WIDE = 2000.0


def mitsuba_albedo(mi, stack: Stack, theta_deg: float, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Directional albedo (3,) and its standard error, from renders of `samples` paths per pixel each."""
    scene = mi.load_dict(_scene(mi, OpticalStack.of(stack), theta_deg))
    means = []
    while True:
        means.append(np.array(mi.render(scene, spp=samples, seed=len(means))).reshape(-1, 3).mean(axis=0))
        mean, stderr = np.mean(means, axis=0), np.std(means, axis=0) / np.sqrt(max(len(means) - 1, 1))
        if len(means) >= _ROUNDS and (np.all(stderr < _TARGET * mean) or len(means) >= _MOST_ROUNDS):
            return mean, stderr


def _scene(mi, optics: OpticalStack, theta_deg: float) -> dict:
    to = mi.ScalarTransform4f()
    theta = np.radians(theta_deg)
    top = float(len(optics.interfaces))
    eye = [100.0 * np.sin(theta), 0.0, top + 100.0 * np.cos(theta)]
    media = [_medium(interface) for interface in optics.interfaces]
    # `volpath` follows one channel's distances: where channels differ, few paths carry most of another's light
    is_grey = all(np.ptp(interface.tau) == 0.0 for interface in optics.interfaces)
    scene = {
        "type": "scene",
        "integrator": {"type": "volpath" if is_grey else "volpathmis", "max_depth": -1, "rr_depth": 30},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
        "sensor": {
            "type": "orthographic",
            "to_world": to.look_at(origin=eye, target=[0.0, 0.0, top], up=[0.0, 1.0, 0.0]) @ to.scale([0.1, 0.1, 1.0]),
            "film": {"type": "hdrfilm", "width": _PIXELS, "height": _PIXELS, "pixel_format": "rgb", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
    }
    for i, interface in enumerate(optics.interfaces):
        scene[f"interface_{i}"] = _plane(to, top - i, _dielectric(interface), media[i - 1] if i else None, media[i])
    return {**scene, "base": _plane(to, 0.0, _base(optics.base), media[-1], None)}


def _plane(to, height: float, bsdf: dict, above: dict | None, below: dict | None) -> dict:
    plane = {"type": "rectangle", "to_world": to.translate([0.0, 0.0, height]) @ to.scale(_WIDE), "bsdf": bsdf}
    return plane | ({"exterior": above} if above else {}) | ({"interior": below} if below else {})


def _medium(interface: Interface) -> dict:
    albedo, g = (np.zeros(3), 0.0) if interface.scattering is None else (interface.scattering.albedo, interface.scattering.g)
    depth = np.maximum(interface.tau, 1e-6)
    return {
        "type": "homogeneous",
        "scale": float(np.max(depth)),
        "sigma_t": {"type": "rgb", "value": (depth / np.max(depth)).tolist()},
        "albedo": {"type": "rgb", "value": albedo.tolist()},
        "phase": {"type": "hg", "g": float(g)},
    }


def _dielectric(interface: Interface) -> dict:
    if interface.eta == 1.0:
        return {"type": "null"}
    ior = {"int_ior": interface.n_below, "ext_ior": interface.n_above}
    if interface.facets.is_specular:
        return {"type": "dielectric", **ior}
    return {"type": "roughdielectric", "distribution": interface.distribution, "alpha": interface.alpha, **ior}


def _base(base) -> dict:
    if isinstance(base, DiffuseBase):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": base.color.tolist()}}
    eta, k = ({"type": "rgb", "value": v.tolist()} for v in base.relative_index)
    return {"type": "roughconductor", "distribution": base.facets.distribution, "alpha": base.facets.alpha, "eta": eta, "k": k}


def main(samples: int = 16) -> None:
    """Print and write the table."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    columns, rows = ("stack", "view_deg", "adding", "mitsuba", "stderr", "worst_error"), []
    for name in NAMES:
        stack = scattering_suite()[name]
        for theta in VIEWS_DEG:
            exact = make_model("adding", stack, surface="single").albedo(spherical(np.radians(theta), 0.0))
            found, stderr = mitsuba_albedo(mi, stack, theta, samples)
            numbers = (" ".join(f"{v:.4f}" for v in values) for values in (exact, found))
            rows.append([name, f"{theta:g}", *numbers, f"{np.max(stderr / exact):.4f}", f"{np.max(np.abs(found / exact - 1.0)):.4f}"])
            print(rows[-1], file=sys.stderr, flush=True)
    print_table(columns, rows)
    heading = ("make mitsuba-slabs", f"Mitsuba {mi.__version__}, explicit slabs, single facets; relative errors of the worst channel")
    write_table(Path(FIGURES) / "mitsuba_slabs.csv", heading, columns, rows, lambda line: print(line, file=sys.stderr))


if __name__ == "__main__":
    main()
