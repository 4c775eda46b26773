# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles makes of a material beside the picture: bakes, passes, overrides, catchers, and the ways to sample it."""

import json

import bpy
import numpy as np

from lamina.addon.blender.versions import node_tree
from lamina.addon.rendering.geometry import plane_mesh
from lamina.addon.rendering.settings import add_object

from .case import case
from .trial import METAL, PAINT, SAME, Surface, Trial

NOISE = 0.03  # other samples of the same light
GREY_AOV = (0.25, 0.5, 0.75)


# bakes


def bake(trial: Trial, surface: Surface, kind: str, parts: set[str] | None = None, samples: int = 16) -> np.ndarray:
    """Mean color of a bake of a plane in a white world, (3,)."""
    trial.stage(samples=samples, furnace=True)
    material = trial.material(surface)
    trial.show(material, plane_mesh("plane", 1.0))
    image = bpy.data.images.new("bake", 16, 16, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
    bpy.ops.object.bake(type=kind, margin=0, use_clear=True, **({"pass_filter": parts} if parts else {}))
    pixels = np.empty(16 * 16 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, 4).mean(axis=0)[:3].astype(float)


def from_above(trial: Trial, surface: Surface) -> np.ndarray:
    """What the same plane shows to a camera along its normal, (3,), with OSL."""
    trial.stage(16, 64, furnace=True).camera.data.ortho_scale = 0.5
    trial.show(trial.material(surface), plane_mesh("plane", 1.0))
    return trial.picture(osl=True).mean


_WEIGHT = "the color of a single-scattering GGX closure is its weight, whatever light the lobe loses; color times light is the picture."


def _bake_cases(label: str, surface: Surface, roughness: float) -> None:
    @case(f"bake Combined, {label}", osl_off=True)
    def combined(trial):
        """A Combined bake of a plane beside its picture from above."""
        trial.compare("baked", bake(trial, surface, "COMBINED"), from_above(trial, surface), max(NOISE, trial.within))

    @case(f"bake Diffuse and Glossy colors, {label}", osl_off=True, plain=_WEIGHT)
    def colors(trial):
        """The two colors' sum beside the picture from above in a white world."""
        parts = [bake(trial, surface, kind, {"COLOR"}) for kind in ("DIFFUSE", "GLOSSY")]
        # the color of a glossy lobe is what it reflects; Cycles has it from a table
        trial.compare("sum", sum(parts), from_above(trial, surface), max(0.05, trial.within))

    @case(f"bake Diffuse and Glossy light, {label}", osl_off=True)
    def light(trial):
        """Their sum beside the Combined bake's light, the picture from above."""
        parts = [bake(trial, surface, kind, {"DIRECT", "INDIRECT", "COLOR"}) for kind in ("DIFFUSE", "GLOSSY")]
        trial.compare("sum", sum(parts), from_above(trial, surface), max(NOISE, trial.within))

    @case(f"bake Roughness, {label}", osl_off=True)
    def rough(trial):
        """The roughness that the artist set, or, of a layered surface, one between it and a diffuse base's 1."""
        got = bake(trial, surface, "ROUGHNESS")[0]
        if label == "metal":
            trial.compare("roughness", got, roughness, 0.02)
        else:
            trial.require(f"roughness {got:.3f} is from {roughness} to 1", roughness * 0.98 <= got <= 1.0)


for _label, _surface, _roughness in (("paint", PAINT, 0.3), ("metal", METAL, 0.4)):
    _bake_cases(_label, _surface, _roughness)


@case("bake Normal", osl_off=True)
def bake_normal(trial):
    """A plane's tangent-space normal map."""
    trial.compare("normal", bake(trial, PAINT, "NORMAL"), (0.5, 0.5, 1.0), 0.005)


@case("bake Emit and Transmission", osl_off=True)
def bake_emit(trial):
    """Neither emits nor transmits."""
    trial.compare("emitted", bake(trial, PAINT, "EMIT"), (0.0,) * 3, 0.001, least=1.0)
    trial.compare("transmitted", bake(trial, PAINT, "TRANSMISSION", {"COLOR"}), (0.0,) * 3, 0.001, least=1.0)


# passes


def with_passes(trial: Trial, names: tuple[str, ...], surface: Surface = PAINT, **stage) -> bpy.types.ViewLayer:
    """A stage with passes and a ball of the surface."""
    layer = trial.stage(**stage).view_layers[0]
    for name in names:
        setattr(layer, f"use_pass_{name}", True)
    trial.show(trial.material(surface))
    return layer


def _passes_case(label: str, surface: Surface) -> None:
    @case(f"light passes put together, {label}", osl_off=True)
    def passes(trial):
        """Color x (direct + indirect) of diffuse, glossy and transmission, as a compositor adds them, beside the picture."""
        kinds = ("diffuse", "glossy", "transmission")
        with_passes(trial, tuple(f"{kind}_{part}" for kind in kinds for part in ("color", "direct", "indirect")) + ("emit",), surface)
        picture = trial.picture()
        short = {"diffuse": "Diff", "glossy": "Gloss", "transmission": "Trans"}
        names = picture.exr.channels
        total = np.zeros(3)
        for kind in kinds:
            said = {p: short[kind] + p for p in ("Col", "Dir", "Ind")}
            if f"{picture.layer}.{said['Col']}.R" not in names:  # Blender 5 spells them out
                said = {p: f"{kind.title()} {q}" for p, q in (("Col", "Color"), ("Dir", "Direct"), ("Ind", "Indirect"))}
            color, direct, indirect = (picture.passed(said[p]) for p in ("Col", "Dir", "Ind"))
            total = total + color * (direct + indirect)
        trial.compare("sum", total[picture.covered].mean(axis=0), trial.plain(surface).mean, trial.within)


for _label, _surface in (("paint", PAINT), ("metal", METAL)):
    _passes_case(_label, _surface)


@case("color passes in a white world", osl_off=True, plain=_WEIGHT)
def color_passes(trial):
    """Diffuse color + glossy color beside what the ball reflects of a white world."""
    with_passes(trial, ("diffuse_color", "glossy_color"), furnace=True, samples=64)
    got = trial.picture()
    names = ("DiffCol", "GlossCol") if f"{got.layer}.DiffCol.R" in got.exr.channels else ("Diffuse Color", "Glossy Color")
    colors = sum(got.mean_of(n) for n in names)
    trial.compare("colors", colors, trial.picture(osl=True).mean, max(0.05, trial.within))


@case("normal pass", osl_off=True)
def normal_pass(trial):
    """The ball's normals: those of its shape, to a cosine of .995."""
    with_passes(trial, ("normal", "position"))
    picture = trial.picture()
    normal, place = (picture.passed(name, "XYZ")[picture.covered] for name in ("Normal", "Position"))
    cosine = (normal * place).sum(axis=1) / np.maximum(np.linalg.norm(normal, axis=1) * np.linalg.norm(place, axis=1), 1e-9)
    trial.compare("mean cosine", cosine.mean(), 1.0, 0.005)


@case("cryptomatte", osl_off=True)
def cryptomatte(trial):
    """The material's own id and its coverage, found by its name in the file's manifest."""
    layer = trial.stage().view_layers[0]
    layer.use_pass_cryptomatte_material = True
    trial.show(trial.material())
    picture = trial.picture()
    manifests = [json.loads(v) for k, v in picture.exr.metadata.items() if k.endswith("/manifest")]
    ids = {name: np.uint32(int(number, 16)).view(np.float32) for manifest in manifests for name, number in manifest.items()}
    trial.require("the manifest has the material", "subject" in ids)
    plane = next(v for k, v in picture.exr.channels.items() if k.endswith(("CryptoMaterial00.R", "CryptoMaterial00.r")))
    trial.compare("share of the ball that has its id", (plane[picture.covered] == ids["subject"]).mean(), 1.0, 0.001)


@case("material index pass", osl_off=True)
def index_pass(trial):
    """Pass Index of the material."""
    layer = with_passes(trial, ("material_index",))
    layer.id_data.objects["item"].active_material.pass_index = 7
    picture = trial.picture()
    plane = next(v for k, v in picture.exr.channels.items() if "IndexMA" in k or "Material Index" in k)
    trial.compare("index", plane[picture.covered].mean(), 7.0, 1e-4)


@case("denoising albedo and normal", osl_off=True)
def denoising_passes(trial):
    """Denoising albedo of a rough paint beside what it reflects of a white world; its normals."""
    layer = trial.stage(samples=32, furnace=True).view_layers[0]
    layer.cycles.denoising_store_passes = True
    trial.show(trial.material())
    got = trial.picture()
    trial.compare("albedo", got.mean_of("Denoising Albedo"), trial.picture(osl=True).mean, 0.15)
    trial.require("normals are there", np.abs(got.mean_of("Denoising Normal", "XYZ")).max() > 0.3)


@case("light groups", osl_off=True)
def light_groups(trial):
    """Groups of the sun and of the world: their sum is the picture, and neither is empty."""
    layer = trial.stage().view_layers[0]
    for name in ("key", "fill"):
        layer.lightgroups.add().name = name
    bpy.data.objects["Sun"].lightgroup, bpy.context.scene.world.lightgroup = "key", "fill"
    trial.show(trial.material())
    picture = trial.picture()
    parts = [picture.mean_of(f"Combined_{name}") for name in ("key", "fill")]
    trial.require("neither is empty", all(p.max() > 0.02 for p in parts))
    trial.compare("sum", sum(parts), trial.plain().mean, trial.within)


@case("shader AOV", osl_off=True, limit="Cycles leaves every shader AOV black while OSL is on; Check or the panel names it, and with OSL off it is right")
def aov(trial):
    """An AOV Output beside the surface: its color."""
    layer = trial.stage().view_layers[0]
    made = layer.aovs.add()
    made.name, made.type = "mask", "COLOR"
    material = trial.material()
    node = material.node_tree.nodes.new("ShaderNodeOutputAOV")
    node.aov_name = "mask"
    node.inputs["Color"].default_value = (*GREY_AOV, 1.0)
    trial.show(material)
    picture = trial.picture()
    trial.compare("AOV", picture.mean_of("mask"), GREY_AOV, 0.001)


@case("a preset in a scene with shader AOVs", quick=False, beside=False)
def aov_scene(trial):
    """Apply Preset leaves OSL off where the scene has an AOV, so that the AOV stays."""
    scene = trial.stage()
    scene.cycles.shading_system = False
    made = scene.view_layers[0].aovs.add()
    made.name, made.type = "mask", "COLOR"
    material = bpy.data.materials.new("subject")
    node = node_tree(material).nodes.new("ShaderNodeOutputAOV")
    node.aov_name = "mask"
    node.inputs["Color"].default_value = (*GREY_AOV, 1.0)
    trial.show(material)
    bpy.ops.lamina.apply_preset(preset="clean_copper")
    trial.require("OSL is still off", not scene.cycles.shading_system)
    picture = trial.picture()
    trial.compare("AOV", picture.mean_of("mask"), GREY_AOV, 0.001)
    trial.require("the surface is not black", picture.mean.max() > 0.05)


# whole pictures


@case("material override by the material", osl_off=True)
def override_by(trial):
    """A view layer whose override is the material: its picture on an object that has another."""
    plain = trial.plain()
    trial.show(bpy.data.materials.new("other"))
    bpy.context.view_layer.material_override = trial.material()
    trial.compare_pictures("overridden", trial.picture(), plain, trial.within)


@case("material override over the material", quick=False, osl_off=True)
def override_over(trial):
    """A view layer whose override is a grey Principled, over the material: the grey."""
    grey = bpy.data.materials.new("grey")
    node_tree(grey)
    trial.show(grey)
    expected = trial.picture(osl=True)
    trial.stage()
    grey = bpy.data.materials.new("grey")
    node_tree(grey)
    trial.show(trial.material())
    bpy.context.view_layer.material_override = grey
    trial.compare_pictures("overridden", trial.picture(), expected)


@case("two view layers", osl_off=True)
def two_layers(trial):
    """A second view layer with an override; the first shows the material."""
    plain = trial.plain()
    scene = bpy.context.scene
    trial.show(trial.material())
    other = bpy.data.materials.new("other")
    node_tree(other)
    scene.view_layers.new("clay").material_override = other
    trial.compare_pictures("first layer", trial.picture(), plain, trial.within)


@case("film transparent", quick=False, osl_off=True)
def film(trial):
    """Alpha of the ball and beside it."""
    trial.show(trial.material())
    alpha = trial.picture().alpha
    trial.compare("centre and corner", (alpha[24, 24], alpha[0, 0]), (1.0, 0.0), 0.001)


@case("holdout object", osl_off=True)
def holdout(trial):
    """A ball that is a holdout: no alpha, no light."""
    trial.show(trial.material()).is_holdout = True
    picture = trial.picture()
    trial.compare("alpha and light", (picture.alpha.max(), picture.passed("Combined").max()), (0.0, 0.0), 0.001, least=1.0)


def _caught(trial: Trial, material: bpy.types.Material, osl: bool | None = None) -> np.ndarray:
    """Alpha of a shadow catcher of the material under a grey ball, (h, w)."""
    floor = trial.show(material, plane_mesh("floor", 4.0), "floor")
    floor.is_shadow_catcher, floor.location.z = True, -1.0
    grey = bpy.data.materials.new("grey")
    node_tree(grey)
    trial.show(grey)
    bpy.context.scene.camera.data.ortho_scale = 5.0
    return trial.picture(osl=osl).alpha


@case("shadow catcher", osl_off=True)
def catcher(trial):
    """A floor of the material that catches a ball's shadow, beside a catcher of a plain Diffuse BSDF."""
    diffuse = bpy.data.materials.new("diffuse")
    tree = node_tree(diffuse)
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    expected = _caught(trial, diffuse).mean()
    trial.stage()
    # a glossy floor's shadow is a little lighter or darker than a matte one's
    trial.compare("mean alpha", _caught(trial, trial.material()).mean(), expected, 0.1)


@case("shadow on a catcher", osl_off=True)
def shadow(trial):
    """A ball of the material over a matte catcher: the shadow of a grey ball."""

    def alpha(material) -> float:
        # without what the ball reflects onto the floor
        bpy.context.scene.cycles.max_bounces = 0
        floor = trial.show(None, plane_mesh("floor", 4.0), "floor")
        floor.is_shadow_catcher, floor.location.z = True, -1.0
        trial.show(material)
        bpy.context.scene.camera.data.ortho_scale = 5.0
        return trial.picture().alpha.mean()

    grey = bpy.data.materials.new("grey")
    node_tree(grey)
    expected = alpha(grey)
    trial.stage()
    trial.compare("mean alpha", alpha(trial.material()), expected, 0.02)


def _settings_case(label: str, told: str, change, within: float = NOISE, quick: bool = False) -> None:
    def sampled(trial):
        expected = trial.plain()
        trial.show(trial.material())
        change(bpy.context.scene)
        trial.compare_pictures("picture", trial.picture(), expected, max(within, trial.within))

    sampled.__doc__ = told
    sampled.__module__ = __name__
    case(label, quick=quick, osl_off=True)(sampled)


def _set(owner: str = "cycles", **values):
    def change(scene):
        target = getattr(scene, owner)
        for name, value in values.items():
            setattr(target, name, value)

    return change


_settings_case("render in tiles", "Tiles of 32 pixels beside one tile.", _set(use_auto_tile=True, tile_size=32), SAME, quick=True)
_settings_case("adaptive sampling", "Adaptive sampling beside plain sampling.", _set(use_adaptive_sampling=True, adaptive_threshold=0.02))
_settings_case("denoised", "OpenImageDenoise over the picture: the same quarters.", _set(use_denoising=True, denoiser="OPENIMAGEDENOISE"), 0.03)
_settings_case("path guiding", "Path guiding beside none.", _set(use_guiding=True, use_surface_guiding=True, guiding_training_samples=8, max_bounces=3))
_settings_case("light tree", "The light tree beside none.", _set(use_light_tree=True))
_settings_case("no reflective caustics, filter glossy", "A ball alone has no caustics to lose.", _set(caustics_reflective=False, blur_glossy=0.0))
_settings_case("persistent data", "Rendered with data that is kept.", _set("render", use_persistent_data=True), SAME)
_settings_case("simplify", "Simplify with no limit that concerns the ball.", _set("render", use_simplify=True, simplify_subdivision_render=6), SAME)


@case("border", osl_off=True)
def border(trial):
    """A quarter rendered as a border: the same quarter of the whole picture."""
    expected = trial.plain()
    trial.show(trial.material())
    render = bpy.context.scene.render
    render.use_border, render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = True, 0.0, 0.5, 0.5, 1.0
    got = trial.picture()
    half = (slice(0, 24), slice(0, 24))
    mean = [np.where(p.covered[half][..., None], p.passed("Combined")[half], 0.0).mean(axis=(0, 1)) for p in (got, expected)]
    trial.compare("upper left quarter", mean[0], mean[1], trial.within)


@case("light linking", osl_off=True)
def light_linking(trial):
    """A sun that is linked to another object only: the ball as without the sun."""
    trial.show(trial.material())
    bpy.data.objects["Sun"].hide_render = True
    expected = trial.picture(osl=True)
    trial.stage()
    trial.show(trial.material())
    other = bpy.data.collections.new("lit")
    other.objects.link(trial.show(None, plane_mesh("floor", 0.1), "floor"))
    bpy.data.objects["floor"].location.z = -5.0
    bpy.data.objects["Sun"].light_linking.receiver_collection = other
    trial.compare_pictures("linked away", trial.picture(), expected, trial.within)


@case("shadow linking", quick=False, osl_off=True)
def shadow_linking(trial):
    """A ball that is taken out of the sun's shadow casters throws none on a floor."""

    def floor_light(casts: bool) -> np.ndarray:
        trial.stage(max_bounces=0)
        floor = trial.show(None, plane_mesh("floor", 4.0), "floor")
        floor.location.z = -1.0
        ball = trial.show(trial.material())
        ball.visible_camera = False
        if not casts:
            blockers = bpy.data.collections.new("blockers")
            blockers.objects.link(floor)
            bpy.data.objects["Sun"].light_linking.blocker_collection = blockers
        bpy.context.scene.camera.data.ortho_scale = 5.0
        bpy.context.scene.world = None
        return trial.picture().passed("Combined")

    without = floor_light(False)
    trial.require("a shadow falls with it", floor_light(True).min() < 0.2 * without.max())
    trial.compare("darkest without it", without.min(), without.max(), 0.05)


@case("visible to the camera only by reflection", quick=False, osl_off=True)
def ray_visibility(trial):
    """A ball without Camera visibility: no alpha."""
    trial.show(trial.material()).visible_camera = False
    trial.compare("alpha", trial.picture().alpha.max(), 0.0, 0.001, least=1.0)


@case("two suns and an area light", quick=False, osl_off=True)
def many_lights(trial):
    """Lights one by one: their pictures' sum beside the picture with all of them."""
    trial.show(trial.material())
    scene = bpy.context.scene
    scene.world = None
    area = bpy.data.lights.new("Area", "AREA")
    area.energy, area.size = 200.0, 2.0
    add_object(scene, "Area", area).location = (0.0, 0.0, 3.0)
    scene.cycles.samples = 64
    lights = [bpy.data.objects[name] for name in ("Sun", "Area")]
    both = trial.picture().mean
    one_by_one = []
    for light in lights:
        light.hide_render = True
        one_by_one.append(trial.picture(osl=True).mean)
        light.hide_render = False
    trial.compare("all", both, sum(one_by_one), max(NOISE, trial.within))


@case("Freestyle lines", quick=False, osl_off=True)
def freestyle(trial):
    """With Freestyle on, without lines to draw: the surface stays."""
    expected = trial.plain()
    trial.show(trial.material())
    bpy.context.scene.render.use_freestyle = True
    bpy.context.view_layer.use_freestyle = True
    trial.compare_pictures("surface", trial.picture(), expected, max(NOISE, trial.within))


@case("reflected in a mirror", quick=False, osl_off=True)
def mirror(trial):
    """The ball seen in a perfect mirror beside the ball seen at once."""
    expected = trial.plain()
    scene = trial.stage()
    trial.show(trial.material())
    glass = bpy.data.materials.new("mirror")
    tree = node_tree(glass)
    shader = tree.nodes.new("ShaderNodeBsdfAnisotropic")
    shader.inputs["Color"].default_value, shader.inputs["Roughness"].default_value = (1.0,) * 4, 0.0
    tree.links.new(shader.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    plate = trial.show(glass, plane_mesh("mirror", 1.3), "mirror")
    plate.location, plate.rotation_euler = (0.0, 0.0, 6.0), (0.0, 1.25 * np.pi, 0.0)
    plate.visible_shadow = plate.visible_diffuse = plate.visible_glossy = False
    camera = scene.camera
    camera.location, camera.rotation_euler = (-6.0, 0.0, 6.0), (0.5 * np.pi, 0.0, -0.5 * np.pi)
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = 4
    got = trial.picture()
    # the mirror covers the frame, so the ball is where the picture is not that of the world
    inside = np.linalg.norm(np.indices(got.alpha.shape) - (np.array(got.alpha.shape)[:, None, None] - 1) / 2, axis=0) < 17
    mean = [p.passed("Combined")[inside].mean(axis=0) for p in (got, expected)]
    trial.compare("middle of the ball", mean[0], mean[1], max(NOISE, trial.within))
