/* red_cuda: the calls of the CUDA driver that a scheduler of streams needs, loaded at run time.
 *
 * Nothing of CUDA is needed to compile or link this: no toolkit, no header, no library. red_cuda_load() opens
 * libcuda.so.1 and looks everything up once, so that no call does it later, in real time. The library has no state but
 * that table, allocates nothing and starts no thread. Drivers of CUDA 10.2 (JetPack 4) and later will do.
 *
 * Every function returns RED_CUDA_OK, an error of the driver (a CUresult, positive), or one of this library (negative).
 * Outputs are written on RED_CUDA_OK only, but for the words of red_cuda_load and red_cuda_module_load. No pointer may be
 * NULL unless it says so.
 *
 * Calls on handles need a context on the calling thread: red_cuda_context_enter(). */
#ifndef RED_CUDA_H
#define RED_CUDA_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t red_cuda_status_t;

/* Done. */
#define RED_CUDA_OK 0
/* libcuda.so.1 could not be opened: there is no driver here. */
#define RED_CUDA_NO_LIBRARY (-1)
/* The driver lacks entry points that are needed: it is too old, or not NVIDIA's. */
#define RED_CUDA_NO_ENTRY (-2)
/* red_cuda_load() has not succeeded. */
#define RED_CUDA_NOT_LOADED (-3)

/* Errors of the driver that callers treat apart; there are more. */
#define RED_CUDA_OUT_OF_MEMORY 2
#define RED_CUDA_NO_DEVICE 100
#define RED_CUDA_NOT_READY 600

typedef struct CUctx_st *red_cuda_context_t;
typedef struct CUstream_st *red_cuda_stream_t;
typedef struct CUevent_st *red_cuda_event_t;
typedef struct CUmod_st *red_cuda_module_t;
typedef struct CUfunc_st *red_cuda_function_t;
typedef struct CUgraph_st *red_cuda_graph_t;
typedef struct CUgraphExec_st *red_cuda_graph_exec_t;
/* An address in the device's memory. */
typedef uint64_t red_cuda_address_t;

/* --- the driver --------------------------------------------------------------------------------------------------- */

/* Loads the driver, once per process; again it answers what it found then, unless that was a failure. Not to be called
 * by two threads at once. `words` takes why it failed: the loader's message, or the names of what is missing, cut at
 * `size` bytes with the NUL. */
red_cuda_status_t red_cuda_load(char *words, size_t size);
/* cuInit(0). */
red_cuda_status_t red_cuda_init(void);
/* 1000 * major + 10 * minor of the newest CUDA that the driver supports. */
red_cuda_status_t red_cuda_driver_version(int32_t *version);
/* The name of a driver's error, such as CUDA_ERROR_ILLEGAL_ADDRESS, and what it means; static text. */
red_cuda_status_t red_cuda_error_name(red_cuda_status_t error, const char **name);
red_cuda_status_t red_cuda_error_text(red_cuda_status_t error, const char **text);

/* --- devices and contexts ----------------------------------------------------------------------------------------- */

red_cuda_status_t red_cuda_device_count(int32_t *count);
/* The device of a number from 0. */
red_cuda_status_t red_cuda_device_get(int32_t ordinal, int32_t *device);
red_cuda_status_t red_cuda_device_name(int32_t device, char *name, size_t size);
/* As domain:bus:device.function; NVML names devices by it. */
red_cuda_status_t red_cuda_device_bus_id(int32_t device, char *id, size_t size);
/* A CUdevice_attribute by its number. */
red_cuda_status_t red_cuda_device_attribute(int32_t device, uint32_t attribute, int32_t *value);
/* The device's primary context, which the CUDA runtime and so PyTorch and TensorRT use too; each retain needs a release. */
red_cuda_status_t red_cuda_context_retain(int32_t device, red_cuda_context_t *context);
red_cuda_status_t red_cuda_context_release(int32_t device);
/* Makes it the calling thread's. */
red_cuda_status_t red_cuda_context_enter(red_cuda_context_t context);
/* Waits until all of it is done. */
red_cuda_status_t red_cuda_context_synchronize(void);
/* Priorities of streams: a smaller number is more urgent. Both 0 where there is one only. */
red_cuda_status_t red_cuda_context_priorities(int32_t *least, int32_t *greatest);

