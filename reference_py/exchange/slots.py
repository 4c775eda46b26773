# SPDX-License-Identifier: GPL-3.0-or-later
"""What Principled and OpenPBR have room for: a coat, a gloss and a base; a stack put into it, and a stack made of it."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import Sentence
from ..material.schema import ANISOTROPY, CONDUCTOR, COVERAGE, DIELECTRIC, NORMAL, SCATTERING, THIN_FILM
from ..material.stack import Base, Layer, Stack
from ..models.baselines.parts import COS_82, conductor, dielectric_f0
from ..optics.bases import ConductorBase, DiffuseBase
from ..optics.colour import artist_color, artist_index
from ..optics.diffuse import fujii_roughness
from ..optics.interface import Microfacets, optical_depth
from ..optics.optical_stack import OpticalStack
from .report import APPROXIMATED, KEPT, LOST, Loss, shown

BASE, COAT, GLOSS = "base", "coat", "gloss"
_AS_ITS = {COAT: Sentence("as the coat's"), GLOSS: Sentence("as the gloss's")}
# At 1 a metal has no finite index.
MOST_REFLECTANCE = CONDUCTOR.parameter("reflectance").maximum
# A layer that covers less and is no coat is left out.
_HALF = 0.5
# The round trip of a medium is its tint: half of the crossing that the tint is meant for, each way.
_ONE_WAY = 0.5
# Sockets take any number; below this one nothing but total reflection is left.
_LEAST_IOR = 0.2
# Reduced optical depth of a layer that stands for a medium without end; its base has the medium's color besides.
_OPAQUE = 20.0
_LIMITS = {p.name: p for p in SCATTERING.parameters}
SUBSURFACE, COAT_COLOR, FILM, METAL_FILM = "subsurface", "coat color", "film", "metal film"
"""What only some models have room for, beside the anisotropy of a coat; films are those of a gloss and of a metal."""
_IN_COLOR = Sentence("in the base color, the same at all angles")
_WHITE = 1e-9  # optical depth below which a medium is clear


@dataclass(frozen=True)
class Surface:
    """A dielectric interface: its index relative to what is above it, its roughness, and optional features by name."""

    eta: float
    roughness: float
    features: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Body:
    """A medium without end below the gloss, of the slots' color: its density per thickness, and how forward it scatters."""

    density: float
    g: float

    @classmethod
    def of(cls, free_path: float, g: float) -> "Body":
        """That of a mean free path in thicknesses, dense enough that nothing shows through."""
        g = float(np.clip(g, *(_LIMITS["scatter_g"].minimum, _LIMITS["scatter_g"].maximum)))
        return cls(float(np.clip(1.0 / max(free_path, 1e-9), _OPAQUE / (1.0 - max(g, 0.0)), _LIMITS["density"].maximum)), g)

    @property
    def values(self) -> dict:
        """Of a layer, but for its color."""
        return {"density": self.density, "scatter_g": self.g}


