#include "program.h"

#include <link.h>
#include <stdbool.h>

static bool holds(const struct dl_phdr_info *object, uintptr_t address)
{
    for (int k = 0; k < object->dlpi_phnum; k++) {
        const ElfW(Phdr) *segment = &object->dlpi_phdr[k];
        uintptr_t begin = object->dlpi_addr + segment->p_vaddr;
        if (segment->p_type == PT_LOAD && address >= begin && address - begin < segment->p_memsz)
            return true;
    }
    return false;
}

/// Segments that nobody writes to are in memory as they are in the file.
static int add_object(struct dl_phdr_info *object, size_t bytes, void *user)
{
    (void)bytes;
    if (!holds(object, (uintptr_t)rsv_program_digest)) return 0;
    for (int k = 0; k < object->dlpi_phnum; k++) {
        const ElfW(Phdr) *segment = &object->dlpi_phdr[k];
        if (segment->p_type == PT_LOAD && !(segment->p_flags & PF_W))
            rsv_sha256_add(
                user, (const void *)(object->dlpi_addr + segment->p_vaddr), segment->p_filesz);
    }
    return 1;
}

void rsv_program_digest(char *digits)
{
    rsv_sha256 hash = rsv_sha256_begin();
    dl_iterate_phdr(add_object, &hash);
    rsv_sha256_end(&hash, digits);
}
