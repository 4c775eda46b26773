# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart of error against cost: its references, its slab, and one small case of the whole."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.view_table import KNOTS, DiffuseTable, TableLobes
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.models.adding.adding_model import Adding
from lamina.reference_py.registry import make_model
from lamina.study.pareto.ball_picture import Surroundings, ball_picture, difference, encoded, shown
from lamina.study.pareto.draw import frontier
from lamina.study.pareto.reflectance import LobeReflectance, ModelReflectance, Reference, TruthReflectance, belcour_lobes, glossy_lobes
from lamina.study.pareto.surface_types import SURFACES, load_surface
from lamina.study.tables import read_table

GREY = {"kind": "lambert", "color": [0.5, 0.5, 0.5]}
COATED = Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.0}], "base": GREY})


def test_the_display():
    ramp = shown(np.geomspace(1e-3, 1e3, 200)[:, None] * np.array([1.0, 0.5, 0.2]))
    assert np.all(np.diff(ramp, axis=0) >= -1e-12) and ramp.max() <= 1.0
    # light too bright for the screen turns white
    assert ramp[-1].min() > 0.9 and ramp[0, 2] < 0.3 * ramp[0, 0]
    assert list(encoded(np.array([0.0, 1.0]))) == [0, 255]


def test_a_white_furnace_shows_the_albedo():
    class White(Surroundings):
        texels = np.ones((16, 32))

    reflectance = LobeReflectance(glossy_lobes(np.array([0.9, 0.6, 0.3]), 0.3))
    picture = ball_picture(reflectance, [0.3], 12, White())
    inside = np.isfinite(picture[..., 0])
    place = (np.arange(12) + 0.5) / 6.0 - 1.0
    cosines = np.sqrt(np.maximum(1.0 - place**2 - place[:, None] ** 2, 0.0))[inside]
    np.testing.assert_allclose(picture[inside], reflectance.albedo(cosines), rtol=4e-3)


def test_the_truth_is_its_own_reference():
    truth = Adding(COATED)
    errors = Reference(COATED, truth).errors(TruthReflectance(truth))
    assert max(errors.albedo, errors.shape) < 1e-9


def test_layer_is_as_wrong_as_known():
    """.520 where physics has .316, and no less in the shape."""
    errors = Reference(COATED, Adding(COATED)).errors(ModelReflectance(make_model("cycles_layer", COATED)))
    assert 0.6 < errors.albedo < 0.8 and errors.shape >= 0.6


def test_belcour_in_tables_keeps_his_albedo():
    stack = load_surface("frosted_paint")
    model = make_model("belcour", stack)
    cosines = np.array([0.3, 0.7, 1.0])
    np.testing.assert_allclose(LobeReflectance(belcour_lobes(model)).albedo(cosines), ModelReflectance(model).albedo(cosines), rtol=0.02)


def test_frontier():
    assert frontier([(1.0, 5.0), (2.0, 6.0), (3.0, 1.0), (3.0, 2.0)]) == [(1.0, 5.0), (3.0, 1.0)]


def test_an_unknown_surface_is_named():
    for name in SURFACES:
        load_surface(name)
    with pytest.raises(LaminaError, match="'varnish'.*glazed_mug.*three_rough"):
        load_surface("varnish")


@pytest.mark.blender
def test_numpy_and_cycles_show_the_same_ball(blender):
    from lamina.study.pareto.bench import ball, studio_stage, with_material
    from lamina.study.pareto.compared_materials import table_material

    surroundings = Surroundings()
    lobe_set = TableLobes((*glossy_lobes(np.array([0.5, 0.3, 0.2]), 0.2).tables, DiffuseTable(np.ones((KNOTS, 3)) * 0.3)))
    expected = ball_picture(LobeReflectance(lobe_set), [0.2], 32, surroundings)
    with studio_stage(32, surroundings) as stage:
        stage.show([with_material(ball(), table_material(lobe_set, COATED, "pareto_test"))])
        rendered = stage.picture(128)
    error = difference(rendered, expected, surroundings)
    print(f"render against numpy: mean CIEDE2000 {error:.3f}")
    assert error < 0.5
    flipped = difference(rendered[:, ::-1], expected, surroundings)
    assert flipped > 3.0 * error


@pytest.mark.blender
@pytest.mark.parametrize("tint", [(1.0, 1.0, 1.0), (0.9, 0.5, 0.2)])
def test_the_slab_is_the_stack(blender, tint):
    """Smooth interfaces with absorption between them: Cycles' volumes and glass give what `adding` says."""
    from lamina.study.pareto.bench import furnace_stage, plane
    from lamina.study.pareto.explicit_slab import slab_objects
    from lamina.study.pareto.slab_truth import slab_errors

    smooth = {"kind": "dielectric", "roughness": 0.0}
    layers = [{**smooth, "ior": 1.5, "tint": tint}, {**smooth, "ior": 1.3, "tint": tint[::-1]}]
    stack = Stack.from_dict({"layers": layers, "base": GREY})
    with furnace_stage(128) as stage:
        errors = slab_errors(stage, slab_objects(stack, plane), stack, Adding(stack), 2)
    print(f"slab: albedo {errors.albedo:.3f}, shape {errors.shape:.3f}")
    # 4 standard errors of the darkest channel, of which the mirror-like .04 is most; the bins' noise adds up
    assert errors.albedo < (0.03 if min(tint) == 1.0 else 0.11)
    assert errors.shape_mean < 0.25


@pytest.mark.blender
@pytest.mark.slow
def test_one_small_chart(blender, tmp_path):
    from lamina.study.charts.pareto_chart import COLUMNS, chart
    from lamina.study.pareto.quality import Quality

    small = Quality(1, 32, 2, 16, 1, 16, 8, 16, 4, 1, memory=False)
    materials = len(blender.data.materials)
    chart(tmp_path, lambda text: None, ["glazed_mug"], 1, small)
    rows = {row["method"]: row for row in read_table(tmp_path / "pareto.csv")}
    assert tuple(rows["glossy"]) == COLUMNS
    ours = {"weidlich_wilkie", "analytic", "nodes", *(f"baked_{k}" for k in (1, 2, 3, 4))}
    assert set(rows) == {"glossy", "principled", "layer", "belcour", "slab"} | ours
    assert float(rows["glossy"]["cost"]) == 1.0
    assert float(rows["baked_2"]["albedo"]) < 0.01 < float(rows["layer"]["albedo"])
    assert int(rows["baked_2"]["shader_bytes"]) < 100_000
    assert len(blender.data.materials) == materials and not list(tmp_path.glob(".*"))
