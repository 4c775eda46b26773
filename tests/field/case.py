# SPDX-License-Identifier: GPL-3.0-or-later
"""A case of the field test: something that an artist does, done once with a Lamina material and once with a Principled one.

A case is a function of a `Trial`. It notes what it got beside what it expected; the numbers, and not the case, give the verdict.
"""

from collections.abc import Callable
from dataclasses import dataclass

import bpy

from .trial import LAMINA, PRINCIPLED, Trial

OK, LIMIT, FAILS = "ok", "limit", "fails"
NONE = "-"  # in the column of a material for which the case means nothing
WITHOUT_OSL = ", OSL off"


@dataclass(frozen=True)
class Row:
    """A line of the table. verdict: OK; LIMIT, which the note states; or FAILS."""

    case: str
    blender: str
    lamina: str
    principled: str
    verdict: str
    note: str


@dataclass(frozen=True)
class Case:
    """A registered case. group: the module that it stands in. limit: of Blender's own; it excuses Lamina where Principled fails as well. plain: one that README states, which any stock node of the same closures has."""

    name: str
    group: str
    act: Callable[[Trial], None]
    osl: bool
    quick: bool
    least: tuple[int, int]
    limit: str
    plain: str
    beside: bool

    @property
    def told(self) -> str:
        """What is compared: the first line of the function's docstring."""
        return (self.act.__doc__ or "").strip().splitlines()[0]

    def is_here(self) -> bool:
        """Whether this Blender is new enough for it."""
        return bpy.app.version[:2] >= self.least

    def run(self, always: bool = True) -> Row:
        """Do it with both materials and judge; with Principled only where that can change the verdict, unless `always`."""
        lamina = self._tried(LAMINA)
        principled = self._tried(PRINCIPLED) if self.beside and (always or (lamina.is_wrong and self.limit)) else None
        note, verdict = self.told, OK
        if lamina.is_wrong:
            verdict = FAILS
            if lamina.stated:
                verdict, note = LIMIT, f"{note} Check says: {lamina.stated}"
            elif self.plain:
                verdict, note = LIMIT, f"{note} Limit of Blender: {self.plain}"
            elif self.limit and principled is not None and principled.is_wrong:
                verdict, note = LIMIT, f"{note} Limit of Blender: {self.limit}"
        return Row(self.name, blender(), lamina.text(), principled.text() if principled else NONE, verdict, note)

    def _tried(self, kind: str) -> Trial:
        with Trial(kind, self.osl) as trial:
            try:
                self.act(trial)
            except Exception as error:  # a case that cannot be done is a case that failed
                trial.broke(error)
        return trial


CASES: dict[str, Case] = {}


def case(name: str, *, quick: bool = True, least: tuple[int, int] = (4, 5), limit: str = "", plain: str = "", beside: bool = True, osl_off: bool = False):
    """Register the function below as a case.

    quick: under a second, so that it is also a test. least: the Blender that it needs. beside: done with Principled, too.
    plain: a limit of Blender's that every stock node of the same closures has, see README. osl_off: done a second time, as a case of its own, in a scene where Open Shading Language is off.
    """

    def register(act: Callable[[Trial], None]) -> Callable[[Trial], None]:
        group = act.__module__.rsplit(".", 1)[-1]
        for osl in (True, False) if osl_off else (True,):
            made = Case(name if osl else name + WITHOUT_OSL, group, act, osl, quick, least, limit, plain, beside)
            if made.name in CASES:
                raise ValueError(f"two cases are called {made.name!r}")
            CASES[made.name] = made
        return act

    return register


def blender() -> str:
    """The running Blender, such as "4.5"."""
    return "{}.{}".format(*bpy.app.version)
