// Calendar, Julian date and time scales.
//
// An instant is `utc_j2000_s`: seconds since 2000-01-01T12:00:00 UTC with every day 86400 s long (leap seconds are not
// represented). Dates are proleptic Gregorian with astronomical years (year 0 is 1 BC): the ten days that
// 1582-10-05 .. 1582-10-14 lacks in history exist here, and a date from a source that used the Julian calendar must be
// converted first. UT1 is taken equal to UTC (they differ by less than 0.9 s after 1972: 13.5 arcseconds of the Earth's
// rotation), and TT = UTC + delta T.
#pragma once

#include <string>
#include <string_view>

#include <alpenglow/core/result.hpp>

namespace alpenglow::ephemeris {

// Years for which delta T is known or modelled (Espenak & Meeus 2006), and so the years that the API accepts.
inline constexpr int min_year = -1999;
inline constexpr int max_year = 3000;
inline constexpr double min_utc_j2000_s = -126196228800.0; // -1999-01-01T00:00:00
inline constexpr double max_utc_j2000_s = 31588488000.0;   // 3001-01-01T00:00:00, not included

inline constexpr double j2000_jd = 2451545.0;
inline constexpr double day_s = 86400.0;
inline constexpr double century_s = 36525.0 * day_s;

struct CalendarTime {
    int year = 2000;     // astronomical
    int month = 1;       // 1 .. 12
    int day = 1;         // 1 .. 28, 29, 30 or 31
    int hour = 0;        // 0 .. 23
    int minute = 0;      // 0 .. 59
    double second = 0.0; // [0, 60)
};

// True when min_utc_j2000_s <= utc_j2000_s < max_utc_j2000_s (false for NaN).
[[nodiscard]] bool in_range(double utc_j2000_s) noexcept;

// Seconds since J2000 UTC. Error: the field that is out of range.
[[nodiscard]] Result<double> utc_from_calendar(const CalendarTime& time);

// The inverse, to about 1e-5 s (double's resolution at the far end). Precondition: in_range(utc_j2000_s).
[[nodiscard]] CalendarTime calendar_from_utc(double utc_j2000_s);

// ISO 8601: YYYY-MM-DD, optionally followed by T or a space and hh:mm[:ss[.fff]], then Z, +hh:mm, +hh or nothing (UTC).
// Years may carry a sign and more than four digits. `where` names the source in the error.
[[nodiscard]] Result<double> parse_time(std::string_view text, std::string_view where = "time");

// "2026-06-21T05:30:00Z", rounded to `decimals` (0 .. 6) places of the second. Precondition: in_range(utc_j2000_s).
[[nodiscard]] std::string format_time(double utc_j2000_s, int decimals = 0);

[[nodiscard]] inline double julian_date(double utc_j2000_s) noexcept {
    return j2000_jd + utc_j2000_s / day_s;
}
[[nodiscard]] inline double utc_from_julian_date(double jd) noexcept {
    return (jd - j2000_jd) * day_s;
}
[[nodiscard]] inline double julian_centuries(double j2000_s) noexcept {
    return j2000_s / century_s;
}

// Delta T = TT - UT in seconds: Espenak & Meeus, Five Millennium Canon of Solar Eclipses (NASA/TP-2006-214141),
// polynomial expressions, except after 2005, where their forecast ran away (75.1 s for 2026 against 69.1 s measured):
// IERS yearly values to 2026, then the parabola that leaves the last of them level and meets theirs in 2150.
// Within 1 s of 32.184 s + TAI-UTC over 1972 to 2026; uncertain by minutes before 0 and after 2200.
[[nodiscard]] double delta_t_s(double utc_j2000_s) noexcept;

} // namespace alpenglow::ephemeris
