# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lobe set that was baked over live parameters writes: tables over the view and those, which come in through sockets."""

import numpy as np

from ....reference_py.errors import LaminaError
from ....reference_py.lobes.axes import (
    BRIGHT_OFFSET,
    HALF_DEPTH,
    LEAST_COUNT,
    REFLECTANCE_OFFSET,
    Axis,
    AzimuthAxis,
    CoatedReflectanceAxis,
    DepthAxis,
    EdgeAxis,
    IndexAxis,
    NumberAxis,
    ReflectanceAxis,
    ScatterColorAxis,
    ThicknessAxis,
    has_waves,
    top_index,
)
from ....reference_py.lobes.diffuse_ramp import RAMP_COSINES
from ....reference_py.lobes.live_grid import COEFFICIENT_DIGITS, MIN_ALPHA, LiveLobe, LiveLobes, LiveRamp, LogEnergy
from ....reference_py.lobes.lobe import ConductorCurve, DielectricCurve
from ....reference_py.lobes.view_table import KNOTS
from ....reference_py.material.place import Place
from ....reference_py.optics.scattering import FIT
from ..inputs import base_color_input, place_input
from .block import PRIMARY_ARGUMENTS, Block, Closure, numbers
from .view_frame import FRAME_FUNCTIONS, Frame

# Roots of alpha that differ by less are one, but for how they were rounded.
_SAME = 1e-4

NOTE = "Tables hold the values that the stack had, but for those with a socket."


def grid_block(lobe_set: LiveLobes, owners: list[str], prefix: str = "") -> Block:
    """The block of a lobe set of a stack whose shader parameters begin with `owners`; what it declares ends with `prefix`."""
    writer = _Writer(lobe_set, owners, prefix)
    return Block(
        functions=(*FRAME_FUNCTIONS, "grid.h", *writer.functions, *(name for frame in writer.frames for name in frame.functions)),
        arrays=tuple(writer.arrays),
        common=tuple(line for frame in dict.fromkeys(writer.frames) for line in (*frame.table_view, *frame.glossy)),
        body=tuple(writer.statements),
        closures=tuple(writer.closures),
    )


