#include "transport.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "transport.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

// What one octant's sweep reads and writes. Shared by the instruction sets.
#ifndef ALPENGLOW_CLOUDS_SWEEP_TYPES
#define ALPENGLOW_CLOUDS_SWEEP_TYPES
namespace alpenglow::clouds {
struct OctantTables {
    float ax[8], ay[8], az[8]; // 2 |direction| / block size
    float sum[8];              // of the three
    float y[16][8];            // moments -> radiance along the ordinate
    float w[8][16];            // radiance -> moments
    float inflow[8];
    int sx, sy, sz; // +1 or -1
};
struct SweepInput {
    int nx, ny, nz;
    const float* sigma;
    const std::int32_t* active;
    const float* source; // 16 an active cell: coefficients of the source, W/m a radiance unit
};
} // namespace alpenglow::clouds
#endif

HWY_BEFORE_NAMESPACE();
namespace alpenglow::clouds::HWY_NAMESPACE {

typedef float F8 __attribute__((vector_size(32), aligned(4)));
typedef int I8 __attribute__((vector_size(32), aligned(4)));
typedef float F16 __attribute__((vector_size(64), aligned(4)));

#define ALPENGLOW_LOAD8(p) (*reinterpret_cast<const F8*>(p))
#define ALPENGLOW_STORE8(p, v) (*reinterpret_cast<F8*>(p) = (v))

HWY_INLINE bool any_lane(I8 mask) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
    return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#else
    int any = 0;
    for (int l = 0; l < 8; ++l) {
        any |= mask[l];
    }
    return any != 0;
#endif
}

// Eight ordinates of one octant through the whole lattice. faces_y: nx * 8, faces_z: nx * ny * 8. Adds to moments.
void sweep_octant(const SweepInput& in, const OctantTables& t, float* faces_y, float* faces_z, float* moments) {
    const F8 ax = ALPENGLOW_LOAD8(t.ax);
    const F8 ay = ALPENGLOW_LOAD8(t.ay);
    const F8 az = ALPENGLOW_LOAD8(t.az);
    const F8 asum = ALPENGLOW_LOAD8(t.sum);
    const F8 inflow = ALPENGLOW_LOAD8(t.inflow);
    const F8 zero = {};
    for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(in.nx) * in.ny; ++i) {
        ALPENGLOW_STORE8(faces_z + 8 * i, inflow);
    }
    for (int kz = 0; kz < in.nz; ++kz) {
        const int z = t.sz > 0 ? kz : in.nz - 1 - kz;
        for (int x = 0; x < in.nx; ++x) {
            ALPENGLOW_STORE8(faces_y + 8 * x, inflow);
        }
        for (int ky = 0; ky < in.ny; ++ky) {
            const int y = t.sy > 0 ? ky : in.ny - 1 - ky;
            F8 px = inflow;
            const std::ptrdiff_t row = (std::ptrdiff_t(z) * in.ny + y) * in.nx;
            for (int kx = 0; kx < in.nx; ++kx) {
                const int x = t.sx > 0 ? kx : in.nx - 1 - kx;
                const std::ptrdiff_t cell = row + x;
                float* fy = faces_y + 8 * std::ptrdiff_t(x);
                float* fz = faces_z + 8 * (std::ptrdiff_t(y) * in.nx + x);
                const F8 py = ALPENGLOW_LOAD8(fy);
                const F8 pz = ALPENGLOW_LOAD8(fz);
                const float s = in.sigma[cell];
                const std::ptrdiff_t a = in.active[cell];
                F8 source = zero;
                if (s > 0.0F) {
                    const float* q = in.source + 16 * a;
                    F8 even = zero;
                    for (int k = 0; k < 16; k += 2) {
                        source += q[k] * ALPENGLOW_LOAD8(t.y[k]);
                        even += q[k + 1] * ALPENGLOW_LOAD8(t.y[k + 1]);
                    }
                    source += even;
                }
                const F8 streaming = source + (ay * py + az * pz);
                const F8 inverse = 1.0F / (asum + s);
                F8 centre = (streaming + ax * px) * inverse;
                F8 ox = centre + centre - px;
                F8 oy = centre + centre - py;
                F8 oz = centre + centre - pz;
                const I8 bad = ((ox < zero) | (oy < zero) | (oz < zero)) & (source >= zero);
                if (any_lane(bad)) {
                    // The step scheme, positive and conservative, for the ordinates whose diamonds would turn negative.
                    const F8 step = (source + 0.5F * (ax * px + ay * py + az * pz)) / (0.5F * asum + s);
                    centre = bad ? step : centre;
                    ox = bad ? step : ox;
                    oy = bad ? step : oy;
                    oz = bad ? step : oz;
                }
                px = ox;
                ALPENGLOW_STORE8(fy, oy);
                ALPENGLOW_STORE8(fz, oz);
                if (a >= 0) {
                    F16* m = reinterpret_cast<F16*>(moments + 16 * a);
                    F16 sum = *m;
                    F16 other = {};
                    for (int l = 0; l < 8; l += 2) {
                        sum += centre[l] * *reinterpret_cast<const F16*>(t.w[l]);
                        other += centre[l + 1] * *reinterpret_cast<const F16*>(t.w[l + 1]);
                    }
                    *m = sum + other;
                }
            }
        }
    }
}

