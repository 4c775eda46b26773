// SPDX-License-Identifier: GPL-3.0-or-later
// The tangent in the plane of the normal, turned about it by a share of a full turn. Any direction where there is none.
vector turned(vector direction, normal n, float turns)
{
    vector side = cross(n, direction);
    if (dot(side, side) < 1e-12)
        side = cross(n, abs(n[2]) < 0.9 ? vector(0.0, 0.0, 1.0) : vector(1.0, 0.0, 0.0));
    side = normalize(side);
    float angle = M_2PI * turns;
    return cos(angle) * cross(side, n) + sin(angle) * side;
}
