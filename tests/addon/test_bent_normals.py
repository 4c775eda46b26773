# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a shading normal would mirror the view below the surface, weights are those of the normal that Cycles takes instead.

Small pictures under a white world, of which a smooth layer's bake made white rims and speckles (low-poly meshes, bumps).
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("bpy")

from lamina.addon.blender import versions
from lamina.addon.blender.images import read_exr
from lamina.addon.material import material as materials
from lamina.addon.rendering import settings
from lamina.addon.rendering.geometry import plane_mesh, sphere_mesh
from lamina.addon.shader.nodes import view_nodes
from lamina.addon.shader.osl import osl_files
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

BACKENDS = ("osl", "nodes")
SCENES = ("cylinder", "bump .3", "bump 1")
# Of the mean of a picture. Stock nodes leave out Cycles' least height: 1.8 % over a bump of 1.
NEAR = 0.02
ROUGH = 0.04


def glaze(roughness: float = 0.0) -> Stack:
    return Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": roughness}], "base": {"kind": "lambert", "color": [0.045, 0.2, 0.33]}})


def shown(bpy, stack: Stack, tier: str = "baked", backend: str = "osl"):
    material = bpy.data.materials.new("bent")
    materials.apply_stack(material, stack, tier, backend)
    materials.refresh(material, settle=True)
    return material


def cylinder(bpy):
    """Sixteen sides and two caps, all shaded smooth: the caps' normals lean by 45 degrees at their rims."""
    import bmesh

    build, mesh = bmesh.new(), bpy.data.meshes.new("cylinder")
    bmesh.ops.create_cone(build, cap_ends=True, segments=16, radius1=1.0, radius2=1.0, depth=2.0)
    build.to_mesh(mesh)
    build.free()
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def ribbons(bpy):
    """Strands beside each other, which Cycles shades as round though they are flat."""
    curves = bpy.data.hair_curves.new("ribbons")
    curves.add_curves([2] * 8)
    x = np.repeat(np.linspace(-0.9, 0.9, 8), 2)
    points = np.stack([x, np.zeros(16), np.tile([-1.5, 1.5], 8)], axis=-1)
    curves.points.foreach_set("position", points.astype(np.float32).ravel())
    curves.points.foreach_set("radius", np.full(16, 0.12, np.float32))
    return curves


def bumped(bpy, material, strength: float):
    tree = material.node_tree
    noise, bump = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeDisplacement")
    noise.inputs["Scale"].default_value, bump.inputs["Scale"].default_value = 8.0, strength
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], tree.get_output_node("ALL").inputs["Displacement"])
    material.displacement_method = "BUMP"


def pixels(bpy, tmp_path, material, data, samples: int = 32, size: int = 48):
    """Radiance (size, size, 3) under a white world, seen from a little above, and where the object fills the pixel."""
    with settings.scratch_scene("Bent") as scene:
        settings.measurement_settings(scene, samples, size, max_bounces=1)
        scene.cycles.filter_width = 1.0
        scene.render.film_transparent = True
        scene.cycles_curves.shape = "RIBBONS"
        scene.world = bpy.data.worlds.new("white")
        background = next(n for n in versions.node_tree(scene.world).nodes if n.type == "BACKGROUND")
        background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (1.0, 1.0, 1.0, 1.0), 1.0
        camera = bpy.data.cameras.new("camera")
        camera.type, camera.ortho_scale = "ORTHO", 2.6
        scene.camera = settings.add_object(scene, "camera", camera)
        scene.camera.location, scene.camera.rotation_euler = (0.0, -5.0, 1.5), (np.arctan2(5.0, 1.5), 0.0, 0.0)
        data.materials.append(material)
        settings.add_object(scene, "object", data)
        settings.render_to(scene, Path(tmp_path, "bent.exr"))
        picture = read_exr(Path(tmp_path, "bent.exr"))
        layer = f"{scene.view_layers[0].name}.Combined"
        return picture.layer(layer, "RGB"), picture.layer(layer, "A")[..., 0] > 0.99


def of_scene(bpy, tmp_path, scene: str, material, **options):
    if scene.startswith("bump"):
        bumped(bpy, material, float(scene.split()[1]))
    return pixels(bpy, tmp_path, material, cylinder(bpy) if scene == "cylinder" else sphere_mesh("ball"), **options)


def mean(*args, **options) -> np.ndarray:
    radiance, inside = of_scene(*args, **options)
    return radiance[inside].mean(axis=0)


def unbend(monkeypatch):
    """The deliberate fault: weights at the view of the shading normal as it is."""
    part = osl_files._part

    def straight(name: str):
        found = part(name)
        return replace(found, text=found.text.replace("missing > 0.0", "0"))

    monkeypatch.setattr(osl_files, "_part", straight)
    monkeypatch.setattr(view_nodes.View, "normal", property(lambda view: view._geometry.outputs["Normal"]))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scene", SCENES)
def test_a_bake_of_a_smooth_layer_is_that_of_a_nearly_smooth_one(blender, tmp_path, scene, backend):
    smooth, rough, live = (
        mean(blender, tmp_path, scene, shown(blender, stack, tier, b))
        for stack, tier, b in ((glaze(), "baked", backend), (glaze(0.01), "baked", backend), (glaze(), "analytic", "osl"))
    )
    print(f"{scene}, {backend}: {smooth.round(4)}, roughness .01 {rough.round(4)}, analytic {live.round(4)}")
    assert np.all(np.abs(smooth / rough - 1.0) <= ROUGH)
    assert np.all(np.abs(smooth / live - 1.0) <= NEAR)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scene", SCENES)
def test_the_view_of_the_unbent_normal_would_be_caught(blender, tmp_path, monkeypatch, scene, backend):
    live = mean(blender, tmp_path, scene, shown(blender, glaze(), "analytic"))
    unbend(monkeypatch)
    assert mean(blender, tmp_path, scene, shown(blender, glaze(), "baked", backend))[0] > 1.2 * live[0]


@pytest.mark.parametrize("tier, backend", [("baked", "osl"), ("baked", "nodes"), ("analytic", "osl")])
@pytest.mark.parametrize("scene", SCENES)
def test_nothing_reflects_more_than_it_receives(blender, tmp_path, scene, tier, backend):
    """A lossless stack: no mean of 3 x 3 pixels above 1.005."""
    white = Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.0}], "base": {"kind": "lambert", "color": [1.0, 1.0, 1.0]}})
    radiance, inside = of_scene(blender, tmp_path, scene, shown(blender, white, tier, backend), samples=256, size=32)
    windows = np.lib.stride_tricks.sliding_window_view
    means = windows(radiance, (3, 3), axis=(0, 1)).mean(axis=(-2, -1))[windows(inside, (3, 3)).all(axis=(-2, -1))]
    print(f"{scene}, {tier} {backend}: {means.max():.4f} at most, {means.mean():.4f} in the mean")
    assert means.max() <= 1.005


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("data", ["plane", "ribbons"])
def test_flat_surfaces_and_strands_stay(blender, tmp_path, monkeypatch, data, backend):
    """Where Cycles bends nothing, pictures are those of the normal as it is; of a coat over metal, which has tilted lobes."""
    stack = presets.load("frosted_metal")  # which other tests bake too

    def picture():
        made = ribbons(blender) if data == "ribbons" else plane_mesh("plane", 1.0)
        return pixels(blender, tmp_path, shown(blender, stack, "baked", backend), made, samples=4)

    radiance, inside = picture()
    unbend(monkeypatch)
    before, _ = picture()
    assert inside.sum() > 100
    np.testing.assert_allclose(radiance, before, rtol=2e-5, atol=1e-6)
