# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lobe set in tables writes: constants over the view, and no parameters that make sockets but a base's color that is followed.

Tables are array parameters: they stay at their defaults, take no time per shading, and make no sockets. Cycles translates
a shader for each material that has it, in a time that goes with the count of lookups; so a lobe's shape is one table.
"""

from collections.abc import Sequence

import numpy as np

from ....reference_py.lobes.lobe import DielectricCurve
from ....reference_py.lobes.view_table import AZIMUTHS, KNOTS, BaseColorTable, DiffuseTable, GlossyTable, TableLobes, is_glossy
from ..inputs import base_color_input
from .block import PRIMARY_ARGUMENTS, Block, Closure, numbers
from .view_frame import FRAME_FUNCTIONS, Frame

NOTE = "Tables hold the values that the stack had."


def table_block(lobe_set: TableLobes, owners: Sequence[str], prefix: str = "") -> Block:
    """The block of a lobe set of a stack whose shader parameters begin with `owners`; its array parameters begin with `prefix`."""
    arrays: list[str] = []
    said: dict[str, str] = {}
    body: list[str] = []
    frames = [Frame.of(table.normal, owners) for table in lobe_set.tables]
    closures = tuple([_closure(arrays, said, body, f"{prefix}{i}", *lobe, owners[-1]) for i, lobe in enumerate(zip(lobe_set.tables, frames))])
    glossy = dict.fromkeys(frame for table, frame in zip(lobe_set.tables, frames) if is_glossy(table))
    axes = dict.fromkeys(axis for table in lobe_set.tables if (axis := _axis(table)) is not None)
    return Block(
        functions=(
            *(FRAME_FUNCTIONS if glossy else ("bent.h", "view_place.h")),
            *(name for frame in frames for name in frame.functions),
            *(("incidence.h", "rotate_tangent.h", "azimuth_place.h") if axes else ()),
            *(("ramp.h",) if body else ()),
        ),
        arrays=tuple(arrays),
        common=(
            *(line for frame in dict.fromkeys(frames) for line in frame.table_view),
            *(line for frame in glossy for line in frame.glossy),
            *(line for axis in axes for line in _about_axis(axis)),
            *said.values(),
        ),
        body=tuple(body),
        closures=closures,
    )


def _closure(arrays: list[str], said: dict[str, str], body: list[str], name: str, table, about: Frame, owner: str) -> Closure:
    """A lobe; its array parameters are added to `arrays`, statements that it needs to `said`, by what they make known, and those that are its block's own to `body`."""
    if isinstance(table, BaseColorTable):
        weight, table = _base_weight(arrays, said, name, table, about, owner), table.now
    else:
        weight = _value(arrays, f"Weight{name}", table.weight, about, _axis(table))
    if isinstance(table, DiffuseTable):
        return Closure(weight, f"diffuse({about.normal})") if table.ramp is None else _diffuse_ramp(body, name, weight, table.ramp, about)
    alpha_x, alpha_y, slope = _shape(arrays, said, name, table.shape, about)
    upright = f"{about.normal}, {f'tangent{about.suffix}' if table.frame is None else _named(_axis(table))}"
    if isinstance(table.fresnel, DielectricCurve):
        eta, distribution = f"{table.fresnel.eta:.9g}", table.distribution
        alpha_y = f"break_isotropy({alpha_x})" if table.frame is None else alpha_y
        return Closure(weight, f'interface_bsdf({upright}, {alpha_x}, {alpha_y}, {eta}, "{distribution}")')
    if table.frame is not None:
        frame = upright
    elif _is_round(table.shape):
        frame, alpha_y = upright, f"break_isotropy({alpha_x})"
    else:
        frame, alpha_y = about.tilted(slope), f"break_isotropy({alpha_x}, {alpha_y})"
    return Closure(weight, f'microfacet("{table.distribution}", {frame}, {alpha_x}, {alpha_y}, 1.0, 0)', shape=(alpha_x, alpha_y, slope))


def _diffuse_ramp(body: list[str], name: str, weight: str, ramp: np.ndarray, about: Frame) -> Closure:
    """The closure of a base's light; a grey ramp is the same in every working space."""
    colors = ", ".join(f"color({numbers(row)})" for row in ramp)
    body.append(f"color ramp_{name}[RAMP] = {{{colors}}};")
    if np.any(ramp != ramp[:, :1]):
        body += [f"color diffuse_{name} = {weight};", f"ramp_to_working(ramp_{name}, diffuse_{name}, {PRIMARY_ARGUMENTS});"]
        weight = f"diffuse_{name}"
    return Closure(weight, f"diffuse_ramp({about.normal}, ramp_{name})", True)


