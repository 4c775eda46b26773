# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings of the two kinds of picture: a measurement and a studio photograph; and scenes to render them in."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from ...reference_py.errors import LaminaError
from ..blender.environment import osl_available
from ..blender.interrupt import interruptible
from ..blender.versions import set_media_type


def _common(scene: bpy.types.Scene, samples: int, size: int | tuple[int, int], device: str = "CPU") -> None:
    width, height = (size, size) if isinstance(size, int) else size
    if samples < 1 or min(width, height) < 1:
        raise LaminaError(
            "render of {width} x {height} pixels with {samples} samples: all three must be at least 1", width=width, height=height, samples=samples
        )
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1.0
    render.use_border = render.use_compositing = render.use_sequencer = False
    render.use_motion_blur = render.use_persistent_data = False
    render.film_transparent = False
    render.dither_intensity = 0.0
    cycles.device = device
    cycles.shading_system = osl_available()[0]
    cycles.samples = samples
    cycles.use_animated_seed = False
    cycles.time_limit = 0.0
    cycles.film_exposure = 1.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.use_guiding = cycles.use_fast_gi = False
    scene.view_settings.use_curve_mapping = False
    scene.view_settings.exposure, scene.view_settings.gamma = 0.0, 1.0
    scene.display_settings.display_device = "sRGB"


def measurement_settings(
    scene: bpy.types.Scene, samples: int, size: int | tuple[int, int], *, max_bounces: int = 0, seed: int = 0, device: str = "CPU", osl: bool = True
) -> None:
    """Set up `scene` so that its pixels are plain Monte Carlo estimates in linear float32.

    Cycles on `device`, "CPU" or "GPU"; with `osl` OSL is on where there is OSL; pixels that do not overlap (box filter of width .01), nothing that trades
    bias for noise (denoiser, clamps, blur_glossy, light threshold), a multilayer EXR without view transform.
    `size` is the width and height in pixels, or both.
    Raises LaminaError for samples or sizes below 1.
    """
    _common(scene, samples, size, device)
    cycles = scene.cycles
    cycles.shading_system = cycles.shading_system and osl
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    # blue noise would correlate neighbouring pixels, and their spread is our error bar
    cycles.sampling_pattern = "TABULATED_SOBOL"
    cycles.seed = seed
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 0.01
    cycles.blur_glossy = 0.0
    cycles.use_light_tree = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = max_bounces
    cycles.transmission_bounces = max_bounces
    cycles.transparent_max_bounces = 8
    scene.view_settings.view_transform, scene.view_settings.look = "Raw", "None"
    image = scene.render.image_settings
    set_media_type(image, "MULTI_LAYER_IMAGE")
    image.file_format = "OPEN_EXR_MULTILAYER"
    image.color_depth, image.exr_codec = "32", "ZIP"


def studio_settings(scene: bpy.types.Scene, samples: int, size: int | tuple[int, int], *, seed: int = 0) -> None:
    """Set up `scene` for a pretty picture: a soft pixel filter, OpenImageDenoise where there is one, 8-bit PNG.

    The view transform is Khronos PBR Neutral, made to show a material's own color; AgX turns copper into pewter.
    Raises LaminaError for samples or sizes below 1.
    """
    import _cycles

    _common(scene, samples, size)
    cycles = scene.cycles
    cycles.seed = seed
    cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.adaptive_min_samples = True, 0.03, 8
    cycles.use_light_tree = False  # for a handful of lights it only costs time (1.7 times)
    cycles.use_denoising = _cycles.with_openimagedenoise
    if cycles.use_denoising:
        cycles.denoiser = "OPENIMAGEDENOISE"
        cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.5
    cycles.blur_glossy = 0.0
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 4, 1, 3
    scene.view_settings.view_transform, scene.view_settings.look = "Khronos PBR Neutral", "None"
    image = scene.render.image_settings
    set_media_type(image, "IMAGE")
    image.file_format, image.color_mode, image.color_depth, image.compression = "PNG", "RGB", "8", 15


def render_to(scene: bpy.types.Scene, path: str | os.PathLike) -> None:
    """Render `scene` (it need not be the window's) into the file `path`.

    Raises LaminaError when Blender leaves no file: render() returns FINISHED even then.
    """
    path = Path(path)
    scene.render.filepath = str(path)
    scene.render.use_file_extension = False
    try:
        with interruptible():
            bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise LaminaError("rendering {scene}: {reason}", scene=scene.name, reason=str(error).strip()) from None
    if not path.is_file() or path.stat().st_size == 0:
        raise LaminaError("rendering {scene}: Blender wrote no picture to {path}", scene=scene.name, path=path)


def add_object(scene: bpy.types.Scene, name: str, data: bpy.types.ID) -> bpy.types.Object:
    """New object with `data` in `scene`."""
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item


def remove_scene(scene: bpy.types.Scene) -> None:
    """Remove `scene`, its objects, what only they used, and its world. Materials stay."""
    world, data = scene.world, {item.data for item in scene.collection.all_objects if item.data}
    bpy.data.batch_remove(list(scene.collection.all_objects))
    bpy.data.batch_remove([block for block in data if block.users == 0])
    bpy.data.scenes.remove(scene)
    if world is not None and world.users == 0:
        bpy.data.worlds.remove(world)


@contextmanager
def scratch_scene(name: str) -> Iterator[bpy.types.Scene]:
    """A new scene without a world (black) that is gone, objects and all, when the block ends."""
    scene = bpy.data.scenes.new(name)
    try:
        yield scene
    finally:
        remove_scene(scene)