// out = b - A x, or one damped Jacobi step. Arrays are padded by a plane of zeros on both ends.
void residual(int count, std::ptrdiff_t sy, std::ptrdiff_t sz, const float* gx, const float* gy, const float* gz,
              const float* absorption, const float* inverse_diagonal, const float* x, const float* b, float* out) {
    (void)absorption;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        const float near = gx[i] * x[i + 1] + gx[i - 1] * x[i - 1] + gy[i] * x[i + sy] + gy[i - sy] * x[i - sy] +
                           gz[i] * x[i + sz] + gz[i - sz] * x[i - sz];
        out[i] = b[i] + near - x[i] / inverse_diagonal[i];
    }
}

void jacobi(int count, std::ptrdiff_t sy, std::ptrdiff_t sz, const float* gx, const float* gy, const float* gz,
            const float* inverse_diagonal, const float* x, const float* b, float* out) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        const float near = gx[i] * x[i + 1] + gx[i - 1] * x[i - 1] + gy[i] * x[i + sy] + gy[i - sy] * x[i - sy] +
                           gz[i] * x[i + sz] + gz[i - sz] * x[i - sz];
        out[i] = x[i] + 0.8F * ((b[i] + near) * inverse_diagonal[i] - x[i]);
    }
}

} // namespace alpenglow::clouds::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>

#include <alpenglow/clouds/view.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

namespace alpenglow::clouds {

HWY_EXPORT(sweep_octant);
HWY_EXPORT(residual);
HWY_EXPORT(jacobi);

const Ordinate* ordinate_table() {
    static const std::array<Ordinate, ordinates> table = [] {
        std::array<Ordinate, ordinates> out{};
        const double nodes[2] = {0.33998104358485626, 0.86113631159405258};
        const double weights[2] = {0.65214515486254614, 0.34785484513745386};
        for (int octant = 0; octant < 8; ++octant) {
            for (int i = 0; i < 8; ++i) {
                const double mu = nodes[i / 4];
                const double azimuth = (i % 4 + 0.5) * pi / 8.0;
                const double s = std::sqrt(1.0 - mu * mu);
                glm::dvec3 d(s * std::cos(azimuth), s * std::sin(azimuth), mu);
                for (int a = 0; a < 3; ++a) {
                    if ((octant >> a) & 1) {
                        d[a] = -d[a];
                    }
                }
                out[std::size_t(octant * 8 + i)] = {glm::vec3(d), static_cast<float>(weights[i / 4] * pi / 8.0)};
            }
        }
        return out;
    }();
    return table.data();
}

Transport::Transport(const Lattice& lattice, const std::vector<float>& density, const glm::vec3& block_m,
                     const Medium& medium)
    : lattice_(lattice), block_m_(block_m), scaled_(scaled_medium(medium)) {
    assert(density.size() == lattice.cells());
    const glm::ivec3 n = lattice.dims;
    sigma_.resize(density.size());
    const auto factor = static_cast<float>(double(medium.extinction_per_m) * scaled_.extinction);
    // Beyond 1e4 mean free paths a cell nothing changes but rounding.
    const float most = 1e4F / std::min({block_m.x, block_m.y, block_m.z});
    for (std::size_t i = 0; i < density.size(); ++i) {
        sigma_[i] = std::min(density[i] * factor, most);
        if (sigma_[i] < 1e-20F) {
            sigma_[i] = 0.0F;
        }
    }
    // Active: matter, or next to it, so that radiance can be interpolated at the cloud's edge.
    std::vector<std::uint8_t> near(density.size(), 0);
    const auto at = [&](int x, int y, int z) {
        return (std::size_t(z) * std::size_t(n.y) + std::size_t(y)) * std::size_t(n.x) + std::size_t(x);
    };
    for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x) {
                if (sigma_[at(x, y, z)] > 0.0F) {
                    for (int k = std::max(0, z - 1); k <= std::min(n.z - 1, z + 1); ++k) {
                        for (int j = std::max(0, y - 1); j <= std::min(n.y - 1, y + 1); ++j) {
                            for (int i = std::max(0, x - 1); i <= std::min(n.x - 1, x + 1); ++i) {
                                near[at(i, j, k)] = 1;
                            }
                        }
                    }
                }
            }
        }
    }
    active_.assign(density.size(), -1);
    for (std::size_t i = 0; i < near.size(); ++i) {
        if (near[i] != 0) {
            active_[i] = static_cast<std::int32_t>(cell_of_.size());
            cell_of_.push_back(static_cast<std::int32_t>(i));
        }
    }
    active_count_ = cell_of_.size();
    make_levels();
}

