// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define KNOTS 2

// Where tables over the view, even in the root of its cosine, are read: the knot below, and the way to the next.
void view_place(float view_z, output int cell, output float between)
{
    float place = sqrt(view_z) * (KNOTS - 1);
    cell = min((int)place, KNOTS - 2);
    between = place - cell;
}
