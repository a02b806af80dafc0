#include <alpenglow/sky/sky_fit.hpp>

#include "fit_normaliser.hpp"
#include "fit_simd.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>

namespace alpenglow::sky {
namespace {

constexpr std::size_t max_degree = 64;

double mapped(const FitAxis& axis, double x) {
    switch (axis.map) {
    case FitMap::half_tangent:
        return std::tan(0.5 * x);
    case FitMap::log_offset:
        return std::log(x - axis.offset);
    case FitMap::linear:
        break;
    }
    return x;
}

// The Chebyshev variable, held to -1 .. 1; NaN becomes -1.
double variable(const FitAxis& axis, double x) {
    const double held = x >= axis.low ? std::min(x, axis.high) : axis.low;
    const double low = mapped(axis, axis.low);
    const double high = mapped(axis, axis.high);
    return std::clamp((2.0 * mapped(axis, held) - low - high) / (high - low), -1.0, 1.0);
}

// Outside by how much, summed over axes, each by its length: 0 inside.
double outside(const SkyFitPart& part, std::span<const double> parameters) {
    double sum = 0.0;
    for (std::size_t a = 0; a < part.axes.size(); ++a) {
        const FitAxis& axis = part.axes[a];
        const double x = parameters[a];
        sum += x < axis.low ? (axis.low - x) : x > axis.high ? (x - axis.high) : 0.0;
    }
    return sum;
}

std::size_t row_count(const SkyFitPart& part) {
    return part.degrees.size() / part.axes.size();
}

class Writer {
public:
    template <class T>
    void put(T value) {
        std::uint8_t raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        bytes.insert(bytes.end(), raw, raw + sizeof(T));
    }
    std::vector<std::uint8_t> bytes;
};

class Reader {
public:
    explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    template <class T>
    [[nodiscard]] T take() {
        T value{};
        if (bytes_.size() < sizeof(T)) {
            short_ = true;
            return value;
        }
        std::memcpy(&value, bytes_.data(), sizeof(T));
        bytes_ = bytes_.subspan(sizeof(T));
        return value;
    }
    [[nodiscard]] bool ran_short() const { return short_; }
    [[nodiscard]] std::size_t left() const { return bytes_.size(); }

private:
    std::span<const std::uint8_t> bytes_;
    bool short_ = false;
};

// FNV-1a.
std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
    std::uint32_t hash = 2166136261U;
    for (const std::uint8_t byte : bytes) {
        hash = (hash ^ byte) * 16777619U;
    }
    return hash;
}

constexpr std::uint32_t magic = 0x46594b53U; // "SKYF"

} // namespace

static_assert(std::endian::native == std::endian::little, "fit tables are little-endian");

std::size_t SkyFit::bytes() const {
    std::size_t sum = 0;
    for (const SkyFitPart& part : parts) {
        sum +=
            part.degrees.size() + part.log_degrees.size() + sizeof(float) * (part.rows.size() + part.log_terms.size());
    }
    return sum;
}