std::size_t Transport::memory_bytes() const {
    std::size_t bytes = (sigma_.size() + active_.size() + cell_of_.size() + transport_.size() + boundary_.size()) * 4;
    for (const Level& level : levels_) {
        bytes += 4 * (level.gx.size() * 8);
    }
    return bytes;
}

// Diffusion: conductance between cells h apart is 2 / (3 h^2 (s_i + s_j)) with the transport extinction s; towards the
// outside Marshak's condition gives 1 / (h (3 s h / 2 + 2)).
void Transport::make_levels() {
    const glm::ivec3 n = lattice_.dims;
    const float extent = std::max({static_cast<float>(n.x) * block_m_.x, static_cast<float>(n.y) * block_m_.y,
                                   static_cast<float>(n.z) * block_m_.z});
    // Light crosses empty cells without any scattering; diffusion cannot, and takes a mean free path of the cloud's
    // size there.
    const float floor = 2.0F / extent;
    const auto anisotropy = static_cast<float>(1.0 - scaled_.albedo * scaled_.moments[1]);
    transport_.resize(sigma_.size());
    for (std::size_t i = 0; i < sigma_.size(); ++i) {
        transport_[i] = std::max(sigma_[i] * anisotropy, floor);
    }
    boundary_.assign(sigma_.size(), 0.0F);
    Level fine;
    fine.dims = n;
    fine.pad = std::size_t(n.x) * std::size_t(n.y) + 1;
    const std::size_t total = sigma_.size() + 2 * fine.pad;
    for (auto* array : {&fine.gx, &fine.gy, &fine.gz, &fine.absorption, &fine.inverse_diagonal}) {
        array->assign(total, 0.0F);
    }
    const std::size_t strides[3] = {1, std::size_t(n.x), std::size_t(n.x) * std::size_t(n.y)};
    std::vector<float>* conductances[3] = {&fine.gx, &fine.gy, &fine.gz};
    for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x) {
                const std::size_t i =
                    (std::size_t(z) * std::size_t(n.y) + std::size_t(y)) * std::size_t(n.x) + std::size_t(x);
                const int c[3] = {x, y, z};
                fine.absorption[fine.pad + i] = sigma_[i] * static_cast<float>(1.0 - scaled_.albedo);
                for (int a = 0; a < 3; ++a) {
                    const float h = block_m_[a];
                    const float edge = 1.0F / (h * (1.5F * transport_[i] * h + 2.0F));
                    if (c[a] == 0) {
                        boundary_[i] += edge;
                    }
                    if (c[a] == n[a] - 1) {
                        boundary_[i] += edge;
                    } else {
                        (*conductances[a])[fine.pad + i] =
                            2.0F / (3.0F * h * h * (transport_[i] + transport_[i + strides[a]]));
                    }
                }
            }
        }
    }
    std::vector<float> outside = boundary_;
    levels_.push_back(std::move(fine));
    for (;;) {
        Level& level = levels_.back();
        const glm::ivec3 d = level.dims;
        const std::size_t sy = std::size_t(d.x);
        const std::size_t sz = sy * std::size_t(d.y);
        const std::size_t cells = sz * std::size_t(d.z);
        for (std::size_t i = 0; i < cells; ++i) {
            const std::size_t p = level.pad + i;
            level.inverse_diagonal[p] = 1.0F / (level.absorption[p] + outside[i] + level.gx[p] + level.gx[p - 1] +
                                                level.gy[p] + level.gy[p - sy] + level.gz[p] + level.gz[p - sz]);
        }
        if (std::max({d.x, d.y, d.z}) <= 3) {
            break;
        }
        Level coarse;
        coarse.dims = (d + 1) / 2;
        const glm::ivec3 cd = coarse.dims;
        coarse.pad = std::size_t(cd.x) * std::size_t(cd.y) + 1;
        const std::size_t coarse_cells = std::size_t(cd.x) * std::size_t(cd.y) * std::size_t(cd.z);
        for (auto* array : {&coarse.gx, &coarse.gy, &coarse.gz, &coarse.absorption, &coarse.inverse_diagonal}) {
            array->assign(coarse_cells + 2 * coarse.pad, 0.0F);
        }
        std::vector<float> coarse_outside(coarse_cells, 0.0F);
        // Sums over the eight cells; conductances across coarse faces are halved, for the distance has doubled.
        for (int z = 0; z < d.z; ++z) {
            for (int y = 0; y < d.y; ++y) {
                for (int x = 0; x < d.x; ++x) {
                    const std::size_t i = std::size_t(z) * sz + std::size_t(y) * sy + std::size_t(x);
                    const std::size_t j =
                        (std::size_t(z / 2) * std::size_t(cd.y) + std::size_t(y / 2)) * std::size_t(cd.x) +
                        std::size_t(x / 2);
                    coarse.absorption[coarse.pad + j] += level.absorption[level.pad + i];
                    coarse_outside[j] += outside[i];
                    if (x & 1) {
                        coarse.gx[coarse.pad + j] += 0.5F * level.gx[level.pad + i];
                    }
                    if (y & 1) {
                        coarse.gy[coarse.pad + j] += 0.5F * level.gy[level.pad + i];
                    }
                    if (z & 1) {
                        coarse.gz[coarse.pad + j] += 0.5F * level.gz[level.pad + i];
                    }
                }
            }
        }
        outside = std::move(coarse_outside);
        levels_.push_back(std::move(coarse));
    }
}

