/* A body for a pool of kind cuda that allocates while it runs. */
#include <dlfcn.h>
#include <stddef.h>

#include "red_plugin.h"

int allocates(void *user, const red_plugin_context *context)
{
    (void)user;
    void *driver = dlopen("libcuda.so.1", RTLD_NOW | RTLD_NOLOAD);
    unsigned (*allocate)(unsigned long long *, size_t);
    *(void **)&allocate = driver == NULL ? NULL : dlsym(driver, "cuMemAlloc_v2");
    unsigned long long address;
    if (context->size < offsetof(red_plugin_context, stream) + sizeof context->stream || context->stream == NULL) {
        return 1;
    }
    return allocate != NULL && allocate(&address, 4096) == 0 ? 0 : 2;
}
