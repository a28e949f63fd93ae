/// Numbers as files have them, with a point: the program that we are part of may have chosen a locale that has commas.
#ifndef RSV_NUMBER_TEXT_H
#define RSV_NUMBER_TEXT_H

#include <stddef.h>

#define RSV_NUMBER_BYTES 32 ///< enough for 17 digits, sign and exponent

/// @param digits significant digits, up to 17, which identify a double exactly
void rsv_number_text(char text[RSV_NUMBER_BYTES], int digits, double value);

/// As strtod in the C locale. @param end out: behind the number; `text` if there is none; may be NULL
double rsv_number_value(const char *text, char **end);

#endif