namespace {

std::size_t cells_of(const Transport::Level& level) {
    return std::size_t(level.dims.x) * std::size_t(level.dims.y) * std::size_t(level.dims.z);
}

void smooth(const Transport::Level& l, std::vector<float>& x, const std::vector<float>& b,
            std::vector<float>& scratch) {
    const auto sy = static_cast<std::ptrdiff_t>(l.dims.x);
    const auto sz = sy * l.dims.y;
    HWY_DYNAMIC_DISPATCH(jacobi)
    (static_cast<int>(cells_of(l)), sy, sz, l.gx.data() + l.pad, l.gy.data() + l.pad, l.gz.data() + l.pad,
     l.inverse_diagonal.data() + l.pad, x.data() + l.pad, b.data() + l.pad, scratch.data() + l.pad);
    std::swap(x, scratch);
}

void residual_of(const Transport::Level& l, const std::vector<float>& x, const std::vector<float>& b,
                 std::vector<float>& r) {
    const auto sy = static_cast<std::ptrdiff_t>(l.dims.x);
    const auto sz = sy * l.dims.y;
    HWY_DYNAMIC_DISPATCH(residual)
    (static_cast<int>(cells_of(l)), sy, sz, l.gx.data() + l.pad, l.gy.data() + l.pad, l.gz.data() + l.pad,
     l.absorption.data() + l.pad, l.inverse_diagonal.data() + l.pad, x.data() + l.pad, b.data() + l.pad,
     r.data() + l.pad);
}

double inner(const std::vector<float>& a, const std::vector<float>& b) {
    double sums[8] = {};
    std::size_t i = 0;
    for (; i + 8 <= a.size(); i += 8) {
        for (std::size_t j = 0; j < 8; ++j) {
            sums[j] += double(a[i + j]) * double(b[i + j]);
        }
    }
    for (; i < a.size(); ++i) {
        sums[0] += double(a[i]) * double(b[i]);
    }
    return std::accumulate(sums, sums + 8, 0.0);
}

} // namespace

