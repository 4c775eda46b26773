# SPDX-License-Identifier: GPL-3.0-or-later
"""One picture per fit: slices in the plane of incidence, polar and Cartesian, lobes of data and fit, and where the residuals are.

Imports matplotlib when called, never on import.
"""

from collections.abc import Sequence

import numpy as np

from ..optics.frame import spherical
from .compare import Evaluator
from .drawing import new_figure, style
from .fitting import Fit
from .metric import Metric
from .readers.measurement import Measurement, half_angles

# Angles of incidence of a report: those of Weidlich07, figure 9.
INCIDENT_DEG = (0.0, 35.0, 65.0)
_VIEW_DEG = np.arange(-85.0, 85.5, 1.0)
# Measured pairs this near to a slice are drawn on it, the nearest ones first.
_NEAR_DEG, _MOST_DOTS = 4.0, 250
_COLORS = ("tab:red", "tab:green", "tab:blue")
# Cells across a lobe's image; measured pairs that are looked at for it, at once, and how near they must be.
_LOBE_CELLS, _LOBE_PAIRS, _LOBE_CHUNK, _LOBE_NEAR = 72, 30_000, 100, 0.25


def picture(
    measurement: Measurement,
    fit: Fit,
    evaluator: Evaluator,
    truth: Evaluator | None = None,
    title: str = "",
    curves: dict[str, Evaluator] | None = None,
    angles: Sequence[float] = INCIDENT_DEG,
):
    """A matplotlib figure, with a column for each angle of incidence in degrees. `truth` draws the data as a curve where it is known everywhere, as of a model; else pairs
    near each slice are drawn as dots. `curves` are more models for the slices, by name.
    """
    figure = new_figure(
        max(13.0, 4.3 * len(angles)), 15.5, title or f"{measurement.source}\n{fit.structure.name}, model {fit.model}: error {100 * fit.error:.2g} %"
    )
    grid = figure.add_gridspec(5, len(angles), height_ratios=(1.0, 0.75, 0.9, 0.9, 0.9))
    for column, angle in enumerate(angles):
        cartesian, polar = figure.add_subplot(grid[0, column]), figure.add_subplot(grid[1, column], projection="polar")
        _slice(cartesian, polar, measurement, angle, evaluator, truth, curves or {}, legend=column == 0)
        _lobes(figure, (figure.add_subplot(grid[2, column]), figure.add_subplot(grid[3, column])), measurement, angle, evaluator, truth)
    last = grid[4, :].subgridspec(1, 3)
    _residual_maps(figure, [last[column] for column in range(3)], measurement, fit, evaluator)
    return figure


def _slice(cartesian, polar, measurement, angle, evaluator, truth, curves, legend) -> None:
    wo = spherical(np.radians(_VIEW_DEG), 0.0)
    wi = np.broadcast_to(spherical(np.radians(angle), np.pi), wo.shape)
    fitted, exact = evaluator(wi, wo), truth(wi, wo) if truth else None
    near, view = _on_slice(measurement, angle)
    single = measurement.channels == 1
    for c in range(measurement.channels):
        color = "black" if single else _COLORS[c]
        for axis, x, dots in ((cartesian, _VIEW_DEG, view), (polar, np.radians(_VIEW_DEG), np.radians(view))):
            axis.plot(x, fitted[:, c], color="tab:red" if single else color, linewidth=1.6, label="fit" if single else f"fit, {('red', 'green', 'blue')[c]}")
            if exact is not None:
                axis.plot(x, exact[:, c], color=color, linestyle="--", linewidth=1.0, label="data" if c == 0 else None)
            else:
                axis.plot(
                    dots, measurement.f[near, c], ".", color=color, markersize=3, alpha=0.6, zorder=1, label=f"data within {_NEAR_DEG:g}°" if c == 0 else None
                )
    for name, other in curves.items():
        cartesian.plot(_VIEW_DEG, other(wi, wo)[:, 0 if single else 1], linewidth=0.9, label=name)
    cartesian.axvline(-angle, color="tab:orange", linewidth=0.8, linestyle=":")
    shown = exact if exact is not None else fitted
    limit = 1.3 * float(np.quantile(np.max(shown, axis=1), 0.97)) + 1e-6
    cartesian.set_ylim(0.0, limit)
    style(cartesian, f"incident at {angle:g}° (dotted: towards the light)", "view angle (degrees)", "f (1/sr)", legend=legend)
    polar.set_theta_zero_location("N")
    polar.set_theta_direction(-1)
    polar.set_thetalim(-0.5 * np.pi, 0.5 * np.pi)
    polar.set_rlim(0.0, limit)
    polar.set_yticks(np.linspace(0.0, limit, 5)[1:-1], [""] * 3)
    polar.tick_params(labelsize=6)