std::vector<std::uint8_t> write_fit(const SkyFit& fit, FitStorage storage) {
    Writer body;
    body.put(static_cast<std::uint32_t>(fit.normaliser));
    body.put(static_cast<std::uint32_t>(fit.bands));
    body.put(static_cast<std::uint32_t>(fit.parts.size()));
    for (const SkyFitPart& part : fit.parts) {
        body.put(static_cast<std::uint32_t>(part.axes.size()));
        body.put(static_cast<std::uint32_t>(row_count(part)));
        body.put(static_cast<std::uint32_t>(part.log_terms.size()));
        for (const FitAxis& axis : part.axes) {
            body.put(static_cast<std::uint32_t>(axis.map));
            body.put(axis.low);
            body.put(axis.high);
            body.put(axis.offset);
        }
        for (const std::uint8_t d : part.degrees) {
            body.put(d);
        }
        for (const std::uint8_t d : part.log_degrees) {
            body.put(d);
        }
        if (storage == FitStorage::float32) {
            for (const float c : part.rows) {
                body.put(c);
            }
        } else {
            // Rows within a sixteenth of the largest stay whole: their rounding would show. A scale of 0 says so.
            const std::size_t n = fit.functions();
            const auto largest = [&](std::size_t first, std::size_t count) {
                float most = 1e-30F;
                for (std::size_t f = first; f < first + count; ++f) {
                    most = std::max(most, std::abs(part.rows[f]));
                }
                return most;
            };
            const float all = largest(0, part.rows.size());
            for (std::size_t r = 0; r < row_count(part); ++r) {
                const float most = largest(r * n, n);
                const float scale = most * 16.0F > all ? 0.0F : most / 32767.0F;
                body.put(scale);
                for (std::size_t f = 0; f < n; ++f) {
                    if (scale == 0.0F) {
                        body.put(part.rows[r * n + f]);
                    } else {
                        body.put(static_cast<std::int16_t>(std::lround(part.rows[r * n + f] / scale)));
                    }
                }
            }
        }
        for (const float c : part.log_terms) {
            body.put(c);
        }
    }
    while (body.bytes.size() % 4 != 0) {
        body.put(std::uint8_t{0});
    }
    Writer all;
    all.put(magic);
    all.put(static_cast<std::uint32_t>(storage));
    all.put(checksum(body.bytes));
    all.bytes.insert(all.bytes.end(), body.bytes.begin(), body.bytes.end());
    return all.bytes;
}

