#include <alpenglow/clouds/compact.hpp>

#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace alpenglow::clouds {
namespace {

constexpr int side = 9;
constexpr int max_bits = 12; // two values and 7 bits of misalignment fit into 32
constexpr float peak = 4.0F; // errors that a single value may be off by where lines stand for it
constexpr float any_error = std::numeric_limits<float>::infinity();

using Values = std::array<float, CompactField::brick_values>;

std::size_t place(int x, int y, int z) {
    return std::size_t((z * side + y) * side + x);
}

// What the numbers kept stand for: themselves plus a plane, or the square.
enum class Coding { plane, square };

// Where a brick's values are kept, and how.
struct Layout {
    glm::ivec3 low{0};
    glm::ivec3 steps{8}; // to the high corner
    int shift = 0;       // log2 of the step
    int bits = 0;
    float offset = 0.0F;
    float scale = 0.0F;

    [[nodiscard]] glm::ivec3 dims() const { return steps + 1; }
    [[nodiscard]] std::size_t bytes() const {
        const glm::ivec3 n = dims();
        return (std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z) * std::size_t(bits) + 7) / 8;
    }
    [[nodiscard]] std::uint32_t code() const {
        std::uint32_t out = 0;
        for (int a = 0; a < 3; ++a) {
            out |= static_cast<std::uint32_t>(low[a]) << (4 * a);
            out |= static_cast<std::uint32_t>(steps[a]) << (12 + 4 * a);
        }
        return out | static_cast<std::uint32_t>(bits) << 24 | static_cast<std::uint32_t>(shift) << 28;
    }
    [[nodiscard]] std::uint32_t quantised(float value) const {
        const auto most = static_cast<float>((1 << bits) - 1);
        return scale > 0.0F ? static_cast<std::uint32_t>(std::clamp((value - offset) / scale + 0.5F, 0.0F, most)) : 0U;
    }
    // Calls visit(place) for every node, x fastest.
    template <class Visit>
    void for_nodes(const Visit& visit) const {
        for (int z = 0; z <= steps.z; ++z) {
            for (int y = 0; y <= steps.y; ++y) {
                for (int x = 0; x <= steps.x; ++x) {
                    visit(place(low.x + (x << shift), low.y + (y << shift), low.z + (z << shift)));
                }
            }
        }
    }
};

float lerp(float a, float b, float t) {
    return a + t * (b - a);
}

// Trilinear in a dense grid of nodes at `p`, in nodes.
template <class Node>
float trilinear(const Node& node, const glm::ivec3& dims, const glm::vec3& p) {
    glm::ivec3 i;
    glm::ivec3 next;
    glm::vec3 t;
    for (int a = 0; a < 3; ++a) {
        i[a] = static_cast<int>(p[a]);
        t[a] = p[a] - static_cast<float>(i[a]);
        next[a] = std::min(i[a] + 1, dims[a] - 1);
    }
    const auto row = [&](int y, int z) { return lerp(node(i.x, y, z), node(next.x, y, z), t.x); };
    return lerp(lerp(row(i.y, i.z), row(next.y, i.z), t.y), lerp(row(i.y, next.z), row(next.y, next.z), t.y), t.z);
}

// A brick to be packed. Codes: the numbers to be kept, of values that may be off by `errors`.
struct Cells {
    Coding coding;
    const Values& values;
    const Values& errors;
    Values codes;
    float strictest = any_error; // what a code may be off by, so that no value is off by more than its error

    Cells(Coding how, const Values& v, const Values& e, const glm::vec3& slope) : coding(how), values(v), errors(e) {
        for (std::size_t i = 0; i < v.size(); ++i) {
            if (how == Coding::square) {
                codes[i] = std::sqrt(v[i]);
                // (c + d)^2 - c^2 = 2 c d + d^2 <= e
                if (e[i] > 0.0F && e[i] < any_error) {
                    strictest = std::min(strictest, std::sqrt(v[i] + e[i]) - codes[i]);
                }
            } else {
                const auto x = static_cast<float>(i % side);
                const auto y = static_cast<float>(i / side % side);
                const auto z = static_cast<float>(i / side / side);
                codes[i] = v[i] - (slope.x * x + slope.y * y + slope.z * z);
                if (e[i] > 0.0F) {
                    strictest = std::min(strictest, e[i]);
                }
            }
        }
    }
    [[nodiscard]] float decoded(float code) const { return coding == Coding::square ? code * code : code; }
};

