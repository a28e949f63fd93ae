/// The reference cases: tests/validation/cases.json, or the file that the variable RSV_VALIDATION names.
#ifndef CASE_FILE_H
#define CASE_FILE_H

#include <cjson/cJSON.h>

/// Ends the program with a line that says why if the file cannot be read. Free with cJSON_Delete.
cJSON *case_file_read(void);

#endif