@dataclass(frozen=True)
class Slots:
    """Values that both models share. `color` is the diffuse albedo or, of a metal, F0 under its medium; linear RGB."""

    color: tuple
    edge: tuple | None = None
    """Gulbrandsen's edge tint of a metal's relative index; None for a diffuse base."""
    roughness: float = 0.5
    """Of a metal."""
    sigma_deg: float = 0.0
    """Of a diffuse base (Oren-Nayar); 0 is Lambert."""
    features: dict = field(default_factory=dict)
    """Of a metal: values of anisotropy and thin film."""
    gloss: Surface | None = None
    coat: Surface | None = None
    coat_tint: tuple = (1.0, 1.0, 1.0)
    """What two perpendicular crossings of the coat leave."""
    coat_weight: float = 1.0
    body: Body | None = None
    """Of a diffuse base: whether it stands for a medium that scatters."""

    @property
    def is_metal(self) -> bool:
        """Whether the base is a metal: then it has an edge tint."""
        return self.edge is not None

    def with_color(self, color) -> "Slots":
        """A copy of another color: (3,), or one number for all channels."""
        return replace(self, color=tuple(float(c) for c in np.broadcast_to(color, 3)))

    def image(self, coated: bool) -> Stack:
        """The stack that `baselines` read as these slots, without features; a clear top of index 1 stands for no coat."""
        layers, n = [], 1.0
        if coated and self.coat:
            n = self.coat.eta
            layers.append(_layer(n, _isotropic(self.coat.roughness, self.coat.features), self.coat_tint, _ONE_WAY))
        if self.gloss:
            layers = layers or [_layer(1.0, 0.0)]
            n *= self.gloss.eta
            layers.append(_layer(n, _isotropic(self.gloss.roughness, self.gloss.features)))
        return Stack(tuple(layers), self._image_base(n))

    def _image_base(self, n: float) -> Base:
        if self.is_metal:
            index = metal_index(self.color, self.edge)
            values = {"eta": tuple(n * index[0]), "k": tuple(n * index[1]), "roughness": _isotropic(self.roughness, self.features), "distribution": "ggx"}
            return Base("conductor", values)
        if self.sigma_deg > 0.0:
            return Base("oren_nayar", {"color": self.color, "sigma_deg": self.sigma_deg})
        return Base("lambert", {"color": self.color})


def metal_index(color, edge) -> tuple[np.ndarray, np.ndarray]:
    """Relative complex index of a metal given by F0 and edge tint."""
    return artist_index(np.clip(color, 0.0, MOST_REFLECTANCE), np.asarray(edge))


def edge_of_f82(color: np.ndarray, f82_tint: np.ndarray) -> np.ndarray:
    """Edge tint (3,) of the metal whose reflectance at 82 degrees is nearest to this share of Schlick's curve."""
    color = np.clip(color, 0.0, MOST_REFLECTANCE)
    edges = np.linspace(0.0, 1.0, 257)
    rise = color + (1.0 - color) * (1.0 - COS_82) ** 5
    reached = [conductor(*artist_index(color, np.full(3, g)))(np.full((), COS_82)) / rise for g in edges]
    return edges[np.argmin(np.abs(np.array(reached) - f82_tint), axis=0)]


def sigma_of_fujii(roughness: float) -> float:
    """Standard deviation in degrees whose `fujii_roughness` this is; 90 for more than there is."""
    degrees = np.linspace(0.0, 90.0, 9001)
    return float(np.interp(roughness, fujii_roughness(degrees), degrees))


def effective_ior(ior: float, level: float) -> float:
    """Index whose reflectance at normal incidence is that of `ior` times twice the Specular IOR Level, as Cycles has it."""
    ior = max(ior, _LEAST_IOR)
    if level == 0.5:
        return float(ior)
    root = np.sqrt(np.clip(dielectric_f0(ior) * 2.0 * level, 0.0, 0.99))
    eta = (1.0 + root) / (1.0 - root)
    return float(1.0 / eta if ior < 1.0 else eta)


def _isotropic(roughness: float, features: dict) -> float:
    """Roughness of the isotropic surface that stands for an anisotropic one."""
    return Microfacets.of(Layer("dielectric", {"roughness": roughness, "distribution": "ggx", **features})).alpha ** 0.5


def _layer(ior: float, roughness: float, tint=(1.0, 1.0, 1.0), thickness: float = 1.0) -> Layer:
    return Layer("dielectric", {"ior": ior, "roughness": roughness, "tint": tuple(tint), "thickness": thickness, "distribution": "ggx"})


@dataclass(frozen=True)
class Placed:
    """Slots, what became of each parameter, and which element of the stack each slot is: a layer's index, -1 the base."""

    slots: Slots
    losses: tuple[Loss, ...]
    owners: dict[str, int]

    @property
    def films(self) -> frozenset[int]:
        """The elements whose film is in the slots."""
        surfaces = {BASE: self.slots.features, GLOSS: self.slots.gloss.features if self.slots.gloss else {}}
        return frozenset(self.owners[role] for role, features in surfaces.items() if features.get("film_thickness"))


