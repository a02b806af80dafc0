#include "horizon.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>

#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace alpenglow::sandbox {
namespace {

// A point of a profile: distance along the azimuth and height.
struct Point {
    float s;
    float h;
};

// The upper convex hull of all points pushed so far, each nearer than the one before. The storage has room for all.
class Hull {
public:
    explicit Hull(Point* storage, std::size_t size = 0) : points_(storage), size_(size) {}

    // Adds a point.
    void push(Point p) {
        while (size_ >= 2 && below(points_[size_ - 1], p, points_[size_ - 2])) {
            --size_;
        }
        points_[size_++] = p;
    }
    // The largest tangent from the last point to any before; negative for the first.
    [[nodiscard]] float tangent() const {
        if (size_ < 2) {
            return -1e30F;
        }
        const Point p = points_[size_ - 1];
        const Point top = points_[size_ - 2];
        return (top.h - p.h) / (top.s - p.s);
    }
    [[nodiscard]] std::size_t size() const { return size_; }

private:
    // Is `middle` on or under the segment from `near` to `far`?
    static bool below(Point middle, Point near, Point far) {
        return (middle.h - near.h) * (far.s - near.s) <= (far.h - near.h) * (middle.s - near.s);
    }
    Point* points_;
    std::size_t size_;
};

// A line of the grid: from sample coordinates along `major` one step at a time, moving p/q across at each.
struct Frame {
    bool swapped; // true: the major axis is y
    int sign;     // of the major step, towards the horizon
    int p;        // q times the minor step for a major step of +1 (signed)
    int q;
};

Frame frame_of(int azimuth) {
    const glm::ivec2 d = horizon_direction(azimuth);
    const bool swapped = std::abs(d.y) > std::abs(d.x);
    const int major = swapped ? d.y : d.x;
    const int minor = swapped ? d.x : d.y;
    const int sign = major > 0 ? 1 : -1;
    return {swapped, sign, minor * sign, std::abs(major)};
}

int floor_div(int a, int b) {
    const int q = a / b;
    return a % b != 0 && (a < 0) != (b < 0) ? q - 1 : q;
}

// Hulls of what `beyond` holds outside of `grid`, on parallel lines across the azimuth.
struct FarHulls {
    float first_m = 0.0F; // across-position of line 0
    float step_m = 1.0F;
    std::vector<std::vector<Point>> lines;
};

FarHulls far_hulls(const HeightGrid& grid, const HeightGrid& beyond, glm::vec2 along) {
    const glm::vec2 across(-along.y, along.x);
    const float half = 0.5F * grid.extent_m();
    const float half_far = 0.5F * beyond.extent_m();
    const float step_m = beyond.spacing_m / std::max(std::abs(along.x), std::abs(along.y));
    FarHulls hulls;
    hulls.step_m = beyond.spacing_m;
    const int count = 2 * static_cast<int>(std::ceil(1.42F * half / hulls.step_m)) + 1;
    hulls.first_m = -hulls.step_m * static_cast<float>(count / 2);
    hulls.lines.resize(static_cast<std::size_t>(count));
    parallel_for(static_cast<std::size_t>(count), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line) {
            const float offset = hulls.first_m + hulls.step_m * static_cast<float>(line);
            // Steps that meet the samples where the azimuth does.
            const int steps = static_cast<int>(1.42F * half_far / step_m);
            std::vector<Point>& points = hulls.lines[line];
            points.resize(static_cast<std::size_t>(std::max(steps, 0)));
            Hull hull(points.data());
            for (int k = steps; k > 0; --k) {
                const float s = step_m * static_cast<float>(k);
                const glm::vec2 p = s * along + offset * across;
                const float reach = std::max(std::abs(p.x), std::abs(p.y));
                if (reach <= half) {
                    break;
                }
                if (reach <= half_far) {
                    hull.push({s, sample_bilinear(beyond, p)});
                }
            }
            points.resize(hull.size());
        }
    });
    return hulls;
}

} // namespace

namespace {

// The encoding as a table: the least tangent of each code, and the code of the least tangent that shares the upper half
// of its bits with others.
struct Encoder {
    static constexpr std::uint32_t infinity = 0x7F80U;
    std::array<float, 257> least{};
    std::array<std::uint8_t, infinity + 1> start{};

