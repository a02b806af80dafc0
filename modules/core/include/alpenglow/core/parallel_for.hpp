// A data-parallel loop whose result never depends on the number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace alpenglow {

// Calls body(begin, end) for consecutive chunks of [0, count), each `grain` long but for the last. Chunk borders depend
// on `grain` alone, so a body that writes only its own items (or reduces per chunk, in chunk order afterwards) gives
// the same bits whatever the thread count. Chunks run on up to `threads` threads, the caller's included
// (0: parallel_threads()). Returns when all are done. The body must not throw.
void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body,
                  unsigned threads = 0);

// The number of threads parallel_for uses by default: ALPENGLOW_THREADS if set to a positive number, else the hardware's.
[[nodiscard]] unsigned parallel_threads() noexcept;

} // namespace alpenglow