def from_stack(stack: Stack, name: str, room: frozenset[str] = frozenset()) -> Placed:
    """Put a stack into slots of the model called `name`; its base color is still that of the stack.

    `room`: what this model has beside the others: "anisotropy" of its coat, `SUBSURFACE` and what is there. One clear layer over a
    diffuse base is its gloss, any other top layer the coat; a layer that covers less than half and is no coat is left out. An
    opaque layer that covers half or more is the base.
    """
    losses: list[Loss] = []
    layers, place, base = _above_base(stack, losses, name)
    working = [(i, e) for n, (i, e) in enumerate(layers) if e["ior"] != (layers[n - 1][1]["ior"] if n else 1.0)]
    tau = sum((optical_depth(e["tint"], e["thickness"]) for _, e in layers), np.zeros(3))
    is_metal = isinstance(OpticalStack.of(base).base, ConductorBase)
    tinted = bool(np.max(tau) > _WHITE)
    as_gloss = (
        not is_metal and len(working) == 1 and not working[0][1].has(COVERAGE) and (not tinted or any(working[0][1].has(f) for f in (ANISOTROPY, THIN_FILM)))
    )
    coat = None if as_gloss or not layers else (working or layers)[0]
    rest = working[1:] if coat and working else working if as_gloss else []
    gloss = rest[0] if rest and not is_metal else None
    owners = {BASE: place} | ({COAT: coat[0]} if coat else {}) | ({GLOSS: gloss[0]} if gloss else {})
    above = coat[1]["ior"] if coat else 1.0
    slots = _base_slots(base, _medium_above_base(layers), losses, name, METAL_FILM in room)
    if coat:
        tint = tuple(np.exp(-2.0 * tau))
        slots = replace(
            slots,
            coat=Surface(above, coat[1]["roughness"], _features(coat[1])),
            coat_tint=tint,
            coat_weight=coat[1]["coverage"] if coat[1].has(COVERAGE) else 1.0,
        )
    if gloss:
        slots = replace(slots, gloss=Surface(gloss[1]["ior"] / above, gloss[1]["roughness"], _features(gloss[1], FILM in room)))
    if SUBSURFACE in room and layers and is_body(layers[-1][1], base.base):
        slots = replace(slots, body=Body(layers[-1][1]["density"] * layers[-1][1]["thickness"], layers[-1][1]["scatter_g"]))
    for index, layer in layers:
        role = next((r for r, i in owners.items() if i == index), None)
        losses += _layer_losses(
            f"layer {index}",
            layer,
            role,
            tinted and not (coat and COAT_COLOR in room),
            name,
            room,
            (index, layer) in working,
            slots.body is not None and index == layers[-1][0],
        )
    return Placed(slots, tuple(losses), owners)


def _above_base(stack: Stack, losses: list[Loss], name: str) -> tuple[list[tuple[int, Layer]], int, Stack]:
    """The clear layers, each with its index, above what the base is, where that is (-1: the stack's own), and it as a stack."""
    layers: list[tuple[int, Layer]] = []
    for index, layer in enumerate(stack.layers):
        if not _is_there(index, layer, losses, name, is_coat=not layers and not layer.is_opaque):
            continue
        if layer.is_opaque:
            for hidden in range(index + 1, len(stack.layers)):
                losses.append(
                    Loss(f"layer {hidden} kind", stack.layers[hidden].kind, LOST, Sentence("it is below layer {index}, which is opaque", index=index))
                )
            losses.append(Loss("base kind", stack.base.kind, LOST, Sentence("it is below layer {index}, which is opaque", index=index)))
            return layers, index, Stack((), layer.as_base())
        layers.append((index, layer))
    return layers, -1, Stack((), stack.base)


def is_body(layer: Layer, base: Base) -> bool:
    """Whether a layer's medium goes on without end: its base has its color."""
    return "scatter_color" in layer and "color" in base and np.allclose(layer["scatter_color"], base["color"], atol=1e-6)


