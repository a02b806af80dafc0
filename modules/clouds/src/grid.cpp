#include <alpenglow/clouds/grid.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {

glm::dvec3 GridTransform::world_from_index(const glm::dvec3& index) const {
    return origin_m + axes * (voxel_m * index);
}

glm::dvec3 GridTransform::index_from_world(const glm::dvec3& world_m) const {
    return local_direction(world_m - origin_m) / voxel_m;
}

glm::dvec3 GridTransform::local_direction(const glm::dvec3& world) const {
    const auto dot = [](const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
    return {dot(axes[0], world), dot(axes[1], world), dot(axes[2], world)};
}

BrickTable::BrickTable(const glm::ivec3& bricks)
    : bricks_(bricks), nodes_((bricks.x + 7) / 8, (bricks.y + 7) / 8, (bricks.z + 7) / 8) {
    assert(bricks.x >= 0 && bricks.y >= 0 && bricks.z >= 0);
    node_.assign(std::size_t(nodes_.x) * std::size_t(nodes_.y) * std::size_t(nodes_.z), -1);
}

namespace {

std::size_t node_number(const glm::ivec3& nodes, int x, int y, int z) {
    return (std::size_t(z >> 3) * std::size_t(nodes.y) + std::size_t(y >> 3)) * std::size_t(nodes.x) +
           std::size_t(x >> 3);
}

std::int32_t place_in_node(int x, int y, int z) {
    return ((z & 7) * 8 + (y & 7)) * 8 + (x & 7);
}

} // namespace

std::int32_t BrickTable::find(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= bricks_.x || y >= bricks_.y || z >= bricks_.z) {
        return -1;
    }
    const std::int32_t node = node_[node_number(nodes_, x, y, z)];
    return node < 0 ? -1 : entry_[std::size_t(node + place_in_node(x, y, z))];
}

std::int32_t BrickTable::insert(int x, int y, int z) {
    assert(x >= 0 && y >= 0 && z >= 0 && x < bricks_.x && y < bricks_.y && z < bricks_.z);
    std::int32_t& node = node_[node_number(nodes_, x, y, z)];
    if (node < 0) {
        node = static_cast<std::int32_t>(entry_.size());
        entry_.resize(entry_.size() + 512, -1);
    }
    std::int32_t& entry = entry_[std::size_t(node + place_in_node(x, y, z))];
    if (entry < 0) {
        entry = count();
        coordinates_.emplace_back(x, y, z);
    }
    return entry;
}

std::size_t BrickTable::memory_bytes() const {
    return (node_.size() + entry_.size()) * sizeof(std::int32_t) + coordinates_.size() * sizeof(glm::ivec3);
}

SparseGrid::SparseGrid(const glm::ivec3& min, const glm::ivec3& size, const GridTransform& transform)
    : min_(min.x & ~7, min.y & ~7, min.z & ~7), transform_(transform) {
    const glm::ivec3 end = min + size;
    table_ = BrickTable(glm::ivec3((end.x - min_.x + 7) / 8, (end.y - min_.y + 7) / 8, (end.z - min_.z + 7) / 8));
}

float SparseGrid::value(int x, int y, int z) const {
    const int lx = x - min_.x;
    const int ly = y - min_.y;
    const int lz = z - min_.z;
    if (lx < 0 || ly < 0 || lz < 0) {
        return 0.0F;
    }
    const std::int32_t b = table_.find(lx >> 3, ly >> 3, lz >> 3);
    return b < 0 ? 0.0F : brick(b)[place_in_node(lx, ly, lz)];
}

float SparseGrid::sample(double x, double y, double z) const {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const double fz = std::floor(z);
    const auto tx = static_cast<float>(x - fx);
    const auto ty = static_cast<float>(y - fy);
    const auto tz = static_cast<float>(z - fz);
    const int ix = static_cast<int>(fx);
    const int iy = static_cast<int>(fy);
    const int iz = static_cast<int>(fz);
    const auto lerp = [](float a, float b, float t) { return a + t * (b - a); };
    const auto row = [&](int dy, int dz) {
        return lerp(value(ix, iy + dy, iz + dz), value(ix + 1, iy + dy, iz + dz), tx);
    };
    return lerp(lerp(row(0, 0), row(1, 0), ty), lerp(row(0, 1), row(1, 1), ty), tz);
}

float* SparseGrid::brick(int x, int y, int z) {
    const std::int32_t number = table_.insert(x, y, z);
    const std::size_t needed = (std::size_t(number) + 1) * brick_voxels;
    if (values_.size() < needed) {
        values_.resize(needed, 0.0F);
    }
    return brick(number);
}

std::size_t SparseGrid::active_voxels() const {
    return static_cast<std::size_t>(std::count_if(values_.begin(), values_.end(), [](float v) { return v > 0.0F; }));
}

float SparseGrid::max_density() const {
    return values_.empty() ? 0.0F : *std::max_element(values_.begin(), values_.end());
}

std::size_t SparseGrid::memory_bytes() const {
    return table_.memory_bytes() + values_.size() * sizeof(float);
}

void SparseGrid::prune() {
    BrickTable kept(table_.bricks());
    std::vector<float> values;
    for (std::int32_t b = 0; b < table_.count(); ++b) {
        const float* from = brick(b);
        if (std::any_of(from, from + brick_voxels, [](float v) { return v > 0.0F; })) {
            const glm::ivec3& c = table_.coordinates()[std::size_t(b)];
            kept.insert(c.x, c.y, c.z);
            values.insert(values.end(), from, from + brick_voxels);
        }
    }
    table_ = std::move(kept);
    values_ = std::move(values);
}

} // namespace alpenglow::clouds
