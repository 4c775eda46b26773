# SPDX-License-Identifier: GPL-3.0-or-later
"""Are tests able to fail? Puts one fault at a time into a copy of the tree, and runs the tests that must see it.

    tests/deliberate_faults.py [WORD]    # of faults whose name has the word; `make faults` for all

Prints what was caught and what survived. Exits with 1 where one survives or no longer can be put in. A fault is a line of
`FAULTS`; whoever finds one that no test sees adds it there, with its test.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# What no test of `FAULTS` reads, or would be another version's.
LEFT_OUT = (".*", "__pycache__", "build", "dist", "demo_blend", "scenes", "*.png", "*.blend")


@dataclass(frozen=True)
class Fault:
    """`old` stands once in `file` and becomes `new`; each of `tests` fails then."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


MEASURE = "reference_py/optics/error_measure.py"
AUTO, ESTIMATE, COST = "reference_py/lobes/methods/auto.py", "reference_py/lobes/error_estimate.py", "reference_py/lobes/methods/cost.py"
PATCHES, CACHE, METHODS = "reference_py/lobes/patch_lobes.py", "reference_py/lobes/cache.py", "reference_py/lobes/methods/__init__.py"
PAPER, MICROFACET, FILM = "reference_py/models/weidlich_wilkie.py", "reference_py/optics/microfacet.py", "reference_py/optics/thin_film.py"
OF_AUTO, OF_ERROR, OF_COST = (f"tests/reference_py/test_{name}.py::" for name in ("auto", "error_estimate", "cost"))
OF_PATCHES, OF_CACHE = "tests/reference_py/test_patch_lobes.py::", "tests/reference_py/test_cache.py::"
OF_CAVITIES, OF_FILM = "tests/reference_py/test_v_cavities.py::", "tests/reference_py/test_thinnest_film.py::"
OF_WARNING, OF_PAPER = "tests/reference_py/test_fit_warnings.py::", "tests/reference_py/test_weidlich_wilkie.py::"

OF_BRUSHED = "tests/reference_py/test_brushed_bakes.py::test_"
OF_EXCHANGE = "tests/reference_py/test_exchange.py::test_"

