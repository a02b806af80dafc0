#include <alpenglow/prt/evaluate.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "evaluate.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::prt {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr std::size_t lanes = hn::MaxLanes(D());

HWY_INLINE V load(const float* from) {
    return hn::Load(D(), from);
}
HWY_INLINE V load(const hwy::float16_t* from) {
    return hn::PromoteTo(D(), hn::Load(hn::Rebind<hwy::float16_t, D>(), from));
}
HWY_INLINE V load(const std::int8_t* from) {
    const hn::RebindToSigned<D> integers;
    return hn::ConvertTo(D(), hn::PromoteTo(integers, hn::Load(hn::Rebind<std::int8_t, D>(), from)));
}

// One block of 16 points is read from front to back, a single stream that the hardware's prefetcher follows, in
// `groups` registers; `chains` coefficients at a time hide the latency of the multiply-adds: 12 sums in flight.
constexpr std::size_t groups = lanes >= block_points ? 1 : lanes * 4 >= block_points ? block_points / lanes : 4;
constexpr std::size_t chains = 4 / groups;

// light is [3][coefficients]; with three channels channel c's vectors follow `stored` coefficients later.
template <bool colour, class T>
HWY_INLINE void sums(const T* HWY_RESTRICT from, std::size_t coefficients, std::size_t stored,
                     const float* HWY_RESTRICT light, V (&r)[groups], V (&g)[groups], V (&b)[groups]) {
    const D d;
    V sr[groups][chains];
    V sg[groups][chains];
    V sb[groups][chains];
    for (std::size_t t = 0; t < groups; ++t) {
        for (std::size_t c = 0; c < chains; ++c) {
            sr[t][c] = hn::Zero(d);
            sg[t][c] = hn::Zero(d);
            sb[t][c] = hn::Zero(d);
        }
    }
    const auto add = [&](std::size_t i, std::size_t c) HWY_ATTR {
        const V lr = hn::Set(d, light[i]);
        const V lg = hn::Set(d, light[coefficients + i]);
        const V lb = hn::Set(d, light[2 * coefficients + i]);
        for (std::size_t t = 0; t < groups; ++t) {
            const T* m = from + i * block_points + t * lanes;
            const V m0 = load(m);
            sr[t][c] = hn::MulAdd(m0, lr, sr[t][c]);
            sg[t][c] = hn::MulAdd(colour ? load(m + stored * block_points) : m0, lg, sg[t][c]);
            sb[t][c] = hn::MulAdd(colour ? load(m + 2 * stored * block_points) : m0, lb, sb[t][c]);
        }
    };
    std::size_t i = 0;
    for (; i + chains <= coefficients; i += chains) {
        for (std::size_t c = 0; c < chains; ++c) {
            add(i + c, c);
        }
    }
    for (; i < coefficients; ++i) {
        add(i, 0);
    }
    for (std::size_t t = 0; t < groups; ++t) {
        for (std::size_t c = 1; c < chains; ++c) {
            sr[t][0] = hn::Add(sr[t][0], sr[t][c]);
            sg[t][0] = hn::Add(sg[t][0], sg[t][c]);
            sb[t][0] = hn::Add(sb[t][0], sb[t][c]);
        }
        r[t] = sr[t][0];
        g[t] = sg[t][0];
        b[t] = sb[t][0];
    }
}

template <bool colour, class T>
void vectors(const T* HWY_RESTRICT from, std::size_t width, std::size_t coefficients, std::size_t stored,
             const float* HWY_RESTRICT light, std::size_t first, std::size_t last, std::size_t count, float* out) {
    const D d;
    constexpr std::size_t step = groups * lanes;
    V r[groups];
    V g[groups];
    V b[groups];
    for (std::size_t point = first; point < last; point += step) {
        const T* at = from + point / block_points * width * block_points + point % block_points;
        sums<colour>(at, coefficients, stored, light, r, g, b);
        if (point + step <= count) {
            for (std::size_t t = 0; t < groups; ++t) {
                hn::StoreInterleaved3(r[t], g[t], b[t], d, out + 3 * (point + t * lanes));
            }
        } else if (point < count) {
            HWY_ALIGN float rest[3 * step];
            for (std::size_t t = 0; t < groups; ++t) {
                hn::StoreInterleaved3(r[t], g[t], b[t], d, rest + 3 * t * lanes);
            }
            std::memcpy(out + 3 * point, rest, 3 * (count - point) * sizeof(float));
        }
    }
}

