#include <alpenglow/clouds/compact.hpp>
#include <alpenglow/clouds/march.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "march.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <cstddef>
#include <cstdint>

// Plain views of what the kernels read. Shared by the instruction sets.
#ifndef ALPENGLOW_CLOUDS_MARCH_TYPES
#define ALPENGLOW_CLOUDS_MARCH_TYPES
namespace alpenglow::clouds {

struct BrickView {
    const std::int32_t* nodes;
    const std::int32_t* entries;
    const float* scale;
    const float* offset;
    const std::uint8_t* data;
    std::int32_t nodes_x, nodes_y;
    float size[3]; // voxels
};

struct FieldView {
    const std::uint16_t* values;
    float first[3]; // centre of block 0, voxels from the volume's corner
    float inverse_factor;
    std::int32_t dims[3];
    float offset, scale;
};

struct CompactView {
    const std::int32_t* nodes; // pairs
    const std::uint16_t* entries;
    const std::int32_t* bricks; // 4 words each
    const std::int32_t* slopes;
    const std::uint8_t* data;
    std::int32_t nodes_x, nodes_y;
    float first[3]; // centre of cell 0, voxels from the volume's corner
    float inverse_factor;
    float last[3]; // cells
};

constexpr int max_lights = 8;

struct MarchInput {
    BrickView volume;
    int lights;
    FieldView depth[max_lights];
    int fields;
    FieldView field[3];
    CompactView compact_density, compact_depth[max_lights], compact_field[3]; // of march_compact(), instead
    const float* table;                                                       // [angle][depth]
    const std::uint16_t* compact_table;
    const float* compact_rows;
    float table_decay, inverse_max_depth;
    float step;       // metres
    float extinction; // along the eye ray, 1/m
    float beam_scale; // 1 / eye extinction over the medium's
    float optical_step, stop;
    bool riemann;
    const std::uint8_t* detail; // null: none
    float detail_strength, detail_cells, inverse_most;
    bool detail_drifts;
    float detail_first[3], detail_second[3]; // cells
};

// Up to 16 rays, structure of arrays.
struct Packet {
    float o[3][16]; // where distances are counted from: voxels from the volume's corner
    float d[3][16]; // voxels a metre
    float t0[16], t1[16];
    float angle[max_lights][16]; // table coordinates
    float beam[max_lights][16];  // results
    float field[3][16];
    float transmittance[16], depth[16], spread[16];
};

} // namespace alpenglow::clouds
#endif

HWY_BEFORE_NAMESPACE();
namespace alpenglow::clouds::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

// 32 bits at byte offsets.
HWY_INLINE VI gather_bytes(const void* base, VI offset) {
    return hn::GatherOffset(DI(), static_cast<const std::int32_t*>(base), offset);
}

HWY_INLINE V lerp(V a, V b, V t) {
    return hn::MulAdd(t, hn::Sub(b, a), a);
}

// Brick numbers for points in the volume (others must be masked off by the caller); -1: nothing there; -2: not even a
// node.
HWY_INLINE VI find_brick(const BrickView& v, VI bx, VI by, VI bz) {
    const DI di;
    const VI node_index =
        hn::Add(hn::Mul(hn::Add(hn::Mul(hn::ShiftRight<3>(bz), hn::Set(di, v.nodes_y)), hn::ShiftRight<3>(by)),
                        hn::Set(di, v.nodes_x)),
                hn::ShiftRight<3>(bx));
    const VI node = hn::GatherIndex(di, v.nodes, node_index);
    const VI seven = hn::Set(di, 7);
    const VI place = hn::Add(hn::ShiftLeft<6>(hn::And(bz, seven)),
                             hn::Add(hn::ShiftLeft<3>(hn::And(by, seven)), hn::And(bx, seven)));
    const auto missing = hn::Lt(node, hn::Zero(di));
    const VI brick = hn::GatherIndex(di, v.entries, hn::Add(hn::Max(node, hn::Zero(di)), place));
    return hn::IfThenElse(missing, hn::Set(di, -2), brick);
}

// The same of a compact field.
HWY_INLINE VI find_brick(const CompactView& v, VI bx, VI by, VI bz) {
    const DI di;
    const VI node_index =
        hn::Add(hn::Mul(hn::Add(hn::Mul(hn::ShiftRight<3>(bz), hn::Set(di, v.nodes_y)), hn::ShiftRight<3>(by)),
                        hn::Set(di, v.nodes_x)),
                hn::ShiftRight<3>(bx));
    const VI pair = hn::ShiftLeft<1>(node_index);
    const VI first = hn::GatherIndex(di, v.nodes, pair);
    const VI seven = hn::Set(di, 7);
    const VI place = hn::Add(hn::ShiftLeft<6>(hn::And(bz, seven)),
                             hn::Add(hn::ShiftLeft<3>(hn::And(by, seven)), hn::And(bx, seven)));
    const VI entry = hn::Add(hn::GatherIndex(di, v.nodes + 1, pair), place);
    const VI within = hn::And(gather_bytes(v.entries, hn::ShiftLeft<1>(entry)), hn::Set(di, 0xffff));
    const VI brick = hn::IfThenElse(hn::Eq(within, hn::Set(di, 512)), hn::Set(di, -1), hn::Add(first, within));
    return hn::IfThenElse(hn::Lt(first, hn::Zero(di)), hn::Set(di, -2), brick);
}

