#include "number_text.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>

/// State of the calling thread between begin_plain and end_plain, while it uses the C locale.
typedef struct plain_locale {
    locale_t plain, before;
} plain_locale;

static plain_locale begin_plain(void)
{
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    return (plain_locale){ plain, uselocale(plain) };
}

static void end_plain(plain_locale l)
{
    uselocale(l.before);
    if (l.plain) freelocale(l.plain);
}

void rsv_number_text(char text[RSV_NUMBER_BYTES], int digits, double value)
{
    plain_locale l = begin_plain();
    snprintf(text, RSV_NUMBER_BYTES, "%.*g", digits, value);
    end_plain(l);
}

double rsv_number_value(const char *text, char **end)
{
    plain_locale l = begin_plain();
    double value = strtod(text, end);
    end_plain(l);
    return value;
}
