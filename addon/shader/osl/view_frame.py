# SPDX-License-Identifier: GPL-3.0-or-later
"""What a shader declares of the view, once: its cosine, its place in tables, and the frame of glossy lobes."""

# Statements that declare the view in tables, and what glossy lobes over it need; they call FRAME_FUNCTIONS.
FRAME_FUNCTIONS = ("bent.h", "view_place.h", "tangent.h", "incidence.h", "break_isotropy.h", "interface.h")
FRAME = (
    "vector tangent = any_tangent(N);",
    "vector side = tangential_part(I, bent_normal);",
    "vector along = incidence_tangent(side, tangent);",
)


def view(suffix: str = "", normal: str = "N") -> tuple[str, ...]:
    """The statements that declare `bent_normal` and `view_z`; they call `bent.h`."""
    return f"normal bent_normal{suffix} = bent({normal}, I, Ng);", f"float view_z{suffix} = view_cosine(bent_normal{suffix}, I);"


def table_view() -> tuple[str, ...]:
    """Those, and the statements that say where tables over the view are read; they call `view_place.h`."""
    return *view(), "int cell;", "float between;", "view_place(view_z, cell, between);"