def _is_there(index: int, layer: Layer, losses: list[Loss], name: str, is_coat: bool) -> bool:
    if is_coat or not layer.has(COVERAGE) or layer["coverage"] == 1.0:
        return True
    there = layer["coverage"] >= _HALF
    becomes = Sentence("counts as whole") if there else Sentence("is left out")
    losses.append(
        Loss(
            f"layer {index} coverage",
            layer["coverage"],
            LOST,
            Sentence("only the coat of {name} has a weight; the layer {becomes}", name=name, becomes=becomes),
        )
    )
    return there


def _medium_above_base(layers) -> float:
    return layers[-1][1]["ior"] if layers else 1.0


def _features(element: Layer | Base, with_film: bool = True) -> dict:
    return {p.name: element[p.name] for f in (ANISOTROPY, *((THIN_FILM,) if with_film else ())) if element.has(f) for p in f.parameters}


def _base_slots(stack: Stack, n: float, losses: list[Loss], name: str, with_film: bool) -> Slots:
    base = stack.base
    if base.has(NORMAL):
        losses.append(Loss("base normal", "", KEPT, Sentence("as the normal")))
    optics = OpticalStack.of(stack).base
    if isinstance(optics, DiffuseBase):
        losses.append(Loss("base color", base["color"], APPROXIMATED, Sentence("solved such that the mean albedo stays")))
        if optics.sigma_deg:
            losses.append(Loss("base sigma_deg", optics.sigma_deg, KEPT, Sentence("as diffuse roughness")))
        return Slots(tuple(base["color"]), sigma_deg=optics.sigma_deg)
    f0, edge = artist_color(optics.eta / n, optics.k / n)
    given = next(v for v in ("metal", "eta", "reflectance") if v in base)
    losses.append(Loss(f"base {given}", base[given], APPROXIMATED, Sentence("as reflectance at 0 and 82 degrees, solved such that the mean albedo stays")))
    losses.append(Loss("base roughness", base["roughness"], KEPT, Sentence("as roughness")))
    losses += _distribution_loss("base", base, name)
    kept = _features(base, with_film)
    losses += [
        Loss(f"base {key}", value, *((KEPT, Sentence("as it is")) if key in kept else (APPROXIMATED, _IN_COLOR))) for key, value in _features(base).items()
    ]
    return Slots(tuple(np.minimum(f0, MOST_REFLECTANCE)), edge=tuple(edge), roughness=base["roughness"], features=kept)


def _distribution_loss(where: str, element: Layer | Base, name: str) -> list[Loss]:
    if element["distribution"] == "ggx":
        return []
    return [Loss(f"{where} distribution", element["distribution"], LOST, Sentence("{name} has GGX, whose highlights have longer tails", name=name))]


def _layer_losses(where: str, layer: Layer, role: str | None, in_color: bool, name: str, room, works: bool, is_body: bool) -> list[Loss]:
    """What became of a layer's parameters; `in_color`: there is no tint of a coat that could hold the media."""
    losses = []
    white = np.max(optical_depth(layer["tint"], layer["thickness"])) <= _WHITE
    if role:
        losses += [Loss(f"{where} ior", layer["ior"], KEPT, _AS_ITS[role]), Loss(f"{where} roughness", layer["roughness"], KEPT, _AS_ITS[role])]
        losses += _distribution_loss(where, layer, name)
    elif works:
        losses.append(Loss(f"{where} ior", layer["ior"], LOST, Sentence("{name} has no third interface and none between coat and metal", name=name)))
        losses.append(Loss(f"{where} roughness", layer["roughness"], LOST, Sentence("goes with its interface")))
    if white:
        losses.append(Loss(f"{where} tint", layer["tint"], KEPT, Sentence("it is clear")))
    elif in_color:
        losses.append(Loss(f"{where} tint", layer["tint"], APPROXIMATED, _IN_COLOR))
    else:
        how = Sentence("its round trip is the coat's tint") if role == COAT else Sentence("merged into the coat's tint")
        losses.append(Loss(f"{where} tint", layer["tint"], KEPT if role == COAT else APPROXIMATED, how))
    if role == COAT and layer.has(COVERAGE):
        losses.append(Loss(f"{where} coverage", layer["coverage"], KEPT, Sentence("as the coat's weight")))
    for feature in (ANISOTROPY, THIN_FILM):
        if layer.has(feature):
            fate, how = LOST, Sentence("{name} has no place for it here", name=name)
            if role == GLOSS and feature == THIN_FILM and FILM not in room:
                fate, how = APPROXIMATED, _IN_COLOR
            elif role == GLOSS or (role == COAT and feature.name in room):
                fate, how = KEPT, Sentence("as it is")
            losses += [Loss(f"{where} {p.name}", layer[p.name], fate, how) for p in feature.parameters]
    if layer.has(SCATTERING):
        given = (p.name for p in SCATTERING.parameters if p.name in layer)
        if is_body:
            how = Sentence("as light below the surface, which spreads there and not here")
        else:
            how = Sentence("in the base color alone, such that the mean albedo stays")
        losses += [Loss(f"{where} {key}", layer[key], APPROXIMATED, how) for key in given]
    if layer.has(NORMAL):
        losses.append(Loss(f"{where} normal", "", KEPT if role else LOST, _AS_ITS[role] if role else Sentence("goes with its interface")))
    return losses


