/// What `resolvent info` says of a file of a luminaire.
#ifndef CLI_LUMINAIRE_INFO_H
#define CLI_LUMINAIRE_INFO_H

#include "session.h"

/// Whether the file's name says that it is one: .ies or .ldt.
bool cli_is_luminaire(const char *path);

/// Prints it, as text or JSON; says what went wrong on standard error.
bool cli_print_luminaire(cli_session *session, const char *path, bool json);

#endif
