# SPDX-License-Identifier: GPL-3.0-or-later
"""Short ways to write the stacks and views that tests need."""

import numpy as np
import pytest

from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical


def lambert(value):
    return {"kind": "lambert", "color": [value] * 3}


def conductor(eta, k, alpha, distribution="ggx"):
    return {"kind": "conductor", "eta": [eta] * 3, "k": [k] * 3, "roughness": alpha**0.5, "distribution": distribution}


def coat(alpha, ior=1.5, distribution="ggx", **values):
    return {"kind": "dielectric", "ior": ior, "roughness": alpha**0.5, "distribution": distribution, **values}


def stack(*layers, base):
    return Stack.from_dict({"layers": list(layers), "base": base})


def view(theta_deg, phi=0.0):
    return spherical(np.radians(theta_deg), phi)


def assert_same(found: Stack, wanted: Stack) -> None:
    """That two stacks are equal, but for means of masks, which a bake of 1,024 points gives."""

    def parts(one):
        return [*one.layers, one.base]

    masked = [{name: part[name] for name in part.masks} for part in parts(wanted)]
    for part, means in zip(parts(found), masked, strict=True):
        assert {name: part[name] for name in means} == pytest.approx(means, abs=0.01)
    data = found.to_dict()
    for row, means in zip([*data["layers"], data["base"]], masked):
        row |= means
    assert data == wanted.to_dict()


def on_a_plane(blender, stack, tier: str = "analytic"):
    """A new plane, the active object, with a new material of a stack, which is returned."""
    from lamina.addon.material.material import apply_stack

    blender.ops.mesh.primitive_plane_add()
    made = blender.data.materials.new("coated")
    apply_stack(made, stack, tier)
    blender.context.object.active_material = made
    return made