// `row` selects a matrix row (0 for vectors), `out` that row's plane.
void EvaluateRow(const TransferTable& table, const float* light, std::size_t coefficients, std::size_t row,
                 std::size_t first, std::size_t last, float* out) {
    const TransferInfo& info = table.info;
    const std::size_t stored = info.coefficients();
    const std::size_t width = info.width();
    const std::size_t skip = row * stored * info.channels * block_points;
    const auto run = [&](const auto* from) {
        if (info.channels == 3) {
            vectors<true>(from + skip, width, coefficients, stored, light, first, last, info.count, out);
        } else {
            vectors<false>(from + skip, width, coefficients, stored, light, first, last, info.count, out);
        }
    };
    switch (info.encoding) {
    case Encoding::f32:
        run(reinterpret_cast<const float*>(table.blocks.data()));
        break;
    case Encoding::f16:
        run(reinterpret_cast<const hwy::float16_t*>(table.blocks.data()));
        break;
    case Encoding::s8:
        run(reinterpret_cast<const std::int8_t*>(table.blocks.data()));
        break;
    case Encoding::cpca:
        break;
    }
}

// One cluster: `mean` is its mean's result, lit [3][components] those of its components. Blocks first .. last of the
// table; the last of a cluster may hold padding.
void EvaluateCluster(const TransferTable& table, const float* HWY_RESTRICT mean, const float* HWY_RESTRICT lit,
                     std::size_t first, std::size_t last, float* out) {
    const D d;
    const std::size_t components = table.info.components;
    const auto* weights = reinterpret_cast<const std::int8_t*>(table.blocks.data());
    HWY_ALIGN float rgb[3 * block_points];
    constexpr std::size_t step = groups * lanes;
    V r[groups];
    V g[groups];
    V b[groups];
    for (std::size_t block = first; block < last; ++block) {
        const std::uint32_t* points = table.slot_points.data() + block * block_points;
        const bool full = points[block_points - 1] != TransferTable::no_point;
        // Points of a cluster stand in their own order: a block without gaps needs no scattering.
        const bool dense = full && points[block_points - 1] - points[0] == block_points - 1;
        float* to = dense ? out + 3 * std::size_t{points[0]} : rgb;
        for (std::size_t lane = 0; lane < block_points; lane += step) {
            sums<false>(weights + block * components * block_points + lane, components, components, lit, r, g, b);
            for (std::size_t t = 0; t < groups; ++t) {
                hn::StoreInterleaved3(hn::Add(r[t], hn::Set(d, mean[0])), hn::Add(g[t], hn::Set(d, mean[1])),
                                      hn::Add(b[t], hn::Set(d, mean[2])), d, to + 3 * (lane + t * lanes));
            }
        }
        if (dense) {
            continue;
        }
        if (full) {
            for (std::size_t k = 0; k < block_points; ++k) {
                std::memcpy(out + 3 * std::size_t{points[k]}, rgb + 3 * k, 3 * sizeof(float));
            }
            continue;
        }
        for (std::size_t k = 0; k < block_points && points[k] != TransferTable::no_point; ++k) {
            std::memcpy(out + 3 * std::size_t{points[k]}, rgb + 3 * k, 3 * sizeof(float));
        }
    }
}