// Trilinear density in known bricks (numbers >= 0) at voxel (ix, iy, iz) + fractions.
HWY_INLINE V sample_brick(const BrickView& v, VI brick, VI ix, VI iy, VI iz, V tx, V ty, V tz) {
    const D d;
    const DI di;
    const VI seven = hn::Set(di, 7);
    const VI byte = hn::Set(di, 0xff);
    const VI at = hn::Add(hn::Mul(brick, hn::Set(di, static_cast<std::int32_t>(BrickVolume::brick_stride))),
                          hn::Add(hn::Mul(hn::And(iz, seven), hn::Set(di, 81)),
                                  hn::Add(hn::Mul(hn::And(iy, seven), hn::Set(di, 9)), hn::And(ix, seven))));
    const auto row = [&](int o) {
        const VI pair = gather_bytes(v.data + o, at);
        const V a = hn::ConvertTo(d, hn::And(pair, byte));
        const V b = hn::ConvertTo(d, hn::And(hn::ShiftRight<8>(pair), byte));
        return lerp(a, b, tx);
    };
    const V value = lerp(lerp(row(0), row(9), ty), lerp(row(81), row(90), ty), tz);
    return hn::MulAdd(value, hn::GatherIndex(d, v.scale, brick), hn::GatherIndex(d, v.offset, brick));
}

HWY_INLINE V sample_field(const FieldView& f, V px, V py, V pz) {
    const D d;
    const DI di;
    const auto coordinate = [&](V p, int a) {
        const V q = hn::Mul(hn::Sub(p, hn::Set(d, f.first[a])), hn::Set(d, f.inverse_factor));
        return hn::Min(hn::Max(q, hn::Zero(d)), hn::Set(d, static_cast<float>(f.dims[a] - 1)));
    };
    const V x = coordinate(px, 0);
    const V y = coordinate(py, 1);
    const V z = coordinate(pz, 2);
    const VI ix = hn::Min(hn::ConvertTo(di, x), hn::Set(di, f.dims[0] - 2));
    const VI iy = hn::Min(hn::ConvertTo(di, y), hn::Set(di, f.dims[1] - 2));
    const VI iz = hn::Min(hn::ConvertTo(di, z), hn::Set(di, f.dims[2] - 2));
    const V tx = hn::Sub(x, hn::ConvertTo(d, ix));
    const V ty = hn::Sub(y, hn::ConvertTo(d, iy));
    const V tz = hn::Sub(z, hn::ConvertTo(d, iz));
    const VI cell = hn::Add(hn::Mul(hn::Add(hn::Mul(iz, hn::Set(di, f.dims[1])), iy), hn::Set(di, f.dims[0])), ix);
    const VI at = hn::ShiftLeft<1>(cell);
    const VI word = hn::Set(di, 0xffff);
    const std::ptrdiff_t sy = f.dims[0];
    const std::ptrdiff_t sz = sy * f.dims[1];
    const auto row = [&](std::ptrdiff_t o) {
        const VI pair = gather_bytes(f.values + o, at);
        const V a = hn::ConvertTo(d, hn::And(pair, word));
        const V b = hn::ConvertTo(d, hn::And(hn::ShiftRight<16>(pair), word));
        return lerp(a, b, tx);
    };
    const V value = lerp(lerp(row(0), row(sy), ty), lerp(row(sz), row(sy + sz), ty), tz);
    return hn::MulAdd(value, hn::Set(d, f.scale), hn::Set(d, f.offset));
}

// CompactField::sample() in known bricks, at cells from the brick's corner.
template <bool squared>
HWY_INLINE V sample_compact_brick(const CompactView& v, VI brick, V lx, V ly, V lz) {
    const D d;
    const DI di;
    const hn::RebindToUnsigned<DI> du;
    const VI about = hn::ShiftLeft<2>(brick);
    const VI base = hn::GatherIndex(di, v.bricks, about);
    const auto box = hn::BitCast(du, hn::GatherIndex(di, v.bricks + 1, about));
    const VI nibble = hn::Set(di, 15);
    const VI code = hn::BitCast(di, box);
    const VI shift = hn::BitCast(di, hn::ShiftRight<28>(box));
    // 2^-shift, by its exponent.
    const V inverse = hn::BitCast(d, hn::ShiftLeft<23>(hn::Sub(hn::Set(di, 127), shift)));
    const VI nx = hn::And(hn::ShiftRight<12>(code), nibble);
    const VI ny = hn::And(hn::ShiftRight<16>(code), nibble);
    const VI nz = hn::And(hn::ShiftRight<20>(code), nibble);
    const auto coordinate = [&](V l, VI low, VI steps) {
        const V q = hn::Mul(hn::Sub(l, hn::ConvertTo(d, low)), inverse);
        return hn::Min(hn::Max(q, hn::Zero(d)), hn::ConvertTo(d, steps));
    };
    const V x = coordinate(lx, hn::And(code, nibble), nx);
    const V y = coordinate(ly, hn::And(hn::ShiftRight<4>(code), nibble), ny);
    const V z = coordinate(lz, hn::And(hn::ShiftRight<8>(code), nibble), nz);
    const VI ix = hn::ConvertTo(di, x);
    const VI iy = hn::ConvertTo(di, y);
    const VI iz = hn::ConvertTo(di, z);
    const V tx = hn::Sub(x, hn::ConvertTo(d, ix));
    const V ty = hn::Sub(y, hn::ConvertTo(d, iy));
    const V tz = hn::Sub(z, hn::ConvertTo(d, iz));
    const VI one = hn::Set(di, 1);
    const VI seven = hn::Set(di, 7);
    const VI bits = hn::And(hn::ShiftRight<24>(code), nibble);
    const auto bits_u = hn::BitCast(du, bits);
    const auto mask = hn::Sub(hn::Shl(hn::Set(du, 1U), bits_u), hn::Set(du, 1U));
    const VI row_bits = hn::Mul(hn::Add(nx, one), bits);
    const VI plane_bits = hn::Mul(hn::Add(ny, one), row_bits);
    const VI start = hn::Add(hn::Mul(iz, plane_bits), hn::Add(hn::Mul(iy, row_bits), hn::Mul(ix, bits)));
    const auto* floats = reinterpret_cast<const float*>(v.bricks);
    const V offset = hn::GatherIndex(d, floats + 2, about);
    const V scale = hn::GatherIndex(d, floats + 3, about);
    const auto decoded = [&](V kept) {
        if constexpr (squared) {
            const V root = hn::MulAdd(kept, scale, offset);
            return hn::Mul(root, root);
        } else {
            return kept;
        }
    };
    const auto row = [&](VI at) {
        const auto word = hn::BitCast(du, gather_bytes(v.data, hn::Add(base, hn::ShiftRight<3>(at))));
        const auto pair = hn::Shr(word, hn::BitCast(du, hn::And(at, seven)));
        const V a = hn::ConvertTo(d, hn::BitCast(di, hn::And(pair, mask)));
        const V b = hn::ConvertTo(d, hn::BitCast(di, hn::And(hn::Shr(pair, bits_u), mask)));
        return lerp(decoded(a), decoded(b), tx);
    };
    const VI above = hn::Add(start, plane_bits);
    const V value = lerp(lerp(row(start), row(hn::Add(start, row_bits)), ty),
                         lerp(row(above), row(hn::Add(above, row_bits)), ty), tz);
    if constexpr (squared) {
        return value;
    } else {
        const VI slope = hn::GatherIndex(di, v.slopes, brick);
        const VI exponent = hn::BitCast(di, hn::ShiftRight<27>(hn::BitCast(du, slope)));
        const V unit = hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(exponent, hn::Set(di, 127 - 24))));
        const V sx = hn::ConvertTo(d, hn::ShiftRight<23>(hn::ShiftLeft<23>(slope)));
        const V sy = hn::ConvertTo(d, hn::ShiftRight<23>(hn::ShiftLeft<14>(slope)));
        const V sz = hn::ConvertTo(d, hn::ShiftRight<23>(hn::ShiftLeft<5>(slope)));
        const V plane = hn::MulAdd(sx, lx, hn::MulAdd(sy, ly, hn::Mul(sz, lz)));
        return hn::MulAdd(plane, unit, hn::MulAdd(value, scale, offset));
    }
}