Transport::Scratch Transport::make_scratch() const {
    Scratch scratch;
    for (const Level& level : levels_) {
        const std::vector<float> zeros(level.gx.size(), 0.0F);
        scratch.x.push_back(zeros);
        scratch.b.push_back(zeros);
        scratch.r.push_back(zeros);
    }
    return scratch;
}

// x ~ A^-1 b: two damped Jacobi steps before and after, so that the cycle is symmetric.
void Transport::v_cycle(Scratch& scratch, std::size_t number) const {
    const Level& l = levels_[number];
    std::vector<float>& x = scratch.x[number];
    const std::vector<float>& b = scratch.b[number];
    std::vector<float>& r = scratch.r[number];
    const std::size_t cells = cells_of(l);
    for (std::size_t i = 0; i < cells; ++i) { // the first step from zero
        x[l.pad + i] = 0.8F * l.inverse_diagonal[l.pad + i] * b[l.pad + i];
    }
    if (number + 1 == levels_.size()) {
        for (int i = 0; i < 12; ++i) {
            smooth(l, x, b, r);
        }
        return;
    }
    smooth(l, x, b, r);
    residual_of(l, x, b, r);
    const Level& c = levels_[number + 1];
    std::vector<float>& coarse_b = scratch.b[number + 1];
    std::fill(coarse_b.begin(), coarse_b.end(), 0.0F);
    for (int z = 0; z < l.dims.z; ++z) {
        for (int y = 0; y < l.dims.y; ++y) {
            const float* row =
                r.data() + l.pad + (std::size_t(z) * std::size_t(l.dims.y) + std::size_t(y)) * std::size_t(l.dims.x);
            float* to = coarse_b.data() + c.pad +
                        (std::size_t(z / 2) * std::size_t(c.dims.y) + std::size_t(y / 2)) * std::size_t(c.dims.x);
            for (int i = 0; i < l.dims.x; ++i) {
                to[i / 2] += row[i];
            }
        }
    }
    v_cycle(scratch, number + 1);
    for (int z = 0; z < l.dims.z; ++z) {
        for (int y = 0; y < l.dims.y; ++y) {
            float* fine =
                x.data() + l.pad + (std::size_t(z) * std::size_t(l.dims.y) + std::size_t(y)) * std::size_t(l.dims.x);
            const float* coarse =
                scratch.x[number + 1].data() + c.pad +
                (std::size_t(z / 2) * std::size_t(c.dims.y) + std::size_t(y / 2)) * std::size_t(c.dims.x);
            for (int i = 0; i < l.dims.x; ++i) {
                fine[i] += coarse[i / 2];
            }
        }
    }
    smooth(l, x, b, r);
    smooth(l, x, b, r);
}

void Transport::p1_solve(Scratch& scratch, const std::vector<float>& rhs, std::vector<float>& x, int iterations,
                         float tolerance) const {
    const Level& l = levels_.front();
    const double norm = inner(rhs, rhs);
    if (!(norm > 0.0)) {
        std::fill(x.begin(), x.end(), 0.0F);
        return;
    }
    std::vector<float> r(rhs.size(), 0.0F);
    residual_of(l, x, rhs, r);
    std::vector<float> p(rhs.size(), 0.0F);
    double rz = 0.0;
    const std::vector<float> zeros(rhs.size(), 0.0F);
    std::vector<float> ap(rhs.size(), 0.0F);
    for (int i = 0; i < iterations && inner(r, r) > double(tolerance) * double(tolerance) * norm; ++i) {
        scratch.b[0] = r;
        v_cycle(scratch, 0);
        const std::vector<float>& preconditioned = scratch.x[0];
        const double now = inner(r, preconditioned);
        if (!(now > 0.0)) {
            return;
        }
        const auto beta = static_cast<float>(i == 0 ? 0.0 : now / rz);
        for (std::size_t j = 0; j < rhs.size(); ++j) {
            p[j] = preconditioned[j] + beta * p[j];
        }
        rz = now;
        residual_of(l, p, zeros, ap); // -A p
        const double curvature = -inner(p, ap);
        if (!(curvature > 0.0)) {
            return;
        }
        const auto alpha = static_cast<float>(rz / curvature);
        for (std::size_t j = 0; j < rhs.size(); ++j) {
            x[j] += alpha * p[j];
            r[j] += alpha * ap[j];
        }
    }
}

