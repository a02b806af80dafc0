// Dates as people write them. In a build without the module ephemeris there are none (calendar_none.cpp): every date is
// taken, means second 0, and is shown as such.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <alpenglow/core/result.hpp>

namespace alpenglow::sandbox {

struct Date {
    int year = 2000, month = 1, day = 1;
    double seconds = 0.0; // since midnight, UTC
};

// Seconds since J2000 UTC of an ISO 8601 date. `where` names the source in the error.
[[nodiscard]] Result<double> read_time(std::string_view text, std::string_view where);
[[nodiscard]] std::string show_time(double utc_j2000_s);
[[nodiscard]] Date date_of(double utc_j2000_s);
[[nodiscard]] std::optional<double> utc_of(const Date& date); // empty where no such date exists

} // namespace alpenglow::sandbox
