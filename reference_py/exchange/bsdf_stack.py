# SPDX-License-Identifier: GPL-3.0-or-later
"""A tree of MaterialX's BSDFs as rows of a stack, from the top, and a base.

Every BSDF of a file is in air, so an index is that to the medium above. A factor below an interface is the round trip of
its medium. A mix of a coated and the same uncoated is a coat's coverage, one with a bare opaque surface an opaque layer.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import Sentence
from ..material.schema import CONDUCTOR as METAL
from ..material.schema import DIELECTRIC as CLEAR
from ..material.schema import LAMBERT, SCHEMA, THIN_FILM
from ..material.schema import OREN_NAYAR as ROUGH_BASE
from ..models.baselines.parts import dielectric_f0
from ..optics.colour import artist_color, artist_index
from .bsdf_albedo import light_of, sigma_deg
from .bsdf_tree import BURLEY, CONDUCTOR, DIELECTRIC, OREN_NAYAR, SCHLICK, SUBSURFACE, Added, Layered, Leaf, Mixed, Scaled, Tree
from .matching import mean
from .report import APPROXIMATED, LOST, Loss, film_limited
from .slots import MOST_REFLECTANCE, edge_of_f82, ior_in_range

# Above this F0 a curve of Schlick's is a metal's.
_METAL_F0 = 0.25
# Blender's anisotropy makes the alphas' ratio 1 - .9 anisotropy.
_MOST_RATIO = 0.9
_DIFFUSE = (OREN_NAYAR, BURLEY, SUBSURFACE)
# Half of the crossing that a tint is meant for, each way.
_ONE_WAY = 0.5
# Values that differ by less are the same surface's.
_ALIKE = 1e-4


@dataclass
class Rows:
    """`layers` from the top and `base`, as a stack's dictionaries; `media` (tint, thickness) lie above all of them.

    `sources` name the leaf that an element came from, by its index, -1 the base; `n` is the index above the base.
    """

    layers: list[dict]
    base: dict
    media: list[tuple[tuple, float]] = field(default_factory=list)
    sources: dict[int, Leaf] = field(default_factory=dict)
    n: float = 1.0

    def under(self, tops: list[dict], leaves: list[Leaf]) -> "Rows":
        """Below other layers, the lowest of which has the media."""
        if tops:
            tops = [*tops[:-1], _with_media(tops[-1], self.media)]
        moved = {i + len(tops) * (i >= 0): leaf for i, leaf in self.sources.items()}
        return Rows([*tops, *self.layers], self.base, [] if tops else self.media, moved | dict(enumerate(leaves)), self.n)


def _with_media(row: dict, media: list[tuple[tuple, float]]) -> dict:
    """A layer with media below its interface: one is itself, more are their product's."""
    if not media:
        return row
    given = [(row["tint"], row["thickness"]), *media] if "tint" in row else media
    if len(given) == 1:
        return row | {"tint": given[0][0], "thickness": given[0][1]}
    return row | {"tint": tuple(np.prod([np.power(tint, thickness / _ONE_WAY) for tint, thickness in given], axis=0)), "thickness": _ONE_WAY}