// CompactField::sample() at voxels from the volume's corner.
HWY_INLINE V sample_compact(const CompactView& f, V px, V py, V pz) {
    const D d;
    const DI di;
    const auto coordinate = [&](V p, int a) {
        const V q = hn::Mul(hn::Sub(p, hn::Set(d, f.first[a])), hn::Set(d, f.inverse_factor));
        return hn::Min(hn::Max(q, hn::Zero(d)), hn::Set(d, f.last[a]));
    };
    const V x = coordinate(px, 0);
    const V y = coordinate(py, 1);
    const V z = coordinate(pz, 2);
    const VI bx = hn::ShiftRight<3>(hn::ConvertTo(di, x));
    const VI by = hn::ShiftRight<3>(hn::ConvertTo(di, y));
    const VI bz = hn::ShiftRight<3>(hn::ConvertTo(di, z));
    const VI brick = find_brick(f, bx, by, bz);
    const auto local = [&](V q, VI b) { return hn::Sub(q, hn::ConvertTo(d, hn::ShiftLeft<3>(b))); };
    const V value =
        sample_compact_brick<false>(f, hn::Max(brick, hn::Zero(di)), local(x, bx), local(y, by), local(z, bz));
    return hn::IfThenElseZero(hn::RebindMask(d, hn::Gt(brick, hn::Set(di, -1))), value);
}

// One copy of the detail's texture, -1 .. 1, at cells >= 0.
HWY_INLINE V sample_texture(const MarchInput& in, V x, V y, V z) {
    const D d;
    const DI di;
    const VI ix = hn::ConvertTo(di, x);
    const VI iy = hn::ConvertTo(di, y);
    const VI iz = hn::ConvertTo(di, z);
    const V tx = hn::Sub(x, hn::ConvertTo(d, ix));
    const V ty = hn::Sub(y, hn::ConvertTo(d, iy));
    const V tz = hn::Sub(z, hn::ConvertTo(d, iz));
    const VI wrap = hn::Set(di, DetailTexture::size - 1);
    const VI byte = hn::Set(di, 0xff);
    const VI side = hn::Set(di, DetailTexture::stride);
    const VI at =
        hn::Add(hn::Mul(hn::Add(hn::Mul(hn::And(iz, wrap), side), hn::And(iy, wrap)), side), hn::And(ix, wrap));
    const auto row = [&](int o) {
        const VI pair = gather_bytes(in.detail + o, at);
        const V a = hn::ConvertTo(d, hn::And(pair, byte));
        const V b = hn::ConvertTo(d, hn::And(hn::ShiftRight<8>(pair), byte));
        return lerp(a, b, tx);
    };
    constexpr int stride = DetailTexture::stride;
    const V value =
        lerp(lerp(row(0), row(stride), ty), lerp(row(stride * stride), row(stride * stride + stride), ty), tz);
    return hn::MulSub(value, hn::Set(d, 2.0F / 255.0F), hn::Set(d, 1.0F));
}

// DetailTexture::sample() at voxels from the volume's corner.
HWY_INLINE V sample_detail(const MarchInput& in, V px, V py, V pz) {
    const D d;
    const V cells = hn::Set(d, in.detail_cells);
    const auto at = [&](V p, float offset) { return hn::MulAdd(p, cells, hn::Set(d, offset)); };
    const float* a = in.detail_first;
    const V noise = sample_texture(in, at(px, a[0]), at(py, a[1]), at(pz, a[2]));
    if (!in.detail_drifts) {
        return noise;
    }
    const float* b = in.detail_second;
    return hn::Mul(hn::Add(noise, sample_texture(in, at(py, b[0]), at(pz, b[1]), at(px, b[2]))),
                   hn::Set(d, 0.70710678F));
}

