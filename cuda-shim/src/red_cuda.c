/* The table of the driver's entry points, and a call for each. See red_cuda.h. */
#include "red_cuda.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <string.h>

#include "driver_api.h"

#define LIBRARY "libcuda.so.1"

#define STREAM_NON_BLOCKING 1u
#define EVENT_DISABLE_TIMING 2u
/* Other threads' unsafe calls do not break a capture of this one. */
#define CAPTURE_THREAD_LOCAL 1u
#define HOST_PORTABLE 1u
#define JIT_ERROR_LOG 5u
#define JIT_ERROR_LOG_BYTES 6u

#define FIELD(field, name, parameters) unsigned(*field) parameters;
static struct {
    bool is_loaded;
    RED_CUDA_REQUIRED(FIELD)
    RED_CUDA_OPTIONAL(FIELD)
    RED_CUDA_OLDER(FIELD)
} driver;

/* POSIX gives dlsym's result the size of a function pointer; ISO C has no cast for it. */
static bool look_up(void *library, const char *name, void *field)
{
    void *found = dlsym(library, name);
    memcpy(field, &found, sizeof found);
    return found != NULL;
}

/* Text that is cut where there is no room. */
struct words {
    char *at;
    size_t left;
};

static void say(struct words *words, const char *text)
{
    size_t length = strlen(text);
    if (words->left == 0) {
        return;
    }
    length = length < words->left ? length : words->left - 1;
    memcpy(words->at, text, length);
    words->at += length;
    words->left -= length;
    *words->at = '\0';
}

red_cuda_status_t red_cuda_load(char *words, size_t size)
{
    struct words said = {words, size};
    bool is_whole = true;
    say(&said, "");
    if (driver.is_loaded) {
        return RED_CUDA_OK;
    }
    void *library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        const char *why = dlerror();
        say(&said, why == NULL ? LIBRARY : why);
        return RED_CUDA_NO_LIBRARY;
    }
#define MISSING(symbol)                  \
    do {                                 \
        say(&said, is_whole ? "" : ", "); \
        say(&said, symbol);              \
        is_whole = false;                \
    } while (0)