class Builder:
    """Puts a tree into rows; what that costs is in `losses`."""

    def __init__(self) -> None:
        self.losses: list[Loss] = []
        self.covers: dict[str, Leaf] = {}
        """What lies where an image says, by the name of the mix."""

    def _say(self, name: str, value, fate: str, how: Sentence) -> None:
        self.losses.append(Loss(name, value, fate, how))

    def rows(self, tree: Tree, n: float = 1.0) -> Rows:
        """Of a tree below a medium of index `n`."""
        if isinstance(tree, Leaf):
            return self._single(tree, n)
        if isinstance(tree, Scaled):
            inner = self.rows(tree.bsdf, n)
            color, thickness = tree.medium or (tree.color, 2.0 * _ONE_WAY)
            return replace(inner, media=[(color, 0.5 * thickness), *inner.media])
        if isinstance(tree, Layered):
            return self._layered(tree, n)
        return self._mixed(tree, n) if isinstance(tree, Mixed) else self._added(tree, n)

    def _layered(self, tree: Layered, n: float) -> Rows:
        if (hiding := _lowest(tree.top)) is not None and _is_opaque(hiding):
            self._say(f"{hiding.name} {hiding.kind}", "", LOST, Sentence("what is below it: it hides that in a stack"))
            return self.rows(tree.top, n)
        tops, sources = self._interfaces(tree.top, n)
        return self.rows(tree.base, tops[-1]["ior"] if tops else n).under(tops, sources)

    def _interfaces(self, tree: Tree, n: float) -> tuple[list[dict], list[Leaf]]:
        """Clear layers of what lies on top of something."""
        if isinstance(tree, Leaf):
            row = self._interface(tree, n)
            return ([row], [tree]) if row else ([], [])
        if isinstance(tree, Layered):
            above, leaves = self._interfaces(tree.top, n)
            below, more = self._interfaces(tree.base, above[-1]["ior"] if above else n)
            return [*above, *below], [*leaves, *more]
        if isinstance(tree, Scaled):
            if isinstance(tree.bsdf, Leaf):  # only the highlight is scaled, as a tint does
                tint = tuple(np.multiply(tree.bsdf.values.get("tint", (1.0,) * 3), tree.color))
                return self._interfaces(replace(tree.bsdf, values={**tree.bsdf.values, "tint": tint}), n)
            self._say("multiply", tree.color, LOST, Sentence("a factor of several layers together, on top of others"))
            return self._interfaces(tree.bsdf, n)
        stays = self._stronger(tree, Sentence("on top of others"))
        return self._interfaces(stays, n)

    def _interface(self, leaf: Leaf, n: float) -> dict | None:
        v = leaf.values
        if v["weight"] == 0.0:
            return None
        if leaf.kind not in (DIELECTRIC, SCHLICK):
            self._say(f"{leaf.name} {leaf.kind}", "", LOST, Sentence("a stack has no such layer; that is {share} of white light", share=self._share(leaf)))
            return None
        if leaf.kind == SCHLICK:
            f0, tint = float(np.mean(v["color0"])), v["color0"]
        else:
            f0, tint = dielectric_f0(v["ior"]) * float(np.mean(v["tint"])), v["tint"]
        if np.ptp(tint) > 1e-6:
            self._say(f"{leaf.name} {'color0' if leaf.kind == SCHLICK else 'tint'}", tint, LOST, Sentence("a dielectric's highlight has no color"))
        root = f0**0.5
        plain = leaf.kind == DIELECTRIC and min(tint) == 1.0
        eta = v["ior"] if plain else (1.0 + root) / (1.0 - root)
        if not plain:
            self._say(
                f"{leaf.name} {'color0' if leaf.kind == SCHLICK else 'tint'}",
                tint,
                APPROXIMATED,
                Sentence("as an index of {eta:.4g} to what is above", eta=eta),
            )
        row = {"kind": CLEAR.name, "name": leaf.name, "ior": ior_in_range(n * eta, f"{leaf.name} ior", self.losses), **self._facets(leaf)}
        return row | ({"coverage": v["weight"]} if v["weight"] < 1.0 else {})

    def _facets(self, leaf: Leaf) -> dict:
        """Roughness, anisotropy and film in a stack's terms."""
        along, across = leaf.values["roughness"]
        turn = leaf.turn
        if across > along:
            along, across, turn = across, along, (turn + 0.25) % 1.0
        row = {"roughness": float((along * across) ** 0.25), "distribution": leaf.distribution}
        if along > 0.0 and across < along * (1.0 - 1e-6):
            given = 1.0 - across / along
            kept = min(given, _MOST_RATIO)
            if kept < given:
                self._say(
                    f"{leaf.name} roughness",
                    leaf.values["roughness"],
                    APPROXIMATED,
                    Sentence("as an anisotropy of 1, a ratio of {ratio:.2g}", ratio=1.0 - _MOST_RATIO),
                )
            row |= {"anisotropy": kept / _MOST_RATIO, "rotation": turn}
        if leaf.values["thinfilm_thickness"] > 0.0:
            for parameter, value in zip(THIN_FILM.parameters, (leaf.values["thinfilm_thickness"], leaf.values["thinfilm_ior"])):
                row[parameter.name] = float(np.clip(value, parameter.minimum, parameter.maximum))
                if row[parameter.name] != value:
                    self._say(f"{leaf.name} {parameter.name}", value, APPROXIMATED, film_limited(parameter, row[parameter.name]))
        return row

    def _single(self, leaf: Leaf, n: float) -> Rows:
        """A leaf with nothing below it."""
        v, black = leaf.values, {"kind": LAMBERT.name, "color": (0.0, 0.0, 0.0)}
        if leaf.kind in _DIFFUSE:
            return Rows([], self._diffuse(leaf), sources={-1: leaf}, n=n)
        if _is_opaque(leaf):
            return Rows([], self._metal(leaf, n), sources={-1: leaf}, n=n)
        row = self._interface(leaf, n)
        if row is None:
            return Rows([], black, n=n)
        if leaf.mode != "R" and leaf.kind == DIELECTRIC:
            self._say(f"{leaf.name} scatter_mode", leaf.mode, LOST, Sentence("light goes through it, and a stack is opaque: it is black below"))
        return Rows([row], black, sources={0: leaf} | ({} if v["weight"] else {-1: leaf}), n=row["ior"])

    def _diffuse(self, leaf: Leaf) -> dict:
        color = tuple(leaf.values["weight"] * c for c in leaf.values["color"])
        if leaf.kind == SUBSURFACE:
            self._say(
                f"{leaf.name} color",
                leaf.values["color"],
                APPROXIMATED,
                Sentence("light that spreads below the surface counts as a diffuse base of this color"),
            )
        if leaf.kind == BURLEY and leaf.values["roughness"] > 0.0:
            self._say(f"{leaf.name} roughness", leaf.values["roughness"], APPROXIMATED, Sentence("as a Lambert base of the same mean albedo"))
        sigma = sigma_deg(leaf) if leaf.kind == OREN_NAYAR else 0.0
        return {"kind": ROUGH_BASE.name, "color": color, "sigma_deg": sigma} if sigma else {"kind": LAMBERT.name, "color": color}

    def _metal(self, leaf: Leaf, n: float) -> dict:
        color, edge = relative_colors(leaf)
        if leaf.kind == SCHLICK and (min(leaf.values["color90"]) < 1.0 or leaf.values["exponent"] != 5.0):
            self._say(f"{leaf.name} color90", leaf.values["color90"], APPROXIMATED, Sentence("as the nearest metal, white at the horizon"))
        if leaf.values["weight"] < 1.0:
            self._say(f"{leaf.name} weight", leaf.values["weight"], APPROXIMATED, Sentence("in the metal's color"))
        return metal_row(color, edge, n) | self._facets(leaf)

    def _mixed(self, tree: Mixed, n: float) -> Rows:
        merged = _merged(tree.first, tree.second, tree.share) if tree.image is None else None
        if merged is not None:
            return self.rows(merged, n)
        ways = [(tree.second, tree.first, tree.share)]
        if tree.image is None:  # no node says one less an image
            ways.append((tree.first, tree.second, 1.0 - tree.share))
        for put in (self._covering, self._spotted):
            for above, below, share in ways:
                begun = len(self.losses)
                if (found := put(above, below, share, n)) is not None:
                    if tree.image is not None:
                        self.covers[tree.name] = found.sources[0]
                    return found
                del self.losses[begun:]
        return self.rows(self._stronger(tree, Sentence("a stack mixes coated and uncoated, or with one bare opaque surface")), n)

    def _covering(self, above: Tree, below: Tree, share: float, n: float) -> Rows | None:
        """What is below, with one more layer on a share of it; None where `above` is not that."""
        rest = self.rows(below, n)
        whole = self.rows(above, n)
        if not whole.layers or whole.media or rest.media or "coverage" in whole.layers[0] or SCHEMA.is_opaque(whole.layers[0]["kind"]):
            return None
        # where both are over the same node, a metal there is another one below a medium
        inner = above.base.bsdf if isinstance(above, Layered) and isinstance(above.base, Scaled) else above.base if isinstance(above, Layered) else None
        if inner != below and not _alike([*whole.layers[1:], whole.base], [*rest.layers, rest.base]):
            return None
        return replace(whole, layers=[whole.layers[0] | {"coverage": share}, *whole.layers[1:]])

    def _spotted(self, above: Tree, below: Tree, share: float, n: float) -> Rows | None:
        """What is below, with an opaque layer on a share of it; None where `above` is none."""
        if not isinstance(above, Leaf) or not (_is_opaque(above) or above.kind in _DIFFUSE):
            return None
        rest = self.rows(below, n)
        row = self._metal(above, n) if _is_opaque(above) else self._diffuse(above)
        return rest.under([row | {"coverage": share}], [above]) if not rest.media else None

    def _added(self, tree: Added, n: float) -> Rows:
        merged = _merged(tree.first, tree.second, None)
        if merged is not None:
            return self.rows(merged, n)
        for top, base in ((tree.first, tree.second), (tree.second, tree.first)):
            if isinstance(top, Leaf) and top.kind in (DIELECTRIC, SCHLICK) and top.mode == "R" and not _is_opaque(top):
                self._say("add", top.name, APPROXIMATED, Sentence("as a layer on top, which takes from what is below what it reflects"))
                return self._layered(Layered(top, base), n)
        return self.rows(self._stronger(tree, Sentence("a stack has no such sum")), n)

    def _stronger(self, tree: Mixed | Added, why: Sentence) -> Tree:
        """Of two the one that sends back more light; the other one is lost."""
        share = tree.share if isinstance(tree, Mixed) else 0.5
        light = [s * float(np.sum(mean(light_of(t).back))) for s, t in ((1.0 - share, tree.first), (share, tree.second))]
        name = tree.name if isinstance(tree, Mixed) else "add"
        lost = 100.0 * min(light) / max(sum(light), 1e-9)
        self._say(
            name,
            f"{share:.4g}" if isinstance(tree, Mixed) else "",
            LOST,
            Sentence("{why}: the weaker of two, {lost:.0f} % of their light, is in the base color alone", why=why, lost=lost),
        )
        return tree.second if light[1] > light[0] else tree.first

    @staticmethod
    def _share(leaf: Leaf) -> str:
        light = light_of(leaf)
        return f"{100.0 * float(np.mean(mean(light.back + sum(light.lost.values())))):.0f} %"