void sample_points(const BrickView& v, const float* x, const float* y, const float* z, float* out, std::size_t count) {
    const D d;
    const DI di;
    const std::size_t lanes = hn::Lanes(d);
    alignas(64) float padded[4][16];
    for (std::size_t i = 0; i < count; i += lanes) {
        const float* px = x + i;
        const float* py = y + i;
        const float* pz = z + i;
        const bool whole = i + lanes <= count;
        if (!whole) {
            for (std::size_t l = 0; l < lanes; ++l) {
                const std::size_t j = i + l < count ? i + l : i;
                padded[0][l] = x[j];
                padded[1][l] = y[j];
                padded[2][l] = z[j];
            }
            px = padded[0];
            py = padded[1];
            pz = padded[2];
        }
        const V zero = hn::Zero(d);
        const V vx = hn::LoadU(d, px);
        const V vy = hn::LoadU(d, py);
        const V vz = hn::LoadU(d, pz);
        const M inside = hn::And(hn::And(hn::And(hn::Ge(vx, zero), hn::Ge(vy, zero)), hn::Ge(vz, zero)),
                                 hn::And(hn::And(hn::Lt(vx, hn::Set(d, v.size[0])), hn::Lt(vy, hn::Set(d, v.size[1]))),
                                         hn::Lt(vz, hn::Set(d, v.size[2]))));
        const V cx = hn::IfThenElseZero(inside, vx);
        const V cy = hn::IfThenElseZero(inside, vy);
        const V cz = hn::IfThenElseZero(inside, vz);
        const VI ix = hn::ConvertTo(di, cx);
        const VI iy = hn::ConvertTo(di, cy);
        const VI iz = hn::ConvertTo(di, cz);
        const VI brick = find_brick(v, hn::ShiftRight<3>(ix), hn::ShiftRight<3>(iy), hn::ShiftRight<3>(iz));
        const M filled = hn::And(inside, hn::RebindMask(d, hn::Gt(brick, hn::Set(di, -1))));
        const V value = sample_brick(v, hn::Max(brick, hn::Zero(di)), ix, iy, iz, hn::Sub(cx, hn::ConvertTo(d, ix)),
                                     hn::Sub(cy, hn::ConvertTo(d, iy)), hn::Sub(cz, hn::ConvertTo(d, iz)));
        const V result = hn::IfThenElseZero(filled, value);
        if (whole) {
            hn::StoreU(result, d, out + i);
        } else {
            hn::StoreU(result, d, padded[3]);
            for (std::size_t l = 0; i + l < count; ++l) {
                out[i + l] = padded[3][l];
            }
        }
    }
}

std::size_t packet_lanes() {
    return hn::Lanes(D());
}

// What a march reads from: the bricks and dense fields, or their compact form.
struct Plain {
    static HWY_INLINE VI find(const MarchInput& in, VI bx, VI by, VI bz) { return find_brick(in.volume, bx, by, bz); }
    static HWY_INLINE V density(const MarchInput& in, VI brick, VI ix, VI iy, VI iz, V px, V py, V pz) {
        const D d;
        return sample_brick(in.volume, brick, ix, iy, iz, hn::Sub(px, hn::ConvertTo(d, ix)),
                            hn::Sub(py, hn::ConvertTo(d, iy)), hn::Sub(pz, hn::ConvertTo(d, iz)));
    }
    static HWY_INLINE V depth(const MarchInput& in, int i, V px, V py, V pz) {
        return sample_field(in.depth[i], px, py, pz);
    }
    static HWY_INLINE V field(const MarchInput& in, int i, V px, V py, V pz) {
        return sample_field(in.field[i], px, py, pz);
    }
    static HWY_INLINE V beam(const MarchInput& in, VI angle, VI depth, V tu, V ta) {
        const D d;
        const VI at = hn::Add(hn::Mul(angle, hn::Set(DI(), BeamTable::depths)), depth);
        const V near = lerp(hn::GatherIndex(d, in.table, at), hn::GatherIndex(d, in.table + 1, at), tu);
        const V far = lerp(hn::GatherIndex(d, in.table + BeamTable::depths, at),
                           hn::GatherIndex(d, in.table + BeamTable::depths + 1, at), tu);
        return lerp(near, far, ta);
    }
};

struct Compact {
    static HWY_INLINE VI find(const MarchInput& in, VI bx, VI by, VI bz) {
        return find_brick(in.compact_density, bx, by, bz);
    }
    static HWY_INLINE V density(const MarchInput& in, VI brick, VI ix, VI iy, VI iz, V px, V py, V pz) {
        const auto local = [](V p, VI i) { return hn::Sub(p, hn::ConvertTo(D(), hn::AndNot(hn::Set(DI(), 7), i))); };
        return sample_compact_brick<true>(in.compact_density, brick, local(px, ix), local(py, iy), local(pz, iz));
    }
    static HWY_INLINE V depth(const MarchInput& in, int i, V px, V py, V pz) {
        return sample_compact(in.compact_depth[i], px, py, pz);
    }
    static HWY_INLINE V field(const MarchInput& in, int i, V px, V py, V pz) {
        return sample_compact(in.compact_field[i], px, py, pz);
    }
    static HWY_INLINE V beam(const MarchInput& in, VI angle, VI depth, V tu, V ta) {
        const D d;
        const DI di;
        const VI word = hn::Set(di, 0xffff);
        const VI at = hn::ShiftLeft<1>(hn::Add(hn::Mul(angle, hn::Set(di, BeamTable::depths)), depth));
        const VI about = hn::ShiftLeft<1>(angle);
        const auto row = [&](int next) {
            const VI pair = gather_bytes(in.compact_table + next * BeamTable::depths, at);
            const V a = hn::ConvertTo(d, hn::And(pair, word));
            const V b = hn::ConvertTo(d, hn::And(hn::ShiftRight<16>(pair), word));
            const float* of_row = in.compact_rows + std::ptrdiff_t(2) * next;
            return hn::MulAdd(lerp(a, b, tu), hn::GatherIndex(d, of_row + 1, about), hn::GatherIndex(d, of_row, about));
        };
        return lerp(row(0), row(1), ta);
    }
};

