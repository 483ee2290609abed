/* What is open: memory that cannot be, handles that are closed, copied, made up or of something else, and calls that come
 * in the middle of another. */
#define _GNU_SOURCE
#include "calls.h"

#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static struct small_memory memory;
static struct small_dag_memory dag_memory, more_dag_memory;
static _Alignas(RED_ALIGN) unsigned char large[RED_SCHEDULER_16X256X64_BYTES];

typedef red_status (*open_dag_fn)(void *, size_t, red_dag *);
typedef red_status (*open_scheduler_fn)(void *, size_t, const red_config *, red_scheduler *);
/* Handles that may be open at once, at least; above that there is an end somewhere. */
#define MANY 4096

static void dags(const char *name, open_dag_fn open, size_t bytes) {
    red_dag dag = {0}, other = {0};
    CALL_BY(name, RED_STATUS_TOO_SHORT, open, large, 16, &dag);
    CALL_BY(name, RED_STATUS_MISALIGNED, open, large + 1, bytes, &dag);
    CALL_BY(name, RED_STATUS_NULL_POINTER, open, NULL, bytes, &dag);
    /* The handle would be written over the graph. */
    CALL_BY(name, RED_STATUS_OVERLAP, open, large, bytes, (red_dag *)(void *)large);
    CALL_BY(name, RED_STATUS_OVERLAP, open, large, bytes, (red_dag *)(void *)(large + bytes - sizeof dag));
    CALL_BY(name, RED_OK, open, large, bytes, (red_dag *)(void *)(large + bytes));
    CALL(RED_OK, red_dag_close, (red_dag *)(void *)(large + bytes));
    CALL_BY(name, RED_OK, open, large, bytes, &dag);
    CALL_BY(name, RED_STATUS_OVERLAP, open, large, bytes, &other);
    CALL_BY(name, RED_STATUS_OVERLAP, open, large + RED_ALIGN, bytes, &other);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_STATUS_CLOSED, red_dag_close, &dag);
}

static void schedulers(const char *name, open_scheduler_fn open, size_t bytes) {
    const red_config config = preset(RED_PRESET_REDRT);
    red_scheduler scheduler = {0}, other = {0};
    CALL_BY(name, RED_STATUS_TOO_SHORT, open, large, 16, &config, &scheduler);
    CALL_BY(name, RED_STATUS_MISALIGNED, open, large + 1, bytes, &config, &scheduler);
    CALL_BY(name, RED_STATUS_NULL_POINTER, open, NULL, bytes, &config, &scheduler);
    CALL_BY(name, RED_STATUS_OVERLAP, open, large, bytes, &config, (red_scheduler *)(void *)(large + 8));
    CALL_BY(name, RED_OK, open, large, bytes, &config, &scheduler);
    CALL_BY(name, RED_STATUS_OVERLAP, open, large, bytes, &config, &other);
    CALL(RED_OK, red_scheduler_close, &scheduler);
    CALL(RED_STATUS_CLOSED, red_scheduler_close, &scheduler);
}

