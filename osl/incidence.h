// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The part of a direction in the plane of the normal: as long as the sine of the two.
vector tangential_part(vector w, normal n)
{
    return w - dot(n, w) * n;
}

// Along it; at the normal any direction will do, and is `otherwise`.
vector incidence_tangent(vector side, vector otherwise)
{
    return dot(side, side) > 1e-12 ? normalize(side) : otherwise;
}