template <class From>
void march_from(const MarchInput& in, Packet& packet) {
    const D d;
    const DI di;
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.0F);
    const V half = hn::Set(d, 0.5F);
    const V step = hn::Set(d, in.step);
    const V inverse_step = hn::Set(d, 1.0F / in.step);
    const V dx = hn::LoadU(d, packet.d[0]);
    const V dy = hn::LoadU(d, packet.d[1]);
    const V dz = hn::LoadU(d, packet.d[2]);
    const V ex = hn::LoadU(d, packet.o[0]);
    const V ey = hn::LoadU(d, packet.o[1]);
    const V ez = hn::LoadU(d, packet.o[2]);
    const auto safe_inverse = [&](V v) {
        const V tiny = hn::Set(d, 1e-12F);
        return hn::Div(one, hn::IfThenElse(hn::Lt(hn::Abs(v), tiny), hn::CopySign(tiny, v), v));
    };
    const V inverse_x = safe_inverse(dx);
    const V inverse_y = safe_inverse(dy);
    const V inverse_z = safe_inverse(dz);
    const M positive_x = hn::Gt(dx, zero);
    const M positive_y = hn::Gt(dy, zero);
    const M positive_z = hn::Gt(dz, zero);
    const V t0 = hn::LoadU(d, packet.t0);
    const V t1 = hn::LoadU(d, packet.t1);
    const V low = zero;
    const V sx = hn::Set(d, in.volume.size[0] - 1e-3F);
    const V sy = hn::Set(d, in.volume.size[1] - 1e-3F);
    const V sz = hn::Set(d, in.volume.size[2] - 1e-3F);

    V k = zero;
    V width = one; // steps this sample stands for
    V transmittance = one;
    V depth = zero;
    V depth_2 = zero;
    V weight = zero;
    V beam[max_lights];
    V field[3];
    for (int i = 0; i < in.lights; ++i) {
        beam[i] = zero;
    }
    for (int i = 0; i < in.fields; ++i) {
        field[i] = zero;
    }
    M active = hn::Lt(t0, t1);
    while (!hn::AllFalse(d, active)) {
        const V from = hn::Max(hn::Mul(k, step), t0);
        const V to = hn::Min(hn::Mul(hn::Add(k, width), step), t1);
        active = hn::And(active, hn::Lt(from, t1));
        const V t = hn::Mul(half, hn::Add(from, to));
        // Points of lanes that are done stay in the volume, so that their loads are harmless.
        const V px = hn::Min(hn::Max(hn::MulAdd(dx, t, ex), low), sx);
        const V py = hn::Min(hn::Max(hn::MulAdd(dy, t, ey), low), sy);
        const V pz = hn::Min(hn::Max(hn::MulAdd(dz, t, ez), low), sz);
        const VI ix = hn::ConvertTo(di, px);
        const VI iy = hn::ConvertTo(di, py);
        const VI iz = hn::ConvertTo(di, pz);
        const VI bx = hn::ShiftRight<3>(ix);
        const VI by = hn::ShiftRight<3>(iy);
        const VI bz = hn::ShiftRight<3>(iz);
        const VI brick = From::find(in, bx, by, bz);
        const M filled = hn::And(active, hn::RebindMask(d, hn::Gt(brick, hn::Set(di, -1))));
        V next = hn::Add(k, width);
        V next_width = one;
        if (!hn::AllFalse(d, filled)) {
            V density =
                hn::IfThenElseZero(filled, From::density(in, hn::Max(brick, hn::Zero(di)), ix, iy, iz, px, py, pz));
            if (in.detail != nullptr && !hn::AllFalse(d, hn::Gt(density, zero))) {
                const V weight_of =
                    hn::Mul(hn::Set(d, in.detail_strength), hn::NegMulAdd(density, hn::Set(d, in.inverse_most), one));
                density = hn::Mul(density, hn::Max(hn::MulAdd(weight_of, sample_detail(in, px, py, pz), one), zero));
            }
            const V s = hn::Mul(density, hn::Set(d, in.extinction));
            const V length = hn::Max(hn::Sub(to, from), zero);
            const V tau = hn::Mul(s, length);
            if (!hn::AllFalse(d, hn::And(active, hn::Gt(tau, zero)))) {
                // 1 - exp(-tau) by its series where the subtraction would cancel.
                const V e = hn::Exp(d, hn::Max(hn::Neg(tau), hn::Set(d, -87.0F)));
                const V series =
                    hn::Mul(tau, hn::MulAdd(tau, hn::MulAdd(tau, hn::Set(d, 1.0F / 6.0F), hn::Set(d, -0.5F)), one));
                const V opacity = hn::IfThenElse(hn::Lt(tau, hn::Set(d, 1e-2F)), series, hn::Sub(one, e));
                const V share = hn::IfThenElseZero(active, hn::Mul(transmittance, in.riemann ? tau : opacity));
                for (int i = 0; i < in.lights; ++i) {
                    const V optical = From::depth(in, i, px, py, pz);
                    const V u = hn::Mul(
                        hn::Min(hn::Sqrt(hn::Max(hn::Mul(optical, hn::Set(d, in.inverse_max_depth)), zero)), one),
                        hn::Set(d, static_cast<float>(BeamTable::depths - 1)));
                    const VI iu = hn::Min(hn::ConvertTo(di, u), hn::Set(di, BeamTable::depths - 2));
                    const V tu = hn::Sub(u, hn::ConvertTo(d, iu));
                    const V a = hn::LoadU(d, packet.angle[i]);
                    const VI ia = hn::Min(hn::ConvertTo(di, a), hn::Set(di, BeamTable::angles - 2));
                    const V ta = hn::Sub(a, hn::ConvertTo(d, ia));
                    const V value = From::beam(in, ia, iu, tu, ta);
                    const V decay =
                        hn::Exp(d, hn::Max(hn::Mul(optical, hn::Set(d, -in.table_decay)), hn::Set(d, -87.0F)));
                    beam[i] = hn::MulAdd(share, hn::Mul(value, decay), beam[i]);
                }
                for (int i = 0; i < in.fields; ++i) {
                    field[i] = hn::MulAdd(share, From::field(in, i, px, py, pz), field[i]);
                }
                const V seen = hn::IfThenElseZero(active, hn::Mul(transmittance, opacity));
                depth = hn::MulAdd(seen, t, depth);
                depth_2 = hn::MulAdd(hn::Mul(seen, t), t, depth_2);
                weight = hn::Add(weight, seen);
                transmittance =
                    hn::IfThenElse(hn::And(active, hn::Gt(tau, zero)), hn::Mul(transmittance, e), transmittance);
                if (in.optical_step > 0.0F) {
                    // The less is still seen, the more optical depth a step may span.
                    const V allowed =
                        hn::Mul(hn::Set(d, in.optical_step),
                                hn::Div(hn::Sub(one, transmittance), hn::Max(transmittance, hn::Set(d, 1e-3F))));
                    const V steps = hn::Floor(hn::Div(allowed, hn::Max(hn::Mul(s, step), hn::Set(d, 0.05F))));
                    next_width = hn::IfThenElse(hn::Gt(tau, zero), hn::Min(hn::Max(steps, one), hn::Set(d, 4.0F)), one);
                }
            }
        }
        const M vacant = hn::AndNot(hn::RebindMask(d, hn::Gt(brick, hn::Set(di, -1))), active);
        if (!hn::AllFalse(d, vacant)) {
            // Leave the empty brick, or the empty node of 8^3 bricks, at once.
            const auto nodeless = hn::Eq(brick, hn::Set(di, -2));
            const VI size = hn::IfThenElse(nodeless, hn::Set(di, 64), hn::Set(di, 8));
            const VI mask = hn::Neg(size);
            const V extent = hn::ConvertTo(d, size);
            const auto exit = [&](VI cell, V eye, V inverse, M positive) {
                const V corner = hn::ConvertTo(d, hn::And(cell, mask));
                return hn::Mul(hn::Sub(hn::Add(corner, hn::IfThenElseZero(positive, extent)), eye), inverse);
            };
            const V leave = hn::Min(hn::Min(exit(ix, ex, inverse_x, positive_x), exit(iy, ey, inverse_y, positive_y)),
                                    exit(iz, ez, inverse_z, positive_z));
            const V beyond = hn::Ceil(hn::MulSub(leave, inverse_step, half));
            next = hn::IfThenElse(vacant, hn::Max(next, hn::Min(beyond, hn::Set(d, 1e9F))), next);
        }
        k = next;
        width = next_width;
        active = hn::And(active, hn::Gt(transmittance, hn::Set(d, in.stop)));
    }
    // What rays that stopped early have left out counts as more of the same.
    const M stopped = hn::Le(transmittance, hn::Set(d, in.stop));
    const V correction = hn::IfThenElse(stopped, hn::Div(one, hn::Sub(one, hn::Min(transmittance, half))), one);
    for (int i = 0; i < in.lights; ++i) {
        hn::StoreU(hn::Mul(hn::Mul(beam[i], correction), hn::Set(d, in.beam_scale)), d, packet.beam[i]);
    }
    for (int i = 0; i < in.fields; ++i) {
        hn::StoreU(hn::Mul(field[i], correction), d, packet.field[i]);
    }
    hn::StoreU(hn::IfThenElseZero(hn::Not(stopped), transmittance), d, packet.transmittance);
    const V inverse_weight = hn::Div(one, hn::Max(weight, hn::Set(d, 1e-30F)));
    const V mean = hn::IfThenElseZero(hn::Gt(weight, zero), hn::Mul(depth, inverse_weight));
    const V variance = hn::NegMulAdd(mean, mean, hn::Mul(depth_2, inverse_weight));
    hn::StoreU(mean, d, packet.depth);
    hn::StoreU(hn::IfThenElseZero(hn::Gt(weight, zero), hn::Sqrt(hn::Max(variance, zero))), d, packet.spread);
}