// Sets offset, scale and bits for the layout's nodes, so that no code is off by more than `error`.
void quantise(Layout& layout, const Cells& cells, bool cared_only, float error) {
    float low = any_error;
    float high = -any_error;
    layout.for_nodes([&](std::size_t i) {
        if (!cared_only || cells.errors[i] < any_error) {
            low = std::min(low, cells.codes[i]);
            high = std::max(high, cells.codes[i]);
        }
    });
    layout.bits = 0;
    layout.scale = 0.0F;
    const bool zeros = cells.coding == Coding::square && low == 0.0F; // they stay zeros
    if (!(low < high)) {                                              // one value, or none
        layout.offset = low < any_error ? low : 0.0F;
    } else if (!zeros && high - low <= 2.0F * error) {
        layout.offset = 0.5F * (low + high);
    } else {
        const float levels = error > 0.0F ? (high - low) / (2.0F * error) : any_error;
        layout.bits = 1;
        while (layout.bits < max_bits && static_cast<float>((1 << layout.bits) - 1) < levels) {
            ++layout.bits;
        }
        layout.offset = low;
        layout.scale = (high - low) / static_cast<float>((1 << layout.bits) - 1);
    }
}

// The part of the errors that lines between the layout's nodes leave over, in the mean of squares; negative: they do
// not do, by that or because one cell is off by more than `peak` errors.
float left_over(const Layout& layout, const Cells& cells) {
    const auto node = [&](int x, int y, int z) {
        return cells.decoded(cells.codes[place(layout.low.x + (x << layout.shift), layout.low.y + (y << layout.shift),
                                               layout.low.z + (z << layout.shift))]);
    };
    const float inverse = 1.0F / static_cast<float>(1 << layout.shift);
    float squares = 0.0F;
    float count = 0.0F;
    for (int z = 0; z < side; ++z) {
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                const std::size_t i = place(x, y, z);
                const float error = cells.errors[i];
                if (!(error < any_error)) {
                    continue;
                }
                const glm::vec3 p = glm::vec3(x, y, z) * inverse;
                const float off = std::abs(trilinear(node, layout.dims(), p) - cells.decoded(cells.codes[i]));
                if (error == 0.0F ? off > 0.0F : off > (peak - 1.0F) * error) {
                    return -1.0F;
                }
                if (error > 0.0F) {
                    squares += (off / error) * (off / error);
                    count += 1.0F;
                }
            }
        }
    }
    // A quantised value is off by a third of the square of half its step in the mean.
    const float left = 1.0F - 3.0F * squares / std::max(count, 1.0F);
    return left < 0.1F ? -1.0F : std::sqrt(left);
}

// The plane through the values that may not be off by any amount, by least squares: its slope in each cell's step.
glm::vec3 slope_of(const Values& values, const Values& errors) {
    double n = 0.0;
    glm::dvec3 mean(0.0);
    double mean_value = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (errors[i] < any_error) {
            n += 1.0;
            mean += glm::dvec3(double(i % side), double(i / side % side), double(i / side / side));
            mean_value += double(values[i]);
        }
    }
    mean /= n;
    mean_value /= n;
    double m[3][3] = {};
    glm::dvec3 b(0.0);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (errors[i] < any_error) {
            const glm::dvec3 d = glm::dvec3(double(i % side), double(i / side % side), double(i / side / side)) - mean;
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c) {
                    m[r][c] += d[r] * d[c];
                }
                b[r] += d[r] * (double(values[i]) - mean_value);
            }
        }
    }
    for (int r = 0; r < 3; ++r) {
        m[r][r] += 1.0; // of few cells, or cells in a plane: no slope where they say nothing
    }
    // Gauss, without pivots: the matrix is positive definite.
    for (int r = 0; r < 3; ++r) {
        for (int s = r + 1; s < 3; ++s) {
            const double f = m[s][r] / m[r][r];
            for (int c = r; c < 3; ++c) {
                m[s][c] -= f * m[r][c];
            }
            b[s] -= f * b[r];
        }
    }
    glm::dvec3 out(0.0);
    for (int r = 2; r >= 0; --r) {
        double sum = b[r];
        for (int c = r + 1; c < 3; ++c) {
            sum -= m[r][c] * out[c];
        }
        out[r] = sum / m[r][r];
    }
    return glm::vec3(out);
}

