/* Streams as threads. */
#define _GNU_SOURCE
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "stand_in.h"

pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
unsigned spent;

static int streams;
/* Operations that are not done. */
static uint64_t pending;
static __thread bool in_host_function;

bool is_in_host_function(void)
{
    return in_host_function;
}

struct kept {
    struct kept *next;
    void *unused;
};
static struct kept *all_kept;

void *kept(size_t bytes)
{
    static pthread_mutex_t keeping = PTHREAD_MUTEX_INITIALIZER;
    struct kept *made = calloc(1, sizeof *made + bytes);
    if (made == NULL) {
        abort();
    }
    pthread_mutex_lock(&keeping);
    made->next = all_kept;
    all_kept = made;
    pthread_mutex_unlock(&keeping);
    return made + 1;
}

void graph_add(struct CUgraph_st *graph, const struct operation *operation)
{
    struct operation *copy = malloc(sizeof *copy);
    if (copy == NULL) {
        abort();
    }
    *copy = *operation;
    copy->next = NULL;
    if (graph->first == NULL) {
        graph->last = &graph->first;
    }
    *graph->last = copy;
    graph->last = &copy->next;
}

void graph_clear(struct CUgraph_st *graph)
{
    while (graph->first != NULL) {
        struct operation *gone = graph->first;
        graph->first = gone->next;
        free(gone);
    }
}

static bool ignores_waits(void)
{
    return script_of("ignores", "waits", 0) != 0;
}

/* With the lock held, which is let go while the kernel takes its time. */
static void run_kernel(struct CUstream_st *stream, const struct operation *o)
{
    const char *name = o->kernel->name;
    uint64_t ignored = 0, error = 0;
    bool hangs = script_at("hang", name, &ignored), fails = script_at("fault", name, &error);
    say("begin %d %s", stream->number, name);
    pthread_mutex_unlock(&lock);
    sleep_us(script_from("slows", name, script_of("takes", name, 0)));
    if (o->kernel->computation != NULL) {
        o->kernel->computation->run(o->arguments);
    }
    pthread_mutex_lock(&lock);
    while (hangs && spent == 0 && !stream->ends) {
        pthread_cond_wait(&changed, &lock);
    }
    if (fails) {
        spent = (unsigned)error;
    }
    say("end %d %s", stream->number, name);
}

static void run(struct CUstream_st *stream, struct operation *o)
{
    switch (o->kind) {
    case KERNEL:
        run_kernel(stream, o);
        break;
    case RECORD:
        o->event->reached = o->turn > o->event->reached ? o->turn : o->event->reached;
        o->event->at_ns = clock_ns();
        break;
    case WAIT:
        while (o->event->reached < o->turn && spent == 0 && !stream->ends && !ignores_waits()) {
            pthread_cond_wait(&changed, &lock);
        }
        break;
    case CALL:
        pthread_mutex_unlock(&lock);
        in_host_function = true;
        o->function(o->argument);
        in_host_function = false;
        pthread_mutex_lock(&lock);
        break;
    case COPY:
        memcpy(o->to, o->from, o->bytes);
        break;
    case SET:
        memset(o->to, 0, o->bytes);
        break;
    }
}

static void *stream_main(void *argument)
{
    struct CUstream_st *stream = argument;
    cpu_set_t everywhere;
    /* The device computes beside the lanes, wherever those are pinned. */
    memset(&everywhere, 0xff, sizeof everywhere);
    (void)sched_setaffinity(0, sizeof everywhere, &everywhere);
    pthread_mutex_lock(&lock);
    for (;;) {
        struct operation *next = stream->queue.first;
        /* Nothing runs any more in a context that is spent. */
        if (next != NULL && spent == 0) {
            run(stream, next);
            stream->queue.first = next->next;
            free(next);
            pending--;
            pthread_cond_broadcast(&changed);
        } else if (stream->ends) {
            break;
        } else {
            pthread_cond_wait(&changed, &lock);
        }
    }
    pthread_mutex_unlock(&lock);
    return NULL;
}

struct CUstream_st *stream_new(void)
{
    struct sched_param ordinary = {0};
    struct CUstream_st *stream = kept(sizeof *stream);
    pthread_attr_t attributes;
    if (stream == NULL || pthread_attr_init(&attributes) != 0) {
        abort();
    }
    pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
    pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
    pthread_attr_setschedparam(&attributes, &ordinary);
    stream->number = ++streams;
    if (pthread_create(&stream->thread, &attributes, stream_main, stream) != 0) {
        abort();
    }
    pthread_attr_destroy(&attributes);
    return stream;
}

/* Without waiting, as the driver; the thread ends when its queue is empty. */
void stream_end(struct CUstream_st *stream)
{
    pthread_mutex_lock(&lock);
    stream->ends = true;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
    pthread_detach(stream->thread);
}

void stream_add(struct CUstream_st *stream, struct operation operation)
{
    pthread_mutex_lock(&lock);
    if (operation.kind == RECORD && stream->capture == NULL) {
        operation.turn = ++operation.event->recorded;
    } else if (operation.kind == WAIT) {
        operation.turn = operation.event->recorded;
    }
    if (stream->capture == NULL) {
        pending++;
    }
    graph_add(stream->capture == NULL ? &stream->queue : stream->capture, &operation);
    /* A queue that ran empty begins anew. */
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

void streams_drain(void)
{
    pthread_mutex_lock(&lock);
    while (pending > 0 && spent == 0) {
        pthread_cond_wait(&changed, &lock);
    }
    pthread_mutex_unlock(&lock);
}
