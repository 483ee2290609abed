/* The entry points. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "stand_in.h"

#define DECLARE(field, name, parameters) unsigned name parameters;
RED_CUDA_REQUIRED(DECLARE)
RED_CUDA_OPTIONAL(DECLARE)
RED_CUDA_OLDER(DECLARE)

#ifdef LACKING
/* Hidden, and so not found by its name. */
#define HIDE(name) __typeof__(name) name __attribute__((visibility("hidden")));
HIDE(cuStreamWaitEvent)
HIDE(cuGraphLaunch)
HIDE(cuGraphInstantiate)
HIDE(cuGraphInstantiateWithFlags)
#endif

static bool is_initialised;
static uint64_t allocated;
static int events;
static struct CUctx_st {
    int device;
} context;
static __thread struct CUctx_st *current;

/* What a call answers before it does anything: what the script says, that the context is spent, that a host function
 * called it. */
static unsigned before(const char *name)
{
    uint64_t error = 0;
    sleep_us(script_of("delay", name, 0));
    if (is_in_host_function()) {
        say("forbidden %s", name);
        return CUDA_ERROR_NOT_PERMITTED;
    }
    if (script_at("refuse", name, &error)) {
        return (unsigned)error;
    }
    pthread_mutex_lock(&lock);
    error = spent;
    pthread_mutex_unlock(&lock);
    return (unsigned)error;
}

/* Of calls that need a context. */
static unsigned inside(const char *name)
{
    unsigned error = before(name);
    return error == CUDA_SUCCESS && current == NULL ? CUDA_ERROR_INVALID_CONTEXT : error;
}

#define ANSWER(result, ...)                       \
    do {                                          \
        unsigned answer_ = (result);              \
        say_call(__func__, answer_, __VA_ARGS__); \
        return answer_;                           \
    } while (0)

static void say_call(const char *name, unsigned result, int stream, const char *what, int number)
{
    char text[128] = "";
    if (stream > 0 && what != NULL && number > 0) {
        (void)snprintf(text, sizeof text, " %d %s%d", stream, what, number);
    } else if (stream > 0 && what != NULL) {
        (void)snprintf(text, sizeof text, " %d %s", stream, what);
    } else if (stream > 0) {
        (void)snprintf(text, sizeof text, " %d", stream);
    }
    say("call %s%s = %u", name, text, result);
}

#define TRY_BEFORE                        \
    unsigned error = before(__func__);    \
    if (error != CUDA_SUCCESS) {          \
        ANSWER(error, 0, NULL, 0);        \
    }
#define TRY_INSIDE                        \
    unsigned error = inside(__func__);    \
    if (error != CUDA_SUCCESS) {          \
        ANSWER(error, 0, NULL, 0);        \
    }

