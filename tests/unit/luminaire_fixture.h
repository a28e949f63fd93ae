/// Made-up files of luminaires.
#ifndef RSV_TEST_LUMINAIRE_FIXTURE_H
#define RSV_TEST_LUMINAIRE_FIXTURE_H

#include "resolvent/luminaire.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>
#include <math.h>

#define DEGREES (M_PI / 180)

/// A made-up distribution of type C with the wanted symmetry: 1 = in C and -C, 2 = also in C and 180 - C.
static inline double wanted_intensity(double gamma, double c, int symmetry)
{
    double around = symmetry == 3   ? 1
                    : symmetry == 2 ? 1 + 0.4 * cos(2 * c)
                    : symmetry == 1 ? 1 + 0.3 * cos(c) + 0.2 * cos(2 * c)
                                    : 1 + 0.3 * cos(c) + 0.2 * sin(c);
    return 1000 * exp(-gamma) * around * (0.3 + cos(gamma) * cos(gamma));
}

/// Range of C planes that a symmetry needs.
static inline double last_plane(int symmetry)
{
    return symmetry == 3 ? 0 : symmetry == 2 ? 90 : symmetry == 1 ? 180 : 360;
}

static inline char *write_ies(int version, int symmetry, int step)
{
    static const char *const heads[] = { "", "IESNA91\n", "IESNA:LM-63-1995\n",
        "IESNA:LM-63-2002\n[LUMINAIRE] a lamp\n" };
    char *text = NULL;
    size_t length = 0;
    FILE *s = open_memstream(&text, &length);
    assert_non_null(s);
    int planes = (int)(last_plane(symmetry) / 15) + 1, angles = 180 / step + 1;
    fprintf(s, "%s[TEST] x\r\nTILT=%s\r\n", heads[version],
        version == 1 ? "INCLUDE\n1\n2\n0 90\n1 .9" : "NONE");
    fprintf(s, "2 1500 2 %d %d 1 2 0.3 0.6 0\n0.9 1 40\n", angles, planes);
    for (int k = 0; k < angles; k++)
        fprintf(s, "%d%s", k * step, k % 10 == 9 ? "\r\n" : " ");
    for (int k = 0; k < planes; k++)
        fprintf(s, "\n%d", 15 * k);
    for (int j = 0; j < planes; j++)
        for (int k = 0; k < angles; k++)
            fprintf(s, "%s%.8g", k % 8 ? " " : "\n",
                wanted_intensity(k * step * DEGREES, 15 * j * DEGREES, symmetry) / 1.8);
    fputs("\n", s);
    assert_int_equal(fclose(s), 0);
    return text;
}

static inline char *write_eulumdat(int symmetry, int step)
{
    char *text = NULL;
    size_t length = 0;
    FILE *s = open_memstream(&text, &length);
    assert_non_null(s);
    static const int kinds[] = { 0, 2, 4, 1 };
    int planes = 24, angles = 180 / step + 1,
        stored = (int)(last_plane(symmetry) / 15) + (symmetry > 0);
    fprintf(s, "maker\r\n1\r\n%d\r\n%d\r\n15\r\n%d\r\n%d\r\nreport\r\na lamp\r\nn\r\nf\r\nd\r\n",
        kinds[symmetry], planes, angles, step);
    fprintf(s, "600\r\n300\r\n80\r\n500\r\n0\r\n10\r\n20\r\n10\r\n20\r\n100\r\n80\r\n1,"
               "0\r\n0\r\n1\r\n2\r\nLED\r\n3000\r\nwarm\r\n80\r\n40\r\n");
    for (int k = 0; k < 10; k++)
        fputs("0.5\r\n", s);
    for (int k = 0; k < planes; k++)
        fprintf(s, "%d\r\n", 15 * k);
    for (int k = 0; k < angles; k++)
        fprintf(s, "%d\r\n", k * step);
    for (int j = 0; j < stored; j++)
        for (int k = 0; k < angles; k++)
            fprintf(s, "%.8g\r\n",
                wanted_intensity(k * step * DEGREES, 15 * j * DEGREES, symmetry) / 3);
    assert_int_equal(fclose(s), 0);
    return text;
}

#endif
