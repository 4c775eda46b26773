# SPDX-License-Identifier: GPL-3.0-or-later
"""What a shader declares of the view, once for each normal: its cosine, its place in tables, and the frame of glossy lobes."""

from collections.abc import Sequence
from dataclasses import dataclass

from ....reference_py.material.place import Place
from ..inputs import normal_input

# Files that the statements of a `Frame` call, but for its own normal's.
FRAME_FUNCTIONS = ("bent.h", "view_place.h", "tangent.h", "incidence.h", "break_isotropy.h", "interface.h")


@dataclass(frozen=True)
class Frame:
    """A normal: the surface's, or the own one of the element whose shader parameters begin with `owner`.

    Its variables are `normal`, and "bent_normal", "view_z", "cell", "between", "tangent", "side" and "along" with `suffix`.
    """

    owner: str = ""

    @classmethod
    def of(cls, place: Place | None, owners: Sequence[str]) -> "Frame":
        """That of a lobe about the own normal at a place, or the surface's."""
        return cls() if place is None else cls(normal_input(place, owners).owner)

    @property
    def suffix(self) -> str:
        return f"_{self.owner}" if self.owner else ""

    @property
    def normal(self) -> str:
        return f"normal{self.suffix}" if self.owner else "N"

    @property
    def functions(self) -> tuple[str, ...]:
        """The file that an own normal calls."""
        return ("own_normal.h",) if self.owner else ()

    @property
    def view(self) -> tuple[str, ...]:
        """The statements that declare the normal, as Cycles bends it too, and the view's cosine to it."""
        own = [f"normal {self.normal} = own_normal({self.owner}Normal, N);"] if self.owner else []
        bent = f"normal bent_normal{self.suffix} = bent({self.normal}, I, Ng);"
        return *own, bent, f"float view_z{self.suffix} = view_cosine(bent_normal{self.suffix}, I);"

    @property
    def table_view(self) -> tuple[str, ...]:
        """Those, and the statements that say where tables over the view are read."""
        s = self.suffix
        return *self.view, f"int cell{s};", f"float between{s};", f"view_place(view_z{s}, cell{s}, between{s});"

    @property
    def glossy(self) -> tuple[str, ...]:
        """What glossy lobes need besides."""
        s = self.suffix
        return (
            f"vector tangent{s} = any_tangent({self.normal});",
            f"vector side{s} = tangential_part(I, bent_normal{s});",
            f"vector along{s} = incidence_tangent(side{s}, tangent{s});",
        )

    def tilted(self, slope: str) -> str:
        """The normal of a lobe that is tilted by a slope times the sine of the view, and the direction along the plane of incidence."""
        return f"normalize(bent_normal{self.suffix} + {slope} * side{self.suffix}), along{self.suffix}"