/* --- streams and events ------------------------------------------------------------------------------------------- */

/* A stream that waits for no other, not even the legacy default one. */
red_cuda_status_t red_cuda_stream_create(int32_t priority, red_cuda_stream_t *stream);
red_cuda_status_t red_cuda_stream_destroy(red_cuda_stream_t stream);
/* What is submitted to the stream from now on starts after what `event` recorded last. The calling thread does not wait. */
red_cuda_status_t red_cuda_stream_wait(red_cuda_stream_t stream, red_cuda_event_t event);
/* Calls `function` on a thread of the driver's when the stream comes to it. It must not call CUDA, nor block. */
red_cuda_status_t red_cuda_stream_call(red_cuda_stream_t stream, void (*function)(void *), void *argument);
/* What is submitted to the stream by this thread goes into a graph instead. */
red_cuda_status_t red_cuda_stream_begin_capture(red_cuda_stream_t stream);
red_cuda_status_t red_cuda_stream_end_capture(red_cuda_stream_t stream, red_cuda_graph_t *graph);
/* `timed` is 0 for an event that only orders, which is cheaper. */
red_cuda_status_t red_cuda_event_create(int32_t timed, red_cuda_event_t *event);
red_cuda_status_t red_cuda_event_destroy(red_cuda_event_t event);
red_cuda_status_t red_cuda_event_record(red_cuda_event_t event, red_cuda_stream_t stream);
/* RED_CUDA_OK when what it recorded last is done, RED_CUDA_NOT_READY before. */
red_cuda_status_t red_cuda_event_query(red_cuda_event_t event);
/* Both timed. Half a microsecond exact. */
red_cuda_status_t red_cuda_event_elapsed(red_cuda_event_t from, red_cuda_event_t to, float *milliseconds);

/* --- what runs ---------------------------------------------------------------------------------------------------- */

/* Loads PTX text, with its NUL, or a cubin. `words` takes what the driver's assembler found wrong, cut at `size` bytes. */
red_cuda_status_t red_cuda_module_load(const void *image, char *words, size_t size, red_cuda_module_t *module);
red_cuda_status_t red_cuda_module_unload(red_cuda_module_t module);
red_cuda_status_t red_cuda_module_function(red_cuda_module_t module, const char *name, red_cuda_function_t *function);
/* Three extents each. `arguments` has a pointer to each parameter of the kernel, as many as the kernel has. */
red_cuda_status_t red_cuda_launch(red_cuda_function_t function, const uint32_t grid[3], const uint32_t block[3],
                                  red_cuda_stream_t stream, void **arguments);
red_cuda_status_t red_cuda_graph_instantiate(red_cuda_graph_t graph, red_cuda_graph_exec_t *executable);
red_cuda_status_t red_cuda_graph_launch(red_cuda_graph_exec_t executable, red_cuda_stream_t stream);
red_cuda_status_t red_cuda_graph_exec_destroy(red_cuda_graph_exec_t executable);
red_cuda_status_t red_cuda_graph_destroy(red_cuda_graph_t graph);

/* --- memory ------------------------------------------------------------------------------------------------------- */

/* Bytes of the device's memory, of all processes together. */
red_cuda_status_t red_cuda_memory_info(size_t *free, size_t *total);
red_cuda_status_t red_cuda_memory_allocate(size_t bytes, red_cuda_address_t *address);
red_cuda_status_t red_cuda_memory_free(red_cuda_address_t address);
red_cuda_status_t red_cuda_memory_set(red_cuda_address_t address, uint8_t value, size_t bytes, red_cuda_stream_t stream);
/* Pinned memory of the host, from and to which copies do not wait. */
red_cuda_status_t red_cuda_host_allocate(size_t bytes, void **address);
red_cuda_status_t red_cuda_host_free(void *address);
red_cuda_status_t red_cuda_copy_to_device(red_cuda_address_t to, const void *from, size_t bytes,
                                          red_cuda_stream_t stream);
red_cuda_status_t red_cuda_copy_to_host(void *to, red_cuda_address_t from, size_t bytes, red_cuda_stream_t stream);

#ifdef __cplusplus
}
#endif

#endif