/* Opens graphs until there are too many, and then everything else too. */
static void too_many(void) {
    static struct small_dag_memory memories[MANY];
    static red_dag dags[MANY];
    size_t open = 0;
    red_status status = RED_OK;
    while (open < MANY && status == RED_OK) {
        status = red_dag_open_4x16x16(&memories[open], sizeof memories[open], &dags[open]);
        if (status == RED_OK) open++;
    }
    EXPECT(open >= 8 && status == RED_STATUS_TOO_MANY_OPEN);
    const red_config config = preset(RED_PRESET_REDRT);
    red_scheduler scheduler = {0};
    red_dag dag = {0};
    CALL(RED_STATUS_TOO_MANY_OPEN, red_dag_open_4x16x16, &dag_memory, sizeof dag_memory, &dag);
    CALL(RED_STATUS_TOO_MANY_OPEN, red_dag_open_8x64x32, large, sizeof large, &dag);
    CALL(RED_STATUS_TOO_MANY_OPEN, red_dag_open_16x256x64, large, sizeof large, &dag);
    CALL(RED_STATUS_TOO_MANY_OPEN, red_scheduler_open_4x16x16, &memory, sizeof memory, &config, &scheduler);
    CALL(RED_STATUS_TOO_MANY_OPEN, red_scheduler_open_8x64x32, large, sizeof large, &config, &scheduler);
    CALL(RED_STATUS_TOO_MANY_OPEN, red_scheduler_open_16x256x64, large, sizeof large, &config, &scheduler);

    /* An edit needs a place too: with one free for the scheduler there is none for it. */
    CALL(RED_OK, red_dag_close, &dags[--open]);
    CALL(RED_OK, red_dag_close, &dags[--open]);
    scheduler = open_small(&memory, 1);
    const uint32_t task = add_simple_task(&scheduler, SECOND);
    dag = open_small_dag(&dag_memory);
    red_dag edit = {0};
    CALL(RED_STATUS_TOO_MANY_OPEN, red_scheduler_edit, &scheduler, task, &more_dag_memory, sizeof more_dag_memory, &edit);
    CALL(RED_OK, red_scheduler_close, &scheduler);
    CALL(RED_OK, red_dag_close, &dag);
    while (open > 0) CALL(RED_OK, red_dag_close, &dags[--open]);
}

