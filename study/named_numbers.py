# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that documents quote, by name: each is a text that committed tables give. `numbers` puts them into the documents.

Numbers are written as the documents have them: no zero before the point, a dimension where it belongs to the number.
"""

from collections.abc import Callable, Mapping
from functools import cache, partial
from types import MappingProxyType

import numpy as np

from .tables import FIGURES, read_table

Row = dict[str, str]
_WORDS = {1: "one", 2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 10: "ten", 12: "twelve", 30: "thirty"}
# EEVEE is called too dark beyond this share of the energy.
_DARK = 0.1
# Of a lobe's shape that stock nodes change: the materials where it counts.
_OFF_IN_SHAPE = 0.1


def plain(value: float, digits: int) -> str:
    """ ".65", "3.8", "52"."""
    text = f"{value:.{digits}f}"
    return text.removeprefix("0") if digits else text


def percent(share: float, digits: int = 0) -> str:
    return plain(100.0 * share, digits) + " %"


def span(values, digits: int) -> str:
    """Least and most: "1.03 to 1.28"."""
    return f"{plain(min(values), digits)} to {plain(max(values), digits)}"


def word(count: int) -> str:
    return _WORDS.get(count, str(count))


@cache
def rows(table: str) -> list[Row]:
    return read_table(FIGURES / f"{table}.csv")


def column(found: list[Row], name: str) -> np.ndarray:
    return np.array([float(row[name]) for row in found])


def where(table: str, **cells: str) -> list[Row]:
    """Rows of a table with these cells; there is one at least, or a chart's name has changed."""
    found = [row for row in rows(table) if all(row[name] == cell for name, cell in cells.items())]
    if not found:
        raise LookupError(f"figures/{table}.csv has no row with {cells}")
    return found


def cell(table: str, name: str, **cells: str) -> float:
    """A cell of the one row with these cells."""
    (row,) = where(table, **cells)
    return float(row[name])


# --- energy and shape of the tiers ---


def tier(name: str, statistic: Callable[[np.ndarray], float], of: str, digits: int) -> str:
    return percent(statistic(column(where("tier_errors", tier=name), of)), digits)


def beyond_three_percent() -> str:
    return str(np.sum(column(where("tier_errors", tier="analytic"), "albedo_worst") > 0.03))


def preset_table() -> str:
    from ..reference_py.material import presets

    lines = ["| preset | chosen | closures | albedo error | shape error |", "| --- | --- | --- | --- | --- |"]
    for name in sorted(presets.PAPER):
        (row,) = where("preset_errors", preset=name)
        errors = f"{percent(float(row['albedo_worst']), 2)} | {percent(float(row['shape_worst']), 1)}"
        lines.append(f"| {name} | {row['chosen']} | {row['closures']} | {errors} |")
    return "\n".join(["\n", *lines, "\n"])


def preset_energy(truth: str) -> np.ndarray:
    return column(where("preset_errors", truth=truth), "albedo_worst")


# --- cost ---


def cost(surface: str, method: str) -> str:
    return plain(cell("pareto", "cost", surface=surface, method=method), 2)


def geometry_over_two_lobes() -> np.ndarray:
    return column([row for row in where("pareto", method="baked_2") if row["over_slab"] and row["surface"] != "frosted_metal"], "over_slab")


def stock_nodes_shape() -> str:
    """Of the materials whose shape stock nodes change."""
    pairs = zip(column(where("pareto", method="nodes"), "shape"), column(where("pareto", method="baked_2"), "shape"))
    return span([100.0 * nodes for nodes, script in pairs if nodes - script > _OFF_IN_SHAPE], 0) + " %"


def cost_factor(factor: str, scene: str) -> float:
    return cell("cost_factors", "cost", factor=factor, scene=scene)


def one_lobe_more() -> str:
    costs = [cost_factor(f"diffuse + {n} ggx", "frame-filling ball") for n in (1, 3)]
    return plain((costs[1] - costs[0]) / 2.0, 2)


def saved_in_the_corner() -> str:
    whole = cost_factor("diffuse + 3 ggx", "ball in a corner")
    return percent(1.0 - cost_factor("diffuse + 3 ggx, but 1 after any bounce", "ball in a corner") / whole)