// A slope in 32 bits: three signed mantissas of 9 bits times 2^(e - 24) with one exponent e of 5 bits.
std::uint32_t encode_slope(const glm::vec3& slope) {
    const float most = std::max({std::abs(slope.x), std::abs(slope.y), std::abs(slope.z)});
    int e = 0;
    while (e < 31 && most > 255.0F * std::ldexp(1.0F, e - 24)) {
        ++e;
    }
    std::uint32_t out = static_cast<std::uint32_t>(e) << 27;
    for (int a = 0; a < 3; ++a) {
        const float mantissa = std::clamp(std::round(std::ldexp(slope[a], 24 - e)), -255.0F, 255.0F);
        out |= (static_cast<std::uint32_t>(static_cast<std::int32_t>(mantissa)) & 511U) << (9 * a);
    }
    return out;
}

glm::vec3 decode_slope(std::uint32_t code) {
    const float unit = std::ldexp(1.0F, static_cast<int>(code >> 27) - 24);
    glm::vec3 out;
    for (int a = 0; a < 3; ++a) {
        out[a] = unit * static_cast<float>(static_cast<std::int32_t>(code << (23 - 9 * a)) >> 23);
    }
    return out;
}

// The box beyond which the brick repeats its border.
Layout trimmed(const Cells& cells) {
    const Values& errors = cells.errors;
    Layout out;
    glm::ivec3 high(8);
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        // Whether the cells of layer `from` may be replaced by those of layer `to`.
        const auto repeats = [&](int from, int to) {
            glm::ivec3 c;
            for (c[v] = out.low[v]; c[v] <= high[v]; ++c[v]) {
                for (c[u] = out.low[u]; c[u] <= high[u]; ++c[u]) {
                    c[axis] = from;
                    const std::size_t i = place(c.x, c.y, c.z);
                    c[axis] = to;
                    const std::size_t j = place(c.x, c.y, c.z);
                    if (errors[i] < any_error && !(errors[j] < any_error && cells.codes[i] == cells.codes[j])) {
                        return false;
                    }
                }
            }
            return true;
        };
        const auto all = [&](int begin, int end, int to) {
            for (int from = begin; from < end; ++from) {
                if (!repeats(from, to)) {
                    return false;
                }
            }
            return true;
        };
        while (out.low[axis] < 8 && all(0, out.low[axis] + 1, out.low[axis] + 1)) {
            ++out.low[axis];
        }
        while (high[axis] > out.low[axis] && all(high[axis], 9, high[axis] - 1)) {
            --high[axis];
        }
    }
    out.steps = high - out.low;
    return out;
}

Layout smallest(const Cells& cells) {
    Layout out = trimmed(cells);
    quantise(out, cells, true, cells.strictest);
    for (int shift = 1; shift <= 3 && out.bits > 0; ++shift) {
        Layout thin;
        thin.shift = shift;
        thin.steps = glm::ivec3(8 >> shift);
        const float left = left_over(thin, cells);
        if (left < 0.0F) {
            break; // fewer nodes do worse
        }
        quantise(thin, cells, false, left * cells.strictest);
        if (thin.bytes() < out.bytes()) {
            out = thin;
        }
    }
    return out;
}

struct Packed {
    bool needed = false;
    Layout layout;
    std::uint32_t slope = 0;
    std::vector<std::uint8_t> data;
};

Packed pack(Coding coding, const Values& values, const Values& errors) {
    Packed out;
    out.needed = true;
    Cells cells(coding, values, errors, glm::vec3(0.0F));
    out.layout = smallest(cells);
    if (coding == Coding::plane && out.layout.bits > 0) {
        const std::uint32_t slope = encode_slope(slope_of(values, errors));
        const Cells sloped(coding, values, errors, decode_slope(slope));
        const Layout with_slope = smallest(sloped);
        if (with_slope.bytes() < out.layout.bytes()) {
            out.layout = with_slope;
            out.slope = slope;
            cells.codes = sloped.codes;
        }
    }
    const Layout& layout = out.layout;
    out.data.assign(layout.bytes() + 4, 0);
    std::size_t bit = 0;
    layout.for_nodes([&](std::size_t i) {
        const std::uint32_t code = layout.quantised(cells.codes[i]) << (bit & 7);
        for (std::size_t byte = 0; byte < 3; ++byte) {
            out.data[bit / 8 + byte] |= static_cast<std::uint8_t>(code >> (8 * byte));
        }
        bit += std::size_t(layout.bits);
    });
    out.data.resize(layout.bytes());
    return out;
}

