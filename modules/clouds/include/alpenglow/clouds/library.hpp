// Many clouds within a memory budget.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include <alpenglow/clouds/bricks.hpp>
#include <alpenglow/core/result.hpp>

namespace alpenglow::clouds {

// Means over 2^level voxels a side: the level of detail for clouds that are far away.
[[nodiscard]] SparseGrid coarsen(const SparseGrid& grid, int level);

// Volumes from .vdb files, each read once and shared. When a new one would break the budget, those that nobody else
// holds go, the longest unused first.
class CloudLibrary {
public:
    explicit CloudLibrary(std::size_t budget_bytes) : budget_(budget_bytes) {}

    // grid_name as in load_vdb(). level: as in coarsen(). Errors name the file, and the bytes where the budget is too
    // small.
    [[nodiscard]] Result<std::shared_ptr<const BrickVolume>> load(const std::string& path,
                                                                  const std::string& grid_name = {}, int level = 0);

    [[nodiscard]] std::size_t memory_bytes() const { return used_; }
    [[nodiscard]] std::size_t volumes() const { return entries_.size(); }

private:
    struct Entry {
        std::shared_ptr<const BrickVolume> volume;
        std::size_t bytes = 0;
        std::uint64_t last_use = 0;
    };
    std::size_t budget_;
    std::size_t used_ = 0;
    std::uint64_t clock_ = 0;
    std::map<std::string, Entry> entries_;
};

} // namespace alpenglow::clouds