class _Writer:
    def __init__(self, lobe_set: LiveLobes, owners: list[str], prefix: str):
        self.arrays: list[str] = []
        self.statements: list[str] = []
        self.functions: list[str] = []
        self.closures: list[Closure] = []
        self._prefix, self._axes, self._index, self._coefficients = prefix, lobe_set.axes, "", lobe_set.coefficients
        self._stack, self._owners = lobe_set.stack, owners
        self.frames = [Frame.of(lobe.normal, owners) for lobe in lobe_set.grid]
        self._about = Frame()
        """Whose normal the view is seen from in what is being written."""
        self._said: set[str] = set()
        self._grey_terms: dict[tuple[str, int], str] = {}
        """Of energies that are read together: by energy and axis."""
        self._brushed = self._name("brushed")
        if lobe_set.brushing is not None:
            self.functions.append("rotate_tangent.h")
            rotation = lobe_set.rotation
            turns = f"{lobe_set.brushing / (2.0 * np.pi):.9g}" if rotation is None else place_input(lobe_set.stack, rotation, owners).osl_name
            self._say(f"vector {self._brushed} = rotate_tangent(Tangent, N, {turns});")
        self._coordinates = [self._coordinate(i, axis) for i, axis in enumerate(lobe_set.axes)]
        self._lobes(lobe_set, base_color_input(owners[-1]).osl_name)

    def _name(self, word: str) -> str:
        return f"{word}_{self._prefix}" if self._prefix else word

    def _say(self, *lines: str) -> None:
        self.statements += lines

    def _array(self, kind: str, name: str, entries: list[str]) -> str:
        self.arrays.append(f"{kind} {self._name(name)}[{len(entries)}] = {{{','.join(entries)}}}")
        return self._name(name)

    def _given(self, place: Place) -> str:
        """An expression for a value: its socket where it is live, else a constant."""
        if any(place in axis.live for axis in self._axes):
            return place_input(self._stack, place, self._owners).osl_name
        constant = place.value(self._stack)
        return f"{constant:.9g}" if np.ndim(constant) == 0 else f"color({numbers(constant)})"

    def _coordinate(self, i: int, axis: Axis) -> tuple[str, str]:
        """Expressions for an axis' coordinate, and for the one that shapes are read at."""
        if isinstance(axis, AzimuthAxis):
            name = self._name("turned")
            self._say(f"float {name} = min(abs(dot(side, {self._brushed})) / max(length(side), 1e-6), 1.0);")
            return (name,) * 2
        first = self._given(axis.live[0])
        if isinstance(axis, NumberAxis):
            return (first,) * 2
        name = self._name(f"coordinate{i}")
        if isinstance(axis, IndexAxis):
            self._say(f"float {name} = ({first} - 1.0) / ({first} + 1.0);")
            if axis is top_index(self._axes):
                self._index = first
            return (name,) * 2
        if isinstance(axis, ThicknessAxis):
            self._say(f"float {name} = max({first}, 0.0);", f"{name} /= {name} + {axis.half(self._stack):.9g};")
            return (name,) * 2
        if isinstance(axis, DepthAxis):
            self.functions.append("medium.h")
            counts = self._name(f"counts{i}")
            tint, thickness = (self._given(Place(axis.layer, part)) for part in ("tint", "thickness"))
            self._say(f"color {name} = optical_depth({tint}, {thickness});", f"{name} /= {name} + {HALF_DEPTH:g};")
            self._say(f"color {counts} = (1.0 - {name}) * (1.0 - {name}) + {LEAST_COUNT:g};")
            return name, f"mean_of({counts} * {name}) / mean_of({counts})"
        if isinstance(axis, ReflectanceAxis):
            self._say(f"color {name} = clamp({first}, color(0.0), color(1.0));")
            self._say(f"{name} = log(({name} + {REFLECTANCE_OFFSET:g}) / ({1.0 + BRIGHT_OFFSET:g} - {name}));")
            if isinstance(axis, CoatedReflectanceAxis):
                counts = self._name(f"counts{i}")
                self._say(f"color {counts} = exp(0.5 * {name});")
                return name, f"mean_of({counts} * {name}) / mean_of({counts})"
        elif isinstance(axis, EdgeAxis):
            self._say(f"color {name} = 1.0 - sqrt(1.0 - clamp({first}, color(0.0), color(1.0)));")
        elif isinstance(axis, ScatterColorAxis):
            a, b = FIT
            bounded = f"clamp({first}, color(0.0), color(1.0))"
            self._say(
                f"color {name} = {1.0 + a:g} + {b:g} * {bounded};",
                f"{name} = 1.0 - ({name} - sqrt({name} * {name} - {4.0 * a:g} * (1.0 - {bounded}))) * {0.5 / a:.9g};",
            )
        else:
            raise LaminaError(f"no shader follows the axis {type(axis).__name__}")
        return name, f"mean_of({name})"

    def _once(self, name: str, *lines: str) -> str:
        """A name that these statements declare."""
        if name not in self._said:
            self._said.add(name)
            self._say(*lines)
        return name

    def _knots(self, i: int, which: str, is_shared: bool) -> tuple[str, str]:
        """Names of the knot below the coordinate of an axis and of the way to the next; in three channels unless `is_shared`."""
        scale, each, value = getattr(self._axes[i], which), "" if is_shared else "[3]", self._coordinates[i][is_shared]
        tag = f"{which}{i}{'' if is_shared else 's'}"
        cell, along = self._name(f"cell_{tag}"), self._name(f"along_{tag}")
        if not is_shared and not self._axes[i].is_color:  # one place for all channels is found once
            lines = (f"{kind} {name}[3] = {{{', '.join([one] * 3)}}};" for kind, name, one in zip(("int", "float"), (cell, along), self._knots(i, which, True)))
            self._once(cell, *lines)
            return cell, along
        size = scale.high - scale.low
        if scale.bend == 1.0:
            place = f"({value} - {scale.low:.9g}) * {(scale.count - 1) / size:.9g}"
        else:  # those of energies are one but for their counts
            way = self._name(f"way_{'knots' if which == 'knots' else ''}{i}{'' if is_shared else 's'}")
            self._once(way, f"{'float' if is_shared else 'color'} {way} = grid_way({value}, {scale.low:.9g}, {size:.9g}, {scale.bend:.9g});")
            place = f"{way} * {scale.count - 1}"
        self._once(cell, f"int {cell}{each};", f"float {along}{each};", f"grid_place({place}, {scale.count}, {cell}, {along});")
        return cell, along

    def _place(self, which: str, numbers: tuple[int, ...], is_shared: bool) -> str:
        """Arguments of `grid` for tables over these axes."""
        sizes = [getattr(self._axes[i], which).count for i in numbers]
        steps = [KNOTS * int(np.prod(sizes[k + 1 :])) for k in range(len(sizes))]
        parts = [self._knots(i, which, is_shared) for i in numbers]
        s = self._about.suffix
        tag = f"{which}{''.join(map(str, numbers))}{'' if is_shared else 's'}{s}"
        at = self._name(f"at_{tag}")
        if is_shared:
            self._once(at, f"int {at} = {' + '.join(f'{cell} * {step}' for (cell, _), step in zip(parts, steps))} + cell{s};")
        else:
            places = [f"{' + '.join(f'{cell}[{c}] * {step}' for (cell, _), step in zip(parts, steps))} + cell{s}" for c in range(3)]
            self._once(at, f"int {at}[3] = {{{', '.join(places)}}};")
        return ", ".join([at, *map(str, steps), *(along for _, along in parts), f"between{s}"])

    def _value(self, name: str, values: np.ndarray, which: str = "knots", axes: tuple[int, ...] | None = None, are_channels: bool = True) -> str:
        """An expression for values (..., KNOTS, 1 or 3) over some axes, all unless told, at the live parameters and the view.

        Three that are no channels are read at the place of the mean.
        """
        axes = tuple(range(len(self._axes))) if axes is None else axes
        changing = [number for number in range(len(axes)) if np.any(values != values.take([0], number))]
        values = values[tuple(slice(None) if number in changing else 0 for number in range(len(axes)))]
        axes = tuple(axes[number] for number in changing)
        rows = values.reshape(-1, values.shape[-1])
        is_shared = rows.shape[1] == 1 or not are_channels or not any(self._axes[i].is_color for i in axes)
        if is_shared and are_channels and np.all(rows == rows[:, :1]):
            rows = rows[:, :1]
        color = rows.shape[1] == 3
        if np.all(rows == rows[0]):
            return f"color({numbers(rows[0])})" if color else f"{rows[0, 0]:.6g}"
        is_whole = color and is_shared
        entries = [f"color({','.join(map(_entry, row))})" for row in rows] if is_whole else [_entry(value) for value in rows.ravel()]
        table = self._array("color" if is_whole else "float", name, entries)
        if not axes:
            s = self._about.suffix
            return f"mix({table}[cell{s}], {table}[cell{s} + 1], between{s})"
        return f"grid({table}, {self._place(which, axes, is_shared)})"

    def _energy(self, name: str, log: LogEnergy) -> str:
        terms = [self._grey_terms.get((name, i)) or self._value(f"{name}{i}", table, "fine", (i,)) for i, table in enumerate(log.along)]
        if log.modes is not None and np.any(log.modes):
            terms.append(self._modes(name, log.modes))
        total = " + ".join(terms)
        return f"grid_energy({total})" if log.is_log else f"max(({total}) * color(1.0), color(0.0))"

    def _read_at_once(self, energies: dict[str, LogEnergy]) -> None:
        """Read what three energies have along an axis as one color, where it and the place are the same in all channels."""
        for i, axis in enumerate(self._axes):
            tables = [log.along[i] for log in energies.values()]
            if not axis.is_color and all(np.all(table == table[..., :1]) for table in tables):
                term = self._name(f"along{i}")
                self._say(f"color {term} = {self._value(f'LogAlong{i}', np.concatenate([t[..., :1] for t in tables], -1), 'fine', (i,), are_channels=False)};")
                self._grey_terms |= {(name, i): f"{term}[{c}]" for c, name in enumerate(energies)}

    def _modes(self, name: str, modes: np.ndarray) -> str:
        """An expression for the modes of an energy (n, KNOTS, 3), each times its coefficient."""
        count, s = len(modes) // 3, self._about.suffix
        by_channel = np.moveaxis(modes.reshape(count, 3, KNOTS, 3), (3, 2), (0, 2))
        if is_one := bool(np.all(by_channel == by_channel[:1])):
            by_channel = by_channel[:1]
        table = self._array("color", f"{name}Modes", [f"color({','.join(map(_entry, row))})" for row in by_channel.reshape(-1, 3)])
        coefficients, step = self._coefficients_now()
        return f"grid_modes({table}, {coefficients}, {count}, {0 if is_one else count * KNOTS}, {step}, cell{s}, between{s})"

    def _coefficients_now(self) -> tuple[str, int]:
        """The array of coefficients at the live parameters, three in a color, and the step from one channel's to the next's, 0 where they have the same."""
        sizes = [axis.cross.count for axis in self._axes]
        count, nodes, is_shared = self._coefficients.shape[-1] // 3, int(np.prod(sizes)), not any(axis.is_color for axis in self._axes)
        name = self._name("coefficients")
        if name in self._said:
            return name, 0 if is_shared else count
        # whole numbers are the shortest text
        unit = 10.0**-COEFFICIENT_DIGITS
        rows = np.rint(np.moveaxis(self._coefficients.reshape(nodes, count, 3), 1, 0).reshape(-1, 3) / unit) + 0.0
        table = self._array("color", "Coefficients", [f"color({','.join(map(_entry, row))})" for row in rows])
        for i in range(len(sizes)):
            self._knots(i, "cross", is_shared)

        def at(channel: str) -> str:
            return f"{unit:g} * {self._at_nodes(table, 'cross', f'i * {nodes} + ', channel)}"

        loop = f"for (int i = 0; i < {count}; ++i)"
        if is_shared:
            self._once(name, f"color {name}[{count}];", loop, f"    {name}[i] = {at('')};")
        else:
            self._once(name, f"color {name}[{3 * count}];", "for (int c = 0; c < 3; ++c)", f"    {loop}", f"        {name}[c * {count} + i] = {at('[c]')};")
        return name, 0 if is_shared else count

    def _at_nodes(self, table: str, which: str, begin: str, channel: str) -> str:
        """An expression for a table over the axes alone, from an entry on, at the place of a channel, or where that is empty at the one that all share."""
        sizes = [getattr(axis, which).count for axis in self._axes]
        parts = [self._knots(i, which, not channel) for i in range(len(sizes))]
        steps = [int(np.prod(sizes[k + 1 :])) for k in range(len(sizes))]
        place = begin + " + ".join(f"{cell}{channel}" + (f" * {step}" if step > 1 else "") for (cell, _), step in zip(parts, steps))
        if len(parts) == 1:
            return f"mix({table}[{place}], {table}[{place} + 1], {parts[0][1]}{channel})"
        # the last axis is the innermost, as the view is elsewhere
        return f"grid({table}, {place}, {', '.join([*map(str, steps[:-1]), *(f'{along}{channel}' for _, along in parts)])})"

    def _lobes(self, lobe_set: LiveLobes, base_color: str) -> None:
        fitted = [i for i, lobe in enumerate(lobe_set.grid) if isinstance(lobe.energy, np.ndarray)]
        # shares are 1 together: the last lobe has what the others leave, where all see one view
        last = fitted[-1] if len(fitted) > 1 and len({self.frames[i] for i in fitted}) == 1 else None
        shares: list[str] = []
        if lobe_set.base is not None and len(set(self.frames)) == 1:
            self._about = self.frames[0]
            self._read_at_once({"LogSum": lobe_set.log_sum, "LogThrough": lobe_set.base.log_through, "LogBack": lobe_set.base.log_back})
        for i, lobe in enumerate(lobe_set.grid):
            self._about = self.frames[i]
            total = self._name(f"fitted{self._about.suffix}")
            if total not in self._said:
                self._once(total, f"color {total} = {self._energy('LogSum', lobe_set.log_sum)};")
            if lobe.energy is None:
                weight = ""
            elif isinstance(lobe.energy, LogEnergy):
                weight = self._energy(f"Mirror{i}", lobe.energy)
            else:
                if i == last:
                    weight = f"{total} * max(color(1.0) - {' - '.join(shares)}, color(0.0))"
                else:
                    shares.append(self._name(f"share{i}"))
                    self._say(f"color {shares[-1]} = {self._value(f'Share{i}', lobe.energy)};")
                    weight = f"{total} * {shares[-1]}"
                if np.any(lobe.unit != 1.0):
                    weight += f" / {self._value(f'Unit{i}', lobe.unit, 'fine' if has_waves(self._axes) else 'knots')}"
            if lobe.is_diffuse and lobe_set.base is not None:
                through, back = self._energy("LogThrough", lobe_set.base.log_through), self._energy("LogBack", lobe_set.base.log_back)
                color = base_color if lobe_set.base.is_live else f"color({numbers(np.clip(lobe_set.stack.base['color'], 0.0, 1.0))})"
                weight = f"({weight} + {through} * {color} / (color(1.0) - {back} * {color}))"
            if lobe.is_diffuse and lobe_set.ramp is not None:
                self.closures.append(self._diffuse_ramp(weight, lobe_set.ramp))
                continue
            self.closures.append(Closure(weight, *self._closure(i, lobe)))

    def _diffuse_ramp(self, weight: str, ramp: LiveRamp) -> Closure:
        """The closure of a base's light."""
        self.functions.append("ramp.h")
        name, energy = self._name("ramp"), self._name("base_light")
        beside = [f"{name}_{i}" for i in range(len(ramp.modes))]
        # of each channel three amounts, which are read as one color
        rows = np.moveaxis(ramp.amounts.reshape(-1, len(ramp.modes), 3), 2, 0)
        is_shared = not any(axis.is_color for axis in self._axes)
        table = self._array("color", "Ramp", [f"color({','.join(map(_entry, row))})" for row in rows.reshape(-1, rows.shape[-1])])
        amounts = self._at_nodes(table, "knots", f"c * {rows.shape[1]} + ", "" if is_shared else "[c]")
        self._say(
            *(f"color {amount};" for amount in beside),
            "for (int c = 0; c < 3; ++c) {",
            f"    color amounts = {amounts};",
            *(f"    {amount}[c] = amounts[{i}];" for i, amount in enumerate(beside)),
            "}",
            f"color {name}[RAMP];",
            f"{name}[0] = color(0.0);",
        )
        for k in range(1, len(RAMP_COSINES)):
            terms = " + ".join(f"{mode[k]:.6g} * {amount}" for mode, amount in zip(ramp.modes, beside))
            self._say(f"{name}[{k}] = max(color({RAMP_COSINES[k]:.9g}) + {terms}, color(0.0));")
        self._say(f"color {energy} = {weight};", f"ramp_to_working({name}, {energy}, {PRIMARY_ARGUMENTS});")
        return Closure(energy, f"diffuse_ramp({self._about.normal}, {name})", True)

    def _closure(self, i: int, lobe: LiveLobe) -> tuple[str, bool, tuple[str, ...]]:
        """The closure, that it is local, and its shape."""
        upright = f"{self._about.normal}, tangent{self._about.suffix}"
        if lobe.is_diffuse:
            return f"diffuse({self._about.normal})", True, ()
        if lobe.is_specular:
            return f'microfacet("{lobe.distribution}", {upright}, 0.0, 0.0, 1.0, 0)', True, ("0.0",) * 3
        if lobe.is_brushed:
            upright = f"{self._about.normal}, {self._brushed}"
        elif isinstance(lobe.fresnel, DielectricCurve):
            alpha = self._alpha(f"alpha_{i}", self._root(f"Root{i}", lobe.shape[..., 0]))
            eta = self._index or f"{lobe.fresnel.eta:.9g}"
            return f'interface_bsdf({upright}, {alpha}, break_isotropy({alpha}), {eta}, "{lobe.distribution}")', True, ()
        elif isinstance(lobe.fresnel, ConductorCurve):
            alpha, index = self._alpha(f"alpha_{i}", self._root(f"Root{i}", lobe.shape[..., 0])), self._metal(lobe.fresnel)
            return f'metal_bsdf({upright}, {alpha}, break_isotropy({alpha}), {index}, "{lobe.distribution}", {PRIMARY_ARGUMENTS})', True, ()
        is_upright = not np.any(lobe.shape[..., 2])
        is_round = is_upright and not lobe.is_brushed and np.array_equal(lobe.shape[..., 0], lobe.shape[..., 1])
        if is_round or any(self._live_root(lobe.shape[..., c]) for c in range(2)):
            roots = [self._root(f"Root{axis.upper()}{i}", lobe.shape[..., c]) for c, axis in enumerate("x" if is_round else "xy")]
            slope = "0.0" if is_upright else self._value(f"Slope{i}", lobe.shape[..., 2:])
        else:
            shape = self._name(f"shape{i}")
            self._say(f"color {shape} = {self._value(f'Shape{i}', lobe.shape, are_channels=False)};")
            *roots, slope = (f"{shape}[{c}]" for c in range(3))
        alphas = [self._alpha(f"alpha_{axis}{i}", root) for axis, root in zip("xy", roots)]
        if lobe.is_brushed and lobe.fresnel is not None:
            eta = self._index or f"{lobe.fresnel.eta:.9g}"
            return f'interface_bsdf({upright}, {", ".join(alphas)}, {eta}, "{lobe.distribution}")', True, ()
        if lobe.is_brushed:
            return f'microfacet("{lobe.distribution}", {upright}, {", ".join(alphas)}, 1.0, 0)', True, ()
        if is_round:
            return f'microfacet("{lobe.distribution}", {upright}, {alphas[0]}, break_isotropy({alphas[0]}), 1.0, 0)', True, (alphas[0], alphas[0], "0.0")
        return (
            f'microfacet("{lobe.distribution}", {self._about.tilted(slope)}, {alphas[0]}, break_isotropy({", ".join(alphas)}), 1.0, 0)',
            True,
            (*alphas, slope),
        )

    def _root(self, name: str, values: np.ndarray) -> str:
        """An expression for the root (..., KNOTS) of an alpha, which may be a live roughness itself."""
        return self._live_root(values) or self._value(name, values[..., None])

    def _live_root(self, values: np.ndarray) -> str:
        """The live roughness that a root (..., KNOTS) of an alpha is; empty where it is none."""
        for number, axis in enumerate(self._axes):
            knots = axis.knots.knots.reshape([-1 if n == number else 1 for n in range(values.ndim)])
            if isinstance(axis, NumberAxis) and np.allclose(values, knots, rtol=0.0, atol=_SAME):
                return self._coordinates[number][1]
        return ""

    def _metal(self, curve: ConductorCurve) -> str:
        """Arguments for a metal's index."""
        self.functions += ["metal.h", "artist_index.h"]
        colors = Place(None, "reflectance"), Place(None, "edge_color")
        if not any(place in axis.live for axis in self._axes for place in colors):
            return f"color({numbers(curve.eta)}), color({numbers(curve.k)})"
        eta, k = self._name("eta"), self._name("k")
        self._say(f"color {eta}, {k};", f"artist_index({', '.join(map(self._given, colors))}, {eta}, {k});")
        return f"{eta}, {k}"

    def _alpha(self, word: str, root: str) -> str:
        """The variable that a root's square becomes."""
        alpha = self._name(word)
        self._say(f"float {alpha} = max({root}, 0.0);", f"{alpha} = clamp({alpha} * {alpha}, {MIN_ALPHA:g}, 1.0);")
        return alpha


def _entry(value: float) -> str:
    """A number of a table; there are thousands, so no zero stands before its point and no space between two."""
    text = f"{value:.6g}"
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