def _axis(table) -> float | None:
    """The axis of a lobe that is brushed, or whose weight turns with the azimuth of the view."""
    frame = table.frame if isinstance(table, GlossyTable) else None
    return frame if isinstance(table, BaseColorTable) or table.axis is None else table.axis


def _named(axis: float) -> str:
    """The variable of an axis, and in those of its sheets a suffix: its millionths of a radian, as patches may be brushed along almost the same one."""
    return f"axis_{round(1e6 * axis)}"


def _about_axis(axis: float) -> tuple[str, ...]:
    """Statements that declare an axis, and where sheets about it are read."""
    name = _named(axis)
    return (
        f"vector {name} = rotate_tangent(Tangent, N, {axis / (2.0 * np.pi):.9g});",
        f"int row_{name};",
        f"float turned_{name};",
        f"azimuth_place(tangential_part(I, bent_normal), {name}, row_{name}, turned_{name});",
        f"row_{name} = row_{name} * {KNOTS} + cell;",
    )


def _base_weight(arrays: list[str], said: dict[str, str], name: str, table: BaseColorTable, about: Frame, owner: str) -> str:
    light = _base_light(arrays, said, name, table, about, owner)
    weight = f"{_value(arrays, f'Through{name}', table.through, about)} * {light}"
    if not np.any(table.own):
        return weight
    weight = f"{_value(arrays, f'Own{name}', table.own, about)} + {weight}"
    return f"({weight})" if np.all(table.through >= 0.0) else f"max({weight}, color(0.0))"


def _base_light(arrays: list[str], said: dict[str, str], name: str, table: BaseColorTable, about: Frame, owner: str) -> str:
    """What of light that got down to the base leaves it up again: one expression for all lobes of equal tables."""
    key = f"{about.suffix}/{table.back.tobytes().hex()}"
    if key not in said:
        color = base_color_input(owner).osl_name
        said[key] = f"color base_light_{name} = {color} / (color(1.0) - {_value(arrays, f'Back{name}', table.back, about)} * {color});"
    return said[key].split()[1]


def _is_round(shape: np.ndarray) -> bool:
    return not np.any(shape[:, 2]) and np.all(shape[:, 0] == shape[:, 1])


def _shape(arrays: list[str], said: dict[str, str], name: str, shape: np.ndarray, about: Frame) -> tuple[str, str, str]:
    """Expressions for the columns of a lobe's shape (KNOTS, 3) at the view."""
    if _is_round(shape):
        alpha = _value(arrays, f"Alpha{name}", shape[:, 0], about)
        if np.any(shape[:, 0] != shape[0, 0]):
            said[f"alpha_{name}"] = f"float alpha_{name} = {alpha};"
            alpha = f"alpha_{name}"
        return alpha, alpha, "0"
    said[f"shape_{name}"] = f"color shape_{name} = {_value(arrays, f'Shape{name}', shape, about)};"
    return f"shape_{name}[0]", f"shape_{name}[1]", f"shape_{name}[2]"


def _value(arrays: list[str], name: str, column: np.ndarray, about: Frame, axis: float | None = None) -> str:
    """An expression for a column (KNOTS,) or (KNOTS, 3), or for sheets (AZIMUTHS, KNOTS, 3) about an axis, at the view about a normal; a table becomes an
    array parameter.
    """
    if column.ndim == 3:
        entries = ", ".join([f"color({numbers(row)})" for row in column.reshape(-1, 3)])
        arrays.append(f"color {name}[{len(AZIMUTHS) * KNOTS}] = {{{entries}}}")
        row, turned = f"row_{_named(axis)}", f"turned_{_named(axis)}"
        low, high = (f"mix({name}[{row}{i}], {name}[{row}{j}], between)" for i, j in (("", " + 1"), (f" + {KNOTS}", f" + {KNOTS + 1}")))
        return f"mix({low}, {high}, {turned})"
    color = column.ndim == 2
    if np.all(column == column[0]):
        return f"color({numbers(column[0])})" if color else f"{column[0]:.9g}"
    entries = ", ".join([f"color({numbers(row)})" for row in column]) if color else numbers(column)
    arrays.append(f"{'color' if color else 'float'} {name}[{KNOTS}] = {{{entries}}}")
    cell, between = f"cell{about.suffix}", f"between{about.suffix}"
    return f"mix({name}[{cell}], {name}[{cell} + 1], {between})"
