# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets in tables as JSON's types and back. The types are named, nothing is executed."""

import numpy as np

from ..material.place import Place
from ..material.stack import Stack
from .axes import AXES, Axis, Scale
from .diffuse_ramp import RAMP_COSINES
from .live_grid import LiveBase, LiveLobe, LiveLobes, LiveRamp, LogEnergy, unit_sizes
from .lobe import ConductorCurve, DielectricCurve
from .view_table import AZIMUTHS, KNOTS, BaseColorTable, DiffuseTable, GlossyTable, TableLobes


def pack_tables(lobe_set: TableLobes) -> dict:
    """A baked lobe set as lists and numbers."""
    return {"tables": [_pack(table) for table in lobe_set.tables], "stock": lobe_set.stock and pack_tables(lobe_set.stock)}


def unpack_tables(data: dict, stack: Stack) -> TableLobes:
    """The lobe set of `pack_tables`, with the stack's own live values. Raises ValueError, KeyError or TypeError on anything else."""
    stock = data["stock"] and unpack_tables(data["stock"], stack)
    return TableLobes(tuple(_unpack(table, stack) for table in data["tables"]), stock)


def _pack(table) -> dict:
    if isinstance(table, BaseColorTable):
        shape = None if table.shape is None else table.shape.tolist()
        light = {name: getattr(table, name).tolist() for name in ("own", "through", "back")}
        return light | {"distribution": table.distribution, "shape": shape, "ramp": _pack_ramp(table)}
    weight = np.asarray(table.weight).tolist()
    if isinstance(table, DiffuseTable):
        return {"weight": weight, "axis": table.axis, "ramp": _pack_ramp(table)}
    eta = None if table.fresnel is None else table.fresnel.eta
    return {
        "weight": weight,
        "axis": table.axis,
        "frame": table.frame,
        "shape": np.asarray(table.shape).tolist(),
        "distribution": table.distribution,
        "eta": eta,
    }


def _pack_ramp(table: DiffuseTable | BaseColorTable) -> list | None:
    return None if table.ramp is None else table.ramp.tolist()


def _unpack_ramp(data: dict) -> np.ndarray | None:
    return None if data["ramp"] is None else _array(data["ramp"], (len(RAMP_COSINES), 3))


def _unpack(data: dict, stack: Stack):
    if "through" in data:
        light = (_array(data[name]) for name in ("own", "through", "back"))
        shape = None if data["shape"] is None else _array(data["shape"])
        return BaseColorTable(*light, np.array(stack.base["color"]), distribution=data["distribution"], shape=shape, ramp=_unpack_ramp(data))
    axis, frame = (None if data.get(name) is None else float(data[name]) for name in ("axis", "frame"))
    weight = _array(data["weight"], (KNOTS, 3) if axis is None else (len(AZIMUTHS), KNOTS, 3))
    if "shape" not in data:
        return DiffuseTable(weight, axis, ramp=_unpack_ramp(data))
    curve = None if data["eta"] is None else DielectricCurve(float(data["eta"]))
    return GlossyTable(str(data["distribution"]), weight, _array(data["shape"]), curve, frame, axis)