// kernel_y: [rows][lanes of the block range] weights y_i(R) kernel_l. Sums rows of M L against them.
template <bool colour, class T>
void glossy(const TransferTable& table, const T* HWY_RESTRICT from, const float* HWY_RESTRICT light,
            std::size_t coefficients, const float* HWY_RESTRICT row_weights, std::size_t block,
            float* HWY_RESTRICT rgb) {
    const D d;
    const std::size_t stored = table.info.coefficients();
    const std::size_t width = table.info.width();
    const std::size_t row_values = stored * table.info.channels;
    from += block * width * block_points;
    for (std::size_t lane = 0; lane < block_points; lane += lanes) {
        V r = hn::Zero(d);
        V g = hn::Zero(d);
        V b = hn::Zero(d);
        // Four rows at a time, for the latency of the multiply-adds.
        std::size_t row = 0;
        for (; row + 4 <= table.info.rows; row += 4) {
            V sr[4];
            V sg[4];
            V sb[4];
            for (int t = 0; t < 4; ++t) {
                sr[t] = hn::Zero(d);
                sg[t] = hn::Zero(d);
                sb[t] = hn::Zero(d);
            }
            const T* m = from + row * row_values * block_points + lane;
            for (std::size_t i = 0; i < coefficients; ++i) {
                const V lr = hn::Set(d, light[i]);
                const V lg = hn::Set(d, light[coefficients + i]);
                const V lb = hn::Set(d, light[2 * coefficients + i]);
                for (std::size_t t = 0; t < 4; ++t) {
                    const T* at = m + (t * row_values + i) * block_points;
                    const V m0 = load(at);
                    sr[t] = hn::MulAdd(m0, lr, sr[t]);
                    sg[t] = hn::MulAdd(colour ? load(at + stored * block_points) : m0, lg, sg[t]);
                    sb[t] = hn::MulAdd(colour ? load(at + 2 * stored * block_points) : m0, lb, sb[t]);
                }
            }
            for (std::size_t t = 0; t < 4; ++t) {
                const V w = hn::Load(d, row_weights + (row + t) * block_points + lane);
                r = hn::MulAdd(w, sr[t], r);
                g = hn::MulAdd(w, sg[t], g);
                b = hn::MulAdd(w, sb[t], b);
            }
        }
        for (; row < table.info.rows; ++row) {
            V sr = hn::Zero(d);
            V sg = hn::Zero(d);
            V sb = hn::Zero(d);
            const T* m = from + row * row_values * block_points + lane;
            for (std::size_t i = 0; i < coefficients; ++i) {
                const T* at = m + i * block_points;
                const V m0 = load(at);
                sr = hn::MulAdd(m0, hn::Set(d, light[i]), sr);
                sg =
                    hn::MulAdd(colour ? load(at + stored * block_points) : m0, hn::Set(d, light[coefficients + i]), sg);
                sb = hn::MulAdd(colour ? load(at + 2 * stored * block_points) : m0,
                                hn::Set(d, light[2 * coefficients + i]), sb);
            }
            const V w = hn::Load(d, row_weights + row * block_points + lane);
            r = hn::MulAdd(w, sr, r);
            g = hn::MulAdd(w, sg, g);
            b = hn::MulAdd(w, sb, b);
        }
        hn::StoreInterleaved3(r, g, b, d, rgb + 3 * lane);
    }
}

void EvaluateGlossyBlock(const TransferTable& table, const float* light, std::size_t coefficients,
                         const float* row_weights, std::size_t block, float* rgb) {
    const auto run = [&](const auto* from) {
        if (table.info.channels == 3) {
            glossy<true>(table, from, light, coefficients, row_weights, block, rgb);
        } else {
            glossy<false>(table, from, light, coefficients, row_weights, block, rgb);
        }
    };
    switch (table.info.encoding) {
    case Encoding::f32:
        run(reinterpret_cast<const float*>(table.blocks.data()));
        break;
    case Encoding::f16:
        run(reinterpret_cast<const hwy::float16_t*>(table.blocks.data()));
        break;
    case Encoding::s8:
        run(reinterpret_cast<const std::int8_t*>(table.blocks.data()));
        break;
    case Encoding::cpca:
        break;
    }
}

} // namespace HWY_NAMESPACE
} // namespace alpenglow::prt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::prt {

HWY_EXPORT(EvaluateRow);
HWY_EXPORT(EvaluateCluster);
HWY_EXPORT(EvaluateGlossyBlock);

