# SPDX-License-Identifier: GPL-3.0-or-later
"""The instruments: what they read off stock materials must be what the formulas, written here anew, say."""

import importlib
import os
import sys

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender import environment, images, versions
from lamina.addon.rendering import geometry, measure, sheet, studio
from lamina.reference_py.errors import LaminaError

pytestmark = pytest.mark.blender


@pytest.fixture(autouse=True, scope="module")
def osl_on_path():
    environment.ensure_osl_query_on_path()


def stock(kind: str, distribution: str = "", **inputs) -> bpy.types.Material:
    """Material of one stock BSDF node, white unless told otherwise."""
    material = bpy.data.materials.new(kind)
    tree = versions.node_tree(material)
    tree.nodes.clear()
    shader, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    if distribution:
        shader.distribution = distribution
    for name, value in ({"Color": (1.0, 1.0, 1.0, 1.0)} | inputs).items():
        shader.inputs[name].default_value = value
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def glossy(distribution: str, alpha: float) -> tuple[bpy.types.Material, float]:
    """Glossy material and the alpha that it really has: the square of a float32 roughness."""
    roughness = np.float32(np.sqrt(alpha))
    return stock("ShaderNodeBsdfAnisotropic", distribution, Roughness=float(roughness)), float(roughness * roughness)


def microfacet_f_cos(distribution: str, alpha: float, n, wi, wo):
    """f * cos_theta_i of a lossless microfacet lobe: D and height-correlated G2 (Heitz 2014); Beckmann's Lambda is the
    rational fit of Walter et al. 2007, as in Cycles. sin^2 of the half angle comes from a cross product."""

    def tan2(c):
        return np.maximum(1.0 / c**2 - 1.0, 0.0)

    h = (wi + wo) / np.linalg.norm(wi + wo)
    cos_i, cos_o, cos_h = n @ wi, n @ wo, n @ h
    tan2_h = np.sum(np.cross(n, h) ** 2, axis=-1) / cos_h**2
    if distribution == "GGX":
        D = 1.0 / (np.pi * alpha**2 * cos_h**4 * (1.0 + tan2_h / alpha**2) ** 2)

        def Lambda(c):
            return (np.sqrt(1.0 + alpha**2 * tan2(c)) - 1.0) / 2.0
    else:
        D = np.exp(-tan2_h / alpha**2) / (np.pi * alpha**2 * cos_h**4)

        def Lambda(c):
            a = 1.0 / (alpha * np.sqrt(np.maximum(tan2(c), 1e-30)))
            fit = (1.0 - 1.259 * a + 0.396 * a**2) / (3.535 * a + 2.181 * a**2)
            return np.where(alpha**2 * tan2(c) < 0.39, 0.0, fit)

    return D / ((1.0 + Lambda(cos_i) + Lambda(cos_o)) * 4.0 * cos_o)


def lit(reading: dict, least_cos: float = 0.05) -> np.ndarray:
    n = reading["normal"]
    return reading["mask"] & (n @ reading["wi"] > least_cos) & (n @ reading["wo"] > least_cos)


def test_diffuse_sphere_is_lambert_and_black_elsewhere():
    reading = measure.render_sun_sphere(stock("ShaderNodeBsdfDiffuse", Color=(0.5, 0.25, 1.0, 1.0)), 50.0, 64)
    cos_i = reading["normal"] @ reading["wi"]
    m = lit(reading)
    expected = cos_i[m][:, None] * np.array([0.5, 0.25, 1.0]) / np.pi
    np.testing.assert_allclose(reading["radiance"][m], expected, rtol=3e-6)
    assert not reading["radiance"][~reading["mask"]].any()
    assert not reading["radiance"][reading["mask"] & (cos_i < -1e-3)].any()
    # the unit disc covers pi / 4 of the picture
    assert reading["mask"].mean() == pytest.approx(np.pi / 4.0, abs=0.01)
    # x to the right and y up in the picture, and the sphere's facets are finer than 1e-4
    np.testing.assert_allclose(reading["position"], reading["normal"], atol=1e-4)
    assert reading["position"][10, 32, 1] > 0.5 and reading["position"][32, 54, 0] > 0.5


