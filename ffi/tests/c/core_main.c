/* What there is without an operating system. */
#include "calls.h"

int main(void) {
    test_config();
    test_graph();
    test_handles();
    test_pointers();
    test_tasks();
    test_loop();
    return report();
}
