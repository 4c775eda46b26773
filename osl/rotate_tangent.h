// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "tangent.h"
// The tangent in the plane of the normal, turned about it by a share of a full turn. Any direction where there is none.
vector rotate_tangent(vector direction, normal n, float turns)
{
    vector side = cross(n, direction);
    side = dot(side, side) < 1e-12 ? any_tangent(n) : normalize(side);
    float angle = M_2PI * turns;
    return cos(angle) * cross(side, n) + sin(angle) * side;
}
