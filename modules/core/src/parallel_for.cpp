#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstdlib>
#include <thread>
#include <vector>

namespace alpenglow {

unsigned parallel_threads() noexcept {
    static const unsigned count = [] {
        if (const char* text = std::getenv("ALPENGLOW_THREADS")) {
            const long asked = std::strtol(text, nullptr, 10);
            if (asked > 0 && asked < 4096) {
                return static_cast<unsigned>(asked);
            }
        }
        return std::max(1U, std::thread::hardware_concurrency());
    }();
    return count;
}

void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body,
                  unsigned threads) {
    assert(grain > 0);
    if (count == 0) {
        return;
    }
    const std::size_t chunks = (count + grain - 1) / grain;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t chunk = next.fetch_add(1); chunk < chunks; chunk = next.fetch_add(1)) {
            const std::size_t begin = chunk * grain;
            body(begin, std::min(count, begin + grain));
        }
    };
    const std::size_t wanted = threads == 0 ? parallel_threads() : threads;
    std::vector<std::thread> helpers;
    helpers.reserve(std::min(wanted, chunks) - 1);
    for (std::size_t i = 1; i < std::min(wanted, chunks); ++i) {
        helpers.emplace_back(work);
    }
    work();
    for (std::thread& helper : helpers) {
        helper.join();
    }
}

} // namespace alpenglow
