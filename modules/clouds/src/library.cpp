#include <alpenglow/clouds/library.hpp>

#include <alpenglow/clouds/vdb.hpp>

#include <cassert>

namespace alpenglow::clouds {

SparseGrid coarsen(const SparseGrid& grid, int level) {
    assert(level >= 0 && level < 8);
    if (level == 0) {
        return grid;
    }
    const int factor = 1 << level;
    const auto floor_div = [factor](int a) { return a >= 0 ? a / factor : -((-a + factor - 1) / factor); };
    const glm::ivec3 low = grid.min();
    const glm::ivec3 high = grid.min() + grid.table().bricks() * 8 - 1;
    const glm::ivec3 first(floor_div(low.x), floor_div(low.y), floor_div(low.z));
    const glm::ivec3 last(floor_div(high.x), floor_div(high.y), floor_div(high.z));
    GridTransform transform = grid.transform();
    // Coarse voxel i is the mean of fine voxels factor i .. factor i + factor - 1: its centre lies among them.
    transform.origin_m = grid.transform().world_from_index(glm::dvec3(0.5 * (factor - 1)));
    transform.voxel_m = grid.transform().voxel_m * double(factor);
    SparseGrid out(first, grid.table().count() == 0 ? glm::ivec3(0) : last - first + 1, transform);
    const float weight = 1.0F / static_cast<float>(factor * factor * factor);
    for (std::int32_t b = 0; b < grid.table().count(); ++b) {
        const glm::ivec3 corner = grid.min() + grid.table().coordinates()[std::size_t(b)] * 8;
        const float* values = grid.brick(b);
        for (int i = 0; i < SparseGrid::brick_voxels; ++i) {
            if (values[i] > 0.0F) {
                const glm::ivec3 v = corner + glm::ivec3(i & 7, (i >> 3) & 7, i >> 6);
                const glm::ivec3 c = glm::ivec3(floor_div(v.x), floor_div(v.y), floor_div(v.z)) - out.min();
                out.brick(c.x >> 3, c.y >> 3, c.z >> 3)[((c.z & 7) * 8 + (c.y & 7)) * 8 + (c.x & 7)] +=
                    values[i] * weight;
            }
        }
    }
    return out;
}

Result<std::shared_ptr<const BrickVolume>> CloudLibrary::load(const std::string& path, const std::string& grid_name,
                                                              int level) {
    const std::string key = path + '\n' + grid_name + '\n' + std::to_string(level);
    if (const auto found = entries_.find(key); found != entries_.end()) {
        found->second.last_use = ++clock_;
        return found->second.volume;
    }
    const auto vdb = load_vdb(path, grid_name);
    if (!vdb) {
        return vdb.error();
    }
    const auto grid = sparse_from_vdb(*vdb, path + ": " + vdb->name());
    if (!grid) {
        return grid.error();
    }
    auto volume = std::make_shared<const BrickVolume>(level == 0 ? *grid : coarsen(*grid, level));
    const std::size_t bytes = volume->memory_bytes();
    while (used_ + bytes > budget_) {
        auto oldest = entries_.end();
        for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
            if (entry->second.volume.use_count() == 1 &&
                (oldest == entries_.end() || entry->second.last_use < oldest->second.last_use)) {
                oldest = entry;
            }
        }
        if (oldest == entries_.end()) {
            return Error{
                "its bricks take " + std::to_string(bytes) + " bytes, and clouds in use take " + std::to_string(used_),
                path, "at most " + std::to_string(budget_) + " bytes in all: a larger budget, or a coarser level"};
        }
        used_ -= oldest->second.bytes;
        entries_.erase(oldest);
    }
    used_ += bytes;
    entries_[key] = {volume, bytes, ++clock_};
    return std::shared_ptr<const BrickVolume>(volume);
}

} // namespace alpenglow::clouds