@pytest.mark.parametrize("distribution", ["GGX", "BECKMANN"])
@pytest.mark.parametrize("sun_deg", [0.0, 70.0])
def test_wide_lobes_equal_the_formula(distribution, sun_deg):
    material, alpha = glossy(distribution, 0.5)
    reading = measure.render_sun_sphere(material, sun_deg, 64)
    m = lit(reading)
    expected = microfacet_f_cos(distribution, alpha, reading["normal"][m], reading["wi"], reading["wo"])
    bright = expected > 1e-4 * expected.max()  # Beckmann's tail underflows
    error = np.abs(reading["radiance"][m][:, 0][bright] / expected[bright] - 1.0)
    assert bright.sum() > 1000
    assert np.median(error) < 1e-6 and error.max() < 1e-5


@pytest.mark.parametrize("distribution, alpha", [("BECKMANN", 0.002), ("GGX", 0.0175), ("GGX", 0.05)])
def test_narrow_lobes_are_as_exact_as_float32_allows(distribution, alpha):
    """Cycles takes sin^2 = 1 - cos^2 in float32: about 1e-7 / alpha^2 relative error, which a window resolves."""
    material, alpha = glossy(distribution, alpha)
    half = 2.5 * alpha
    reading = measure.render_sun_sphere(material, 60.0, 48, window=(np.sin(np.radians(30.0)), 0.0, half))
    n = reading["normal"] / np.linalg.norm(reading["normal"], axis=-1, keepdims=True)
    h = (reading["wi"] + reading["wo"]) / np.linalg.norm(reading["wi"] + reading["wo"])
    m = np.linalg.norm(np.cross(n, h), axis=-1) < 2.0 * alpha
    expected = microfacet_f_cos(distribution, alpha, n[m], reading["wi"], reading["wo"])
    measured = reading["radiance"][m][:, 0]
    assert m.sum() > 500
    assert np.percentile(np.abs(measured / expected - 1.0), 99) < 4e-7 / alpha**2 + 1e-6
    assert abs(measured.sum() / expected.sum() - 1.0) < 1e-7 / alpha**2 + 1e-6


def test_furnace_of_white_lossless_materials_is_one():
    angles = [0.0, 60.0, 89.0]
    for material, tolerance in ((stock("ShaderNodeBsdfDiffuse"), 1e-6), (glossy("GGX", 0.0)[0], 1e-6), (glossy("MULTI_GGX", 0.5)[0], 8e-3)):
        albedo, stderr = measure.render_furnace(material, angles, 32, 24)
        np.testing.assert_allclose(albedo, 1.0, atol=tolerance)
        assert albedo.shape == stderr.shape == (3, 3) and stderr.max() < 2e-3


def test_furnace_equals_the_integral_of_the_formula():
    """Single-scattering GGX loses energy: quadrature of f cos against the furnace, within four standard errors."""
    material, alpha = glossy("GGX", 0.6)
    albedo, stderr = measure.render_furnace(material, [0.0, 60.0], 64, 32)
    # Gauss-Legendre over the polar angle of the light, midpoints over its azimuth
    node, weight = np.polynomial.legendre.leggauss(400)
    theta, phi = (node + 1.0) * np.pi / 4.0, (np.arange(400) + 0.5) * 2.0 * np.pi / 400
    wi = np.stack(np.broadcast_arrays(np.sin(theta)[:, None] * np.cos(phi), np.sin(theta)[:, None] * np.sin(phi), np.cos(theta)[:, None]), axis=-1)
    for view, measured, error in zip(np.radians([0.0, 60.0]), albedo[:, 0], stderr[:, 0]):
        wo = np.array([np.sin(view), 0.0, np.cos(view)])
        h = wi + wo
        h /= np.linalg.norm(h, axis=-1, keepdims=True)
        a2, cos_h = alpha**2, h[..., 2]
        D = a2 / (np.pi * (cos_h**2 * (a2 - 1.0) + 1.0) ** 2)
        lambdas = sum((np.sqrt(1.0 + a2 * (1.0 / c**2 - 1.0)) - 1.0) / 2.0 for c in (wo[2], wi[..., 2]))
        f_cos = D / ((1.0 + lambdas) * 4.0 * wo[2])
        expected = np.sum(f_cos * (weight * np.pi / 4.0 * np.sin(theta))[:, None]) * 2.0 * np.pi / 400
        assert abs(measured - expected) < 4.0 * error + 1e-5
        assert error < 1e-3


