// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tables over the view at knots of live parameters. The knot below a value, and the way to the next: less than 0 below
// the first, at most 1. Of a color each channel has its own, and none is less than 0.
void knot_place(float knots[], int count, float value, output int cell, output float along)
{
    cell = 0;
    for (int k = 1; k < count - 1; ++k)
        cell += value >= knots[k];
    along = min((value - knots[cell]) / (knots[cell + 1] - knots[cell]), 1.0);
}

void knot_place(float knots[], int count, color value, output int cell[3], output float along[3])
{
    for (int c = 0; c < 3; ++c) {
        knot_place(knots, count, value[c], cell[c], along[c]);
        along[c] = max(along[c], 0.0);
    }
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

color grid(color table[], int at[3], int step, float along[3], float between)
{
    color red = grid(table, at[0], step, along[0], between);
    color green = grid(table, at[1], step, along[1], between);
    color blue = grid(table, at[2], step, along[2], between);
    return color(red[0], green[1], blue[2]);
}

color grid(color table[], int at[3], int step, int second_step, float along[3], float second_along[3], float between)
{
    color red = grid(table, at[0], step, second_step, along[0], second_along[0], between);
    color green = grid(table, at[1], step, second_step, along[1], second_along[1], between);
    color blue = grid(table, at[2], step, second_step, along[2], second_along[2], between);
    return color(red[0], green[1], blue[2]);
}

float mean_of(color value)
{
    return (value[0] + value[1] + value[2]) / 3.0;
}