// Which cells of a lattice a sample with matter around it can read: those with matter, and their neighbours.
std::vector<std::uint8_t> cells_in_use(const BrickVolume& volume, const Lattice& lattice) {
    const std::vector<float> density = volume.block_means(lattice.first, lattice.dims, lattice.factor);
    std::vector<std::uint8_t> used(density.size());
    for (std::size_t i = 0; i < density.size(); ++i) {
        used[i] = density[i] > 0.0F ? 1 : 0;
    }
    const std::size_t strides[3] = {1, std::size_t(lattice.dims.x),
                                    std::size_t(lattice.dims.x) * std::size_t(lattice.dims.y)};
    std::vector<std::uint8_t> grown(used.size());
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t stride = strides[axis];
        const auto length = static_cast<std::size_t>(lattice.dims[axis]);
        for (std::size_t i = 0; i < used.size(); ++i) {
            const std::size_t c = i / stride % length;
            grown[i] = static_cast<std::uint8_t>(used[i] | (c > 0 ? used[i - stride] : 0) |
                                                 (c + 1 < length ? used[i + stride] : 0));
        }
        used.swap(grown);
    }
    return used;
}

// error(value): what a cell's value may be off by.
template <class ErrorOf>
CompactField compact(const Field16& field, const std::vector<std::uint8_t>& used, const ErrorOf& error) {
    const Lattice& l = field.lattice;
    const glm::vec3 origin = glm::vec3(l.first) + 0.5F * static_cast<float>(l.factor - 1);
    const auto fill = [&](const glm::ivec3& brick, float* values, float* errors) {
        bool any = false;
        for (int i = 0; i < CompactField::brick_values; ++i) {
            const glm::ivec3 c = brick * 8 + glm::ivec3(i % side, i / side % side, i / side / side);
            const bool inside = c.x < l.dims.x && c.y < l.dims.y && c.z < l.dims.z;
            const glm::ivec3 at(std::min(c.x, l.dims.x - 1), std::min(c.y, l.dims.y - 1), std::min(c.z, l.dims.z - 1));
            const std::size_t cell =
                (std::size_t(at.z) * std::size_t(l.dims.y) + std::size_t(at.y)) * std::size_t(l.dims.x) +
                std::size_t(at.x);
            values[i] = field.offset + field.scale * static_cast<float>(field.values[cell]);
            const bool cared = inside && used[cell] != 0;
            errors[i] = any_error;
            if (cared) {
                errors[i] = error(values[i]);
            }
            any = any || cared;
        }
        return any;
    };
    return {origin, l.factor, (l.dims + 7) / 8, false, fill};
}

} // namespace

CompactField::CompactField(const glm::vec3& origin, int factor, const glm::ivec3& extent, bool squared,
                           const Fill& fill, const BrickTable* where)
    : origin_(origin), factor_(factor), squared_(squared), bricks_in_(extent) {
    nodes_ = (extent + 7) / 8;
    node_.resize(std::size_t(nodes_.x) * std::size_t(nodes_.y) * std::size_t(nodes_.z));
    constexpr std::size_t node_bricks = 512;
    std::vector<Packed> packed(node_bricks);
    assert(where == nullptr || where->bricks() == extent);
    for (std::size_t n = 0; n < node_.size(); ++n) {
        if (where != nullptr && where->node_table()[n] < 0) {
            continue;
        }
        const glm::ivec3 corner(static_cast<int>(n % std::size_t(nodes_.x)),
                                static_cast<int>(n / std::size_t(nodes_.x) % std::size_t(nodes_.y)),
                                static_cast<int>(n / (std::size_t(nodes_.x) * std::size_t(nodes_.y))));
        parallel_for(node_bricks, 16, [&](std::size_t begin, std::size_t end) {
            Values values;
            Values errors;
            for (std::size_t i = begin; i < end; ++i) {
                const auto place = static_cast<int>(i);
                const glm::ivec3 c = corner * 8 + glm::ivec3(place & 7, place >> 3 & 7, place >> 6);
                const bool inside = c.x < extent.x && c.y < extent.y && c.z < extent.z;
                packed[i] = inside && fill(c, values.data(), errors.data())
                                ? pack(squared ? Coding::square : Coding::plane, values, errors)
                                : Packed{};
            }
        });
        if (std::none_of(packed.begin(), packed.end(), [](const Packed& p) { return p.needed; })) {
            continue;
        }
        node_[n] = {static_cast<std::int32_t>(bricks_.size()), static_cast<std::int32_t>(entry_.size())};
        for (const Packed& p : packed) {
            const std::size_t within = bricks_.size() - std::size_t(node_[n].first);
            entry_.push_back(static_cast<std::uint16_t>(p.needed ? within : node_bricks));
            if (p.needed) {
                if (!squared) {
                    slopes_.push_back(p.slope);
                }
                bricks_.push_back(
                    {static_cast<std::uint32_t>(data_.size()), p.layout.code(), p.layout.offset, p.layout.scale});
                data_.insert(data_.end(), p.data.begin(), p.data.end());
            }
        }
    }
    assert(data_.size() < (std::size_t(1) << 31));
    // A trimmed brick's rows are read one past their end, with weight 0.
    data_.resize(data_.size() + 160, 0);
    data_.shrink_to_fit();
    bricks_.shrink_to_fit();
    slopes_.shrink_to_fit();
    entry_.resize(entry_.size() + 2, node_bricks); // room for 32-bit reads
    entry_.shrink_to_fit();
}

