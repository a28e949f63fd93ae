#include "parallel.h"

#include <pthread.h>
#include <stdatomic.h>

enum { MOST_THREADS = 256 };

typedef struct loop {
    size_t count, grain;
    void (*body)(void *job, size_t begin, size_t end);
    void *job;
    atomic_size_t next;
} loop;

static void *take_spans(void *user)
{
    loop *l = user;
    for (size_t begin; (begin = atomic_fetch_add(&l->next, l->grain)) < l->count;)
        l->body(l->job, begin, l->count - begin > l->grain ? begin + l->grain : l->count);
    return NULL;
}

void cli_parallel_for(uint32_t threads, size_t count, size_t grain,
    void (*body)(void *job, size_t begin, size_t end), void *job)
{
    loop l = { .count = count, .grain = grain, .body = body, .job = job };
    size_t spans = (count + grain - 1) / grain, started = 0;
    if (threads > spans) threads = (uint32_t)spans;
    pthread_t thread[MOST_THREADS];
    while (started + 1 < threads && started < MOST_THREADS &&
           pthread_create(&thread[started], NULL, take_spans, &l) == 0)
        started++; // where the system refuses one, there are fewer
    take_spans(&l);
    for (size_t k = 0; k < started; k++)
        pthread_join(thread[k], NULL);
}
