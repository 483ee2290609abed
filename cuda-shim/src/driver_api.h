/* The entry points of libcuda.so.1 that are used, with prototypes of our own: no CUDA header is needed, and one binary
 * runs from CUDA 10.2 (JetPack 4) on. Where a check has NVIDIA's header, it compiles this table against it.
 *
 * Results and enumerations are unsigned int, as compilers make them of the driver's. */
#ifndef RED_CUDA_DRIVER_API_H
#define RED_CUDA_DRIVER_API_H

#include <stddef.h>

struct CUctx_st;
struct CUevent_st;
struct CUfunc_st;
struct CUgraph_st;
struct CUgraphExec_st;
struct CUgraphNode_st;
struct CUmod_st;
struct CUstream_st;

/* X(field of the table, name in the library, parameters). Names with _v2 are what cuda.h makes of the plain ones. */
#define RED_CUDA_REQUIRED(X)                                                                                            \
    X(init, cuInit, (unsigned flags))                                                                                   \
    X(driver_version, cuDriverGetVersion, (int *version))                                                               \
    X(error_name, cuGetErrorName, (unsigned error, const char **name))                                                  \
    X(error_string, cuGetErrorString, (unsigned error, const char **text))                                              \
    X(device_count, cuDeviceGetCount, (int *count))                                                                     \
    X(device_get, cuDeviceGet, (int *device, int ordinal))                                                              \
    X(device_name, cuDeviceGetName, (char *name, int size, int device))                                                 \
    X(device_attribute, cuDeviceGetAttribute, (int *value, unsigned attribute, int device))                             \
    X(device_bus_id, cuDeviceGetPCIBusId, (char *id, int size, int device))                                             \
    X(context_retain, cuDevicePrimaryCtxRetain, (struct CUctx_st * *context, int device))                               \
    X(context_set, cuCtxSetCurrent, (struct CUctx_st * context))                                                        \
    X(context_synchronize, cuCtxSynchronize, (void))                                                                    \
    X(context_priorities, cuCtxGetStreamPriorityRange, (int *least, int *greatest))                                     \
    X(stream_create, cuStreamCreateWithPriority, (struct CUstream_st * *stream, unsigned flags, int priority))          \
    X(stream_destroy, cuStreamDestroy_v2, (struct CUstream_st * stream))                                                \
    X(stream_wait, cuStreamWaitEvent, (struct CUstream_st * stream, struct CUevent_st * event, unsigned flags))         \
    X(stream_begin_capture, cuStreamBeginCapture_v2, (struct CUstream_st * stream, unsigned mode))                      \
    X(stream_end_capture, cuStreamEndCapture, (struct CUstream_st * stream, struct CUgraph_st * *graph))                \
    X(launch_host, cuLaunchHostFunc, (struct CUstream_st * stream, void (*function)(void *), void *argument))           \
    X(event_create, cuEventCreate, (struct CUevent_st * *event, unsigned flags))                                        \
    X(event_destroy, cuEventDestroy_v2, (struct CUevent_st * event))                                                    \
    X(event_record, cuEventRecord, (struct CUevent_st * event, struct CUstream_st * stream))                            \
    X(event_query, cuEventQuery, (struct CUevent_st * event))                                                           \
    X(event_elapsed, cuEventElapsedTime, (float *milliseconds, struct CUevent_st *from, struct CUevent_st *to))         \
    X(module_load, cuModuleLoadDataEx,                                                                                  \
      (struct CUmod_st * *module, const void *image, unsigned count, unsigned *options, void **values))                 \
    X(module_unload, cuModuleUnload, (struct CUmod_st * module))                                                        \
    X(module_function, cuModuleGetFunction, (struct CUfunc_st * *function, struct CUmod_st *module, const char *name))  \
    X(launch_kernel, cuLaunchKernel,                                                                                    \
      (struct CUfunc_st * function, unsigned grid_x, unsigned grid_y, unsigned grid_z, unsigned block_x,                \
       unsigned block_y, unsigned block_z, unsigned shared_bytes, struct CUstream_st *stream, void **arguments,         \
       void **extra))                                                                                                   \
    X(graph_launch, cuGraphLaunch, (struct CUgraphExec_st * graph, struct CUstream_st * stream))                        \
    X(graph_exec_destroy, cuGraphExecDestroy, (struct CUgraphExec_st * graph))                                          \
    X(graph_destroy, cuGraphDestroy, (struct CUgraph_st * graph))                                                       \
    X(memory_info, cuMemGetInfo_v2, (size_t * free, size_t * total))                                                    \
    X(memory_allocate, cuMemAlloc_v2, (unsigned long long *address, size_t bytes))                                      \
    X(memory_free, cuMemFree_v2, (unsigned long long address))                                                          \
    X(memory_set, cuMemsetD8Async,                                                                                      \
      (unsigned long long address, unsigned char value, size_t bytes, struct CUstream_st *stream))                      \
    X(host_allocate, cuMemHostAlloc, (void **address, size_t bytes, unsigned flags))                                    \
    X(host_free, cuMemFreeHost, (void *address))                                                                        \
    X(copy_to_device, cuMemcpyHtoDAsync_v2,                                                                             \
      (unsigned long long to, const void *from, size_t bytes, struct CUstream_st *stream))                              \
    X(copy_to_host, cuMemcpyDtoHAsync_v2,                                                                               \
      (void *to, unsigned long long from, size_t bytes, struct CUstream_st *stream))

/* Not in every driver: of each of these and its older one below there is one. */
#define RED_CUDA_OPTIONAL(X)                                                                                            \
    X(context_release, cuDevicePrimaryCtxRelease_v2, (int device))                                                      \
    X(graph_instantiate, cuGraphInstantiateWithFlags,                                                                   \
      (struct CUgraphExec_st * *executable, struct CUgraph_st *graph, unsigned long long flags))

/* As CUDA 10.2 has them; newer headers give these names to newer entry points. */
#define RED_CUDA_OLDER(X)                                                                                               \
    X(context_release_10, cuDevicePrimaryCtxRelease, (int device))                                                      \
    X(graph_instantiate_10, cuGraphInstantiate,                                                                         \
      (struct CUgraphExec_st * *executable, struct CUgraph_st *graph, struct CUgraphNode_st **error_node,               \
       char *log, size_t log_size))

#endif