unsigned cuInit(unsigned flags)
{
    (void)flags;
    TRY_BEFORE
    is_initialised = true;
    ANSWER(script_number("devices", 1) == 0 ? 100 : CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuDriverGetVersion(int *version)
{
    *version = (int)script_number("version", 12020);
    return CUDA_SUCCESS;
}

unsigned cuGetErrorName(unsigned error, const char **name)
{
    static __thread char text[32];
    (void)snprintf(text, sizeof text, "CUDA_ERROR_%u", error);
    *name = error == 700 ? "CUDA_ERROR_ILLEGAL_ADDRESS" : error == 2 ? "CUDA_ERROR_OUT_OF_MEMORY" : text;
    return CUDA_SUCCESS;
}

unsigned cuGetErrorString(unsigned error, const char **text)
{
    (void)error;
    *text = "as the script says";
    return CUDA_SUCCESS;
}

unsigned cuDeviceGetCount(int *count)
{
    TRY_BEFORE
    *count = (int)script_number("devices", 1);
    return is_initialised ? CUDA_SUCCESS : CUDA_ERROR_NOT_INITIALIZED;
}

unsigned cuDeviceGet(int *device, int ordinal)
{
    TRY_BEFORE
    *device = ordinal;
    return ordinal < (int)script_number("devices", 1) ? CUDA_SUCCESS : CUDA_ERROR_INVALID_DEVICE;
}

unsigned cuDeviceGetName(char *name, int size, int device)
{
    (void)snprintf(name, (size_t)size, "stand-in %d", device);
    return CUDA_SUCCESS;
}

unsigned cuDeviceGetAttribute(int *value, unsigned attribute, int device)
{
    (void)device;
    *value = attribute == 75 ? 5 : attribute == 76 ? 3 : 1;
    return CUDA_SUCCESS;
}

unsigned cuDeviceGetPCIBusId(char *id, int size, int device)
{
    (void)snprintf(id, (size_t)size, "0000:0%d:00.0", device);
    return CUDA_SUCCESS;
}

unsigned cuDevicePrimaryCtxRetain(struct CUctx_st **made, int device)
{
    TRY_BEFORE
    context.device = device;
    *made = &context;
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuDevicePrimaryCtxRelease_v2(int device)
{
    (void)device;
    TRY_BEFORE
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuDevicePrimaryCtxRelease(int device)
{
    return cuDevicePrimaryCtxRelease_v2(device);
}

unsigned cuCtxSetCurrent(struct CUctx_st *given)
{
    TRY_BEFORE
    current = given;
    return CUDA_SUCCESS;
}

unsigned cuCtxSynchronize(void)
{
    TRY_INSIDE
    streams_drain();
    ANSWER(spent, 0, NULL, 0);
}

unsigned cuCtxGetStreamPriorityRange(int *least, int *greatest)
{
    TRY_INSIDE
    *least = 0;
    *greatest = -5;
    return CUDA_SUCCESS;
}

unsigned cuStreamCreateWithPriority(struct CUstream_st **stream, unsigned flags, int priority)
{
    TRY_INSIDE
    if (flags != 1 || priority > 0 || priority < -5) {
        ANSWER(CUDA_ERROR_INVALID_VALUE, 0, NULL, 0);
    }
    *stream = stream_new();
    ANSWER(CUDA_SUCCESS, (*stream)->number, NULL, 0);
}

unsigned cuStreamDestroy_v2(struct CUstream_st *stream)
{
    stream_end(stream);
    ANSWER(CUDA_SUCCESS, stream->number, NULL, 0);
}

unsigned cuStreamWaitEvent(struct CUstream_st *stream, struct CUevent_st *event, unsigned flags)
{
    (void)flags;
    TRY_INSIDE
    stream_add(stream, (struct operation){.kind = WAIT, .event = event});
    ANSWER(CUDA_SUCCESS, stream->number, "event", event->number);
}

unsigned cuStreamBeginCapture_v2(struct CUstream_st *stream, unsigned mode)
{
    (void)mode;
    TRY_INSIDE
    stream->capture = calloc(1, sizeof *stream->capture);
    ANSWER(CUDA_SUCCESS, stream->number, NULL, 0);
}

unsigned cuStreamEndCapture(struct CUstream_st *stream, struct CUgraph_st **graph)
{
    TRY_INSIDE
    *graph = stream->capture;
    stream->capture = NULL;
    ANSWER(*graph == NULL ? CUDA_ERROR_INVALID_VALUE : CUDA_SUCCESS, stream->number, NULL, 0);
}

unsigned cuLaunchHostFunc(struct CUstream_st *stream, void (*function)(void *), void *argument)
{
    TRY_INSIDE
    stream_add(stream, (struct operation){.kind = CALL, .function = function, .argument = argument});
    ANSWER(CUDA_SUCCESS, stream->number, NULL, 0);
}

unsigned cuEventCreate(struct CUevent_st **event, unsigned flags)
{
    (void)flags;
    TRY_INSIDE
    *event = kept(sizeof **event);
    pthread_mutex_lock(&lock);
    (*event)->number = ++events;
    pthread_mutex_unlock(&lock);
    return CUDA_SUCCESS;
}

/* Streams may have it in their queues still. */
unsigned cuEventDestroy_v2(struct CUevent_st *event)
{
    (void)event;
    return CUDA_SUCCESS;
}

unsigned cuEventRecord(struct CUevent_st *event, struct CUstream_st *stream)
{
    TRY_INSIDE
    stream_add(stream, (struct operation){.kind = RECORD, .event = event});
    ANSWER(CUDA_SUCCESS, stream->number, "event", event->number);
}

unsigned cuEventQuery(struct CUevent_st *event)
{
    TRY_INSIDE
    pthread_mutex_lock(&lock);
    bool is_done = event->reached == event->recorded;
    error = spent;
    pthread_mutex_unlock(&lock);
    return error != CUDA_SUCCESS ? error : is_done ? CUDA_SUCCESS : CUDA_ERROR_NOT_READY;
}

unsigned cuEventElapsedTime(float *milliseconds, struct CUevent_st *from, struct CUevent_st *to)
{
    TRY_INSIDE
    pthread_mutex_lock(&lock);
    *milliseconds = (float)(to->at_ns - from->at_ns) / 1e6f;
    pthread_mutex_unlock(&lock);
    return CUDA_SUCCESS;
}

unsigned cuModuleLoadDataEx(struct CUmod_st **module, const void *image, unsigned count, unsigned *options, void **values)
{
    TRY_INSIDE
    if (strstr(image, ".version") == NULL) {
        if (count == 2 && options[0] == 5 && options[1] == 6) {
            (void)snprintf(values[0], (size_t)(uintptr_t)values[1], "no .version");
        }
        ANSWER(CUDA_ERROR_INVALID_PTX, 0, NULL, 0);
    }
    *module = kept(sizeof **module);
    (*module)->text = strdup(image);
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuModuleUnload(struct CUmod_st *module)
{
    (void)module;
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

/* PTX names a kernel as `.entry NAME`. */
static bool has_kernel(const char *text, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = text; (at = strstr(at, ".entry")) != NULL;) {
        at += strlen(".entry");
        at += strspn(at, " \t\n");
        if (strncmp(at, name, length) == 0 && strchr(" \t\n(", at[length]) != NULL) {
            return true;
        }
    }
    return false;
}

unsigned cuModuleGetFunction(struct CUfunc_st **function, struct CUmod_st *module, const char *name)
{
    TRY_INSIDE
    if (!has_kernel(module->text, name)) {
        ANSWER(CUDA_ERROR_NOT_FOUND, 0, NULL, 0);
    }
    struct CUfunc_st *made = kept(sizeof *made);
    (void)snprintf(made->name, sizeof made->name, "%s", name);
    made->computation = computation_of(name);
    made->next = module->functions;
    module->functions = made;
    *function = made;
    return CUDA_SUCCESS;
}

unsigned cuLaunchKernel(struct CUfunc_st *function, unsigned grid_x, unsigned grid_y, unsigned grid_z, unsigned block_x,
                        unsigned block_y, unsigned block_z, unsigned shared_bytes, struct CUstream_st *stream,
                        void **arguments, void **extra)
{
    (void)shared_bytes, (void)extra;
    TRY_INSIDE
    uint64_t threads = (uint64_t)block_x * block_y * block_z;
    if ((uint64_t)grid_x * grid_y * grid_z == 0 || threads == 0 || threads > 1024) {
        ANSWER(CUDA_ERROR_INVALID_VALUE, stream->number, function->name, 0);
    }
    struct operation operation = {.kind = KERNEL, .kernel = function};
    const struct computation *computation = function->computation;
    for (unsigned i = 0; computation != NULL && i < computation->count; i++) {
        memcpy(&operation.arguments[i], arguments[i], computation->bytes[i]);
    }
    /* Said first: the stream is quick. */
    say_call(__func__, CUDA_SUCCESS, stream->number, function->name, 0);
    stream_add(stream, operation);
    return CUDA_SUCCESS;
}

unsigned cuGraphInstantiateWithFlags(struct CUgraphExec_st **executable, struct CUgraph_st *graph,
                                     unsigned long long flags)
{
    (void)flags;
    TRY_INSIDE
    *executable = calloc(1, sizeof **executable);
    pthread_mutex_lock(&lock);
    for (struct operation *o = graph->first; o != NULL; o = o->next) {
        graph_add(&(*executable)->graph, o);
    }
    pthread_mutex_unlock(&lock);
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuGraphInstantiate(struct CUgraphExec_st **executable, struct CUgraph_st *graph,
                            struct CUgraphNode_st **error_node, char *text, size_t text_size)
{
    (void)error_node, (void)text, (void)text_size;
    return cuGraphInstantiateWithFlags(executable, graph, 0);
}

unsigned cuGraphLaunch(struct CUgraphExec_st *graph, struct CUstream_st *stream)
{
    TRY_INSIDE
    say_call(__func__, CUDA_SUCCESS, stream->number, NULL, 0);
    for (struct operation *o = graph->graph.first; o != NULL; o = o->next) {
        stream_add(stream, *o);
    }
    return CUDA_SUCCESS;
}

unsigned cuGraphExecDestroy(struct CUgraphExec_st *graph)
{
    graph_clear(&graph->graph);
    free(graph);
    return CUDA_SUCCESS;
}

unsigned cuGraphDestroy(struct CUgraph_st *graph)
{
    graph_clear(graph);
    free(graph);
    return CUDA_SUCCESS;
}

unsigned cuMemGetInfo_v2(size_t *free_bytes, size_t *total)
{
    TRY_INSIDE
    *total = script_number("memory", 2ull << 30);
    *free_bytes = *total - allocated;
    return CUDA_SUCCESS;
}

/* Before each allocation its size. */
#define HEAD 64

unsigned cuMemAlloc_v2(unsigned long long *address, size_t bytes)
{
    TRY_INSIDE
    pthread_mutex_lock(&lock);
    bool fits = bytes > 0 && allocated + bytes <= script_number("memory", 2ull << 30);
    char *memory = fits ? malloc(bytes + HEAD) : NULL;
    if (memory != NULL) {
        memcpy(memory, &bytes, sizeof bytes);
        allocated += bytes;
        *address = (uintptr_t)memory + HEAD;
    }
    pthread_mutex_unlock(&lock);
    ANSWER(memory == NULL ? CUDA_ERROR_OUT_OF_MEMORY : CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuMemFree_v2(unsigned long long address)
{
    char *memory = (char *)(uintptr_t)address - HEAD;
    size_t bytes;
    memcpy(&bytes, memory, sizeof bytes);
    streams_drain();
    pthread_mutex_lock(&lock);
    allocated -= bytes;
    pthread_mutex_unlock(&lock);
    free(memory);
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuMemsetD8Async(unsigned long long address, unsigned char value, size_t bytes, struct CUstream_st *stream)
{
    TRY_INSIDE
    if (value != 0) {
        return CUDA_ERROR_INVALID_VALUE;
    }
    stream_add(stream, (struct operation){.kind = SET, .to = (void *)(uintptr_t)address, .bytes = bytes});
    ANSWER(CUDA_SUCCESS, stream->number, NULL, 0);
}

unsigned cuMemHostAlloc(void **address, size_t bytes, unsigned flags)
{
    (void)flags;
    TRY_INSIDE
    *address = malloc(bytes);
    ANSWER(*address == NULL ? CUDA_ERROR_OUT_OF_MEMORY : CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuMemFreeHost(void *address)
{
    streams_drain();
    free(address);
    ANSWER(CUDA_SUCCESS, 0, NULL, 0);
}

unsigned cuMemcpyHtoDAsync_v2(unsigned long long to, const void *from, size_t bytes, struct CUstream_st *stream)
{
    TRY_INSIDE
    stream_add(stream,
               (struct operation){.kind = COPY, .to = (void *)(uintptr_t)to, .from = from, .bytes = bytes});
    ANSWER(CUDA_SUCCESS, stream->number, NULL, 0);
}

unsigned cuMemcpyDtoHAsync_v2(void *to, unsigned long long from, size_t bytes, struct CUstream_st *stream)
{
    TRY_INSIDE
    stream_add(stream,
               (struct operation){.kind = COPY, .to = to, .from = (const void *)(uintptr_t)from, .bytes = bytes});
    ANSWER(CUDA_SUCCESS, stream->number, NULL, 0);
}
