// Progress and cancelling of a parallel loop.
#pragma once

#include <alpenglow/core/timing.hpp>
#include <alpenglow/prt/bake.hpp>

#include <algorithm>
#include <atomic>
#include <mutex>

namespace alpenglow::prt {

// Calls the user's callback, one thread at a time and not too often, and remembers a refusal.
class Ticker {
public:
    Ticker(const ProgressCallback& callback, const char* stage, double from, double to, std::size_t total)
        : callback_(callback), stage_(stage), from_(from), to_(to), total_(static_cast<double>(total)),
          start_(wall_seconds()) {}
    [[nodiscard]] bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
    void done(std::size_t items) {
        const std::size_t count = done_.fetch_add(items) + items;
        if (!callback_) {
            return;
        }
        const std::unique_lock lock(mutex_, std::try_to_lock);
        const double now = wall_seconds();
        if (!lock.owns_lock() || now - last_ < 0.05 || cancelled()) {
            return;
        }
        last_ = now;
        const double part = static_cast<double>(count) / total_;
        const double remaining = (now - start_) * (1.0 - part) / std::max(part, 1e-9);
        if (!callback_(Progress{from_ + (to_ - from_) * part, remaining, stage_})) {
            cancelled_.store(true);
        }
    }

private:
    const ProgressCallback& callback_;
    const char* stage_;
    double from_;
    double to_;
    double total_;
    double start_;
    double last_ = 0.0;
    std::atomic<std::size_t> done_{0};
    std::atomic<bool> cancelled_{false};
    std::mutex mutex_;
};

} // namespace alpenglow::prt
