#include "sandbox/app/sky_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sky/horizon_filter.hpp>
#include <alpenglow/sky/sky_state.hpp>

#include "sandbox/render/tone.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr float pi_f = std::numbers::pi_v<float>;
constexpr float least_blur_weight = 1.4F; // docs/sky.md: the least ringing and blur together at 7 bands
constexpr float difference_range = 0.5F;  // at the ends of the scale
constexpr glm::vec3 background(0.07F, 0.08F, 0.10F);
constexpr glm::vec3 ink(0.88F);
constexpr glm::vec3 faint(0.45F);

float luminance(const glm::vec3& rgb) {
    return glm::dot(rgb, glm::vec3(0.2126F, 0.7152F, 0.0722F));
}

using Coefficients = std::array<glm::vec3, SkyLightSh::max_bands * SkyLightSh::max_bands>;

glm::vec3 evaluate(int bands, std::span<const glm::vec3> coefficients, std::span<const float> basis) {
    glm::vec3 sum(0.0F);
    for (std::size_t i = 0; i < static_cast<std::size_t>(bands * bands); ++i) {
        sum += coefficients[i] * basis[i];
    }
    return sum;
}

std::string percent(const char* before, float part) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%s%.1f %%", before, static_cast<double>(100.0F * part));
    return text.data();
}

// Directions evenly over the sphere (Fibonacci).
std::vector<glm::vec3> even_directions() {
    constexpr int count = 4096;
    std::vector<glm::vec3> directions(count);
    for (int i = 0; i < count; ++i) {
        const float z = 1.0F - (2.0F * static_cast<float>(i) + 1.0F) / count;
        const float level = std::sqrt(1.0F - z * z);
        const auto turn = static_cast<float>(std::fmod(static_cast<double>(i) * 0.6180339887498949, 1.0));
        directions[static_cast<std::size_t>(i)] = {level * std::cos(2.0F * pi_f * turn),
                                                   level * std::sin(2.0F * pi_f * turn), z};
    }
    return directions;
}

} // namespace

glm::vec3 chart_direction(glm::vec2 place) {
    const float radius = glm::length(place);
    const float zenith_angle = radius * chart_rim_rad;
    const float scale = radius > 0.0F ? std::sin(zenith_angle) / radius : chart_rim_rad;
    return {-place.x * scale, place.y * scale, std::cos(zenith_angle)};
}

glm::vec2 chart_place(glm::vec3 direction) {
    const float level = std::hypot(direction.x, direction.y);
    if (!(level > 0.0F)) {
        return glm::vec2(0.0F);
    }
    const float radius = std::atan2(level, direction.z) / chart_rim_rad;
    return glm::vec2(-direction.x, direction.y) * (radius / level);
}

glm::vec3 signed_colour(float value) {
    const glm::vec3 middle(0.80F);
    const glm::vec3 end = value < 0.0F ? glm::vec3(0.05F, 0.25F, 0.65F) : glm::vec3(0.70F, 0.07F, 0.08F);
    return glm::mix(middle, end, std::clamp(std::abs(value), 0.0F, 1.0F));
}

ShQuality sh_quality(const SkyState& sky, const SkyTables* tables, int bands, std::span<const glm::vec3> coefficients) {
    const std::vector<glm::vec3> directions = even_directions();
    const std::size_t above = directions.size() / 2; // they come from the zenith down
    std::vector<glm::vec3> dome(above);
    sky::sky_radiance(sky, tables, std::span(directions).first(above), dome);
    double power = 0.0;
    double blur = 0.0;
    double ringing = 0.0;
    std::array<float, SkyLightSh::max_bands * SkyLightSh::max_bands> basis{};
    for (std::size_t i = 0; i < directions.size(); ++i) {
        sh::evaluate_basis(bands, directions[i], basis);
        const double there = static_cast<double>(luminance(evaluate(bands, coefficients, basis)));
        if (i < above) {
            const double here = static_cast<double>(luminance(dome[i]));
            power += here * here;
            blur += (there - here) * (there - here);
        } else {
            ringing += there * there;
        }
    }
    if (!(power > 0.0)) {
        return {};
    }
    return {static_cast<float>(std::sqrt(blur / power)), static_cast<float>(std::sqrt(ringing / power))};
}

