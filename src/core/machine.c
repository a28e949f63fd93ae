#include "core.h"

#include <math.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

/// Memory limit of the container; INFINITY = none, or unknown.
static double container_memory(void)
{
    double bytes;
    FILE *file = fopen("/sys/fs/cgroup/memory.max", "r");
    if (!file) return INFINITY;
    if (fscanf(file, "%lf", &bytes) != 1) bytes = INFINITY; // "max"
    fclose(file);
    return bytes;
}

/// Memory limit of the process (ulimit -v).
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
