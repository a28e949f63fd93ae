#include "core.h"

#include <math.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

/// What a container allows its programs; INFINITY = no limit, or none that is known.
static double container_memory(void)
{
    double bytes;
    FILE *file = fopen("/sys/fs/cgroup/memory.max", "r");
    if (!file) return INFINITY;
    if (fscanf(file, "%lf", &bytes) != 1) bytes = INFINITY; // "max"
    fclose(file);
    return bytes;
}

/// What a limit of the shell (ulimit -v) allows this process.
static double limited_memory(void)
{
    struct rlimit limit;
    bool is_limited = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
    return is_limited ? (double)limit.rlim_cur : INFINITY;
}

double rsv_machine_memory(void)
{
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    double bytes = pages > 0 && page > 0 ? (double)pages * (double)page : INFINITY;
    return fmin(fmin(bytes, container_memory()), limited_memory());
}