def to_stack(slots: Slots, name: str, source: str, losses: list[Loss]) -> tuple[Stack, dict[str, int]]:
    """The stack of slots, and which element each slot is; what the schema does not allow is clamped and said."""
    rows, n, owners = [], 1.0, {BASE: -1}
    if slots.coat:
        n = ior_in_range(slots.coat.eta, "coat IOR", losses)
        owners[COAT] = len(rows)
        row = {
            "kind": "dielectric",
            "name": "Coat",
            "ior": n,
            "roughness": slots.coat.roughness,
            "tint": list(slots.coat_tint),
            "thickness": _ONE_WAY,
            **slots.coat.features,
        }
        rows.append(row | ({"coverage": slots.coat_weight} if slots.coat_weight < 1.0 else {}))
    if slots.gloss:
        n = ior_in_range(n * slots.gloss.eta, "IOR", losses)
        owners[GLOSS] = len(rows)
        rows.append({"kind": "dielectric", "name": "Gloss", "ior": n, "roughness": slots.gloss.roughness, **slots.gloss.features})
    if slots.body:
        if not slots.gloss:
            rows.append({"kind": "dielectric", "name": "Subsurface", "ior": n, "roughness": 0.0})
        rows[-1] |= {"scatter_color": list(slots.color), **slots.body.values}
    if slots.is_metal:
        reflectance, edge = artist_color(*(n * part for part in metal_index(slots.color, slots.edge)))
        base = {
            "kind": "conductor",
            "reflectance": list(np.minimum(reflectance, MOST_REFLECTANCE)),
            "edge_color": list(edge),
            "roughness": slots.roughness,
            **slots.features,
        }
    elif slots.sigma_deg > 0.0:
        base = {"kind": "oren_nayar", "color": list(slots.color), "sigma_deg": slots.sigma_deg}
    else:
        base = {"kind": "lambert", "color": list(slots.color)}
    data = {"name": name, "source": source, "layers": rows, "base": base}
    return Stack.from_dict(_plain(data), name or "conversion"), owners


def _plain(value):
    """The same with Python's own floats."""
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    return (
        [float(v) for v in value]
        if isinstance(value, list) and value and not isinstance(value[0], dict)
        else ([_plain(v) for v in value] if isinstance(value, list) else float(value) if isinstance(value, np.floating) else value)
    )


def ior_in_range(ior: float, parameter: str, losses: list[Loss]) -> float:
    """An index as a layer may have it; what is limited is said."""
    limits = DIELECTRIC.parameter("ior")
    clamped = float(np.clip(ior, limits.minimum, limits.maximum))
    if abs(clamped - ior) > 1e-9:
        losses.append(
            Loss(
                parameter,
                ior,
                APPROXIMATED,
                Sentence("a layer's index is {least} to {most}; it is {kept}", least=shown(limits.minimum), most=shown(limits.maximum), kept=shown(clamped)),
            )
        )
    return clamped
