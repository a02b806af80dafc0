#include <alpenglow/ephemeris/time.hpp>

#include <alpenglow/core/quiet.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>

namespace alpenglow::ephemeris {
namespace {

// Days from 2000-01-01 to a proleptic Gregorian date; the year starts in March, as in the course's equation (9).
std::int64_t days_from_civil(std::int64_t year, int month, int day) {
    year -= month <= 2 ? 1 : 0;
    const std::int64_t era = (year >= 0 ? year : year - 399) / 400;
    const std::int64_t year_of_era = year - era * 400;
    const std::int64_t day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
    const std::int64_t day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    return era * 146097 + day_of_era - 730425;
}

bool is_leap(int year) {
    return year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
}

int days_in_month(int year, int month) {
    constexpr std::array<int, 12> days{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    return month == 2 && is_leap(year) ? 29 : days[static_cast<std::size_t>(month - 1)];
}

// append, not +: GCC 12 warns falsely (-Wrestrict) about literal + string.
std::string years_accepted() {
    return std::string("a year from ").append(std::to_string(min_year)).append(" to ").append(std::to_string(max_year));
}

std::string quoted(std::string_view text) {
    return std::string("'").append(text.substr(0, 64)).append("'");
}

Error field_error(std::string_view where, const char* field, const std::string& value, std::string expected) {
    return Error{std::string(field).append(" is ").append(value), std::string(where), std::move(expected)};
}

Result<double> utc_from_calendar(const CalendarTime& t, std::string_view where) {
    if (t.year < min_year || t.year > max_year) {
        return field_error(where, "year", std::to_string(t.year), years_accepted());
    }
    if (t.month < 1 || t.month > 12) {
        return field_error(where, "month", std::to_string(t.month), "1 to 12");
    }
    if (const int last = days_in_month(t.year, t.month); t.day < 1 || t.day > last) {
        return field_error(where, "day", std::to_string(t.day),
                           std::string("1 to ").append(std::to_string(last)).append(" in that month"));
    }
    if (t.hour < 0 || t.hour > 23) {
        return field_error(where, "hour", std::to_string(t.hour), "0 to 23");
    }
    if (t.minute < 0 || t.minute > 59) {
        return field_error(where, "minute", std::to_string(t.minute), "0 to 59");
    }
    if (!is_number(t.second) || t.second < 0.0 || t.second >= 60.0) {
        return field_error(where, "second", std::to_string(t.second),
                           "0 to less than 60; leap seconds are not represented");
    }
    const double day_seconds = 3600.0 * t.hour + 60.0 * t.minute + t.second;
    return static_cast<double>(days_from_civil(t.year, t.month, t.day)) * day_s - 0.5 * day_s + day_seconds;
}

// Reads fields off the front of a text.
class Scanner {
public:
    explicit Scanner(std::string_view text) : rest_(text) {}

    bool accept(char c) {
        if (rest_.empty() || rest_.front() != c) {
            return false;
        }
        rest_.remove_prefix(1);
        return true;
    }
    // Between `least` and `most` digits.
    bool number(std::size_t least, std::size_t most, int& value) {
        std::size_t n = 0;
        while (n < rest_.size() && n < most && rest_[n] >= '0' && rest_[n] <= '9') {
            ++n;
        }
        if (n < least) {
            return false;
        }
        std::from_chars(rest_.data(), rest_.data() + n, value);
        rest_.remove_prefix(n);
        return true;
    }
    // The digits after a decimal point; those past the 17th are dropped.
    bool fraction(double& value) {
        double scale = 0.1;
        std::size_t n = 0;
        for (; n < rest_.size() && rest_[n] >= '0' && rest_[n] <= '9'; ++n) {
            if (n < 17) {
                value += scale * (rest_[n] - '0');
                scale *= 0.1;
            }
        }
        rest_.remove_prefix(n);
        return n > 0;
    }
    [[nodiscard]] bool at_end() const { return rest_.empty(); }

private:
    std::string_view rest_;
};

bool scan(Scanner& in, CalendarTime& t, int& offset_minutes) {
    const bool negative = in.accept('-');
    if (!negative) {
        in.accept('+');
    }
    if (!in.number(4, 9, t.year) || !in.accept('-') || !in.number(2, 2, t.month) || !in.accept('-') ||
        !in.number(2, 2, t.day)) {
        return false;
    }
    t.year = negative ? -t.year : t.year;
    if (in.at_end()) {
        return true;
    }
    if (!in.accept('T') && !in.accept('t') && !in.accept(' ')) {
        return false;
    }
    if (!in.number(2, 2, t.hour) || !in.accept(':') || !in.number(2, 2, t.minute)) {
        return false;
    }
    if (in.accept(':')) {
        int whole = 0;
        if (!in.number(2, 2, whole)) {
            return false;
        }
        double fraction = 0.0;
        if ((in.accept('.') || in.accept(',')) && !in.fraction(fraction)) {
            return false;
        }
        // A fraction of 17 nines rounds to one.
        t.second = whole + std::min(fraction, 1.0 - 1e-9);
    }
    if (in.at_end() || in.accept('Z') || in.accept('z')) {
        return in.at_end();
    }
    const bool west = in.accept('-');
    int hours = 0;
    int minutes = 0;
    if ((!west && !in.accept('+')) || !in.number(2, 2, hours)) {
        return false;
    }
    if (!in.at_end()) {
        in.accept(':');
        if (!in.number(2, 2, minutes)) {
            return false;
        }
    }
    offset_minutes = (west ? -1 : 1) * (60 * hours + minutes);
    return in.at_end() && hours <= 15 && minutes <= 59;
}

// TT - UT1 on 1 January, IERS (EOP 14 C04; 2026 predicted).
constexpr int delta_t_first_year = 2005;
constexpr std::array<double, 22> delta_t_table{64.69, 64.85, 65.15, 65.46, 65.78, 66.07, 66.32, 66.60,
                                               66.91, 67.28, 67.64, 68.10, 68.59, 68.97, 69.22, 69.36,
                                               69.36, 69.29, 69.20, 69.18, 69.14, 69.10};
constexpr double delta_t_last_year = delta_t_first_year + static_cast<double>(delta_t_table.size() - 1);

template <std::size_t N>
double polynomial(double x, const std::array<double, N>& coefficients) {
    double sum = 0.0;
    for (std::size_t i = N; i-- > 0;) {
        sum = sum * x + coefficients[i];
    }
    return sum;
}

} // namespace

bool in_range(double utc_j2000_s) noexcept {
    return is_number(utc_j2000_s) && utc_j2000_s >= min_utc_j2000_s && utc_j2000_s < max_utc_j2000_s;
}

Result<double> utc_from_calendar(const CalendarTime& time) {
    return utc_from_calendar(time, "calendar");
}

CalendarTime calendar_from_utc(double utc_j2000_s) {
    assert(in_range(utc_j2000_s));
    const double since_midnight = utc_j2000_s + 0.5 * day_s;
    const double day_floor = std::floor(since_midnight / day_s);
    double seconds = std::clamp(since_midnight - day_floor * day_s, 0.0, std::nextafter(day_s, 0.0));
    // The civil date of a day number, by 400-year eras that start in March.
    const std::int64_t days = static_cast<std::int64_t>(day_floor) + 730425;
    const std::int64_t era = (days >= 0 ? days : days - 146096) / 146097;
    const std::int64_t doe = days - era * 146097;
    const std::int64_t yoe = (doe - doe / 1460 + doe / 36524 - doe / 146096) / 365;
    const std::int64_t doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
    const std::int64_t mp = (5 * doy + 2) / 153;
    CalendarTime t;
    t.day = static_cast<int>(doy - (153 * mp + 2) / 5 + 1);
    t.month = static_cast<int>(mp < 10 ? mp + 3 : mp - 9);
    t.year = static_cast<int>(yoe + era * 400 + (t.month <= 2 ? 1 : 0));
    t.hour = static_cast<int>(seconds / 3600.0);
    seconds -= 3600.0 * t.hour;
    t.minute = static_cast<int>(seconds / 60.0);
    t.second = seconds - 60.0 * t.minute;
    return t;
}

Result<double> parse_time(std::string_view text, std::string_view where) {
    CalendarTime t;
    int offset_minutes = 0;
    Scanner in(text);
    if (!scan(in, t, offset_minutes)) {
        return Error{quoted(text).append(" is no date"), std::string(where),
                     "ISO 8601, such as 2026-06-21T05:30:00Z, 2026-06-21 05:30 or 2026-06-21T07:30+02:00"};
    }
    Result<double> local = utc_from_calendar(t, where);
    if (!local) {
        return local;
    }
    const double utc = *local - 60.0 * offset_minutes;
    if (!in_range(utc)) {
        return Error{quoted(text).append(" is out of range after its offset"), std::string(where),
                     years_accepted().append(" in UTC")};
    }
    return utc;
}

std::string format_time(double utc_j2000_s, int decimals) {
    assert(in_range(utc_j2000_s) && decimals >= 0 && decimals <= 6);
    // Round first, so that 59.9999 s carries into the minute; stay inside the range at its end.
    const double scale = std::pow(10.0, decimals);
    const double whole = std::floor(utc_j2000_s);
    double rounded = whole + std::round((utc_j2000_s - whole) * scale) / scale;
    if (!in_range(rounded)) {
        rounded = std::nextafter(max_utc_j2000_s, 0.0);
    }
    const CalendarTime t = calendar_from_utc(rounded);
    // The second's fraction cannot round up again beyond what double cannot resolve: cap it.
    const double second = std::min(std::round(t.second * scale) / scale, 60.0 - 1.0 / scale);
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%s%04d-%02d-%02dT%02d:%02d:%0*.*fZ", t.year < 0 ? "-" : "",
                  std::abs(t.year), t.month, t.day, t.hour, t.minute, decimals == 0 ? 2 : 3 + decimals, decimals,
                  second);
    return text.data();
}

double delta_t_s(double utc_j2000_s) noexcept {
    const double year = 2000.0 + (utc_j2000_s + 0.5 * day_s) / (365.2425 * day_s);
    if (year < -500.0 || year >= 2150.0) {
        const double u = (year - 1820.0) / 100.0;
        return -20.0 + 32.0 * u * u;
    }
    if (year < 500.0) {
        return polynomial<7>(year / 100.0,
                             {10583.6, -1014.41, 33.78311, -5.952053, -0.1798452, 0.022174192, 0.0090316521});
    }
    if (year < 1600.0) {
        return polynomial<7>((year - 1000.0) / 100.0,
                             {1574.2, -556.01, 71.23472, 0.319781, -0.8503463, -0.005050998, 0.0083572073});
    }
    if (year < 1700.0) {
        return polynomial<4>(year - 1600.0, {120.0, -0.9808, -0.01532, 1.0 / 7129.0});
    }
    if (year < 1800.0) {
        return polynomial<5>(year - 1700.0, {8.83, 0.1603, -0.0059285, 0.00013336, -1.0 / 1174000.0});
    }
    if (year < 1860.0) {
        return polynomial<8>(year - 1800.0, {13.72, -0.332447, 0.0068612, 0.0041116, -0.00037436, 0.0000121272,
                                             -0.0000001699, 0.000000000875});
    }
    if (year < 1900.0) {
        return polynomial<6>(year - 1860.0, {7.62, 0.5737, -0.251754, 0.01680668, -0.0004473624, 1.0 / 233174.0});
    }
    if (year < 1920.0) {
        return polynomial<5>(year - 1900.0, {-2.79, 1.494119, -0.0598939, 0.0061966, -0.000197});
    }
    if (year < 1941.0) {
        return polynomial<4>(year - 1920.0, {21.20, 0.84493, -0.076100, 0.0020936});
    }
    if (year < 1961.0) {
        return polynomial<4>(year - 1950.0, {29.07, 0.407, -1.0 / 233.0, 1.0 / 2547.0});
    }
    if (year < 1986.0) {
        return polynomial<4>(year - 1975.0, {45.45, 1.067, -1.0 / 260.0, -1.0 / 718.0});
    }
    if (year < 2005.0) {
        return polynomial<6>(year - 2000.0, {63.86, 0.3345, -0.060374, 0.0017275, 0.000651814, 0.00002373599});
    }
    if (year < delta_t_last_year) {
        const double x = year - delta_t_first_year;
        const auto i = static_cast<std::size_t>(x);
        const double f = x - static_cast<double>(i);
        return delta_t_table[i] + f * (delta_t_table[i + 1] - delta_t_table[i]);
    }
    const double in_2150 = -20.0 + 32.0 * 3.3 * 3.3;
    const double s = (year - delta_t_last_year) / (2150.0 - delta_t_last_year);
    return delta_t_table.back() + (in_2150 - delta_t_table.back()) * s * s;
}

} // namespace alpenglow::ephemeris