# --- constants that were fitted ---


def calibration(stacks: str, constants: str, of: str) -> str:
    (row,) = where("calibration", stacks=stacks, constants=constants)
    return percent(0.01 * float(row[of].removesuffix(" %")), 1)


def mirror_alone() -> str:
    return plain(np.mean([cell("cost_fit", "cost", material=f"{how}: 0 diffuse, 1 mirror, 0 glossy") for how in ("OSL", "nodes")]), 2)


def live_cost_errors(constants: str) -> np.ndarray:
    """Relative errors of the estimate for the live methods of `pareto`, without their signs."""
    from . import calibrate_cost

    coefficients = calibrate_cost.cost.PARTS if constants == "committed" else calibrate_cost.fit(calibrate_cost.read_rows())
    return np.abs(calibrate_cost.errors(calibrate_cost.pareto_rows(), coefficients))


def within_two_percent() -> list[float]:
    """Cost over that of Principled with a coat, of what is cheapest of all that bakes are and whose albedo is at most 2 % off, by surfaces."""
    found = []
    for surface in dict.fromkeys(row["surface"] for row in rows("pareto")):
        bakes = [float(r["cost"]) for r in where("pareto", surface=surface) if r["method"].startswith("baked") and float(r["albedo"]) <= 0.02]
        found.append(min(bakes) / cell("pareto", "cost", surface=surface, method="principled"))
    return found


def live_cost(statistic: Callable[[np.ndarray], float], constants: str) -> str:
    return percent(statistic(live_cost_errors(constants)))


def live_cost_misses() -> str:
    from .calibrate_cost import GOOD_TO

    return word(int(np.sum(live_cost_errors("committed") > GOOD_TO)))


# --- surroundings and the viewport ---


def patina_brighter() -> str:
    with_osl, without = (where("surroundings", preset="patina_copper", surroundings=s)[0] for s in ("osl_on", "osl_off"))
    return span([100.0 * (float(without[c]) / float(with_osl[c]) - 1.0) for c in "rgb"], 1) + " %"


def stands_in(words: str, how: str) -> list[float]:
    """Worst errors of albedo in per cent of what surfaces whose name has these words, with a film or brushed, get in a method."""
    return [100.0 * float(row["albedo_worst"]) for row in rows("stands_in") if words in row["stack"] and row["stands_in"] == how]


def not_baked(count: str) -> str:
    """How many of the cases of so many textured values no bake follows, in the groups of surfaces."""
    found = where("followed", live_values=count)
    return span([100.0 * (1.0 - float(row["baked"]) / float(row["cases"])) for row in found], 0) + " %"


def shape_over_own() -> np.ndarray:
    """Of bakes that follow a color, the error of shape over that of bakes of each color alone."""
    return column(rows("base_color"), "shape_median") / column(rows("base_color"), "own_shape_median")


def live_shapes(is_meant: Callable[[Row], bool]) -> list[float]:
    """How many times as much of the shape is elsewhere as in bakes of each value, in the median, by rows."""
    return [float(r["shape_median"]) / float(r["own_shape_median"]) for r in rows("live_values") if is_meant(r)]


def start_ms() -> np.ndarray:
    found = where("branches", osl="on")
    return column(found, "start_ms") - column(found, "alone_start_ms")


def eevee(name: str, ours: bool) -> np.ndarray:
    """A column of Lamina's materials, or of Blender's own nodes."""
    return np.abs(column([row for row in rows("viewport") if bool(row["closures"]) == ours], name))


def eevee_dark(is_dark: bool) -> np.ndarray:
    energy = eevee("eevee_energy", True)
    return energy[(energy > _DARK) == is_dark]


def field(blender: str, verdict: str | None = None) -> str:
    return str(len(where("field", blender=blender, **({"verdict": verdict} if verdict else {}))))


def house(what: str, when: str) -> str:
    return where("house", what=what)[0][when]


# --- batches, farms, work that grows ---


