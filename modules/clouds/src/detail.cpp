#include <alpenglow/clouds/detail.hpp>

#include "noise.hpp"

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {
namespace {

// Distance to the nearest of one feature point a cell, on a lattice that repeats after `period` cells.
float repeating_worley(float x, float y, float z, int period, std::uint32_t seed) {
    const glm::ivec3 base(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)),
                          static_cast<int>(std::floor(z)));
    float nearest = 9.0F;
    for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const auto wrapped = [period](int v) { return (v % period + period) % period; };
                const std::uint32_t h = hash(wrapped(base.x + dx), wrapped(base.y + dy), wrapped(base.z + dz), seed);
                const float px = static_cast<float>(base.x + dx) + static_cast<float>(h & 1023U) / 1024.0F - x;
                const float py = static_cast<float>(base.y + dy) + static_cast<float>((h >> 10) & 1023U) / 1024.0F - y;
                const float pz = static_cast<float>(base.z + dz) + static_cast<float>((h >> 20) & 1023U) / 1024.0F - z;
                nearest = std::min(nearest, px * px + py * py + pz * pz);
            }
        }
    }
    return std::sqrt(nearest);
}

} // namespace

DetailTexture::DetailTexture(std::uint32_t seed) {
    constexpr std::size_t cells = std::size_t(size) * size * size;
    std::vector<float> values(cells);
    parallel_for(size, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z) {
            for (std::size_t y = 0; y < size; ++y) {
                for (std::size_t x = 0; x < size; ++x) {
                    const auto at = [&](float period) {
                        const float scale = period / static_cast<float>(size);
                        return repeating_worley(static_cast<float>(x) * scale, static_cast<float>(y) * scale,
                                                static_cast<float>(z) * scale, static_cast<int>(period),
                                                seed + static_cast<std::uint32_t>(period));
                    };
                    values[(z * size + y) * size + x] = -(0.65F * at(8.0F) + 0.35F * at(16.0F));
                }
            }
        }
    });
    double mean = 0.0;
    double square = 0.0;
    for (const float v : values) {
        mean += double(v) / double(cells);
        square += double(v) * double(v) / double(cells);
    }
    const double spread = std::sqrt(square - mean * mean);
    data_.assign(std::size_t(stride) * stride * stride + 4, 128);
    for (std::size_t z = 0; z < stride; ++z) {
        for (std::size_t y = 0; y < stride; ++y) {
            for (std::size_t x = 0; x < stride; ++x) {
                const double v = values[((z % size) * size + y % size) * size + x % size];
                const double byte = std::round(127.5 + 127.5 * (v - mean) / (2.5 * spread));
                data_[(z * stride + y) * stride + x] = static_cast<std::uint8_t>(std::clamp(byte, 0.0, 255.0));
            }
        }
    }
}

float DetailTexture::sample(const glm::vec3& cell) const {
    const glm::ivec3 i(cell);
    const glm::vec3 t = cell - glm::vec3(i);
    const std::size_t at = (std::size_t(i.z & (size - 1)) * stride + std::size_t(i.y & (size - 1))) * stride +
                           std::size_t(i.x & (size - 1));
    const auto lerp = [](float a, float b, float s) { return a + s * (b - a); };
    const auto row = [&](std::size_t o) {
        return lerp(static_cast<float>(data_[at + o]), static_cast<float>(data_[at + o + 1]), t.x);
    };
    constexpr std::size_t plane = std::size_t(stride) * stride;
    const float value = lerp(lerp(row(0), row(stride), t.y), lerp(row(plane), row(plane + stride), t.y), t.z);
    return value * (2.0F / 255.0F) - 1.0F;
}

float DetailTexture::sample(const glm::vec3& cell, const DetailOffsets& offsets) const {
    const glm::vec3 turned(cell.y, cell.z, cell.x);
    return (sample(cell + offsets.first) + sample(turned + offsets.second)) * 0.70710678F;
}

DetailOffsets detail_drift(double time_s, double lifetime_s) {
    assert(std::isfinite(time_s) && lifetime_s > 0.0);
    // Directions without a common period: the pair of offsets does not come back while anyone watches. Detail that
    // rises is a texture that is read further down.
    constexpr double billow = DetailTexture::size / 8.0;
    constexpr double first[3] = {0.267, -0.189, -0.945};
    constexpr double second[3] = {-0.611, 0.737, 0.289}; // in the turned frame: y, z, x
    DetailOffsets out;
    const auto wrapped = [&](double per_lifetime) {
        constexpr double side = DetailTexture::size;
        const double cells = std::fmod(time_s / lifetime_s * billow * per_lifetime, side);
        const auto offset = static_cast<float>(cells < 0.0 ? cells + side : cells);
        return offset < static_cast<float>(side) ? offset : 0.0F; // rounded up to the side
    };
    for (int a = 0; a < 3; ++a) {
        out.first[a] = wrapped(first[a]);
        out.second[a] = wrapped(second[a]);
    }
    return out;
}

} // namespace alpenglow::clouds