#define REQUIRE(field, name, parameters)                   \
    if (!look_up(library, #name, (void *)&driver.field)) { \
        MISSING(#name);                                    \
    }
#define LOOK(field, name, parameters) (void)look_up(library, #name, (void *)&driver.field);
    RED_CUDA_REQUIRED(REQUIRE)
    RED_CUDA_OPTIONAL(LOOK)
    RED_CUDA_OLDER(LOOK)
    if (driver.context_release == NULL && driver.context_release_10 == NULL) {
        MISSING("cuDevicePrimaryCtxRelease");
    }
    if (driver.graph_instantiate == NULL && driver.graph_instantiate_10 == NULL) {
        MISSING("cuGraphInstantiate");
    }
    if (!is_whole) {
        memset(&driver, 0, sizeof driver);
        dlclose(library);
        return RED_CUDA_NO_ENTRY;
    }
    /* For good: its threads may be anywhere when a process ends. */
    driver.is_loaded = true;
    return RED_CUDA_OK;
}

#define CALL(...) (driver.is_loaded ? (red_cuda_status_t)driver.__VA_ARGS__ : RED_CUDA_NOT_LOADED)

red_cuda_status_t red_cuda_init(void)
{
    return CALL(init(0));
}

red_cuda_status_t red_cuda_driver_version(int32_t *version)
{
    return CALL(driver_version(version));
}

red_cuda_status_t red_cuda_error_name(red_cuda_status_t error, const char **name)
{
    return CALL(error_name((unsigned)error, name));
}

red_cuda_status_t red_cuda_error_text(red_cuda_status_t error, const char **text)
{
    return CALL(error_string((unsigned)error, text));
}

red_cuda_status_t red_cuda_device_count(int32_t *count)
{
    return CALL(device_count(count));
}

red_cuda_status_t red_cuda_device_get(int32_t ordinal, int32_t *device)
{
    return CALL(device_get(device, ordinal));
}

red_cuda_status_t red_cuda_device_name(int32_t device, char *name, size_t size)
{
    return CALL(device_name(name, (int)size, device));
}

red_cuda_status_t red_cuda_device_bus_id(int32_t device, char *id, size_t size)
{
    return CALL(device_bus_id(id, (int)size, device));
}

red_cuda_status_t red_cuda_device_attribute(int32_t device, uint32_t attribute, int32_t *value)
{
    return CALL(device_attribute(value, attribute, device));
}

red_cuda_status_t red_cuda_context_retain(int32_t device, red_cuda_context_t *context)
{
    return CALL(context_retain(context, device));
}

red_cuda_status_t red_cuda_context_release(int32_t device)
{
    if (driver.context_release == NULL) {
        return CALL(context_release_10(device));
    }
    return CALL(context_release(device));
}

red_cuda_status_t red_cuda_context_enter(red_cuda_context_t context)
{
    return CALL(context_set(context));
}

red_cuda_status_t red_cuda_context_synchronize(void)
{
    return CALL(context_synchronize());
}

red_cuda_status_t red_cuda_context_priorities(int32_t *least, int32_t *greatest)
{
    return CALL(context_priorities(least, greatest));
}

red_cuda_status_t red_cuda_stream_create(int32_t priority, red_cuda_stream_t *stream)
{
    return CALL(stream_create(stream, STREAM_NON_BLOCKING, priority));
}

red_cuda_status_t red_cuda_stream_destroy(red_cuda_stream_t stream)
{
    return CALL(stream_destroy(stream));
}

red_cuda_status_t red_cuda_stream_wait(red_cuda_stream_t stream, red_cuda_event_t event)
{
    return CALL(stream_wait(stream, event, 0));
}

red_cuda_status_t red_cuda_stream_call(red_cuda_stream_t stream, void (*function)(void *), void *argument)
{
    return CALL(launch_host(stream, function, argument));
}

red_cuda_status_t red_cuda_stream_begin_capture(red_cuda_stream_t stream)
{
    return CALL(stream_begin_capture(stream, CAPTURE_THREAD_LOCAL));
}

red_cuda_status_t red_cuda_stream_end_capture(red_cuda_stream_t stream, red_cuda_graph_t *graph)
{
    return CALL(stream_end_capture(stream, graph));
}

red_cuda_status_t red_cuda_event_create(int32_t timed, red_cuda_event_t *event)
{
    return CALL(event_create(event, timed != 0 ? 0 : EVENT_DISABLE_TIMING));
}

red_cuda_status_t red_cuda_event_destroy(red_cuda_event_t event)
{
    return CALL(event_destroy(event));
}

red_cuda_status_t red_cuda_event_record(red_cuda_event_t event, red_cuda_stream_t stream)
{
    return CALL(event_record(event, stream));
}

red_cuda_status_t red_cuda_event_query(red_cuda_event_t event)
{
    return CALL(event_query(event));
}

red_cuda_status_t red_cuda_event_elapsed(red_cuda_event_t from, red_cuda_event_t to, float *milliseconds)
{
    return CALL(event_elapsed(milliseconds, from, to));
}

red_cuda_status_t red_cuda_module_load(const void *image, char *words, size_t size, red_cuda_module_t *module)
{
    struct words said = {words, size};
    unsigned options[] = {JIT_ERROR_LOG, JIT_ERROR_LOG_BYTES};
    /* A size is passed as a value in the place of a pointer. */
    void *values[] = {words, (void *)(uintptr_t)(unsigned)size};
    say(&said, "");
    return CALL(module_load(module, image, 2, options, values));
}

red_cuda_status_t red_cuda_module_unload(red_cuda_module_t module)
{
    return CALL(module_unload(module));
}

red_cuda_status_t red_cuda_module_function(red_cuda_module_t module, const char *name, red_cuda_function_t *function)
{
    return CALL(module_function(function, module, name));
}

red_cuda_status_t red_cuda_launch(red_cuda_function_t function, const uint32_t grid[3], const uint32_t block[3],
                                  red_cuda_stream_t stream, void **arguments)
{
    return CALL(launch_kernel(function, grid[0], grid[1], grid[2], block[0], block[1], block[2], 0, stream, arguments,
                              NULL));
}

red_cuda_status_t red_cuda_graph_instantiate(red_cuda_graph_t graph, red_cuda_graph_exec_t *executable)
{
    if (driver.graph_instantiate == NULL) {
        return CALL(graph_instantiate_10(executable, graph, NULL, NULL, 0));
    }
    return CALL(graph_instantiate(executable, graph, 0));
}

red_cuda_status_t red_cuda_graph_launch(red_cuda_graph_exec_t executable, red_cuda_stream_t stream)
{
    return CALL(graph_launch(executable, stream));
}

red_cuda_status_t red_cuda_graph_exec_destroy(red_cuda_graph_exec_t executable)
{
    return CALL(graph_exec_destroy(executable));
}

red_cuda_status_t red_cuda_graph_destroy(red_cuda_graph_t graph)
{
    return CALL(graph_destroy(graph));
}

red_cuda_status_t red_cuda_memory_info(size_t *free, size_t *total)
{
    return CALL(memory_info(free, total));
}

red_cuda_status_t red_cuda_memory_allocate(size_t bytes, red_cuda_address_t *address)
{
    unsigned long long at = 0;
    red_cuda_status_t status = CALL(memory_allocate(&at, bytes));
    if (status == RED_CUDA_OK) {
        *address = at;
    }
    return status;
}

red_cuda_status_t red_cuda_memory_free(red_cuda_address_t address)
{
    return CALL(memory_free(address));
}

red_cuda_status_t red_cuda_memory_set(red_cuda_address_t address, uint8_t value, size_t bytes, red_cuda_stream_t stream)
{
    return CALL(memory_set(address, value, bytes, stream));
}

red_cuda_status_t red_cuda_host_allocate(size_t bytes, void **address)
{
    return CALL(host_allocate(address, bytes, HOST_PORTABLE));
}

red_cuda_status_t red_cuda_host_free(void *address)
{
    return CALL(host_free(address));
}

red_cuda_status_t red_cuda_copy_to_device(red_cuda_address_t to, const void *from, size_t bytes,
                                          red_cuda_stream_t stream)
{
    return CALL(copy_to_device(to, from, bytes, stream));
}

red_cuda_status_t red_cuda_copy_to_host(void *to, red_cuda_address_t from, size_t bytes, red_cuda_stream_t stream)
{
    return CALL(copy_to_host(to, from, bytes, stream));
}
