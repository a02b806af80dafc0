// Trilinear blending of many receivers: cells and weights for a group of receivers at once, then whole cache lines.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "blend.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/cache_control.h>
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
    alignas(64) float finite[16];        // 1 where the position is, else 0
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
        const auto finite = hn::And(hn::IsFinite(x), hn::And(hn::IsFinite(y), hn::IsFinite(z)));
        hn::Store(hn::IfThenElseZero(finite, one), d, group.finite + k);
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

// Lines: those of a probe, known to the compiler where that matters, else 0.
template <std::size_t Lines>
struct Floats {
    const float* probes;
    std::size_t lines;

    [[nodiscard]] HWY_INLINE std::size_t stride() const { return 16 * (Lines != 0 ? Lines : lines); }
    HWY_INLINE void prefetch(std::uint32_t probe) const {
        const float* const p = probes + probe * stride();
        for (std::size_t i = 0; i < stride(); i += 16) {
            hwy::Prefetch(p + i);
        }
    }
    // probe(c) and weight(c) of the eight corners.
    template <class Probe, class Weight>
    HWY_INLINE void blend(const Probe& probe, const Weight& weight, float* out) const {
        const float* corner[8];
        V w[8];
        HWY_UNROLL(8)
        for (std::size_t c = 0; c < 8; ++c) {
            corner[c] = probes + probe(c) * stride();
            w[c] = hn::Set(d, weight(c));
        }
        for (std::size_t i = 0; i < stride(); i += hn::Lanes(d)) {
            V a = hn::Mul(w[0], hn::Load(d, corner[0] + i));
            V b = hn::Mul(w[1], hn::Load(d, corner[1] + i));
            HWY_UNROLL(4)
            for (std::size_t c = 2; c < 8; c += 2) {
                a = hn::MulAdd(w[c], hn::Load(d, corner[c] + i), a);
                b = hn::MulAdd(w[c + 1], hn::Load(d, corner[c + 1] + i), b);
            }
            hn::Store(hn::Add(a, b), d, out + i);
        }
    }
};

// Count: floats of a probe.
template <std::size_t Count>
struct Packed {
    const PackedProbe* probes;

    [[nodiscard]] static HWY_INLINE std::size_t stride() { return (Count + 15) / 16 * 16; }
    HWY_INLINE void prefetch(std::uint32_t probe) const { hwy::Prefetch(probes + probe); }
    template <class Probe, class Weight>
    HWY_INLINE void blend(const Probe& probe, const Weight& weight, float* out) const {
        constexpr hn::Rebind<std::int16_t, D> narrow;
        constexpr hn::RebindToSigned<D> wide;
        constexpr std::size_t lanes = hn::MaxLanes(d), vectors = (Count + 15) / 16 * 16 / lanes;
        V sum[vectors];
        HWY_UNROLL(8)
        for (std::size_t c = 0; c < 8; ++c) {
            const PackedProbe& from = probes[probe(c)];
            const V w = hn::Set(d, weight(c) * from.scale);
            // The last vector reads the scale as two more values, which are thrown away.
            const auto* const values = reinterpret_cast<const std::int16_t*>(&from);
            HWY_UNROLL(32)
            for (std::size_t i = 0; i < vectors; ++i) {
                const V value = hn::ConvertTo(d, hn::PromoteTo(wide, hn::LoadU(narrow, values + i * lanes)));
                sum[i] = c == 0 ? hn::Mul(w, value) : hn::MulAdd(w, value, sum[i]);
            }
        }
        HWY_UNROLL(32)
        for (std::size_t i = 0; i < vectors; ++i) {
            hn::Store(sum[i], d, out + i * lanes);
        }
        // What the means lack stands after the coefficients.
        for (std::size_t c = 0; c < 3; ++c) {
            out[c] += out[Count + c] * (1.0F / 32768.0F);
        }
        std::fill(out + Count, out + stride(), 0.0F);
    }
};

template <class Light>
HWY_INLINE void blend_all(const Light& source, const ProbeGrid& grid, const ProbeGridSh& light,
                          const glm::vec3* positions, std::size_t count, float* out) {
    const Cells cells = cells_of(grid);
    const std::uint8_t* const masks = light.cell_mask.data();
    std::uint32_t offset[8];
    for (std::uint32_t c = 0; c < 8; ++c) {
        offset[c] = corner_offset(cells, c);
    }
    Group groups[2];
    float padded[48];
    const auto locate_group = [&](std::size_t start, Group& group) HWY_ATTR {
        const std::size_t here = std::min<std::size_t>(16, count - start);
        const float* from = &positions[start].x;
        if (here < 16) {
            std::fill(std::copy_n(from, 3 * here, padded), padded + 48, 0.0F);
            from = padded;
        }
        make_group(cells, from, group);
    };
    locate_group(0, groups[0]);
    for (std::size_t start = 0, turn = 0; start < count; start += 16, turn ^= 1) {
        const std::size_t here = std::min<std::size_t>(16, count - start);
        const Group& group = groups[turn];
        const bool more = start + 16 < count;
        if (more) {
            locate_group(start + 16, groups[turn ^ 1]);
        }
        for (std::size_t r = 0; r < here; ++r, out += source.stride()) {
            // The grid is larger than the nearest caches: fetch what the group after this one needs.
            if (more) {
                for (std::size_t c = 0; c < 8; ++c) {
                    source.prefetch(groups[turn ^ 1].first[r] + offset[c]);
                }
            }
            if (HWY_LIKELY(masks[group.first[r]] == 0xffU && group.finite[r] != 0.0F)) {
                const std::uint32_t first = group.first[r];
                source.blend([&](std::size_t c) { return first + offset[c]; },
                             [&](std::size_t c) { return group.weight[c][r]; }, out);
            } else {
                const Corners corners = blend_corners(grid, light, positions[start + r]);
                source.blend([&](std::size_t c) { return corners.probe[c]; },
                             [&](std::size_t c) { return corners.weight[c]; }, out);
            }
        }
    }
}