Result<SkyFit> read_fit(std::span<const std::uint8_t> bytes, const std::string& name) {
    const auto wrong = [&](const std::string& what, const std::string& expected) {
        return Error{what, name, expected};
    };
    Reader head(bytes);
    if (head.take<std::uint32_t>() != magic || head.ran_short()) {
        return wrong("this is no sky fit", "a file that begins with SKYF");
    }
    const auto found = head.take<std::uint32_t>();
    if (found != 1 && found != 2) {
        return wrong("format version is " + std::to_string(found), "1 or 2");
    }
    const bool whole = found == 1;
    const auto sum = head.take<std::uint32_t>();
    if (head.ran_short() || checksum(bytes.subspan(12)) != sum) {
        return wrong("the checksum does not match: the table is truncated or damaged", "the table as it was written");
    }
    Reader in(bytes.subspan(12));
    SkyFit fit;
    const auto normaliser = in.take<std::uint32_t>();
    fit.bands = static_cast<int>(in.take<std::uint32_t>());
    const auto parts = in.take<std::uint32_t>();
    if (normaliser > 2 || fit.bands < 1 || fit.bands > 7 || parts < 1 || parts > 64) {
        return wrong("bands are " + std::to_string(fit.bands) + ", parts " + std::to_string(parts),
                     "1 to 7 bands, 1 to 64 parts");
    }
    fit.normaliser = static_cast<FitNormaliser>(normaliser);
    for (std::uint32_t p = 0; p < parts; ++p) {
        SkyFitPart part;
        const auto axes = in.take<std::uint32_t>();
        const auto rows = in.take<std::uint32_t>();
        const auto terms = in.take<std::uint32_t>();
        if (axes < 1 || axes > max_fit_axes || rows < 1 || rows > 4094 || terms > 65536) {
            return wrong("axes are " + std::to_string(axes) + ", rows " + std::to_string(rows),
                         "1 to 4 axes, 1 to 4094 rows");
        }
        if (in.left() < axes * 28ULL +
                            rows * (axes + (whole ? 4ULL * fit.functions() : 4ULL + 2ULL * fit.functions())) +
                            terms * (axes + 4ULL)) {
            return wrong("the table ends early", "all of its rows");
        }
        for (std::uint32_t a = 0; a < axes; ++a) {
            FitAxis axis;
            axis.map = static_cast<FitMap>(in.take<std::uint32_t>());
            axis.low = in.take<double>();
            axis.high = in.take<double>();
            axis.offset = in.take<double>();
            const bool known = axis.map == FitMap::linear || axis.map == FitMap::half_tangent ||
                               (axis.map == FitMap::log_offset && axis.offset < axis.low);
            if (!known || !(axis.low < axis.high) || (a == 0 && axis.map != FitMap::half_tangent)) {
                return wrong("axis " + std::to_string(a) + " has no valid map or range",
                             "low < high, offset below low");
            }
            part.axes.push_back(axis);
        }
        for (std::uint32_t i = 0; i < rows * axes; ++i) {
            part.degrees.push_back(in.take<std::uint8_t>());
        }
        for (std::uint32_t i = 0; i < terms * axes; ++i) {
            part.log_degrees.push_back(in.take<std::uint8_t>());
        }
        for (std::uint32_t r = 0; r < rows; ++r) {
            const float scale = whole ? 1.0F : in.take<float>();
            for (std::size_t f = 0; f < fit.functions(); ++f) {
                part.rows.push_back(whole || scale == 0.0F ? in.take<float>()
                                                           : scale * static_cast<float>(in.take<std::int16_t>()));
            }
        }
        for (std::uint32_t i = 0; i < terms; ++i) {
            part.log_terms.push_back(in.take<float>());
        }
        for (std::uint32_t r = 0; r < rows; ++r) {
            for (std::uint32_t a = 0; a < axes; ++a) {
                if (part.degrees[r * axes + a] >= max_degree) {
                    return wrong("row " + std::to_string(r) + " has a degree over 63", "degrees 0 to 63");
                }
            }
            if (r > 0 && part.degrees[r * axes] < part.degrees[(r - 1) * axes]) {
                return wrong("rows are not sorted by the first degree", "ascending degrees");
            }
        }
        for (const std::uint8_t d : part.log_degrees) {
            if (d >= max_degree) {
                return wrong("a degree of the normaliser is over 63", "degrees 0 to 63");
            }
        }
        const auto finite = [](float x) { return std::isfinite(x); };
        if (!std::all_of(part.rows.begin(), part.rows.end(), finite) ||
            !std::all_of(part.log_terms.begin(), part.log_terms.end(), finite)) {
            return wrong("a coefficient is not finite", "finite numbers");
        }
        fit.parts.push_back(std::move(part));
    }
    if (in.ran_short()) {
        return wrong("the table ends early", "all of its rows");
    }
    if (in.left() >= 4) {
        return wrong(std::to_string(in.left()) + " bytes follow the table", "nothing");
    }
    return fit;
}

void evaluate_fit(const SkyFit& fit, std::span<const double> parameters, int bands, std::span<glm::dvec3> out) {
    assert(bands >= 1 && bands <= fit.bands && out.size() >= static_cast<std::size_t>(bands * bands));
    const auto best =
        std::min_element(fit.parts.begin(), fit.parts.end(), [&](const SkyFitPart& a, const SkyFitPart& b) {
            return outside(a, parameters) < outside(b, parameters);
        });
    const SkyFitPart& part = *best;
    const std::size_t axes = part.axes.size();
    assert(parameters.size() >= axes);
    std::array<std::array<double, max_degree + 2>, max_fit_axes> t{};
    for (std::size_t a = 0; a < axes; ++a) {
        chebyshev(variable(part.axes[a], parameters[a]), max_degree, t[a].data());
    }
    const auto product = [&](const std::vector<std::uint8_t>& degrees, std::size_t row) {
        double w = 1.0;
        for (std::size_t a = 0; a < axes; ++a) {
            w *= t[a][degrees[row * axes + a]];
        }
        return w;
    };
    double factor = 1.0;
    if (fit.normaliser == FitNormaliser::preetham) {
        const FitAxis& sun = part.axes[0];
        const FitAxis& haze = part.axes[1];
        const double theta = std::clamp(parameters[0], sun.low, sun.high);
        factor = PreethamNormaliser<double>::of(std::clamp(parameters[1], haze.low, haze.high))(std::sin(theta),
                                                                                                std::cos(theta));
    } else if (fit.normaliser == FitNormaliser::exponent) {
        double exponent = 0.0;
        for (std::size_t i = 0; i < part.log_terms.size(); ++i) {
            exponent += static_cast<double>(part.log_terms[i]) * product(part.log_degrees, i);
        }
        factor = std::exp(exponent);
    }
    std::fill_n(out.begin(), bands * bands, glm::dvec3(0.0));
    const std::size_t functions = fit.functions();
    for (std::size_t r = 0; r < row_count(part); ++r) {
        const double w = factor * product(part.degrees, r);
        const float* row = part.rows.data() + r * functions;
        for (int l = 0; l < bands; ++l) {
            for (int m = 0; m <= l; ++m, row += 3) {
                out[static_cast<std::size_t>(l * (l + 1) + m)] += w * glm::dvec3(row[0], row[1], row[2]);
            }
        }
    }
}

