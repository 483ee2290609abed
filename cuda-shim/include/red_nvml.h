/* red_nvml: how busy a GPU is, whoever keeps it so, by NVIDIA's management library, loaded at run time.
 *
 * Functions return 0, an error of the library (an nvmlReturn_t, positive), or RED_NVML_NONE. Outputs are written on 0 only. */
#ifndef RED_NVML_H
#define RED_NVML_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* There is no libnvidia-ml.so.1, or it lacks what is needed: a Jetson has none. */
#define RED_NVML_NONE (-1)

/* A device by its PCI bus id, as cuDeviceGetPCIBusId gives it. Loads the library, once per process: not to be called by two
 * threads at once, and not in real time. */
int32_t red_nvml_open(const char *bus_id, void **device);
/* Percent of the last sampling period, of a sixth of a second to a second, in which a kernel ran. About a millisecond. */
int32_t red_nvml_utilisation(void *device, uint32_t *percent);

#ifdef __cplusplus
}
#endif
#endif
