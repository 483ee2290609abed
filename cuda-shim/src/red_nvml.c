/* The few calls of NVIDIA's management library that tell a device's use. See red_nvml.h. */
#include "red_nvml.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <string.h>

#define LIBRARY "libnvidia-ml.so.1"

struct nvmlDevice_st;
/* nvmlUtilization_t: percent of the last sampling period. */
struct utilisation {
    unsigned gpu, memory;
};

static struct {
    bool is_loaded;
    unsigned (*init)(void);
    unsigned (*handle)(const char *bus_id, struct nvmlDevice_st **device);
    unsigned (*utilisation)(struct nvmlDevice_st *device, struct utilisation *used);
} nvml;

static bool look_up(void *library, const char *name, void *field)
{
    void *found = dlsym(library, name);
    memcpy(field, &found, sizeof found);
    return found != NULL;
}

int32_t red_nvml_open(const char *bus_id, void **device)
{
    if (!nvml.is_loaded) {
        void *library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
        if (library == NULL || !look_up(library, "nvmlInit_v2", &nvml.init) ||
            !look_up(library, "nvmlDeviceGetHandleByPciBusId_v2", &nvml.handle) ||
            !look_up(library, "nvmlDeviceGetUtilizationRates", &nvml.utilisation)) {
            return RED_NVML_NONE;
        }
        const unsigned error = nvml.init();
        if (error != 0) {
            return (int32_t)error;
        }
        nvml.is_loaded = true;
    }
    struct nvmlDevice_st *found = NULL;
    const unsigned error = nvml.handle(bus_id, &found);
    if (error != 0) {
        return (int32_t)error;
    }
    *device = found;
    return 0;
}

int32_t red_nvml_utilisation(void *device, uint32_t *percent)
{
    struct utilisation used = {0, 0};
    if (!nvml.is_loaded) {
        return RED_NVML_NONE;
    }
    const unsigned error = nvml.utilisation(device, &used);
    if (error == 0) {
        *percent = used.gpu;
    }
    return (int32_t)error;
}
