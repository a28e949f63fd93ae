#include "number_text.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>

void rsv_number_text(char text[RSV_NUMBER_BYTES], int digits, double value)
{
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0), before = uselocale(plain);
    snprintf(text, RSV_NUMBER_BYTES, "%.*g", digits, value);
    uselocale(before);
    if (plain) freelocale(plain);
}

double rsv_number_value(const char *text, char **end)
{
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0), before = uselocale(plain);
    double value = strtod(text, end);
    uselocale(before);
    if (plain) freelocale(plain);
    return value;
}
