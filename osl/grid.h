// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tables over the view at even knots of live parameters. The knot below a place and the way to the next; of a color each
// channel has its own.
void grid_place(float place, int count, output int cell, output float along)
{
    float at = clamp(place, 0.0, count - 1.0);
    cell = min((int)at, count - 2);
    along = at - cell;
}

void grid_place(color place, int count, output int cell[3], output float along[3])
{
    for (int c = 0; c < 3; ++c)
        grid_place(place[c], count, cell[c], along[c]);
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