void Transport::p1_correct(Scratch& scratch, const std::vector<float>& source0, const std::vector<glm::vec3>& source1,
                           bool start, float inflow, RadianceMoments& moments) const {
    const Level& l = levels_.front();
    const glm::ivec3 n = lattice_.dims;
    const std::size_t strides[3] = {1, std::size_t(n.x), std::size_t(n.x) * std::size_t(n.y)};
    std::vector<float> rhs(l.gx.size(), 0.0F);
    std::vector<float> flux(l.gx.size(), 0.0F);
    const auto isotropic = static_cast<float>(4.0 * pi) * inflow;
    for (std::size_t i = 0; i < sigma_.size(); ++i) {
        rhs[l.pad + i] = source0[i] + boundary_[i] * isotropic;
    }
    // Minus the divergence of the current that the first moment of the source drives, from faces.
    const auto driven = [&](std::size_t i, std::size_t j, int a) {
        return (source1[i][a] + source1[j][a]) / (transport_[i] + transport_[j]);
    };
    // Cells with a source have active neighbours only: no face is missed.
    for (const std::int32_t cell : cell_of_) {
        const auto i = static_cast<std::size_t>(cell);
        const int c[3] = {static_cast<int>(i % strides[1]), static_cast<int>(i / strides[1] % std::size_t(n.y)),
                          static_cast<int>(i / strides[2])};
        for (int a = 0; a < 3; ++a) {
            if (c[a] + 1 < n[a]) {
                const std::size_t j = i + strides[a];
                const float f = driven(i, j, a) / block_m_[a];
                rhs[l.pad + i] -= f;
                rhs[l.pad + j] += f;
            }
        }
    }
    if (start) {
        std::fill(flux.begin() + static_cast<std::ptrdiff_t>(l.pad), flux.end() - static_cast<std::ptrdiff_t>(l.pad),
                  isotropic);
    }
    p1_solve(scratch, rhs, flux, start ? 4 : 1, start ? 1e-3F : 5e-2F);
    for (std::size_t number = 0; number < active_count_; ++number) {
        const auto i = static_cast<std::size_t>(cell_of_[number]);
        const std::size_t p = l.pad + i;
        float* m = moments.data() + 16 * number;
        constexpr float y0 = 0.28209479F;
        constexpr float y1 = 0.48860251F;
        const float scalar = m[0] / y0;
        const float change = std::max(flux[p], -0.9F * scalar);
        m[0] += y0 * change;
        const int x = static_cast<int>(i % strides[1]);
        const int y = static_cast<int>(i / strides[1] % std::size_t(n.y));
        const int z = static_cast<int>(i / strides[2]);
        const int c[3] = {x, y, z};
        glm::vec3 current;
        for (int a = 0; a < 3; ++a) {
            const float ahead = c[a] + 1 < n[a] ? flux[p + strides[a]] : flux[p];
            const float behind = c[a] > 0 ? flux[p - strides[a]] : flux[p];
            current[a] = (source1[i][a] - (ahead - behind) / (6.0F * block_m_[a])) / transport_[i];
        }
        // A current cannot exceed the flux that makes it.
        const float length = std::sqrt(current.x * current.x + current.y * current.y + current.z * current.z);
        const float most = std::abs(change) * 0.9F;
        if (length > most) {
            current *= length > 0.0F ? most / length : 0.0F;
        }
        m[1] -= y1 * current.y;
        m[2] += y1 * current.z;
        m[3] -= y1 * current.x;
    }
}

struct TransportJob::State {
    const Transport* transport;
    Source source;
    int sweeps;
    int sweep = 0;
    int slice = 0; // 0: begin; 1 .. 8: octants; 9: end
    bool started;
    float change = 0.0F;
    float last_change = 1e30F;
    float brightest = 0.0F; // bound on the zeroth moment
    float scatter[16];
    float beam[16];
    std::array<OctantTables, 8> octants;
    RadianceMoments moments;
    std::vector<float> emission;
    std::array<RadianceMoments, 2> swept; // of even and odd octants: fixed, so that sums do not depend on threads
    std::vector<float> source0;
    std::vector<glm::vec3> source1;
    Transport::Scratch scratch;
    std::vector<float> faces_y[2], faces_z[2];