def pack_grid(lobe_set: LiveLobes) -> dict:
    """A lobe set that was baked over live parameters as lists and numbers."""
    lobes = [
        {
            "energy": _pack_log(lobe.energy) if isinstance(lobe.energy, LogEnergy) else None if lobe.energy is None else lobe.energy.tolist(),
            "distribution": lobe.distribution,
            "shape": None if lobe.shape is None else lobe.shape.tolist(),
            "eta": lobe.fresnel.eta if isinstance(lobe.fresnel, DielectricCurve) else None,
            "is_metal": isinstance(lobe.fresnel, ConductorCurve),
            "unit": None if lobe.unit is None else lobe.unit.tolist(),
            "is_brushed": lobe.is_brushed,
        }
        for lobe in lobe_set.grid
    ]
    axes = [
        [type(axis).__name__, [place.pair() for place in axis.live], *([scale.low, scale.high, scale.count, scale.bend] for scale in axis.scales), axis.before]
        for axis in lobe_set.axes
    ]
    ramp = lobe_set.ramp and {"modes": lobe_set.ramp.modes.tolist(), "amounts": lobe_set.ramp.amounts.tolist()}
    base = lobe_set.base and {
        "log_through": _pack_log(lobe_set.base.log_through),
        "log_back": _pack_log(lobe_set.base.log_back),
        "is_live": lobe_set.base.is_live,
    }
    coefficients = None if lobe_set.coefficients is None else lobe_set.coefficients.tolist()
    return {
        "axes": axes,
        "lobes": lobes,
        "log_sum": _pack_log(lobe_set.log_sum),
        "coefficients": coefficients,
        "base": base,
        "ramp": ramp,
        "rotation": lobe_set.rotation and lobe_set.rotation.pair(),
        "stock": lobe_set.stock and pack_grid(lobe_set.stock),
    }


def _pack_log(energy: LogEnergy) -> dict:
    return {"along": [table.tolist() for table in energy.along], "modes": None if energy.modes is None else energy.modes.tolist(), "is_log": energy.is_log}


def unpack_grid(data: dict, stack: Stack) -> LiveLobes:
    """The lobe set of `pack_grid`. Raises ValueError, KeyError or TypeError on anything else."""
    axes = tuple(
        AXES[kind](
            tuple(Place.of_pair(*pair) for pair in live),
            *(Scale(float(low), float(high), int(count), float(bend)) for low, high, count, bend in scales),
            int(before),
        )
        for kind, live, *scales, before in data["axes"]
    )
    size = (*(axis.knots.count for axis in axes), KNOTS)

    def grid(values, columns: int = 3, size: tuple[int, ...] = size):
        return None if values is None else _array(values, (*size, columns))

    coefficients = None
    if len(axes) > 1:
        modes = len(np.ravel(data["coefficients"])) // int(np.prod([axis.cross.count for axis in axes]))
        coefficients = _array(data["coefficients"], (*(axis.cross.count for axis in axes), modes))

    def log_energy(values: dict) -> LogEnergy:
        along = tuple(_array(table, (axis.fine.count, KNOTS, 3)) for axis, table in zip(axes, values["along"], strict=True))
        modes = None if coefficients is None else _array(values["modes"], (coefficients.shape[-1], KNOTS, 3))
        return LogEnergy(along, modes, bool(values["is_log"]))

    lobes = [
        LiveLobe(
            log_energy(lobe["energy"]) if isinstance(lobe["energy"], dict) else grid(lobe["energy"]),
            lobe["distribution"],
            grid(lobe["shape"]),
            ConductorCurve.of(stack.base) if lobe["is_metal"] else None if lobe["eta"] is None else DielectricCurve(float(lobe["eta"])),
            grid(lobe["unit"], 1, (*unit_sizes(axes), KNOTS)),
            is_brushed=bool(lobe["is_brushed"]),
        )
        for lobe in data["lobes"]
    ]
    base = data["base"]
    if base is not None:
        base = LiveBase(log_energy(base["log_through"]), log_energy(base["log_back"]), bool(base["is_live"]))
    ramp = _unpack_live_ramp(data["ramp"], axes)
    rotation = data["rotation"] and Place.of_pair(*data["rotation"])
    stock = data["stock"] and unpack_grid(data["stock"], stack)
    return LiveLobes(stack, axes, tuple(lobes), log_energy(data["log_sum"]), coefficients, base, rotation, ramp, stock)


def _unpack_live_ramp(data: dict | None, axes: tuple[Axis, ...]) -> LiveRamp | None:
    if data is None:
        return None
    modes = _array(data["modes"], (len(data["modes"]), len(RAMP_COSINES)))
    return LiveRamp(modes, _array(data["amounts"], (*(axis.knots.count for axis in axes), len(modes), 3)))


def _array(values, shape: tuple[int, ...] = (KNOTS, 3)) -> np.ndarray:
    array = np.array(values, float)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise ValueError("a table is broken")
    return array