Canvas paint_sky_chart(const SkyState& sky, const SkyTables* tables, const SkyLightSh& light, int bands,
                       ChartFilter filter, float exposure, int width_px) {
    constexpr int margin = 10;
    constexpr int header = 16;
    constexpr int footer = 28;
    const int diameter = std::min((width_px - 5 * margin) / 4, 360);
    const int width = 4 * diameter + 5 * margin;
    Canvas canvas(width, header + diameter + footer + margin, background, 0.92F);

    const auto count = static_cast<std::size_t>(bands * bands);
    Coefficients raw{};
    std::copy_n(light.coefficients.begin(), count, raw.begin());
    Coefficients filtered = raw;
    if (filter == ChartFilter::sinc) {
        sky::filter_zonal_sinc(bands, std::span<glm::vec3>(filtered).first(count));
    } else {
        sky::HorizonFilter(bands, static_cast<double>(least_blur_weight))
            .apply(std::span<glm::vec3>(filtered).first(count));
    }

    // The disc's pixels, and the dome's light at those above the horizon.
    struct Pixel {
        int x, y;
    };
    std::vector<Pixel> pixels;
    std::vector<glm::vec3> directions;
    for (int y = 0; y < diameter; ++y) {
        for (int x = 0; x < diameter; ++x) {
            const glm::vec2 place((static_cast<float>(x) + 0.5F) * 2.0F / static_cast<float>(diameter) - 1.0F,
                                  1.0F - (static_cast<float>(y) + 0.5F) * 2.0F / static_cast<float>(diameter));
            if (glm::dot(place, place) <= 1.0F) {
                pixels.push_back({x, y});
                directions.push_back(chart_direction(place));
            }
        }
    }
    std::vector<glm::vec3> dome(directions.size());
    sky::sky_radiance(sky, tables, directions, dome);
    double power = 0.0;
    double weights = 0.0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        if (directions[i].z < 0.0F) {
            dome[i] = glm::vec3(0.0F); // the sky on SH has no lower half
            continue;
        }
        const float zenith_angle = std::acos(std::min(directions[i].z, 1.0F));
        const auto weight = static_cast<double>(zenith_angle > 0.0F ? std::sin(zenith_angle) / zenith_angle : 1.0F);
        power += weight * static_cast<double>(luminance(dome[i]) * luminance(dome[i]));
        weights += weight;
    }
    const auto level = static_cast<float>(std::sqrt(power / std::max(weights, 1e-30)));

    std::array<float, SkyLightSh::max_bands * SkyLightSh::max_bands> basis{};
    const auto left_of = [&](int disc) { return margin + disc * (diameter + margin); };
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        sh::evaluate_basis(bands, directions[i], basis);
        const glm::vec3 smooth = evaluate(bands, filtered, basis);
        const float difference =
            level > 0.0F ? (luminance(smooth) - luminance(dome[i])) / (level * difference_range) : 0.0F;
        const std::array<glm::vec3, 4> colours{
            display(dome[i] * exposure), display(glm::max(evaluate(bands, raw, basis), glm::vec3(0.0F)) * exposure),
            display(glm::max(smooth, glm::vec3(0.0F)) * exposure), signed_colour(difference)};
        for (int disc = 0; disc < 4; ++disc) {
            canvas.set(left_of(disc) + pixels[i].x, header + pixels[i].y, colours[static_cast<std::size_t>(disc)]);
        }
    }

    const ShQuality before = sh_quality(sky, tables, bands, raw);
    const ShQuality after = sh_quality(sky, tables, bands, filtered);
    const std::array<std::string, 4> titles{"dome", "SH, " + std::to_string(bands) + (bands == 1 ? " band" : " bands"),
                                            std::string("SH filtered: ") +
                                                std::string(chart_filter_names[static_cast<std::size_t>(filter)]),
                                            "filtered - dome, of the sky's rms"};
    const std::array<std::string, 4> notes{"N up, E left; ring: horizon",
                                           percent("blur ", before.blur) + percent("  ringing ", before.ringing),
                                           percent("blur ", after.blur) + percent("  ringing ", after.ringing), ""};
    for (int disc = 0; disc < 4; ++disc) {
        const auto which = static_cast<std::size_t>(disc);
        const int left = left_of(disc);
        canvas.text(left, 4, titles[which], ink);
        canvas.text(left, header + diameter + 6, notes[which], ink);
        const float radius = 0.5F * static_cast<float>(diameter);
        const glm::vec2 middle(static_cast<float>(left) + radius, static_cast<float>(header) + radius);
        const float ring = radius * 0.5F * pi_f / chart_rim_rad;
        constexpr int steps = 180;
        for (int i = 0; i < steps; i += 2) { // dashed
            const auto at = [&](int k) {
                const float turn = 2.0F * pi_f * static_cast<float>(k) / steps;
                return middle + ring * glm::vec2(std::sin(turn), std::cos(turn));
            };
            canvas.line(at(i), at(i + 1), faint);
        }
        if (disc < 3 && sky.to_sun.z > -0.3F) { // a cross where the sun stands
            const glm::vec2 place = chart_place(sky.to_sun) * glm::vec2(radius, -radius) + middle;
            canvas.line(place - glm::vec2(4.0F, 0.0F), place + glm::vec2(4.0F, 0.0F), glm::vec3(0.1F));
            canvas.line(place - glm::vec2(0.0F, 4.0F), place + glm::vec2(0.0F, 4.0F), glm::vec3(0.1F));
        }
    }
    // The scale of differences.
    const int left = left_of(3);
    const int top = header + diameter + 4;
    for (int x = 0; x < diameter; ++x) {
        const float value = (static_cast<float>(x) + 0.5F) * 2.0F / static_cast<float>(diameter) - 1.0F;
        canvas.fill(left + x, top, left + x + 1, top + 8, signed_colour(value));
    }
    const std::string low = percent("", -difference_range);
    const std::string high = percent("+", difference_range);
    canvas.text(left, top + 12, low, ink);
    canvas.text(left + (diameter - Canvas::text_width("0")) / 2, top + 12, "0", ink);
    canvas.text(left + diameter - Canvas::text_width(high), top + 12, high, ink);
    return canvas;
}

} // namespace alpenglow::sandbox
