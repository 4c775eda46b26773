// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define LOBE_BEND 1.0

// Alpha outside of a lobe whose p has this variance: a slope m changes p by 2 cos_o m + LOBE_BEND sin_o m^2.
float lobe_alpha(float variance, float cos_o)
{
    float bend = LOBE_BEND * sqrt(1.0 - cos_o * cos_o);
    float spread = sqrt(variance);
    return min(spread / (cos_o + sqrt(cos_o * cos_o + bend * spread)), 1.0);
}
