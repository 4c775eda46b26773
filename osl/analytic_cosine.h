// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define LEAST_COS2 1.0

// Cosine of a beam in a medium of index n; a floor keeps trapped ones finite.
float cosine(float p, float n)
{
    return sqrt(max(1.0 - (p / n) * (p / n), 0.0) + LEAST_COS2);
}