    Encoder() {
        for (int v = 1; v < 256; ++v) {
            const double x = (v - 0.5) / 255.0;
            least[static_cast<std::size_t>(v)] = static_cast<float>(std::tan(0.5 * pi * x * x));
        }
        least[256] = std::numeric_limits<float>::infinity();
        std::size_t v = 0;
        for (std::uint32_t upper = 0; upper < infinity; ++upper) {
            while (least[v + 1] <= std::bit_cast<float>(upper << 16U)) {
                ++v;
            }
            start[upper] = static_cast<std::uint8_t>(v);
        }
        start[infinity] = 255;
    }
    [[nodiscard]] std::uint8_t encode(float tangent) const {
        std::size_t v = start[std::bit_cast<std::uint32_t>(tangent) >> 16U];
        while (v < 255 && least[v + 1] <= tangent) {
            ++v;
        }
        return static_cast<std::uint8_t>(v);
    }
};

} // namespace

std::uint8_t encode_horizon(float tangent) noexcept {
    static const Encoder encoder;
    return tangent > 0.0F ? encoder.encode(tangent) : std::uint8_t{0};
}

float decode_horizon_rad(std::uint8_t v) noexcept {
    const float x = static_cast<float>(v) / 255.0F;
    return static_cast<float>(0.5 * pi) * x * x;
}

std::array<std::uint32_t, 4> pack_horizon(const HorizonBytes& bytes) noexcept {
    std::array<std::uint32_t, 4> words{};
    for (std::size_t k = 0; k < bytes.size(); ++k) {
        words[k / 4] |= static_cast<std::uint32_t>(bytes[k]) << (8U * (k % 4U));
    }
    return words;
}

glm::ivec2 horizon_direction(int azimuth) noexcept {
    // North through east: (east, north).
    static constexpr int x[horizon_azimuths] = {0, 2, 1, 5, 1, 5, 1, 2, 0, -2, -1, -5, -1, -5, -1, -2};
    static constexpr int y[horizon_azimuths] = {1, 5, 1, 2, 0, -2, -1, -5, -1, -5, -1, -2, 0, 2, 1, 5};
    return {x[azimuth], y[azimuth]};
}

std::vector<float> sweep_horizon(const HeightGrid& grid, int azimuth, const HeightGrid* beyond) {
    assert(azimuth >= 0 && azimuth < horizon_azimuths);
    const Frame f = frame_of(azimuth);
    const int n = grid.n;
    std::vector<float> tangents(grid.height_m.size(), 0.0F);

    // Lines are numbered by c = q minor - p major, the same for all samples of a line; between samples c / q is where
    // the line crosses the column.
    const int c_low = -std::max(0, f.p) * (n - 1);
    const int c_high = f.q * (n - 1) + std::max(0, -f.p) * (n - 1);
    const float slope = static_cast<float>(f.p) / static_cast<float>(f.q);
    const float step_m = grid.spacing_m * std::sqrt(1.0F + slope * slope);
    const glm::vec2 along = f.swapped ? glm::vec2(slope, 1.0F) : glm::vec2(1.0F, slope);
    const glm::vec2 unit = along * (static_cast<float>(f.sign) / std::sqrt(1.0F + slope * slope));
    FarHulls far;
    if (beyond != nullptr) {
        far = far_hulls(grid, *beyond, unit);
    }
    const std::size_t major_stride = f.swapped ? static_cast<std::size_t>(n) : 1U;
    const std::size_t minor_stride = f.swapped ? 1U : static_cast<std::size_t>(n);
    const float* height = grid.height_m.data();

    parallel_for(static_cast<std::size_t>(c_high - c_low + 1), 512, [&](std::size_t begin, std::size_t end) {
        std::vector<Point> storage;
        std::size_t far_most = 0;
        for (const std::vector<Point>& points : far.lines) {
            far_most = std::max(far_most, points.size());
        }
        storage.resize(static_cast<std::size_t>(n) + far_most);
        for (std::size_t line = begin; line < end; ++line) {
            const int c = c_low + static_cast<int>(line);
            // Columns where 0 <= (c + p major) / q <= n - 1.
            int first = 0;
            int last = n - 1;
            if (f.p > 0) {
                first = std::max(first, floor_div(-c + f.p - 1, f.p));
                last = std::min(last, floor_div(f.q * (n - 1) - c, f.p));
            } else if (f.p < 0) {
                first = std::max(first, floor_div(c - f.q * (n - 1) - f.p - 1, -f.p));
                last = std::min(last, floor_div(c, -f.p));
            }
            if (first > last) {
                continue;
            }
            std::size_t beyond_count = 0;
            const float sign = static_cast<float>(f.sign);
            if (beyond != nullptr) {
                const float major_m = grid.origin_m.x + grid.spacing_m * static_cast<float>(first);
                const float minor_m =
                    grid.origin_m.x + grid.spacing_m * static_cast<float>(c + f.p * first) / static_cast<float>(f.q);
                const glm::vec2 p = f.swapped ? glm::vec2(minor_m, major_m) : glm::vec2(major_m, minor_m);
                const float offset = -unit.y * p.x + unit.x * p.y;
                const int near = std::clamp(static_cast<int>(std::lround((offset - far.first_m) / far.step_m)), 0,
                                            static_cast<int>(far.lines.size()) - 1);
                // The far hull measures from the centre; this line measures steps along itself.
                const float zero = (unit.x * p.x + unit.y * p.y) - sign * step_m * static_cast<float>(first);
                const float farthest = sign * step_m * static_cast<float>(f.sign > 0 ? last : first);
                for (const Point point : far.lines[static_cast<std::size_t>(near)]) {
                    if (point.s - zero > farthest) { // a far line may pass beside a corner
                        storage[beyond_count++] = {point.s - zero, point.h};
                    }
                }
            }
            Hull hull(storage.data(), beyond_count);
            const int from = f.sign > 0 ? last : first;
            const int count = last - first + 1;
            int numerator = c + f.p * from;
            int minor = floor_div(numerator, f.q);
            int rest = numerator - minor * f.q;
            const int advance = -f.sign * f.p; // per step back from the horizon
            for (int k = 0; k < count; ++k) {
                const int major = from - f.sign * k;
                const std::size_t at =
                    static_cast<std::size_t>(major) * major_stride + static_cast<std::size_t>(minor) * minor_stride;
                const float s = sign * step_m * static_cast<float>(major);
                if (rest == 0) {
                    hull.push({s, height[at]});
                    tangents[at] = std::max(0.0F, hull.tangent());
                } else {
                    const float t = static_cast<float>(rest) / static_cast<float>(f.q);
                    hull.push({s, height[at] + t * (height[at + minor_stride] - height[at])});
                }
                rest += advance;
                while (rest < 0) {
                    rest += f.q;
                    --minor;
                }
                while (rest >= f.q) {
                    rest -= f.q;
                    ++minor;
                }
            }
        }
    });
    return tangents;
}