def relative_colors(leaf: Leaf) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance and edge color (3,) of an opaque leaf, against what is above it."""
    v = leaf.values
    if leaf.kind == CONDUCTOR:
        color, edge = artist_color(np.maximum(v["ior"], 1e-3), np.array(v["extinction"]))
    else:
        color = np.array(v["color0"])
        edge = edge_of_f82(color, np.array(v["color82"]))
    return np.minimum(v["weight"] * color, MOST_REFLECTANCE), edge


def metal_row(color, edge, n: float) -> dict:
    """A conductor's element of colors against a medium of index n."""
    eta, k = (n * part for part in artist_index(np.clip(color, 0.0, MOST_REFLECTANCE), np.asarray(edge)))
    reflectance, absolute = artist_color(eta, k)
    return {"kind": METAL.name, "reflectance": tuple(np.minimum(reflectance, MOST_REFLECTANCE)), "edge_color": tuple(absolute)}


def _is_opaque(leaf: Leaf) -> bool:
    return leaf.kind == CONDUCTOR or leaf.kind == SCHLICK and max(leaf.values["color0"]) > _METAL_F0


def _lowest(tree: Tree) -> Leaf | None:
    """The lowest leaf of layers; None where that is a mix or a sum."""
    if isinstance(tree, Layered):
        return _lowest(tree.base)
    return tree if isinstance(tree, Leaf) else None