def line(found: list[Row], x: str, y: str) -> tuple[float, float]:
    """(slope, value at 0) of the straight line through the points."""
    slope, start = np.polyfit(column(found, x), column(found, y), 1)
    return float(slope), float(start)


def batch() -> tuple[float, float]:
    return line(where("scale", study="pictures"), "n", "render_s")


def per_material(study: str, of: str, n: str) -> float:
    return cell("scale", of, study=study, n=n) / float(n)


def making_one_more() -> str:
    study = "materials, one stack as stock nodes"
    first, last = (cell("scale", "make_s", study=study, n=n) for n in ("1", "1000"))
    return plain(1000.0 * (last - first) / 999.0, 0) + " ms"


def render_of_layers() -> str:
    return span(column([row for row in rows("scale") if row["study"].startswith("layers")], "render_s"), 1) + " s"


# --- fits ---


def recovered(noise: str, layers: str | None = None) -> list[Row]:
    return where("fit_recovery", noise=noise, **({"layers": layers} if layers else {}))


def within(noise: str, of: str, most: float) -> str:
    return str(np.sum(column(recovered(noise), of) <= most))


def left_of_noise() -> np.ndarray:
    """What fits leave of noisy data, over what the stacks leave that these were made from."""
    return column(recovered("0.05"), "data_error") / column(recovered("0.05"), "true_data_error")


def glaze_error(name: str, glaze: str, thickness: str) -> str:
    """Over white."""
    return percent(cell("tint_spectrum", name, glaze=glaze, base="white", thickness=thickness))


def closures_error(surface: str, closures: str, blender: str, digits: int = 0) -> str:
    """Of the worst view."""
    (row,) = where("closures", surface=surface, closures=closures, blender=blender)
    return percent(max(float(value) for name, value in row.items() if name.startswith("error_")), digits)


def blue_paint(one: str, other: str, suffix: str = "") -> str:
    """How many times closer the other one is."""
    ours, theirs = (cell("fit_blue_paint", "rms_log", model=model + suffix) for model in (other, one))
    return plain(theirs / ours, 1)


GGX, SUM, TO_65 = "GGX and Lambert", "any sum of lobes of stacks", ", to 65 degrees"
PAPER_READING = "paper's parameters, n 1.3 and 1.69"
ONE_STACK, OSL = "materials, one baked stack", "materials, Principled in OSL"