std::vector<HorizonBytes> compute_horizons(const HeightGrid& grid, const HeightGrid* beyond) {
    std::vector<HorizonBytes> bytes(grid.height_m.size());
    for (int azimuth = 0; azimuth < horizon_azimuths; ++azimuth) {
        const std::vector<float> tangents = sweep_horizon(grid, azimuth, beyond);
        parallel_for(tangents.size(), 1U << 15U, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                bytes[i][static_cast<std::size_t>(azimuth)] = encode_horizon(tangents[i]);
            }
        });
    }
    return bytes;
}

float walk_horizon(const HeightGrid& grid, int i, int j, int azimuth) {
    const Frame f = frame_of(azimuth);
    const float slope = static_cast<float>(f.p) / static_cast<float>(f.q);
    const float step_m = grid.spacing_m * std::sqrt(1.0F + slope * slope);
    const int major0 = f.swapped ? j : i;
    const int minor0 = f.swapped ? i : j;
    const float h0 = grid.at(i, j);
    float best = 0.0F;
    for (int k = 1;; ++k) {
        const int major = major0 + f.sign * k;
        const int numerator = f.q * minor0 + f.sign * k * f.p;
        if (major < 0 || major >= grid.n || numerator < 0 || numerator > f.q * (grid.n - 1)) {
            return best;
        }
        const int minor = numerator / f.q;
        const int next = std::min(minor + 1, grid.n - 1);
        const float t = static_cast<float>(numerator - minor * f.q) / static_cast<float>(f.q);
        const float a = f.swapped ? grid.at(minor, major) : grid.at(major, minor);
        const float b = f.swapped ? grid.at(next, major) : grid.at(major, next);
        best = std::max(best, (a + t * (b - a) - h0) / (step_m * static_cast<float>(k)));
    }
}

float sky_visibility(const HorizonBytes& bytes) noexcept {
    float sum = 0.0F;
    for (const std::uint8_t v : bytes) {
        const float c = std::cos(decode_horizon_rad(v));
        sum += c * c;
    }
    return sum / static_cast<float>(horizon_azimuths);
}

} // namespace alpenglow::sandbox
