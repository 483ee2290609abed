/* Our prototypes of the driver's entry points, and their names, against NVIDIA's header: whatever differs does not compile. */
#include <cuda.h>

#include "../src/driver_api.h"

#if CUDA_VERSION < 11040
#error "entry points that are optional are declared from CUDA 11.4 on"
#endif

#define CHECK(field, name, parameters) \
    _Static_assert(__builtin_types_compatible_p(__typeof__(name), unsigned parameters), #name);
RED_CUDA_REQUIRED(CHECK)
RED_CUDA_OPTIONAL(CHECK)