static void wrong_handles(void) {
    red_scheduler scheduler = open_small(&memory, 1);
    red_dag dag = open_small_dag(&dag_memory);
    red_dag_summary summary = RED_DAG_SUMMARY_INIT;
    uint64_t at = 7;

    const red_dag none = {0}, as_dag = {scheduler.bits};
    CALL(RED_STATUS_CLOSED, red_dag_summarize, &none, &summary);
    CALL(RED_STATUS_OTHER_KIND, red_dag_summarize, &as_dag, &summary);
    const red_scheduler as_scheduler = {dag.bits}, made_up = {UINT64_C(0x123456789abcdef0)};
    CALL(RED_STATUS_OTHER_KIND, red_scheduler_poll_at, &as_scheduler, &at);
    CALL(RED_STATUS_FOREIGN, red_scheduler_poll_at, &made_up, &at);
    EXPECT(at == 7);

    /* A copy of a handle that was closed finds nothing, not even what was opened in its place. */
    red_dag copy = dag;
    CALL(RED_OK, red_dag_close, &dag);
    red_dag next = open_small_dag(&dag_memory);
    CALL(RED_STATUS_CLOSED, red_dag_summarize, &copy, &summary);
    CALL(RED_STATUS_CLOSED, red_dag_close, &copy);
    CALL(RED_OK, red_dag_summarize, &next, &summary);
    CALL(RED_OK, red_dag_close, &next);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

static void wrong_class(void) {
    red_scheduler scheduler = open_small(&memory, 1);
    red_dag dag = {0};
    CALL(RED_OK, red_dag_open_8x64x32, large, sizeof large, &dag);
    add(&dag, node_of(MS));
    const red_timing timing = timing_of(SECOND);
    uint32_t task = 7;
    CALL(RED_STATUS_OTHER_CLASS, red_scheduler_add_task, &scheduler, &dag, &timing, &task);
    red_certificate proof = RED_CERTIFICATE_INIT;
    CALL(RED_STATUS_OTHER_CLASS, red_scheduler_commit, &scheduler, &dag, 0, &proof);
    EXPECT(task == 7);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* The largest class: open, one job, closed. */
static void large_class(void) {
    static _Alignas(RED_ALIGN) unsigned char graph[RED_DAG_16X256X64_BYTES];
    red_config config = preset(RED_PRESET_REDRT);
    config.lanes = 32;
    red_scheduler scheduler = {0};
    red_dag dag = {0};
    CALL(RED_OK, red_scheduler_open_16x256x64, large, sizeof large, &config, &scheduler);
    CALL(RED_OK, red_dag_open_16x256x64, graph, sizeof graph, &dag);
    for (int i = 0; i < 256; i++) add(&dag, node_of(MS));
    const red_timing timing = timing_of(SECOND);
    uint32_t task = 0, job = 0;
    CALL(RED_OK, red_scheduler_add_task, &scheduler, &dag, &timing, &task);
    CALL(RED_OK, red_scheduler_release, &scheduler, task, 0, &job);
    for (int lane = 0; lane < 32; lane++) poll(&scheduler, 0, RED_ACTION_KIND_DISPATCH);
    poll(&scheduler, 0, RED_ACTION_KIND_NOTHING);
    CALL(RED_OK, red_dag_close, &dag);
    CALL(RED_OK, red_scheduler_close, &scheduler);
}

/* A page that cannot be written: the call that writes its answer there is stopped in its middle, and what the handler calls
 * then comes from below. */
static void *page;
static red_dag busy_dag;
static red_scheduler busy_scheduler;
static int interruptions;

static void interrupted(int number) {
    (void)number;
    interruptions++;
    red_action action;
    uint32_t lane = 0;
    red_dag_summary summary = RED_DAG_SUMMARY_INIT;
    red_node node = node_of(MS);
    if (interruptions == 1) {
        CALL(RED_STATUS_BUSY, red_dag_summarize, &busy_dag, &summary);
        CALL(RED_STATUS_BUSY, red_dag_add_node, &busy_dag, &node, &lane);
        CALL(RED_STATUS_BUSY, red_dag_close, &busy_dag);
    } else if (interruptions == 2) {
        CALL(RED_STATUS_BUSY, red_scheduler_poll, &busy_scheduler, 0, &action);
        CALL(RED_STATUS_BUSY, red_scheduler_close, &busy_scheduler);
    } else {
        /* Not what was planted. */
        _exit(1);
    }
    mprotect(page, 4096, PROT_READ | PROT_WRITE);
}

static void busy(void) {
    page = mmap(NULL, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    EXPECT(page != MAP_FAILED);
    struct sigaction handler, before;
    memset(&handler, 0, sizeof handler);
    handler.sa_handler = interrupted;
    sigaction(SIGSEGV, &handler, &before);
    busy_dag = open_small_dag(&dag_memory);
    busy_scheduler = open_small(&memory, 1);
    const red_node node = node_of(MS);
    CALL(RED_OK, red_dag_add_node, &busy_dag, &node, (uint32_t *)page);
    EXPECT(interruptions == 1);
    mprotect(page, 4096, PROT_READ);
    CALL(RED_OK, red_scheduler_poll, &busy_scheduler, 0, (red_action *)page);
    EXPECT(interruptions == 2);
    CALL(RED_OK, red_dag_close, &busy_dag);
    CALL(RED_OK, red_scheduler_close, &busy_scheduler);
    sigaction(SIGSEGV, &before, NULL);
    munmap(page, 4096);
}

void test_handles(void) {
    dags("red_dag_open_4x16x16", red_dag_open_4x16x16, RED_DAG_4X16X16_BYTES);
    dags("red_dag_open_8x64x32", red_dag_open_8x64x32, RED_DAG_8X64X32_BYTES);
    dags("red_dag_open_16x256x64", red_dag_open_16x256x64, RED_DAG_16X256X64_BYTES);
    schedulers("red_scheduler_open_4x16x16", red_scheduler_open_4x16x16, RED_SCHEDULER_4X16X16_BYTES);
    schedulers("red_scheduler_open_8x64x32", red_scheduler_open_8x64x32, RED_SCHEDULER_8X64X32_BYTES);
    schedulers("red_scheduler_open_16x256x64", red_scheduler_open_16x256x64, RED_SCHEDULER_16X256X64_BYTES);
    too_many();
    wrong_handles();
    wrong_class();
    large_class();
    busy();
}
