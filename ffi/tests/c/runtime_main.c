/* The runtime. */
#include "runtime.h"

int main(void) {
    test_set_up();
    test_runtime_tasks();
    test_run();
    test_ends();
    test_memory();
    test_runtime_pointers();
    return report();
}