float CompactField::sample(const glm::vec3& index) const {
    glm::vec3 p = (index - origin_) / static_cast<float>(factor_);
    glm::ivec3 brick;
    for (int a = 0; a < 3; ++a) {
        p[a] = std::clamp(p[a], 0.0F, static_cast<float>(8 * bricks_in_[a]) - 1e-3F);
        brick[a] = static_cast<int>(p[a]) >> 3;
        p[a] -= static_cast<float>(8 * brick[a]);
    }
    const Node& node =
        node_[(std::size_t(brick.z >> 3) * std::size_t(nodes_.y) + std::size_t(brick.y >> 3)) * std::size_t(nodes_.x) +
              std::size_t(brick.x >> 3)];
    if (node.first < 0) {
        return 0.0F;
    }
    const std::uint16_t within =
        entry_[std::size_t(node.entries + ((brick.z & 7) * 8 + (brick.y & 7)) * 8 + (brick.x & 7))];
    if (within == 512) {
        return 0.0F;
    }
    const std::int32_t number = node.first + within;
    const Brick& b = bricks_[std::size_t(number)];
    float plane = 0.0F;
    if (!squared_) {
        const glm::vec3 slope = decode_slope(slopes_[std::size_t(number)]);
        plane = slope.x * p.x + slope.y * p.y + slope.z * p.z;
    }
    glm::ivec3 dims;
    for (int a = 0; a < 3; ++a) {
        const auto low = static_cast<float>((b.box >> (4 * a)) & 15U);
        const auto steps = static_cast<int>((b.box >> (12 + 4 * a)) & 15U);
        const float inverse = 1.0F / static_cast<float>(1U << (b.box >> 28));
        p[a] = std::clamp((p[a] - low) * inverse, 0.0F, static_cast<float>(steps));
        dims[a] = steps + 1;
    }
    const std::size_t bits = (b.box >> 24) & 15U;
    const auto node_value = [&](int x, int y, int z) {
        const std::size_t at =
            bits * ((std::size_t(z) * std::size_t(dims.y) + std::size_t(y)) * std::size_t(dims.x) + std::size_t(x));
        const std::uint8_t* bytes = data_.data() + b.at + at / 8;
        const std::uint32_t word = bytes[0] | std::uint32_t(bytes[1]) << 8 | std::uint32_t(bytes[2]) << 16;
        const float code = b.offset + b.scale * static_cast<float>((word >> (at & 7)) & ((1U << bits) - 1U));
        return squared_ ? code * code : code;
    };
    return plane + trilinear(node_value, dims, p);
}

std::size_t CompactField::memory_bytes() const {
    return node_.size() * sizeof(Node) + entry_.size() * sizeof(std::uint16_t) + bricks_.size() * sizeof(Brick) +
           slopes_.size() * sizeof(std::uint32_t) + data_.size();
}

CompactTable::CompactTable(const BeamTable& table)
    : decay_(table.decay()), max_depth_(table.max_depth()), narrow_(table.narrow()) {
    constexpr std::size_t row = BeamTable::depths;
    for (std::size_t a = 0; a < std::size_t(BeamTable::angles); ++a) {
        const float* from = table.values().data() + a * row;
        const auto [low, high] = std::minmax_element(from, from + row);
        const float scale = (*high - *low) / 65535.0F;
        for (std::size_t d = 0; d < row; ++d) {
            const float code = scale > 0.0F ? (from[d] - *low) / scale + 0.5F : 0.0F;
            values_.push_back(static_cast<std::uint16_t>(std::clamp(code, 0.0F, 65535.0F)));
        }
        rows_.push_back(*low);
        rows_.push_back(scale);
    }
    values_.resize(values_.size() + 2, 0);
    values_.shrink_to_fit();
    rows_.shrink_to_fit();
}

