/* Two copies of the library in one process: one is part of this program, the other is loaded by the name that it is given. */
#include <dlfcn.h>
#include <stdio.h>

#include <red.h>

static _Alignas(RED_ALIGN) unsigned char memory[RED_DAG_4X16X16_BYTES], others[RED_DAG_4X16X16_BYTES];

typedef red_status open_dag(void *, size_t, red_dag *);
typedef red_status close_dag(red_dag *);
typedef red_status add_node(red_dag *, const red_node *, uint32_t *);

#define SAY(call) printf("%s: %d\n", #call, (int)(call))

int main(int count, char **words) {
    void *library = dlopen(count > 1 ? words[1] : "", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        puts(dlerror());
        return 2;
    }
    /* What is loaded later finds its own functions, and not those of this program. */
    open_dag *open_there = (open_dag *)dlsym(library, "red_dag_open_4x16x16");
    close_dag *close_there = (close_dag *)dlsym(library, "red_dag_close");
    add_node *add_there = (add_node *)dlsym(library, "red_dag_add_node");
    uint32_t (*version_there)(void) = (uint32_t(*)(void))dlsym(library, "red_abi_version");
    red_dag here, there;
    red_node node = RED_NODE_INIT;
    uint32_t number;
    printf("versions: %u and %u\n", (unsigned)red_abi_version(), (unsigned)version_there());
    SAY(red_dag_open_4x16x16(memory, sizeof memory, &here));
    SAY(open_there(others, sizeof others, &there));
    SAY(add_there(&here, &node, &number));
    SAY(red_dag_add_node(&there, &node, &number));
    SAY(close_there(&here));
    SAY(red_dag_close(&there));
    SAY(red_dag_add_node(&here, &node, &number));
    SAY(add_there(&there, &node, &number));
    SAY(red_dag_close(&here));
    SAY(close_there(&there));
    return 0;
}