    void sweep_one(std::size_t octant) {
        const Transport& t = *transport;
        const SweepInput input{t.lattice_.dims.x, t.lattice_.dims.y, t.lattice_.dims.z,
                               t.sigma_.data(),   t.active_.data(),  emission.data()};
        const std::size_t group = octant & 1;
        HWY_DYNAMIC_DISPATCH(sweep_octant)
        (input, octants[octant], faces_y[group].data(), faces_z[group].data(), swept[group].data());
    }
};

TransportJob::~TransportJob() = default;
TransportJob::TransportJob(TransportJob&&) noexcept = default;
TransportJob& TransportJob::operator=(TransportJob&&) noexcept = default;

TransportJob::TransportJob(const Transport& transport, Source source, int sweeps, RadianceMoments start)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.transport = &transport;
    s.source = std::move(source);
    s.sweeps = transport.active_count_ == 0 ? 0 : sweeps;
    s.moments = std::move(start);
    s.started = s.moments.size() == 16 * transport.active_count_;
    if (!s.started) {
        s.moments.assign(16 * transport.active_count_, 0.0F);
    }
    const Ordinate* table = ordinate_table();
    const glm::vec3& block = transport.block_m_;
    for (int o = 0; o < 8; ++o) {
        OctantTables& t = s.octants[std::size_t(o)];
        t.sx = o & 1 ? -1 : 1;
        t.sy = o & 2 ? -1 : 1;
        t.sz = o & 4 ? -1 : 1;
        for (int i = 0; i < 8; ++i) {
            const Ordinate& ordinate = table[8 * o + i];
            float y[16];
            sh_bands4(ordinate.direction, y);
            t.ax[i] = 2.0F * std::abs(ordinate.direction.x) / block.x;
            t.ay[i] = 2.0F * std::abs(ordinate.direction.y) / block.y;
            t.az[i] = 2.0F * std::abs(ordinate.direction.z) / block.z;
            t.sum[i] = t.ax[i] + t.ay[i] + t.az[i];
            t.inflow[i] = s.source.inflow[std::size_t(8 * o + i)];
            for (int k = 0; k < 16; ++k) {
                t.y[k][i] = y[k];
                t.w[i][k] = y[k] * ordinate.weight;
            }
        }
    }
    // The beam's first collisions: moments of the direction that it travels in.
    const auto band = [](int k) { return std::size_t(k == 0 ? 0 : (k < 4 ? 1 : (k < 9 ? 2 : 3))); };
    sh_bands4(-s.source.to_light, s.beam);
    for (int k = 0; k < 16; ++k) {
        s.scatter[k] = static_cast<float>(transport.scaled_.albedo * transport.scaled_.moments[band(k)]);
        s.beam[k] *= s.scatter[k];
    }
    // No cell of a cloud that absorbs nothing sees more scalar flux than 4 pi times the inflow, or 8 times the
    // irradiance.
    s.brightest = 0.28209479F * (*std::max_element(s.source.inflow.begin(), s.source.inflow.end()) * 13.2F +
                                 (s.source.deposit.empty() ? 0.0F : 8.0F));
    s.source0.assign(transport.sigma_.size(), 0.0F);
    s.source1.assign(transport.sigma_.size(), glm::vec3(0.0F));
    s.emission.resize(16 * transport.active_count_);
    s.scratch = transport.make_scratch();
    for (int group = 0; group < 2; ++group) {
        s.swept[std::size_t(group)].resize(16 * transport.active_count_);
        s.faces_y[group].resize(8 * std::size_t(transport.lattice_.dims.x));
        s.faces_z[group].resize(8 * std::size_t(transport.lattice_.dims.x) * std::size_t(transport.lattice_.dims.y));
    }
}

bool TransportJob::done() const {
    return state_->sweep >= state_->sweeps && state_->started;
}
const RadianceMoments& TransportJob::moments() const {
    return state_->moments;
}
float TransportJob::change() const {
    return state_->change;
}

