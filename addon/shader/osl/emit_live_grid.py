# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lobe set that was baked over live parameters writes: tables over the view and those, which come in through sockets."""

import numpy as np

from ....reference_py.lobes.live_grid import MIN_ALPHA, MIN_ENERGY, LiveLobe, LiveLobes
from ....reference_py.lobes.lobe import DielectricCurve
from ....reference_py.lobes.view_table import KNOTS
from ....reference_py.material.schema import SCHEMA
from .block import Block, Closure, numbers
from .emit_tables import clamped_color
from .frame import FRAME, FRAME_FUNCTIONS, table_view

NOTE = "Tables hold the values that the stack had, but for those with a socket."


def grid_block(lobe_set: LiveLobes, owners: list[str], prefix: str = "") -> Block:
    """The block of a lobe set of a stack whose shader parameters begin with `owners`; what it declares ends with `prefix`."""
    writer = _Writer(lobe_set, owners, prefix)
    return Block(
        functions=(*FRAME_FUNCTIONS, "grid.h"),
        arrays=tuple(writer.arrays),
        common=(*table_view(), *FRAME),
        body=tuple(writer.statements),
        closures=tuple(writer.closures),
    )


class _Writer:
    def __init__(self, lobe_set: LiveLobes, owners: list[str], prefix: str):
        self.arrays: list[str] = []
        self.statements: list[str] = []
        self.closures: list[Closure] = []
        self._prefix = prefix
        sizes = [len(axis.knots) for axis in lobe_set.axes]
        steps = [KNOTS * int(np.prod(sizes[i + 1 :])) for i in range(len(sizes))]
        for i, axis in enumerate(lobe_set.axes):
            place, is_base = axis.parameter, axis.parameter.layer is None
            kinds = SCHEMA.bases if is_base else SCHEMA.layers
            value = (owners[-1] if is_base else owners[place.layer]) + kinds[place.element(lobe_set.stack).kind].parameter(place.name).osl_name
            self._array("float", f"Knots{i}", [f"{knot:.9g}" for knot in axis.knots])
            knots, cell, along = (self._name(word) for word in (f"Knots{i}", f"knot{i}", f"along{i}"))
            self._say(f"int {cell};", f"float {along};", f"knot_place({knots}, {len(axis.knots)}, {value}, {cell}, {along});")
        at = " + ".join(f"{self._name(f'knot{i}')} * {step}" for i, step in enumerate(steps))
        self._say(f"int {self._name('at')} = {at} + cell;")
        alongs = [self._name(f"along{i}") for i in range(len(sizes))]
        place = [self._name("at"), *map(str, steps)]
        self._free = ", ".join([*place, *alongs, "between"])
        self._bounded = ", ".join([*place, *(f"max({along}, 0.0)" for along in alongs), "between"])
        self._lobes(lobe_set, clamped_color(owners[-1]))

    def _name(self, word: str) -> str:
        return f"{word}_{self._prefix}" if self._prefix else word

    def _say(self, *lines: str) -> None:
        self.statements += lines

    def _array(self, kind: str, name: str, entries: list[str]) -> None:
        self.arrays.append(f"{kind} {self._name(name)}[{len(entries)}] = {{{', '.join(entries)}}}")

    def _value(self, name: str, values: np.ndarray, extends: bool = False) -> str:
        """An expression for values (..., KNOTS, 1 or 3) at the live parameters and the view."""
        rows = values.reshape(-1, values.shape[-1])
        color = rows.shape[1] == 3
        if np.all(rows == rows[0]):
            return f"color({numbers(rows[0])})" if color else f"{rows[0, 0]:.6g}"
        entries = [f"color({', '.join(map(_entry, row))})" if color else _entry(row[0]) for row in rows]
        self._array("color" if color else "float", name, entries)
        return f"grid({self._name(name)}, {self._free if extends else self._bounded})"

    def _lobes(self, lobe_set: LiveLobes, base_color: str) -> None:
        shared = []
        for i, lobe in enumerate(lobe_set.grid):
            if lobe.unit is not None:
                shared.append(self._name(f"energy{i}"))
                self._say(f"color {shared[-1]} = {self._value(f'Energy{i}', lobe.energy)};")
        total = self._value("LogSum", lobe_set.log_sum)
        self._say(f"color {self._name('scale')} = exp({total}) / max({' + '.join(shared)}, color({MIN_ENERGY:g}));")
        for i, lobe in enumerate(lobe_set.grid):
            if lobe.unit is None:
                weight = self._value(f"Weight{i}", lobe.energy)
            else:
                weight = f"{self._name(f'energy{i}')} * {self._name('scale')} / {self._value(f'Unit{i}', lobe.unit)}"
            if lobe.shape is None and lobe_set.base is not None:
                through, back = self._value("LogThrough", lobe_set.base.log_through), self._value("LogBack", lobe_set.base.log_back)
                weight = f"({weight} + exp({through}) * {base_color} / (color(1.0) - exp({back}) * {base_color}))"
            self.closures.append(Closure(weight, *self._closure(i, lobe)))

    def _closure(self, i: int, lobe: LiveLobe) -> tuple[str, bool, tuple[str, ...]]:
        """The closure, that it is local, and its shape."""
        if lobe.shape is None:
            return "diffuse(N)", True, ()
        if lobe.is_specular:
            return f'microfacet("{lobe.distribution}", N, tangent, 0.0, 0.0, 1.0, 0)', True, ("0.0",) * 3
        roots = [self._value(f"Root{axis}{i}", lobe.shape[..., column : column + 1], extends=True) for column, axis in enumerate("XY")]
        alphas = [self._name(f"alpha_{axis}{i}") for axis in "xy"]
        for alpha, root in zip(alphas, roots):
            self._say(f"float {alpha} = max({root}, 0.0);", f"{alpha} = clamp({alpha} * {alpha}, {MIN_ALPHA:g}, 1.0);")
        if isinstance(lobe.fresnel, DielectricCurve):
            curve = f'{lobe.fresnel.eta:.9g}, "{lobe.distribution}"'
            return f"interface_bsdf(N, tangent, {alphas[0]}, break_isotropy({alphas[0]}), {curve})", True, ()
        slope = self._value(f"Slope{i}", lobe.shape[..., 2:])
        return f'microfacet("{lobe.distribution}", normalize(bent_normal + {slope} * side), along, {", ".join(alphas)}, 1.0, 0)', True, (*alphas, slope)


def _entry(value: float) -> str:
    """A number of a table; there are thousands, so no zero stands before its point."""
    text = f"{value:.5g}"
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