void blend_kernel(const ProbeGrid& grid, const ProbeGridSh& light, const glm::vec3* positions, std::size_t count,
                  float* out) {
    const float* const probes = light.coefficients.data()->values.data();
    if (light.lines == 2) {
        blend_all(Floats<2>{probes, 2}, grid, light, positions, count, out);
    } else {
        blend_all(Floats<0>{probes, light.lines}, grid, light, positions, count, out);
    }
}

void blend_packed_kernel(const ProbeGrid& grid, const ProbeGridSh& light, const glm::vec3* positions, std::size_t count,
                         float* out) {
    const PackedProbe* const probes = light.packed.data();
    if (light.order == 3) {
        blend_all(Packed<27>{probes}, grid, light, positions, count, out);
    } else if (light.order == 2) {
        blend_all(Packed<12>{probes}, grid, light, positions, count, out);
    } else {
        blend_all(Packed<3>{probes}, grid, light, positions, count, out);
    }
}

void pack_kernel(ProbeGridSh& light, const std::uint32_t* probes, std::size_t count) {
    constexpr hn::Rebind<std::int16_t, D> narrow;
    const std::size_t stride = light.lines * 16;
    for (std::size_t k = 0; k < count; ++k) {
        const float* const from = light.coefficients.data()->values.data() + probes[k] * stride;
        PackedProbe& to = light.packed[probes[k]];
        V most = hn::Zero(d);
        for (std::size_t i = 0; i < stride; i += hn::Lanes(d)) {
            most = hn::Max(most, hn::Abs(hn::Load(d, from + i)));
        }
        const float largest = hn::GetLane(hn::MaxOfLanes(d, most));
        to = PackedProbe{};
        if (largest < 1e-33F) { // its inverse would overflow
            continue;
        }
        constexpr float steps = 32764.0F;
        const float inverse = steps / largest;
        alignas(64) std::int16_t values[32] = {};
        for (std::size_t i = 0; i < stride; i += hn::Lanes(d)) {
            const auto rounded = hn::NearestInt(hn::Mul(hn::Load(d, from + i), hn::Set(d, inverse)));
            hn::StoreU(hn::DemoteTo(narrow, rounded), narrow, values + i);
        }
        const auto n = static_cast<std::size_t>(light.order * light.order);
        for (std::size_t c = 0; c < 3; ++c) {
            // What rounding can take from the irradiance, in steps of the mean: (A_l / pi) sqrt(2 l + 1) |e_l|.
            float error[3] = {};
            for (std::size_t i = 1; i < n; ++i) {
                const float e = from[3 * i + c] * inverse - static_cast<float>(values[3 * i + c]);
                error[i < 4 ? 1U : 2U] += e * e;
            }
            const float lift =
                from[c] > 0.0F ? 1.1547006F * std::sqrt(error[1]) + 0.5590171F * std::sqrt(error[2]) : 0.0F;
            const float mean = from[c] * inverse + lift, whole = std::nearbyint(mean);
            values[c] = static_cast<std::int16_t>(whole);
            values[3 * n + c] = static_cast<std::int16_t>((mean - whole) * 32768.0F);
        }
        std::copy_n(values, to.values.size(), to.values.begin());
        to.scale = largest / steps;
    }
}

} // namespace
} // namespace alpenglow::probes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::probes {

HWY_EXPORT(blend_kernel);
HWY_EXPORT(blend_packed_kernel);
HWY_EXPORT(pack_kernel);

void blend(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
           std::span<ProbeLine> out) {
    assert(out.size() >= positions_m.size() * light.lines && !light.coefficients.empty());
    if (!positions_m.empty()) {
        HWY_DYNAMIC_DISPATCH(blend_kernel)
        (grid, light, positions_m.data(), positions_m.size(), out.data()->values.data());
    }
}

void blend_packed(const ProbeGrid& grid, const ProbeGridSh& light, std::span<const glm::vec3> positions_m,
                  std::span<ProbeLine> out) {
    assert(out.size() >= positions_m.size() * light.lines && !light.packed.empty());
    if (!positions_m.empty()) {
        HWY_DYNAMIC_DISPATCH(blend_packed_kernel)
        (grid, light, positions_m.data(), positions_m.size(), out.data()->values.data());
    }
}

void pack(ProbeGridSh& light, std::span<const std::uint32_t> probes) {
    if (!light.packed.empty()) {
        HWY_DYNAMIC_DISPATCH(pack_kernel)(light, probes.data(), probes.size());
    }
}

} // namespace alpenglow::probes
#endif
