#include "trial.h"

#include "../core/core_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/// What an honest importer stays far below.
#define SECONDS_AT_LEAST 10
#define BYTES_PER_SECOND 100000
#define MEMORY_AT_LEAST ((size_t)512 << 20)
#define MEMORY_PER_BYTE 200

static void limit(int resource, size_t most)
{
    struct rlimit bounds;
    if (getrlimit(resource, &bounds) != 0 || bounds.rlim_cur <= most) return;
    bounds.rlim_cur = most;
    setrlimit(resource, &bounds);
}

/// Address space in use.
static size_t space_in_use(void)
{
    size_t pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file && fscanf(file, "%zu", &pages) != 1) pages = 0;
    if (file) fclose(file);
    return pages * (size_t)sysconf(_SC_PAGESIZE);
}

/// Crashes end the copy without a core file, a report or a handler of the caller's.
static void prepare_copy(size_t bytes)
{
    static const int deadly[] = { SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGINT,
        SIGTERM };
    for (size_t k = 0; k < sizeof deadly / sizeof *deadly; k++)
        signal(deadly[k], SIG_DFL);
    int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, SECONDS_AT_LEAST + bytes / BYTES_PER_SECOND);
    size_t used = space_in_use();
    if (used) limit(RLIMIT_AS, used + MEMORY_AT_LEAST + MEMORY_PER_BYTE * bytes);
}

static rsv_status judge(int ended, const char *message)
{
    if (WIFEXITED(ended) && WEXITSTATUS(ended) == 0) return RSV_OK;
    if (WIFSIGNALED(ended)) {
        int number = WTERMSIG(ended);
        if (number == SIGINT || number == SIGTERM)
            return rsv_fail(RSV_ERROR_CANCELLED, "cancelled while reading");
        if (number == SIGXCPU || number == SIGKILL)
            return rsv_fail(RSV_ERROR_FORMAT,
                "cannot be read: it keeps the importer busy beyond all measure; is it damaged?");
    }
    if (*message) return rsv_fail(RSV_ERROR_FORMAT, "cannot be read: %s", message);
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot be read: the importer crashes on it; repair it, or convert it to glTF");
}

rsv_status rsv_trial(bool (*work)(void *user, char *message), void *user, size_t bytes)
{
    char *message = mmap(
        NULL, RSV_TRIAL_MESSAGE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (message == MAP_FAILED) return rsv_fail(RSV_ERROR_MEMORY, "out of memory");
    pid_t copy = fork();
    if (copy == 0) {
        prepare_copy(bytes);
        _exit(work(user, message) ? 0 : 1);
    }
    int ended = 0;
    while (copy > 0 && waitpid(copy, &ended, 0) < 0 && errno == EINTR) {}
    message[RSV_TRIAL_MESSAGE_BYTES - 1] = '\0';
    rsv_status status =
        copy > 0 ? judge(ended, message)
                 : rsv_fail(RSV_ERROR_MEMORY, "no process can be started: %s", strerror(errno));
    munmap(message, RSV_TRIAL_MESSAGE_BYTES);
    return status;
}
