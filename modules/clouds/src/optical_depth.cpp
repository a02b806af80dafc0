#include <alpenglow/clouds/optical_depth.hpp>

#include "deposit.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "optical_depth.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::clouds::HWY_NAMESPACE {

// out[i] = cubic value of four rows (v - 1 .. v + 2, `stride` apart, u - 1 first) at weights wu and wv, not
// below `lowest`; `line` holds count + 3 values.
void cubic_row(const float* rows, std::ptrdiff_t stride, const float* wu, const float* wv, float* line, float lowest,
               float* out, int count) {
    const float* a = rows;
    const float* b = rows + stride;
    const float* c = b + stride;
    const float* d = c + stride;
    for (int i = 0; i < count + 3; ++i) {
        line[i] = wv[0] * a[i] + wv[1] * b[i] + wv[2] * c[i] + wv[3] * d[i];
    }
    for (int i = 0; i < count; ++i) {
        const float value = wu[0] * line[i] + wu[1] * line[i + 1] + wu[2] * line[i + 2] + wu[3] * line[i + 3];
        out[i] = value > lowest ? value : lowest;
    }
}

// out[i] = a[i] - (second differences along three axes) / 12, not below 0.
void sharpened_row(const float* a, std::ptrdiff_t sy, std::ptrdiff_t sz, float* out, int count) {
    for (int i = 0; i < count; ++i) {
        const float* p = a + i;
        const float sum = (p[-1] + p[1]) + (p[-sy] + p[sy]) + (p[-sz] + p[sz]);
        const float value = 1.5F * p[0] - sum * (1.0F / 12.0F);
        out[i] = value > 0.0F ? value : 0.0F;
    }
}

// One slab of a row of columns: the density at the new slice, the depth by the trapezoid rule.
void advance_row(const float* a, const float* b, float fu, float fv, float half_step, float* density, float* depth,
                 int count) {
    const float w00 = (1.0F - fu) * (1.0F - fv);
    const float w10 = fu * (1.0F - fv);
    const float w01 = (1.0F - fu) * fv;
    const float w11 = fu * fv;
    for (int i = 0; i < count; ++i) {
        const float d = w00 * a[i] + w10 * a[i + 1] + w01 * b[i] + w11 * b[i + 1];
        depth[i] += half_step * (density[i] + d);
        density[i] = d;
    }
}

void deposit(const float* density, const float* depth, float extinction, float thickness, float* out, int count) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::CappedTag<float, 16> d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const auto lowest = hn::Set(d, -87.0F);
    const auto one = hn::Set(d, 1.0F);
    for (int x = 0; x < count; x += lanes) {
        const auto s = hn::Mul(hn::LoadU(d, density + x), hn::Set(d, extinction));
        const auto matter = hn::Gt(s, hn::Zero(d));
        if (hn::AllFalse(d, matter)) {
            hn::StoreU(hn::Zero(d), d, out + x);
            continue;
        }
        const auto half = hn::Mul(s, hn::Set(d, 0.5F * thickness));
        const auto tau = hn::Mul(hn::LoadU(d, depth + x), hn::Set(d, extinction));
        const auto near = hn::Exp(d, hn::Max(hn::Min(hn::Sub(half, tau), hn::Zero(d)), lowest));
        const auto far = hn::Exp(d, hn::Max(hn::Neg(hn::Add(half, tau)), lowest));
        const auto centre = hn::Exp(d, hn::Max(hn::Neg(tau), lowest));
        const auto thick = hn::Gt(half, hn::Set(d, 1e-2F));
        const auto mean = hn::Div(hn::Sub(near, far), hn::IfThenElse(thick, hn::Add(half, half), one));
        hn::StoreU(hn::Mul(s, hn::IfThenElse(thick, mean, centre)), d, out + x);
    }
}

} // namespace alpenglow::clouds::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