namespace {

constexpr std::size_t most_coefficients = 36;

// Light as [3][coefficients], the scales of 8-bit tables folded in.
struct PackedLight {
    std::size_t coefficients = 0;
    std::array<float, 3 * most_coefficients> values{};
};

PackedLight pack(const TransferInfo& info, std::span<const glm::vec3> light) {
    PackedLight packed;
    std::size_t order = 0;
    while ((order + 1) * (order + 1) <= light.size()) {
        ++order;
    }
    assert(order * order == light.size());
    order = std::min<std::size_t>(order, info.order);
    packed.coefficients = order * order;
    for (std::size_t l = 0; l < order; ++l) {
        for (std::size_t i = l * l; i < (l + 1) * (l + 1); ++i) {
            for (std::size_t c = 0; c < 3; ++c) {
                const float scale =
                    info.encoding == Encoding::s8 ? info.band_scale[(info.channels == 3 ? c : 0) * 8 + l] : 1.0F;
                packed.values[c * packed.coefficients + i] = light[i][static_cast<glm::length_t>(c)] * scale;
            }
        }
    }
    return packed;
}

void evaluate_cpca(const TransferTable& table, const PackedLight& light, std::span<glm::vec3> out, BlockRange blocks) {
    const TransferInfo& info = table.info;
    const std::size_t components = info.components;
    const std::size_t n = info.coefficients();
    std::array<float, 3> mean{};
    std::vector<float> lit(3 * components);
    for (std::size_t cluster = 0; cluster < info.clusters; ++cluster) {
        const std::size_t first = std::max<std::size_t>(table.cluster_blocks[cluster], blocks.first);
        const std::size_t last = std::min<std::size_t>(table.cluster_blocks[cluster + 1], blocks.last);
        if (first >= last) {
            continue;
        }
        for (std::size_t j = 0; j <= components; ++j) {
            const float* m = table.clusters.data() + (cluster * (components + 1) + j) * info.width();
            for (std::size_t c = 0; c < 3; ++c) {
                const float* channel = m + (info.channels == 3 ? c * n : 0);
                const float* l = light.values.data() + c * light.coefficients;
                std::array<float, 4> part{}; // so that the additions overlap
                std::size_t i = 0;
                for (; i + 4 <= light.coefficients; i += 4) {
                    for (std::size_t k = 0; k < 4; ++k) {
                        part[k] += channel[i + k] * l[i + k];
                    }
                }
                for (; i < light.coefficients; ++i) {
                    part[0] += channel[i] * l[i];
                }
                const float sum = part[0] + part[1] + (part[2] + part[3]);
                (j == 0 ? mean[c] : lit[c * components + j - 1]) = sum;
            }
        }
        HWY_DYNAMIC_DISPATCH(EvaluateCluster)(table, mean.data(), lit.data(), first, last, &out[0].x);
    }
}

} // namespace

BlockRange all_blocks(const TransferTable& table) noexcept {
    return {0, table.info.slots / block_points};
}

void evaluate(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out,
              BlockRange blocks) noexcept {
    assert(table.info.rows == 1 && out.size() >= table.info.count && blocks.last <= table.info.slots / block_points);
    if (out.empty()) {
        return;
    }
    const PackedLight packed = pack(table.info, light);
    if (table.info.encoding == Encoding::cpca) {
        evaluate_cpca(table, packed, out, blocks);
        return;
    }
    HWY_DYNAMIC_DISPATCH(EvaluateRow)
    (table, packed.values.data(), packed.coefficients, 0, blocks.first * block_points, blocks.last * block_points,
     &out[0].x);
}

