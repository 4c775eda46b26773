// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The normal of a layer that has its own; of length 0 it is the surface's.
normal own_normal(vector own, normal n)
{
    return own == vector(0.0) ? n : normalize(own);
}
