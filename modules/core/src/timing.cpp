#include <alpenglow/core/timing.hpp>

#include <ctime>

namespace alpenglow {
namespace {
double read_clock(clockid_t id) noexcept {
    timespec now{};
    clock_gettime(id, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
} // namespace

double thread_cpu_seconds() noexcept {
    return read_clock(CLOCK_THREAD_CPUTIME_ID);
}
double process_cpu_seconds() noexcept {
    return read_clock(CLOCK_PROCESS_CPUTIME_ID);
}
double wall_seconds() noexcept {
    return read_clock(CLOCK_MONOTONIC);
}

} // namespace alpenglow
