#include "child_process.h"

#include "../core/core.h"

#include <errno.h>
#include <fcntl.h>
#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/// Limits that no working importer comes near.
#define SECONDS_AT_LEAST 10
#define BYTES_PER_SECOND 100000
#define MEMORY_AT_LEAST ((size_t)512 << 20)
#define MEMORY_PER_BYTE 200

#define MESSAGE_BYTES 400

/// Memory limit for an input of this size, including the data made from it.
static size_t most_memory(size_t bytes) { return MEMORY_AT_LEAST + MEMORY_PER_BYTE * bytes; }

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

/// Crashes end the child without a core file, a report or a handler of the caller's.
static void prepare_child(size_t bytes)
{
    static const int deadly[] = { SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGINT,
        SIGTERM, SIGPIPE };
    for (size_t k = 0; k < sizeof deadly / sizeof *deadly; k++)
        signal(deadly[k], SIG_DFL);
    // Assimp reads numbers by the locale of whose program this is
    uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
    int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, SECONDS_AT_LEAST + bytes / BYTES_PER_SECOND);
    size_t used = space_in_use();
    if (used) limit(RLIMIT_AS, used + most_memory(bytes));
}

/// The work of a child.
typedef struct child_task {
    rsv_child_work work;
    void *user;
    size_t bytes;  ///< of its input
    char *message; ///< [MESSAGE_BYTES] of its failure; shared with the caller
} child_task;

/// The child's life.
static _Noreturn void work_and_end(const child_task *task, int to)
{
    prepare_child(task->bytes);
    FILE *answer = fdopen(to, "wb");
    rsv_status status =
        answer ? task->work(task->user, answer) : rsv_fail(RSV_ERROR_MEMORY, "out of memory");
    if (status == RSV_OK && (fflush(answer) != 0 || ferror(answer)))
        status = rsv_fail(RSV_ERROR_IO, "its content cannot be passed on: %s", strerror(errno));
    if (status != RSV_OK) snprintf(task->message, MESSAGE_BYTES, "%s", rsv_last_error());
    _exit((int)status);
}

/// Reads until the child has said all.
static rsv_status collect(
    rsv_context *context, int from, size_t most, uint8_t **answer, size_t *count)
{
    enum { PIECE = 1 << 20 };
    size_t capacity = 0;
    for (;;) {
        rsv_status status = rsv_grow(context, (void **)answer, &capacity, *count + PIECE, 1);
        if (status != RSV_OK) return status;
        ssize_t got = read(from, *answer + *count, PIECE);
        if (got == 0) return RSV_OK;
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            return rsv_fail(RSV_ERROR_IO, "its content cannot be passed on: %s", strerror(errno));
        *count += (size_t)got;
        if (*count > most)
            return rsv_fail(RSV_ERROR_FORMAT,
                "cannot be read: reading it takes too much memory; is it damaged?");
    }
}

static rsv_status judge(int ended, const char *message)
{
    if (WIFEXITED(ended) && WEXITSTATUS(ended) == RSV_OK) return RSV_OK;
    if (WIFSIGNALED(ended)) {
        int number = WTERMSIG(ended);
        if (number == SIGINT || number == SIGTERM)
            return rsv_fail(RSV_ERROR_CANCELLED, "cancelled while reading");
        if (number == SIGXCPU || number == SIGKILL)
            return rsv_fail(
                RSV_ERROR_FORMAT, "cannot be read: reading it takes too long; is it damaged?");
    }
    if (WIFEXITED(ended) && WEXITSTATUS(ended) <= RSV_ERROR_DEVICE && *message)
        return rsv_fail((rsv_status)WEXITSTATUS(ended), "%s", message);
    return rsv_fail(RSV_ERROR_FORMAT,
        "cannot be read: it makes the importer crash; repair it, or convert it to glTF");
}

static rsv_status work_in_child(
    rsv_context *context, const child_task *task, uint8_t **answer, size_t *count)
{
    int way[2], ended = 0;
    if (pipe(way) != 0)
        return rsv_fail(RSV_ERROR_MEMORY, "no process can be started: %s", strerror(errno));
    pid_t child = fork();
    if (child == 0) {
        close(way[0]);
        work_and_end(task, way[1]);
    }
    close(way[1]);
    rsv_status status =
        child > 0 ? collect(context, way[0], most_memory(task->bytes), answer, count)
                  : rsv_fail(RSV_ERROR_MEMORY, "no process can be started: %s", strerror(errno));
    close(way[0]);
    if (status != RSV_OK && child > 0) kill(child, SIGKILL);
    while (child > 0 && waitpid(child, &ended, 0) < 0 && errno == EINTR) {}
    task->message[MESSAGE_BYTES - 1] = '\0';
    return status == RSV_OK ? judge(ended, task->message) : status;
}

rsv_status rsv_in_child_process(rsv_context *context, rsv_child_work work, void *user, size_t bytes,
    uint8_t **answer, size_t *count)
{
    *answer = NULL;
    *count = 0;
    char *message =
        mmap(NULL, MESSAGE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (message == MAP_FAILED) return rsv_fail(RSV_ERROR_MEMORY, "out of memory");
    const child_task task = { work, user, bytes, message };
    rsv_status status = work_in_child(context, &task, answer, count);
    munmap(message, MESSAGE_BYTES);
    if (status == RSV_OK) return RSV_OK;
    rsv_free(context, *answer);
    *answer = NULL;
    *count = 0;
    return status;
}
