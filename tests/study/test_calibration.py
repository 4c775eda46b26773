# SPDX-License-Identifier: GPL-3.0-or-later
"""What finds constants: it recovers what made its data, the committed ones are what it finds, and a file is changed in nothing else."""

from pathlib import Path

import numpy as np
import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import cost
from lamina.study import calibrate_analytic, calibrate_cost
from lamina.study.calibrate_analytic import Case, best_on, fit, in_force
from lamina.study.constants_file import read_constants, write_constants
from lamina.study.random_stacks import hard_stacks, plain_stacks
from lamina.study.suite import suite

COMMITTED = {name: read_constants(calibrate_analytic.FILE)[name] for name in calibrate_analytic.PLAIN}


def scaled(values, factors):
    """Constants off by factors, in the logarithm or logit that the solver sees."""
    return calibrate_analytic.from_numbers(calibrate_analytic.to_numbers(values) + np.log(factors))


def worst(cases, values):
    with in_force(values):
        return max(float(np.max(np.abs(case.errors()))) for case in cases)


def test_stacks_are_those_of_their_seed():
    def texts(seed):
        rng = np.random.default_rng(seed)
        return [stack.to_json() for stack in (*plain_stacks(rng, 20), *hard_stacks(rng, 20))]

    assert texts(3) == texts(3)
    assert not set(texts(3)) & set(texts(4))
    counts = [len(stack.layers) for stack in (*plain_stacks(np.random.default_rng(3), 20), *hard_stacks(np.random.default_rng(3), 20))]
    assert set(counts[:20]) == {1, 2} and set(counts[20:]) == {3, 4, 5, 6}


def test_constants_become_numbers_and_come_back():
    back = calibrate_analytic.from_numbers(calibrate_analytic.to_numbers(COMMITTED))
    assert {name: type(value) for name, value in back.items()} == {name: type(value) for name, value in COMMITTED.items()}
    for name, value in back.items():
        assert value == pytest.approx(COMMITTED[name], rel=1e-12)


def test_constants_in_force_are_used_and_then_gone():
    case = Case(hard_stacks(np.random.default_rng(5), 1)[0], truth=np.ones((4, 3)))
    before = case.albedo()
    with pytest.raises(ZeroDivisionError), in_force(scaled(COMMITTED, 1.5)):
        assert np.max(np.abs(case.albedo() - before)) > 1e-3
        raise ZeroDivisionError
    assert np.array_equal(case.albedo(), before)


def test_the_fit_finds_what_made_its_data():
    """Data of the tier itself with three other constants, which come back, and with them the albedos of stacks that were not fitted."""
    made_with = {"LOBE_SPREAD": 1.2, "REMIX_SCALE": 0.2, "BASE_LOSS": 0.2}
    stacks = plain_stacks(np.random.default_rng(11), 7)
    with in_force(made_with):
        truths = [Case(stack, truth=np.ones((len(calibrate_analytic.THETA_DEG), 3))).albedo() for stack in stacks]
    cases = [Case(stack, truth=truth) for stack, truth in zip(stacks, truths)]
    assert worst(cases[:5], {}) > 0.05
    found = fit(cases[:5], COMMITTED, names=tuple(made_with), pull=0.0)
    assert found == pytest.approx(made_with, rel=1e-3)
    assert worst(cases[5:], found) < 1e-4


# Stacks of the suite whose errors the constants decide and whose truth takes little time.
DECIDED = (
    "gold_coat_0_1_metal_0_1", "copper_coat_0_02_metal_0_3", "silver_coat_0_2_metal_0_4", "titanium_coat_0_1_metal_0", "copper_1_5_0_3_over_1_8_0",
    "copper_1_8_0_3_over_1_33_0", "copper_1_33_0_1_over_1_5_0_5", "copper_1_5_0_5_over_1_33_0_1", "car_paint_red_smooth", "plastic_tinted_deep",
)  # fmt: skip


def test_no_constant_is_better_doubled_or_halved():
    """As errors count in the fit: 4 % is what the best of 56 changes gains on these few (printed), 10 % is asked."""
    cases = [Case(suite()[name]) for name in DECIDED]

    def size(values):
        with in_force(values):
            return float(np.mean([np.abs(case.errors()) ** 4 for case in cases]) ** 0.25)

    count = len(calibrate_analytic.to_numbers(COMMITTED))
    others = [size(scaled(COMMITTED, np.exp(sign * np.log(2.0) * row))) for row in np.eye(count) for sign in (1.0, -1.0)]
    print(f"{size(COMMITTED):.4f}, best of the others {min(others):.4f}")
    assert size(COMMITTED) <= 1.1 * min(others)


