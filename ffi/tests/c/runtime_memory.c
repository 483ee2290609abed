/* Where the process has no memory left: a status, and what was there goes on. The program is linked with --wrap, so that what
 * the library asks of the allocator comes by here. */
#include "runtime.h"

#include <stdlib.h>
#include <unistd.h>

/* What the calling thread may still have; and what a call asks for first, to see whether it is there. */
static _Thread_local size_t left = SIZE_MAX, asked;

static bool has(size_t bytes) {
    if (left == SIZE_MAX) return true;
    if (asked == 0) {
        asked = bytes;
        return bytes <= left;
    }
    if (bytes > left) return false;
    left -= bytes;
    return true;
}

void *__real_malloc(size_t bytes);
void *__real_calloc(size_t count, size_t bytes);
void *__real_realloc(void *at, size_t bytes);
int __real_posix_memalign(void **at, size_t align, size_t bytes);
void *__wrap_malloc(size_t bytes);
void *__wrap_calloc(size_t count, size_t bytes);
void *__wrap_realloc(void *at, size_t bytes);
int __wrap_posix_memalign(void **at, size_t align, size_t bytes);

void *__wrap_malloc(size_t bytes) { return has(bytes) ? __real_malloc(bytes) : NULL; }
void *__wrap_calloc(size_t count, size_t bytes) { return has(count * bytes) ? __real_calloc(count, bytes) : NULL; }
void *__wrap_realloc(void *at, size_t bytes) { return has(bytes) ? __real_realloc(at, bytes) : NULL; }
int __wrap_posix_memalign(void **at, size_t align, size_t bytes) {
    return has(bytes) ? __real_posix_memalign(at, align, bytes) : 12;
}

/* With nothing left it says so; with what it asks for first, and no more, it is done. */
#define SHORT(function, ...) \
    do { \
        left = asked = 0; \
        red_status said = function(__VA_ARGS__); \
        const size_t enough = asked; \
        left = SIZE_MAX; \
        called(__FILE__, __LINE__, #function, RED_STATUS_NO_MEMORY, said); \
        left = enough; \
        asked = 0; \
        said = function(__VA_ARGS__); \
        left = SIZE_MAX; \
        called(__FILE__, __LINE__, #function, RED_OK, said); \
    } while (0)

void test_memory(void) {
    static struct dag_memory memory, edit_memory;
    static struct small_memory small;
    char path[] = "red-test-XXXXXX";
    const int file = mkstemp(path);
    EXPECT(file >= 0);
    red_scheduler logged = open_small(&small, 1);
    SHORT(red_record_begin, &logged, path);
    uint64_t dropped = 7;
    CALL(RED_OK, red_record_end, &logged, 1, &dropped);
    CALL(RED_OK, red_scheduler_close, &logged);

    const red_config policy = preset(RED_PRESET_REDRT);
    const red_runtime_config config = config_of(RED_MODE_BEST_EFFORT);
    red_runtime runtime = {0};
    uint32_t pool = 7;
    SHORT(red_runtime_open, &policy, &config, &runtime);
    SHORT(red_runtime_add_cuda_pool, &runtime, 0, 1, RED_NONE_64, &pool);
    CALL(RED_OK, red_runtime_close, &runtime);
    CALL(RED_OK, red_runtime_open, &policy, &config, &runtime);
    SHORT(red_runtime_record, &runtime, path);
    red_dag dag = open_dag(&memory), edit = {0};
    red_callback callbacks[256];
    for (uint32_t i = 0; i < 256; i++) {
        add(&dag, node_of(1));
        callbacks[i] = callback_of(i, nothing, NULL);
    }
    const red_timing timing = timing_of(60 * SECOND);
    uint32_t task = RED_NONE, other = RED_NONE;
    const uint32_t cpu = 0;
    SHORT(red_runtime_add_task, &runtime, &dag, callbacks, 256, &timing, &task);
    SHORT(red_runtime_pin, &runtime, &cpu, 1);
    SHORT(red_runtime_every, &runtime, task, 0, SECOND);
    SHORT(red_runtime_start, &runtime);
    /* The same of a lane. */
    SHORT(red_runtime_add_task, &runtime, &dag, callbacks, 256, &timing, &other);
    CALL(RED_OK, red_dag_close, &dag);
    red_figures figures = RED_FIGURES_INIT;
    red_certificate proof = RED_CERTIFICATE_INIT;
    SHORT(red_runtime_figures, &runtime, &figures);
    SHORT(red_runtime_certificate, &runtime, other, &proof);
    SHORT(red_runtime_edit, &runtime, other, &edit_memory, sizeof edit_memory, &edit);
    SHORT(red_runtime_commit, &runtime, &edit, NULL, 0, &proof);
    CALL(RED_OK, red_dag_close, &edit);
    SHORT(red_runtime_remove_task, &runtime, other);
    CALL(RED_OK, red_runtime_close, &runtime);
    close(file);
    unlink(path);
}
