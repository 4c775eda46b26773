// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "working_space.h"
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define RAMP 8

// A ramp of `diffuse_ramp` as a closure of this weight has it in the working space; in a Rec.709 file it stays.
void ramp_to_working(output color ramp[RAMP], color weight, color red, color green, color blue)
{
    if (red != color(1.0, 0.0, 0.0)) {
        color whole = max(to_working(weight, red, green, blue), color(1e-20));
        for (int k = 1; k < RAMP; ++k)
            ramp[k] = to_working(weight * ramp[k], red, green, blue) / whole;
    }
}