void march_packet(const MarchInput& in, Packet& packet) {
    march_from<Plain>(in, packet);
}

void march_compact(const MarchInput& in, Packet& packet) {
    march_from<Compact>(in, packet);
}

} // namespace alpenglow::clouds::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {

HWY_EXPORT(sample_points);
HWY_EXPORT(march_packet);
HWY_EXPORT(march_compact);
HWY_EXPORT(packet_lanes);

namespace {

BrickView view_of(const BrickVolume& volume) {
    const glm::ivec3 size = volume.size();
    return {volume.table().node_table().data(),
            volume.table().entries().data(),
            volume.scales().data(),
            volume.offsets().data(),
            volume.data().data(),
            volume.table().nodes().x,
            volume.table().nodes().y,
            {static_cast<float>(size.x), static_cast<float>(size.y), static_cast<float>(size.z)}};
}

FieldView view_of(const Field16& field, const glm::ivec3& corner) {
    const Lattice& l = field.lattice;
    const float half = 0.5F * static_cast<float>(l.factor - 1);
    return {field.values.data(),
            {static_cast<float>(l.first.x - corner.x) + half, static_cast<float>(l.first.y - corner.y) + half,
             static_cast<float>(l.first.z - corner.z) + half},
            1.0F / static_cast<float>(l.factor),
            {l.dims.x, l.dims.y, l.dims.z},
            field.offset,
            field.scale};
}

CompactView view_of(const CompactField& field, const glm::ivec3& corner) {
    static_assert(sizeof(CompactField::Brick) == 16);
    const glm::vec3 first = field.origin() - glm::vec3(corner);
    const glm::vec3 last = glm::vec3(field.size()) - 1e-3F;
    return {reinterpret_cast<const std::int32_t*>(field.node_table().data()),
            field.entries().data(),
            reinterpret_cast<const std::int32_t*>(field.bricks().data()),
            reinterpret_cast<const std::int32_t*>(field.slopes().data()),
            field.data().data(),
            field.nodes().x,
            field.nodes().y,
            {first.x, first.y, first.z},
            1.0F / static_cast<float>(field.factor()),
            {last.x, last.y, last.z}};
}

} // namespace