namespace alpenglow::clouds {

HWY_EXPORT(cubic_row);
HWY_EXPORT(sharpened_row);
HWY_EXPORT(advance_row);
HWY_EXPORT(deposit);

void deposit_row(const float* density, const float* depth, float extinction, float thickness, float* out, int count) {
    HWY_DYNAMIC_DISPATCH(deposit)(density, depth, extinction, thickness, out, count);
}

Lattice lattice_over(const BrickVolume& volume, int factor, int margin, std::size_t max_cells) {
    Lattice lattice;
    if (volume.active_voxels() == 0) {
        lattice.dims = glm::ivec3(1);
        return lattice;
    }
    for (lattice.factor = factor;; ++lattice.factor) {
        const int f = lattice.factor;
        const glm::ivec3 extent = volume.active_high() - volume.active_low() + 1;
        lattice.dims = (extent + f - 1) / f + 2 * margin;
        // Centred: the blocks' excess over the voxels lies on both sides.
        lattice.first = volume.active_low() - margin * f - ((lattice.dims - 2 * margin) * f - extent) / 2;
        if (lattice.cells() <= max_cells) {
            return lattice;
        }
    }
}

Field16::Field16(const Lattice& on, const std::vector<float>& from) : lattice(on) {
    assert(from.size() == on.cells());
    const auto [low, high] = std::minmax_element(from.begin(), from.end());
    offset = *low;
    scale = (*high - *low) / 65535.0F;
    values.assign(from.size() + 2, 0);
    const float inverse = scale > 0.0F ? 1.0F / scale : 0.0F;
    const float bottom = offset;
    parallel_for(from.size(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            values[i] = static_cast<std::uint16_t>(std::min((from[i] - bottom) * inverse + 0.5F, 65535.0F));
        }
    });
}

float Field16::sample(const glm::vec3& index) const {
    const float half = 0.5F * static_cast<float>(lattice.factor - 1);
    glm::ivec3 cell;
    glm::vec3 t;
    for (int a = 0; a < 3; ++a) {
        const float p =
            std::clamp((index[a] - static_cast<float>(lattice.first[a]) - half) / static_cast<float>(lattice.factor),
                       0.0F, static_cast<float>(lattice.dims[a] - 1));
        cell[a] = std::min(static_cast<int>(p), std::max(0, lattice.dims[a] - 2));
        t[a] = p - static_cast<float>(cell[a]);
    }
    const std::size_t dx = lattice.dims.x > 1 ? 1 : 0;
    const std::size_t dy = lattice.dims.y > 1 ? std::size_t(lattice.dims.x) : 0;
    const std::size_t dz = lattice.dims.z > 1 ? std::size_t(lattice.dims.x) * std::size_t(lattice.dims.y) : 0;
    const std::uint16_t* at =
        values.data() +
        (std::size_t(cell.z) * std::size_t(lattice.dims.y) + std::size_t(cell.y)) * std::size_t(lattice.dims.x) +
        std::size_t(cell.x);
    const auto lerp = [](float a, float b, float s) { return a + s * (b - a); };
    const auto row = [&](std::size_t o) { return lerp(at[o], at[o + dx], t.x); };
    return offset + scale * lerp(lerp(row(0), row(dy), t.y), lerp(row(dz), row(dy + dz), t.y), t.z);
}