float CompactTable::value(float depth, float one_minus_cos) const {
    const float a = BeamTable::angle_coordinate(one_minus_cos, narrow_);
    const int ia = std::min(static_cast<int>(a), BeamTable::angles - 2);
    const float u =
        std::min(std::sqrt(std::max(depth, 0.0F) / max_depth_), 1.0F) * static_cast<float>(BeamTable::depths - 1);
    const int iu = std::min(static_cast<int>(u), BeamTable::depths - 2);
    const float tu = u - static_cast<float>(iu);
    const auto row = [&](std::size_t angle) {
        const std::uint16_t* from = values_.data() + angle * BeamTable::depths + std::size_t(iu);
        return rows_[2 * angle] +
               rows_[2 * angle + 1] * lerp(static_cast<float>(from[0]), static_cast<float>(from[1]), tu);
    };
    return std::exp(-decay_ * depth) * lerp(row(std::size_t(ia)), row(std::size_t(ia) + 1), a - static_cast<float>(ia));
}

std::size_t CompactTable::memory_bytes() const {
    return values_.size() * sizeof(std::uint16_t) + rows_.size() * sizeof(float);
}

CompactCloud::CompactCloud(const BrickVolume& volume, const CloudLighting& lighting, const glm::dvec3& eye_m,
                           const CompactSettings& settings)
    : settings_(settings), transform_(volume.transform()), min_(volume.min()), active_low_(volume.active_low()),
      active_high_(volume.active_high()), max_density_(volume.max_density()) {
    if (volume.empty()) {
        return;
    }
    const float error = settings.density_error * std::sqrt(max_density_);
    density_ = CompactField(
        glm::vec3(min_), 1, volume.table().bricks(), true,
        [&](const glm::ivec3& c, float* values, float* errors) {
            const std::int32_t b = volume.table().find(c.x, c.y, c.z);
            if (b < 0) {
                return false;
            }
            const std::uint8_t* data = volume.data().data() + std::size_t(b) * BrickVolume::brick_stride;
            for (std::size_t i = 0; i < std::size_t(BrickVolume::brick_voxels); ++i) {
                values[i] =
                    volume.offsets()[std::size_t(b)] + volume.scales()[std::size_t(b)] * static_cast<float>(data[i]);
                errors[i] = error * std::sqrt(values[i]);
            }
            return true;
        },
        &volume.table());
    relight(volume, lighting, eye_m);
}

void CompactCloud::relight(const BrickVolume& volume, const CloudLighting& lighting, const glm::dvec3& eye_m) {
    table_ = CompactTable(lighting.table());
    eye_extinction_ = lighting.eye_extinction();
    extinction_per_m_ = lighting.medium().extinction_per_m * eye_extinction_;
    riemann_ = lighting.settings().method == LightingMethod::harris;
    lights_.clear();
    fields_.clear();
    if (volume.empty()) {
        return;
    }
    std::vector<std::uint8_t> used;
    Lattice of;
    const auto used_on = [&](const Lattice& lattice) -> const std::vector<std::uint8_t>& {
        if (used.empty() || !(of == lattice)) {
            used = cells_in_use(volume, lattice);
            of = lattice;
        }
        return used;
    };
    const float decay = table_.decay();
    for (const BakedLight& light : lighting.lights()) {
        const auto error = [&](float depth) {
            const float scaled = std::clamp(decay * depth, 0.0F, 24.0F);
            return settings_.depth_error * std::exp(0.75F * scaled);
        };
        lights_.push_back(
            {light.to_light, light.irradiance, compact(light.depth, used_on(light.depth.lattice), error)});
    }
    const CloudLighting::ViewFields view = lighting.contract(transform_.index_from_world(eye_m));
    colour_ = view.colour;
    for (const Field16& field : view.fields) {
        const float most = field.offset + 65535.0F * field.scale;
        const auto error = [&](float value) { return settings_.light_error * std::max(value, 0.05F * most); };
        fields_.push_back(compact(field, used_on(field.lattice), error));
    }
}

std::size_t CompactCloud::light_bytes() const {
    std::size_t bytes = table_.memory_bytes();
    for (const Light& light : lights_) {
        bytes += light.depth.memory_bytes();
    }
    for (const CompactField& field : fields_) {
        bytes += field.memory_bytes();
    }
    return bytes;
}

} // namespace alpenglow::clouds
