/* A stand-in for libnvidia-ml.so.1, with what is asked of it. The line `load 87` of the script says how busy the device is, in
 * percent; without it the device is not known. */
#include <stddef.h>

#include "stand_in.h"

unsigned nvmlInit_v2(void);
unsigned nvmlDeviceGetHandleByPciBusId_v2(const char *bus_id, void **device);
unsigned nvmlDeviceGetUtilizationRates(void *device, unsigned used[2]);

static char device_of_nvml;

unsigned nvmlInit_v2(void)
{
    sleep_us(script_of("delay", "nvmlInit_v2", 0));
    return 0;
}

unsigned nvmlDeviceGetHandleByPciBusId_v2(const char *bus_id, void **device)
{
    (void)bus_id;
    *device = &device_of_nvml;
    /* NVML_ERROR_NOT_FOUND. */
    return script_number("load", 101) > 100 ? 6 : 0;
}

unsigned nvmlDeviceGetUtilizationRates(void *device, unsigned used[2])
{
    (void)device;
    used[0] = (unsigned)script_number("load", 0);
    used[1] = 0;
    return 0;
}
