/// Loops on threads that the program already has: a pool of three, and as many tasks as the library likes.
#include <resolvent/resolvent.h>

#include <pthread.h>
#include <stdio.h>
#include <string.h>

enum { THREADS = 3 };

typedef struct pool {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    void (*task)(void *data, size_t index);
    void *data;
    size_t next, count, running, loops;
    bool closed;
} pool;

static void *serve(void *user)
{
    pool *p = (pool *)user;
    pthread_mutex_lock(&p->lock);
    while (!p->closed) {
        if (p->next == p->count) {
            pthread_cond_wait(&p->changed, &p->lock);
            continue;
        }
        size_t index = p->next++;
        p->running++;
        pthread_mutex_unlock(&p->lock);
        p->task(p->data, index);
        pthread_mutex_lock(&p->lock);
        p->running--;
        pthread_cond_broadcast(&p->changed);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

/// rsv_context_desc.parallel
static void run(void *user, size_t count, void (*task)(void *data, size_t index), void *data)
{
    pool *p = (pool *)user;
    pthread_mutex_lock(&p->lock);
    p->task = task;
    p->data = data;
    p->next = 0;
    p->count = count;
    p->loops++;
    pthread_cond_broadcast(&p->changed);
    while (p->next < p->count || p->running > 0)
        pthread_cond_wait(&p->changed, &p->lock);
    pthread_mutex_unlock(&p->lock);
}

int main(void)
{
    pool p;
    pthread_t thread[THREADS];
    memset(&p, 0, sizeof p);
    pthread_mutex_init(&p.lock, NULL);
    pthread_cond_init(&p.changed, NULL);
    for (int k = 0; k < THREADS; k++)
        if (pthread_create(&thread[k], NULL, serve, &p) != 0) return 1;
    rsv_context *context = NULL;
    rsv_scene *scene = NULL;
    rsv_light *light = NULL;
    rsv_context_desc own = rsv_default_context_desc();
    own.thread_count = 2 * THREADS; // tasks per loop: idle threads take the next one
    own.parallel = run;
    own.user = &p;
    rsv_solve_desc solve = rsv_default_solve_desc(RSV_QUALITY_DRAFT);
    rsv_status status = rsv_context_create(&own, &context);
    if (status == RSV_OK) status = rsv_scene_builtin(context, "cornell-blocks", &scene);
    if (status == RSV_OK) status = rsv_light_create(scene, &solve, &light);
    if (status == RSV_OK)
        printf("%zu elements, %zu loops\n", rsv_light_report(light)->elements, p.loops);
    else
        fprintf(stderr, "error: %s\n", rsv_last_error());
    rsv_light_destroy(light);
    rsv_scene_destroy(scene);
    rsv_context_destroy(context);
    pthread_mutex_lock(&p.lock);
    p.closed = true;
    pthread_cond_broadcast(&p.changed);
    pthread_mutex_unlock(&p.lock);
    for (int k = 0; k < THREADS; k++)
        pthread_join(thread[k], NULL);
    return status != RSV_OK || p.loops == 0;
}
