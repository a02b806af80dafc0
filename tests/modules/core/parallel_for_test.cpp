#include <alpenglow/core/parallel_for.hpp>

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <vector>

namespace alpenglow {
namespace {

TEST(ParallelFor, VisitsEachItemOnceWhateverTheThreads) {
    for (const unsigned threads : {1U, 2U, 7U}) {
        for (const std::size_t count :
             {std::size_t{0}, std::size_t{1}, std::size_t{63}, std::size_t{64}, std::size_t{1000}}) {
            std::vector<std::atomic<int>> visits(count);
            parallel_for(
                count, 64,
                [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i) {
                        ++visits[i];
                    }
                },
                threads);
            for (const auto& n : visits) {
                EXPECT_EQ(n.load(), 1);
            }
        }
    }
}

TEST(ParallelFor, ChunkBordersDependOnTheGrainAlone) {
    const auto borders = [](unsigned threads) {
        std::mutex mutex;
        std::set<std::pair<std::size_t, std::size_t>> seen;
        parallel_for(
            1000, 37,
            [&](std::size_t begin, std::size_t end) {
                const std::lock_guard lock(mutex);
                seen.emplace(begin, end);
            },
            threads);
        return seen;
    };
    EXPECT_EQ(borders(1), borders(5));
}

} // namespace
} // namespace alpenglow
