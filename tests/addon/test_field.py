# SPDX-License-Identifier: GPL-3.0-or-later
"""The quick cases of the field test (tests/field): a Lamina material where it meets the rest of Blender."""

import pytest

pytest.importorskip("bpy")

from field import CASES, FAILS
from field.case import NONE, OK, Case, case
from field.trial import PAINT, Surface

from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

QUICK = [c for c in CASES.values() if c.quick and c.is_here()]


@pytest.mark.parametrize("each", QUICK, ids=lambda c: c.name)
def test_a_case_does_not_fail(blender, each: Case):
    row = each.run(always=False)
    assert row.verdict != FAILS, f"{row.lamina} | Principled: {row.principled} | {row.note}"


def judged(act, limit: str = "", beside: bool = True):
    return Case("probe", "probe", act, True, True, (4, 5), limit, "", beside).run()


def test_the_numbers_give_the_verdict(blender):
    """A case without a comparison, one that raises, a black picture and a loss that Principled does not share all fail."""
    black = Surface(Stack.from_dict({"base": {"kind": "lambert", "color": [0.0, 0.0, 0.0]}}), {"Base Color": (0.0, 0.0, 0.0, 1.0)})

    def nothing(trial):
        """Nothing."""

    def broken(trial):
        """Nothing."""
        raise ValueError("no such thing")

    def dark(trial):
        """A black picture is the same as itself."""
        trial.show(trial.material(black))
        trial.compare_pictures("picture", trial.picture(), trial.plain(black))

    def loss(trial):
        """A value that Lamina alone loses."""
        trial.compare("value", 1.0 if trial.is_lamina else 2.0, 2.0)

    def shared(trial):
        """A value that both lose."""
        trial.compare("value", 1.0, 2.0)

    assert [judged(act).verdict for act in (nothing, broken, dark, loss, shared)] == [FAILS] * 5
    assert judged(loss, limit="a limit that Principled does not have").verdict == FAILS
    assert judged(shared, limit="a limit of both").verdict == "limit"
    assert judged(shared, limit="a limit of both", beside=False).principled == NONE
    assert "no such thing" in judged(broken).lamina


def test_another_color_is_another_picture(blender):
    def act(trial):
        """Two colors of one paint."""
        trial.show(trial.material(PAINT))
        trial.compare_pictures("picture", trial.picture(), trial.plain(PAINT.with_color((0.5, 0.1, 0.05))))

    row = judged(act)
    assert row.verdict == FAILS and row.principled.startswith("WRONG")


def test_a_name_is_used_once():
    taken = next(iter(CASES))
    with pytest.raises(ValueError, match="two cases"):
        case(taken)(lambda trial: None)


def test_there_are_sixty_cases_and_ok_is_a_word():
    assert len([c for c in CASES.values() if c.is_here()]) >= 60 and OK == "ok"