namespace {

// Zeros at a 64-byte border.
SkyFitEvaluator::Floats aligned_floats(std::size_t count) {
    auto* p = static_cast<float*>(::operator new(count * sizeof(float), std::align_val_t(64)));
    std::fill_n(p, count, 0.0F);
    return SkyFitEvaluator::Floats(p);
}

} // namespace

void SkyFitEvaluator::Free::operator()(float* p) const noexcept {
    ::operator delete(p, std::align_val_t(64));
}

SkyFitEvaluator::SkyFitEvaluator(const SkyFit& fit) : fit_(&fit), caches_(fit.parts.size()) {
    for (const SkyFitPart& source : fit.parts) {
        Part part;
        const std::size_t axes = source.axes.size();
        const std::size_t rows = row_count(source);
        const std::size_t degrees = source.degrees[(rows - 1) * axes] + 1U;
        // With two axes, the rows of a degree are made the degrees 0, 1 .. of the other axis, with zeros where the
        // table has none: the weights are the same for every degree then.
        std::vector<std::size_t> place(rows);
        part.first.assign(degrees + 1, 0);
        std::size_t count = 0;
        std::size_t r = 0;
        for (std::size_t i = 0; i < degrees; ++i) {
            part.first[i] = static_cast<std::int32_t>(count);
            std::size_t most = 0;
            for (; r < rows && source.degrees[r * axes] == i; ++r) {
                place[r] = axes == 2 ? count + source.degrees[r * axes + 1] : count + most;
                most = std::max(most, place[r] - count + 1);
            }
            count += most;
        }
        part.first[degrees] = static_cast<std::int32_t>(count);
        assert(count < max_fit_rows);
        for (std::size_t i = 0; axes == 2 && i < degrees; ++i) {
            for (std::int32_t k = part.first[i]; k < part.first[i + 1]; ++k) {
                part.position.push_back(
                    static_cast<std::int16_t>(static_cast<std::int32_t>(i * fit_weights) + k - part.first[i]));
            }
        }
        part.rows = aligned_floats(count * fit_stride);
        for (r = 0; r < rows; ++r) {
            std::copy_n(source.rows.data() + r * fit.functions(), fit.functions(),
                        part.rows.get() + place[r] * fit_stride);
        }
        for (std::size_t a = 0; a < axes; ++a) {
            const double low = mapped(source.axes[a], source.axes[a].low);
            const double high = mapped(source.axes[a], source.axes[a].high);
            part.low[a] = static_cast<float>(a == 0 ? low : source.axes[a].low);
            part.high[a] = static_cast<float>(a == 0 ? high : source.axes[a].high);
            part.scale[a] = static_cast<float>(2.0 / (high - low));
            part.shift[a] = static_cast<float>(-(low + high) / (high - low));
            for (r = 0; r < rows; ++r) {
                part.most[a] = std::max<std::size_t>(part.most[a], source.degrees[r * axes + a]);
            }
            for (std::size_t i = 0; i < source.log_terms.size(); ++i) {
                part.log_most[a] = std::max<std::size_t>(part.log_most[a], source.log_degrees[i * axes + a]);
            }
        }
        parts_.push_back(std::move(part));
    }
    cut_into_cells();
}

