// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sockets and closures are in the file's working space, the model is in linear Rec.709. red, green and blue are Rec.709's primaries
// in the working space: sockets, which Blender converts with all other colors of a file. In a Rec.709 file both are exact.
color from_working(color c, color red, color green, color blue)
{
    vector r = (vector)red;
    vector g = (vector)green;
    vector b = (vector)blue;
    vector v = (vector)c;
    return max(color(dot(v, cross(g, b)), dot(r, cross(v, b)), dot(r, cross(g, v))) / dot(r, cross(g, b)), color(0.0));
}

color to_working(color c, color red, color green, color blue)
{
    return c[0] * red + c[1] * green + c[2] * blue;
}
