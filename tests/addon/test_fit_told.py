# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command `fit` says of values that a highlight hides."""

import json

import numpy as np
import pytest
from support import measured
from support.stacks import conductor, stack

from lamina.addon.cli.main import run
from lamina.reference_py.fit.measurement import spread_pairs
from lamina.reference_py.models import make_model


@pytest.mark.parametrize("dim, warned", [(0.004, True), (0.0, False)])
def test_a_dim_color_that_no_metal_has_is_warned_of(tmp_path, capsys, dim, warned):
    """A highlight of alpha .05 over a color of .004/sr: metal alone meets the former, and the error says nothing of the latter."""
    wi, wo = spread_pairs(150, np.random.default_rng(0))
    metal = make_model("weidlich_wilkie", stack(base=conductor(0.2, 3.9, 0.05))).f(wo, wi)
    path = tmp_path / "gloss.csv"
    path.write_text(measured.table_text(wi, wo, metal + dim))
    assert run(["fit", str(path), "--model", "weidlich_wilkie", "--layers", "0", "--base", "conductor", "--samples", "60", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    print(told["error"], told["warnings"])
    assert told["explains"]
    lines = [line for line in err.splitlines() if "warning: " in line]
    assert len(lines) == len(told["warnings"]) == warned
    assert not warned or "off by more than a factor of two" in lines[0] and told["warnings"][0] in lines[0]
