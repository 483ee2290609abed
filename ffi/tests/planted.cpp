// Mistakes that have to be found: by a sanitizer, by valgrind, by an assertion. One, by its name.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <red.hpp>

using namespace std::chrono_literals;
using Memory = red::DagMemory<red::Caps4x16x16>;

namespace {

/// What the compiler cannot know.
volatile int one = 1;

void overflow() {
    std::array<red::PlacedNode, 1> *nodes = new std::array<red::PlacedNode, 1>;
    std::printf("%u\n", nodes->data()[one].c().node);
    delete nodes;
}

void undefined() {
    int largest = 2'147'483'647;
    largest += one;
    std::printf("%d\n", largest);
}

void leak() {
    volatile const Memory *memory = new Memory;
    memory = nullptr;
    static_cast<void>(memory);
}

/// The memory of an open graph is given back, and the graph is used: by the library, which no sanitizer of C++ watches.
void lent() {
    auto *memory = new Memory;
    auto dag = red::Dag::open(*memory);
    delete memory;
    std::printf("%d\n", dag->add_node(red::Node::ordinary(1ms)).ok());
}

void misuse() {
    const red::Result<red::NodeId> none = RED_STATUS_CYCLE;
    std::printf("%u\n", none.value().value());
}

} // namespace

int main(int count, char **words) {
    const char *what = count > 1 ? words[1] : "";
    const struct {
        const char *name;
        void (*mistake)();
    } all[] = {{"overflow", overflow}, {"undefined", undefined}, {"leak", leak}, {"lent", lent}, {"misuse", misuse}};
    for (const auto &[name, mistake] : all) {
        if (std::strcmp(name, what) == 0) {
            mistake();
            return 0;
        }
    }
    return 2;
}
