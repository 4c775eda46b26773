// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tables over the view at knots of live parameters. The knot below a value, and the way to the next: less than 0 below
// the first, at most 1.
void knot_place(float knots[], int count, float value, output int cell, output float along)
{
    cell = 0;
    for (int k = 1; k < count - 1; ++k)
        cell += value >= knots[k];
    along = min((value - knots[cell]) / (knots[cell + 1] - knots[cell]), 1.0);
}

float grid(float table[], int at, int step, float along, float between)
{
    return mix(mix(table[at], table[at + 1], between), mix(table[at + step], table[at + step + 1], between), along);
}

color grid(color table[], int at, int step, float along, float between)
{
    return mix(mix(table[at], table[at + 1], between), mix(table[at + step], table[at + step + 1], between), along);
}

float grid(float table[], int at, int step, int second_step, float along, float second_along, float between)
{
    return mix(grid(table, at, second_step, second_along, between), grid(table, at + step, second_step, second_along, between), along);
}

color grid(color table[], int at, int step, int second_step, float along, float second_along, float between)
{
    return mix(grid(table, at, second_step, second_along, between), grid(table, at + step, second_step, second_along, between), along);
}