void SkyFitEvaluator::cut_into_cells() {
    const std::size_t axes = fit_->parts.front().axes.size();
    std::size_t cells = 1;
    for (std::size_t a = 0; a < axes; ++a) {
        std::vector<float>& cuts = cuts_[a];
        for (const Part& part : parts_) {
            cuts.push_back(part.low[a]);
        }
        std::sort(cuts.begin(), cuts.end());
        cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
        cuts.erase(cuts.begin()); // all is above the lowest
        cells *= cuts.size() + 1;
    }
    cells_.resize(cells);
    for (std::size_t cell = 0; cell < cells; ++cell) {
        // The cell's lowest corner; its part is the one that holds it, or where there is a hole the nearest.
        std::array<float, max_fit_axes> corner{};
        std::size_t rest = cell;
        for (std::size_t a = axes; a-- > 0;) {
            const std::size_t i = rest % (cuts_[a].size() + 1);
            rest /= cuts_[a].size() + 1;
            float lowest = std::numeric_limits<float>::max();
            for (const Part& part : parts_) {
                lowest = std::min(lowest, part.low[a]);
            }
            corner[a] = i == 0 ? lowest : cuts_[a][i - 1];
        }
        float nearest = std::numeric_limits<float>::max();
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            float off = 0.0F;
            for (std::size_t a = 0; a < axes; ++a) {
                // A part's upper border belongs to the next.
                const float over = corner[a] - parts_[p].high[a];
                off += std::max({parts_[p].low[a] - corner[a], over, over >= 0.0F ? 1e-6F : 0.0F});
            }
            if (off < nearest) {
                nearest = off;
                cells_[cell] = static_cast<std::uint16_t>(p);
            }
        }
    }
}

// The part whose box holds the parameters, or the nearest.
std::size_t SkyFitEvaluator::part_for(float half_tangent, std::span<const float> others) const {
    std::size_t cell = 0;
    for (const float cut : cuts_[0]) {
        cell += half_tangent >= cut ? 1 : 0;
    }
    for (std::size_t a = 0; a < others.size() && a + 1 < max_fit_axes; ++a) {
        const std::vector<float>& cuts = cuts_[a + 1];
        std::size_t i = 0;
        for (const float cut : cuts) {
            i += others[a] >= cut ? 1 : 0;
        }
        cell = cell * (cuts.size() + 1) + i;
    }
    return cells_[cell];
}

// The Chebyshev variable in single precision; NaN becomes -1.
float SkyFitEvaluator::fast_variable(const Part& part, const FitAxis& axis, std::size_t a, float x) {
    float y = x >= part.low[a] ? std::min(x, part.high[a]) : part.low[a];
    if (axis.map == FitMap::log_offset) {
        y = std::log(y - static_cast<float>(axis.offset));
    } else if (axis.map == FitMap::half_tangent) {
        y = std::tan(0.5F * y);
    }
    return std::clamp(y * part.scale[a] + part.shift[a], -1.0F, 1.0F);
}

