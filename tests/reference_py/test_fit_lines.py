# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit tells people: English on the command line, to the letter, and sentences that a window can tell in its own language."""

import json

from lamina.reference_py.errors import Sentence
from lamina.reference_py.fit.metric import percent
from lamina.reference_py.fit.outcome import lines
from lamina.reference_py.fit.parameters import Parameters, Structure

STRUCTURE = Structure.of(1, "conductor")
ENGLISH = """\
Qq (ggx, ggx from the top), 3 parameters, model adding
error 12.35 % over 200 pairs of directions (RMS of log f cos), 3.00 % of the reflected light (L1)
of the fitted pairs' error 5.00 % differ from pair to pair, as noise does, and 11.00 % are alike among neighbours: what such a stack cannot say (their squares add up)
by region: 0-30 deg 10.0 %, towards the light 2.6 %
  tried 0 layers over lambert      3 parameters   error 30.00 % of the 90 fitted pairs
  tried 1 layer over conductor    12 parameters   error 12.00 % of the 90 fitted pairs
  tried 2 cloudy layers over lambert  14 parameters   error 11.00 % of the 90 fitted pairs
one more layer would bring the error from 12 % to below .01 % with +4 parameters: the criterion rises by -3
  ior of layer 0                  1.5000 +- 0.0123
  red tint of layer 0            -0.2500 +- 12.0000   not determined by the data
  roughness of the base           1.0000 +- 0.0000   not determined by the data   at its bound
not determined: may be off by more than 5 %, as its standard error or fits from other starts say"""


def result() -> dict:
    names = {str(name): name for name in Parameters(STRUCTURE, 3).names}
    rows = [("ior of layer 0", 1.5, 0.0123, True, False), ("red tint of layer 0", -0.25, 12.0, False, False), ("roughness of the base", 1.0, 0.0, False, True)]
    keys = ("name", "value", "standard_error", "determined", "at_bound")
    tried = [(Structure.of(0, "lambert"), 3, 0.3), (STRUCTURE, 12, 0.12), (Structure.of(2, "lambert", cloudy=True), 14, 0.11)]
    return {
        "stack": {"name": "Qq", "layers": [{"kind": "dielectric", "distribution": "ggx"}], "base": {"kind": "conductor", "metal": "gold", "distribution": "ggx"}},
        "model": "adding", "error": 0.12345, "pairs": 200, "fitted_pairs": 90, "shape_error": 0.03, "noise": 0.05, "misfit": 0.11,
        "error_by_region": {Sentence("{low:g}-{high:g} deg", low=0.0, high=30.0): 0.1, Sentence("towards the light"): 0.026},
        "tried": [{"structure": structure.name, "parameters": count, "error": error} for structure, count, error in tried],
        "reason": Sentence(
            "one more layer would bring the error from {before} to {after} with {parameters:+d} parameters: the criterion rises by {change:.0f}",
            before=percent(0.123), after=percent(1e-6), parameters=4, change=-3.2,
        ),
        "parameters": [dict(zip(keys, (names[row[0]], *row[1:]), strict=True)) for row in rows],
        "not_determined": [row[0] for row in rows if not row[3]],
    }  # fmt: skip


def test_a_command_line_has_them_in_english():
    assert "\n".join(lines(result())) == ENGLISH


def test_a_process_keeps_their_words():
    def shout(template: str) -> str:
        return f"!{template}"

    for line in lines(result()):
        got = Sentence.unpacked(json.loads(json.dumps(line.packed())))
        assert got == line and got.told(shout) == line.told(shout) != line
    told = "\n".join(line.told(shout) for line in lines(result()))
    for part in (
        "!0-30 deg 10.0 %",
        "!towards the light",
        "!1 layer over conductor",
        "!below .01 %",
        "!!red tint of !layer 0",
        "!the base",
        "!   at its bound",
    ):
        assert part in told, part
