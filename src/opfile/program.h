/// Which program this is: processes that share a job must run the same code, not just the same version of it.
#ifndef RSV_PROGRAM_H
#define RSV_PROGRAM_H

#include "sha256.h"

/// SHA-256 of the code and constants of the program, or of the library if it is a shared one.
/// @param digits [RSV_SHA256_DIGITS + 1]
void rsv_program_digest(char *digits);

#endif
