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

/// The address sanitizer forbids reading the gaps between constants.
__attribute__((no_sanitize_address)) static void copy(
    uint8_t *to, const volatile uint8_t *from, size_t bytes)
{
    for (size_t k = 0; k < bytes; k++)
        to[k] = from[k];
}

static void add_segment(rsv_sha256 *hash, const uint8_t *begin, size_t bytes)
{
    uint8_t piece[4096];
    for (size_t at = 0; at < bytes; at += sizeof piece) {
        size_t length = bytes - at < sizeof piece ? bytes - at : sizeof piece;
        copy(piece, begin + at, length);
        rsv_sha256_add(hash, piece, length);
    }
}

/// Read-only segments are the same in memory and in the file.
static int add_object(struct dl_phdr_info *object, size_t bytes, void *user)
{
    (void)bytes;
    if (!holds(object, (uintptr_t)rsv_program_digest)) return 0;
    for (int k = 0; k < object->dlpi_phnum; k++) {
        const ElfW(Phdr) *segment = &object->dlpi_phdr[k];
        if (segment->p_type == PT_LOAD && !(segment->p_flags & PF_W))
            add_segment(user, (const uint8_t *)(object->dlpi_addr + segment->p_vaddr), // NOLINT
                segment->p_filesz);
    }
    return 1;
}

void rsv_program_digest(char *digits)
{
    rsv_sha256 hash = rsv_sha256_begin();
    dl_iterate_phdr(add_object, &hash);
    rsv_sha256_end(&hash, digits);
}