namespace {

// Lagrange's cubic through -1, 0, 1, 2 at f: depths bend most where light enters, and lines between them would be
// above.
void cubic_weights(float f, float* w) {
    w[0] = -f * (f - 1.0F) * (f - 2.0F) / 6.0F;
    w[1] = (f + 1.0F) * (f - 1.0F) * (f - 2.0F) / 2.0F;
    w[2] = -(f + 1.0F) * f * (f - 2.0F) / 2.0F;
    w[3] = (f + 1.0F) * f * (f - 1.0F) / 6.0F;
}

// Walks the slices from the light's side. advance(rows a and b of the slice, fractions, last density, depth, count,
// first slice?, metres a slab) moves a row of columns on. lowest: of what is read back. Returns the columns' depths
// behind the last slice and the area of one.
struct Columns {
    std::vector<float> depth;
    double area_m2;
    LightColumns where;
};

template <class Advance>
Columns sweep_columns(const Lattice& lattice, const std::vector<float>& density, const glm::vec3& block_m,
                      const glm::vec3& to_light, float lowest, std::vector<float>& out, Advance&& advance) {
    assert(density.size() == lattice.cells());
    out.resize(density.size());
    // The light's direction in blocks a metre; the main axis and the two others, the faster one first.
    const glm::vec3 d = to_light / block_m;
    int axis = 0;
    for (int a = 1; a < 3; ++a) {
        if (std::abs(d[a]) > std::abs(d[axis])) {
            axis = a;
        }
    }
    const int ua = axis == 0 ? 1 : 0;
    const int va = axis == 2 ? 1 : 2;
    const float metres = 1.0F / std::abs(d[axis]); // along the light, a slice
    const float su = d[ua] * metres;               // shift of a column towards the light, a slice
    const float sv = d[va] * metres;
    const int nu = lattice.dims[ua];
    const int nv = lattice.dims[va];
    const int na = lattice.dims[axis];
    const std::size_t strides[3] = {1, std::size_t(lattice.dims.x),
                                    std::size_t(lattice.dims.x) * std::size_t(lattice.dims.y)};

    // Column (U, V) passes slice k (0 on the light's side) at u = U - su * k: U covers all that any slice needs.
    const auto reach = [na](float s) { return s * static_cast<float>(na - 1); };
    const int u0 = static_cast<int>(std::floor(std::min(0.0F, reach(su)))) - 3;
    const int v0 = static_cast<int>(std::floor(std::min(0.0F, reach(sv)))) - 3;
    const int columns_u = static_cast<int>(std::ceil(std::max(0.0F, reach(su)))) + nu + 4 - u0;
    const int columns_v = static_cast<int>(std::ceil(std::max(0.0F, reach(sv)))) + nv + 4 - v0;
    std::vector<float> behind(std::size_t(columns_u) * std::size_t(columns_v), 0.0F);
    // Strips of columns go from the first slice to the last on their own; each carries a row of the last one and two of
    // the next as well, which its own read-back interpolates with.
    constexpr int strip = 24;
    // A slice has a border of zeros wide enough for columns that are one slab past it.
    constexpr int border = 4;
    const int row = nu + 2 * border;
    const auto strips = static_cast<std::size_t>((columns_v + strip - 1) / strip);
    parallel_for(strips, 1, [&](std::size_t number, std::size_t) {
        const int own = v0 + static_cast<int>(number) * strip; // this strip's rows of columns: own .. own + count - 1
        const int count = std::min(strip, v0 + columns_v - own);
        const int first = own - 1; // that it carries
        const int rows = count + 3;
        std::vector<float> depth(std::size_t(columns_u) * std::size_t(rows), 0.0F);
        std::vector<float> last(depth.size(), 0.0F);
        std::vector<float> slice(std::size_t(row) * std::size_t(rows + 1), 0.0F);
        std::vector<float> line(2 * (static_cast<std::size_t>(nu) + 8));
        for (int k = 0; k < na; ++k) {
            const std::size_t plane = std::size_t(d[axis] > 0.0F ? na - 1 - k : k) * strides[axis];
            const float shift_u = -su * static_cast<float>(k);
            const float shift_v = -sv * static_cast<float>(k);
            const auto iu = static_cast<int>(std::floor(shift_u));
            const auto iv = static_cast<int>(std::floor(shift_v));
            const float fu = shift_u - static_cast<float>(iu);
            const float fv = shift_v - static_cast<float>(iv);
            // Columns whose u = U + iu lies in -3 .. nu + 1: those that leave the slice drop to zero density there.
            const int begin_u = std::max(u0, -3 - iu);
            const int end_u = std::min(u0 + columns_u, nu + 2 - iu);
            const int begin_v = std::max({first, v0, -3 - iv});
            const int end_v = std::min({first + rows, v0 + columns_v, nv + 2 - iv});
            for (int v = begin_v + iv; v < end_v + iv + 1 && begin_v < end_v; ++v) {
                float* to = slice.data() + std::size_t(v - first - iv) * std::size_t(row) + border;
                const float* from = density.data() + plane + std::size_t(std::clamp(v, 0, nv - 1)) * strides[va];
                if (v < 0 || v >= nv) {
                    std::fill_n(to, nu, 0.0F);
                } else if (strides[ua] == 1) {
                    std::memcpy(to, from, std::size_t(nu) * sizeof(float));
                } else {
                    for (int u = 0; u < nu; ++u) {
                        to[u] = from[std::size_t(u) * strides[ua]];
                    }
                }
            }
            for (int v = begin_v; v < end_v; ++v) {
                const float* a = slice.data() + std::size_t(v - first) * std::size_t(row) + (begin_u + iu + border);
                const std::size_t column = std::size_t(v - first) * std::size_t(columns_u) + std::size_t(begin_u - u0);
                advance(a, a + row, fu, fv, last.data() + column, depth.data() + column, end_u - begin_u, k, metres);
            }
            // Back at block centres: U = u - shift_u.
            const auto ju = static_cast<int>(std::floor(-shift_u));
            const auto jv = static_cast<int>(std::floor(-shift_v));
            float wu[4];
            float wv[4];
            cubic_weights(-shift_u - static_cast<float>(ju), wu);
            cubic_weights(-shift_v - static_cast<float>(jv), wv);
            for (int v = std::max(0, own - jv); v < std::min(nv, own + count - jv); ++v) {
                const float* a =
                    depth.data() + std::size_t(v + jv - 1 - first) * std::size_t(columns_u) + std::size_t(ju - 1 - u0);
                float* to = out.data() + plane + std::size_t(v) * strides[va];
                float* scratch = line.data() + nu + 8;
                if (strides[ua] == 1) {
                    HWY_DYNAMIC_DISPATCH(cubic_row)(a, columns_u, wu, wv, scratch, lowest, to, nu);
                } else {
                    HWY_DYNAMIC_DISPATCH(cubic_row)(a, columns_u, wu, wv, scratch, lowest, line.data(), nu);
                    for (int u = 0; u < nu; ++u) {
                        to[std::size_t(u) * strides[ua]] = line[std::size_t(u)];
                    }
                }
            }
        }
        std::copy_n(depth.begin() + columns_u, std::size_t(columns_u) * std::size_t(count),
                    behind.begin() + static_cast<std::ptrdiff_t>(std::size_t(own - v0) * std::size_t(columns_u)));
    });
    const double area =
        double(block_m[ua]) * double(block_m[va]) * double(std::abs(to_light[axis])); // across the light
    return {std::move(behind), area, {axis, su, sv, d[axis] > 0.0F, {u0, v0}, {columns_u, columns_v}}};
}

} // namespace

