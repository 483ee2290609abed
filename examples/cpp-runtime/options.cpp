#include "options.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>

Options options_of(int count, char **words) {
    Options options;
    for (int i = 1; i < count; i++) {
        char *end = nullptr;
        if (std::strcmp(words[i], "--best-effort") == 0) {
            options.best_effort = true;
        } else if (std::strcmp(words[i], "--seconds") == 0 && i + 1 < count) {
            const long seconds = std::strtol(words[++i], &end, 10);
            options.wrong |= *end != '\0' || seconds < 1 || seconds > 86'400;
            options.seconds = options.wrong ? 0 : static_cast<int>(seconds);
        } else {
            options.wrong = true;
        }
    }
    if (options.wrong) {
        std::fprintf(stderr, "usage: cpp-runtime [--seconds 1..86400] [--best-effort]\n");
    }
    return options;
}