def test_the_lowest_point_of_a_curve():
    grid = np.geomspace(0.1, 10.0, 9)
    assert best_on(grid, lambda v: (np.log(v) - np.log(1.3)) ** 2) == pytest.approx(1.3, rel=1e-9)


def test_the_cost_fit_finds_what_made_its_data():
    rng = np.random.default_rng(3)
    made_with = dict(zip(cost.PARTS, rng.uniform(0.05, 2.0, len(cost.PARTS))))
    rows = []
    for i in range(40):
        counts = dict(zip(cost.PARTS, [1, *map(int, rng.integers(0, 4, len(cost.PARTS) - 1))]))
        rows.append(calibrate_cost.Row(str(i), counts, sum(made_with[part] * count for part, count in counts.items())))
    assert calibrate_cost.fit(rows) == pytest.approx(made_with, rel=1e-4)


def test_the_measured_table_gives_the_committed_costs_of_closures():
    """To .05 of a glossy node, and the estimate is good to 20 % for every material without layers' arithmetic (worst 12 %, printed)."""
    rows = calibrate_cost.read_rows()
    found = calibrate_cost.fit(rows)
    closures = ("object", "lit", "diffuse", "mirror", "glossy")
    assert [found[part] for part in closures] == pytest.approx([cost.PARTS[part] for part in closures], abs=0.05)
    plain = [row for row in rows if not any(count for part, count in row.parts.items() if part not in closures)]
    off = np.abs(calibrate_cost.errors(plain, cost.PARTS))
    print(f"{len(plain)} materials, median {np.median(off):.3f}, worst {np.max(off):.3f}")
    assert len(plain) == 30 and np.max(off) < 0.2


# Live methods of `lamina chart pareto` whose estimate is off by more than the quarter that it is good to: (estimated, measured). A bare metal counts as
# one glossy lobe, without what its weight takes; what a layer takes depends on its values.
BEYOND = {"clean_copper, analytic": (1.05, 1.529)}


def test_known_misses_of_the_estimate_are_those_stated():
    rows = calibrate_cost.pareto_rows()
    off = np.abs(calibrate_cost.errors(rows, cost.PARTS))
    found = {
        row.name: (sum(cost.PARTS[part] * count for part, count in row.parts.items()), row.cost) for row, e in zip(rows, off) if e > calibrate_cost.GOOD_TO
    }
    assert found == {name: pytest.approx(figures) for name, figures in BEYOND.items()}
    assert len(rows) == 12


def test_a_table_of_other_parts_is_refused(tmp_path: Path):
    table = tmp_path / "cost_fit.csv"
    with pytest.raises(LaminaError, match="--measure"):
        calibrate_cost.read_rows(table)
    table.write_text("# x\nmaterial,object,cost\na,1,1.0\n", encoding="utf-8")
    with pytest.raises(LaminaError, match="weidlich_wilkie_layer"):
        calibrate_cost.read_rows(table)


def test_no_part_costs_less_than_nothing():
    none = dict.fromkeys(cost.PARTS, 0)
    rows = [calibrate_cost.Row("a", none | {"object": 1}, 1.0), calibrate_cost.Row("b", none | {"object": 1, "diffuse": 1}, 0.9)]
    found = calibrate_cost.fit(rows)
    assert found["diffuse"] == 0.0 and 0.9 < found["object"] <= 1.0


def test_constants_are_written_in_their_place_alone(tmp_path: Path):
    file = tmp_path / "constants.py"
    text = '"""A = 1"""\nA = 1.0  # kept\nB, C = 2.0, (3.0, 4.0)\n"""ä"""\nD = {\n    "x": 1.0,\n    "y": 2.0,\n}\nname = 5.0\n'
    file.write_text(text, encoding="utf-8")
    assert read_constants(file) == {"A": 1.0, "B": 2.0, "C": (3.0, 4.0), "D.x": 1.0, "D.y": 2.0}
    write_constants(file, {"A": 1.23456, "C": (30.0, 4e-7), "D.y": 2.5})
    assert file.read_text(encoding="utf-8") == text.replace("A = 1.0 ", "A = 1.235 ").replace("(3.0, 4.0)", "(30.0, 4e-07)").replace('"y": 2.0', '"y": 2.5')
    with pytest.raises(LaminaError, match="E"):
        write_constants(file, {"A": 7.0, "E": 1.0})
    assert "A = 1.235 " in file.read_text(encoding="utf-8")
