// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define KNOTS 2
#define FLOOR 0.01

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

float grid_way(float value, float low, float size, float bend)
{
    return pow(clamp((value - low) / size, 0.0, 1.0), bend);
}

color grid_way(color value, float low, float size, float bend)
{
    return pow(clamp((value - low) / size, color(0.0), color(1.0)), bend);
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

float grid(float table[], int at, int step, int second_step, int third_step, float along, float second_along, float third_along, float between)
{
    float low = grid(table, at, second_step, third_step, second_along, third_along, between);
    return mix(low, grid(table, at + step, second_step, third_step, second_along, third_along, between), along);
}

color grid(color table[], int at, int step, int second_step, int third_step, float along, float second_along, float third_along, float between)
{
    color low = grid(table, at, second_step, third_step, second_along, third_along, between);
    return mix(low, grid(table, at + step, second_step, third_step, second_along, third_along, between), along);
}

// Where each channel is at a place of its own, a table has the channels of its colors as numbers, one after the other.
color grid(float table[], int at[3], int step, float along[3], float between)
{
    color result = 0.0;
    for (int c = 0; c < 3; ++c) {
        int low = 3 * at[c] + c;
        int high = low + 3 * step;
        result[c] = mix(mix(table[low], table[low + 3], between), mix(table[high], table[high + 3], between), along[c]);
    }
    return result;
}

color grid(float table[], int at[3], int step, int second_step, float along[3], float second_along[3], float between)
{
    color result = 0.0;
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 2; ++r) {
            int low = 3 * (at[c] + r * step) + c;
            int high = low + 3 * second_step;
            float value = mix(mix(table[low], table[low + 3], between), mix(table[high], table[high + 3], between), second_along[c]);
            result[c] += (r == 0 ? 1.0 - along[c] : along[c]) * value;
        }
    }
    return result;
}

color grid(float table[], int at[3], int step, int second_step, int third_step, float along[3], float second_along[3], float third_along[3], float between)
{
    int next[3];
    for (int c = 0; c < 3; ++c)
        next[c] = at[c] + step;
    color low = grid(table, at, second_step, third_step, second_along, third_along, between);
    color high = grid(table, next, second_step, third_step, second_along, third_along, between);
    return mix(low, high, color(along[0], along[1], along[2]));
}

// A sum of tables over the view, each times its coefficient; `count` colors hold three of either for every channel, or for all where steps
// from one channel to the next are 0.
color grid_modes(color table[], color coefficients[], int count, int table_step, int coefficient_step, int cell, float between)
{
    color result = 0.0;
    int channels = table_step + coefficient_step > 0 ? 3 : 1;
    for (int i = 0; i < count; ++i) {
        vector part = 0.0;
        for (int c = 0; c < channels; ++c) {
            if (c == 0 || table_step > 0) {
                int at = c * table_step + i * KNOTS + cell;
                part = (vector)mix(table[at], table[at + 1], between);
            }
            result[c] += dot(part, (vector)coefficients[c * coefficient_step + i]);
        }
    }
    return channels == 1 ? color(result[0]) : result;
}

// The energy of which a grid has the logarithm, FLOOR added.
color grid_energy(color logarithm)
{
    return max(exp(logarithm) - color(FLOOR), color(0.0));
}

float mean_of(color value)
{
    return (value[0] + value[1] + value[2]) / 3.0;
}