def test_furnace_standard_error_is_the_spread_of_repetitions():
    material, _ = glossy("GGX", 0.6)
    runs = [measure.render_furnace(material, [0.0], 4, 16, seed=100 * k) for k in range(12)]
    spread = np.std([albedo[0, 0] for albedo, _ in runs], ddof=1)
    claimed = np.mean([stderr[0, 0] for _, stderr in runs])
    assert 0.5 < spread / claimed < 1.8
    again, _ = measure.render_furnace(material, [0.0], 4, 16, seed=0)
    assert again[0, 0] == runs[0][0][0, 0]


def test_measuring_leaves_nothing_behind():
    material = stock("ShaderNodeBsdfDiffuse")
    kinds = ("scenes", "objects", "meshes", "lights", "cameras", "worlds", "materials", "curves")

    def census():
        return {kind: len(getattr(bpy.data, kind)) for kind in kinds}

    before = census()
    measure.render_sun_sphere(material, 10.0, 8)
    measure.render_furnace(material, [0.0], 1, 4)
    studio.build_ball_scene(material, 16, 1).remove()
    assert census() == before


@pytest.mark.parametrize("size", [16, (64, 16), (16, 64), (48, 32)])
def test_the_ball_is_whole_and_as_large_in_pictures_of_any_shape(size):
    from bpy_extras.object_utils import world_to_camera_view

    built = studio.build_ball_scene(stock("ShaderNodeBsdfDiffuse"), size, 1)
    built.scene.view_layers[0].update()
    wide, high = built.scene.render.resolution_x, built.scene.render.resolution_y
    at = np.array([world_to_camera_view(built.scene, built.scene.camera, built.ball.matrix_world @ v.co)[:2] for v in built.ball.data.vertices])
    built.remove()
    assert at.min() > 0.0 and at.max() < 1.0
    extent = np.ptp(at, axis=0) * (wide, high) / min(wide, high)
    assert 0.6 < extent.min() and extent.max() < 0.95


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda m: measure.render_sun_sphere(m, 200.0), "sun_theta_deg 200"),
        (lambda m: measure.render_sun_sphere(m, 0.0, window=(3.0, 0.0, 0.1)), "window"),
        (lambda m: measure.render_furnace(m, [90.0]), "theta_deg_list"),
        (lambda m: measure.render_furnace(m, [0.0], 0), "0 samples"),
        (lambda m: sheet.render_sheet([], "sheet.png"), "0 materials"),
        (lambda m: sheet.render_sheet([sheet.Tile("a", m)], "/nowhere/at/all/sheet.png"), "does not exist"),
    ],
)
def test_bad_requests_are_refused_by_name(call, words):
    with pytest.raises(LaminaError, match=words):
        call(stock("ShaderNodeBsdfDiffuse"))


@pytest.mark.parametrize(
    "make", [geometry.sphere_mesh, geometry.ball_mesh, geometry.stand_mesh, geometry.backdrop_mesh, lambda name: geometry.plane_mesh(name, 1.0)]
)
def test_meshes_are_valid_and_face_outward(make):
    mesh = make("Mesh")
    assert not mesh.validate()  # True would mean that Blender had to repair it
    assert all(len(set(face.vertices)) == len(face.vertices) for face in mesh.polygons)
    if make is geometry.sphere_mesh:
        assert min(face.normal.dot(face.center) for face in mesh.polygons) > 0.99
        assert max(abs(vertex.co.length - 1.0) for vertex in mesh.vertices) < 1e-6
    if make in (geometry.ball_mesh, geometry.sphere_mesh):  # the divergence theorem: outward faces enclose a volume
        assert sum(face.normal.dot(face.center) * face.area for face in mesh.polygons) / 3.0 > 3.4


def test_osl_report_is_right_about_this_build():
    has, reason = environment.osl_available()
    if environment.is_wheel():
        importlib.import_module("oslquery")
        assert has and reason.startswith("OSL")
    before = list(sys.path)
    environment.ensure_osl_query_on_path()
    assert sys.path == before


def test_a_real_blender_keeps_its_path(monkeypatch):
    monkeypatch.setattr(environment, "is_wheel", lambda: False)
    monkeypatch.setattr(sys, "path", [p for p in sys.path if "bpy" not in p])
    before = list(sys.path)
    environment.ensure_osl_query_on_path()
    assert sys.path == before