// The Chebyshev values of axis 1 where there are but two axes (rows index them), else a product for each row.
void SkyFitEvaluator::weights(std::size_t index, std::span<const float> others, float* out,
                              Normaliser& normaliser) const {
    const SkyFitPart& part = fit_->parts[index];
    const std::size_t axes = part.axes.size();
    const std::array<std::size_t, max_fit_axes>& most = parts_[index].most;
    if (axes == 2) {
        chebyshev(fast_variable(parts_[index], part.axes[1], 1, others[0]), most[1] + 1, out);
        std::fill(out + most[1] + 1, out + fit_weights, 0.0F);
    } else {
        std::array<std::array<float, max_degree + 2>, max_fit_axes> t;
        for (std::size_t a = 1; a < axes; ++a) {
            chebyshev(fast_variable(parts_[index], part.axes[a], a, others[a - 1]), most[a] + 1, t[a].data());
        }
        for (std::size_t r = 0; r < row_count(part); ++r) {
            float w = 1.0F;
            for (std::size_t a = 1; a < axes; ++a) {
                w *= t[a][part.degrees[r * axes + a]];
            }
            out[r] = w;
        }
    }
    if (fit_->normaliser == FitNormaliser::preetham) {
        const float turbidity = std::clamp(others[0], parts_[index].low[1], parts_[index].high[1]);
        const auto n = PreethamNormaliser<float>::of(turbidity);
        normaliser = {n.zenith_slope, n.zenith_offset, n.chi_slope, n.horizon, n.c, n.d, n.e};
    }
}

// What was divided out, for a sun with the Chebyshev variable x, the sine r and the cosine z of its zenith angle.
float SkyFitEvaluator::factor(std::size_t index, float x, float r, float z, std::span<const float> others,
                              const Normaliser& n) const {
    if (fit_->normaliser == FitNormaliser::preetham) {
        const PreethamNormaliser<float> k{n.zenith_slope, n.zenith_offset, n.chi_slope, n.horizon, n.c, n.d, n.e};
        return z > 0.0F ? k(r, z) : k(1.0F, 0.0F);
    }
    if (fit_->normaliser == FitNormaliser::exponent) {
        const SkyFitPart& part = fit_->parts[index];
        const Part& own = parts_[index];
        const std::size_t axes = part.axes.size();
        std::array<std::array<float, max_degree + 2>, max_fit_axes> t;
        for (std::size_t a = 0; a < axes; ++a) {
            chebyshev(a == 0 ? x : fast_variable(own, part.axes[a], a, others[a - 1]), own.log_most[a] + 1,
                      t[a].data());
        }
        float exponent = 0.0F;
        for (std::size_t i = 0; i < part.log_terms.size(); ++i) {
            float w = part.log_terms[i];
            for (std::size_t a = 0; a < axes; ++a) {
                w *= t[a][part.log_degrees[i * axes + a]];
            }
            exponent += w;
        }
        return std::exp(exponent);
    }
    return 1.0F;
}

struct SkyFitEvaluator::Sun {
    float r, u, cos_a, sin_a; // sine of the zenith angle, tangent of its half, azimuth

    explicit Sun(const glm::vec3& to_sun) {
        const float squared = to_sun.x * to_sun.x + to_sun.y * to_sun.y;
        r = std::sqrt(squared);
        u = r / std::max(1.0F + to_sun.z, 1e-6F); // large at the nadir, never infinite
        const bool has_azimuth = r > 0.0F;
        const float inverse = 1.0F / (has_azimuth ? r : 1.0F);
        cos_a = has_azimuth ? to_sun.x * inverse : 1.0F;
        sin_a = to_sun.y * inverse;
    }
};

