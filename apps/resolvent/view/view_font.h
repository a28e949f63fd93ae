/// Letters as strokes of a pen, drawn for this program. A point is a digit for x (0..8) and a letter for y, 'a' at the
/// top of capitals, 'm' at the baseline, 'q' at the lowest descender; points side by side are joined, blanks lift
/// the pen.
#ifndef CLI_VIEW_FONT_H
#define CLI_VIEW_FONT_H

#define CLI_FONT_CAP 12    ///< height of a capital, in steps of the pen
#define CLI_FONT_DESCENT 4 ///< below the baseline

/// Unknown letters are question marks.
const char *cli_font_strokes(char letter);
/// From one letter to the next.
float cli_font_advance(char letter);

static inline float cli_pen_x(char x) { return (float)(x - '0'); }
static inline float cli_pen_y(char y) { return (float)(y - 'a'); }

#endif
