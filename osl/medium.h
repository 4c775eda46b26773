// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define TINT_FLOOR 1.0

// Optical depth of one perpendicular crossing: tint^thickness is what it leaves of white light (Weidlich and Wilkie 2007, eq. 5).
// The floor keeps a black tint finite.
color optical_depth(color tint, float thickness)
{
    return -log(max(tint, color(TINT_FLOOR))) * thickness;
}
