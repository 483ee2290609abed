// A runtime that is started where the process may take so much memory and no more: it runs, or is refused and can be
// started later, whatever that limit is.
#include "tests.hpp"

#include <cstdio>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

constexpr rlim_t kib = 1024, step = 256 * kib, most = 32 * 1024 * kib;
enum class Ended : int { Started = 0, Refused = 1, Wrong = 2 };

/// What this process has mapped, in bytes.
rlim_t mapped() {
    unsigned long pages = 0;
    std::FILE *statm = std::fopen("/proc/self/statm", "r");
    CHECK(statm != nullptr && std::fscanf(statm, "%lu", &pages) == 1);
    std::fclose(statm);
    return static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

Ended start_with(rlim_t more) {
    auto runtime = red::Runtime::open(red::Config::redrt().lanes(2), red::RuntimeConfig::best_effort().duration(1ms));
    rlimit before{};
    if (!runtime.ok() || getrlimit(RLIMIT_AS, &before) != 0) {
        return Ended::Wrong;
    }
    rlimit tight = before;
    tight.rlim_cur = mapped() + more;
    if (setrlimit(RLIMIT_AS, &tight) != 0) {
        return Ended::Wrong;
    }
    const auto started = runtime->start();
    if (started.ok()) {
        return runtime->wait().ok() ? Ended::Started : Ended::Wrong;
    }
    char text[1024];
    std::fprintf(stderr, "%s%s", started == RED_STATUS_NO_MEMORY ? "" : started.text(), runtime->message(text));
    if (started != RED_STATUS_NO_MEMORY || setrlimit(RLIMIT_AS, &before) != 0) {
        return Ended::Wrong;
    }
    return runtime->start().ok() && runtime->wait().ok() ? Ended::Refused : Ended::Wrong;
}

} // namespace

int main() {
    unsigned started = 0, refused = 0;
    for (rlim_t more = 0; more <= most; more += step) {
        const pid_t child = fork();
        if (child == 0) {
            _exit(static_cast<int>(start_with(more)));
        }
        int how = 0;
        CHECK(child > 0 && waitpid(child, &how, 0) == child);
        const bool is_told = WIFEXITED(how) && WEXITSTATUS(how) < static_cast<int>(Ended::Wrong);
        if (!is_told) {
            std::fprintf(stderr, "with %lu KiB: %x\n", static_cast<unsigned long>(more / kib), static_cast<unsigned>(how));
        }
        CHECK(is_told);
        started += is_told && WEXITSTATUS(how) == static_cast<int>(Ended::Started);
        refused += is_told && WEXITSTATUS(how) == static_cast<int>(Ended::Refused);
    }
    std::printf("started %u, refused first %u\n", started, refused);
    CHECK(started > 0 && refused > 0);
    return check_end("little_memory");
}
