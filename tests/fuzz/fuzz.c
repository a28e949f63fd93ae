/// The entry of libFuzzer for the reader of FUZZ_EXTENSION.
#include "readers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_read(FUZZ_EXTENSION, data, size);
    return 0;
}