LightDepth light_depth(const Lattice& lattice, const std::vector<float>& density, const glm::vec3& block_m,
                       const glm::vec3& to_light, float removal_per_density) {
    LightDepth out;
    Columns columns = sweep_columns(lattice, density, block_m, to_light, 0.0F, out.depth,
                                    [&](const float* a, const float* b, float fu, float fv, float* last, float* depth,
                                        int count, int slice, float metres) {
                                        HWY_DYNAMIC_DISPATCH(advance_row)
                                        (a, b, fu, fv, slice == 0 ? 0.0F : 0.5F * metres, last, depth, count);
                                    });
    double removed = 0.0;
    for (const float tau : columns.depth) {
        removed -= std::expm1(-double(removal_per_density) * double(tau));
    }
    out.removed_m2 = removed * columns.area_m2;
    out.columns = columns.where;
    out.behind = std::move(columns.depth);
    return out;
}

std::vector<float> sharpened(const Lattice& lattice, const std::vector<float>& depth) {
    assert(depth.size() == lattice.cells());
    const glm::ivec3 n = lattice.dims;
    std::vector<float> out(depth);
    const std::ptrdiff_t sy = n.x;
    const std::ptrdiff_t sz = sy * n.y;
    if (n.x < 3 || n.y < 3 || n.z < 3) {
        return out;
    }
    parallel_for(std::size_t(n.z - 2), 4, [&](std::size_t begin, std::size_t end) {
        for (auto z = static_cast<std::ptrdiff_t>(begin) + 1; z < static_cast<std::ptrdiff_t>(end) + 1; ++z) {
            for (std::ptrdiff_t y = 1; y + 1 < n.y; ++y) {
                const std::ptrdiff_t at = z * sz + y * sy + 1;
                HWY_DYNAMIC_DISPATCH(sharpened_row)(depth.data() + at, sy, sz, out.data() + at, n.x - 2);
            }
        }
    });
    return out;
}