NUMBERS: Mapping[str, Callable[[], str]] = MappingProxyType({
    "energy bound": lambda: f"{np.ceil(100.0 * np.max(column(where('tier_errors', tier='baked, 2 glossy'), 'albedo_worst'))):.0f} %",
    "stacks": lambda: str(len({row["stack"] for row in rows("tier_errors")})),
    "baked 2 energy median": partial(tier, "baked, 2 glossy", np.median, "albedo_worst", 1),
    "baked 2 energy worst": partial(tier, "baked, 2 glossy", np.max, "albedo_worst", 2),
    "analytic energy median": partial(tier, "analytic", np.median, "albedo_worst", 0),
    "analytic energy worst": partial(tier, "analytic", np.max, "albedo_worst", 0),
    "analytic energy beyond": beyond_three_percent,
    "paper energy median": partial(tier, "weidlich_wilkie", np.median, "albedo_worst", 0),
    "baked 2 shape usual": partial(tier, "baked, 2 glossy", np.median, "shape_median", 1),
    "baked 2 shape median": partial(tier, "baked, 2 glossy", np.median, "shape_worst", 1),
    "baked 2 shape worst": partial(tier, "baked, 2 glossy", np.max, "shape_worst", 0),
    "stock 2 shape usual": partial(tier, "baked, 2 glossy, stock nodes", np.median, "shape_median", 1),
    "stock 2 shape median": partial(tier, "baked, 2 glossy, stock nodes", np.median, "shape_worst", 1),
    "baked 3 shape usual": partial(tier, "baked, 3 glossy", np.median, "shape_median", 1),
    "baked 3 shape median": partial(tier, "baked, 3 glossy", np.median, "shape_worst", 1),
    "baked 3 shape worst": partial(tier, "baked, 3 glossy", np.max, "shape_worst", 0),
    "analytic shape usual": partial(tier, "analytic", np.median, "shape_median", 1),
    "analytic shape median": partial(tier, "analytic", np.median, "shape_worst", 1),
    "analytic shape worst": partial(tier, "analytic", np.max, "shape_worst", 0),
    "truths agree": lambda: str(len(where("suite_agreement", albedo_agrees="yes", f_agrees="yes"))),
    "suite": lambda: str(len(rows("suite_agreement"))),
    "preset table": preset_table,
    "presets": lambda: word(len(rows("preset_errors"))),
    "presets by walks energy": lambda: percent(np.max(preset_energy("position_free")), 1),
    "presets energy": lambda: percent(np.max(preset_energy("adding")), 1),
    **{f"cost {surface} {method}": partial(cost, surface, method)
       for surface in ("frosted_paint", "metallic_car_paint", "three_rough") for method in ("baked_1", "baked_2", "principled", "layer")},
    **{f"cost glazed_mug {method}": partial(cost, "glazed_mug", method) for method in ("baked_1", "principled", "layer")},
    "scene cost two lobes": lambda: span(column(where("pareto", method="baked_2"), "scene_cost"), 2),
    "scene cost principled": lambda: span(column(where("pareto", method="principled"), "scene_cost"), 2),
    "geometry over two lobes": lambda: span(geometry_over_two_lobes(), 0),
    "geometry over frosted metal": lambda: plain(cell("pareto", "over_slab", surface="frosted_metal", method="baked_2"), 0),
    "surface types": lambda: word(len({row["surface"] for row in rows("pareto")})),
    "stock nodes shape": stock_nodes_shape,
    "one lobe more": one_lobe_more,
    "saved in the corner": saved_in_the_corner,
    **{f"calibration {name} {constants}": partial(calibration, stacks, constants, of)
       for name, stacks, of in (("seen", "albedo, suite and paper's presets", "worst"), ("tinted", "albedo, held out, 3 to 6 tinted layers", "mean"),
                                ("shape", "shape, held out", "mean"))
       for constants in ("committed", "fitted")},
    "cost of a mirror": mirror_alone,
    **{f"cost {name} {constants}": partial(live_cost, statistic, constants)
       for name, statistic in (("RMS", lambda e: np.sqrt(np.mean(e * e))), ("median", np.median)) for constants in ("committed", "fitted")},
    "cost live materials": lambda: word(len(live_cost_errors("committed"))),
    "cost misses": live_cost_misses,
    "patina brighter": patina_brighter,
    "branches render": lambda: span(column(where("branches", osl="on"), "render"), 3),
    "branches start": lambda: span(100.0 * (column(where("branches", osl="on"), "start") - 1.0), 0) + " %",
    "branches start least": lambda: span(100.0 * (column(where("branches", osl="on"), "start_least") - 1.0), 0) + " %",
    "branches start ms": lambda: span(start_ms(), 0) + " ms",
    "branches make": lambda: span(column(where("branches", osl="on"), "make"), 1),
    "eevee materials": lambda: word(len(eevee("eevee_delta_e", True))),
    "eevee delta e": lambda: span(np.sort(eevee("eevee_delta_e", True))[:-1], 1),
    "eevee brushed": lambda: plain(cell("viewport", "eevee_delta_e", material="Brushed Nickel"), 1),
    "eevee own nodes": lambda: span(eevee("eevee_delta_e", False), 1),
    "stock nodes delta e": lambda: plain(np.max(eevee("nodes_delta_e", True)), 2),
    "eevee dark": lambda: span(100.0 * eevee_dark(True), 0) + " %",
    "eevee dark count": lambda: word(len(eevee_dark(True))),
    "eevee others": lambda: span(100.0 * eevee_dark(False), 0) + " %",
    "eevee own coat": lambda: percent(-cell("viewport", "eevee_energy", material="Principled with a coat")),
    "pools worst": lambda: percent(np.max(column(rows("pools"), "worst")), 1),
    "field 4.5": partial(field, "4.5"),
    "field 5.3": partial(field, "5.3"),
    "field limits": partial(field, "4.5", "limit"),
    "field limits 5.3": partial(field, "5.3", "limit"),
    **{f"house {name} {when}": partial(house, what, when)
       for name, what in (("nodes", "folders and top files in the import graph"), ("circles", "of them in a circle"), ("rooms", "files from a lobe set to its OSL text"),
                          ("returns", "calls back into one of them"), ("kinds", "comparisons with a kind's name"))
       for when in ("before", "now")},
    "killed pictures": lambda: rows("killed_batch")[-1]["pictures_there"],
    "killed times": lambda: word(len(where("killed_batch", how="killed"))),
    "farm task": lambda: plain(line(rows("farm_tasks"), "pictures_per_task", "seconds_per_task")[1], 1) + " s",
    "batch start": lambda: plain(batch()[1], 1) + " s",
    "batch picture": lambda: plain(batch()[0], 2) + " s",
    "batch knee": lambda: plain(batch()[1] / batch()[0], 0),
    "start principled": lambda: plain(1000.0 * per_material(OSL, "render_s", "1000"), 0) + " ms",
    "start copper": lambda: plain(1000.0 * per_material(ONE_STACK, "render_s", "1000"), 0) + " ms",
    "copper over principled": lambda: plain(per_material(ONE_STACK, "render_s", "1000") / per_material(OSL, "render_s", "1000"), 2),
    "start stock nodes": lambda: plain(1000.0 * per_material("materials, one stack as stock nodes", "render_s", "1000"), 0) + " ms",
    "make one more": making_one_more,
    "bake seconds": lambda: span(column(rows("bakes"), "now_s"), 1) + " s",
    "table fits": lambda: ", ".join(f"{float(row['now_s']):.0f} s" for row in rows("fit_table")),
    "table fits before": lambda: ", ".join(f"{float(row['former_s']):.0f} s" for row in rows("fit_table")),
    "bake ratio": lambda: span(column(rows("bakes"), "ratio"), 0),
    "base color energy": lambda: percent(max(column(rows("base_color"), "albedo_worst")), 1),
    "base color shape": lambda: plain(np.median(shape_over_own()), 1),
    "base color shape worst": lambda: plain(max(shape_over_own()), 1),
    "two live with color shape": lambda: span(live_shapes(lambda r: "and the color" in r["live"] and "film" not in r["live"] and r["axes"] != "3"), 1),
    "bakes over principled": lambda: span(within_two_percent(), 2),
    "three live energy": lambda: span([100.0 * float(r["albedo_worst"]) for r in rows("live_values") if r["axes"] == "3"], 1) + " %",
    "three live shape": lambda: span(live_shapes(lambda r: r["axes"] == "3"), 1),
    "film beside roughness energy": lambda: percent(cell("live_values", "albedo_worst", stack="filmed varnish over metal"), 1),
    "film beside roughness shape": lambda: plain(np.max(live_shapes(lambda r: r["stack"] == "filmed varnish over metal")), 1),
    "live bakes seconds": lambda: span(column(rows("live_values"), "cpu_s"), 0) + " s",
    "medium energy": lambda: percent(max(cell("live_values", "albedo_worst", stack="milk over metal", live=f"the {name} of layer 0") for name in ("density", "scatter color")), 1),
    "medium shape": lambda: span(live_shapes(lambda r: "milk" in r["stack"]), 1),
    "medium energy of both": lambda: percent(cell("live_values", "albedo_worst", stack="milk over paint"), 1),
    "film bakes": lambda: plain(max(stands_in("film", "baked")), 1) + " %",
    "textured films": lambda: span(stands_in("textured", "weidlich_wilkie"), 0) + " %",
    "brushed live": lambda: plain(max(stands_in("coat", "analytic")), 1) + " %",
    "brushed bakes": lambda: plain(max(stands_in("brushed", "baked")), 1) + " %",
    "not baked of one": lambda: not_baked("1"),
    "not baked of two": lambda: not_baked("2"),
    "not baked of three": lambda: not_baked("3"),
    "bake": lambda: plain(per_material("materials, distinct, baked", "make_s", "100"), 1) + " s",
    "baked before": lambda: plain(1000.0 * per_material("materials, distinct, baked before", "make_s", "100"), 0) + " ms",
    "render of layers": render_of_layers,
    "memory": lambda: plain(per_material(ONE_STACK, "render_mb", "1000"), 2) + " MB",
    "memory principled": lambda: plain(per_material(OSL, "render_mb", "1000"), 2) + " MB",
    "fits": lambda: str(len(recovered("0"))),
    "fits with noise": lambda: str(len(recovered("0.05"))),
    "fits f within": partial(within, "0", "shape_error", 0.01),
    "fits f worst": lambda: percent(np.max(column(recovered("0"), "shape_error")), 2),
    "fits f one layer": lambda: percent(np.median(column(recovered("0", "1"), "shape_error")), 3),
    "fits f two layers": lambda: percent(np.median(column(recovered("0", "2"), "shape_error")), 3),
    "fits values within": partial(within, "0", "worst_parameter_error", 0.03),
    "fits values worst": lambda: percent(np.max(column(recovered("0"), "worst_parameter_error")), 1),
    "fits with noise f within": partial(within, "0.05", "shape_error", 0.03),
    "fits with noise f worst": lambda: percent(np.max(column(recovered("0.05"), "shape_error")), 1),
    "fits with noise values within": partial(within, "0.05", "worst_parameter_error", 0.03),
    "fits with noise worst value": lambda: max(recovered("0.05"), key=lambda row: float(row["worst_parameter_error"]))["worst_parameter"],
    "fits with noise values worst": lambda: percent(np.max(column(recovered("0.05"), "worst_parameter_error"))),
    "fits with noise as near": lambda: str(np.sum(left_of_noise() <= 1.0)),
    "fits with noise left": lambda: plain(np.max(left_of_noise()), 3),
    "fits determined": lambda: percent(np.sum(column(rows("fit_recovery"), "determined")) / np.sum(column(rows("fit_recovery"), "parameters"))),
    "blue paint": partial(blue_paint, PAPER_READING, "weidlich_wilkie, 1 layer over lambert"),
    "blue paint three layers": partial(blue_paint, GGX, "weidlich_wilkie, 3 layers over oren_nayar"),
    "blue paint to 65": partial(blue_paint, GGX, "weidlich_wilkie, 2 layers over oren_nayar", TO_65),
    "blue paint sum": partial(blue_paint, GGX, SUM),
    "blue paint sum to 65": partial(blue_paint, GGX, SUM, TO_65),
    "blue paint ggx": lambda: plain(cell("fit_blue_paint", "rms_log", model=GGX), 4),
    "blue paint sum error": lambda: plain(cell("fit_blue_paint", "rms_log", model=SUM), 4),
    "glaze in rgb, red": partial(glaze_error, "rgb_red", "amber", "5"),
    "glaze in rgb, blue": partial(glaze_error, "rgb_blue", "amber", "5"),
    "narrow glaze in rgb, blue": partial(glaze_error, "rgb_blue", "narrow yellow", "2"),
    "glaze as spectrum": partial(glaze_error, "spectrum_blue", "amber", "5"),
    "layer over paint": lambda: closures_error("smooth coat over paint", "cycles layer", "5.3"),
    "lamina over paint": lambda: closures_error("smooth coat over paint", "lamina", "all", 1),
    "film in 5.3": lambda: closures_error("film on a rough dielectric", "cycles dielectric_bsdf", "5.3", 1),
    "film by lamina": lambda: closures_error("film on a rough dielectric", "lamina", "all", 1),
    "copper under thick amber": lambda: span([float(r[f"delta_e_{tint}"]) for r in where("spectral", thickness="5") for tint in ("rgb", "tint_spectrum")], 1),
    "blue paint cloudy": lambda: plain(cell("fit_blue_paint", "rms_log", model="adding, 1 cloudy layer over lambert"), 4),
    "blue paint two cloudy": lambda: plain(cell("fit_blue_paint", "rms_log", model="adding, 2 cloudy layers over lambert"), 4),
    "blue paint asked": lambda: plain(cell("fit_blue_paint", "rms_log", model=GGX) / 1.5, 4),
})  # fmt: skip