FAULTS = (
    Fault("what a conversion is compared with has no films", "reference_py/exchange/conversion.py", "truth(stack, everywhere - placed.films)", "truth(stack)",
          (f"{OF_EXCHANGE}a_film_without_a_place_counts", f"{OF_EXCHANGE}the_color_of_a_film_is_in_the_base_color_where_none_goes_out")),
    Fault("under a film of Principled a metal keeps its own color", "reference_py/exchange/conversion.py",
          "color, found = solve_near(filmed(placed.slots), wanted)", "found = filmed(placed.slots)(color)",
          (f"{OF_EXCHANGE}under_a_film_of_principled_the_base_color_is_the_nearest",)),
    Fault("what brushing does to a live bake's energy is left out", "reference_py/lobes/baked/brushed_grid.py",
          "total = level[:, None] * turns", "total = level[:, None] + 0.0 * turns",
          (f"{OF_BRUSHED}auto_follows_live_values",)),
    Fault("a base's light goes as Lambert's", "reference_py/lobes/baked/live.py", "return with_ramp(lobes) if", "return lobes if",
          ("tests/reference_py/test_diffuse_ramp.py::test_light_of_the_base_goes_where_the_truth_has_it",)),
    Fault("a metal has the curve that it was baked with", "reference_py/lobes/live_grid.py",
          "return ConductorCurve.of(stack.base)", "return curve",
          ("tests/reference_py/test_bare_metal.py::test_every_metal_of_a_texture_is_closer_than_its_own_fits",)),
    Fault("what a metal reflects more often goes as Lambert's light", "reference_py/lobes/baked/bare_metal.py", "return replace(with_ramp(grid_of(", "return replace((grid_of(",
          ("tests/reference_py/test_bare_metal.py::test_every_metal_of_a_texture_is_closer_than_its_own_fits",)),
    Fault("fits do not see what they send between the points", "reference_py/lobes/baked/fit_lobes.py", " + self.unseen(found.shape, weight, columns)", "",
          ("tests/reference_py/test_bare_metal.py::test_a_polished_metal_has_one_highlight",)),
    Fault("stock nodes have the bake of OSL without its ramp", "reference_py/lobes/tabulate.py",
          "tables = (lobe_set.stock or lobe_set).tables", "tables = lobe_set.tables",
          ("tests/reference_py/test_diffuse_ramp.py::test_stock_nodes_keep_the_fits_that_carry_the_bases_light",)),
    Fault("lobes change places along the view", "reference_py/lobes/baked/live.py", "nodes = in_one_order(nodes)", "nodes = dict(nodes)",
          ("tests/reference_py/test_live_bakes.py::test_lobes_of_a_bare_metal_do_not_change_places_along_the_view",)),
    Fault("lobes below the first knot get narrow faster than the surface", "reference_py/lobes/baked/make_grid.py",
          "np.minimum(slope, first / start) if lower and goes_on else slope", "slope",
          ("tests/reference_py/test_live_bakes.py::test_below_the_first_knot_lobes_get_narrow_no_faster_than_the_surface",)),
    Fault("auto's brushed bake stands still", AUTO, "lobe_set = baked(stack, live, DEFAULT_GLOSSY,", "lobe_set = baked(stack, (), DEFAULT_GLOSSY,",
          (f"{OF_BRUSHED}auto_follows_live_values",)),
    Fault("auto takes the dearest", AUTO, "return min(good, key=lambda t: (t[0].cost, t[0].visible))", "return max(good, key=lambda t: (t[0].cost, t[0].visible))",
          (f"{OF_AUTO}test_the_cheapest_within_the_tolerance_is_taken",)),
    Fault("auto takes the closest, whatever it costs", AUTO, "return min(good, key=lambda t: (t[0].cost, t[0].visible))", "return min(good, key=lambda t: t[0].visible)",
          (f"{OF_AUTO}test_the_cheapest_within_the_tolerance_is_taken",)),
    Fault("half as much error again is as close", AUTO, "_AS_CLOSE = 0.05", "_AS_CLOSE = 0.5",
          (f"{OF_AUTO}test_where_none_is_good_enough_the_cheapest_of_the_closest_is_taken",)),
    Fault("bakes go on though one is good enough", AUTO, "if least <= tolerance:", "if least <= 0.0:",
          (f"{OF_AUTO}test_the_cheapest_within_the_tolerance_is_taken",)),
    Fault("the albedo of the mean view", AUTO, "float(np.max(errors.albedo)), *means", "float(np.mean(errors.albedo)), *means",
          (f"{OF_AUTO}test_errors_are_the_worst_albedo_and_the_mean_soft_light",)),
    Fault("soft light left out of what is chosen by", "reference_py/lobes/made.py", "return max(self.albedo, self.soft_light)", "return self.albedo",
          (f"{OF_AUTO}test_the_cheapest_within_the_tolerance_is_taken", f"{OF_AUTO}test_what_people_read_of_a_candidate_is_the_worse_of_both_errors")),
    Fault("a lobe costs twice", COST, '"glossy": 0.2,', '"glossy": 0.4,', (f"{OF_COST}test_costs_of_lobes_are_those_measured",)),
    Fault("live layers are folded", COST, "folds = not live and", "folds =", (f"{OF_COST}test_everything_that_a_shader_has_costs",)),
    Fault("layers over metals cost as those over paint", COST, "isinstance(lobe_set.base, ConductorBase)", "False",
          (f"{OF_COST}test_costs_of_coated_stacks_are_those_measured",)),
    Fault("lights are sampled for mirrors", COST, "int(mirror < len(lobes))", "1",
          (f"{OF_COST}test_a_mirror_alone_costs_half_as_no_lights_are_sampled_for_it", f"{OF_COST}test_parts_are_those_of_the_materials_that_were_measured")),
    Fault("soft light left out of the estimate", ESTIMATE, "return float(max(np.max(self.albedo), np.mean(self.soft_light)))", "return float(np.max(self.albedo))",
          (f"{OF_ERROR}test_the_error_that_is_seen_is_the_worse_of_the_worst_albedo_and_the_mean_soft_light",
           f"{OF_ERROR}test_light_on_the_wrong_side_is_seen_though_the_albedo_is_right")),
    Fault("soft lights are not measured", ESTIMATE, "soft = worst_share(", "soft = 0.0 * worst_share(",
          (f"{OF_ERROR}test_too_much_or_too_little_everywhere_is_all_three_errors",)),
    Fault("soft lights leave gaps", ESTIMATE, "SOFT_LIGHT_DEG = 40.0", "SOFT_LIGHT_DEG = 4.0",
          (f"{OF_ERROR}test_too_much_or_too_little_everywhere_is_all_three_errors",)),
    Fault("soft lights are three times as wide", ESTIMATE, "SOFT_LIGHT_DEG = 40.0", "SOFT_LIGHT_DEG = 120.0",
          (f"{OF_ERROR}test_light_on_the_wrong_side_is_seen_though_the_albedo_is_right",)),
    Fault("too bright makes up for too dark", ESTIMATE, "np.sum(np.abs(self._lights @ gap), axis=(1, 2))", "np.abs(np.sum(self._lights @ gap, axis=(1, 2)))",
          (f"{OF_ERROR}test_light_on_the_wrong_side_is_seen_though_the_albedo_is_right",)),
    Fault("views crowd at a ball's middle", ESTIMATE, "np.sqrt(1.0 - (np.arange(_PIXELS) + 0.5) / _PIXELS)", "1.0 - 0.5 * (np.arange(_PIXELS) + 0.5) / _PIXELS",
          (f"{OF_ERROR}test_views_split_a_balls_pixels_evenly",)),
    Fault("patches' shares are forgotten", PATCHES, "weight=patch.share * np.asarray(lobe.weight)", "weight=np.asarray(lobe.weight)",
          (f"{OF_PATCHES}test_energy_is_the_patches_mean", f"{OF_PATCHES}test_a_coat_on_a_quarter_of_a_grey_surface")),
    Fault("of equal lobes the last is kept", PATCHES, "weight=other.weight + lobe.weight", "weight=lobe.weight",
          (f"{OF_PATCHES}test_lobes_that_differ_in_weight_alone_are_one", f"{OF_PATCHES}test_energy_is_the_patches_mean")),
    Fault("lobes of other widths are one", PATCHES, "shapes = ((a.alpha_x, b.alpha_x), ", "shapes = (", (f"{OF_PATCHES}test_lobes_that_differ_in_anything_else_stay_two",)),
    Fault("the error of the best patch", "reference_py/lobes/methods/summary.py", "return max(part.choice.shown(osl).visible", "return min(part.choice.shown(osl).visible",
          (f"{OF_PATCHES}test_error_is_the_worst_patchs_and_cost_the_dearests",)),
    Fault("live values by the whole stack's numbers", METHODS, "in map(patch.place, options.live) if", "in options.live if",
          (f"{OF_PATCHES}test_keys_are_those_of_the_patches_with_their_own_layers_numbers",)),
    Fault("bakes of another version are used", CACHE, "(_code() + key)", "key", (f"{OF_CACHE}test_what_another_version_computed_is_not_used",)),
    Fault("two digits are the same content", CACHE, 'f"{value:.5g}"', 'f"{value:.2g}"', (f"{OF_CACHE}test_what_changes_the_light_is_another_content",)),
    Fault("a layer's thickness is lost where truths are asked at once", "reference_py/lobes/baked/side_by_side.py", "float) ** thickness)", "float))",
          ("tests/reference_py/test_grid_energies.py::test_truths_side_by_side_are_those_of_each_alone",)),
    Fault("curves through energies have straight ends", "reference_py/lobes/baked/grid_energies.py", "= 1.0, -2.0, 1.0", "= 1.0, 0.0, 0.0",
          ("tests/reference_py/test_grid_energies.py::test_curves_through_cubics_are_these",)),
    Fault("live values make other bakes", CACHE, "None if name in ALWAYS_LIVE or Place(i, name) in live else", "None if name in ALWAYS_LIVE else",
          (f"{OF_CACHE}test_of_live_values_only_that_they_are_live_counts",)),
    Fault("the newest files go first", CACHE, "key=lambda one: one[1].st_mtime)", "key=lambda one: -one[1].st_mtime)",
          (f"{OF_CACHE}test_the_oldest_go_first",)),
    Fault("a kept choice keeps another stack's values", AUTO, "choice.lobe_set.with_values_of(stack), f", "choice.lobe_set, f",
          (f"{OF_CACHE}test_a_chosen_live_method_is_made_of_the_stack_that_asks",)),
    Fault("an error of the mean channel", MEASURE, "np.max(apart", "np.mean(apart",
          ("tests/reference_py/test_error_measure.py::test_worst_channel_is_told_and_a_black_one_is_not_divided_by",)),
    Fault("V cavities of factor 1.9", MICROFACET, "2.0 * cos_m * np.minimum", "1.9 * cos_m * np.minimum",
          (f"{OF_CAVITIES}test_the_factor_is_what_rays_see_of_a_groove", f"{OF_CAVITIES}test_equation_1_with_its_factor", f"{OF_CAVITIES}test_out_of_the_plane")),
    Fault("V cavities block the upper direction", MICROFACET, "np.minimum(cos_i, cos_o) / safe", "np.maximum(cos_i, cos_o) / safe",
          (f"{OF_CAVITIES}test_the_factor_is_what_rays_see_of_a_groove",)),
    Fault("films from 20 nm on", FILM, "THINNEST_NM = 0.1", "THINNEST_NM = 20.0",
          (f"{OF_FILM}test_a_tenth_of_a_nanometre_is_the_thinnest_film", f"{OF_FILM}test_a_film_comes_gradually",
           f"{OF_FILM}test_thin_films_reflect_as_airy_says")),
    Fault("films are met once", FILM, "path = 2.0 * ior", "path = 1.0 * ior", (f"{OF_FILM}test_thin_films_reflect_as_airy_says",)),
    Fault("no warning of hidden values", "reference_py/fit/outcome.py", "if share <= _HIDDEN_SHARE:", "if share <= 1.0:",
          (f"{OF_WARNING}test_a_color_that_is_off_beside_a_highlight_is_warned_of", f"{OF_WARNING}test_a_twentieth_of_the_values_is_worth_a_warning")),
    Fault("the command keeps warnings to itself", "addon/cli/fit.py", 'for warning in result["warnings"]:', "for warning in ():",
          ("tests/addon/test_fit_told.py::test_a_dim_color_that_no_metal_has_is_warned_of",)),
    Fault("bright values are hidden", "reference_py/fit/metric.py", "dim = (m.f * self._scale < FLOOR) & (m.f > _DARK)", "dim = m.f > _DARK",
          (f"{OF_WARNING}test_nothing_is_hidden_where_nothing_is_bright",)),
    Fault("a value of 8 % error is determined", "reference_py/fit/certainty.py", "OF_VALUE = 0.05", "OF_VALUE = 0.08",
          ("tests/reference_py/test_certainty.py::test_a_twentieth_of_a_value_is_the_most_that_is_determined",)),
    Fault("no value is ever undetermined", "reference_py/fit/certainty.py", "known = spread <= OF_VALUE * np.abs(values)", "known = spread >= 0.0",
          ("tests/reference_py/test_fit.py::test_what_data_do_not_determine_is_named",)),
    Fault("eq. 4 compensates nothing", PAPER, "t21 = (1.0 - g) + t21 * g", "t21 = t21 * g", (f"{OF_PAPER}test_compensation_is_equation_4",)),
    Fault("eq. 6 counts one way twice", PAPER, "(1.0 / cos_i + 1.0 / cos_o)", "(2.0 / cos_i)", (f"{OF_PAPER}test_clear_interface_leaves_absorption_alone",)),
)  # fmt: skip