def _on_slice(measurement: Measurement, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows with the light at an angle and the view in its plane, and those views in degrees, positive beyond the normal."""
    m = measurement
    theta_i = np.degrees(np.arccos(np.clip(m.wi[:, 2], 0.0, 1.0)))
    theta_o = np.degrees(np.arccos(np.clip(m.wo[:, 2], 0.0, 1.0)))
    turn = np.arctan2(m.wo[:, 1], m.wo[:, 0]) - np.arctan2(m.wi[:, 1], m.wi[:, 0])
    aside = np.abs(np.sin(turn)) * np.sin(np.radians(theta_o)) * min(1.0, angle / _NEAR_DEG)
    away = np.maximum(np.abs(theta_i - angle), np.degrees(np.arcsin(np.minimum(aside, 1.0))))
    near = np.argsort(away, kind="stable")[:_MOST_DOTS]
    near = near[away[near] < _NEAR_DEG]
    sign = np.where(np.cos(turn[near]) > 0.0, -1.0, 1.0)
    return near, sign * theta_o[near]


def _lobes(figure, axes, measurement: Measurement, angle: float, evaluator: Evaluator, truth: Evaluator | None) -> None:
    """f cos over the hemisphere of views, seen from above, on one scale: of the data, then of the fit."""
    x, y = np.meshgrid(*2 * [np.linspace(-0.995, 0.995, _LOBE_CELLS)])
    wo = np.stack([x, y, np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))], axis=-1)
    inside = wo[..., 2] > 0.1
    wo = wo[inside]
    wi = np.broadcast_to(spherical(np.radians(angle), np.pi), wo.shape)
    cos_o = wo[:, 2]
    fitted = np.mean(evaluator(wi, wo), axis=1) * cos_o
    data = np.mean(truth(wi, wo), axis=1) * cos_o if truth else _measured(measurement, wi, wo) * cos_o
    known = np.concatenate([fitted, data[np.isfinite(data)]])
    low, high = float(np.quantile(known, 0.02)), float(np.quantile(known, 0.995))
    for axis, name, values in zip(axes, ("data", "fit"), (data, fitted)):
        image = np.full(x.shape, np.nan)
        image[inside] = values
        drawn = axis.imshow(image, origin="lower", extent=(-1, 1, -1, 1), cmap="viridis", vmin=low, vmax=high, interpolation="nearest")
        axis.set_title(f"{name}: f cos, light {f'at {angle:g}° from the left' if angle else 'from above'}", fontsize=8)
        axis.plot([-np.sin(np.radians(angle))], [0.0], "x", color="tab:orange", markersize=5)
        axis.set_axis_off()
        figure.colorbar(drawn, ax=axis, shrink=0.8).ax.tick_params(labelsize=6)


def _measured(measurement: Measurement, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """(n,) mean over channels of the nearest measured pairs; NaN where none is near.

    Near in half and difference angles, as for an isotropic surface, with a highlight's half angles told apart.
    """
    m = measurement.subset(np.arange(0, len(measurement.f), max(1, len(measurement.f) // _LOBE_PAIRS)))
    place, wanted = _place(m.wi, m.wo), _place(wi, wo)
    result = np.empty(len(wi))
    for i in range(0, len(wi), _LOBE_CHUNK):
        distance = np.sum(np.square(wanted[i : i + _LOBE_CHUNK, None] - place), axis=-1)
        nearest = np.argmin(distance, axis=1)
        far = np.take_along_axis(distance, nearest[:, None], axis=1)[:, 0] > np.square(_LOBE_NEAR)
        result[i : i + _LOBE_CHUNK] = np.where(far, np.nan, np.mean(m.f[nearest], axis=1))
    return result


def _place(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    theta_h, theta_d, phi_d = half_angles(wi, wo)
    across = np.sqrt(theta_h) * np.sin(theta_d)
    # the second harmonic of phi_d: light and view may change places
    return np.stack([np.sqrt(theta_h), theta_d, across * np.cos(2.0 * phi_d), across * np.sin(2.0 * phi_d)], axis=-1)


def _residual_maps(figure, places, measurement, fit, evaluator) -> None:
    """Mean residual by half and difference angle, by view and light angle, and the errors per region."""
    m = measurement.subset(np.arange(0, len(measurement.f), max(1, len(measurement.f) // 6000)))
    metric = Metric(m, fit.metric.kind)
    f = evaluator(m.wi, m.wo)
    residual = np.mean(metric.residual(f), axis=1)
    theta_h, theta_d, _ = (np.degrees(a) for a in half_angles(m.wi, m.wo))
    limit = max(float(np.quantile(np.abs(residual), 0.95)), 1e-3)
    pairs = (
        ("half angle", theta_h, "difference angle", theta_d),
        ("light angle", np.degrees(np.arccos(m.wi[:, 2])), "view angle", np.degrees(np.arccos(m.wo[:, 2]))),
    )
    for column, (x_name, x, y_name, y) in enumerate(pairs):
        axis = figure.add_subplot(places[column])
        edges = np.linspace(0.0, 90.0, 19)
        count, *_ = np.histogram2d(x, y, (edges, edges))
        total, *_ = np.histogram2d(x, y, (edges, edges), weights=residual)
        mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        image = axis.imshow(mean.T, origin="lower", extent=(0, 90, 0, 90), cmap="RdBu_r", vmin=-limit, vmax=limit, aspect="auto")
        style(axis, "mean residual (fit above data: red)", f"{x_name} (degrees)", f"{y_name} (degrees)", legend=False)
        bar = figure.colorbar(image, ax=axis)
        bar.ax.tick_params(labelsize=6)
        bar.set_label("of log f cos", fontsize=7)
    axis = figure.add_subplot(places[2])
    bands = metric.bands(metric.residual(f))
    axis.barh(list(bands), [100.0 * v for v in bands.values()], color="tab:gray")
    axis.invert_yaxis()
    style(axis, "error per region", "RMS residual (%)", "", legend=False)