def _merged(first: Tree, second: Tree, share: float | None) -> Leaf | None:
    """One leaf of two diffuse ones, mixed or, without a share, added; None of others."""
    if not (isinstance(first, Leaf) and isinstance(second, Leaf) and first.kind in _DIFFUSE and second.kind in _DIFFUSE) or first.images or second.images:
        return None
    a, b = (1.0, 1.0) if share is None else (1.0 - share, share)
    colors = [np.multiply(f * leaf.values["weight"], leaf.values["color"]) for f, leaf in ((a, first), (b, second))]
    kept = first if np.sum(colors[0]) >= np.sum(colors[1]) else second
    return replace(kept, values={**kept.values, "weight": 1.0, "color": tuple(np.clip(colors[0] + colors[1], 0.0, 1.0))})


def _alike(first: list[dict], second: list[dict]) -> bool:
    """Whether two columns of elements are the same surfaces."""
    if len(first) != len(second):
        return False
    for a, b in zip(first, second):
        if a.get("kind") != b.get("kind") or a.get("distribution") != b.get("distribution"):
            return False
        numbers = [k for k in {**a, **b} if k not in ("kind", "name", "distribution")]
        if any(k not in a or k not in b or not np.allclose(a[k], b[k], atol=_ALIKE) for k in numbers):
            return False
    return True


def said_once(losses: list[Loss]) -> list[Loss]:
    """Without repetition, as a leaf may be linked twice."""
    return list({(loss.parameter, loss.how): loss for loss in losses}.values())