void sample_batch(const BrickVolume& volume, std::span<const float> x, std::span<const float> y,
                  std::span<const float> z, std::span<float> density) {
    assert(x.size() == y.size() && y.size() == z.size() && z.size() == density.size());
    if (volume.empty()) {
        std::fill(density.begin(), density.end(), 0.0F);
        return;
    }
    // The kernel works from the volume's corner; a block at a time is shifted there.
    constexpr std::size_t block = 256;
    float shifted[3][block];
    const glm::vec3 corner(volume.min());
    for (std::size_t i = 0; i < x.size(); i += block) {
        const std::size_t n = std::min(block, x.size() - i);
        for (std::size_t j = 0; j < n; ++j) {
            shifted[0][j] = x[i + j] - corner.x;
            shifted[1][j] = y[i + j] - corner.y;
            shifted[2][j] = z[i + j] - corner.z;
        }
        HWY_DYNAMIC_DISPATCH(sample_points)(view_of(volume), shifted[0], shifted[1], shifted[2], density.data() + i, n);
    }
}

namespace {

// What both forms of a lit cloud tell about their rays, beside a MarchInput.
struct Scene {
    const GridTransform& transform;
    glm::ivec3 corner; // of the volume, index coordinates
    glm::ivec3 active_low, active_high;
    float max_density;
    float table_decay, table_max_depth, table_narrow;
    std::vector<glm::vec3> to_light; // the grid's frame
    std::vector<glm::vec3> irradiance;
    glm::vec3 colour; // of a single field
    bool compact;
};

Picture march_scene(const Scene& scene, MarchInput& in, const Camera& camera, const MarchSettings& settings) {
    Picture picture(camera.width, camera.height);
    const GridTransform& transform = scene.transform;
    const glm::dvec3 eye = transform.index_from_world(camera.position_m);
    const PixelRect rect = settings.rect.empty() ? PixelRect{0, 0, camera.width, camera.height} : settings.rect;
    assert(rect.x0 >= 0 && rect.y0 >= 0 && rect.x1 <= camera.width && rect.y1 <= camera.height);
    const auto voxel = static_cast<float>(std::min({transform.voxel_m.x, transform.voxel_m.y, transform.voxel_m.z}));
    in.table_decay = scene.table_decay;
    in.inverse_max_depth = 1.0F / scene.table_max_depth;
    in.step = settings.step_voxels * voxel;
    in.optical_step = settings.optical_step;
    in.stop = settings.stop_transmittance;
    if (settings.detail != nullptr && settings.detail_strength > 0.0F) {
        in.detail = settings.detail->data().data();
        in.detail_strength = settings.detail_strength;
        in.detail_cells = settings.detail_cells;
        in.inverse_most = 1.0F / scene.max_density;
        in.detail_drifts = settings.detail_offsets.has_value();
        const DetailOffsets offsets = settings.detail_offsets.value_or(DetailOffsets{});
        for (int a = 0; a < 3; ++a) {
            in.detail_first[a] = offsets.first[a];
            in.detail_second[a] = offsets.second[a];
        }
    }
    const glm::dvec3 low(scene.active_low - 1);
    const glm::dvec3 high(scene.active_high + 1);
    // Packets are tiles four pixels wide: neighbours take the same bricks.
    const int lanes = static_cast<int>(HWY_DYNAMIC_DISPATCH(packet_lanes)());
    const int tile_w = std::min(4, lanes);
    const int tile_h = lanes / tile_w;
    const int tiles_x = (rect.x1 - rect.x0 + tile_w - 1) / tile_w;
    const int tiles_y = (rect.y1 - rect.y0 + tile_h - 1) / tile_h;
    parallel_for(
        std::size_t(tiles_x) * std::size_t(tiles_y), 8,
        [&](std::size_t begin, std::size_t end) {
            Packet packet{};
            double bases[16] = {};
            for (std::size_t tile = begin; tile < end; ++tile) {
                const int x0 = rect.x0 + static_cast<int>(tile % std::size_t(tiles_x)) * tile_w;
                const int y0 = rect.y0 + static_cast<int>(tile / std::size_t(tiles_x)) * tile_h;
                bool any = false;
                for (int lane = 0; lane < lanes; ++lane) {
                    const int x = std::min(x0 + lane % tile_w, rect.x1 - 1);
                    const int y = std::min(y0 + lane / tile_w, rect.y1 - 1);
                    const glm::vec3 world =
                        camera.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
                    const glm::vec3 local(transform.local_direction(glm::dvec3(world)));
                    const glm::vec3 direction = local / glm::vec3(transform.voxel_m);
                    const std::size_t ray = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
                    double enter = settings.from_m.empty() ? 0.0 : std::max(0.0, double(settings.from_m[ray]));
                    auto leave = double(settings.scene_depth_m.empty() ? 1e30F : settings.scene_depth_m[ray]);
                    for (int a = 0; a < 3; ++a) {
                        const double inverse =
                            1.0 / (std::abs(direction[a]) < 1e-12F ? std::copysign(1e-12, double(direction[a]))
                                                                   : double(direction[a]));
                        const double u = (low[a] - eye[a]) * inverse;
                        const double v = (high[a] - eye[a]) * inverse;
                        enter = std::max(enter, std::min(u, v));
                        leave = std::min(leave, std::max(u, v));
                    }
                    // As in march_ray(): steps are counted from the eye, distances from the step that enters the box.
                    const double base = enter < leave ? std::floor(enter / double(in.step)) * double(in.step) : 0.0;
                    bases[lane] = base;
                    const auto t0 = static_cast<float>(enter < leave ? enter - base : 1.0);
                    const auto t1 = static_cast<float>(enter < leave ? leave - base : 0.0);
                    for (int a = 0; a < 3; ++a) {
                        packet.d[a][lane] = direction[a];
                        packet.o[a][lane] = static_cast<float>(
                            enter < leave ? eye[a] - double(scene.corner[a]) + double(direction[a]) * base : 0.0);
                    }
                    packet.t0[lane] = t0;
                    packet.t1[lane] = t1;
                    any = any || t0 < t1;
                    for (int i = 0; i < in.lights; ++i) {
                        const glm::vec3 difference = scene.to_light[std::size_t(i)] - local;
                        packet.angle[i][lane] = BeamTable::angle_coordinate(0.5F * (difference.x * difference.x +
                                                                                    difference.y * difference.y +
                                                                                    difference.z * difference.z),
                                                                            scene.table_narrow);
                    }
                }
                if (!any) {
                    continue;
                }
                if (scene.compact) {
                    HWY_DYNAMIC_DISPATCH(march_compact)(in, packet);
                } else {
                    HWY_DYNAMIC_DISPATCH(march_packet)(in, packet);
                }
                for (int lane = 0; lane < lanes; ++lane) {
                    const int x = x0 + lane % tile_w;
                    const int y = y0 + lane / tile_w;
                    if (x >= rect.x1 || y >= rect.y1) {
                        continue;
                    }
                    const std::size_t pixel = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
                    glm::vec3 sum(0.0F);
                    for (int i = 0; i < in.lights; ++i) {
                        sum += scene.irradiance[std::size_t(i)] * packet.beam[i][lane];
                    }
                    if (in.fields == 1) {
                        sum += scene.colour * packet.field[0][lane];
                    } else if (in.fields == 3) {
                        sum += glm::vec3(packet.field[0][lane], packet.field[1][lane], packet.field[2][lane]);
                    }
                    picture.radiance[pixel] =
                        glm::vec3(std::max(sum.x, 0.0F), std::max(sum.y, 0.0F), std::max(sum.z, 0.0F));
                    picture.transmittance[pixel] = packet.transmittance[lane];
                    picture.spread_m[pixel] = packet.spread[lane];
                    picture.depth_m[pixel] =
                        packet.depth[lane] > 0.0F ? static_cast<float>(bases[lane] + double(packet.depth[lane])) : 0.0F;
                }
            }
        },
        settings.threads);
    return picture;
}

} // namespace