void TransportJob::begin_sweep() {
    State& s = *state_;
    const Transport& t = *s.transport;
    for (RadianceMoments& swept : s.swept) {
        std::fill(swept.begin(), swept.end(), 0.0F);
    }
    for (std::size_t number = 0; number < t.active_count_; ++number) {
        const auto i = static_cast<std::size_t>(t.cell_of_[number]);
        const float sigma = t.sigma_[i];
        const float d = s.source.deposit.empty() ? 0.0F : s.source.deposit[i];
        float* q = s.emission.data() + 16 * number;
        const float* m = s.moments.data() + 16 * number;
        for (int k = 0; k < 16; ++k) {
            q[k] = sigma * s.scatter[k] * m[k] + d * s.beam[k];
        }
    }
}

void TransportJob::end_sweep() {
    State& s = *state_;
    const Transport& t = *s.transport;
    constexpr float y0 = 0.28209479F;
    constexpr float y1 = 0.48860251F;
    double moved = 0.0;
    double whole = 0.0;
    for (std::size_t number = 0; number < t.active_count_; ++number) {
        const auto i = static_cast<std::size_t>(t.cell_of_[number]);
        float* a = s.swept[0].data() + 16 * number;
        const float* b = s.swept[1].data() + 16 * number;
        const float* old = s.moments.data() + 16 * number;
        for (int k = 0; k < 16; ++k) {
            a[k] += b[k];
        }
        // What radiance can be at all, with room for the lobes that truncated moments have: keeps media that three
        // moments cannot describe (a needle of a backward peak) from feeding on themselves.
        a[0] = std::clamp(a[0], 0.0F, s.brightest);
        for (int k = 1; k < 16; ++k) {
            const float most = 5.3F * a[0];
            a[k] = std::clamp(a[k], -most, most);
        }
        const float sigma = t.sigma_[i];
        s.source0[i] = sigma * s.scatter[0] * (a[0] - old[0]) / y0;
        s.source1[i] = glm::vec3(-(a[3] - old[3]), -(a[1] - old[1]), a[2] - old[2]) * (sigma * s.scatter[1] / y1);
        moved += double(a[0] - old[0]) * double(a[0] - old[0]);
        whole += double(a[0]) * double(a[0]);
    }
    s.change = whole > 0.0 ? static_cast<float>(std::min(std::sqrt(moved / whole), 1e30)) : 0.0F;
    if (!(s.change <= 1.5F * s.last_change)) {
        s.sweep = s.sweeps; // diverging (thick cells that diffusion and diamonds see differently): keep what there was
        return;
    }
    s.last_change = s.change;
    s.moments.swap(s.swept[0]);
    if (s.change > 1e-6F) {
        t.p1_correct(s.scratch, s.source0, s.source1, false, 0.0F, s.moments);
    }
    ++s.sweep;
}

void TransportJob::advance() {
    State& s = *state_;
    const Transport& t = *s.transport;
    if (!s.started) {
        s.started = true;
        if (t.active_count_ == 0) {
            return;
        }
        float inflow = 0.0F;
        for (int i = 0; i < ordinates; ++i) {
            inflow += s.source.inflow[std::size_t(i)] * ordinate_table()[i].weight * static_cast<float>(0.25 / pi);
        }
        for (std::size_t number = 0; number < t.active_count_ && !s.source.deposit.empty(); ++number) {
            const auto i = static_cast<std::size_t>(t.cell_of_[number]);
            s.source0[i] = s.scatter[0] * s.source.deposit[i];
            s.source1[i] = -s.source.to_light * (s.scatter[1] * s.source.deposit[i]);
        }
        t.p1_correct(s.scratch, s.source0, s.source1, true, inflow, s.moments);
        return;
    }
    if (done()) {
        return;
    }
    if (s.slice == 0) {
        begin_sweep();
    } else if (s.slice <= 8) {
        s.sweep_one(std::size_t(s.slice - 1));
    } else {
        end_sweep();
    }
    s.slice = s.slice == 9 ? 0 : s.slice + 1;
}

void TransportJob::run() {
    State& s = *state_;
    while (!done()) {
        if (s.started && s.slice == 1) {
            parallel_for(2, 1, [&](std::size_t group, std::size_t) {
                for (std::size_t octant = group; octant < 8; octant += 2) {
                    s.sweep_one(octant);
                }
            });
            s.slice = 9;
        } else {
            advance();
        }
    }
}

} // namespace alpenglow::clouds
#endif
