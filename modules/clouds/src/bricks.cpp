#include <alpenglow/clouds/bricks.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {

BrickVolume::BrickVolume(const SparseGrid& grid) : min_(grid.min() - 8), transform_(grid.transform()) {
    // One more layer of bricks on the near sides: the apron there interpolates between nothing and the first voxels.
    table_ = BrickTable(grid.table().bricks() + 1);
    const BrickTable& from = grid.table();
    for (std::int32_t b = 0; b < from.count(); ++b) {
        const glm::ivec3& c = from.coordinates()[std::size_t(b)];
        const float* values = grid.brick(b);
        bool any = false;
        bool faces[8] = {}; // bit a set: the apron of the neighbour on axis a's near side sees a voxel > 0
        for (int i = 0; i < SparseGrid::brick_voxels; ++i) {
            if (values[i] > 0.0F) {
                any = true;
                const glm::ivec3 v(i & 7, (i >> 3) & 7, i >> 6);
                const glm::ivec3 voxel = grid.min() + c * 8 + v;
                for (int a = 0; a < 3; ++a) {
                    active_low_[a] = active_ == 0 ? voxel[a] : std::min(active_low_[a], voxel[a]);
                    active_high_[a] = active_ == 0 ? voxel[a] : std::max(active_high_[a], voxel[a]);
                }
                ++active_;
                max_density_ = std::max(max_density_, values[i]);
                for (int mask = 1; mask < 8; ++mask) {
                    faces[mask] = faces[mask] || (((mask & 1) == 0 || v.x == 0) && ((mask & 2) == 0 || v.y == 0) &&
                                                  ((mask & 4) == 0 || v.z == 0));
                }
            }
        }
        if (any) {
            faces[0] = true;
            for (int mask = 0; mask < 8; ++mask) {
                if (faces[mask]) {
                    table_.insert(c.x + 1 - (mask & 1), c.y + 1 - ((mask >> 1) & 1), c.z + 1 - ((mask >> 2) & 1));
                }
            }
        }
    }
    const auto count = static_cast<std::size_t>(table_.count());
    if (count == 0) {
        return;
    }
    scale_.assign(count, 0.0F);
    offset_.assign(count, 0.0F);
    data_.assign(count * brick_stride, 0);
    parallel_for(count, 64, [&](std::size_t begin, std::size_t end) {
        float values[brick_voxels];
        for (std::size_t b = begin; b < end; ++b) {
            const glm::ivec3 first = min_ + table_.coordinates()[b] * 8;
            float low = 1e30F;
            float high = 0.0F;
            for (int i = 0; i < brick_voxels; ++i) {
                const float v = grid.value(first.x + i % 9, first.y + i / 9 % 9, first.z + i / 81);
                values[i] = v;
                low = std::min(low, v);
                high = std::max(high, v);
            }
            const float scale = (high - low) / 255.0F;
            scale_[b] = scale;
            offset_[b] = low;
            for (int i = 0; scale > 0.0F && i < brick_voxels; ++i) {
                data_[b * brick_stride + std::size_t(i)] =
                    static_cast<std::uint8_t>(std::clamp((values[i] - low) / scale + 0.5F, 0.0F, 255.0F));
            }
        }
    });
}

float BrickVolume::sample(const glm::vec3& index) const {
    const float px = index.x - static_cast<float>(min_.x);
    const float py = index.y - static_cast<float>(min_.y);
    const float pz = index.z - static_cast<float>(min_.z);
    const glm::ivec3 s = size();
    if (!(px >= 0.0F && py >= 0.0F && pz >= 0.0F && px < static_cast<float>(s.x) && py < static_cast<float>(s.y) &&
          pz < static_cast<float>(s.z))) {
        return 0.0F;
    }
    const int ix = static_cast<int>(px);
    const int iy = static_cast<int>(py);
    const int iz = static_cast<int>(pz);
    const std::int32_t b = table_.find(ix >> 3, iy >> 3, iz >> 3);
    if (b < 0) {
        return 0.0F;
    }
    const std::uint8_t* at = data_.data() + std::size_t(b) * brick_stride + (iz & 7) * 81 + (iy & 7) * 9 + (ix & 7);
    const float tx = px - static_cast<float>(ix);
    const float ty = py - static_cast<float>(iy);
    const float tz = pz - static_cast<float>(iz);
    const auto lerp = [](float u, float v, float t) { return u + t * (v - u); };
    const auto row = [&](int o) { return lerp(at[o], at[o + 1], tx); };
    return offset_[std::size_t(b)] +
           scale_[std::size_t(b)] * lerp(lerp(row(0), row(9), ty), lerp(row(81), row(90), ty), tz);
}

std::size_t BrickVolume::memory_bytes() const {
    return table_.memory_bytes() + (scale_.size() + offset_.size()) * sizeof(float) + data_.size();
}

std::vector<float> BrickVolume::block_means(const glm::ivec3& first, const glm::ivec3& dims, int factor) const {
    assert(factor >= 1);
    std::vector<float> means(std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z), 0.0F);
    const float weight = 1.0F / static_cast<float>(factor * factor * factor);
    // Bricks in the order of their slabs of blocks would race; one slab of brick layers at a time is handled by one
    // thread when blocks do not straddle it. They may, so each thread owns a range of block layers and visits all
    // bricks in it.
    const std::size_t grain = std::max<std::size_t>(1, std::size_t(dims.z) / 8);
    parallel_for(std::size_t(dims.z), grain, [&](std::size_t begin, std::size_t end) {
        const int z0 = first.z + static_cast<int>(begin) * factor;
        const int z1 = first.z + static_cast<int>(end) * factor; // voxels z0 .. z1 - 1 are this thread's
        for (std::int32_t b = 0; b < table_.count(); ++b) {
            const glm::ivec3 corner = min_ + table_.coordinates()[std::size_t(b)] * 8;
            if (corner.z >= z1 || corner.z + 8 <= z0) {
                continue;
            }
            const float scale = scale_[std::size_t(b)];
            const float offset = offset_[std::size_t(b)];
            const std::uint8_t* data = data_.data() + std::size_t(b) * brick_stride;
            for (int z = std::max(0, z0 - corner.z); z < std::min(8, z1 - corner.z); ++z) {
                const int cz = (corner.z + z - first.z) / factor;
                for (int y = 0; y < 8; ++y) {
                    const int vy = corner.y + y - first.y;
                    if (vy < 0 || vy / factor >= dims.y) {
                        continue;
                    }
                    float* row = means.data() + (std::size_t(cz) * std::size_t(dims.y) + std::size_t(vy / factor)) *
                                                    std::size_t(dims.x);
                    for (int x = 0; x < 8; ++x) {
                        const int vx = corner.x + x - first.x;
                        if (vx >= 0 && vx < dims.x * factor) {
                            row[vx / factor] += offset + scale * static_cast<float>(data[z * 81 + y * 9 + x]);
                        }
                    }
                }
            }
        }
        const std::size_t plane = std::size_t(dims.x) * std::size_t(dims.y);
        for (std::size_t i = begin * plane; i < end * plane; ++i) {
            means[i] *= weight;
        }
    });
    return means;
}

} // namespace alpenglow::clouds