std::vector<float> harris_depth(const Lattice& lattice, const std::vector<float>& density, const glm::vec3& block_m,
                                const glm::vec3& to_light, float extinction_per_m, float gain, bool saturate) {
    std::vector<float> out;
    sweep_columns(lattice, density, block_m, to_light, saturate ? 0.0F : -60.0F, out,
                  [&](const float* a, const float* b, float fu, float fv, float* last, float* depth, int count, int,
                      float metres) {
                      // `last` holds the particle of the slice before; light reaches this one through it.
                      for (int i = 0; i < count; ++i) {
                          const float tau = extinction_per_m * metres * last[i];
                          const float gained = depth[i] - std::log(std::max(gain * tau + std::exp(-tau), 1e-30F));
                          depth[i] = std::clamp(gained, saturate ? 0.0F : -60.0F, 80.0F);
                          last[i] = (1.0F - fu) * (1.0F - fv) * a[i] + fu * (1.0F - fv) * a[i + 1] +
                                    (1.0F - fu) * fv * b[i] + fu * fv * b[i + 1];
                      }
                  });
    return out;
}

void harris_incident(const float* tau, int count, double gain, double* incident) {
    for (int k = 0; k < count; ++k) {
        incident[k] = k == 0 ? 1.0 : (gain * double(tau[k - 1]) + std::exp(-double(tau[k - 1]))) * incident[k - 1];
    }
}

double harris_exitant(const float* tau, const double* incident, int count, double albedo, double phase) {
    double exitant = 0.0;
    for (int k = 0; k < count; ++k) {
        exitant = albedo * double(tau[k]) * phase * incident[k] + std::exp(-double(tau[k])) * exitant;
    }
    return exitant;
}

double marched_depth(const BrickVolume& volume, const glm::dvec3& index, const glm::vec3& to_light, double step) {
    const glm::dvec3 voxel = volume.transform().voxel_m;
    const glm::dvec3 d = glm::dvec3(to_light) / voxel; // voxels a metre
    const double most = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    const double dt = step / most;
    const glm::dvec3 low = volume.active_low() - 1;
    const glm::dvec3 high = volume.active_high() + 1;
    double sum = 0.0;
    double before = double(volume.sample(glm::vec3(index)));
    for (double t = dt;; t += dt) {
        const glm::dvec3 p = index + d * t;
        bool gone = false;
        for (int a = 0; a < 3; ++a) {
            gone = gone || (d[a] > 0.0 ? p[a] - d[a] * dt > high[a] : p[a] - d[a] * dt < low[a]);
        }
        if (gone) {
            return sum;
        }
        const auto now = double(volume.sample(glm::vec3(p)));
        sum += 0.5 * (before + now) * dt;
        before = now;
    }
}

} // namespace alpenglow::clouds
#endif