void evaluate(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept {
    evaluate(table, light, out, all_blocks(table));
}

void evaluate_scalar(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept {
    const TransferField field = decode(table);
    const std::size_t n = table.info.coefficients();
    const std::size_t used = std::min(n, light.size());
    for (std::size_t p = 0; p < field.count; ++p) {
        const std::span<const float> m = field.point(p);
        glm::vec3 sum(0.0F);
        for (std::size_t i = 0; i < used; ++i) {
            for (int c = 0; c < 3; ++c) {
                sum[c] += m[field.channels == 3 ? static_cast<std::size_t>(c) * n + i : i] * light[i][c];
            }
        }
        out[p] = sum;
    }
}

void evaluate_matrix(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out,
                     BlockRange blocks) noexcept {
    const TransferInfo& info = table.info;
    assert(info.encoding != Encoding::cpca && out.size() >= info.count * info.rows &&
           blocks.last <= info.slots / block_points);
    if (out.empty()) {
        return;
    }
    const PackedLight packed = pack(info, light);
    // Block by block, so that a block's rows are read while they stand side by side.
    constexpr std::size_t chunk = 4;
    for (std::size_t block = blocks.first; block < blocks.last; block += chunk) {
        const std::size_t last = std::min(block + chunk, blocks.last);
        for (std::size_t row = 0; row < info.rows; ++row) {
            HWY_DYNAMIC_DISPATCH(EvaluateRow)
            (table, packed.values.data(), packed.coefficients, row, block * block_points, last * block_points,
             &out[row * info.count].x);
        }
    }
}

void evaluate_matrix(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept {
    evaluate_matrix(table, light, out, all_blocks(table));
}

void evaluate_glossy(const TransferTable& table, std::span<const glm::vec3> light, std::span<const float> kernel,
                     std::span<const glm::vec3> directions, std::span<glm::vec3> out, BlockRange blocks) noexcept {
    const TransferInfo& info = table.info;
    assert(info.encoding != Encoding::cpca && info.rows > 1 && info.rows <= most_coefficients);
    assert(directions.size() >= info.count && out.size() >= info.count);
    const PackedLight packed = pack(info, light);
    const int out_order = static_cast<int>(std::lround(std::sqrt(static_cast<double>(info.rows))));
    assert(kernel.size() >= static_cast<std::size_t>(out_order));
    alignas(64) std::array<float, most_coefficients * block_points> row_weights{};
    alignas(64) std::array<float, 3 * block_points> rgb{};
    std::array<float, most_coefficients> y{};
    for (std::size_t block = blocks.first; block < blocks.last; ++block) {
        const std::size_t first = block * block_points;
        const std::size_t points = std::min(block_points, info.count - first);
        for (std::size_t k = 0; k < points; ++k) {
            sh::evaluate_basis(out_order, directions[first + k], y);
            for (int l = 0; l < out_order; ++l) {
                for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                    const auto row = static_cast<std::size_t>(i);
                    row_weights[row * block_points + k] = y[row] * kernel[static_cast<std::size_t>(l)];
                }
            }
        }
        HWY_DYNAMIC_DISPATCH(EvaluateGlossyBlock)
        (table, packed.values.data(), packed.coefficients, row_weights.data(), block, rgb.data());
        std::memcpy(&out[first].x, rgb.data(), 3 * points * sizeof(float));
    }
}

void evaluate_glossy(const TransferTable& table, std::span<const glm::vec3> light, std::span<const float> kernel,
                     std::span<const glm::vec3> directions, std::span<glm::vec3> out) noexcept {
    evaluate_glossy(table, light, kernel, directions, out, all_blocks(table));
}

void evaluate_glossy_scalar(const TransferTable& table, std::span<const glm::vec3> light, std::span<const float> kernel,
                            std::span<const glm::vec3> directions, std::span<glm::vec3> out) noexcept {
    const TransferField field = decode(table);
    const std::size_t n = table.info.coefficients();
    const std::size_t used = std::min(n, light.size());
    const auto channels = static_cast<std::size_t>(field.channels);
    std::array<float, most_coefficients> y{};
    for (std::size_t p = 0; p < field.count; ++p) {
        const std::span<const float> m = field.point(p);
        sh::evaluate_basis(field.out_order, directions[p], y);
        glm::vec3 sum(0.0F);
        for (int l = 0; l < field.out_order; ++l) {
            for (int row = l * l; row < (l + 1) * (l + 1); ++row) {
                const auto r = static_cast<std::size_t>(row);
                glm::vec3 transferred(0.0F);
                for (std::size_t i = 0; i < used; ++i) {
                    for (int c = 0; c < 3; ++c) {
                        const std::size_t channel = channels == 3 ? static_cast<std::size_t>(c) : 0;
                        transferred[c] += m[(r * channels + channel) * n + i] * light[i][c];
                    }
                }
                sum += transferred * (y[r] * kernel[static_cast<std::size_t>(l)]);
            }
        }
        out[p] = sum;
    }
}

} // namespace alpenglow::prt
#endif
