# SPDX-License-Identifier: GPL-3.0-or-later
"""A new kind of base or layer, and a new distribution: every model and method computes it by its class's own methods, or refuses it.

None may take it for another kind. `docs/extending.md` tells how a real one is added.
"""

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import METHODS, make_lobe_set
from lamina.reference_py.material.schema import COLOR, DIELECTRIC, SCHEMA, Kind, Parameter, Schema
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics import microfacet, optical_stack
from lamina.reference_py.optics.distribution import Distribution
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.interface import Interface
from lamina.reference_py.registry import MODELS, make_model

COAT = {"kind": "dielectric", "ior": 1.5, "roughness": 0.4}
WO = spherical(np.radians(35.0), 0.0)
WI = spherical(np.radians([10.0, 35.0, 60.0]), np.radians([20.0, 180.0, 90.0]))


@dataclass(frozen=True)
class Retro:
    """A base that sends light back to where it came from: color / pi times 1.5 cos(wi, wo) where that is above 0."""

    n_above: float
    color: np.ndarray

    facets = None
    is_specular = False
    channels = 3

    @classmethod
    def of(cls, base, n_above):
        return cls(n_above, np.array(base["color"]))

    def channel_key(self, channel):
        return self.color[channel]

    def f(self, wi, wo, qualitative=False):
        return self.color / np.pi * 1.5 * np.maximum(np.sum(wi * wo, axis=-1, keepdims=True), 0.0)


@dataclass(frozen=True)
class Mesh(Interface):
    """A layer that is given by its reflectance along the normal and not by its index."""

    @classmethod
    def of(cls, layer, n_above):
        root = np.sqrt(layer["facing"])
        whole = layer.with_values(ior=n_above * (1.0 + root) / (1.0 - root), tint=(1.0, 1.0, 1.0), thickness=1.0, distribution="ggx")
        return Interface.of(whole, n_above)


@dataclass(frozen=True)
class Foam:
    """A layer that is no interface."""

    n_below: float

    @classmethod
    def of(cls, layer, n_above):
        return cls(n_above)


class Cone(Distribution):
    """Slopes of constant density up to sqrt(2) alpha, masked as GGX."""

    name = "cone"
    mean_slope_per_alpha = 2.0**1.5 / 3.0

    def slope_density(self, slope2):
        return np.where(slope2 < 2.0, 0.5, 0.0)

    def slope2_quantile(self, u):
        return 2.0 * u

    def smith_lambda(self, a2_tan2):
        return 0.5 * (np.sqrt(1.0 + a2_tan2) - 1.0)


@pytest.fixture
def schema(monkeypatch):
    """A copy of the schema that has them, and their classes in the tables."""
    facing = Parameter("facing", "float", 0.04, "Facing", "Reflectance along the normal")
    roughness, distribution = (DIELECTRIC.parameter(name) for name in ("roughness", "distribution"))
    either = replace(DIELECTRIC, parameters=tuple(replace(p, choices=(*p.choices, "cone")) if p == distribution else p for p in DIELECTRIC.parameters))
    layers = {"dielectric": either, "mesh": Kind("mesh", "Mesh", "", (facing, roughness)), "foam": Kind("foam", "Foam", "", (facing,))}
    retro = Kind("retro", "Retro", "", (Parameter("color", COLOR, (0.6, 0.4, 0.2), "Color", ""),))
    monkeypatch.setitem(optical_stack.LAYERS, "mesh", Mesh)
    monkeypatch.setitem(optical_stack.LAYERS, "foam", Foam)
    monkeypatch.setitem(optical_stack.BASES, "retro", Retro)
    monkeypatch.setitem(microfacet.DISTRIBUTIONS, "cone", Cone())
    return Schema(MappingProxyType(layers), MappingProxyType({**SCHEMA.bases, "retro": retro}))


def read(schema, *layers, base=None):
    return Stack.from_dict({"layers": list(layers), "base": base or {"kind": "lambert", "color": [0.5, 0.5, 0.5]}}, schema=schema)


def values(name, stack):
    """f of a model, or a method's lobe set; an error if it is refused."""
    if name.startswith("method "):
        return make_lobe_set(stack, name.removeprefix("method "))
    options = {"walks": 16} if name == "position_free" else {}
    return make_model(name, stack, **options).f(WO, WI)


NAMES = [*MODELS, *(f"method {name}" for name in METHODS)]
# Those that take any base with an f of its own, and any distribution with D and masking.
BY_METHODS = {"base": {"weidlich_wilkie", "weidlich_wilkie_repaired", "position_free"}, "distribution": {"weidlich_wilkie", "weidlich_wilkie_repaired"}}


def refusal(name, stack):
    with pytest.raises(LaminaError) as caught:
        values(name, stack)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", NAMES)
def test_a_new_base_is_computed_by_its_own_methods_or_refused(schema, name):
    bare, coated = (read(schema, *layers, base={"kind": "retro"}) for layers in ((), (COAT,)))
    if name not in BY_METHODS["base"]:
        for stack in (bare, coated):
            told = refusal(name, stack)
            assert "knows no base retro, which base has" in told and ("choose" in told or "no method does" in told)
        return
    expected = Retro(1.0, np.array([0.6, 0.4, 0.2])).f(WI, WO)
    assert values(name, bare) == pytest.approx(expected, rel=1e-9)
    assert np.all(np.isfinite(values(name, coated)))


@pytest.mark.parametrize("name", NAMES)
def test_a_new_distribution_is_computed_by_its_own_methods_or_refused(schema, name):
    stack = read(schema, {**COAT, "distribution": "cone"}, base={"kind": "lambert", "color": [0.0, 0.0, 0.0]})
    if name not in BY_METHODS["distribution"]:
        assert "knows no distribution cone, which layer 0 has" in refusal(name, stack)
        return
    # facets steeper than sqrt(2) alpha there are none, where those of GGX and Beckmann go on
    beyond = spherical(np.radians(35.0 + 2.2 * np.degrees(np.arctan(np.sqrt(2.0) * 0.16))), np.pi)
    model = make_model(name, stack)
    assert np.all(model.f(WO, beyond) == 0.0) and np.all(model.f(WO, WI[1]) > 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_a_new_layer_of_known_optics_is_what_its_class_says(schema, name):
    """Every model takes it for the interface that its class makes: that of ior 1.5."""
    if name == "lafortune" or name.startswith("method "):
        pytest.skip("has no layers" if name == "lafortune" else "closures say so by their models")
    mesh, coat = read(schema, {"kind": "mesh", "facing": 0.04, "roughness": 0.4}), read(schema, COAT)
    assert values(name, mesh) == pytest.approx(values(name, coat), rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_a_layer_that_is_no_interface_is_refused(schema, name):
    assert "knows no layer foam, which layer 0 has" in refusal(name, read(schema, {"kind": "foam"}))


def test_a_kind_without_optics_is_named(schema, monkeypatch):
    monkeypatch.delitem(optical_stack.BASES, "retro")
    assert refusal("adding", read(schema, base={"kind": "retro"})) == "base: the kind retro has no optics; choose lambert, oren_nayar, conductor"
