#include "sandbox/app/day_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include <glm/geometric.hpp>

#include <alpenglow/core/constants.hpp>

#include "sandbox/scene/calendar.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr glm::vec3 background(0.07F, 0.08F, 0.10F);
constexpr glm::vec3 ink(0.88F);
constexpr glm::vec3 faint(0.32F);
constexpr glm::vec3 sun_colour(1.0F, 0.80F, 0.25F);
constexpr glm::vec3 sky_colour(0.45F, 0.70F, 1.0F);
constexpr glm::vec3 moon_colour(0.85F, 0.85F, 0.80F);

glm::vec3 behind(float sun_altitude_rad) {
    const float degrees = sun_altitude_rad / static_cast<float>(degree_rad);
    return degrees > -0.833F  ? glm::vec3(0.19F, 0.23F, 0.30F)
           : degrees > -6.0F  ? glm::vec3(0.16F, 0.17F, 0.25F)
           : degrees > -12.0F ? glm::vec3(0.12F, 0.13F, 0.20F)
           : degrees > -18.0F ? glm::vec3(0.09F, 0.10F, 0.15F)
                              : glm::vec3(0.06F, 0.06F, 0.09F);
}

std::string lux_text(const char* name, float lux) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), "%s %.3g lux", name, static_cast<double>(lux));
    return text.data();
}

} // namespace

float DayAxes::x(double part_of_day) const {
    return static_cast<float>(left) +
           static_cast<float>(std::clamp(part_of_day, 0.0, 1.0)) * static_cast<float>(right - left);
}

float DayAxes::y(float lux) const {
    const float log = lux > 0.0F ? std::clamp(std::log10(lux), lowest_log, highest_log) : lowest_log;
    return static_cast<float>(bottom) -
           (log - lowest_log) / (highest_log - lowest_log) * static_cast<float>(bottom - top);
}

Canvas paint_day_chart(const std::vector<DaySample>& day, double utc_j2000_s, int width_px, int height_px) {
    Canvas canvas(width_px, height_px, background, 0.92F);
    const DayAxes axes(width_px, height_px);
    if (day.size() < 2) {
        canvas.text(axes.left, axes.top, "no ephemeris for this date and place", ink);
        return canvas;
    }
    const auto part = [&](double utc) {
        return (utc - day.front().utc_j2000_s) / (day.back().utc_j2000_s - day.front().utc_j2000_s);
    };
    const auto sample_at = [&](double at) {
        const double place = std::clamp(at, 0.0, 1.0) * static_cast<double>(day.size() - 1);
        return day[static_cast<std::size_t>(std::lround(place))];
    };
    for (int x = axes.left; x < axes.right; ++x) {
        const double at = (x + 0.5 - axes.left) / (axes.right - axes.left);
        canvas.fill(x, axes.top, x + 1, axes.bottom, behind(sample_at(at).sun_altitude_rad));
    }
    for (int log = static_cast<int>(DayAxes::lowest_log); log <= static_cast<int>(DayAxes::highest_log); ++log) {
        const auto y = static_cast<int>(axes.y(std::pow(10.0F, static_cast<float>(log))));
        canvas.fill(axes.left, y, axes.right, y + 1, faint, 0.5F);
        const std::string text = "1e" + std::to_string(log);
        canvas.text(axes.left - 4 - Canvas::text_width(text), y - 3, text, ink);
    }
    canvas.text(4, 6, "lux", ink);
    // Hours of UTC.
    const double hour_s = 3600.0;
    for (double utc = std::ceil(day.front().utc_j2000_s / (3.0 * hour_s)) * 3.0 * hour_s; utc <= day.back().utc_j2000_s;
         utc += 3.0 * hour_s) {
        const auto x = static_cast<int>(axes.x(part(utc)));
        canvas.fill(x, axes.top, x + 1, axes.bottom, faint, 0.5F);
        const long hour = std::lround(utc / hour_s) + 12; // J2000 is a noon
        const std::string text = std::to_string((hour % 24 + 24) % 24) + " h";
        canvas.text(x - Canvas::text_width(text) / 2, axes.bottom + 6, text, ink);
    }
    const auto curve = [&](float DaySample::*lux, glm::vec3 colour) {
        const auto at = [&](const DaySample& sample) {
            return glm::vec2(axes.x(part(sample.utc_j2000_s)), axes.y(sample.*lux));
        };
        for (std::size_t i = 0; i + 1 < day.size(); ++i) {
            // What is below the axis is not drawn along it.
            if (std::max(at(day[i]).y, at(day[i + 1]).y) < static_cast<float>(axes.bottom) - 0.5F ||
                std::min(at(day[i]).y, at(day[i + 1]).y) < static_cast<float>(axes.bottom) - 0.5F) {
                canvas.line(at(day[i]), at(day[i + 1]), colour, 2.0F);
            }
        }
    };
    curve(&DaySample::moon_lux, moon_colour);
    curve(&DaySample::sky_lux, sky_colour);
    curve(&DaySample::sun_lux, sun_colour);
    // Now.
    const auto now = static_cast<int>(axes.x(part(utc_j2000_s)));
    canvas.fill(now, axes.top, now + 1, axes.bottom, glm::vec3(0.95F, 0.35F, 0.25F));
    const DaySample here = sample_at(part(utc_j2000_s));
    int x = axes.left;
    for (const auto& [name, lux, colour] :
         {std::tuple{"sun", here.sun_lux, sun_colour}, std::tuple{"sky", here.sky_lux, sky_colour},
          std::tuple{"moon", here.moon_lux, moon_colour}}) {
        const std::string text = lux_text(name, lux);
        canvas.text(x, 7, text, colour);
        x += Canvas::text_width(text) + 18;
    }
    const std::string time = show_time(utc_j2000_s);
    canvas.text(axes.right - Canvas::text_width(time), 7, time, ink);
    return canvas;
}

} // namespace alpenglow::sandbox
