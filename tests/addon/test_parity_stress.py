# SPDX-License-Identifier: GPL-3.0-or-later
"""Parity beyond the presets: many layers, total reflection from above, vanishing interfaces, lobes of every form."""

import numpy as np
import pytest
from support.goniometer import TOLERANCE, parity

from lamina.reference_py.lobes.closure import lobe_f
from lamina.reference_py.lobes.lobe import GlossyLobe, SchlickCurve
from lamina.reference_py.lobes.methods import DEFAULT_METHOD, METHODS
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender


def coat(ior, roughness, **more):
    return {"kind": "dielectric", "ior": ior, "roughness": roughness, **more}


STACKS = {
    "dense above thin": ([coat(2.0, 0.5), coat(1.2, 0.4, distribution="beckmann")], {"kind": "oren_nayar", "sigma_deg": 60}),
    "eight layers": ([coat(1.2 + 0.1 * i, 0.3 + 0.05 * i, tint=[0.9, 0.8, 0.95]) for i in range(7)], {"kind": "conductor", "metal": "gold", "roughness": 0.5}),
    "equal indices": ([coat(1.0, 0.3), coat(1.0, 0.6)], {"kind": "lambert"}),
    "black medium": ([coat(1.5, 0.4, tint=[0, 0.5, 1], thickness=1000)], {"kind": "conductor", "metal": "silver", "roughness": 0.6}),
    "as rough as can be": (
        [coat(1.5, 1.0), coat(1.3, 1.0, distribution="beckmann")],
        {"kind": "conductor", "eta": [0.2, 1, 2], "k": [3, 2, 1], "roughness": 1.0, "distribution": "beckmann"},
    ),
}


@pytest.mark.parametrize("tier", [method for method in METHODS if method != DEFAULT_METHOD])
@pytest.mark.parametrize("name", STACKS)
def test_render_equals_mirror(blender, name, tier):
    import bpy

    from lamina.addon.material.material import apply_stack, refresh, stack_of

    if (name, tier) == ("eight layers", "baked"):
        pytest.skip("its bake takes most of a minute")
    layers, base = STACKS[name]
    material = bpy.data.materials.new(name)
    apply_stack(material, Stack.from_dict({"layers": layers, "base": base}), tier)
    refresh(material, settle=True)
    result = parity(material, make_model("closure_model", stack_of(material), method=tier).f, 60.0)
    print(f"{name}: 99th percentile {result.percentile_99:.1e} of {result.errors.size} values")
    assert result.finite and result.errors.size > 1000
    assert result.percentile_99 <= TOLERANCE


LOBE_SHADER = """
shader tilted_lobe(output closure color BSDF = 0)
{
    vector x = normalize(I - dot(I, N) * N);
    vector n = cos(%(tilt)r) * N + sin(%(tilt)r) * x;
    vector t = cos(%(tilt)r) * x - sin(%(tilt)r) * N;
    BSDF = generalized_schlick_bsdf(n, t, color(1.0), color(0.0), %(alpha_x)r, %(alpha_y)r,
                                    color(0.2, 0.5, 0.9), color(1.0, 0.8, 0.6), 5.0, "%(distribution)s");
}
"""


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("tilt, alpha_x, alpha_y", [(0.0, 0.3, 0.3), (0.15, 0.2, 0.2), (0.15, 0.4, 0.15), (0.1, 0.1, 0.5)])
def test_tilted_anisotropic_schlick_lobes(blender, distribution, tilt, alpha_x, alpha_y):
    """What a lobe set may contain beyond the present tier: the lobe's frame, widths and Fresnel curve."""
    import bpy
    import cycles.osl

    from lamina.addon.blender.versions import node_tree

    bpy.context.scene.render.engine = "CYCLES"
    material = bpy.data.materials.new("lobe")
    tree = node_tree(material)
    tree.nodes.clear()
    script, output = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeOutputMaterial")
    script.script = bpy.data.texts.new("lobe.osl")
    script.script.from_string(LOBE_SHADER % locals())
    cycles.osl.update_script_node(script, lambda level, message: None)
    tree.links.new(script.outputs["BSDF"], output.inputs["Surface"])

    curve = SchlickCurve(np.array([0.2, 0.5, 0.9]), np.array([1.0, 0.8, 0.6]))
    lobe = GlossyLobe(distribution, np.ones(3), np.float64(alpha_x), np.float64(alpha_y), np.float64(tilt), curve)

    def f(wo, wi):
        visible = (wi[..., 2] > 0.0)[..., None]
        return np.where(visible, lobe_f(lobe, wo, wi), 0.0)

    result = parity(material, f, 45.0)
    print(f"{distribution} tilt {tilt} alpha {alpha_x} {alpha_y}: 99th percentile {result.percentile_99:.1e}")
    assert result.finite
    assert result.percentile_99 <= TOLERANCE