def put_in(fault: Fault, tree: Path) -> str:
    """Put a fault into a tree; the file's text before. Raises ValueError where its old text does not stand there once."""
    path = tree / fault.file
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if text.count(fault.old) != 1:
        raise ValueError(f"{fault.old!r} stands {text.count(fault.old)} times in {fault.file}, not once")
    path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    return text


def run(tests: tuple[str, ...], tree: Path) -> subprocess.CompletedProcess:
    """Run tests of a tree, as `lamina` in the folder that it is in."""
    # bytecode is known by second and length, which a fault may share with what was there
    environment = {**os.environ, "PYTHONPATH": str(tree.parent), "PYTHONDONTWRITEBYTECODE": "1", "LAMINA_THOROUGH": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests]
    return subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True)


def verdict(fault: Fault, tree: Path) -> str:
    """What became of a fault: "caught", or what is wrong. The tree is left as it was."""
    try:
        text = put_in(fault, tree)
    except ValueError as error:
        return str(error)
    # one by one, as each must see it
    codes = {test: run((test,), tree).returncode for test in fault.tests}
    (tree / fault.file).write_text(text, encoding="utf-8")
    wrong = [f"{test} {'passes' if code == 0 else f'does not run (pytest says {code})'}" for test, code in codes.items() if code != 1]
    return f"SURVIVED: {', '.join(wrong)}" if wrong else "caught"


def main(word: str = "") -> int:
    faults = [fault for fault in FAULTS if word in fault.name]
    if not faults:
        print(f"no fault's name has {word!r}; choose a word of: {', '.join(fault.name for fault in FAULTS)}")
        return 2
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "lamina"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*LEFT_OUT))
        sound = run(tuple(dict.fromkeys(test for fault in faults for test in fault.tests)), tree)
        if sound.returncode != 0:
            print(sound.stdout + sound.stderr + "\ntests fail without a fault: nothing can be told")
            return 2
        caught = 0
        for fault in faults:
            found = verdict(fault, tree)
            caught += found == "caught"
            print(f"{fault.name:48} {found}", flush=True)
    print(f"{caught} of {len(faults)} caught")
    return 0 if caught == len(faults) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
