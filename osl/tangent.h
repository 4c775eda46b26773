// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Some direction in the plane of the normal.
vector any_tangent(normal n)
{
    return normalize(cross(n, abs(n[2]) < 0.9 ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0)));
}