Picture march(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera,
              const MarchSettings& settings) {
    if (volume.empty()) {
        return Picture(camera.width, camera.height);
    }
    assert(lighting.lights().size() <= std::size_t(max_lights));
    CloudLighting::ViewFields made;
    if (settings.fields == nullptr) {
        made = lighting.contract(volume.transform().index_from_world(camera.position_m));
    }
    const CloudLighting::ViewFields& fields = settings.fields != nullptr ? *settings.fields : made;
    const BeamTable& table = lighting.table();
    Scene scene{volume.transform(),
                volume.min(),
                volume.active_low(),
                volume.active_high(),
                volume.max_density(),
                table.decay(),
                table.max_depth(),
                table.narrow(),
                {},
                {},
                fields.colour,
                false};
    MarchInput in{};
    in.volume = view_of(volume);
    in.table = table.values().data();
    in.lights = static_cast<int>(lighting.lights().size());
    for (int i = 0; i < in.lights; ++i) {
        const BakedLight& light = lighting.lights()[std::size_t(i)];
        in.depth[i] = view_of(light.depth, volume.min());
        scene.to_light.push_back(light.to_light);
        scene.irradiance.push_back(light.irradiance);
    }
    in.fields = static_cast<int>(fields.fields.size());
    for (int i = 0; i < in.fields; ++i) {
        in.field[i] = view_of(fields.fields[std::size_t(i)], volume.min());
    }
    in.extinction = lighting.medium().extinction_per_m * lighting.eye_extinction();
    in.beam_scale = 1.0F / lighting.eye_extinction();
    in.riemann = lighting.settings().method == LightingMethod::harris;
    return march_scene(scene, in, camera, settings);
}

Picture march(const CompactCloud& cloud, const Camera& camera, const MarchSettings& settings) {
    if (cloud.empty()) {
        return Picture(camera.width, camera.height);
    }
    assert(cloud.lights().size() <= std::size_t(max_lights));
    const CompactTable& table = cloud.table();
    Scene scene{cloud.transform(),
                cloud.min(),
                cloud.active_low(),
                cloud.active_high(),
                cloud.max_density(),
                table.decay(),
                table.max_depth(),
                table.narrow(),
                {},
                {},
                cloud.colour(),
                true};
    MarchInput in{};
    in.compact_table = table.values().data();
    in.compact_rows = table.rows().data();
    in.compact_density = view_of(cloud.density(), cloud.min());
    const glm::vec3 size(cloud.density().size());
    for (int a = 0; a < 3; ++a) {
        in.volume.size[a] = size[a];
    }
    in.lights = static_cast<int>(cloud.lights().size());
    for (int i = 0; i < in.lights; ++i) {
        const CompactCloud::Light& light = cloud.lights()[std::size_t(i)];
        in.compact_depth[i] = view_of(light.depth, cloud.min());
        scene.to_light.push_back(light.to_light);
        scene.irradiance.push_back(light.irradiance);
    }
    in.fields = static_cast<int>(cloud.fields().size());
    for (int i = 0; i < in.fields; ++i) {
        in.compact_field[i] = view_of(cloud.fields()[std::size_t(i)], cloud.min());
    }
    in.extinction = cloud.extinction_per_m();
    in.beam_scale = 1.0F / cloud.eye_extinction();
    in.riemann = cloud.riemann();
    return march_scene(scene, in, camera, settings);
}

} // namespace alpenglow::clouds
#endif