def test_exr_round_trip_and_blender_agrees(tmp_path):
    rng = np.random.default_rng(3)
    wanted = {c: rng.normal(size=(37, 21)).astype(np.float32) for c in "RGB"}
    wanted["B"][:] = 0.25  # a plane that compresses, beside ones that do not
    images.write_exr(tmp_path / "a.exr", wanted, {"source": "test, \u03b1"})
    channels, metadata = images.read_exr(tmp_path / "a.exr")
    assert metadata == {"source": "test, \u03b1"}
    for name, plane in wanted.items():
        np.testing.assert_array_equal(channels[name], plane)
    image = bpy.data.images.load(str(tmp_path / "a.exr"))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(37 * 21 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    np.testing.assert_array_equal(pixels.reshape(37, 21, 4)[::-1, :, 0], wanted["R"])
    bpy.data.images.remove(image)


def test_png_round_trip_and_blender_agrees(tmp_path):
    y, x = np.mgrid[0:40, 0:50]
    smooth = np.stack([x * 5, y * 6, (x * y) % 256], axis=-1)
    pixels = np.concatenate([smooth, np.random.default_rng(1).integers(0, 256, (40, 50, 3))]).astype(np.uint8)
    images.write_png(tmp_path / "a.png", pixels, {"lamina:Title": "caf\u00e9"})
    back, metadata = images.read_png(tmp_path / "a.png")
    np.testing.assert_array_equal(back, pixels)
    assert metadata == {"lamina:Title": "caf\u00e9"}
    image = bpy.data.images.load(str(tmp_path / "a.png"))
    image.colorspace_settings.name = "Non-Color"
    loaded = np.empty(80 * 50 * 4, np.float32)
    image.pixels.foreach_get(loaded)
    np.testing.assert_allclose(loaded.reshape(80, 50, 4)[::-1, :, :3] * 255.0, pixels, atol=1e-3)
    # and the other way: what Blender's encoder writes, all its row filters included
    image.file_format = "PNG"
    image.save(filepath=str(tmp_path / "b.png"))
    np.testing.assert_array_equal(images.read_png(tmp_path / "b.png")[0][..., :3], pixels)
    bpy.data.images.remove(image)


@pytest.mark.parametrize("read, name", [(images.read_exr, "x.exr"), (images.read_png, "x.png")])
def test_broken_pictures_are_named(tmp_path, read, name):
    with pytest.raises(LaminaError, match="cannot read"):
        read(tmp_path / name)
    (tmp_path / name).write_bytes(b"not a picture")
    with pytest.raises(LaminaError, match=name):
        read(tmp_path / name)


def test_a_header_that_claims_too_much_is_refused_in_one_line(tmp_path):
    """Found by make fuzz: OpenImageIO says it in several lines, and without a limit asks for the memory."""
    images.write_exr(tmp_path / "a.exr", {"R": np.zeros((4, 4))})
    data = (tmp_path / "a.exr").read_bytes()
    window = np.array([0, 0, 3, 3], "<i4").tobytes()
    assert data.count(window) == 2
    (tmp_path / "a.exr").write_bytes(data.replace(window, np.array([0, 0, 199_999, 199_999], "<i4").tobytes()))
    with pytest.raises(LaminaError, match="a.exr: not an EXR file") as raised:
        images.read_exr(tmp_path / "a.exr")
    assert "\n" not in str(raised.value)


def test_sheet_shows_each_material_over_its_label(tmp_path):
    def principled(color):
        material = bpy.data.materials.new("Look")
        node = next(n for n in versions.node_tree(material).nodes if n.type == "BSDF_PRINCIPLED")
        node.inputs["Base Color"].default_value = (*color, 1.0)
        return material

    seen = []
    items = [sheet.Tile("Red", principled((0.6, 0.01, 0.01))), sheet.Tile("Blue", principled((0.01, 0.01, 0.6)))]
    sheet.render_sheet(items, tmp_path / "sheet.png", 2, 64, 2, lambda done, text: seen.append((done, text)), metadata={"Source": "test"})
    pixels, metadata = images.read_png(tmp_path / "sheet.png")
    half = pixels.shape[1] // 2
    ball = pixels[30:45].astype(int)  # across both balls, below their highlights
    red, blue = ball[:, 25 : half - 25].mean(axis=(0, 1)), ball[:, half + 25 : -25].mean(axis=(0, 1))
    assert red[0] > 1.5 * red[2] and blue[2] > 1.5 * blue[0]
    assert pixels[70:].max() > 120 and pixels[:4].max() < 40  # labels below the tiles, nothing in the margin
    assert seen[0] == (0.0, "Red") and seen[-1][0] == 1.0 and metadata["Source"] == "test"
    assert os.listdir(tmp_path) == ["sheet.png"]
