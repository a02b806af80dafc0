// Trilinear blending of many receivers: cells and weights for a group of receivers at once, then whole cache lines.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "blend.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

#include <alpenglow/probes/grid.hpp>

#include "grid_steps.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::probes::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using Du = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;

constexpr D d;
constexpr Du du;

struct Group {
    alignas(64) std::uint32_t first[16]; // the cell's first corner
    alignas(64) float weight[8][16];
};

// The part of a cell index that an axis makes, and where in the cell the position is.
HWY_INLINE hn::Vec<Du> cell_along(const Cells& cells, std::size_t axis, V position, V& fraction) {
    const V min = hn::Set(d, cells.min[axis]);
    V p = hn::IfThenElse(hn::IsFinite(position), position, min);
    p = hn::Min(hn::Max(p, min), hn::Set(d, cells.max[axis]));
    const V offset = hn::Min(hn::Mul(hn::Sub(p, min), hn::Set(d, cells.scale[axis])), hn::Set(d, cells.last[axis]));
    const V cell = hn::Min(hn::Floor(offset), hn::Set(d, cells.last_cell[axis]));
    fraction = hn::Sub(offset, cell);
    const auto index = hn::BitCast(du, hn::ConvertTo(hn::RebindToSigned<D>(), cell));
    return hn::Mul(index, hn::Set(du, cells.stride[axis]));
}

HWY_INLINE void make_group(const Cells& cells, const float* positions, Group& group) {
    const V one = hn::Set(d, 1.0F);
    for (std::size_t k = 0; k < 16; k += hn::Lanes(d)) {
        V x;
        V y;
        V z;
        hn::LoadInterleaved3(d, positions + 3 * k, x, y, z);
        V fx;
        V fy;
        V fz;
        auto first = cell_along(cells, 0, x, fx);
        first = hn::Add(first, cell_along(cells, 1, y, fy));
        first = hn::Add(first, cell_along(cells, 2, z, fz));
        hn::Store(first, du, group.first + k);
        const V gx = hn::Sub(one, fx);
        const V gy = hn::Sub(one, fy);
        const V gz = hn::Sub(one, fz);
        const V yz[4] = {hn::Mul(gy, gz), hn::Mul(fy, gz), hn::Mul(gy, fz), hn::Mul(fy, fz)};
        for (std::size_t c = 0; c < 4; ++c) {
            hn::Store(hn::Mul(gx, yz[c]), d, group.weight[2 * c] + k);
            hn::Store(hn::Mul(fx, yz[c]), d, group.weight[2 * c + 1] + k);
        }
    }
}

void blend_kernel(const ProbeGrid& grid, const ProbeGridSh& light, const glm::vec3* positions, std::size_t count,
                  float* out) {
    const Cells cells = cells_of(grid);
    const std::size_t stride = light.lines * 16;
    const float* const probes = light.coefficients.data()->values.data();
    const std::uint8_t* const masks = light.cell_mask.data();
    std::size_t offset[8];
    for (std::uint32_t c = 0; c < 8; ++c) {
        offset[c] = corner_offset(cells, c) * stride;
    }
    Group group;
    float padded[48];
    for (std::size_t start = 0; start < count; start += 16) {
        const std::size_t here = std::min<std::size_t>(16, count - start);
        const float* from = &positions[start].x;
        if (here < 16) {
            std::fill(std::copy_n(from, 3 * here, padded), padded + 48, 0.0F);
            from = padded;
        }
        make_group(cells, from, group);
        for (std::size_t r = 0; r < here; ++r, out += stride) {
            const glm::vec3& p = positions[start + r];
            const bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
            const float* corner[8];
            V weight[8];
            if (HWY_LIKELY(masks[group.first[r]] == 0xffU && finite)) {
                const float* const first = probes + group.first[r] * stride;
                for (std::size_t c = 0; c < 8; ++c) {
                    corner[c] = first + offset[c];
                    weight[c] = hn::Set(d, group.weight[c][r]);
                }
            } else {
                const Corners corners = blend_corners(grid, light, p);
                for (std::size_t c = 0; c < 8; ++c) {
                    corner[c] = probes + corners.probe[c] * stride;
                    weight[c] = hn::Set(d, corners.weight[c]);
                }
            }
            for (std::size_t i = 0; i < stride; i += hn::Lanes(d)) {
                V a = hn::Mul(weight[0], hn::Load(d, corner[0] + i));
                V b = hn::Mul(weight[1], hn::Load(d, corner[1] + i));
                for (std::size_t c = 2; c < 8; c += 2) {
                    a = hn::MulAdd(weight[c], hn::Load(d, corner[c] + i), a);
                    b = hn::MulAdd(weight[c + 1], hn::Load(d, corner[c + 1] + i), b);
                }
                hn::Store(hn::Add(a, b), d, out + i);
            }
        }
    }
}

} // namespace
} // namespace alpenglow::probes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::probes {

HWY_EXPORT(blend_kernel);

void blend(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
           std::span<ProbeLine> out) {
    assert(out.size() >= positions_m.size() * light.lines && !light.coefficients.empty());
    if (!positions_m.empty()) {
        HWY_DYNAMIC_DISPATCH(blend_kernel)
        (grid, light, positions_m.data(), positions_m.size(), out.data()->values.data());
    }
}

} // namespace alpenglow::probes
#endif
