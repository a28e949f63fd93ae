/// Output of `resolvent info` for luminaire files.
#ifndef CLI_LUMINAIRE_INFO_H
#define CLI_LUMINAIRE_INFO_H

#include "session.h"

/// Whether the file's name says that it is one: .ies or .ldt.
bool cli_is_luminaire(const char *path);

/// Prints it, as text or JSON. Prints errors on standard error.
bool cli_print_luminaire(cli_session *session, const char *path, bool json);

#endif
