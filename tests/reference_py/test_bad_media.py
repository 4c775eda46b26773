# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that scatter at and beyond the ends of what they may be: a right answer or one line."""

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.baked.live import axes_of
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.slab import half_space_albedo
from lamina.reference_py.registry import make_model

UP = np.array([[0.0, 0.0, 1.0], [0.8, 0.0, 0.6]])
BASE = {"kind": "lambert", "color": [0.5, 0.3, 0.1]}


def cloudy(count: int = 1, **values) -> Stack:
    layer = {"kind": "dielectric", "ior": 1.5, "roughness": 0.1, "scatter_color": [0.8, 0.8, 0.8], "density": 2.0, "scatter_g": 0.0, **values}
    return Stack.from_dict({"layers": [layer] * count, "base": BASE})


def albedo(stack: Stack) -> np.ndarray:
    return make_model("adding", stack, draft=1).albedo(UP)


def test_density_0_is_a_clear_layer():
    clear = Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.1}], "base": BASE})
    np.testing.assert_allclose(albedo(cloudy(density=0.0)), albedo(clear), rtol=1e-9)


def test_the_densest_hides_the_base_and_shows_its_color():
    over_white = Stack.from_dict({**cloudy(density=1000.0).to_dict(), "base": {"kind": "lambert", "color": [1.0, 1.0, 1.0]}})
    np.testing.assert_allclose(albedo(cloudy(density=1000.0)), albedo(over_white), rtol=1e-3)
    painted = Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5, "roughness": 0.1}], "base": {"kind": "lambert", "color": [0.8] * 3}})
    # light that leaves a medium leaves it more to the side than Lambert's does, and more of it is turned back
    ratio = albedo(cloudy(density=1000.0)) / albedo(painted)
    print(f"beside a paint of this color {ratio[:, 0]}")
    assert np.all((0.95 < ratio) & (ratio < 1.0))  # measured .964 and .984


def test_color_1_absorbs_nothing():
    white = Stack.from_dict({**cloudy(scatter_color=[1.0, 1.0, 1.0], density=5.0).to_dict(), "base": {"kind": "lambert", "color": [1.0, 1.0, 1.0]}})
    np.testing.assert_allclose(albedo(white), 1.0, atol=0.004)
    assert half_space_albedo(np.ones(3), 0.5) == pytest.approx(1.0)


@pytest.mark.parametrize("g", [-0.99, 0.99])
def test_the_most_forward_and_backward_are_finite_and_ordered(g):
    found = albedo(cloudy(scatter_g=g))
    assert np.all(np.isfinite(found)) and np.all((found > 0.0) & (found < 1.0))
    assert np.all(np.sign(albedo(cloudy(scatter_g=0.0)) - found) == np.sign(g))


def test_twenty_cloudy_layers_are_one_that_is_twenty_times_as_thick():
    matched = cloudy(20, ior=1.0, roughness=0.0, density=0.5)
    np.testing.assert_allclose(albedo(matched), albedo(cloudy(ior=1.0, roughness=0.0, density=10.0)), rtol=2e-3)


def test_a_texture_of_the_density_that_goes_below_0_is_a_clear_layer():
    """And one that goes beyond what a bake knows ends there."""
    one, place = cloudy(thickness=0.5), Place(0, "density")
    (axis,) = axes_of(one, (place,))
    assert axis.coordinate(place.with_value(one, -2.0)) == axis.coordinate(cloudy(density=0.0)) == 0.0
    assert axis.at(one, 0.5).layers[0]["density"] == pytest.approx(2.0)  # of an optical depth of 1
    last = axis.knots.count - 2, 1.0
    assert axis.knots.place(axis.coordinate(place.with_value(one, 1e9))) == pytest.approx(last)


def test_a_density_together_with_a_thickness_is_not_followed():
    assert axes_of(cloudy(), (Place(0, "density"), Place(0, "thickness"))) is None
    with pytest.raises(LaminaError, match="no quality follows the density of Dielectric, the thickness of Dielectric where a medium scatters"):
        make_lobe_set(cloudy(), "auto", live=(Place(0, "density"), Place(0, "thickness")))


@pytest.mark.parametrize(
    "values, words",
    [
        ({"density": -1.0}, "density is -1; choose 0 to 1000"),
        ({"density": 1e9}, "density is 1e+09; choose 0 to 1000"),
        ({"density": float("nan")}, "density is nan"),
        ({"scatter_color": [1.1, 0.5, 0.5]}, "scatter_color[0] is 1.1; choose 0 to 1"),
        ({"scatter_g": 1.0}, "scatter_g is 1; choose -0.99 to 0.99"),
        ({"scatter_g": -1.0}, "scatter_g is -1; choose -0.99 to 0.99"),
        ({"extinction": [1.0, 1.0, 1.0], "scatter_albedo": [1.0, 1.0, 1.0]}, "exclude each other"),
    ],
)
def test_what_is_no_medium_gets_one_line(values, words):
    with pytest.raises(LaminaError) as error:
        cloudy(**values)
    assert words in str(error.value) and "layer 0" in str(error.value) and "\n" not in str(error.value)