void SkyFitEvaluator::fill(std::size_t index, std::span<const float> others, int bands) {
    const Part& part = parts_[index];
    Cache& cache = caches_[index];
    const std::size_t degrees = part.first.size() - 1;
    if (!cache.sums) {
        cache.sums = aligned_floats(degrees * fit_stride);
    }
    alignas(64) std::array<float, max_fit_rows> w;
    Normaliser& normaliser = cache.normaliser;
    weights(index, others, w.data(), normaliser);
    fit_sum_rows({part.rows.get(), part.first.data(), degrees, part.position.empty() ? nullptr : part.position.data()},
                 w.data(), static_cast<std::size_t>(3 * bands * (bands + 1) / 2), cache.sums.get());
    // The factor at Chebyshev nodes of the sun's variable, and from them its series.
    constexpr std::size_t n = factor_terms;
    static const std::array<std::array<float, n>, n> cosines = [] {
        std::array<std::array<float, n>, n> out{};
        for (std::size_t k = 0; k < n; ++k) {
            for (std::size_t i = 0; i < n; ++i) {
                out[k][i] =
                    static_cast<float>(std::cos(pi * double(k) * (double(i) + 0.5) / n) * (k == 0 ? 1.0 : 2.0) / n);
            }
        }
        return out;
    }();
    const auto factor_at = [&](float x) {
        const float u = (x - part.shift[0]) / part.scale[0];
        const float square = u * u;
        return factor(index, x, 2.0F * u / (1.0F + square), (1.0F - square) / (1.0F + square), others, normaliser);
    };
    std::array<float, n> values;
    for (std::size_t i = 0; i < n; ++i) {
        values[i] = factor_at(cosines[1][i] * (0.5F * n));
    }
    for (std::size_t k = 0; k < n; ++k) {
        float sum = 0.0F;
        for (std::size_t i = 0; i < n; ++i) {
            sum += cosines[k][i] * values[i];
        }
        cache.factor[k] = sum;
    }
    // A factor that changes too fast for so few terms is made anew for every sun.
    cache.series = true;
    for (const float x : {-1.0F, -0.99F, -0.8F, -0.3F, 0.2F, 0.7F, 0.97F, 1.0F}) {
        std::array<float, n + 1> t;
        chebyshev(x, n, t.data());
        float sum = 0.0F;
        for (std::size_t k = 0; k < n; ++k) {
            sum += cache.factor[k] * t[k];
        }
        const float want = factor_at(x);
        cache.series = cache.series && std::abs(sum - want) <= 2e-6F * std::abs(want);
    }
    std::copy(others.begin(), others.end(), cache.others.begin());
    cache.bands = bands;
}

void SkyFitEvaluator::evaluate(const glm::vec3& to_sun, std::span<const float> others, int bands,
                               std::span<glm::vec3> out) {
    assert(bands >= 1 && bands <= fit_->bands && out.size() >= static_cast<std::size_t>(bands * bands));
    const Sun sun(to_sun);
    const std::size_t index = part_for(sun.u, others);
    const Part& part = parts_[index];
    const Cache& cache = caches_[index];
    if (bands > cache.bands || !std::equal(others.begin(), others.end(), cache.others.begin())) {
        fill(index, others, bands);
    }
    const float x = std::clamp(sun.u * part.scale[0] + part.shift[0], -1.0F, 1.0F);
    const float k = cache.series ? 1.0F : factor(index, x, sun.r, to_sun.z, others, cache.normaliser);
    fit_from_sums(cache.sums.get(), part.first.size() - 1,
                  {x, k, cache.series ? cache.factor.data() : nullptr, sun.cos_a, sun.sin_a, bands, &out[0].x});
}

void SkyFitEvaluator::evaluate_uncached(const glm::vec3& to_sun, std::span<const float> others, int bands,
                                        std::span<glm::vec3> out) const {
    assert(bands >= 1 && bands <= fit_->bands && out.size() >= static_cast<std::size_t>(bands * bands));
    const Sun sun(to_sun);
    const std::size_t index = part_for(sun.u, others);
    const Part& part = parts_[index];
    alignas(64) std::array<float, max_fit_rows> w;
    Normaliser normaliser;
    weights(index, others, w.data(), normaliser);
    const float x = std::clamp(sun.u * part.scale[0] + part.shift[0], -1.0F, 1.0F);
    const float k = factor(index, x, sun.r, to_sun.z, others, normaliser);
    fit_from_rows({part.rows.get(), part.first.data(), part.first.size() - 1,
                   part.position.empty() ? nullptr : part.position.data()},
                  w.data(), {x, k, nullptr, sun.cos_a, sun.sin_a, bands, &out[0].x});
}

} // namespace alpenglow::sky
